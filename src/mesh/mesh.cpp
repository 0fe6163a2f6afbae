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

// Vertices of the closure of a point, as local nodes, in DMPlex order.
void closure_nodes(DM dm, PetscInt point, PetscInt vertex_start, PetscInt vertex_end,
                   std::vector<int>& nodes) {
  PetscInt size = 0, *closure = nullptr;
  check(DMPlexGetTransitiveClosure(dm, point, PETSC_TRUE, &size, &closure));
  nodes.clear();
  for (PetscInt k = 0; k < size; ++k)
    if (closure[2 * k] >= vertex_start && closure[2 * k] < vertex_end)
      nodes.push_back(static_cast<int>(closure[2 * k] - vertex_start));
  check(DMPlexRestoreTransitiveClosure(dm, point, PETSC_TRUE, &size, &closure));
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

// Vertices that are leaves of the point SF are ghosts; owned ones are numbered rank by rank in the order of
// points, which is the order in which PETSc lays global vectors.
void Mesh::number_nodes() {
  PetscSF sf = nullptr;
  PetscInt roots = 0, leaves = 0, chart_end = 0;
  const PetscInt* leaf = nullptr;
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, &roots, &leaves, &leaf, nullptr));
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  owned_.assign(static_cast<std::size_t>(node_count_), 1);
  for (PetscInt k = 0; k < leaves; ++k) {
    const PetscInt node = (leaf ? leaf[k] : k) - vertex_start_;
    if (node >= 0 && node < node_count_) owned_[static_cast<std::size_t>(node)] = 0;
  }
  owned_node_count_ = static_cast<int>(std::count(owned_.begin(), owned_.end(), char{1}));

  PetscInt mine = owned_node_count_, before = 0;
  MPI_Exscan(&mine, &before, 1, MPIU_INT, MPI_SUM, comm());
  MPI_Allreduce(&mine, &global_node_count_, 1, MPIU_INT, MPI_SUM, comm());
  int rank = 0;
  MPI_Comm_rank(comm(), &rank);
  PetscInt next = rank == 0 ? 0 : before;
  std::vector<PetscInt> number(static_cast<std::size_t>(chart_end), -1);
  for (int n = 0; n < node_count_; ++n)
    if (owned(n)) number[static_cast<std::size_t>(vertex_point(n))] = next++;
  if (roots >= 0) {
    const std::vector<PetscInt> root = number;
    check(PetscSFBcastBegin(sf, MPIU_INT, root.data(), number.data(), MPI_REPLACE));
    check(PetscSFBcastEnd(sf, MPIU_INT, root.data(), number.data(), MPI_REPLACE));
  }
  global_node_.assign(number.begin() + vertex_start_, number.begin() + vertex_start_ + node_count_);
}

