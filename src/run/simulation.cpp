#include <algorithm>
#include <cmath>
#include <filesystem>
#include <impact/balance/ledger.hpp>
#include <impact/input/option_text.hpp>
#include <impact/io/checkpoint.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/run/observers.hpp>
#include <impact/run/output_folder.hpp>
#include <impact/run/progress.hpp>
#include <impact/run/restart_options.hpp>
#include <impact/run/setup.hpp>
#include <impact/run/simulation.hpp>
#include <impact/run/stop_criteria.hpp>
#include <impact/run/stop_requests.hpp>
#include <impact/scenario/petsc_options.hpp>
#include <impact/scenario/restart_keys.hpp>
#include <impact/solve/coupling.hpp>
#include <impact/time/step_control.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

// The checkpoint to go on from, its options checked against those of this run.
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
  const CheckpointValues& at = resume->values;
  const bool steps = s.time.max_steps > 0 && at.step > s.time.max_steps;
  if (steps || (s.time.max_time > 0 && at.time > s.time.max_time * (1 + 1e-12)))
    throw UserError(
        ExitCode::usage,
        (steps ? "-ts_max_steps " + std::to_string(s.time.max_steps)
               : "-ts_max_time " + number_text(s.time.max_time)) +
            ": checkpoint " + resume->file + " is at t = " + number_text(at.time) + ", step " +
            std::to_string(at.step) +
            "; give an end behind it, name an earlier checkpoint, or start anew without -restart");
  return resume;
}

// What an earlier run left must not be taken for what this one has computed.
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

bool conserves(const Scenario& s) {
  return std::any_of(s.contacts.begin(), s.contacts.end(), [](const ContactSettings& contact) {
    return contact.impact == ImpactUpdate::conserving;
  });
}

// The contact-stabilised update is for all that has inertia and stiffness, at any length of the steps.
bool stabilises(MPI_Comm comm, const Scenario& s, const SolverDefaults& solver) {
  if (s.contacts.empty() || !s.has_inertia()) return false;
  const bool conserve = conserves(s), automatic = solver.cfl > 0 && !conserve;
  const bool stabilise = std::any_of(s.contacts.begin(), s.contacts.end(), [&](const ContactSettings& c) {
    return c.impact == ImpactUpdate::stabilised || (c.impact == ImpactUpdate::automatic && automatic);
  });
  check(PetscPrintf(comm, "impact update: %s (dt is %.3g times h/c_p)\n",
                    stabilise        ? "contact-stabilised"
                    : conserve       ? "energy-conserving"
                    : solver.cfl > 0 ? "none, as asked"
                                     : "none: nothing has a stiffness",
                    solver.cfl));
  return stabilise;
}

Handle<TS> make_integrator(MPI_Comm comm, const Scenario& s) {
  Handle<TS> ts;
  check(TSCreate(comm, ts.out()));
  check(TSSetProblemType(ts, TS_NONLINEAR));
  check(TSSetType(ts, s.has_motion() ? s.time.type.c_str() : "static"));
  check(TSSetTimeStep(ts, s.time.dt));
  if (s.time.max_time > 0) check(TSSetMaxTime(ts, s.time.max_time));
  check(TSSetMaxSteps(ts, s.time.max_steps > 0 ? s.time.max_steps : PETSC_MAX_INT));
  return ts;
}

// So many steps in a row beyond -energy_tol or -energy_stop are no start of a run.
constexpr int steps_beyond = 5;

