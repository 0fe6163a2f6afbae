#include "shared_points.hpp"
#include <algorithm>
#include <cmath>
#include <impact/math/vector3.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/mesh.hpp>
#include <limits>
#include <sstream>

namespace impact {

namespace {

// [DMPolytopeType] the shape of a cell; none where a cell of that kind cannot be used.
std::array<Shape, DM_NUM_POLYTOPES> shapes_of_polytopes() {
  std::array<Shape, DM_NUM_POLYTOPES> shapes{};
  for (const Shape shape : known_shapes())
    for (std::size_t type = 0; type < shapes.size(); ++type)
      if (shape->names.polytope == std::string(DMPolytopeTypes[type])) shapes[type] = shape;
  return shapes;
}

// A relative det J of this size or less is round-off: the cell is flat.
constexpr double degenerate = 1e-10;

// Smallest det J over the points of the rule, in units of (longest extent of the cell)^dim.
double smallest_relative_det(Shape shape, const double* coordinates, const int* node) {
  const auto dim = static_cast<std::size_t>(shape->dim), nodes = static_cast<std::size_t>(shape->nodes);
  const auto x = [&](std::size_t a, std::size_t i) {
    return coordinates[static_cast<std::size_t>(node[a]) * dim + i];
  };
  double extent = 0, smallest = std::numeric_limits<double>::infinity();
  for (std::size_t a = 1; a < nodes; ++a)
    for (std::size_t i = 0; i < dim; ++i) extent = std::max(extent, std::abs(x(a, i) - x(0, i)));
  const double* slope = shape->dN;
  for (int q = 0; q < shape->points; ++q, slope += nodes * dim) {
    std::array<Vector3, 3> J{{{}, {}, {0, 0, dim == 2 ? 1.0 : 0.0}}};
    for (std::size_t a = 0; a < nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i)
        for (std::size_t k = 0; k < dim; ++k) J[i][k] += x(a, i) * slope[a * dim + k] / extent;
    const double det = determinant(J[0], J[1], J[2]);
    smallest = std::isfinite(det) ? std::min(smallest, det) : -1;
  }
  return smallest;
}

} // namespace

Mesh::Mesh(Handle<DM> dm, std::vector<Group> groups) : dm_(std::move(dm)), groups_(std::move(groups)) {
  PetscInt dim = 0, end = 0;
  check(DMGetDimension(dm_, &dim));
  dim_ = static_cast<int>(dim);
  if (dim_ != 2 && dim_ != 3)
    throw UserError(ExitCode::data, "mesh: dimension " + std::to_string(dim_) + "; allowed 2 and 3");
  check(DMPlexGetDepthStratum(dm_, 0, &vertex_start_, &end));
  node_count_ = static_cast<int>(end - vertex_start_);
  for (const Group& g : groups_) label(g.name);
  read_coordinates();
  number_nodes();
  read_cells();
  check_cells();
  measure_edges();
}

MPI_Comm Mesh::comm() const { return PetscObjectComm(reinterpret_cast<PetscObject>(dm_.get())); }

std::string Mesh::place(int node) const {
  std::ostringstream text;
  for (int i = 0; i < dim_; ++i)
    text << (i ? ", " : "(") << coordinates_[static_cast<std::size_t>(node * dim_ + i)];
  text << ")";
  return text.str();
}

std::vector<int> Mesh::closure(PetscInt point) const {
  PetscInt size = 0, *points = nullptr;
  std::vector<int> nodes;
  check(DMPlexGetTransitiveClosure(dm_, point, PETSC_TRUE, &size, &points));
  for (PetscInt k = 0; k < size; ++k)
    if (points[2 * k] >= vertex_start_ && points[2 * k] < vertex_start_ + node_count_)
      nodes.push_back(static_cast<int>(points[2 * k] - vertex_start_));
  check(DMPlexRestoreTransitiveClosure(dm_, point, PETSC_TRUE, &size, &points));
  return nodes;
}

std::vector<char> Mesh::owned_elsewhere() const {
  PetscSF sf = nullptr;
  PetscInt leaves = 0, chart_end = 0;
  const PetscInt* leaf = nullptr;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, nullptr, &leaves, &leaf, nullptr));
  std::vector<char> elsewhere(static_cast<std::size_t>(chart_end), 0);
  for (PetscInt k = 0; k < leaves; ++k) elsewhere[static_cast<std::size_t>(leaf ? leaf[k] : k)] = 1;
  return elsewhere;
}

bool Mesh::has_shape(Shape shape) const {
  const auto index = static_cast<std::size_t>(index_of(shape));
  return index < has_shape_.size() && has_shape_[index] != 0;
}

void Mesh::read_coordinates() {
  Vec values = nullptr;
  PetscSection section = nullptr;
  const PetscScalar* x = nullptr;
  PetscInt coordinate_dim = 0;
  check(DMGetCoordinateDim(dm_, &coordinate_dim));
  throw_first(comm(), ExitCode::data,
              coordinate_dim == dim_ ? "" : "mesh: coordinates have another dimension than the cells");
  check(DMGetCoordinatesLocalSetUp(dm_));
  check(DMGetCoordinatesLocal(dm_, &values));
  check(DMGetCoordinateSection(dm_, &section));
  coordinates_.resize(static_cast<std::size_t>(node_count_ * dim_));
  if (node_count_ == 0) return;
  check(VecGetArrayRead(values, &x));
  for (int n = 0; n < node_count_; ++n) {
    PetscInt offset = 0;
    check(PetscSectionGetOffset(section, vertex_point(n), &offset));
    for (int i = 0; i < dim_; ++i) coordinates_[static_cast<std::size_t>(n * dim_ + i)] = x[offset + i];
  }
  check(VecRestoreArrayRead(values, &x));
}

