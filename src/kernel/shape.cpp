#include <algorithm>
#include <cmath>
#include <impact/kernel/shape.hpp>
#include <impact/math/rotation.hpp>
#include <numeric>

namespace impact {

namespace {

// The list of all shapes.
std::vector<Shape>& shapes() {
  static std::vector<Shape> list = {Shape::tri3,  Shape::quad4, Shape::tet4,  Shape::hex8,  Shape::tri6,
                                    Shape::tet10, Shape::quad9, Shape::hex27, Shape::quad8, Shape::hex20};
  return list;
}

} // namespace

std::span<const Shape> known_shapes() { return shapes(); }

int index_of(Shape shape) {
  return static_cast<int>(std::find(shapes().begin(), shapes().end(), shape) - shapes().begin());
}

Shape find_shape(int dim, std::string_view polytope, int nodes) {
  Shape found;
  for (const Shape shape : shapes())
    if (shape->dim == dim && shape->names.polytope == polytope && shape->nodes == nodes) found = shape;
  return found;
}

Shape linear(Shape shape) {
  return shape->order() == 1 ? shape : find_shape(shape->dim, shape->names.polytope, shape->corners());
}

std::vector<int> corners_around(Shape shape, int node) {
  std::vector<int> corners;
  std::size_t place = static_cast<std::size_t>(node - shape->corners());
  if (node < shape->corners()) {
    corners = {node};
  } else if (place < shape->edges.size()) {
    corners = {shape->edges[place].begin(), shape->edges[place].end()};
  } else if (place -= shape->edges.size(); place < shape->faces.size()) {
    corners = {shape->faces[place].begin(), shape->faces[place].end()};
  } else {
    corners.resize(static_cast<std::size_t>(shape->corners()));
    std::iota(corners.begin(), corners.end(), 0);
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::vector<int> facet_nodes(Shape shape, const CellFacet& facet) {
  const auto corners = static_cast<std::size_t>(node_count(facet));
  std::vector<int> nodes(facet.begin(), facet.begin() + corners);
  int first = shape->corners();
  const auto add_node_amid = [&](auto around, auto places) {
    std::sort(around.begin(), around.end());
    for (std::size_t k = 0; k < places.size(); ++k) {
      auto other = places[k];
      std::sort(other.begin(), other.end());
      if (other == around) nodes.push_back(first + static_cast<int>(k));
    }
  };
  for (std::size_t k = 0; k < (corners == 2 ? 1 : corners); ++k)
    add_node_amid(CellEdge{facet[k], facet[(k + 1) % corners]}, shape->edges);
  first += static_cast<int>(shape->edges.size());
  add_node_amid(facet, shape->faces);
  return nodes;
}

KnownShape::KnownShape(const CellShape& cell) { shapes().emplace_back(cell); }
KnownShape::~KnownShape() { shapes().pop_back(); }

bool locate(Shape shape, const double* X, const double* at, double* N) {
  const int dim = shape->dim, nodes = shape->nodes;
  std::array<double, 3> xi = shape->centroid;
  double slope[3 * max_nodes], step = 0;
  for (int it = 0; it < 30; ++it) {
    shape->basis(xi.data(), N, slope);
    Vector3 r{};
    Matrix3 J = unit_matrix;
    for (int i = 0; i < dim; ++i) {
      const auto row = static_cast<std::size_t>(3 * i);
      r[row / 3] = at[i];
      for (std::size_t j = 0; j < static_cast<std::size_t>(dim); ++j) J[row + j] = 0;
      for (int a = 0; a < nodes; ++a) {
        const double x = X[a * dim + i];
        r[row / 3] -= N[a] * x;
        for (std::size_t j = 0; j < static_cast<std::size_t>(dim); ++j)
          J[row + j] += slope[a * dim + static_cast<int>(j)] * x;
      }
    }
    const Vector3 d = inverse(J) * r;
    step = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(dim); ++i) {
      xi[i] += d[i];
      step = std::max(step, std::abs(d[i]));
    }
    if (!(step < 1e3)) return false;
    if (step < 1e-13) break;
  }
  // To a point that no place has it wanders for ever, through the cell too. Rounding alone leaves far less.
  if (!(step < 1e-8)) return false;
  const Shape corner_cell = linear(shape); // its functions are negative outside alone
  corner_cell->basis(xi.data(), N, slope);
  const bool inside = std::none_of(N, N + corner_cell->nodes, [](double value) { return value < -1e-9; });
  shape->basis(xi.data(), N, slope);
  return inside;
}

} // namespace impact
