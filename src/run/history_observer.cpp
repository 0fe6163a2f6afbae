#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/run/history_observer.hpp>
#include <impact/scenario/columns.hpp>
#include <impact/solve/path_control.hpp>

namespace impact {

bool marks_cycle(double time, double period, int every) {
  const double halves = std::round(2 * time / period);
  if (std::abs(2 * time / period - halves) > 1e-9 * std::max(1.0, halves)) return false;
  return std::llround(std::ceil(halves / 2)) % every == 0;
}

std::string history_file_name(const Scenario& scenario) {
  for (const OutputScenario& output : scenario.outputs)
    if (output.type == OutputScenario::Type::csv) return output.file;
  return "history.csv";
}

HistoryObserver::HistoryObserver(const Scenario& scenario, MotionProblem& motion, const Ledger& ledger,
                                 StateTable& state, const FieldSource& source)
    : scenario_(scenario), motion_(motion), ledger_(ledger), bodies_(state), v_(state.row("v")),
      a_(state.row("a")), phi_(state.find("phi")), load_(state.find(load_parameter_row)), source_(source) {
  if (scenario_.explicit_steps()) {
    every_ = 0;
    dt_ = 1e-3 * scenario_.time.max_time;
  }
  for (const OutputScenario& output : scenario_.outputs)
    if (output.type == OutputScenario::Type::csv) {
      cycles_ = output.cycles;
      every_ = output.every;
      dt_ = output.dt;
      times_ = output.times;
    }
  const Discretisation& d = motion_.discretisation();
  for (std::size_t m = 0; m < d.materials.size(); ++m) {
    const MaterialAssignment& material = d.materials[m];
    if (material.law.parameters.damage == Damage::none) continue;
    const int numbers = numbers_of_crack * scenario_.crack_tips;
    cracks_.push_back({m, {}, state.add({"crack_" + material.id, Support::global, numbers}, at(numbers))});
    for (const std::string& region : material.regions) {
      const std::vector<int> more = d.mesh.nodes(region);
      cracks_.back().nodes.insert(cracks_.back().nodes.end(), more.begin(), more.end());
    }
  }
  for (const ProbeScenario& probe : scenario_.probes)
    for (const std::string& field : probe.fields) source_.require("-probe_" + probe.id + "_fields", field);
  for (const MeasureScenario& measure : scenario_.measures)
    for (const std::string& field : measure.fields)
      source_.require("-measure_" + measure.id + "_fields", field,
                      d.mesh.group(measure.on).dim < d.dim() ? measure.on : "");
  locate_probes();
  find_shares();
}

void HistoryObserver::open(std::optional<long> resume_after, const HistoryFile::Row& columns) {
  const Discretisation& d = motion_.discretisation();
  file_.emplace(
      d.mesh.comm(), scenario_.output_dir + "/" + history_file_name(scenario_), resume_after,
      [units = scenario_.units, plane = d.dim() == 2 && d.frame != Frame::axisymmetric](
          const std::string& column) { return column_unit(column, units, plane); },
      columns);
}

HistoryFile::Row HistoryObserver::row(const Snapshot& snapshot, const StepCounts& counts) {
  HistoryFile::Row row{{"step", static_cast<double>(snapshot.step)},
                       {"time", snapshot.time},
                       {"dt", snapshot.dt},
                       {"tries", snapshot.tries},
                       {"newton", counts.newton},
                       {"linear", counts.linear}};
  if (load_ != nullptr) row.emplace_back("load_parameter", load_->committed[0]);
  if (!motion_.contacts().empty()) {
    row.emplace_back("uzawa", counts.uzawa);
    row.emplace_back("newton_most", counts.longest);
  }
  if (motion_.discretisation().has_damage()) row.emplace_back("damage_its", counts.damage);
  if (motion_.discretisation().has_heat()) row.emplace_back("heat_its", counts.heat);
  if (motion_.discretisation().mass_factor != nullptr)
    row.emplace_back("mass_added", motion_.mass_scaling().added);
  ledger_.append(row);
  append_contacts(row, snapshot);
  ledger_.append_contact_heat(row);
  append_rigid_bodies(row, snapshot);
  ledger_.append_materials(row);
  append_cracks(row, snapshot.time);
  append_probes(row, snapshot);
  append_measures(row, snapshot);
  append_releases(row, snapshot);
  return row;
}

bool HistoryObserver::due(long step, double t, double dt) const {
  if (cycles_ > 0) return marks_cycle(t, scenario_.time.period, cycles_);
  if (step == 0 || (scenario_.time.max_time > 0 && t >= scenario_.time.max_time)) return true;
  if (every_ > 0 && step % every_ == 0) return true;
  const double tolerance = 1e-9 * std::max(std::abs(t), dt);
  for (double time : times_)
    if (time > t - dt + tolerance && time <= t + tolerance) return true;
  const auto count = [this](double time) { return std::floor(time / dt_ * (1 + 1e-12)); };
  return dt_ > 0 && count(t) > count(t - dt);
}

HistoryFile::Row HistoryObserver::watch(const Snapshot& snapshot, const StepCounts& counts) {
  const InStage stage(Stage::output);
  const Timed timed(Event::history);
  HistoryFile::Row now = row(snapshot, counts);
  not_written_.clear();
  if (due(snapshot.step, snapshot.time, snapshot.dt))
    file_->write(now);
  else
    not_written_ = now;
  return now;
}

void HistoryObserver::finish() {
  if (!not_written_.empty()) file_->write(not_written_);
}

} // namespace impact
