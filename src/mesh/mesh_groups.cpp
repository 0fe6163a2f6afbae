#include "shared_points.hpp"
#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/mesh.hpp>

// What the mesh says of its named groups: regions, boundaries, curves and points.

namespace impact {

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
  PetscInt start = 0, end = 0;
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  const std::vector<char> elsewhere = owned_elsewhere();
  for (const PetscInt point : labelled_points(name)) {
    if (point < start || point >= end) continue;
    if (elsewhere[static_cast<std::size_t>(point)])
      continue; // between two ranks: the owner of the point has it
    const PetscInt* support = nullptr;
    check(DMPlexGetSupport(dm_, point, &support));
    std::vector<int> wanted = closure(point);
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
  PetscInt chart_end = 0, start = 0, end = 0;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  std::vector<int> cells(static_cast<std::size_t>(chart_end), 0);
  for (PetscInt point = start; point < end; ++point) {
    PetscInt size = 0;
    check(DMPlexGetSupportSize(dm_, point, &size));
    cells[static_cast<std::size_t>(point)] = static_cast<int>(size);
  }
  reduce_to_owners(dm_, MPI_SUM, cells); // the cells of a facet may be on two ranks
  std::string trouble;
  for (const PetscInt point : labelled_points(name)) {
    if (point < start || point >= end || cells[static_cast<std::size_t>(point)] < 2) continue;
    trouble = option + " \"" + name + "\": has a facet inside a body, near " + place(closure(point)[0]) +
              ", with a cell on either side; allowed: facets on the outside of bodies; a traction or a force "
              "acts inside too, and a slit or a contact there wants its nodes twice";
    break;
  }
  throw_first(comm(), ExitCode::data, trouble);
}

std::vector<int> Mesh::nodes(const std::string& name) const {
  group(name);
  PetscInt chart_end = 0;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  std::vector<int> marked(static_cast<std::size_t>(chart_end), 0);
  for (const PetscInt point : labelled_points(name))
    for (const int n : closure(point)) marked[static_cast<std::size_t>(vertex_point(n))] = 1;
  reduce_to_owners(dm_, MPI_MAX, marked);
  copy_from_owners(dm_, MPI_INT, marked);
  std::vector<int> result;
  for (int n = 0; n < node_count_; ++n)
    if (marked[static_cast<std::size_t>(vertex_point(n))] != 0) result.push_back(n);
  return result;
}

std::vector<double> Mesh::node_shares(const std::string& name) const {
  const int group_dim = group(name).dim;
  const std::vector<char> elsewhere = owned_elsewhere();
  std::vector<double> shares(static_cast<std::size_t>(node_count_), 0.0);
  for (const PetscInt point : labelled_points(name)) {
    if (elsewhere[static_cast<std::size_t>(point)] != 0) continue;
    const std::vector<int> ends = closure(point);
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
