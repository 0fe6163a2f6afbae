#include <algorithm>
#include <cmath>
#include <impact/kernel/measure.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/observers.hpp>
#include <impact/scenario/columns.hpp>

namespace impact {

namespace {

const FieldNote* cell_field(const std::string& name) {
  const auto notes = field_notes();
  const auto found = std::find_if(notes.begin(), notes.end(), [&](const FieldNote& field) {
    return !field.on_nodes && name == field.name;
  });
  return found == notes.end() ? nullptr : &*found;
}

} // namespace

bool FieldSource::is_nodal(const std::string& name) { return cell_field(name) == nullptr; }

std::vector<std::string> FieldSource::names() const {
  std::vector<std::string> names;
  for (const auto& row : state_.rows())
    if (row->output) names.push_back(row->name);
  for (const FieldNote& field : field_notes()) {
    const std::string name = field.name;
    if (field.on_nodes ? name.starts_with("contact_") && !motion_.contacts().empty()
                       : name != "fatigue" || state_.find("fatigue"))
      names.push_back(name);
  }
  return names;
}

void FieldSource::require(const std::string& key, const std::string& name, bool nodal_only) const {
  std::string offered;
  for (const std::string& field : names()) {
    if (nodal_only && !is_nodal(field)) continue;
    if (field == name) return;
    offered += (offered.empty() ? "" : ", ") + field;
  }
  throw UserError(ExitCode::usage, key + ": this run has no " + (nodal_only ? "nodal " : "") + "field '" +
                                       name + "'; it has: " + offered);
}

std::vector<double> FieldSource::nodal(const std::string& name, const Snapshot& snapshot,
                                       int& components) const {
  if (name.rfind("contact_", 0) == 0) {
    std::vector<double> ContactFields::*field = name == "contact_gap"        ? &ContactFields::gap
                                                : name == "contact_status"   ? &ContactFields::status
                                                : name == "contact_traction" ? &ContactFields::traction
                                                : name == "contact_slip"     ? &ContactFields::slip
                                                                             : &ContactFields::pressure;
    components = name == "contact_traction" || name == "contact_slip" ? 3 : 1;
    return motion_.contacts().nodal_fields(snapshot.u).*field;
  }
  const StateRow& row = state_.row(name);
  components = row.components;
  return row.committed;
}

// [group][batch][lane]
std::vector<double> FieldSource::fatigue_means() const {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double>& fatigue = state_.row("fatigue").committed;
  std::vector<double> values;
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates());
    const Batch mean = batch.kernels.cell_mean(X.data(), batch.load<1>(fatigue).data());
    for (int l = 0; l < lanes; ++l) values.push_back(mean[l]);
  });
  return values;
}

std::vector<double> FieldSource::cellwise(const std::string& name, const Snapshot&, int& components) const {
  const Discretisation& d = motion_.discretisation();
  components = cell_field(name)->components;
  if (name == "fatigue") return fatigue_means();
  const std::vector<double>&u = state_.row("u").committed, &history = state_.row("history").committed;
  const StateRow* phi_row = state_.find("phi");
  const StateRow* theta_row = state_.find("theta");
  std::vector<double> values;
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), at = batch.vectors(u);
    std::optional<NodalValues> phi, theta;
    if (phi_row) phi = batch.scalars(phi_row->committed);
    if (theta_row) theta = batch.scalars(theta_row->committed);
    auto points = batch.histories();
    batch.load(history, points);
    MotionInput in;
    in.X = X.data();
    in.u = at.data();
    in.u_n = at.data(); // the stress field leaves the viscous part out: it belongs to a step, not to a state
    in.phi = phi_row ? phi->data() : nullptr;
    in.theta = theta_row ? theta->data() : nullptr;
    in.history = points.data();
    CellOutput out;
    batch.kernels.cell_output(batch.law, in, out);
    const Batch* source = name == "stress"      ? out.stress
                          : name == "von_mises" ? &out.von_mises
                          : name == "pressure"  ? &out.pressure
                                                : &out.alpha;
    for (int k = 0; k < components; ++k)
      for (int l = 0; l < lanes; ++l) values.push_back(source[k][l]);
  });
  return values;
}

} // namespace impact
