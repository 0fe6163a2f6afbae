#pragma once
#include <array>

/// Reference cells as data: nodes, shape functions, one quadrature rule, facets and the names that files
/// use. The rule integrates products of two shape functions of an affine cell exactly, so that the same
/// points (and the same point history) serve the motion, the damage and the mass terms: three points on Tri3,
/// four on Tet4, the 2-point Gauss product on Quad4 and Hex8 (second_order.hpp has those of its cells). A
/// cell is a struct with the members of Tri3; kernel/shape_of.hpp makes of it what a run needs.
namespace impact {

inline constexpr int max_nodes = 27, max_points = 27; ///< of any cell

/// What people and files call a cell.
struct CellNames {
  const char* plural;
  const char* polytope;  ///< of DMPlex (DMPolytopeTypes)
  int gmsh, xdmf;        ///< element type of a .msh file, topology type of a mixed XDMF mesh
  const char* xdmf_name; ///< topology type of an XDMF mesh of these cells alone
};

/// Corners of a facet with the normal outward; -1 after the last.
using CellFacet = std::array<int, 4>;
constexpr int node_count(const CellFacet& facet) {
  int count = 0;
  for (const int node : facet) count += node >= 0;
  return count;
}

using CellEdge = std::array<int, 2>; ///< the corners at its ends

/// Linear functions on the unit simplex: node 0 at the origin, node k at 1 along axis k.
template <int d> struct Simplex {
  static constexpr int dim = d, nodes = d + 1;
  using Point = std::array<double, d>;
  static constexpr Point centroid() {
    Point x{};
    x.fill(1.0 / nodes);
    return x;
  }
  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{1};
    for (unsigned k = 0; k < d; ++k) {
      n[0] -= x[k];
      n[k + 1] = x[k];
    }
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point&) {
    std::array<Point, nodes> g{};
    for (unsigned k = 0; k < d; ++k) {
      g[0][k] = -1;
      g[k + 1][k] = 1;
    }
    return g;
  }
};

/// Products of linear functions on [-1,1]^d, nodes at the ends `sign`, and the 2-point Gauss rule.
template <class Cell, int d> struct LineProduct {
  static constexpr int dim = d, nodes = 1 << d, points = nodes;
  static constexpr double gauss = 0.57735026918962576451;
  using Point = std::array<double, d>;
  static constexpr Point centroid() { return {}; }
  static constexpr Point point(int q) {
    Point x{};
    for (unsigned k = 0; k < d; ++k) x[k] = gauss * Cell::sign[q][k];
    return x;
  }
  static constexpr double weight(int) { return 1; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{};
    for (unsigned a = 0; a < nodes; ++a) {
      n[a] = 1.0 / nodes;
      for (unsigned k = 0; k < d; ++k) n[a] *= 1 + Cell::sign[a][k] * x[k];
    }
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    std::array<Point, nodes> g{};
    for (unsigned a = 0; a < nodes; ++a)
      for (unsigned i = 0; i < d; ++i) {
        g[a][i] = Cell::sign[a][i] / nodes;
        for (unsigned k = 0; k < d; ++k)
          if (k != i) g[a][i] *= 1 + Cell::sign[a][k] * x[k];
      }
    return g;
  }
};

/// 3-node triangle, counter-clockwise.
struct Tri3 : Simplex<2> {
  static constexpr CellNames names = {"linear triangles", "triangle", 2, 4, "Triangle"};
  static constexpr CellFacet facets[] = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 0, -1, -1}};
  static constexpr int from_plex[nodes] = {0, 1, 2}; ///< place of each node in the order of DMPlex
  static constexpr int points = 3;
  static constexpr Point point(int q) { return {q == 1 ? 2.0 / 3 : 1.0 / 6, q == 2 ? 2.0 / 3 : 1.0 / 6}; }
  static constexpr double weight(int) { return 1.0 / 6; }
};

/// 4-node quadrilateral, counter-clockwise from (-1,-1).
struct Quad4 : LineProduct<Quad4, 2> {
  static constexpr CellNames names = {"quadrilaterals", "quadrilateral", 3, 5, "Quadrilateral"};
  static constexpr CellFacet facets[] = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 3, -1, -1}, {3, 0, -1, -1}};
  static constexpr int from_plex[nodes] = {0, 1, 2, 3};
  static constexpr double sign[nodes][dim] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
};

/// 4-node tetrahedron.
struct Tet4 : Simplex<3> {
  static constexpr CellNames names = {"linear tetrahedra", "tetrahedron", 4, 6, "Tetrahedron"};
  static constexpr CellFacet facets[] = {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}};
  static constexpr int from_plex[nodes] = {1, 0, 2, 3}; // DMPlex turns tetrahedra and hexahedra inside out
  static constexpr int points = 4;
  static constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;
  static constexpr Point point(int q) {
    return {q == 1 ? near : far, q == 2 ? near : far, q == 3 ? near : far};
  }
  static constexpr double weight(int) { return 1.0 / 24; }
};

/// 8-node hexahedron in VTK order: the lower face counter-clockwise, then the upper one.
struct Hex8 : LineProduct<Hex8, 3> {
  static constexpr CellNames names = {"hexahedra", "hexahedron", 5, 9, "Hexahedron"};
  static constexpr CellFacet facets[] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                         {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  static constexpr int from_plex[nodes] = {0, 3, 2, 1, 4, 5, 6, 7};
  static constexpr double sign[nodes][dim] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                              {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
};

/// Whether a cell has nodes in the middle of its edges.
template <class Cell> inline constexpr bool is_second_order = requires { Cell::edges; };
/// Whether it has others in the middle of its quadrilaterals, and of itself.
template <class Cell> inline constexpr bool has_faces = requires { Cell::faces; };
template <class Cell> inline constexpr bool has_middle = requires { Cell::middle; };

/// Shape functions and their reference derivatives at the points of the rule and at the centroid, as
/// constants.
template <class Cell> struct ShapeTable {
  double N[Cell::points][Cell::nodes];
  double dN[Cell::points][Cell::nodes][Cell::dim];
  double weight[Cell::points];
  double N0[Cell::nodes], dN0[Cell::nodes][Cell::dim];

  static constexpr ShapeTable make() {
    ShapeTable t{};
    const auto fill = [](const auto& x, auto& N, auto& dN) {
      const auto n = Cell::N(x);
      const auto g = Cell::dN(x);
      for (unsigned a = 0; a < Cell::nodes; ++a) {
        N[a] = n[a];
        for (unsigned i = 0; i < Cell::dim; ++i) dN[a][i] = g[a][i];
      }
    };
    for (int q = 0; q < Cell::points; ++q) {
      t.weight[q] = Cell::weight(q);
      fill(Cell::point(q), t.N[q], t.dN[q]);
    }
    fill(Cell::centroid(), t.N0, t.dN0);
    return t;
  }
};
template <class Cell> inline constexpr ShapeTable<Cell> shape_table = ShapeTable<Cell>::make();

} // namespace impact
