#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/node_map.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <numeric>

namespace impact {

NodeMap::NodeMap(std::vector<PetscInt> points) : point_(std::move(points)) {
  if (point_.empty()) return;
  first_ = point_.front();
  node_.assign(at(point_.back() - first_ + 1), -1);
  for (int node = 0; node < count(); ++node) node_[at(point(node) - first_)] = node;
}

NodeMap node_map(DM dm) {
  PetscSection section = nullptr;
  PetscInt begin = 0, end = 0, dofs = 0;
  std::vector<PetscInt> points;
  check(DMGetCoordinateSection(dm, &section));
  check(PetscSectionGetChart(section, &begin, &end));
  for (PetscInt point = begin; point < end; ++point) {
    check(PetscSectionGetDof(section, point, &dofs));
    if (dofs > 0) points.push_back(point);
  }
  return NodeMap(std::move(points));
}

int order_of(DM dm, const NodeMap& nodes) {
  PetscInt first = 0, end = 0;
  check(DMPlexGetDepthStratum(dm, 1, &first, &end));
  return max_over_ranks(PetscObjectComm(reinterpret_cast<PetscObject>(dm)),
                        first < end && nodes.node(first) >= 0 ? 2 : 1);
}

std::vector<int> nodes_around(DM dm, const NodeMap& nodes, PetscInt point) {
  PetscInt size = 0, *points = nullptr;
  std::vector<int> found;
  check(DMPlexGetTransitiveClosure(dm, point, PETSC_TRUE, &size, &points));
  for (PetscInt k = 0; k < size; ++k)
    if (const int node = nodes.node(points[2 * k]); node >= 0) found.push_back(node);
  check(DMPlexRestoreTransitiveClosure(dm, point, PETSC_TRUE, &size, &points));
  return found;
}

Handle<PetscSection> node_section(DM dm, const NodeMap& nodes, int dofs) {
  PetscInt first = 0, end = 0;
  Handle<PetscSection> section;
  check(PetscSectionCreate(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), section.out()));
  check(PetscSectionSetNumFields(section, 1)); // before the chart, else PETSc 3.18 crashes
  check(PetscSectionSetFieldComponents(section, 0, dofs));
  check(DMPlexGetChart(dm, &first, &end));
  check(PetscSectionSetChart(section, first, end));
  for (int node = 0; node < nodes.count(); ++node) {
    check(PetscSectionSetDof(section, nodes.point(node), dofs));
    check(PetscSectionSetFieldDof(section, nodes.point(node), 0, dofs));
  }
  check(PetscSectionSetUp(section));
  return section;
}

void add_middles(DM dm, Middles middles) {
  PetscInt dim = 0, first = 0, end = 0;
  Vec corners = nullptr;
  const PetscScalar* x = nullptr;
  check(DMGetCoordinateDim(dm, &dim));
  check(DMGetCoordinatesLocalSetUp(dm));
  check(DMGetCoordinatesLocal(dm, &corners));
  const NodeMap vertices = node_map(dm);
  check(DMPlexGetChart(dm, &first, &end));
  std::vector<PetscInt> points;
  for (PetscInt point = first; point < end; ++point) {
    DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
    check(DMPlexGetCellType(dm, point, &type));
    const bool quadrilateral = type == DM_POLYTOPE_QUADRILATERAL || type == DM_POLYTOPE_HEXAHEDRON;
    if (type == DM_POLYTOPE_POINT || type == DM_POLYTOPE_SEGMENT ||
        (quadrilateral && middles == Middles::all))
      points.push_back(point);
  }
  const NodeMap nodes(std::move(points));
  std::vector<PetscScalar> all;
  if (nodes.count() > 0) check(VecGetArrayRead(corners, &x));
  for (int node = 0; node < nodes.count(); ++node) {
    const std::vector<int> around = nodes_around(dm, vertices, nodes.point(node));
    std::vector<PetscScalar> of_corners(around.size());
    // Summed by size: the same on all ranks, whichever corner is the first.
    for (PetscInt i = 0; i < dim; ++i) {
      std::ranges::transform(around, of_corners.begin(), [&](int corner) { return x[corner * dim + i]; });
      std::ranges::sort(of_corners);
      all.push_back(std::accumulate(of_corners.begin(), of_corners.end(), 0.0) /
                    static_cast<double>(around.size()));
    }
  }
  if (nodes.count() > 0) check(VecRestoreArrayRead(corners, &x));
  DM coordinate_dm = nullptr;
  Handle<Vec> values;
  PetscScalar* to = nullptr;
  const Handle<PetscSection> section = node_section(dm, nodes, static_cast<int>(dim));
  check(PetscSectionSetFieldName(section, 0, "coordinates"));
  check(DMGetCoordinateDM(dm, &coordinate_dm));
  check(DMSetCoordinateSection(dm, dim, section));
  check(VecCreateSeq(PETSC_COMM_SELF, static_cast<PetscInt>(all.size()), values.out()));
  check(VecSetBlockSize(values, dim));
  check(VecGetArrayWrite(values, &to));
  std::copy(all.begin(), all.end(), to);
  check(VecRestoreArrayWrite(values, &to));
  check(DMSetCoordinatesLocal(dm, values));
}

} // namespace impact
