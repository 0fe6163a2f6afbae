#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/run/stage.hpp>
#include <impact/run/terminal.hpp>
#include <impact/scenario/petsc_options.hpp>
#include <impact/time/step_control.hpp>
#include <sstream>

namespace impact {

namespace {

// Contacts that are there no more let go (-restart_allow contacts), true if there are any; others begin, and
// conditions come and go (bcs), the heat that passed them with them.
bool allow_other_conditions(const Scenario& scenario, const StateTable& state, const std::string& rows,
                            OtherRows& others) {
  bool lets_go = false;
  std::istringstream lines(rows);
  for (std::string line; std::getline(lines, line);) {
    const std::string row = line.substr(0, line.find(" ("));
    const bool of_lost_contact =
        row.starts_with("contact_") && std::ranges::none_of(scenario.contacts, [&](const auto& contact) {
          return row.starts_with("contact_" + contact.id + "_");
        });
    lets_go = lets_go || of_lost_contact;
    if (row.starts_with("bc_") || of_lost_contact) others.in_vain.push_back(row);
  }
  std::vector<std::string> begins = {"bc_"};
  for (const auto& contact : scenario.contacts)
    if (("\n" + rows).find("\ncontact_" + contact.id + "_") == std::string::npos)
      begins.push_back("contact_" + contact.id + "_");
  for (const auto& row : state.rows())
    if (std::ranges::any_of(begins, [&](const std::string& head) { return row->name.starts_with(head); }))
      others.lacking.push_back(row->name);
  return lets_go;
}

bool conserves(const Scenario& s) {
  return std::ranges::any_of(
      s.contacts, [](const ContactSettings& contact) { return contact.impact == ImpactUpdate::conserving; });
}

// The contact-stabilised update is for all that has inertia and stiffness, at any length of the steps, but
// for long damped ones, which resolve no impact: there the force of contact is that of the end of the step.
bool stabilises(MPI_Comm comm, const Scenario& s, const SolverDefaults& solver) {
  if (s.contacts.empty() || !s.has_inertia() || s.explicit_steps()) return false;
  constexpr double long_step = 1000;
  const bool conserve = conserves(s), slow = solver.cfl > long_step && asks_for_damped_steps(),
             automatic = solver.cfl > 0 && !conserve && !slow;
  const bool stabilise = std::ranges::any_of(s.contacts, [&](const ContactSettings& c) {
    return c.impact == ImpactUpdate::stabilised || (c.impact == ImpactUpdate::automatic && automatic);
  });
  check(PetscPrintf(comm, "impact update: %s (dt is %.3g times h/c_p)\n",
                    stabilise         ? "contact-stabilised"
                    : conserve        ? "energy-conserving"
                    : solver.cfl <= 0 ? "none: nothing has a stiffness"
                    : slow            ? "none: damped steps that resolve no impact"
                                      : "none, as asked",
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

// Steps that resolve no wave leave what is fast to the integrator, which does not damp it unless told to.
void report_long_steps(const Discretisation& d, const SolverDefaults& solver) {
  constexpr double many = 100;
  const double across = std::pow(static_cast<double>(d.mesh.global_cell_count()), 1.0 / d.dim());
  if (solver.cfl <= many * across || asks_for_damped_steps()) return;
  check(
      PetscPrintf(d.mesh.comm(),
                  "a step is %.2g times as long as waves take through the bodies: what swings faster "
                  "alternates from step to step unless -ts_newmark_rho 0.8 damps it; -ts_type static has no "
                  "inertia\n",
                  solver.cfl / across));
}

SolverDefaults choose(const Scenario& s, Setup& setup) {
  SolverDemands demands;
  demands.closes_gaps = setup.contacts.demands().closes_gaps;
  demands.frictional = setup.contacts.demands().frictional;
  demands.rigid = !setup.rigid.empty();
  demands.path = s.coupling.path_length > 0;
  demands.unsymmetric = !unsymmetric_force(s).first.empty();
  SolverDefaults solver =
      choose_solver(setup.discretisation, s.tangent, s.has_inertia(), s.time.dt, demands, s.matrix);
  report_setup(s, setup.discretisation);
  if (!s.explicit_steps()) report_long_steps(setup.discretisation, solver);
  return solver;
}

// -ts_type of the run that wrote.
std::string time_scheme_of(const Checkpoint& checkpoint) {
  std::istringstream lines(checkpoint.values.texts.at("options"));
  for (std::string key, line; lines >> key; std::getline(lines, line))
    if (key == "-ts_type" && lines >> line) return line;
  return "newmark";
}

template <class Problem, class... Given> std::optional<Problem> made_if(bool there, Given&&... given) {
  return there ? std::optional<Problem>(std::in_place, std::forward<Given>(given)...) : std::nullopt;
}

// What stops bodies by their stress, or at once, has no use for two sides that cannot yield.
void refuse_updates_of_rigid_sides(const Setup& setup, bool stabilised) {
  for (const ContactInterface& contact : setup.contacts) {
    if (!between_rigid_sides(setup, contact.settings())) continue;
    const std::string of = "-contact_" + contact.id();
    if (stabilised)
      throw UserError(ExitCode::usage, of +
                                           "_impact: the contact-stabilised update leaves the speed of what "
                                           "touches to its stress, and both sides of this contact are rigid; "
                                           "take " +
                                           of + "_impact conserving, or none for every contact");
    if (contact.demands().closes_gaps)
      throw UserError(ExitCode::usage,
                      of + "_enforce semismooth: multipliers close the gap within a step, and "
                           "give bodies that cannot yield any speed by that; take penalty, as "
                           "this contact has by default");
  }
}

} // namespace

StepRows::StepRows(StateTable& state)
    : u(state.row("u")), v(state.row("v")), a(state.row("a")), mean_rate(state.row("mean_rate")),
      prescribed_velocity(state.row("prescribed_velocity")), phi(state.find("phi")),
      theta(state.find("theta")) {}

RunStage::RunStage(MPI_Comm comm, const Scenario& s, std::optional<GmshFile> kept)
    : scenario(s), setup(build_setup(comm, s, std::move(kept))), d(setup->discretisation),
      state(setup->state), rows(state), inertia(s.has_inertia()), solver(choose(s, *setup)),
      erosion(setup->discretisation, state),
      motion(d, state, setup->boundary, setup->contacts, solver.symmetric, s.contact_operator, solver.matrix,
             &setup->rigid, s.has_motion() && !s.explicit_steps()),
      damage(made_if<DamageProblem>(d.has_damage(), d, state, setup->boundary, s.damage)),
      heat(made_if<HeatProblem>(d.has_heat(), d, state, setup->boundary, s.heat, s.has_motion(),
                                s.has_motion() ? &setup->contacts : &setup->joints)),
      ts(make_integrator(comm, s)), coupling(ts,
                                             {motion, damage ? &*damage : nullptr, heat ? &*heat : nullptr,
                                              state, erosion.on() ? &erosion : nullptr},
                                             s.coupling, solver, stabilises(comm, s, solver)),
      ledger(motion, state, inertia, s.has_motion(),
             {s.history_materials, s.coupling.report_error, coupling.unilateral(),
              s.coupling.by_central_differences.bulk.acts(), heat ? &*heat : nullptr}),
      source(motion, state), u(d.displacement.make_global()), v(d.displacement.make_global()),
      a(d.displacement.make_global()) {
  if (s.explicit_steps()) // many short steps, whose time is that of passing through memory
    for (const char* name : {"u", "v", "a", "mean_rate", "history", "drive", "force_internal",
                             "force_external", "force_contact", "force_inertia"})
      if (state.find(name) != nullptr) state.row(name).rewritten = true;
  if (inertia && !s.explicit_steps()) refuse_updates_of_rigid_sides(*setup, coupling.stabilised());
  set_time_options(ts);
  if (const Integrator& p = integrator_of(ts);
      inertia && conserves(s) && (p.alpha_m != 1 || p.beta != 0.25 || p.gamma != 0.5))
    throw UserError(ExitCode::usage, "-ts_newmark_rho: the energy-conserving contact update "
                                     "(-contact_<id>_impact conserving) is for the trapezoidal rule; take "
                                     "-ts_newmark_rho 1");
}

// A path that begins at the state of another run has its load, the time. One that is left ends at a load of
// its own.
void RunStage::enter_or_leave_path(const Checkpoint& from) {
  const bool had = from.rows.find(std::string(load_parameter_row) + " (") != std::string::npos,
             has = state.find(load_parameter_row) != nullptr;
  if (has && !had)
    state.row(load_parameter_row).committed = state.row(load_parameter_row).trial = {from.values.time, 1};
  if (had && !has)
    check(PetscPrintf(d.mesh.comm(),
                      "impact: the run before followed a path: what its conditions were at its last "
                      "load_parameter they are at t = %.10g from here on\n",
                      from.values.time));
}

void RunStage::set_state(const Checkpoint* resume) {
  double time = 0;
  OtherRows others{{load_parameter_row}, {load_parameter_row, "drive"}}; // of before, where nothing reads it
  if (resume != nullptr) {
    const std::string type = time_scheme_of(*resume);
    other_scheme = scenario.has_motion() && type != scenario.time.type;
    if (other_scheme) { // what explicit steps alone keep, and statics do without
      others.lacking.insert(others.lacking.end(),
                            {"stable_step", "damage_wait", "eroded", "erosion_totals", "patch_scale"});
      others.in_vain.insert(others.in_vain.end(), {"stable_step", "damage_wait"});
    }
    const bool lets_go = allow_other_conditions(scenario, state, resume->rows, others);
    other_forces = other_scheme || (lets_go && inertia);
    read_checkpoint(*resume, {d.mesh, d.groups, state}, others);
    time = resume->values.time;
    enter_or_leave_path(*resume);
    if (other_scheme) set_state_of_other_scheme(scenario, *setup, time, type == "static");
    check(TSSetTime(ts, time));
    check(TSSetStepNumber(ts, static_cast<PetscInt>(resume->values.step)));
  } else {
    set_initial_state(scenario, *setup);
  }
  d.displacement.to_global(rows.u.committed, u);
  d.displacement.to_global(rows.v.committed, v);
  d.displacement.to_global(rows.a.committed, a);
  check(TS2SetSolution(ts, u, v));
  if (erosion.on() && resume != nullptr) {
    erosion.follow_rows();
    erosion.shed_mass();
    if (erosion.news()) coupling.expose_contacts(u);
  }
  motion.update_contact(u);
  if (ExplicitStep* const step = coupling.explicit_step()) {
    if (resume == nullptr || other_scheme)
      step->start(u, v);
    else
      step->resume();
    const double limit = scenario.time.dt > 0 ? scenario.time.dt : PETSC_MAX_REAL;
    set_step_limit(ts, limit);
    check(TSSetTimeStep(ts, std::min(step->longest(), limit)));
  }
  coupling.motion_solver().refresh_matrix();
  coupling.begin_between_steps(time, u, v);
  for (ContactInterface& contact : setup->contacts)
    if (std::ranges::find(others.lacking, "contact_" + contact.id() + "_totals") != others.lacking.end())
      contact.begin_at(time, u);
}

void RunStage::start() {
  coupling.start(u, v, a);
  if (inertia) d.displacement.to_local(a, rows.a.trial);
  for (StateRow* row :
       {&rows.u, &rows.v, &rows.mean_rate}) // whose trial half an earlier commit left undefined
    row->trial = row->committed;
  setup->contacts.advance(u, u, 0);
  PetscReal dt = 0;
  check(TSGetTimeStep(ts, &dt));
  ExplicitStep* const step = coupling.explicit_step();
  ledger.start(integrator_of(ts), dt, u, v, a, step ? step->bodies().kept(dt) : 0);
  if (!std::isfinite(ledger.energy_scale()))
    throw UserError(ExitCode::data, "the state at t = 0 has no energy: what is prescribed there (-bcs, -ics) "
                                    "turns cells inside out; let displacements begin with 0 at t = 0");
  state.commit();
}

void RunStage::resume() {
  if (other_forces) {
    const Handle<Vec> contact = d.displacement.make_global();
    for (ContactInterface& touch : setup->contacts) touch.carry_force();
    setup->contacts.add_carried(-1, contact);
    d.displacement.to_local(contact, state.row("force_contact").committed);
    coupling.start_acceleration(u, v, contact, a);
    if (inertia) d.displacement.to_local(a, rows.a.trial);
    PetscReal dt = 0;
    check(TSGetTimeStep(ts, &dt));
    ledger.resume_with(integrator_of(ts), dt, u, v, a);
    for (StateRow* row : {&rows.u, &rows.v, &rows.mean_rate}) row->trial = row->committed;
    state.commit();
  } else {
    if (inertia) set_acceleration(ts, a);
    ledger.resume(u, v);
  }
  // Lists of candidates made so far would serve for a while, but they are not those that the interrupted run
  // made in its next step.
  for (ContactInterface& contact : setup->contacts) contact.search().forget();
}

void RunStage::forget_what_a_restart_lacks() {
  for (ContactInterface& contact : setup->contacts) contact.search().forget();
  coupling.forget_factors();
}

StepHooks RunStage::hooks() {
  StepHooks hooks;
  if (coupling.stabilised())
    hooks.predict = [this](TS, const Attempt& attempt, Vec u_tilde, Vec v_n) {
      coupling.predict(attempt, u_tilde, v_n);
    };
  if (inertia && coupling.corrects())
    hooks.correct = [this](TS, Vec u_new, Vec v_new, Vec a_new) { coupling.correct(u_new, v_new, a_new); };
  hooks.guess = [this](TS, const Attempt& attempt, Vec guess) { coupling.guess(attempt, guess); };
  if (ExplicitStep* const step = coupling.explicit_step())
    hooks.longest = [step](TS) { return step->longest(); };
  hooks.effort = [this](TS) { return coupling.counts().hardest; };
  const CouplingScenario& limits = scenario.coupling;
  if (limits.max_dphi > 0 || limits.max_dalpha > 0 || limits.max_dtheta > 0)
    hooks.utilisation = [this](TS) { return coupling.utilisation(); };
  return hooks;
}

void RunStage::check_prescribed_data(const Attempt& of_step) {
  const BoundaryData& boundary = setup->boundary;
  if (!boundary.has_data()) return;
  const Attempt attempt = coupling.first_loads(of_step);
  const std::vector<double>&u_n = rows.u.committed, &v_n = rows.prescribed_velocity.committed;
  std::vector<double> unused = u_n;
  motion.evaluate([&] {
    setup->rigid.require_agreement(attempt.t_n, attempt.t);
    boundary.require_agreement(attempt.t_n, attempt.t, u_n, v_n);
    boundary.set_displacement(attempt.t_n, attempt.t, u_n, v_n, unused);
    boundary.set_exact_velocity(attempt.t_n, attempt.t, v_n, unused);
    if (rows.phi) {
      unused = rows.phi->committed;
      boundary.set_damage(attempt.t, unused);
    }
    if (rows.theta) {
      unused = rows.theta->committed;
      boundary.set_temperature(attempt.t, unused);
    }
  });
}

void RunStage::accept(const Attempt& attempt, bool with_ghosts) {
  Vec u_new = nullptr, v_new = nullptr;
  check(TS2GetSolution(ts, &u_new, &v_new));
  const Vec a_new = inertia ? acceleration(ts) : a.get();
  if (coupling.explicit_step()) // the forces are those at this displacement
    rows.u.trial = motion.last_displacement();
  else
    d.displacement.to_local(u_new, rows.u.trial);
  if (with_ghosts || !coupling.explicit_step()) {
    d.displacement.to_local(v_new, rows.v.trial);
    d.displacement.to_local(a_new, rows.a.trial);
  } else {
    d.displacement.owned_to_local(v_new, rows.v.trial);
    d.displacement.owned_to_local(a_new, rows.a.trial);
  }
  std::vector<double>& rate = rows.mean_rate.trial;
  for (std::size_t i = 0; i < rate.size(); ++i)
    rate[i] = (rows.u.trial[i] - rows.u.committed[i]) / attempt.dt;
  if (!coupling.explicit_step()) setup->rigid.advance(u_new);
  const Attempt loads = coupling.loads(attempt);
  setup->boundary.set_exact_velocity(loads.t_n, loads.t, rows.prescribed_velocity.committed,
                                     rows.prescribed_velocity.trial);
  if (!setup->contacts.empty()) {
    if (!coupling.explicit_step()) { // whose contacts have ended their step
      if (!before) before = d.displacement.make_global();
      d.displacement.to_global(rows.u.committed, before);
    }
    setup->contacts.advance(before, u_new, attempt.dt);
  }
  if (ExplicitStep* const step = coupling.explicit_step()) step->accept();
  if (erosion.on()) erosion.settle();
  state.commit();
  follow_erosion(u_new, attempt.dt);
}

void RunStage::follow_erosion(Vec u_now, double dt) {
  if (!erosion.on()) return;
  erosion.follow_rows();
  if (!erosion.news()) return;
  const auto springs = [&] {
    double energy = 0;
    for (const ContactStep& contact : setup->contacts.step(u_now)) energy += contact.energy;
    return energy;
  };
  const double kept = springs();
  coupling.expose_contacts(u_now);
  ledger.book_exposure(kept, springs());
  if (d.sheds_mass()) shed_mass(u_now, dt);
}

// The forces that are there act on through the first half of the next step, on the mass that is left: M a
// stays, but at prescribed dofs. Nodes without any mass stand still, and what they were to get of that half
// goes with their momentum.
void RunStage::shed_mass(Vec u_now, double dt) {
  Vec unused = nullptr, v_now = nullptr;
  check(TS2GetSolution(ts, &unused, &v_now));
  const Vec a_now = acceleration(ts);
  const Ledger::Inertia with_it = ledger.inertia(u_now, v_now, a_now, dt);
  const std::vector<double> mass = d.local_of(motion.lumped_mass());
  erosion.shed_mass();
  motion.forget_mass();
  const std::vector<double> left = d.local_of(motion.lumped_mass());
  std::vector<double> speed = d.local_of(v_now), rate = d.local_of(a_now);
  const auto dim = at(d.dim());
  std::array<double, 3> force{};
  for (std::size_t i = 0; i < mass.size(); ++i) {
    if (left[i] == mass[i] || setup->boundary.fixed_mask()[i]) continue;
    if (left[i] == 0) {
      if (d.mesh.owned(static_cast<int>(i / dim))) force[i % dim] += d.thickness * mass[i] * rate[i];
      speed[i] = rate[i] = 0;
    } else {
      rate[i] *= mass[i] / left[i];
    }
  }
  d.displacement.to_global(speed, v_now);
  d.displacement.to_global(rate, a_now);
  rows.v.committed = rows.v.trial = std::move(speed);
  rows.a.committed = rows.a.trial = std::move(rate);
  sum_over_ranks(d.mesh.comm(), force);
  ledger.book_shed_mass(with_it, ledger.inertia(u_now, v_now, a_now, dt), force);
}

} // namespace impact