void Mesh::read_cells() {
  PetscInt end = 0;
  check(DMPlexGetHeightStratum(dm_, 0, &cell_start_, &end));
  if (node_count_ == 0) end = cell_start_;
  table_of_cell_.reserve(static_cast<std::size_t>(end - cell_start_));
  std::string trouble;
  std::vector<int> closure;
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
    closure_nodes(dm_, point, vertex_start_, vertex_start_ + node_count_, closure);
    for (const int place : shape->from_plex)
      cells.connectivity.push_back(closure[static_cast<std::size_t>(place)]);
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
           << regions_of(table.point[c]) << " near (";
      for (int i = 0; i < dim_; ++i)
        text << (i ? ", " : "") << coordinates_[static_cast<std::size_t>(node[0] * dim_ + i)];
      text << "), smallest relative det J " << det
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

const Group* Mesh::find_group(const std::string& name) const {
  const auto found =
      std::find_if(groups_.begin(), groups_.end(), [&](const Group& g) { return g.name == name; });
  return found == groups_.end() ? nullptr : &*found;
}

const Group& Mesh::group(const std::string& name) const {
  if (const Group* found = find_group(name)) return *found;
  std::string all;
  for (const Group& g : groups_)
    all += (all.empty() ? "" : ", ") + g.name + " (" + std::to_string(g.dim) + "D)";
  throw UserError(ExitCode::data, "mesh: no physical group \"" + name + "\"; the mesh has: " + all);
}

DMLabel Mesh::label(const std::string& name) const {
  DMLabel found = nullptr;
  check(DMGetLabel(dm_, name.c_str(), &found));
  if (!found) throw UserError(ExitCode::data, "mesh: group \"" + name + "\" has no label");
  return found;
}

std::vector<PetscInt> Mesh::labelled_points(const std::string& name) const {
  IS values = nullptr;
  const PetscInt* value = nullptr;
  PetscInt count = 0;
  std::vector<PetscInt> points;
  const DMLabel found = label(name);
  check(DMLabelGetValueIS(found, &values));
  const Handle<IS> owner(values);
  check(ISGetLocalSize(values, &count));
  check(ISGetIndices(values, &value));
  for (PetscInt v = 0; v < count; ++v) {
    Handle<IS> stratum;
    const PetscInt* point = nullptr;
    PetscInt size = 0;
    check(DMLabelGetStratumIS(found, value[v], stratum.out()));
    if (!stratum) continue;
    check(ISGetLocalSize(stratum, &size));
    check(ISGetIndices(stratum, &point));
    points.insert(points.end(), point, point + size);
    check(ISRestoreIndices(stratum, &point));
  }
  check(ISRestoreIndices(values, &value));
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::vector<PetscInt> Mesh::region_cells(const std::string& name) const {
  if (group(name).dim != dim_)
    throw UserError(ExitCode::data, "mesh: group \"" + name + "\" is no region; its dimension must be " +
                                        std::to_string(dim_));
  std::vector<PetscInt> points = labelled_points(name);
  std::erase_if(points, [&](PetscInt p) { return p < cell_start_ || p >= cell_start_ + cell_count(); });
  return points;
}

std::string Mesh::regions_of(PetscInt cell_point) const {
  std::string names;
  for (const Group& g : groups_) {
    PetscInt value = -1;
    if (g.dim != dim_) continue;
    check(DMLabelGetValue(label(g.name), cell_point, &value));
    if (value >= 0) names += (names.empty() ? "" : ", ") + g.name;
  }
  return names.empty() ? "no region" : names;
}

FacetTable Mesh::facets(const std::string& name) const {
  if (group(name).dim != dim_ - 1)
    throw UserError(ExitCode::data, "mesh: group \"" + name + "\" is no boundary; its dimension must be " +
                                        std::to_string(dim_ - 1));
  FacetTable table;
  for (const Shape shape : known_shapes())
    for (std::size_t f = 0; has_shape(shape) && f < shape->facets.size(); ++f)
      table.nodes_per_facet = std::max(table.nodes_per_facet, impact::node_count(shape->facets[f]));
  PetscInt start = 0, end = 0, leaves = 0;
  const PetscInt* leaf = nullptr;
  PetscSF sf = nullptr;
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, nullptr, &leaves, &leaf, nullptr));
  std::vector<int> wanted;
  for (const PetscInt point : labelled_points(name)) {
    PetscInt place = -1;
    if (point < start || point >= end) continue;
    if (leaves > 0 && leaf) check(PetscFindInt(point, leaves, leaf, &place));
    if (place >= 0) continue; // a facet between two ranks belongs to the owner of the point
    const PetscInt* support = nullptr;
    check(DMPlexGetSupport(dm_, point, &support));
    closure_nodes(dm_, point, vertex_start_, vertex_start_ + node_count_, wanted);
    std::sort(wanted.begin(), wanted.end());
    const CellPlace place_of_cell = table_of_cell_[static_cast<std::size_t>(support[0] - cell_start_)];
    const CellTable& cells = cells_[static_cast<std::size_t>(place_of_cell.table)];
    const int* node =
        &cells.connectivity[static_cast<std::size_t>(place_of_cell.cell * impact::node_count(cells.shape))];
    for (const CellFacet& facet : cells.shape->facets) {
      std::vector<int> nodes;
      for (int a = 0; a < impact::node_count(facet); ++a)
        nodes.push_back(node[facet[static_cast<std::size_t>(a)]]);
      std::vector<int> sorted = nodes;
      std::sort(sorted.begin(), sorted.end());
      if (sorted != wanted) continue;
      nodes.resize(static_cast<std::size_t>(table.nodes_per_facet), nodes.back());
      table.connectivity.insert(table.connectivity.end(), nodes.begin(), nodes.end());
      table.point.push_back(point);
      table.cell_point.push_back(support[0]);
    }
  }
  return table;
}