// Owned vertices are numbered rank by rank in the order of points, which is the order in which PETSc lays
// global vectors.
void Mesh::number_nodes() {
  const std::vector<char> elsewhere = owned_elsewhere();
  for (int n = 0; n < node_count_; ++n)
    owned_.push_back(elsewhere[static_cast<std::size_t>(vertex_point(n))] == 0);
  owned_node_count_ = static_cast<int>(std::count(owned_.begin(), owned_.end(), char{1}));

  PetscInt mine = owned_node_count_, end = 0;
  MPI_Scan(&mine, &end, 1, MPIU_INT, MPI_SUM, comm());
  MPI_Allreduce(&mine, &global_node_count_, 1, MPIU_INT, MPI_SUM, comm());
  PetscInt next = end - mine;
  std::vector<PetscInt> number(elsewhere.size(), -1);
  for (int n = 0; n < node_count_; ++n)
    if (owned(n)) number[static_cast<std::size_t>(vertex_point(n))] = next++;
  copy_from_owners(dm_, MPIU_INT, number);
  global_node_.assign(number.begin() + vertex_start_, number.begin() + vertex_start_ + node_count_);
}

void Mesh::read_cells() {
  PetscInt end = 0;
  check(DMPlexGetHeightStratum(dm_, 0, &cell_start_, &end));
  if (node_count_ == 0) end = cell_start_;
  table_of_cell_.reserve(static_cast<std::size_t>(end - cell_start_));
  std::string trouble;
  const auto shapes = shapes_of_polytopes();
  std::vector<int> table_of_shape(known_shapes().size(), -1);
  for (PetscInt point = cell_start_; point < end && trouble.empty(); ++point) {
    DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
    check(DMPlexGetCellType(dm_, point, &type));
    const Shape shape = shapes[static_cast<std::size_t>(type)];
    if (shape == Shape() || shape->dim != dim_) {
      trouble = std::string("mesh: a cell of type ") + DMPolytopeTypes[type] +
                "; allowed are triangles and quadrilaterals in 2D, tetrahedra and hexahedra in 3D";
      break;
    }
    int& table = table_of_shape[static_cast<std::size_t>(index_of(shape))];
    if (table < 0) {
      table = static_cast<int>(cells_.size());
      cells_.push_back({shape, {}, {}});
    }
    CellTable& cells = cells_[static_cast<std::size_t>(table)];
    table_of_cell_.push_back({table, static_cast<int>(cells.point.size())});
    const std::vector<int> node = closure(point);
    for (const int place : shape->from_plex)
      cells.connectivity.push_back(node[static_cast<std::size_t>(place)]);
    cells.point.push_back(point);
  }
  throw_first(comm(), ExitCode::data, trouble);

  has_shape_.assign(known_shapes().size(), 0);
  for (const CellTable& t : cells_) has_shape_[static_cast<std::size_t>(index_of(t.shape))] = 1;
  MPI_Allreduce(MPI_IN_PLACE, has_shape_.data(), static_cast<int>(has_shape_.size()), MPI_INT, MPI_MAX,
                comm());
  const PetscInt count = cell_count();
  MPI_Allreduce(&count, &global_cell_count_, 1, MPIU_INT, MPI_SUM, comm());
}

void Mesh::check_cells() const {
  std::string trouble;
  for (const CellTable& table : cells_) {
    const std::size_t nodes = static_cast<std::size_t>(impact::node_count(table.shape));
    for (std::size_t c = 0; c < table.point.size() && trouble.empty(); ++c) {
      const int* node = &table.connectivity[c * nodes];
      const double det = smallest_relative_det(table.shape, coordinates_.data(), node);
      if (det > degenerate) continue;
      std::ostringstream text;
      text << "mesh: " << (det < -degenerate ? "inverted" : "degenerate") << " cell in "
           << regions_of(table.point[c]) << " near " << place(node[0]) << ", smallest relative det J " << det
           << "; it must be positive at all points; mend the mesh there";
      trouble = text.str();
    }
  }
  throw_first(comm(), ExitCode::data, trouble);
}

void Mesh::measure_edges() {
  PetscInt start = 0, end = 0;
  check(DMPlexGetDepthStratum(dm_, 1, &start, &end));
  double shortest = std::numeric_limits<double>::infinity();
  for (PetscInt edge = start; edge < end; ++edge) {
    const PetscInt* cone = nullptr;
    check(DMPlexGetCone(dm_, edge, &cone));
    double square = 0;
    for (int i = 0; i < dim_; ++i) {
      const double d = coordinates_[static_cast<std::size_t>((cone[1] - vertex_start_) * dim_ + i)] -
                       coordinates_[static_cast<std::size_t>((cone[0] - vertex_start_) * dim_ + i)];
      square += d * d;
    }
    shortest = std::min(shortest, std::sqrt(square));
  }
  MPI_Allreduce(&shortest, &smallest_edge_, 1, MPI_DOUBLE, MPI_MIN, comm());
}

} // namespace impact
