#pragma once
#include <impact/element/second_order.hpp>

/// Quadrilaterals and hexahedra of second order: nodes at the corners of the linear cell, then in the middle
/// of its edges, of its quadrilateral faces and, of hexahedra, of the cell. The rule is the 3-point Gauss
/// product. Of serendipity cells the edges have the last nodes.
namespace impact {

/// The 3-point Gauss product.
template <class Linear> struct ThreePointProduct {
  static constexpr int dim = Linear::dim, points = dim == 2 ? 9 : 27;
  using Corners = Linear;
  using Point = typename Linear::Point;
  static constexpr auto& facets = Linear::facets;
  static constexpr Point centroid() { return {}; }
  static constexpr Point point(int q) {
    Point x{};
    for (double& component : x) {
      component = (q % 3 - 1) * 0.77459666924148337704;
      q /= 3;
    }
    return x;
  }
  static constexpr double weight(int q) {
    double w = 1;
    for (int k = 0; k < dim; ++k) {
      w *= q % 3 == 1 ? 8.0 / 9 : 5.0 / 9;
      q /= 3;
    }
    return w;
  }
};

/// Products of the quadratic functions of a line.
template <class Cell, class Linear> struct QuadraticProduct : ThreePointProduct<Linear> {
  static constexpr int dim = Linear::dim, nodes = dim == 2 ? 9 : 27;
  using Point = typename Linear::Point;

  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{};
    for (std::size_t a = 0; a < nodes; ++a) {
      n[a] = 1;
      for (std::size_t k = 0; k < dim; ++k) n[a] *= value(node_places<Cell>[a][k], x[k]);
    }
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    std::array<Point, nodes> g{};
    for (std::size_t a = 0; a < nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i) {
        g[a][i] = 1;
        for (std::size_t k = 0; k < dim; ++k) {
          const double place = node_places<Cell>[a][k];
          g[a][i] *= k == i ? slope(place, x[k]) : value(place, x[k]);
        }
      }
    return g;
  }

private:
  // Of the node at -1, 0 or 1.
  static constexpr double value(double place, double x) {
    return place == 0 ? 1 - x * x : x * (x + place) / 2;
  }
  static constexpr double slope(double place, double x) { return place == 0 ? -2 * x : x + place / 2; }
};

/// Serendipity functions: of the middle of an edge along direction i (1 - x_i^2) prod_k (1 + s_k x_k)/2, of a
/// corner its linear function without half of those of the edges that meet there.
template <class Cell, class Linear> struct Serendipity : ThreePointProduct<Linear> {
  static constexpr int dim = Linear::dim, nodes = dim == 2 ? 8 : 20;
  using Point = typename Linear::Point;

  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{};
    const auto linear = Linear::N(x);
    for (std::size_t a = 0; a < Linear::nodes; ++a) n[a] = linear[a];
    for (std::size_t a = Linear::nodes; a < nodes; ++a) {
      n[a] = 1;
      for (std::size_t k = 0; k < dim; ++k) n[a] *= value(node_places<Cell>[a][k], x[k]);
      for (const int corner : Cell::edges[a - Linear::nodes]) n[static_cast<std::size_t>(corner)] -= n[a] / 2;
    }
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    std::array<Point, nodes> g{};
    const auto linear = Linear::dN(x);
    for (std::size_t a = 0; a < Linear::nodes; ++a) g[a] = linear[a];
    for (std::size_t a = Linear::nodes; a < nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i) {
        g[a][i] = 1;
        for (std::size_t k = 0; k < dim; ++k) {
          const double place = node_places<Cell>[a][k];
          g[a][i] *= k == i ? slope(place, x[k]) : value(place, x[k]);
        }
        for (const int corner : Cell::edges[a - Linear::nodes])
          g[static_cast<std::size_t>(corner)][i] -= g[a][i] / 2;
      }
    return g;
  }

private:
  static constexpr double value(double place, double x) {
    return place == 0 ? 1 - x * x : (1 + place * x) / 2;
  }
  static constexpr double slope(double place, double x) { return place == 0 ? -2 * x : place / 2; }
};

/// The edges of a quadrilateral and of a hexahedron in VTK order.
inline constexpr CellEdge quadrilateral_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
inline constexpr CellEdge hexahedron_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

/// 9-node quadrilateral.
struct Quad9 : QuadraticProduct<Quad9, Quad4> {
  static constexpr CellNames names = {"biquadratic quadrilaterals", "quadrilateral", 10, 35,
                                      "Quadrilateral_9"};
  static constexpr auto& edges = quadrilateral_edges;
  static constexpr CellFacet faces[] = {{0, 1, 2, 3}};
  static constexpr int from_plex[nodes] = {5, 6, 7, 8, 1, 2, 3, 4, 0};
  static constexpr int from_gmsh[nodes] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
};

/// 8-node quadrilateral, without the node in its middle.
struct Quad8 : Serendipity<Quad8, Quad4> {
  static constexpr CellNames names = {"serendipity quadrilaterals", "quadrilateral", 16, 37,
                                      "Quadrilateral_8"};
  static constexpr auto& edges = quadrilateral_edges;
  static constexpr int from_plex[nodes] = {4, 5, 6, 7, 0, 1, 2, 3};
  static constexpr int from_gmsh[nodes] = {0, 1, 2, 3, 4, 5, 6, 7};
};

/// 27-node hexahedron in VTK order.
struct Hex27 : QuadraticProduct<Hex27, Hex8> {
  static constexpr CellNames names = {"triquadratic hexahedra", "hexahedron", 12, 50, "Hexahedron_27"};
  static constexpr auto& edges = hexahedron_edges;
  static constexpr CellFacet faces[] = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                        {2, 3, 7, 6}, {0, 3, 2, 1}, {4, 5, 6, 7}};
  static constexpr bool middle = true; ///< one more node, in the middle of the cell
  static constexpr int from_plex[nodes] = {19, 22, 21, 20, 23, 24, 25, 26, 10, 9, 8, 7, 11, 12,
                                           13, 14, 16, 15, 18, 17, 6,  5,  3,  4, 1, 2, 0};
  static constexpr int from_gmsh[nodes] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                           19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26};
};

/// 20-node hexahedron in VTK order.
struct Hex20 : Serendipity<Hex20, Hex8> {
  static constexpr CellNames names = {"serendipity hexahedra", "hexahedron", 17, 48, "Hexahedron_20"};
  static constexpr auto& edges = hexahedron_edges;
  static constexpr int from_plex[nodes] = {12, 15, 14, 13, 16, 17, 18, 19, 3,  2,
                                           1,  0,  4,  5,  6,  7,  9,  8,  11, 10};
  static constexpr int from_gmsh[nodes] = {0,  1, 2,  3,  4,  5,  6,  7,  8,  11,
                                           13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
};

} // namespace impact