void Mesh::require_outside(const std::string& option, const std::string& name) const {
  PetscInt chart_end = 0, start = 0, end = 0, roots = 0;
  PetscSF sf = nullptr;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  std::vector<int> cells(static_cast<std::size_t>(chart_end), 0), closure;
  for (PetscInt point = start; point < end; ++point) {
    PetscInt size = 0;
    check(DMPlexGetSupportSize(dm_, point, &size));
    cells[static_cast<std::size_t>(point)] = static_cast<int>(size);
  }
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  if (roots >= 0) { // the cells of a facet may be on two ranks
    const std::vector<int> mine = cells;
    check(PetscSFReduceBegin(sf, MPI_INT, mine.data(), cells.data(), MPI_SUM));
    check(PetscSFReduceEnd(sf, MPI_INT, mine.data(), cells.data(), MPI_SUM));
  }
  std::string trouble;
  for (const PetscInt point : labelled_points(name)) {
    if (point < start || point >= end || cells[static_cast<std::size_t>(point)] < 2) continue;
    closure_nodes(dm_, point, vertex_start_, vertex_start_ + node_count_, closure);
    std::ostringstream text;
    text << option << " \"" << name << "\": has a facet inside a body, near (";
    for (int i = 0; i < dim_; ++i)
      text << (i ? ", " : "") << coordinates_[static_cast<std::size_t>(closure[0] * dim_ + i)];
    text << "), with a cell on either side; allowed: facets on the outside of bodies; a traction or a force "
            "acts inside too, and a slit or a contact there wants its nodes twice";
    trouble = text.str();
    break;
  }
  throw_first(comm(), ExitCode::data, trouble);
}

std::vector<int> Mesh::nodes(const std::string& name) const {
  group(name);
  PetscInt chart_end = 0, roots = 0;
  PetscSF sf = nullptr;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  std::vector<int> marked(static_cast<std::size_t>(chart_end), 0), closure;
  for (const PetscInt point : labelled_points(name)) {
    closure_nodes(dm_, point, vertex_start_, vertex_start_ + node_count_, closure);
    for (const int n : closure) marked[static_cast<std::size_t>(vertex_point(n))] = 1;
  }
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  if (roots >= 0) {
    const std::vector<int> leaf = marked;
    check(PetscSFReduceBegin(sf, MPI_INT, leaf.data(), marked.data(), MPI_MAX));
    check(PetscSFReduceEnd(sf, MPI_INT, leaf.data(), marked.data(), MPI_MAX));
    const std::vector<int> root = marked;
    check(PetscSFBcastBegin(sf, MPI_INT, root.data(), marked.data(), MPI_REPLACE));
    check(PetscSFBcastEnd(sf, MPI_INT, root.data(), marked.data(), MPI_REPLACE));
  }
  std::vector<int> result;
  for (int n = 0; n < node_count_; ++n)
    if (marked[static_cast<std::size_t>(vertex_point(n))] != 0) result.push_back(n);
  return result;
}

std::vector<double> Mesh::node_shares(const std::string& name) const {
  const int group_dim = group(name).dim;
  PetscSF sf = nullptr;
  PetscInt leaves = 0, chart_end = 0;
  const PetscInt* leaf = nullptr;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, nullptr, &leaves, &leaf, nullptr));
  std::vector<char> elsewhere(static_cast<std::size_t>(chart_end), 0);
  for (PetscInt i = 0; i < leaves; ++i) elsewhere[static_cast<std::size_t>(leaf ? leaf[i] : i)] = 1;
  std::vector<double> shares(static_cast<std::size_t>(node_count_), 0.0);
  std::vector<int> ends;
  for (const PetscInt point : labelled_points(name)) {
    if (elsewhere[static_cast<std::size_t>(point)] != 0) continue;
    closure_nodes(dm_, point, vertex_start_, vertex_start_ + node_count_, ends);
    double size = 0;
    for (int k = 0; group_dim == 1 && k < dim_; ++k) {
      const double step = coordinates_[static_cast<std::size_t>(ends.at(1) * dim_ + k)] -
                          coordinates_[static_cast<std::size_t>(ends.at(0) * dim_ + k)];
      size += step * step;
    }
    for (const int node : ends)
      shares[static_cast<std::size_t>(node)] += group_dim == 0 ? 1 : std::sqrt(size) / 2;
  }
  return shares;
}

} // namespace impact
