#include <algorithm>
#include <array>
#include <impact/mesh/node_map.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <stdexcept>
#include <vector>

namespace impact {

int order_of(DM dm) {
  PetscSection section = nullptr;
  PetscInt first = 0, end = 0, begin = 0, chart_end = 0, dofs = 0;
  check(DMPlexGetDepthStratum(dm, 1, &first, &end));
  check(DMGetCoordinateSection(dm, &section));
  check(PetscSectionGetChart(section, &begin, &chart_end));
  if (first < end && first >= begin && first < chart_end) check(PetscSectionGetDof(section, first, &dofs));
  return max_over_ranks(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), dofs > 0 ? 2 : 1);
}

NodeMap node_map(DM dm, int order) {
  NodeMap map;
  PetscInt end = 0;
  check(DMPlexGetDepthStratum(dm, 0, &map.first_vertex, &end));
  map.vertices = end - map.first_vertex;
  if (order == 1) return map;
  check(DMPlexGetDepthStratum(dm, 1, &map.first_edge, &end));
  map.edges = end - map.first_edge;
  if (map.edges > 0 && map.first_edge < map.first_vertex)
    throw std::logic_error("DMPlex numbers edges before vertices");
  return map;
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

Handle<PetscSection> node_section(DM dm, int order, int dofs) {
  PetscInt first = 0, end = 0;
  Handle<PetscSection> section;
  check(PetscSectionCreate(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), section.out()));
  check(PetscSectionSetNumFields(section, 1)); // before the chart, else PETSc 3.18 crashes
  check(PetscSectionSetFieldComponents(section, 0, dofs));
  check(DMPlexGetChart(dm, &first, &end));
  check(PetscSectionSetChart(section, first, end));
  const NodeMap nodes = node_map(dm, order);
  for (int node = 0; node < nodes.count(); ++node) {
    check(PetscSectionSetDof(section, nodes.point(node), dofs));
    check(PetscSectionSetFieldDof(section, nodes.point(node), 0, dofs));
  }
  check(PetscSectionSetUp(section));
  return section;
}

void add_edge_nodes(DM dm) {
  PetscInt dim = 0;
  Vec corners = nullptr;
  const PetscScalar* x = nullptr;
  check(DMGetCoordinateDim(dm, &dim));
  check(DMGetCoordinatesLocalSetUp(dm));
  check(DMGetCoordinatesLocal(dm, &corners));
  const NodeMap nodes = node_map(dm, 2);
  std::vector<PetscScalar> all;
  if (nodes.vertices > 0) {
    check(VecGetArrayRead(corners, &x));
    all.assign(x, x + nodes.vertices * dim);
    check(VecRestoreArrayRead(corners, &x));
  }
  for (PetscInt edge = nodes.first_edge; edge < nodes.first_edge + nodes.edges; ++edge) {
    const PetscInt* cone = nullptr;
    check(DMPlexGetCone(dm, edge, &cone));
    const auto *a = &all[static_cast<std::size_t>(nodes.node(cone[0]) * dim)],
               *b = &all[static_cast<std::size_t>(nodes.node(cone[1]) * dim)];
    std::array<PetscScalar, 3> middle{}; // the same on all ranks, whichever end is the first
    std::transform(a, a + dim, b, middle.begin(), [](double p, double q) { return 0.5 * (p + q); });
    all.insert(all.end(), middle.begin(), middle.begin() + dim);
  }
  DM coordinate_dm = nullptr;
  Handle<Vec> values;
  PetscScalar* to = nullptr;
  const Handle<PetscSection> section = node_section(dm, 2, static_cast<int>(dim));
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
