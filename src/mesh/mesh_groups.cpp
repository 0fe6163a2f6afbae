#include <algorithm>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/mesh.hpp>
#include <set>

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

std::vector<PetscInt> labelled_points(DM dm, const std::string& label, PetscInt value) {
  Handle<IS> stratum;
  const PetscInt* point = nullptr;
  PetscInt size = 0;
  check(DMGetStratumIS(dm, label.c_str(), value, stratum.out()));
  if (!stratum) return {};
  check(ISGetLocalSize(stratum, &size));
  check(ISGetIndices(stratum, &point));
  std::vector<PetscInt> points(point, point + size);
  check(ISRestoreIndices(stratum, &point));
  std::sort(points.begin(), points.end());
  return points;
}

void share_points(DM dm, MPI_Op op, std::vector<int>& value) {
  PetscSF sf = nullptr;
  PetscInt roots = 0;
  check(DMGetPointSF(dm, &sf));
  check(PetscSFGetGraph(sf, &roots, nullptr, nullptr, nullptr));
  if (roots < 0) return; // the DM lies on one rank
  std::vector<int> others = value;
  check(PetscSFReduceBegin(sf, MPI_INT, others.data(), value.data(), op));
  check(PetscSFReduceEnd(sf, MPI_INT, others.data(), value.data(), op));
  others = value;
  check(PetscSFBcastBegin(sf, MPI_INT, others.data(), value.data(), MPI_REPLACE));
  check(PetscSFBcastEnd(sf, MPI_INT, others.data(), value.data(), MPI_REPLACE));
}

// The label of a group has its dimension as value.
std::vector<PetscInt> Mesh::points(const std::string& name) const {
  return labelled_points(dm_, name, group(name).dim);
}

std::vector<PetscInt> Mesh::owned_points(const std::string& name) const {
  PetscSF sf = nullptr;
  PetscInt count = 0;
  const PetscInt* leaf = nullptr; // sorted; null: the first ones
  check(DMGetPointSF(dm_, &sf));
  check(PetscSFGetGraph(sf, nullptr, &count, &leaf, nullptr));
  std::vector<PetscInt> owned = points(name);
  std::erase_if(owned,
                [&](PetscInt p) { return leaf ? std::binary_search(leaf, leaf + count, p) : p < count; });
  return owned;
}

std::vector<PetscInt> Mesh::region_cells(const std::string& name) const {
  if (group(name).dim != dim_)
    throw UserError(ExitCode::data, "mesh: group \"" + name + "\" is no region; its dimension must be " +
                                        std::to_string(dim_));
  std::vector<PetscInt> cells = points(name);
  std::erase_if(cells, [&](PetscInt p) { return p < cell_start_ || p >= cell_start_ + cell_count(); });
  return cells;
}

std::string Mesh::regions_of(PetscInt cell_point) const {
  std::string names;
  for (const Group& g : groups_) {
    PetscInt value = -1;
    if (g.dim != dim_) continue;
    check(DMGetLabelValue(dm_, g.name.c_str(), cell_point, &value));
    if (value >= 0) names += (names.empty() ? "" : ", ") + g.name;
  }
  return names.empty() ? "no region" : names;
}

// A facet as its cell sees it.
void Mesh::add_facet(PetscInt facet, PetscInt cell, FacetTable& table) const {
  std::vector<int> wanted = closure(facet);
  std::sort(wanted.begin(), wanted.end());
  const auto [shape, node] = cell_nodes(cell);
  for (const CellFacet& side : shape->facets) {
    std::vector<int> nodes;
    for (const int a : facet_nodes(shape, side)) nodes.push_back(node[at(a)]);
    std::vector<int> sorted = nodes;
    std::sort(sorted.begin(), sorted.end());
    if (sorted != wanted) continue;
    nodes.resize(at(table.nodes_per_facet), nodes.back());
    table.connectivity.insert(table.connectivity.end(), nodes.begin(), nodes.end());
    table.point.push_back(facet);
    table.cell_point.push_back(cell);
  }
}

FacetTable Mesh::live_facets(const std::string& name, const std::vector<char>& eroded,
                             const std::vector<char>& body) const {
  const auto gone = [&](PetscInt cell) { return eroded[at(cell - cell_start_)] != 0; };
  const FacetTable all = facets(name);
  FacetTable table = all.without([&](std::size_t f) { return gone(all.cell_point[f]); });
  PetscInt chart_end = 0;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  std::vector<int> eroded_beside(at(chart_end), 0); // of facets; the cells of one may be on two ranks
  const auto visit_cone = [&](PetscInt cell, auto&& visitor) {
    PetscInt size = 0;
    const PetscInt* cone = nullptr;
    check(DMPlexGetConeSize(dm_, cell, &size));
    check(DMPlexGetCone(dm_, cell, &cone));
    for (PetscInt k = 0; k < size; ++k) visitor(cone[k]);
  };
  for (PetscInt cell = cell_start_; cell < cell_start_ + cell_count(); ++cell)
    if (gone(cell)) visit_cone(cell, [&](PetscInt facet) { ++eroded_beside[at(facet)]; });
  share_points(dm_, MPI_SUM, eroded_beside);
  for (PetscInt cell = cell_start_; cell < cell_start_ + cell_count(); ++cell) {
    if (gone(cell)) continue;
    visit_cone(cell, [&](PetscInt facet) {
      if (eroded_beside[at(facet)] > 0 && body[at(closure(facet)[0])] != 0) add_facet(facet, cell, table);
    });
  }
  return table;
}