// The objects of a run in the order in which they depend on each other.
class Simulation {
public:
  Simulation(MPI_Comm comm, const Scenario& s, Setup& setup, const SolverDefaults& solver,
             const std::optional<Checkpoint>& resume, const StepProbe& probe);
  ExitCode run();

private:
  void start_state(const std::optional<Checkpoint>& resume);
  void report_start(const SolverDefaults& solver);
  void start(const std::optional<Checkpoint>& resume);
  StepHooks hooks();
  void accept(const Attempt& attempt);
  void reject(const Attempt& attempt);
  void before_attempt(const Attempt& attempt);
  void check_prescribed_data(const Attempt& attempt) const;
  Verdict judge(const Attempt& attempt, Vec u, Vec v, Vec a);
  Verdict judge_energy(const Attempt& attempt, Vec u, Vec v, Vec a);
  bool must_close(double residual) const;
  std::string energy_text(double residual, double t, const char* option) const;
  std::string energy_remedy(double residual) const;
  void write_fields(bool last);
  void obey(const StopRequest& request);
  void write_state(const StepControlState& c);
  void save_end(const StepControlState& control);
  bool checkpoint_is_due() const;
  int active_points();

  MPI_Comm comm_;
  const Scenario& s_;
  Setup& setup_;
  const Discretisation& d_;
  bool inertia_;
  MotionProblem motion_;
  std::optional<DamageProblem> damage_;
  std::optional<HeatProblem> heat_;
  Handle<TS> ts_;
  Coupling coupling_;
  std::optional<Ledger> ledger_;
  FieldSource source_;
  StateRow *control_, *watch_; // watch_: steps in a row beyond -energy_tol, -energy_stop
  std::optional<HistoryObserver> history_;
  std::vector<FieldObserver> fields_;
  Handle<Vec> u_, v_, a_;
  Progress progress_;
  Snapshot snapshot_;
  double last_checkpoint_ = 0;                          // on the clock
  long saved_step_ = -1;                                // of checkpoint_file_
  std::string checkpoint_file_, stopped_by_, ended_by_; // from outside, by a criterion of the run
  std::string last_cause_;                              // why the last try was refused
  std::string energy_warning_;                          // the first one
  double least_energy_ = 0; // of bodies strained by 1e-7: below it the first law is one of rounding errors
  UnreadOptions unread_;
  StopRequests requests_;
  StopCriteria stops_;
  CheckpointWriter checkpoints_;
  StepProbe probe_;
  // -test_restep: every step is tried, refused and tried again with the same dt.
  bool restep_ = false, repeats_ = false, forced_ = false;
  StepControlState control_before_repeat_, control_at_start_;
};

