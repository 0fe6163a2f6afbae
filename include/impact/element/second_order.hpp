#pragma once
#include <impact/element/cells.hpp>
#include <iterator>

/// Triangles and tetrahedra of second order: nodes at the corners of the linear cell, then in the middle of
/// its edges. Where the edges are straight and the nodes in their middle the map of the cell is that of the
/// linear one. The rules have positive weights, all points inside, and integrate polynomials of degree 4
/// (Tri6) and 5 (Tet10) exactly, so products of two shape functions.
namespace impact {

/// Reference place of a node: of the corners of products of lines their ends, of simplices 1 along an axis;
/// then the middles of edges, of faces and of the cell, each halfway between two corners.
template <class Cell> constexpr typename Cell::Point place_of_node(std::size_t a) {
  typename Cell::Point x{};
  if constexpr (is_second_order<Cell>) {
    using Corners = typename Cell::Corners;
    std::array<std::size_t, 2> ends = {a, a};
    constexpr std::size_t edges = std::size(Cell::edges);
    if (a >= Corners::nodes + edges) {
      ends = {0, Corners::nodes - 2}; // of a hexahedron the diagonal of the cell
      if constexpr (has_faces<Cell>)
        if (const std::size_t face = a - Corners::nodes - edges; face < std::size(Cell::faces))
          ends = {static_cast<std::size_t>(Cell::faces[face][0]),
                  static_cast<std::size_t>(Cell::faces[face][2])};
    } else if (a >= Corners::nodes) {
      const CellEdge& edge = Cell::edges[a - Corners::nodes];
      ends = {static_cast<std::size_t>(edge[0]), static_cast<std::size_t>(edge[1])};
    }
    const auto from = place_of_node<Corners>(ends[0]), to = place_of_node<Corners>(ends[1]);
    for (std::size_t k = 0; k < Cell::dim; ++k) x[k] = (from[k] + to[k]) / 2;
  } else if constexpr (requires { Cell::sign; }) {
    for (std::size_t k = 0; k < Cell::dim; ++k) x[k] = Cell::sign[a][k];
  } else if (a > 0) {
    x[a - 1] = 1;
  }
  return x;
}

/// Those of all nodes, [node][dim].
template <class Cell> constexpr auto make_node_places() {
  std::array<typename Cell::Point, Cell::nodes> places{};
  for (std::size_t a = 0; a < Cell::nodes; ++a) places[a] = place_of_node<Cell>(a);
  return places;
}
template <class Cell> inline constexpr auto node_places = make_node_places<Cell>();

/// N = L (2 L - 1) at corners and 4 L_i L_j on edges, with the linear functions L.
template <class Cell, class Linear> struct QuadraticSimplex {
  static constexpr int dim = Linear::dim, nodes = (Linear::nodes * (Linear::nodes + 1)) / 2;
  using Corners = Linear;
  using Point = typename Linear::Point;
  static constexpr auto& facets = Linear::facets;
  static constexpr Point centroid() { return Linear::centroid(); }

  static constexpr std::array<double, nodes> N(const Point& x) {
    const auto L = Linear::N(x);
    std::array<double, nodes> n{};
    for (unsigned a = 0; a < Linear::nodes; ++a) n[a] = L[a] * (2 * L[a] - 1);
    for (unsigned e = 0; e < nodes - Linear::nodes; ++e) n[Linear::nodes + e] = 4 * L[from(e)] * L[to(e)];
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    const auto L = Linear::N(x);
    const auto dL = Linear::dN(x);
    std::array<Point, nodes> g{};
    for (unsigned k = 0; k < dim; ++k) {
      for (unsigned a = 0; a < Linear::nodes; ++a) g[a][k] = (4 * L[a] - 1) * dL[a][k];
      for (unsigned e = 0; e < nodes - Linear::nodes; ++e)
        g[Linear::nodes + e][k] = 4 * (L[from(e)] * dL[to(e)][k] + dL[from(e)][k] * L[to(e)]);
    }
    return g;
  }

private:
  static constexpr unsigned from(unsigned edge) { return static_cast<unsigned>(Cell::edges[edge][0]); }
  static constexpr unsigned to(unsigned edge) { return static_cast<unsigned>(Cell::edges[edge][1]); }
};

/// 6-node triangle. Rule: D. Dunavant, Int. J. Numer. Meth. Engng 21 (1985) 1129, degree 4.
struct Tri6 : QuadraticSimplex<Tri6, Tri3> {
  static constexpr CellNames names = {"quadratic triangles", "triangle", 9, 36, "Triangle_6"};
  static constexpr CellEdge edges[] = {{0, 1}, {1, 2}, {2, 0}};
  static constexpr int from_plex[nodes] = {3, 4, 5, 0, 1, 2};
  static constexpr int from_gmsh[nodes] = {0, 1, 2, 3, 4, 5};
  static constexpr int points = 6;
  static constexpr Point point(int q) {
    const double near = q < 3 ? 0.10810301816807022736 : 0.81684757298045851308, far = (1 - near) / 2;
    return {q % 3 == 1 ? near : far, q % 3 == 2 ? near : far};
  }
  static constexpr double weight(int q) { return q < 3 ? 0.11169079483900573285 : 0.05497587182766093382; }
};

/// 10-node tetrahedron in VTK order. Rule: N. Walkington, Quadrature on simplices of arbitrary dimension
/// (2000), degree 5.
struct Tet10 : QuadraticSimplex<Tet10, Tet4> {
  static constexpr CellNames names = {"quadratic tetrahedra", "tetrahedron", 11, 38, "Tetrahedron_10"};
  static constexpr CellEdge edges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  static constexpr int from_plex[nodes] = {7, 6, 8, 9, 0, 2, 1, 4, 3, 5};
  static constexpr int from_gmsh[nodes] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
  static constexpr int points = 14;
  static constexpr Point point(int q) {
    if (q < 8) { // on the lines from the corners to the centroid
      const double far = q < 4 ? 0.31088591926330060980 : 0.092735250310891226402, near = 1 - 3 * far;
      return {q % 4 == 1 ? near : far, q % 4 == 2 ? near : far, q % 4 == 3 ? near : far};
    }
    const CellEdge& edge = edges[q - 8]; // on those from the edges to it
    constexpr double far = 0.045503704125649649492, near = 0.5 - far;
    Point x{};
    for (int k = 1; k < 4; ++k) x[static_cast<unsigned>(k - 1)] = edge[0] == k || edge[1] == k ? near : far;
    return x;
  }
  static constexpr double weight(int q) {
    return (q < 4 ? 0.11268792571801585080 : q < 8 ? 0.073493043116361949544 : 0.042546020777081466438) / 6;
  }
};

} // namespace impact
