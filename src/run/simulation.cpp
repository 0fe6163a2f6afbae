#include <algorithm>
#include <impact/petsc/log.hpp>
#include <impact/problem/inside_out.hpp>
#include <impact/run/energy_watch.hpp>
#include <impact/run/field_observer.hpp>
#include <impact/run/history_observer.hpp>
#include <impact/run/limits.hpp>
#include <impact/run/output_folder.hpp>
#include <impact/run/run_checkpoints.hpp>
#include <impact/run/simulation.hpp>
#include <impact/run/stop_requests.hpp>
#include <impact/run/terminal.hpp>
#include <impact/scenario/petsc_options.hpp>
#include <impact/solve/stability.hpp>

namespace impact {

namespace {

/// -test_restep: every step is tried, refused and tried again with the same dt, so that what a refused step
/// leaves behind shows in the results.
class Restep {
public:
  explicit Restep(bool wanted) : wanted_(wanted) {}

  void before_attempt(TS ts) {
    if (repeats_) set_step_control_state(ts, before_repeat_);
  }
  /// Whether an accepted step is to be tried once more.
  bool wants(TS ts, const Verdict& verdict) {
    const bool first = !repeats_;
    repeats_ = false;
    if (!wanted_ || !verdict.accept || !first) return false;
    repeats_ = forced_ = true;
    before_repeat_ = step_control_state(ts);
    return true;
  }
  /// Whether the refusal was its own.
  bool refused() {
    const bool mine = forced_;
    if (!mine) repeats_ = false;
    forced_ = false;
    return mine;
  }

private:
  bool wanted_, repeats_ = false, forced_ = false;
  StepControlState before_repeat_;
};

/// The loop over steps and those who watch them.
// Members beyond twelve: the watchers of accepted steps, each asked once in a step.
class Simulation {
public:
  Simulation(RunStage& stage, const std::optional<Checkpoint>& resume, const StepProbe& probe);
  /// Collective, unless it is a dry run.
  ExitCode run();

private:
  void open(const std::optional<Checkpoint>& resume, const HistoryFile::Row& columns);
  void set_times();
  StepHooks hooks();
  void before_attempt(const Attempt& attempt);
  Verdict judge(const Attempt& attempt, Vec u, Vec v, Vec a);
  bool watches(const Attempt& attempt) const;
  bool asks() const;
  void reject(const Attempt& attempt);
  void accept(const Attempt& attempt);
  void write_fields(bool last);
  void write_checkpoint(const StepControlState& control);
  void save_end(const StepControlState& control);
  TSConvergedReason solve();
  ExitCode report_end(TSConvergedReason reason);
  bool must_be_stable();

