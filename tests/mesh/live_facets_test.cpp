#include "box_mesh.hpp"
#include <gtest/gtest.h>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

using Place = std::array<double, 3>;

std::array<double, 3> mean_of(const Mesh& mesh, const int* node, int nodes) {
  Place mean{};
  for (int a = 0; a < nodes; ++a)
    for (int i = 0; i < mesh.dim(); ++i)
      mean[std::size_t(i)] += mesh.coordinates()[std::size_t(node[a] * mesh.dim() + i)] / nodes;
  return mean;
}

// The cells whose middle a body's part holds.
template <class Inside> std::vector<char> cells_in(const Mesh& mesh, Inside&& inside) {
  std::vector<char> gone(std::size_t(mesh.cell_count()), 0);
  for (const CellTable& table : mesh.cells())
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      const int nodes = table.shape->nodes;
      const Place x = mean_of(mesh, &table.connectivity[c * std::size_t(nodes)], nodes);
      if (inside(x)) gone[std::size_t(table.point[c] - mesh.cell_start())] = 1;
    }
  return gone;
}

// Whether the facet points from `from` on, by its nodes as the table promises them.
double outwards(const Mesh& mesh, const FacetTable& facets, int f, const Place& from) {
  const int n = facets.nodes_per_facet;
  const int* node = &facets.connectivity[std::size_t(f * n)];
  const auto x = [&](int a, int i) { return mesh.coordinates()[std::size_t(node[a] * mesh.dim() + i)]; };
  const Place middle = mean_of(mesh, node, n);
  if (mesh.dim() == 2)
    return (x(1, 1) - x(0, 1)) * (middle[0] - from[0]) + (x(0, 0) - x(1, 0)) * (middle[1] - from[1]);
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum += ((x(1, j) - x(0, j)) * (x(2, k) - x(0, k)) - (x(1, k) - x(0, k)) * (x(2, j) - x(0, j))) *
           (middle[std::size_t(i)] - from[std::size_t(i)]);
  }
  return sum;
}

struct Case {
  Shape shape;
  int boundary, around; // facets of the box with 3 cells along an edge, and around the cells in its middle
};

TEST(LiveFacets, FacesAroundAHoleComeFreeAndLookIntoIt) {
  for (const Case& c : {Case{Shape::quad4, 12, 4}, Case{Shape::tri3, 12, 4}, Case{Shape::hex8, 54, 6},
                        Case{Shape::tet4, 108, 12}}) {
    const Mesh mesh = run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("live_facets"),
                                        run_test::box_mesh(c.shape, 3));
    const std::vector<char> body = nodes_of_bodies(mesh, mesh.nodes("boundary"));
    const auto in_middle = [&](const Place& x) {
      return std::all_of(x.begin(), x.begin() + mesh.dim(),
                         [](double y) { return y > 1. / 3 && y < 2. / 3; });
    };
    const FacetTable facets = mesh.live_facets("boundary", cells_in(mesh, in_middle), body);
    int count[2] = {0, 0};
    const Place centre = {0.5, 0.5, mesh.dim() == 3 ? 0.5 : 0};
    for (int f = 0; f < facets.count(); ++f) {
      const Place x = mean_of(mesh, &facets.connectivity[std::size_t(f * facets.nodes_per_facet)],
                              facets.nodes_per_facet);
      const bool inside = std::all_of(x.begin(), x.begin() + mesh.dim(),
                                      [](double y) { return y > 1. / 3 - 1e-9 && y < 2. / 3 + 1e-9; });
      ++count[inside ? 1 : 0];
      EXPECT_EQ(outwards(mesh, facets, f, centre) > 0, !inside);
    }
    EXPECT_EQ(sum_over_ranks(mesh.comm(), count[0]), c.boundary);
    EXPECT_EQ(sum_over_ranks(mesh.comm(), count[1]), c.around);
  }
}

TEST(LiveFacets, FacetsOfCellsThatAreGoneLeaveAndOtherBodiesStay) {
  const Mesh mesh = run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("live_facets"),
                                      run_test::box_mesh(Shape::quad4, 3));
  const std::vector<char> gone = cells_in(mesh, [](const Place& x) { return x[0] < 1. / 3; });
  const std::vector<char> body = nodes_of_bodies(mesh, mesh.nodes("boundary")), none(body.size(), 0);
  const auto count = [&](const std::vector<char>& of) {
    return sum_over_ranks(mesh.comm(), mesh.live_facets("boundary", gone, of).count());
  };
  EXPECT_EQ(count(body), 12 - 5 + 3);
  EXPECT_EQ(count(none), 12 - 5);
}

} // namespace

} // namespace impact
