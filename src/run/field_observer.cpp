#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/run/field_observer.hpp>

namespace impact {

FieldObserver::FieldObserver(const OutputScenario& output, const Scenario& scenario,
                             const Discretisation& discretisation, const FieldSource& source)
    : scenario_(scenario), settings_(output), d_(discretisation), source_(source) {
  for (const std::string& name : output.fields) source.require("-output_" + output.id + "_fields", name);
  std::ranges::sort(settings_.times);
}

void FieldObserver::open(std::optional<double> resume_after) {
  // Regions are numbered from 1 as the materials name them.
  FieldFile file{scenario_.output_dir + "/" + settings_.file, scenario_.title, scenario_.units.name,
                 resume_after};
  std::vector<std::int64_t> by_point(at(d_.mesh.cell_count()), 0);
  std::int64_t number = 0;
  for (const MaterialAssignment& m : d_.materials)
    for (const std::string& region : m.regions) {
      file.regions += std::to_string(++number) + " " + region + " " + m.id + "\n";
      for (const PetscInt point : d_.mesh.region_cells(region))
        by_point[at(point - d_.mesh.cell_start())] = number;
    }
  for (const CellTable& table : d_.mesh.cells())
    for (const PetscInt point : table.point)
      file.region.push_back(by_point[at(point - d_.mesh.cell_start())]);
  file_.emplace(d_.mesh, file);
  if (!file_->warning().empty()) check(PetscPrintf(d_.mesh.comm(), "impact: %s\n", file_->warning().c_str()));
  if (resume_after && settings_.dt > 0)
    next_time_ = (std::floor(*resume_after / settings_.dt * (1 + 1e-12)) + 1) * settings_.dt;
}

// The last time that is written is asked of the files: a kill after the last checkpoint may have taken the
// output at the end, which the resumed run, though it has no step to take, then makes up for.
void FieldObserver::watch(const Snapshot& snapshot, bool last) {
  const double written = file_->last_time();
  const double t = snapshot.time, tolerance = 1e-9 * std::max(std::abs(t), snapshot.dt);
  bool due = last || (snapshot.step == 0 && written < t);
  if (settings_.every > 0 && snapshot.step % settings_.every == 0) due = true;
  if (settings_.cycles > 0 && marks_cycle(t, scenario_.time.period, settings_.cycles)) due = true;
  for (double time : settings_.times)
    due = due || (time > written + tolerance && time <= t + tolerance && t - time <= snapshot.dt + tolerance);
  if (settings_.dt > 0 && t >= next_time_ - tolerance) {
    due = true;
    while (next_time_ <= t + tolerance) next_time_ += settings_.dt;
  }
  if (!due || t <= written) return;
  const InStage stage(Stage::output);
  const Timed timed(Event::field_output);
  std::vector<Field> fields;
  std::vector<FieldValues> keep;
  keep.reserve(settings_.fields.size());
  for (const std::string& name : settings_.fields) {
    FieldValues& field = keep.emplace_back(source_.values(name, snapshot.u));
    if (!field.nodal) field.values = cells_in_mesh_order(d_.mesh, d_.groups, field.components, field.values);
    fields.push_back({name, field.nodal, field.components, field.values});
  }
  file_->write(t, fields);
}

} // namespace impact