Simulation::Simulation(MPI_Comm comm, const Scenario& s, Setup& setup, const SolverDefaults& solver,
                       const std::optional<Checkpoint>& resume, const StepProbe& probe)
    : comm_(comm), s_(s), setup_(setup), d_(setup.discretisation), inertia_(s.has_inertia()),
      motion_(d_, setup.state, setup.boundary, setup.contacts, solver.symmetric, s.contact_operator,
              solver.matrix, &setup.rigid, s.has_motion()),
      damage_(d_.has_damage()
                  ? std::optional<DamageProblem>(std::in_place, d_, setup.state, setup.boundary, s.damage)
                  : std::nullopt),
      heat_(d_.has_heat() ? std::optional<HeatProblem>(std::in_place, d_, setup.state, setup.boundary, s.heat,
                                                       s.has_motion(), &setup.contacts)
                          : std::nullopt),
      ts_(make_integrator(comm, s)),
      coupling_(ts_, {motion_, damage_ ? &*damage_ : nullptr, heat_ ? &*heat_ : nullptr, setup.state},
                s.coupling, solver, stabilises(comm, s, solver)),
      source_(motion_, setup.state), u_(d_.displacement.make_global()), v_(d_.displacement.make_global()),
      a_(d_.displacement.make_global()), progress_(comm, s.time.max_time), unread_(comm, s),
      requests_({s.checkpoint.walltime, s.checkpoint.margin()}), stops_(comm, s),
      checkpoints_({d_.mesh, d_.groups, setup.state, &setup.file},
                   {s.checkpoint.dir, s.checkpoint.keep, s.checkpoint.patience}),
      probe_(probe), restep_(s.restep) {
  least_energy_ = 1e-2 * motion_.reference_force() * d_.mesh.smallest_edge() * d_.thickness *
                  static_cast<double>(d_.mesh.global_cell_count());
  for (const ContactInterface& contact : setup.contacts)
    if (coupling_.stabilised() && between_rigid_sides(setup, contact.settings()))
      throw UserError(ExitCode::usage,
                      "-contact_" + contact.id() +
                          "_impact: the contact-stabilised update leaves the speed of what touches to its "
                          "stress, and both sides of this contact are rigid; take -contact_" +
                          contact.id() + "_impact conserving, or none for every contact");
  set_time_options(ts_);
  if (const Integrator& p = integrator_of(ts_);
      inertia_ && conserves(s) && (p.alpha_m != 1 || p.beta != 0.25 || p.gamma != 0.5))
    throw UserError(ExitCode::usage, "-ts_newmark_rho: the energy-conserving contact update "
                                     "(-contact_<id>_impact conserving) is for the trapezoidal rule; take "
                                     "-ts_newmark_rho 1");
  ledger_.emplace(motion_, setup_.state, inertia_, s.has_motion(),
                  LedgerChoice{s.history_materials, s.coupling.report_error, coupling_.unilateral()});
  StateRow control{"step_control", Support::global, 4};
  control_ = &setup_.state.add(std::move(control), 4);
  watch_ = &setup_.state.add({"energy_watch", Support::global, 2}, 2);
  std::optional<double> resume_time;
  std::optional<long> resume_step;
  if (resume) {
    resume_time = resume->values.time;
    resume_step = resume->values.step;
  }
  history_.emplace(s, motion_, *ledger_, setup_.state, source_);
  for (const OutputScenario& output : s.outputs)
    if (output.type == OutputScenario::Type::xdmf) fields_.emplace_back(output, s, d_, source_);
  start_state(resume);
  report_start(solver);
  stops_.check_names(history_->row(snapshot_, {}));
  if (s.dry_run) return;
  // Nothing is refused any more: what is in the folder may go.
  set_earlier_run_aside(comm, s, resume ? std::optional(resume->file) : std::nullopt);
  retire_older_runs(comm, s, resume);
  history_->open(resume_step);
  if (resume && history_->every_step() && history_->last_step() < resume->values.step)
    check(PetscPrintf(
        comm, "impact: %s has no rows up to the checkpoint's step %ld: the rows between are missing\n",
        history_file_name(s).c_str(), resume->values.step));
  for (FieldObserver& field : fields_) field.open(resume_time);
  std::vector<double> exact_times;
  for (const OutputScenario& output : s.outputs)
    if (output.type == OutputScenario::Type::xdmf)
      exact_times.insert(exact_times.end(), output.times.begin(), output.times.end());
  start(resume);
  set_exact_times(ts_, std::move(exact_times));
  if (s.time.period > 0) set_step_period(ts_, s.time.period);
  if (!s.time.table_times.empty()) set_step_table(ts_, s.time.table_times, s.time.table_dts);
  set_step_hooks(ts_, hooks());
}

void Simulation::start_state(const std::optional<Checkpoint>& resume) {
  StateTable& state = setup_.state;
  if (resume) {
    read_checkpoint(*resume, {d_.mesh, d_.groups, state});
    check(TSSetTime(ts_, resume->values.time));
    check(TSSetStepNumber(ts_, static_cast<PetscInt>(resume->values.step)));
    snapshot_.time = resume->values.time;
    snapshot_.step = resume->values.step;
    if (s_.checkpoint.restart == "auto") saved_step_ = snapshot_.step;
    checkpoint_file_ = resume->file;
  } else {
    set_initial_state(s_, setup_);
  }
  d_.displacement.to_global(state.row("u").committed, u_);
  d_.displacement.to_global(state.row("v").committed, v_);
  d_.displacement.to_global(state.row("a").committed, a_);
  check(TS2SetSolution(ts_, u_, v_));
  snapshot_.u = u_;
  motion_.update_contact(u_);
  coupling_.motion_solver().refresh_matrix();
  coupling_.begin_between_steps(snapshot_.time, u_, v_);
}

