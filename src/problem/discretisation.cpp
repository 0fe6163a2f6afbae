#include <algorithm>
#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/exchange.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/discretisation.hpp>
#include <numbers>

namespace impact {

double Discretisation::softest_modulus() const {
  double softest = HUGE_VAL;
  for (const PointLaw& law : laws)
    if (!law.rigid()) softest = std::min(softest, young_modulus(law.parameters));
  return softest;
}

double Discretisation::small_facet() const { return small_cell() / mesh.smallest_edge(); }
double Discretisation::small_cell() const { return depth * std::pow(mesh.smallest_edge(), dim()); }

std::vector<char> Discretisation::lanes_in(const std::vector<std::string>& regions) const {
  std::vector<PetscInt> cells;
  for (const std::string& name : regions) {
    const auto more = mesh.region_cells(name);
    cells.insert(cells.end(), more.begin(), more.end());
  }
  std::sort(cells.begin(), cells.end());
  std::vector<char> inside;
  for (const CellGroup& group : groups)
    for (int b = 0; b < group.batch_count; ++b)
      for (int l = 0; l < lanes; ++l)
        inside.push_back(l < group.lanes_in_use(b) &&
                         std::binary_search(cells.begin(), cells.end(), group.cell_point[at(b * lanes + l)]));
  return inside;
}

std::size_t Discretisation::point_values(int components) const {
  std::size_t sum = 0;
  for (const CellGroup& group : groups) sum += impact::point_values(group, components);
  return sum;
}

FacetTable ErodedCells::live(const FacetTable& facets, PetscInt cell_start) const {
  return facets.without(
      [&](std::size_t f) { return !cell.empty() && cell[at(facets.cell_point[f] - cell_start)] != 0; });
}

std::size_t Discretisation::batch_count() const {
  std::size_t sum = 0;
  for (const CellGroup& group : groups) sum += at(group.batch_count);
  return sum;
}

void zero_dofs(Vec f, const Mesh& mesh, int components, const std::vector<int>& dofs) {
  double* values = nullptr;
  PetscInt start = 0;
  check(VecGetOwnershipRange(f, &start, nullptr));
  check(VecGetArray(f, &values));
  for (int dof : dofs)
    values[mesh.global_node()[at(dof / components)] * components + dof % components - start] = 0;
  check(VecRestoreArray(f, &values));
}

void add_up(const FieldLayout& layout, std::vector<double>& local) {
  const Handle<Vec> total = layout.make_global();
  layout.add_to_global(local, total);
  layout.to_local(total, local);
}

std::vector<double> Discretisation::local_of(Vec u) const {
  std::vector<double> local = displacement.make_local();
  displacement.to_local(u, local);
  return local;
}

Handle<Vec> Discretisation::global_of(const std::vector<double>& u) const {
  Handle<Vec> global = displacement.make_global();
  displacement.to_global(u, global);
  return global;
}

std::string text_of(const char* format, ...) {
  char text[400];
  va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof(text), format, values);
  va_end(values);
  return text;
}

std::string place_text(const double* x, int dim, const char* format, const char* between) {
  std::string text;
  for (int k = 0; k < dim; ++k) {
    char number[32];
    std::snprintf(number, sizeof(number), format, x[k]);
    text += (k > 0 ? between : "(") + std::string(number);
  }
  return text + ")";
}

std::string place_of_largest(const Discretisation& d, Vec f) {
  std::vector<double> local = d.displacement.make_local();
  d.displacement.owned_to_local(f, local);
  struct {
    double size = 0, x[3] = {0, 0, 0};
  } largest;
  const std::size_t dim = at(d.dim());
  for (std::size_t i = 0; i < local.size(); ++i)
    if (std::abs(local[i]) > largest.size) {
      largest.size = std::abs(local[i]);
      std::copy_n(&d.mesh.coordinates()[i / dim * dim], dim, largest.x);
    }
  largest = of_least(d.mesh.comm(), -largest.size, largest);
  return largest.size > 0 ? place_text(largest.x, d.dim()) : "";
}

std::size_t point_values(const CellGroup& group, int components) {
  return at(group.batch_count) * at(point_count(group.shape)) * at(components) * lanes;
}

