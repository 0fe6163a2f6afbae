#include "search_bench.hpp"
#include "cpu_clock.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/contact/search.hpp>

namespace impact {

namespace {

// Quadrilaterals of side 1 on a wavy sheet, `m` along an edge; shifted, so that the sheets do not match.
std::vector<SearchFacet> sheet(int m, double shift, PetscInt first_node) {
  std::vector<SearchFacet> facets;
  facets.reserve(static_cast<std::size_t>(m) * static_cast<std::size_t>(m));
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < m; ++i) {
      const PetscInt a = first_node + j * (m + 1) + i;
      SearchFacet facet{{a, a + 1, a + m + 2, a + m + 1}, {-1, -1}, {}};
      for (std::size_t c = 0; c < 4; ++c) {
        const double x = shift + i + (c == 1 || c == 2), y = shift + j + (c > 1);
        const double z = 0.1 * shift + 20 * std::sin(0.01 * x) * std::cos(0.013 * y);
        std::copy_n(std::array<double, 3>{x, y, z}.begin(), 3,
                    facet.x.begin() + static_cast<std::ptrdiff_t>(3 * c));
      }
      facets.push_back(facet);
    }
  return facets;
}

double ns_per_facet(int m, double reach, int repetitions, double& pairs) {
  const std::vector<SearchFacet> primary = sheet(m, 0.4, (m + 1) * (m + 1));
  SearchSecondary secondary;
  for (const SearchFacet& facet : sheet(m, 0, 0)) {
    secondary.node.insert(secondary.node.end(), facet.node.begin(), facet.node.begin() + 4);
    secondary.x.insert(secondary.x.end(), facet.x.begin(), facet.x.end());
  }
  const double facets = 2.0 * m * m;
  double least = 1e300;
  for (int i = 0; i < repetitions; ++i) {
    const double start = cpu_seconds();
    const Candidates found = find_candidates(PETSC_COMM_SELF, secondary, primary, reach);
    least = std::min(least, cpu_seconds() - start);
    pairs = static_cast<double>(found.facet.size()) / (m * m);
  }
  return 1e9 * least / facets;
}

} // namespace

void bench_search(int repetitions) {
  // The nearest facets, and what the program asks for by default: twice the facet and a skin.
  for (const double reach : {0.2, 3.0}) {
    double smallest = 0;
    for (const int m : {100, 316, 1000}) {
      double pairs = 0;
      const double ns = ns_per_facet(m, reach, repetitions, pairs);
      if (m == 100) smallest = ns;
      std::printf(
          "search, reach %g facets: %.1f cpu-ns/facet, %.2f of the first, %.1f pairs per secondary facet, "
          "2 x %d facets\n",
          reach, ns, ns / smallest, pairs, m * m);
      std::fflush(stdout);
    }
  }
}

} // namespace impact
