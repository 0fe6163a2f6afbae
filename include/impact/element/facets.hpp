#pragma once
#include <impact/element/second_order_products.hpp>

/// Facets of cells, as cells of one dimension less (cells.hpp): edges here, faces are Tri3, Quad4, Tri6,
/// Quad8 and Quad9. Of second order the corners come first, then the middles of the edges, then that of the
/// facet. The rules integrate products of two shape functions of an affine facet exactly.
namespace impact {

/// Edge of two nodes, from -1 to 1.
struct Line2 : LineProduct<Line2, 1> {
  static constexpr double sign[nodes][dim] = {{-1}, {1}};
};

/// Edge of three nodes: its ends, then its middle. Three Gauss points.
struct Line3 {
  using Corners = Line2;
  static constexpr CellEdge edges[] = {{0, 1}};
  using Point = Line2::Point;
  static constexpr int dim = 1, nodes = 3, points = 3;
  static constexpr Point centroid() { return {}; }
  static constexpr Point point(int q) { return {(q - 1) * 0.77459666924148337704}; }
  static constexpr double weight(int q) { return q == 1 ? 8.0 / 9 : 5.0 / 9; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    const double xi = x[0];
    return {xi * (xi - 1) / 2, xi * (xi + 1) / 2, 1 - xi * xi};
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    const double xi = x[0];
    return {Point{xi - 0.5}, Point{xi + 0.5}, Point{-2 * xi}};
  }
};

/// Second derivatives of the shape functions of a facet of second order at a place, [node][i][j]: central
/// differences of first ones, which are at most quadratic along each direction.
template <class Facet>
constexpr std::array<std::array<typename Facet::Point, Facet::dim>, Facet::nodes>
second_derivatives(const typename Facet::Point& x) {
  std::array<std::array<typename Facet::Point, Facet::dim>, Facet::nodes> d2N{};
  for (unsigned j = 0; j < Facet::dim; ++j) {
    typename Facet::Point up = x, down = x;
    up[j] += 1;
    down[j] -= 1;
    const auto above = Facet::dN(up), below = Facet::dN(down);
    for (unsigned a = 0; a < Facet::nodes; ++a)
      for (unsigned i = 0; i < Facet::dim; ++i) d2N[a][i][j] = (above[a][i] - below[a][i]) / 2;
  }
  return d2N;
}

/// A place of a facet: its shape functions and their slopes there.
template <class Facet> struct FacetPlace {
  std::array<double, Facet::nodes> N{};
  std::array<typename Facet::Point, Facet::nodes> dN{};

  static constexpr FacetPlace at(const typename Facet::Point& xi) { return {Facet::N(xi), Facet::dN(xi)}; }
};

} // namespace impact