// What really solves, and where contact begins.
void Simulation::report_start(const SolverDefaults& solver) {
  for (ContactInterface& contact : setup_.contacts) {
    const ContactMeasures at = contact.measures(u_);
    check(PetscPrintf(comm_,
                      std::isnan(at.gap_min)
                          ? "contact %s: no point faces the other side at the start\n"
                          : "contact %s: smallest gap at the start %.4g, %d points press\n",
                      contact.id().c_str(), at.gap_min, at.active));
  }
  std::vector<std::string> lines;
  if (s_.has_motion())
    lines.push_back("motion solver: " + linear_solver_text(coupling_.motion_solver().snes()) + " (" +
                    solver.reason + "); tangent " + (solver.symmetric ? "symmetric" : "consistent") +
                    (solver.matrix == MatrixFormat::sbaij ? ", its upper half" : ""));
  if (damage_) lines.push_back("damage solver: " + linear_solver_text(damage_->snes()));
  if (heat_) lines.push_back("heat solver: " + linear_solver_text(heat_->snes()));
  PetscBool factors = PETSC_FALSE;
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(SNESGetKSP(coupling_.motion_solver().snes(), &ksp));
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factors, PCLU, PCCHOLESKY, ""));
  report_solvers(d_, lines, s_.has_motion() && factors);
}

void Simulation::start(const std::optional<Checkpoint>& resume) {
  StateTable& state = setup_.state;
  if (resume) {
    if (inertia_) set_acceleration(ts_, a_);
    const std::vector<double>& c = control_->committed;
    set_step_control_state(ts_, {c[0], c[1] != 0, static_cast<PetscInt>(c[2]), static_cast<PetscInt>(c[3])});
    ledger_->resume(u_, v_);
    // Lists of candidates made so far would serve for a while, but they are not those that the interrupted
    // run made in its next step.
    setup_.contacts.forget_search();
    for (const std::string& peak : stops_.restore(resume->values))
      check(PetscPrintf(comm_, "impact: %s does not know peak(%s): it is counted from here on\n",
                        resume->file.c_str(), peak.c_str()));
    check(PetscPrintf(comm_, "resumed from %s at t = %.10g, step %ld\n", resume->file.c_str(), snapshot_.time,
                      snapshot_.step));
    return;
  }
  coupling_.start(u_, a_);
  if (inertia_) d_.displacement.to_local(a_, state.row("a").trial);
  setup_.contacts.advance(u_, u_, 0);
  PetscReal dt = 0;
  check(TSGetTimeStep(ts_, &dt));
  ledger_->start(integrator_of(ts_), dt, u_, v_, a_);
  state.commit();
  stops_.ask(history_->watch(snapshot_, {}));
  write_fields(false);
}

StepHooks Simulation::hooks() {
  StepHooks hooks;
  hooks.before_attempt = [this](TS, const Attempt& attempt) { before_attempt(attempt); };
  if (coupling_.stabilised())
    hooks.predict = [this](TS, const Attempt& attempt, Vec u, Vec v) { coupling_.predict(attempt, u, v); };
  if (inertia_ && coupling_.corrects())
    hooks.correct = [this](TS, Vec u, Vec v, Vec a) { coupling_.correct(u, v, a); };
  hooks.guess = [this](TS, const Attempt& attempt, Vec guess) { coupling_.guess(attempt, guess); };
  hooks.effort = [this](TS) { return coupling_.counts().hardest; };
  const CouplingScenario& limits = s_.coupling;
  if (limits.max_dphi > 0 || limits.max_dalpha > 0 || limits.max_dtheta > 0)
    hooks.utilisation = [this](TS) { return coupling_.utilisation(); };
  hooks.accept = [this](TS, const Attempt& attempt, Vec u, Vec v, Vec a) { return judge(attempt, u, v, a); };
  hooks.on_reject = [this](TS, const Attempt& attempt) { reject(attempt); };
  hooks.on_accept = [this](TS, const Attempt& attempt) { accept(attempt); };
  return hooks;
}

