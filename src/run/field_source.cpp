#include <algorithm>
#include <cmath>
#include <impact/input/spelling.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/material/cohesive.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/field_source.hpp>
#include <impact/scenario/columns.hpp>

namespace impact {

namespace {

const std::pair<std::string, std::vector<double> ContactFields::*> contact_fields[] = {
    {"contact_pressure", &ContactFields::pressure},
    {"contact_gap", &ContactFields::gap},
    {"contact_status", &ContactFields::status},
    {"contact_traction", &ContactFields::traction},
    {"contact_slip", &ContactFields::slip}};

// Fields that are rows with one number per point.
bool is_point_row(std::string_view name) {
  return name == "fatigue" || name == "jc_failure" || name == "eroded";
}

// Fields that are a number of the law.
std::optional<double> number_of(std::string_view name, const MaterialParameters& m) {
  if (name == "E") return m.G == 0 ? 0 : young_modulus(m);
  if (name == "Gc") return m.Gc;
  if (name == "strength") return is_cohesive(m.ge) ? std::sqrt(cohesive_slope(m, 1) / m.cohesive.a1) : 0;
  return {};
}

// Mean over each cell of a row with one number per point.
Batch cell_mean(const CellBatch& batch, const std::vector<double>& row) {
  return batch.mean(batch.vectors(batch.d.mesh.coordinates()), batch.load<1>(row));
}

} // namespace

void FieldSource::require(const std::string& key, const std::string& name,
                          const std::string& no_region) const {
  std::vector<std::string> offered;
  for (const auto& row : state_.rows())
    if (row->output) offered.push_back(row->name);
  for (const FieldNote& field : field_notes()) {
    const bool is_contact = std::string_view(field.name).starts_with("contact_");
    if (field.on_nodes ? is_contact && !motion_.contacts().empty()
                       : no_region.empty() && (!is_point_row(field.name) || state_.find(field.name)))
      offered.emplace_back(field.name);
  }
  if (std::ranges::find(offered, name) == offered.end())
    throw UserError(ExitCode::usage, key + ": this run has no field '" + name + "'" +
                                         (no_region.empty() ? "" : " on " + no_region + ", no region") +
                                         "; it has: " + join(offered));
}

FieldValues FieldSource::values(const std::string& name, Vec u) const {
  const auto notes = field_notes();
  const auto note = std::ranges::find_if(notes, [&](const FieldNote& field) { return name == field.name; });
  if (note != notes.end() && !note->on_nodes)
    return {false, note->components, cell_means(name, note->components)};
  for (const auto& [contact, field] : contact_fields)
    if (name == contact) return {true, note->components, motion_.contacts().nodal_fields(u).*field};
  const StateRow& row = state_.row(name);
  return {true, row.components, row.committed};
}

std::vector<double> FieldSource::cell_means(const std::string& name, int components) const {
  const Discretisation& d = motion_.discretisation();
  const auto values_of = [&](const char* row) {
    const StateRow* const found = state_.find(row);
    return found == nullptr ? nullptr : &found->committed;
  };
  const std::vector<double>&u = state_.row("u").committed, &history = state_.row("history").committed;
  const auto *const phi_row = values_of("phi"), *const theta_row = values_of("theta");
  const StateRow* const row = is_point_row(name) ? &state_.row(name) : nullptr;
  std::vector<double> values;
  const auto append = [&](const Batch* source) {
    for (int k = 0; k < components; ++k)
      for (int l = 0; l < lanes; ++l) values.push_back(source[k][l]);
  };
  PatchState patches;
  if (row == nullptr) share_volumes(d, {&u, phi_row, theta_row, &history}, patches);
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    if (const auto number = number_of(name, batch.law.parameters)) {
      const Batch same = *number;
      return append(&same);
    }
    if (row != nullptr) {
      const Batch mean = cell_mean(batch, row->committed);
      return append(&mean);
    }
    const auto X = batch.vectors(d.mesh.coordinates()), place = batch.displaced(u);
    NodalValues phi = batch.nodal(1), theta = batch.nodal(1);
    auto points = batch.histories();
    MotionInput in;
    in.X = X.data();
    // The stress field leaves the viscous part out: it belongs to a step, not to a state.
    in.u = in.u_n = place.data();
    in.phi = batch.read(phi_row, phi);
    in.theta = batch.read(theta_row, theta);
    in.history = batch.read(&history, points);
    BatchArray<1> patch(1);
    BatchArray<2> pressure(2);
    in.patch = batch.read_shared(patches.J_minus_1, patch);
    in.patch_pressure = batch.read_shared(patches.pressure, pressure);
    CellOutput out;
    batch.kernels.cell_output(batch.law, in, out);
    append(name == "stress"      ? out.stress
           : name == "von_mises" ? &out.von_mises
           : name == "pressure"  ? &out.pressure
                                 : &out.alpha);
  });
  return values;
}

} // namespace impact
