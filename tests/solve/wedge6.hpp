#pragma once
#include <impact/kernel/shape_of.hpp>

/// A cell of one's own, the sample of src/README.md: the 6-node wedge, a triangle (0,0) (1,0) (0,1) swept
/// along
/// [-1,1], with three points in the triangle times two along the third direction.
struct Wedge6 {
  static constexpr impact::CellNames names = {"wedges", "tensor_triangular_prism", 6, 8, "Wedge"};
  static constexpr int dim = 3, nodes = 6, points = 6;
  static constexpr impact::CellFacet facets[] = {
      {0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static constexpr int from_plex[nodes] = {0, 1, 2, 3, 4, 5};
  using Point = std::array<double, dim>;
  static constexpr Point centroid() { return {1.0 / 3, 1.0 / 3, 0}; }
  static constexpr Point point(int q) {
    const auto in_triangle = impact::Tri3::point(q % 3);
    return {in_triangle[0], in_triangle[1], q < 3 ? -impact::Quad4::gauss : impact::Quad4::gauss};
  }
  static constexpr double weight(int) { return 1.0 / 6; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    const auto n = impact::Tri3::N({x[0], x[1]});
    const double low = (1 - x[2]) / 2, high = (1 + x[2]) / 2;
    return {n[0] * low, n[1] * low, n[2] * low, n[0] * high, n[1] * high, n[2] * high};
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    const auto n = impact::Tri3::N({x[0], x[1]});
    const auto g = impact::Tri3::dN({x[0], x[1]});
    std::array<Point, nodes> slope{};
    for (unsigned a = 0; a < nodes; ++a) {
      const double along = a < 3 ? (1 - x[2]) / 2 : (1 + x[2]) / 2;
      slope[a] = {g[a % 3][0] * along, g[a % 3][1] * along, (a < 3 ? -0.5 : 0.5) * n[a % 3]};
    }
    return slope;
  }
};

inline const impact::CellShape wedge6 = impact::cell_shape<Wedge6>();