// A user's expression may lack a value at the nodes of some ranks alone: tried out where all of them can
// agree.
void Simulation::check_prescribed_data(const Attempt& attempt) const {
  const BoundaryData& boundary = setup_.boundary;
  const StateTable& state = setup_.state;
  const std::vector<double>& v_n = state.row("prescribed_velocity").committed;
  std::vector<double> unused = state.row("u").committed;
  agree_on_errors(comm_, [&] {
    setup_.rigid.require_agreement(attempt.t_n, attempt.t);
    boundary.require_agreement(attempt.t_n, attempt.t, state.row("u").committed, v_n);
    boundary.set_displacement(attempt.t_n, attempt.t, state.row("u").committed, v_n, unused);
    boundary.set_exact_velocity(attempt.t_n, attempt.t, v_n, unused);
    if (const StateRow* phi = state.find("phi")) {
      unused = phi->committed;
      boundary.set_damage(attempt.t, unused);
    }
    if (const StateRow* theta = state.find("theta")) {
      unused = theta->committed;
      boundary.set_temperature(attempt.t, unused);
    }
  });
}

void Simulation::before_attempt(const Attempt& attempt) {
  if (repeats_) set_step_control_state(ts_, control_before_repeat_);
  if (attempt.number == 1) control_at_start_ = step_control_state(ts_);
  check_prescribed_data(attempt);
  coupling_.before_attempt(attempt);
  if (probe_.before) probe_.before(attempt, snapshot_.step + 1, setup_.state);
}

void Simulation::reject(const Attempt& attempt) {
  if (probe_.after) probe_.after(attempt, snapshot_.step + 1, setup_.state);
  if (forced_) {
    forced_ = false;
    coupling_.reject();
    return;
  }
  repeats_ = false;
  last_cause_ = coupling_.failure_text();
  if (last_cause_.empty()) last_cause_ = "step refused";
  check(PetscPrintf(comm_, "impact: %s, step %ld try %d at t = %.10g, dt = %.4g; time step cut\n",
                    last_cause_.c_str(), snapshot_.step + 1, static_cast<int>(attempt.number), attempt.t,
                    attempt.dt));
  coupling_.reject();
}

Verdict Simulation::judge(const Attempt& attempt, Vec u, Vec v, Vec a) {
  const bool first = !repeats_;
  repeats_ = false;
  const Verdict verdict = judge_energy(attempt, u, v, a);
  if (!restep_ || !verdict.accept || !first) return verdict;
  ledger_->unbook();
  repeats_ = forced_ = true;
  control_before_repeat_ = step_control_state(ts_);
  return {false, 1.0};
}

Verdict Simulation::judge_energy(const Attempt& attempt, Vec u, Vec v, Vec a) {
  const double before = ledger_->energy_error();
  ledger_->book(coupling_.record(u), u, v, inertia_ ? a : a_.get());
  const double residual = ledger_->energy_error();
  // Consecutive steps beyond the bounds: what the first steps of a run miss is soon small beside what is
  // stored.
  const bool counts = ledger_->energy_scale() >= least_energy_;
  const auto beyond = [&](std::size_t which, double bound) {
    const bool is = counts && bound > 0 && std::abs(residual) > bound;
    watch_->trial[which] = is ? watch_->committed[which] + 1 : 0;
    return is;
  };
  const bool past_stop = beyond(1, s_.energy_stop), past_tol = beyond(0, s_.energy_tol);
  if (past_stop && watch_->trial[1] >= steps_beyond && must_close(residual)) {
    check(PetscPrintf(comm_, "impact: %s\n", energy_text(residual, attempt.t, "energy_stop").c_str()));
    throw UserError(ExitCode::solver, "stopped by -energy_stop: this is no solution; " +
                                          energy_remedy(residual) + " (-energy_stop 0 goes on)");
  }
  if (!past_tol) return {};
  if (s_.energy_action == Scenario::EnergyAction::warn) {
    if (watch_->trial[0] < steps_beyond || !energy_warning_.empty()) return {};
    energy_warning_ = energy_text(residual, attempt.t, "energy_tol");
    check(PetscPrintf(comm_, "impact: WARNING: %s; %s\n", energy_warning_.c_str(),
                      energy_remedy(residual).c_str()));
    return {};
  }
  if (std::abs(residual) <= std::abs(before)) return {};
  check(PetscPrintf(comm_, "impact: %s\n", energy_text(residual, attempt.t, "energy_tol").c_str()));
  if (s_.energy_action == Scenario::EnergyAction::stop)
    throw UserError(ExitCode::solver,
                    "stopped by -energy_action stop; take smaller steps or more coupling passes");
  ledger_->unbook();
  return {false, 0.5};
}