  RunStage& stage_;
  const Scenario& s_;
  MPI_Comm comm_;
  EnergyWatch energy_;
  RunCheckpoints checkpoints_;
  HistoryObserver history_;
  std::vector<FieldObserver> fields_;
  Progress progress_;
  UnreadOptions unread_;
  StopRequests requests_;
  StopCriteria stops_;
  StepProbe probe_;
  Restep restep_;
  bool watches_ = true; // the step at work
  Snapshot snapshot_;
  StepControlState control_at_start_; // when the step at work began
  std::string stopped_by_, ended_by_; // from outside, by a criterion of the run
  std::string last_cause_;            // why the last try was refused
};

Simulation::Simulation(RunStage& stage, const std::optional<Checkpoint>& resume, const StepProbe& probe)
    : stage_(stage), s_(stage.scenario), comm_(stage.d.mesh.comm()), energy_(stage), checkpoints_(stage),
      history_(s_, stage.motion, stage.ledger, stage.state, stage.source), progress_(comm_, s_.time.max_time),
      unread_(comm_, s_), requests_({s_.checkpoint.walltime, s_.checkpoint.margin()}), stops_(comm_, s_),
      probe_(probe), restep_(s_.restep) {
  for (const OutputScenario& output : s_.outputs)
    if (output.type == OutputScenario::Type::xdmf) fields_.emplace_back(output, s_, stage.d, stage.source);
  stage.set_state(resume ? &*resume : nullptr);
  if (resume) {
    snapshot_.time = resume->values.time;
    snapshot_.step = resume->values.step;
  }
  snapshot_.u = stage.u;
  report_solvers(stage);
  std::vector<SNES> solvers;
  if (s_.has_motion() && !s_.explicit_steps()) solvers.push_back(stage.coupling.motion_solver().snes());
  if (stage.damage) solvers.push_back(stage.damage->snes());
  if (stage.heat) solvers.push_back(stage.heat->snes());
  tell_idle_options(comm_, s_, solvers);
  const HistoryFile::Row columns = history_.row(snapshot_, {});
  stops_.check_names(columns);
  if (!s_.dry_run) open(resume, columns);
}

// What is in the folder may go: nothing is refused any more, once the history of a run that goes on is known
// to have its columns.
void Simulation::open(const std::optional<Checkpoint>& resume, const HistoryFile::Row& columns) {
  set_earlier_run_aside(comm_, s_, resume ? std::optional(resume->file) : std::nullopt);
  history_.open(resume ? std::optional(resume->values.step) : std::nullopt, columns);
  retire_older_runs(comm_, s_, resume);
  if (resume && history_.every_step() && history_.last_step() < resume->values.step)
    check(PetscPrintf(
        comm_, "impact: %s has no rows up to the checkpoint's step %ld: the rows between are missing\n",
        history_file_name(s_).c_str(), resume->values.step));
  for (FieldObserver& field : fields_) field.open(resume ? std::optional(resume->values.time) : std::nullopt);
  if (resume) {
    stage_.resume();
    checkpoints_.resume(*resume, stops_);
  } else {
    stage_.start();
    stops_.ask(history_.watch(snapshot_, {}));
    write_fields(false);
  }
  set_times();
  set_step_hooks(stage_.ts, hooks());
}

void Simulation::set_times() {
  std::vector<double> exact_times;
  for (const OutputScenario& output : s_.outputs)
    exact_times.insert(exact_times.end(), output.times.begin(), output.times.end());
  set_exact_times(stage_.ts, std::move(exact_times));
  if (s_.time.period > 0) set_step_period(stage_.ts, s_.time.period);
  if (!s_.time.table_times.empty()) set_step_table(stage_.ts, s_.time.table_times, s_.time.table_dts);
}

StepHooks Simulation::hooks() {
  StepHooks hooks = stage_.hooks();
  hooks.before_attempt = [this](TS, const Attempt& attempt) { before_attempt(attempt); };
  hooks.accept = [this](TS, const Attempt& attempt, Vec u, Vec v, Vec a) { return judge(attempt, u, v, a); };
  hooks.on_reject = [this](TS, const Attempt& attempt) { reject(attempt); };
  hooks.on_accept = [this](TS, const Attempt& attempt) { accept(attempt); };
  return hooks;
}

void Simulation::before_attempt(const Attempt& attempt) {
  restep_.before_attempt(stage_.ts);
  if (attempt.number == 1) control_at_start_ = step_control_state(stage_.ts);
  stage_.check_prescribed_data(attempt);
  stage_.coupling.before_attempt(attempt);
  if (probe_.before) probe_.before(attempt, snapshot_.step + 1, stage_.state);
}

// Explicit steps are many and each of them is cheap: energies and columns are found where someone reads them.
bool Simulation::watches(const Attempt& attempt) const {
  const long step = snapshot_.step + 1;
  return !s_.explicit_steps() || !s_.stops.empty() || step == s_.time.max_steps ||
         history_.due(step, attempt.t, attempt.dt);
}

// Of explicit steps not after each one, but when a checkpoint is due by their number.
bool Simulation::asks() const {
  constexpr long steps = 16;
  const long every = s_.checkpoint.every;
  return !s_.explicit_steps() || watches_ || snapshot_.step % steps == 0 ||
         (every > 0 && snapshot_.step % every == 0);
}

Verdict Simulation::judge(const Attempt& attempt, Vec u, Vec v, Vec a) {
  const double before = stage_.ledger.energy_error();
  const bool watched = watches_ = watches(attempt);
  stage_.ledger.book(stage_.coupling.record(u), u, v, stage_.inertia ? a : stage_.a.get(), watched);
  Verdict verdict = watched ? energy_.judge(before, attempt) : Verdict{};
  verdict.agreed = true; // sums of all ranks say so
  if (!restep_.wants(stage_.ts, verdict)) return verdict;
  stage_.ledger.unbook();
  return {false, 1.0, true};
}

void Simulation::reject(const Attempt& attempt) {
  if (probe_.after) probe_.after(attempt, snapshot_.step + 1, stage_.state);
  if (!restep_.refused()) {
    last_cause_ = stage_.coupling.failure_text();
    if (last_cause_.empty()) last_cause_ = "step refused";
    check(PetscPrintf(comm_, "impact: %s, step %ld try %d at t = %.10g, dt = %.4g; time step cut\n",
                      last_cause_.c_str(), snapshot_.step + 1, static_cast<int>(attempt.number), attempt.t,
                      attempt.dt));
  }
  stage_.coupling.reject();
}

void Simulation::accept(const Attempt& attempt) {
  if (const std::string text = stage_.coupling.crack_text(); !text.empty())
    check(PetscPrintf(comm_, "impact: step %ld: %s\n", snapshot_.step + 1, text.c_str()));
  stage_.accept(attempt, watches_ || !fields_.empty());
  if (stage_.erosion.on() && stage_.erosion.worth_telling())
    check(PetscPrintf(comm_, "impact: step %ld: %s\n", snapshot_.step + 1, stage_.erosion.text().c_str()));
  if (probe_.after) probe_.after(attempt, snapshot_.step + 1, stage_.state);
  snapshot_.step += 1;
  snapshot_.time = attempt.t;
  snapshot_.dt = attempt.dt;
  snapshot_.tries = static_cast<int>(attempt.number);
  check(TS2GetSolution(stage_.ts, &snapshot_.u, nullptr));
  const StepCounts counts = stage_.coupling.counts();
  const bool watched = watches_;
  const HistoryFile::Row columns = watched ? history_.watch(snapshot_, counts) : HistoryFile::Row{};
  write_fields(false);
  if (watched) progress_.line(snapshot_, counts, stage_.ledger, stage_.setup->contacts.active(snapshot_.u));
  std::vector<std::string> solved;
  if (counts.linear > 0) solved.emplace_back("motion");
  if (counts.damage_linear > 0) solved.emplace_back("damage");
  if (counts.heat_linear > 0) solved.emplace_back("heat");
  unread_.judge(solved);
  StopRequest request;
  if (asks()) request = requests_.ask(comm_, checkpoints_.due(snapshot_.step, progress_.wall()));
  if (watched) ended_by_ = stops_.ask(columns);
  stopped_by_ = request.stop;
  if (request.checkpoint || !ended_by_.empty()) write_checkpoint(step_control_state(stage_.ts));
  if (!stopped_by_.empty() || !ended_by_.empty()) check(TSSetConvergedReason(stage_.ts, TS_CONVERGED_USER));
}

// A full disk costs field output, not the run.
void Simulation::write_fields(bool last) {
  for (FieldObserver& field : fields_) {
    try {
      field.watch(snapshot_, last);
    } catch (const UserError& error) {
      if (error.code() != ExitCode::io) throw;
      check(PetscPrintf(comm_, "impact: %s; the run goes on without this output at t = %.10g\n", error.what(),
                        snapshot_.time));
    }
  }
}

void Simulation::write_checkpoint(const StepControlState& control) {
  requests_.note_checkpoint(checkpoints_.write(snapshot_, control, stops_, progress_.wall()));
}

// However a run ends, another one can go on from there. After a failure that is the state before the step,
// without the cuts of dt, which belong to the failed tries.
void Simulation::save_end(const StepControlState& control) {
  try {
    if (checkpoints_.step() != snapshot_.step) write_checkpoint(control);
    if (stopped_by_.empty() && ended_by_.empty())
      check(PetscPrintf(comm_, "the state at t = %.10g, step %ld, is in %s\n", snapshot_.time, snapshot_.step,
                        checkpoints_.file().c_str()));
  } catch (const UserError& error) {
    check(PetscPrintf(comm_, "impact: %s\n", error.what()));
  }
}

TSConvergedReason Simulation::solve() {
  TSConvergedReason reason = TS_CONVERGED_USER;
  if (!stopped_by_.empty()) return reason;
  try {
    const InStage steps(Stage::steps);
    solve_in_time(stage_.ts);
    check(TSGetConvergedReason(stage_.ts, &reason));
  } catch (const UserError& error) {
    if (error.code() == ExitCode::solver || error.code() == ExitCode::data) save_end(control_at_start_);
    throw;
  }
  return reason;
}

ExitCode Simulation::run() {
  if (s_.dry_run) {
    check(PetscPrintf(comm_, "%s\ndry run: the input is complete\n", print_scenario(s_, true).c_str()));
    return ExitCode::ok;
  }
  progress_.header();
  stopped_by_ = requests_.ask(comm_, false).stop; // since the program began
  control_at_start_ = step_control_state(stage_.ts);
  const TSConvergedReason reason = solve();
  if (!ended_by_.empty()) history_.finish(); // the row that met the condition
  if (reason == TS_CONVERGED_ITS && !(s_.time.max_time > 0 && snapshot_.time >= s_.time.max_time))
    ended_by_ = "-ts_max_steps " + std::to_string(s_.time.max_steps);
  // The last state of a run that goes on later is no output of its own.
  if (stopped_by_.empty()) write_fields(true);
  save_end(reason > 0 ? step_control_state(stage_.ts) : control_at_start_);
  return report_end(reason);
}

// Where factors are cheap, or the last linear solve was of an indefinite matrix. Cracks follow their branch
// by themselves.
bool Simulation::must_be_stable() {
  MotionSolver& solver = stage_.coupling.motion_solver();
  const Mesh& mesh = stage_.d.mesh;
  const bool cheap = is_factorised(mesh) || (solver.hooks().conduct.indefinite && can_be_factorised(mesh));
  return cheap && stage_.solver.half_suffices && !stage_.inertia && s_.coupling.moves &&
         !stage_.d.has_damage() && solver.loose().empty();
}

ExitCode Simulation::report_end(TSConvergedReason reason) {
  if (!watches_) stage_.ledger.resume(stage_.u, stage_.v);
  check(PetscPrintf(comm_, "%s at t = %.10g after %ld steps in %s; energy balance %.2e, first law %.2e\n",
                    !stopped_by_.empty() ? "stopped by request"
                    : !ended_by_.empty() ? "stopped"
                    : reason > 0         ? "finished"
                                         : "gave up",
                    snapshot_.time, snapshot_.step, Progress::clock(progress_.wall()).c_str(),
                    stage_.ledger.balance(), stage_.ledger.balance_first_law()));
  check(PetscPrintf(comm_, "%s", stage_.ledger.report().c_str()));
  energy_.report_end(snapshot_.time);
  check(PetscPrintf(comm_, "%s", tell_of_inside_out(stage_.d, stage_.u).c_str()));
  if (const ArcLength* path = stage_.coupling.motion_solver().arc_length();
      stopped_by_.empty() && must_be_stable())
    check(PetscPrintf(
        comm_, "%s",
        tell_of_instability(stage_.motion, stage_.u, path != nullptr, path && path->falls()).c_str()));
  if (const long ways = stage_.coupling.motion_solver().counts().second_ways; ways > 0)
    check(PetscPrintf(comm_, "  motion solves repeated another way        %ld\n", ways));
  if (const double part = stage_.damage ? stage_.damage->held_back() : 0; part > 1e-3)
    check(PetscPrintf(comm_, "  part of the growth of damage that is held back (-damage_substeps)  %.2g\n",
                      part));
  const char* file = checkpoints_.file().c_str();
  if (!stopped_by_.empty())
    check(PetscPrintf(comm_, "stopped by request (%s); -restart auto goes on from %s\n", stopped_by_.c_str(),
                      file));
  if (!ended_by_.empty())
    check(PetscPrintf(comm_, "stopped by %s; the state is in %s\n", ended_by_.c_str(), file));
  if (reason > 0) return ExitCode::ok;
  check(PetscFPrintf(comm_, PETSC_STDERR, "impact: the step could not be solved (%s): %s\n",
                     TSConvergedReasons[reason],
                     last_cause_.empty() ? "no solution at any length" : last_cause_.c_str()));
  tell_of_limits(stage_, last_cause_, snapshot_.u);
  return ExitCode::solver;
}

} // namespace

ExitCode simulate(MPI_Comm comm, const Scenario& s, const StepProbe& probe) {
  std::optional<InStage> starts(Stage::setup);
  if (!s.mesh.convert.empty()) {
    convert_mesh(comm, s);
    return ExitCode::ok;
  }
  std::optional<FolderLock> output, checkpoints;
  if (!s.dry_run) {
    output.emplace(comm, "output_dir", s.output_dir);
    if (s.checkpoint.dir != default_checkpoint_dir(s) && s.checkpoint.dir != s.output_dir)
      checkpoints.emplace(comm, "checkpoint_dir", s.checkpoint.dir);
  }
  const std::optional<Checkpoint> resume = find_checkpoint(comm, s);
  std::optional<GmshFile> kept; // a changed or missing file, or another gmsh, changes nothing on a restart
  if (resume) kept = read_checkpoint_mesh_file(comm, *resume);
  RunStage stage(comm, s, std::move(kept));
  Simulation run(stage, resume, probe);
  starts.reset();
  return run.run();
}

} // namespace impact