FacetTable Mesh::no_facets() const {
  FacetTable table;
  for (const Shape shape : known_shapes())
    for (std::size_t f = 0; has_shape(shape) && f < shape->facets.size(); ++f)
      table.nodes_per_facet =
          std::max(table.nodes_per_facet, static_cast<int>(facet_nodes(shape, shape->facets[f]).size()));
  return table;
}

FacetTable Mesh::facets(const std::string& name) const {
  if (group(name).dim != dim_ - 1)
    throw UserError(ExitCode::data, "mesh: group \"" + name + "\" is no boundary; its dimension must be " +
                                        std::to_string(dim_ - 1));
  FacetTable table = no_facets();
  PetscInt start = 0, end = 0;
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  for (const PetscInt point : owned_points(name)) {
    if (point < start || point >= end) continue;
    const PetscInt* support = nullptr;
    check(DMPlexGetSupport(dm_, point, &support));
    add_facet(point, support[0], table);
  }
  return table;
}

// [point] of facets; they may be on two ranks.
std::vector<int> Mesh::cells_beside() const {
  PetscInt chart_end = 0, start = 0, end = 0;
  check(DMPlexGetChart(dm_, nullptr, &chart_end));
  check(DMPlexGetHeightStratum(dm_, 1, &start, &end));
  std::vector<int> cells(at(chart_end), 0);
  for (PetscInt point = start; point < end; ++point) {
    PetscInt size = 0;
    check(DMPlexGetSupportSize(dm_, point, &size));
    cells[at(point)] = static_cast<int>(size);
  }
  share_points(dm_, MPI_SUM, cells);
  return cells;
}

FacetTable Mesh::outer_facets() const {
  const std::vector<int> cells = cells_beside();
  FacetTable table = no_facets();
  for (PetscInt point = 0; point < static_cast<PetscInt>(cells.size()); ++point) {
    if (cells[at(point)] != 1) continue;
    const PetscInt* support = nullptr;
    check(DMPlexGetSupport(dm_, point, &support));
    add_facet(point, support[0], table);
  }
  return table;
}

void Mesh::require_outside(const std::string& option, const std::string& name) const {
  const std::vector<int> cells = cells_beside();
  std::string trouble;
  for (const PetscInt point : points(name)) {
    if (cells[at(point)] < 2) continue;
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
  std::vector<int> marked(at(chart_end), 0);
  for (const PetscInt point : points(name))
    for (const int n : closure(point)) marked[at(this->point(n))] = 1;
  share_points(dm_, MPI_MAX, marked);
  std::vector<int> result;
  for (int n = 0; n < node_count(); ++n)
    if (marked[at(this->point(n))] != 0) result.push_back(n);
  return result;
}

std::vector<double> Mesh::node_shares(const std::vector<std::string>& names) const {
  const int group_dim = group(names.front()).dim;
  std::vector<double> shares(at(node_count()), 0.0);
  // What is in several of them counts once, and of a line that was refined its edges alone.
  std::set<PetscInt> all;
  for (const std::string& name : names)
    for (const PetscInt point : owned_points(name)) {
      PetscInt depth = 0;
      check(DMPlexGetPointDepth(dm_, point, &depth));
      if (depth == group_dim) all.insert(point);
    }
  for (const PetscInt point : all) {
    std::vector<int> ends = closure(point);
    const int middle = order_ == 2 && group_dim == 1 ? ends.front() : -1; // the edge itself comes first
    if (middle >= 0) ends.erase(ends.begin());
    double size = 0;
    for (int k = 0; group_dim == 1 && k < dim_; ++k) {
      const double step = coordinates_[at(ends.at(1) * dim_ + k)] - coordinates_[at(ends.at(0) * dim_ + k)];
      size += step * step;
    }
    size = std::sqrt(size);
    if (middle >= 0) shares[at(middle)] += 2 * size / 3;
    for (const int node : ends) shares[at(node)] += group_dim == 0 ? 1 : size / (middle >= 0 ? 6 : 2);
  }
  return shares;
}

} // namespace impact
