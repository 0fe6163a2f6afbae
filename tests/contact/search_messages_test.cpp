#include <gtest/gtest.h>
#include <impact/contact/search.hpp>

/// What a search sends, counted by PETSc: it must not grow with the number of ranks.
using namespace impact;

namespace {

// A strip of 40 unit squares at the height z, beginning at x.
std::vector<SearchFacet> strip(double x, double z, PetscInt first_node) {
  std::vector<SearchFacet> facets;
  for (int i = 0; i < 40; ++i) {
    const PetscInt a = first_node + 2 * i;
    SearchFacet facet{{a, a + 2, a + 3, a + 1}, {-1, -1}, {}};
    for (std::size_t c = 0; c < 4; ++c) {
      facet.x[3 * c] = x + i + (c == 1 || c == 2);
      facet.x[3 * c + 1] = c > 1;
      facet.x[3 * c + 2] = z;
    }
    facets.push_back(facet);
  }
  return facets;
}

struct Counts {
  double sends = petsc_isend_ct + petsc_send_ct, receives = petsc_irecv_ct + petsc_recv_ct,
         bytes = petsc_isend_len + petsc_send_len, reductions = petsc_allreduce_ct, gathers = petsc_gather_ct;
};

} // namespace

TEST(ContactMessages, ASearchSendsToTheRanksThatItReachesAndGathersBoxesOnce) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  // Each rank has 40 squares of both strips; only those at its ends are near the strips of other ranks.
  const std::vector<SearchFacet> primary = strip(40.0 * rank + 0.4, 0.1, 100000 + 80 * rank);
  SearchSecondary secondary;
  for (const SearchFacet& facet : strip(40.0 * rank, 0, 80 * rank)) {
    secondary.node.insert(secondary.node.end(), facet.node.begin(), facet.node.begin() + 4);
    secondary.x.insert(secondary.x.end(), facet.x.begin(), facet.x.end());
  }
  const Counts before;
  const Candidates found = find_candidates(PETSC_COMM_WORLD, secondary, primary, 0.5);
  const Counts after;
  const int neighbours = (rank > 0 ? 1 : 0) + (rank + 1 < ranks ? 1 : 0);
  EXPECT_EQ(after.sends - before.sends, neighbours);
  EXPECT_EQ(after.receives - before.receives, neighbours);
  EXPECT_EQ(after.gathers - before.gathers, ranks > 1 ? 1 : 0); // PETSc counts none on one rank
  EXPECT_EQ(after.reductions - before.reductions, 0);
  // One or two facets at either end travel, not the surface.
  EXPECT_LE(after.bytes - before.bytes, 2.0 * neighbours * sizeof(SearchFacet));
  EXPECT_GT(found.facet.size(), 80U);
}
