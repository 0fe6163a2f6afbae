#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/run/alpha2.hpp>
#include <impact/run/observers.hpp>
#include <impact/run/output_folder.hpp>
#include <impact/run/petsc_options.hpp>
#include <impact/run/progress.hpp>
#include <impact/run/stop_requests.hpp>

namespace impact {

namespace {

void refuse_history(const Scenario& s, const Discretisation& d) {
  const char* what = d.has_plasticity()    ? "j2 materials"
                     : d.has_damage()      ? "damage"
                     : d.has_viscosity()   ? "viscosity (_b_d)"
                     : !s.contacts.empty() ? "contact"
                                           : nullptr;
  if (what)
    throw UserError(ExitCode::usage,
                    std::string("-ts_type alpha2: not with ") + what +
                        ", whose history its half steps at the start would spoil; use newmark");
}

// What the callbacks of the integrator see.
struct Problem {
  MotionProblem* motion;
  const std::vector<double>* u_n;
  double scale; // of the rows of prescribed dofs
  double time = NAN;
  Mailbox mailbox;

  void begin(double t) {
    if (t == time) return;
    MotionStep step;
    step.t_n = step.t = t;
    step.u_n = u_n;
    motion->begin(step);
    time = t;
  }
};

PetscErrorCode residual(TS ts, PetscReal t, Vec u, Vec, Vec a, Vec f, void* context) {
  auto& self = *static_cast<Problem*>(context);
  return self.mailbox.guarded([&] {
    self.begin(t);
    if (!self.motion->residual(u, a, f)) {
      SNES snes = nullptr;
      check(TSGetSNES(ts, &snes));
      check(SNESSetFunctionDomainError(snes));
    }
    self.motion->hold(u, self.scale, f);
  });
}

PetscErrorCode tangent(TS, PetscReal t, Vec u, Vec, Vec, PetscReal, PetscReal shift, Mat, Mat,
                       void* context) {
  auto& self = *static_cast<Problem*>(context);
  return self.mailbox.guarded([&] {
    self.begin(t);
    self.motion->tangent(u, shift);
    self.motion->hold_tangent(self.scale);
  });
}

} // namespace

ExitCode simulate_alpha2(MPI_Comm comm, const Scenario& s, Setup& setup, const SolverDefaults& solver) {
  const Discretisation& d = setup.discretisation;
  refuse_history(s, d);
  set_initial_state(s, setup);
  MotionProblem motion(d, setup.state, setup.boundary, setup.contacts, solver.symmetric,
                       ContactOperator::assembled, solver.matrix);
  Handle<TS> ts;
  check(TSCreate(comm, ts.out()));
  check(TSSetProblemType(ts, TS_NONLINEAR));
  check(TSSetType(ts, TSALPHA2));
  check(TSSetTimeStep(ts, s.time.dt));
  check(TSSetMaxTime(ts, s.time.max_time));
  check(TSSetMaxSteps(ts, s.time.max_steps > 0 ? s.time.max_steps : PETSC_MAX_INT));
  check(TSSetExactFinalTime(ts, TS_EXACTFINALTIME_MATCHSTEP));
  const std::vector<double> u_start = setup.state.row("u").committed;
  Problem problem{&motion, &u_start, 1e12 * motion.reference_force() / d.mesh.smallest_edge(), NAN, {}};
  check(TSSetI2Function(ts, nullptr, residual, &problem));
  check(TSSetI2Jacobian(ts, motion.matrix(), motion.matrix(), tangent, &problem));
  SNES snes = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(TSGetSNES(ts, &snes));
  check(SNESSetOptionsPrefix(snes, "motion_"));
  check(SNESSetTolerances(snes, motion.reference_force(), 1e-10, 0, 25, PETSC_DEFAULT));
  check(SNESSetConvergenceTest(
      snes,
      [](SNES self_snes, PetscInt it, PetscReal, PetscReal, PetscReal norm, SNESConvergedReason* why,
         void* context) {
        auto& self = *static_cast<Problem*>(context);
        return self.mailbox.guarded([&] {
          if (it == 0) self.motion->balance().start();
          *why = self.motion->balance().test(self_snes, it, norm);
        });
      },
      &problem, nullptr));
  check(SNESGetKSP(snes, &ksp));
  check(KSPSetType(ksp, KSPPREONLY));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, solver.matrix == MatrixFormat::sbaij ? PCCHOLESKY : PCLU));
  check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  check(TSSetFromOptions(ts));
  check_preconditioner(ksp, solver.matrix);

  Handle<Vec> u = d.displacement.make_global(), v = d.displacement.make_global();
  d.displacement.to_global(setup.state.row("u").committed, u);
  d.displacement.to_global(setup.state.row("v").committed, v);
  check(TS2SetSolution(ts, u, v));
  const FieldSource source(motion, setup.state);
  Ledger ledger(motion, nullptr, setup.state, true);
  HistoryObserver history(s, motion, ledger, setup.state, source);
  set_earlier_run_aside(comm, s, std::nullopt);
  history.open(std::nullopt);
  Progress progress(comm, s.time.max_time);
  Snapshot snapshot;
  snapshot.u = u;
  StopRequests requests({});
  UnreadOptions unread(comm, s);
  std::string stopped_by;
  const auto observe = [&](double t, double dt) {
    d.displacement.to_local(u, setup.state.row("u").committed);
    d.displacement.to_local(v, setup.state.row("v").committed);
    ledger.observe(u, v);
    snapshot.time = t;
    snapshot.dt = dt;
    history.watch(snapshot, {});
  };
  problem.begin(0);
  observe(0, 0);
  progress.header();
  const auto obey = [&] {
    unread.judge({"motion"});
    const StopRequest request = requests.ask(comm, false);
    if (request.checkpoint && request.stop.empty())
      check(PetscPrintf(comm, "impact: no checkpoint: -ts_type alpha2 writes none; the run goes on\n"));
    if (request.stop.empty()) return;
    stopped_by = request.stop;
    check(TSSetConvergedReason(ts, TS_CONVERGED_USER));
  };
  struct Watch {
    const decltype(observe)* call;
    const decltype(obey)* stop;
    Snapshot* snapshot;
    Mailbox* mailbox;
  } watch{&observe, &obey, &snapshot, &problem.mailbox};
  check(TSSetApplicationContext(ts, &watch));
  check(TSSetPostStep(ts, [](TS stepper) -> PetscErrorCode {
    Watch* at = nullptr;
    PetscReal t = 0, t_n = 0;
    TSGetApplicationContext(stepper, &at);
    return at->mailbox->guarded([&] {
      check(TSGetTime(stepper, &t));
      check(TSGetPrevTime(stepper, &t_n));
      at->snapshot->step += 1;
      (*at->call)(t, t - t_n);
      (*at->stop)();
    });
  }));
  problem.mailbox.deliver(TSSolve(ts, nullptr));
  TSConvergedReason reason = TS_CONVERGED_ITERATING;
  check(TSGetConvergedReason(ts, &reason));
  check(PetscPrintf(comm, "%s at t = %.10g after %ld steps in %s (alpha2)\n",
                    reason > 0 ? "finished" : "gave up", snapshot.time, snapshot.step,
                    Progress::clock(progress.wall()).c_str()));
  if (!stopped_by.empty())
    check(PetscPrintf(
        comm,
        "stopped by request (%s); -ts_type alpha2 writes no checkpoints, so that it can only start over\n",
        stopped_by.c_str()));
  return reason > 0 ? ExitCode::ok : ExitCode::solver;
}

} // namespace impact
