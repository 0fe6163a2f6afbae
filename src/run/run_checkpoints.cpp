#include <filesystem>
#include <impact/input/option_text.hpp>
#include <impact/petsc/log.hpp>
#include <impact/run/run_checkpoints.hpp>

namespace impact {

namespace {

/// The line of the checksum of a file on rank 0; none for one that is not there.
std::string content_line(MPI_Comm comm, const std::string& key, const std::string& file) {
  std::string sum;
  on_rank_zero(comm, [&] {
    std::uintmax_t size = 0;
    std::error_code none;
    if (std::filesystem::exists(file, none)) sum = to_hex(file_checksum(file, size));
  });
  sum = broadcast(comm, sum);
  return sum.empty() ? "" : option_line(key, sum);
}

/// The options of a run as a checkpoint holds them, one `-key value` per line: print_scenario, PETSc's
/// options that choose the time scheme, and the checksums of the mesh and of tables (as `-mesh_content`,
/// `-function_<id>_content` and `-material_<id>_hardening_content`). Collective.
std::string restart_options(MPI_Comm comm, const Scenario& scenario) {
  std::string lines = print_scenario(scenario);
  for (const std::string& typed : option_names()) {
    const std::string name = lower_case(typed);
    const bool chooses_scheme = name.starts_with("ts_newmark_") || name.starts_with("damage_ts_");
    if (const auto text = chooses_scheme ? option_text(typed) : std::nullopt)
      lines += option_line(name, *text);
  }
  lines += content_line(comm, "mesh_content", scenario.mesh.file);
  for (const FunctionScenario& function : scenario.functions)
    lines += content_line(comm, "function_" + function.id + "_content", function.file);
  for (const MaterialScenario& material : scenario.materials)
    for (const auto& [name, table] :
         {std::pair("hardening", material.hardening_table), std::pair("Gc_rate", material.rate_table),
          std::pair("Gc_temperature", material.temperature_table)})
      if (!table.empty())
        lines += content_line(comm, "material_" + material.id + "_" + name + "_content", table);
  return lines;
}

// An end that the checkpoint has passed already.
void check_end(const Checkpoint& resume, const Scenario& s) {
  const CheckpointValues& at = resume.values;
  const bool steps = s.time.max_steps > 0 && at.step > s.time.max_steps;
  if (!steps && !(s.time.max_time > 0 && at.time > s.time.max_time * (1 + 1e-12))) return;
  throw UserError(ExitCode::usage,
                  (steps ? "-ts_max_steps " + std::to_string(s.time.max_steps)
                         : "-ts_max_time " + number_text(s.time.max_time)) +
                      ": checkpoint " + resume.file + " is at t = " + number_text(at.time) + ", step " +
                      std::to_string(at.step) +
                      "; give an end behind it, name an earlier checkpoint, or start anew without -restart");
}

} // namespace

std::optional<Checkpoint> find_checkpoint(MPI_Comm comm, const Scenario& s) {
  std::optional<Checkpoint> resume;
  const std::string now = restart_options(comm, s);
  if (s.checkpoint.restart == "auto")
    resume = newest_checkpoint(comm, s.checkpoint.dir);
  else if (s.checkpoint.restart != "none")
    resume = open_checkpoint(comm, s.checkpoint.restart);
  if (!resume) {
    check_restart_options(now, now, s.checkpoint.restart_allow,
                          ""); // a misspelt entry shows at the first start
    if (s.checkpoint.restart == "auto")
      check(PetscPrintf(comm,
                        "impact: -restart auto: no finished checkpoint in %s; the run starts at t = 0\n",
                        s.checkpoint.dir.c_str()));
    return resume;
  }
  for (const std::string& warning : resume->warnings)
    check(PetscPrintf(comm, "impact: %s\n", warning.c_str()));
  const auto options = resume->values.texts.find("options");
  if (options == resume->values.texts.end())
    throw UserError(ExitCode::io, "cannot use checkpoint " + resume->file +
                                      ": it does not hold the options of its run; restart from another one");
  for (const std::string& note :
       check_restart_options(options->second, now, s.checkpoint.restart_allow, resume->file))
    check(PetscPrintf(comm, "impact: %s\n", note.c_str()));
  check_end(*resume, s);
  return resume;
}

void retire_older_runs(MPI_Comm comm, const Scenario& s, const std::optional<Checkpoint>& resume) {
  if (s.checkpoint.restart == "auto") return;
  const int count = retire_checkpoints(comm, s.checkpoint.dir, resume ? resume->file : "");
  if (count > 0)
    check(
        PetscPrintf(comm,
                    "impact: %d checkpoint%s of an earlier run in %s no longer count%s (manifests renamed to "
                    ".manifest.old)\n",
                    count, count == 1 ? "" : "s", s.checkpoint.dir.c_str(), count == 1 ? "s" : ""));
}

RunCheckpoints::RunCheckpoints(RunStage& stage)
    : stage_(stage), control_(stage.state.add({"step_control", Support::global, 4}, 4)),
      writer_({stage.d.mesh, stage.d.groups, stage.state, &stage.setup->file},
              {stage.scenario.checkpoint.dir, stage.scenario.checkpoint.keep,
               stage.scenario.checkpoint.patience}) {}

void RunCheckpoints::resume(const Checkpoint& from, StopCriteria& stops) {
  const MPI_Comm comm = stage_.d.mesh.comm();
  file_ = from.file;
  if (stage_.scenario.checkpoint.restart == "auto") step_ = from.values.step;
  const std::vector<double>& c = control_.committed;
  if (!stage_.other_scheme)
    set_step_control_state(stage_.ts,
                           {c[0], c[1] != 0, static_cast<PetscInt>(c[2]), static_cast<PetscInt>(c[3])});
  for (const std::string& peak : stops.restore(from.values))
    check(PetscPrintf(comm, "impact: %s does not know peak(%s): it is counted from here on\n", file_.c_str(),
                      peak.c_str()));
  check(PetscPrintf(comm, "resumed from %s at t = %.10g, step %ld\n", file_.c_str(), from.values.time,
                    from.values.step));
}

bool RunCheckpoints::due(long step, double wall) const {
  const auto& wanted = stage_.scenario.checkpoint;
  return (wanted.every > 0 && step % wanted.every == 0) || (wanted.wall > 0 && wall - wall_ >= wanted.wall);
}

double RunCheckpoints::write(const Snapshot& at, const StepControlState& c, const StopCriteria& stops,
                             double wall) {
  const InStage output(Stage::output);
  const Timed timed(Event::checkpoint_write);
  const MPI_Comm comm = stage_.d.mesh.comm();
  const double start = MPI_Wtime();
  control_.committed = control_.trial = {c.dt, c.at_limit ? 1.0 : 0.0, static_cast<double>(c.easy_steps),
                                         static_cast<double>(c.rejections)};
  CheckpointValues values{at.time, at.step, {}};
  values.texts["options"] = restart_options(comm, stage_.scenario);
  stops.store(values);
  char version[256] = "";
  check(PetscGetVersion(version, sizeof version));
  values.texts["petsc_version"] = version;
  file_ = writer_.write(values);
  stage_.forget_what_a_restart_lacks();
  step_ = at.step;
  const double seconds = MPI_Wtime() - start;
  wall_ = wall + seconds;
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(file_, unknown);
  check(PetscPrintf(comm, "checkpoint %s: %lld bytes in %.3f s\n", file_.c_str(),
                    static_cast<long long>(bytes), seconds));
  return seconds;
}

} // namespace impact