namespace {

std::vector<int> materials_of_cells(const Mesh& mesh, const std::vector<MaterialAssignment>& materials) {
  PetscInt start = 0, end = 0;
  check(DMPlexGetHeightStratum(mesh.dm(), 0, &start, &end));
  std::vector<int> material(at(end - start), -1);
  int first = -1, second = -1; // a pair of materials that claim one cell
  for (int m = 0; m < static_cast<int>(materials.size()); ++m)
    for (const std::string& region : materials[at(m)].regions) {
      const Group* group = mesh.find_group(region);
      if (group == nullptr || group->dim != mesh.dim()) {
        std::string names;
        for (const Group& g : mesh.groups())
          if (g.dim == mesh.dim()) names += (names.empty() ? "" : ", ") + g.name;
        throw UserError(ExitCode::data, "-material_" + materials[at(m)].id + "_region \"" + region +
                                            "\": no such region; the mesh has: " + names);
      }
      for (PetscInt point : mesh.region_cells(region)) {
        int& mine = material[at(point - start)];
        if (mine >= 0 && mine != m) {
          first = mine;
          second = m;
        }
        mine = m;
      }
    }
  int clash[2] = {first, second};
  max_over_ranks(mesh.comm(), clash);
  if (clash[0] >= 0)
    throw UserError(ExitCode::data, "-material_" + materials[at(clash[0])].id + "_region and -material_" +
                                        materials[at(clash[1])].id +
                                        "_region share cells; give each cell one material");
  return material;
}

// The mean of a cell's nodes, the same to the last bit whatever their order.
std::array<double, 3> centre_of(const Mesh& mesh, const CellTable& table, std::size_t cell) {
  const auto nodes = at(node_count(table.shape)), dim = at(mesh.dim());
  std::array<double, 3> centre{};
  for (std::size_t k = 0; k < dim; ++k) {
    std::vector<double> values;
    for (std::size_t a = 0; a < nodes; ++a)
      values.push_back(mesh.coordinates()[at(table.connectivity[cell * nodes + a]) * dim + k]);
    std::ranges::sort(values);
    for (const double value : values) centre[k] += value / static_cast<double>(nodes);
  }
  return centre;
}

/// A material and its factors somewhere.
struct PlacedLaw {
  int material = 0;
  PlaceFactors factors;
  auto operator<=>(const PlacedLaw&) const = default;
};

// All that any rank has, without repetition, in order.
std::vector<PlacedLaw> unite(MPI_Comm comm, std::vector<PlacedLaw> mine) {
  const auto sort = [](std::vector<PlacedLaw>& all) {
    std::ranges::sort(all);
    all.erase(std::ranges::unique(all).begin(), all.end());
  };
  sort(mine);
  int ranks = 0;
  MPI_Comm_size(comm, &ranks);
  std::vector<PlacedLaw> all;
  for (const auto& part : all_to_all(comm, std::vector(at(ranks), mine)))
    all.insert(all.end(), part.begin(), part.end());
  sort(all);
  return all;
}

// Cells of one law come into the same batches; so what depends on place costs a law for each of its values.
std::vector<CellGroup> pack(const Mesh& mesh, const std::vector<MaterialAssignment>& materials,
                            std::vector<PointLaw>& laws) {
  std::vector<int> of_cell = materials_of_cells(mesh, materials);
  std::vector<PlacedLaw> placed(of_cell.size());
  for (std::size_t c = 0; c < placed.size(); ++c) placed[c].material = of_cell[c];
  const auto place = [&](const CellTable& table) {
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      PlacedLaw& cell = placed[at(table.point[c] - mesh.cell_start())];
      if (cell.material < 0 || !materials[at(cell.material)].factors) continue;
      cell.factors = materials[at(cell.material)].factors(centre_of(mesh, table, c).data());
    }
  };
  agree_on_errors(mesh.comm(), [&] { std::ranges::for_each(mesh.cells(), place); });
  std::vector<PlacedLaw> kinds = unite(mesh.comm(), placed);
  std::erase_if(kinds, [](const PlacedLaw& kind) { return kind.material < 0; });
  for (std::size_t c = 0; c < placed.size(); ++c)
    if (of_cell[c] >= 0)
      of_cell[c] = static_cast<int>(std::ranges::lower_bound(kinds, placed[c]) - kinds.begin());
  std::vector<CellGroup> groups = pack_cells(mesh, of_cell);
  for (CellGroup& group : groups) group.material = kinds[at(group.law)].material;
  for (const PlacedLaw& kind : kinds)
    laws.push_back(kind.factors == PlaceFactors{} ? materials[at(kind.material)].law
                                                  : law_at(materials[at(kind.material)].law, kind.factors));
  return groups;
}