// What a run without inertia loses may be what a crack released that ran within a step: no store takes it up.
bool Simulation::must_close(double residual) const { return inertia_ || residual > 0; }

std::string Simulation::energy_text(double residual, double t, const char* option) const {
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "energy balance: first-law residual %.3g exceeds -%s %.3g at t = %.10g: %.4g of energy %s since "
      "t = 0, the largest is %.4g",
      std::abs(residual), option, option == std::string("energy_tol") ? s_.energy_tol : s_.energy_stop, t,
      std::abs(residual) * ledger_->energy_scale(), residual > 0 ? "gained" : "lost",
      ledger_->energy_scale());
  return text;
}

std::string Simulation::energy_remedy(double residual) const {
  const bool damage = d_.has_damage(), few = damage && s_.coupling.max_it < 10;
  if (!inertia_ && residual < 0 && damage)
    return "likely a crack ran within a step, whose energy nothing takes up without inertia, or damage lags "
           "behind: take smaller steps or more coupling passes (-coupling_snes_max_it) to tell";
  std::string text = residual > 0 ? "likely the steps are too long for what changes its stiffness in them"
                                  : "likely the steps are too long";
  if (few)
    text += ", or damage lags behind the motion in " + std::to_string(s_.coupling.max_it) + " pass" +
            (s_.coupling.max_it == 1 ? "" : "es");
  text += ": take a shorter -ts_dt";
  if (few) text += ", -coupling_snes_max_it 50";
  // Beside contact the trapezoidal rule exchanges nothing with its forces (src/theory.md, N3).
  if (inertia_ && residual > 0)
    text += integrator_of(ts_).alpha_m > 1 && !setup_.contacts.empty() ? ", -ts_newmark_rho 1"
                                                                       : ", -ts_newmark_rho 0.5";
  return text;
}

