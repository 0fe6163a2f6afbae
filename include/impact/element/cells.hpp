#pragma once
#include <array>

/// Reference cells as data: nodes, linear shape functions, one quadrature rule, facets and the names that
/// files use. The rule integrates products of two shape functions of an affine cell exactly, so that the same
/// points (and the same point history) serve the motion, the damage and the mass terms: three points on Tri3,
/// four on Tet4, the 2-point Gauss product on Quad4 and Hex8. A cell is a struct with the members of Tri3;
/// kernel/shape_of.hpp makes of it what a run needs.
namespace impact {

inline constexpr int max_nodes = 27, max_points = 27; ///< of any cell

/// What people and files call a cell.
struct CellNames {
  const char* plural;
  const char* polytope;  ///< of DMPlex (DMPolytopeTypes)
  int gmsh, xdmf;        ///< element type of a .msh file, topology type of a mixed XDMF mesh
  const char* xdmf_name; ///< topology type of an XDMF mesh of these cells alone
};

/// Nodes of a facet with the normal outward; -1 after the last.
using CellFacet = std::array<int, 4>;
constexpr int node_count(const CellFacet& facet) {
  int count = 0;
  for (const int node : facet) count += node >= 0;
  return count;
}

/// 3-node triangle (0,0) (1,0) (0,1), counter-clockwise.
struct Tri3 {
  static constexpr CellNames names = {"linear triangles", "triangle", 2, 4, "Triangle"};
  static constexpr int dim = 2, nodes = 3, points = 3;
  static constexpr CellFacet facets[] = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 0, -1, -1}};
  static constexpr int from_plex[nodes] = {0, 1, 2}; ///< place of each node in the order of DMPlex
  using Point = std::array<double, dim>;
  static constexpr Point centroid() { return {1.0 / 3, 1.0 / 3}; }
  static constexpr Point point(int q) { return {q == 1 ? 2.0 / 3 : 1.0 / 6, q == 2 ? 2.0 / 3 : 1.0 / 6}; }
  static constexpr double weight(int) { return 1.0 / 6; }
  static constexpr std::array<double, nodes> N(const Point& x) { return {1 - x[0] - x[1], x[0], x[1]}; }
  static constexpr std::array<Point, nodes> dN(const Point&) {
    return {Point{-1, -1}, Point{1, 0}, Point{0, 1}};
  }
};

/// 4-node quadrilateral on [-1,1]^2, counter-clockwise from (-1,-1).
struct Quad4 {
  static constexpr CellNames names = {"quadrilaterals", "quadrilateral", 3, 5, "Quadrilateral"};
  static constexpr int dim = 2, nodes = 4, points = 4;
  static constexpr CellFacet facets[] = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 3, -1, -1}, {3, 0, -1, -1}};
  static constexpr int from_plex[nodes] = {0, 1, 2, 3};
  using Point = std::array<double, dim>;
  static constexpr double sign[nodes][dim] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  static constexpr double gauss = 0.57735026918962576451;
  static constexpr Point centroid() { return {0, 0}; }
  static constexpr Point point(int q) { return {gauss * sign[q][0], gauss * sign[q][1]}; }
  static constexpr double weight(int) { return 1; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{};
    for (int a = 0; a < nodes; ++a) n[unsigned(a)] = (1 + sign[a][0] * x[0]) * (1 + sign[a][1] * x[1]) / 4;
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    std::array<Point, nodes> g{};
    for (int a = 0; a < nodes; ++a)
      g[unsigned(a)] = {sign[a][0] * (1 + sign[a][1] * x[1]) / 4, sign[a][1] * (1 + sign[a][0] * x[0]) / 4};
    return g;
  }
};