// Collective.
double mean_circumference(const Mesh& mesh) {
  double sum = 0;
  for (int node = 0; node < mesh.node_count(); ++node)
    if (mesh.owned(node)) sum += mesh.coordinates()[at(2 * node)];
  return 2 * std::numbers::pi * sum_over_ranks(mesh.comm(), sum) /
         static_cast<double>(mesh.global_node_count());
}

} // namespace

Discretisation discretise(Mesh mesh, std::vector<MaterialAssignment> materials, Frame plane,
                          double thickness) {
  const int dim = mesh.dim();
  if (plane != Frame::plane_strain && dim != 2)
    throw UserError(ExitCode::data, plane == Frame::axisymmetric
                                        ? "-plane axisymmetric: the mesh is 3D; axisymmetric runs want a 2D "
                                          "mesh (x = R, y = Z)"
                                        : "-plane stress: the mesh is 3D; sheets want a 2D mesh");
  FieldLayout displacement(mesh, "u", dim), scalar(mesh, "phi", 1);
  for (MaterialAssignment& material : materials) material.law.parameters.sheet = plane == Frame::plane_stress;
  std::vector<PointLaw> laws;
  std::vector<CellGroup> groups = pack(mesh, materials, laws);
  VolumePatches patches(mesh, groups, materials);
  const Frame frame = dim == 3 ? Frame::solid : plane;
  const double depth = frame == Frame::axisymmetric ? mean_circumference(mesh) : 1;
  Discretisation d{std::move(mesh),
                   std::move(displacement),
                   std::move(scalar),
                   std::move(materials),
                   std::move(groups),
                   std::move(laws),
                   frame,
                   is_flat(frame) ? thickness : 1.0,
                   {},
                   {},
                   false,
                   std::move(patches)};
  d.depth = depth;
  return d;
}

void declare_state(const Discretisation& d, StateTable& table) {
  for (const char* name : {"u", "v", "a", "mean_rate", "prescribed_velocity"}) {
    StateRow row{name, Support::vertex, d.dim()};
    row.output = name[1] == '\0';
    table.add(std::move(row), d.node_values(d.dim()));
  }
  const auto add_scalar = [&](const char* name) {
    StateRow row{name, Support::vertex, 1};
    row.output = true;
    table.add(std::move(row), d.node_values(1));
  };
  if (d.has_damage()) add_scalar("phi");
  if (d.has_heat()) add_scalar("theta");
  StateRow& rows = table.add({"history", Support::cell_point, history_size(d.frame)},
                             d.point_values(history_size(d.frame)));
  set_virgin(d.frame, rows.committed);
  rows.trial = rows.committed;
  if (d.has_drive()) table.add({"drive", Support::cell_point, drive_size}, d.point_values(drive_size));
  if (d.has_fatigue()) table.add({"fatigue", Support::cell_point, 1}, d.point_values(1));
  if (d.has_toughness()) table.add({"toughness", Support::cell_point, 2}, d.point_values(2));
  if (d.has_failure()) table.add({"jc_failure", Support::cell_point, 1}, d.point_values(1));
  if (!d.erodes()) return;
  table.add({"eroded", Support::cell_point, 1}, d.point_values(1));
  if (!d.patches.empty()) table.add({"patch_scale", Support::cell_point, 1}, d.point_values(1));
  table.add({"erosion_totals", Support::global, ErosionTotals::components}, ErosionTotals::components);
}

} // namespace impact