void Simulation::accept(const Attempt& attempt) {
  StateTable& state = setup_.state;
  Vec u = nullptr, v = nullptr;
  check(TS2GetSolution(ts_, &u, &v));
  Vec a = inertia_ ? acceleration(ts_) : a_.get();
  StateRow& row = state.row("u");
  d_.displacement.to_local(u, row.trial);
  d_.displacement.to_local(v, state.row("v").trial);
  d_.displacement.to_local(a, state.row("a").trial);
  std::vector<double>& rate = state.row("mean_rate").trial;
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = (row.trial[i] - row.committed[i]) / attempt.dt;
  if (const std::string text = coupling_.crack_text(); !text.empty())
    check(PetscPrintf(comm_, "impact: step %ld: %s\n", snapshot_.step + 1, text.c_str()));
  setup_.rigid.advance(u);
  StateRow& prescribed = state.row("prescribed_velocity");
  setup_.boundary.set_exact_velocity(attempt.t_n, attempt.t, prescribed.committed, prescribed.trial);
  if (!setup_.contacts.empty()) {
    Handle<Vec> u_n = d_.displacement.make_global();
    d_.displacement.to_global(row.committed, u_n);
    setup_.contacts.advance(u_n, u, attempt.dt);
  }
  state.commit();
  if (probe_.after) probe_.after(attempt, snapshot_.step + 1, state);

  snapshot_.step += 1;
  snapshot_.time = attempt.t;
  snapshot_.dt = attempt.dt;
  snapshot_.tries = static_cast<int>(attempt.number);
  snapshot_.u = u;
  const HistoryFile::Row columns = history_->watch(snapshot_, coupling_.counts());
  write_fields(false);
  progress_.line(snapshot_, coupling_.counts(), *ledger_, active_points());
  const StepCounts counts = coupling_.counts();
  std::vector<std::string> solved;
  if (counts.linear > 0) solved.emplace_back("motion");
  if (counts.damage_linear > 0) solved.emplace_back("damage");
  if (counts.heat_linear > 0) solved.emplace_back("heat");
  unread_.judge(solved);
  StopRequest request = requests_.ask(comm_, checkpoint_is_due());
  ended_by_ = stops_.ask(columns);
  request.checkpoint = request.checkpoint || !ended_by_.empty();
  obey(request);
  if (!ended_by_.empty()) check(TSSetConvergedReason(ts_, TS_CONVERGED_USER));
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

void Simulation::obey(const StopRequest& request) {
  if (request.checkpoint) write_state(step_control_state(ts_));
  if (request.stop.empty()) return;
  stopped_by_ = request.stop;
  check(TSSetConvergedReason(ts_, TS_CONVERGED_USER));
}

int Simulation::active_points() { return setup_.contacts.active(snapshot_.u); }

bool Simulation::checkpoint_is_due() const {
  if (s_.checkpoint.every > 0 && snapshot_.step % s_.checkpoint.every == 0) return true;
  return s_.checkpoint.wall > 0 && progress_.wall() - last_checkpoint_ >= s_.checkpoint.wall;
}

void Simulation::write_state(const StepControlState& c) {
  const InStage stage(Stage::output);
  const Timed timed(Event::checkpoint_write);
  const double start = progress_.wall();
  control_->committed = control_->trial = {c.dt, c.at_limit ? 1.0 : 0.0, static_cast<double>(c.easy_steps),
                                           static_cast<double>(c.rejections)};
  CheckpointValues values;
  values.time = snapshot_.time;
  values.step = snapshot_.step;
  values.texts["options"] = restart_options(comm_, s_);
  stops_.store(values);
  char version[256] = "";
  check(PetscGetVersion(version, sizeof version));
  values.texts["petsc_version"] = version;
  checkpoint_file_ = checkpoints_.write(values);
  // A resumed run builds its candidate list afresh and factors anew: so does this one, or they would part by
  // round-off.
  setup_.contacts.forget_search();
  coupling_.forget_factors();
  saved_step_ = snapshot_.step;
  last_checkpoint_ = progress_.wall();
  requests_.note_checkpoint(last_checkpoint_ - start);
  std::error_code unknown;
  const auto bytes = std::filesystem::file_size(checkpoint_file_, unknown);
  check(PetscPrintf(comm_, "checkpoint %s: %lld bytes in %.3f s\n", checkpoint_file_.c_str(),
                    static_cast<long long>(bytes), last_checkpoint_ - start));
}

// However a run ends, another one can go on from there. After a failure that is the state before the step,
// without the cuts of dt, which belong to the failed tries.
void Simulation::save_end(const StepControlState& control) {
  try {
    if (saved_step_ != snapshot_.step) write_state(control);
    if (stopped_by_.empty() && ended_by_.empty())
      check(PetscPrintf(comm_, "the state at t = %.10g, step %ld, is in %s\n", snapshot_.time, snapshot_.step,
                        checkpoint_file_.c_str()));
  } catch (const UserError& error) {
    check(PetscPrintf(comm_, "impact: %s\n", error.what()));
  }
}

ExitCode Simulation::run() {
  progress_.header();
  const StopRequest early = requests_.ask(comm_, false); // since the program began
  stopped_by_ = early.stop;
  TSConvergedReason reason = TS_CONVERGED_USER;
  control_at_start_ = step_control_state(ts_);
  try {
    if (stopped_by_.empty()) {
      const InStage stage(Stage::steps);
      solve_in_time(ts_);
      check(TSGetConvergedReason(ts_, &reason));
    }
  } catch (const UserError& error) {
    if (error.code() == ExitCode::solver || error.code() == ExitCode::data) save_end(control_at_start_);
    throw;
  }
  if (reason == TS_CONVERGED_ITS && !(s_.time.max_time > 0 && snapshot_.time >= s_.time.max_time))
    ended_by_ = "-ts_max_steps " + std::to_string(s_.time.max_steps);
  // The last state of a run that goes on later is no output of its own.
  if (stopped_by_.empty()) write_fields(true);
  save_end(reason > 0 ? step_control_state(ts_) : control_at_start_);
  check(PetscPrintf(comm_, "%s at t = %.10g after %ld steps in %s; energy balance %.2e, first law %.2e\n",
                    !stopped_by_.empty() ? "stopped by request"
                    : !ended_by_.empty() ? "stopped"
                    : reason > 0         ? "finished"
                                         : "gave up",
                    snapshot_.time, snapshot_.step, Progress::clock(progress_.wall()).c_str(),
                    ledger_->balance(), ledger_->balance_first_law()));
  check(PetscPrintf(comm_, "%s", ledger_->report().c_str()));
  const double left = ledger_->energy_error();
  if (!energy_warning_.empty())
    check(PetscPrintf(comm_, "impact: WARNING, first of its kind: %s; at the end %.3g\n",
                      energy_warning_.c_str(), left));
  else if (s_.energy_tol > 0 && std::abs(left) > s_.energy_tol && ledger_->energy_scale() >= least_energy_)
    check(PetscPrintf(comm_, "impact: WARNING: %s; %s\n",
                      energy_text(left, snapshot_.time, "energy_tol").c_str(), energy_remedy(left).c_str()));
  if (coupling_.motion_solver().second_ways() > 0)
    check(PetscPrintf(comm_, "  motion solves repeated with backtracking  %ld\n",
                      coupling_.motion_solver().second_ways()));
  if (!stopped_by_.empty())
    check(PetscPrintf(comm_, "stopped by request (%s); -restart auto goes on from %s\n", stopped_by_.c_str(),
                      checkpoint_file_.c_str()));
  if (!ended_by_.empty())
    check(PetscPrintf(comm_, "stopped by %s; the state is in %s\n", ended_by_.c_str(),
                      checkpoint_file_.c_str()));
  if (reason > 0) return ExitCode::ok;
  check(PetscPrintf(comm_, "impact: the step could not be solved (%s): %s\n", TSConvergedReasons[reason],
                    last_cause_.empty() ? "no solution at any length" : last_cause_.c_str()));
  return ExitCode::solver;
}

} // namespace