/// 4-node tetrahedron (0,0,0) (1,0,0) (0,1,0) (0,0,1).
struct Tet4 {
  static constexpr CellNames names = {"linear tetrahedra", "tetrahedron", 4, 6, "Tetrahedron"};
  static constexpr int dim = 3, nodes = 4, points = 4;
  static constexpr CellFacet facets[] = {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}};
  static constexpr int from_plex[nodes] = {1, 0, 2, 3}; // DMPlex turns tetrahedra and hexahedra inside out
  using Point = std::array<double, dim>;
  static constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;
  static constexpr Point centroid() { return {0.25, 0.25, 0.25}; }
  static constexpr Point point(int q) {
    return {q == 1 ? near : far, q == 2 ? near : far, q == 3 ? near : far};
  }
  static constexpr double weight(int) { return 1.0 / 24; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    return {1 - x[0] - x[1] - x[2], x[0], x[1], x[2]};
  }
  static constexpr std::array<Point, nodes> dN(const Point&) {
    return {Point{-1, -1, -1}, Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}};
  }
};

/// 8-node hexahedron on [-1,1]^3 in VTK order: the lower face counter-clockwise, then the upper one.
struct Hex8 {
  static constexpr CellNames names = {"hexahedra", "hexahedron", 5, 9, "Hexahedron"};
  static constexpr int dim = 3, nodes = 8, points = 8;
  static constexpr CellFacet facets[] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                         {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  static constexpr int from_plex[nodes] = {0, 3, 2, 1, 4, 5, 6, 7};
  using Point = std::array<double, dim>;
  static constexpr double sign[nodes][dim] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                              {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  static constexpr Point centroid() { return {0, 0, 0}; }
  static constexpr Point point(int q) {
    return {Quad4::gauss * sign[q][0], Quad4::gauss * sign[q][1], Quad4::gauss * sign[q][2]};
  }
  static constexpr double weight(int) { return 1; }
  static constexpr std::array<double, nodes> N(const Point& x) {
    std::array<double, nodes> n{};
    for (int a = 0; a < nodes; ++a)
      n[unsigned(a)] = (1 + sign[a][0] * x[0]) * (1 + sign[a][1] * x[1]) * (1 + sign[a][2] * x[2]) / 8;
    return n;
  }
  static constexpr std::array<Point, nodes> dN(const Point& x) {
    std::array<Point, nodes> g{};
    for (int a = 0; a < nodes; ++a) {
      const double f[3] = {1 + sign[a][0] * x[0], 1 + sign[a][1] * x[1], 1 + sign[a][2] * x[2]};
      g[unsigned(a)] = {sign[a][0] * f[1] * f[2] / 8, sign[a][1] * f[0] * f[2] / 8,
                        sign[a][2] * f[0] * f[1] / 8};
    }
    return g;
  }
};

/// Shape functions and their reference derivatives at the points of the rule and at the centroid, as
/// constants.
template <class Cell> struct ShapeTable {
  double N[Cell::points][Cell::nodes];
  double dN[Cell::points][Cell::nodes][Cell::dim];
  double weight[Cell::points];
  double N0[Cell::nodes], dN0[Cell::nodes][Cell::dim];

  static constexpr ShapeTable make() {
    ShapeTable t{};
    for (int q = 0; q < Cell::points; ++q) {
      const auto n = Cell::N(Cell::point(q));
      const auto g = Cell::dN(Cell::point(q));
      t.weight[q] = Cell::weight(q);
      for (int a = 0; a < Cell::nodes; ++a) {
        t.N[q][a] = n[unsigned(a)];
        for (int i = 0; i < Cell::dim; ++i) t.dN[q][a][i] = g[unsigned(a)][unsigned(i)];
      }
    }
    const auto n = Cell::N(Cell::centroid());
    const auto g = Cell::dN(Cell::centroid());
    for (int a = 0; a < Cell::nodes; ++a) {
      t.N0[a] = n[unsigned(a)];
      for (int i = 0; i < Cell::dim; ++i) t.dN0[a][i] = g[unsigned(a)][unsigned(i)];
    }
    return t;
  }
};
template <class Cell> inline constexpr ShapeTable<Cell> shape_table = ShapeTable<Cell>::make();

} // namespace impact
