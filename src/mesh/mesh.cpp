#include <algorithm>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>
#include <sstream>

namespace impact {

namespace {

// A relative det J of this size or less is round-off: the cell is flat.
constexpr double degenerate = 1e-10;

// Smallest det J over the points of the rule, in units of (longest extent of the cell)^dim.
double smallest_relative_det(Shape shape, const double* coordinates, const int* node) {
  const auto dim = at(shape->dim), nodes = at(shape->nodes);
  const auto x = [&](std::size_t a, std::size_t i) { return coordinates[at(node[a]) * dim + i]; };
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

Mesh::Mesh(Handle<DM> dm, std::vector<Group> groups, std::vector<PetscInt> patches)
    : dm_(std::move(dm)), groups_(std::move(groups)), patches_(std::move(patches)) {
  PetscInt dim = 0;
  check(DMGetDimension(dm_, &dim));
  dim_ = static_cast<int>(dim);
  if (dim_ != 2 && dim_ != 3)
    throw UserError(ExitCode::data, "mesh: dimension " + std::to_string(dim_) + "; allowed 2 and 3");
  nodes_ = node_map(dm_);
  order_ = order_of(dm_, nodes_);
  for (const Group& g : groups_) {
    PetscBool known = PETSC_FALSE;
    check(DMHasLabel(dm_, g.name.c_str(), &known));
    if (!known) throw UserError(ExitCode::data, "mesh: group \"" + g.name + "\" has no label");
  }
  read_coordinates();
  number_nodes();
  read_cells();
  check_cells();
  measure_edges();
}

MPI_Comm Mesh::comm() const { return PetscObjectComm(reinterpret_cast<PetscObject>(dm_.get())); }

std::string Mesh::place(int node) const {
  std::ostringstream text;
  for (int i = 0; i < dim_; ++i) text << (i ? ", " : "(") << coordinates_[at(node * dim_ + i)];
  text << ")";
  return text.str();
}

std::vector<int> Mesh::closure(PetscInt point) const { return nodes_around(dm_, nodes_, point); }

bool Mesh::has_shape(Shape shape) const {
  const auto index = at(index_of(shape));
  return index < has_shape_.size() && has_shape_[index] != 0;
}

void Mesh::read_coordinates() {
  Vec values = nullptr;
  const PetscScalar* x = nullptr;
  PetscInt coordinate_dim = 0;
  check(DMGetCoordinateDim(dm_, &coordinate_dim));
  throw_first(comm(), ExitCode::data,
              coordinate_dim == dim_ ? "" : "mesh: coordinates have another dimension than the cells");
  check(DMGetCoordinatesLocalSetUp(dm_));
  check(DMGetCoordinatesLocal(dm_, &values));
  if (node_count() == 0) return;
  check(VecGetArrayRead(values, &x));
  coordinates_.assign(x, x + node_count() * dim_); // they stand in the order of the nodes
  check(VecRestoreArrayRead(values, &x));
}

// PETSc numbers owned nodes rank by rank in the order of points, in which it also lays global vectors.
void Mesh::number_nodes() {
  Handle<DM> dm;
  PetscSection numbers = nullptr;
  check(DMClone(dm_, dm.out()));
  check(DMSetNumFields(dm, 1));
  check(DMSetLocalSection(dm, node_section(dm, nodes_, 1)));
  check(DMGetGlobalSection(dm, &numbers));
  for (int n = 0; n < node_count(); ++n) { // those of other ranks are marked by their sign
    PetscInt number = 0;
    check(PetscSectionGetOffset(numbers, point(n), &number));
    if (number >= 0 && owned_node_count_++ == 0) first_node_ = number;
    global_node_.push_back(number < 0 ? -1 - number : number);
  }
  global_node_count_ = sum_over_ranks(comm(), owned_node_count_);
}

Mesh::CellNodes Mesh::cell_nodes(PetscInt cell) const {
  DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
  check(DMPlexGetCellType(dm_, cell, &type));
  const std::vector<int> node = closure(cell);
  CellNodes ordered{find_shape(dim_, DMPolytopeTypes[type], static_cast<int>(node.size())), {}};
  if (ordered.shape == Shape()) return ordered;
  for (const int place : ordered.shape->from_plex) ordered.node.push_back(node[at(place)]);
  return ordered;
}

void Mesh::read_cells() {
  PetscInt end = 0;
  check(DMPlexGetHeightStratum(dm_, 0, &cell_start_, &end));
  if (node_count() == 0) end = cell_start_;
  cell_count_ = static_cast<int>(end - cell_start_);
  std::string trouble;
  has_shape_.assign(known_shapes().size(), 0);
  for (PetscInt point = cell_start_; point < end && trouble.empty(); ++point) {
    const auto [shape, nodes] = cell_nodes(point);
    if (shape == Shape()) {
      DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
      check(DMPlexGetCellType(dm_, point, &type));
      trouble = std::string("mesh: a cell of type ") + DMPolytopeTypes[type] + " with " +
                std::to_string(closure(point).size()) +
                " nodes; allowed are triangles and quadrilaterals in 2D, tetrahedra and hexahedra in 3D";
      break;
    }
    has_shape_[at(index_of(shape))] = 1;
    auto table = std::find_if(cells_.begin(), cells_.end(), [&](const auto& t) { return t.shape == shape; });
    if (table == cells_.end()) table = cells_.insert(table, {shape, {}, {}});
    table->connectivity.insert(table->connectivity.end(), nodes.begin(), nodes.end());
    table->point.push_back(point);
  }
  throw_first(comm(), ExitCode::data, trouble);
  max_over_ranks(comm(), has_shape_);
  global_cell_count_ = sum_over_ranks(comm(), cell_count_);
}

void Mesh::check_cells() const {
  std::string trouble;
  for (const CellTable& table : cells_) {
    const std::size_t nodes = at(impact::node_count(table.shape));
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
      const double d = coordinates_[at(nodes_.node(cone[1]) * dim_ + i)] -
                       coordinates_[at(nodes_.node(cone[0]) * dim_ + i)];
      square += d * d;
    }
    shortest = std::min(shortest, std::sqrt(square));
  }
  smallest_edge_ = min_over_ranks(comm(), shortest);
}

Mesh shifted_mesh(const Mesh& mesh, const std::vector<double>& shift) {
  check(PetscObjectReference(reinterpret_cast<PetscObject>(mesh.dm())));
  Handle<DM> dm(mesh.dm());
  Vec before = nullptr;
  Handle<Vec> after;
  PetscScalar* x = nullptr;
  check(DMGetCoordinatesLocal(dm, &before));
  check(VecDuplicate(before, after.out()));
  check(VecGetArrayWrite(after, &x));
  std::transform(shift.begin(), shift.end(), mesh.coordinates().begin(), x, std::plus());
  check(VecRestoreArrayWrite(after, &x));
  check(DMSetCoordinatesLocal(dm, after)); // the global ones are made afresh from these
  return Mesh(std::move(dm), mesh.groups(), mesh.patches());
}

} // namespace impact