ExitCode simulate(MPI_Comm comm, const Scenario& s, const StepProbe& probe) {
  std::optional<InStage> starts(Stage::setup);
  std::optional<FolderLock> output, checkpoints;
  if (!s.dry_run) {
    output.emplace(comm, "output_dir", s.output_dir);
    if (s.checkpoint.dir != default_checkpoint_dir(s) && s.checkpoint.dir != s.output_dir)
      checkpoints.emplace(comm, "checkpoint_dir", s.checkpoint.dir);
  }
  const std::optional<Checkpoint> resume = find_checkpoint(comm, s);
  std::optional<GmshFile> kept; // a changed or missing file, or another gmsh, changes nothing on a restart
  if (resume) kept = read_checkpoint_mesh_file(comm, *resume);
  const std::unique_ptr<Setup> setup = build_setup(comm, s, kept ? &*kept : nullptr);
  kept.reset();
  SolverDemands demands;
  demands.closes_gaps = setup->contacts.demands().closes_gaps;
  demands.frictional = setup->contacts.demands().frictional;
  demands.rigid = !setup->rigid.empty();
  demands.unsymmetric = !unsymmetric_force(s).first.empty();
  const SolverDefaults solver =
      choose_solver(setup->discretisation, s.tangent, s.has_inertia(), s.time.dt, demands, s.matrix);
  report_setup(s, setup->discretisation);
  Simulation run(comm, s, *setup, solver, resume, probe);
  starts.reset();
  if (!s.dry_run) return run.run();
  check(PetscPrintf(comm, "%s\ndry run: the input is complete\n", print_scenario(s, true).c_str()));
  return ExitCode::ok;
}

} // namespace impact
