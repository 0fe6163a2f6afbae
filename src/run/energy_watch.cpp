#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/run/energy_watch.hpp>

namespace impact {

namespace {

// So many steps beyond a bound are no start of a run.
constexpr int many_steps = 5;
constexpr double grown = 0.01;  // part of a bound by which an error grows in one of them
constexpr double soft = 0.1;    // part of the elastic energy that penalties may hold without a word
constexpr double restless = 10; // openings of what rubs
constexpr double shrinks = 0.9; // of what it was, an error that grows small beside what comes later
// Part of the largest energy by which a step without inertia strains bodies without work. A way across a peak
// of the energy does so too: so many cuts tell which it was.
constexpr double leap = 0.8;
constexpr int cuts_of_leap = 5;

enum : std::size_t { warns, stops }; // the bounds

// There the trapezoidal work of a step in which much of a body damages is too small, and no sign of anything.
bool damages_in_cycles(const RunStage& stage) {
  return !stage.inertia && stage.d.has_damage() && stage.scenario.time.period > 0;
}

} // namespace

EnergyWatch::EnergyWatch(RunStage& stage)
    : stage_(stage), steps_beyond_(stage.state.add({"energy_watch", Support::global, 2}, 2)),
      least_(1e-2 * stage.motion.reference_force() * stage.d.mesh.smallest_edge() * stage.d.thickness *
             static_cast<double>(stage.d.mesh.global_cell_count())) {}

// Steps without one within the bound between them. What the first steps of a load miss, as the heat of
// friction that begins, grows small beside what comes later, and such steps end no run; what one step
// across a kink of the force misses, as where contact opens, stays, and without inertia counts once.
bool EnergyWatch::beyond(std::size_t which, double bound, double before) {
  const double error = std::abs(stage_.ledger.energy_error());
  const bool is = stage_.ledger.energy_scale() >= least_ && bound > 0 && error > bound;
  const bool counts = !stage_.inertia  ? error >= std::abs(before) + grown * bound
                      : which == stops ? error >= shrinks * std::abs(before)
                                       : true;
  steps_beyond_.trial[which] = is ? steps_beyond_.committed[which] + (counts ? 1 : 0) : 0;
  return is;
}

// Newton's method may find another state of equilibrium than the one next to the last: that one comes from
// nowhere, and a shorter step does not reach it. Paths have a length of their own.
bool EnergyWatch::leaps(double before, const Attempt& attempt) const {
  const Scenario& s = stage_.scenario;
  const double scale = stage_.ledger.energy_scale();
  return !stage_.inertia && s.coupling.path_length == 0 && s.energy_stop > 0 &&
         attempt.number <= cuts_of_leap && scale >= least_ &&
         stage_.ledger.exchanged().strained > leap * scale &&
         stage_.ledger.energy_error() - std::max(before, 0.0) > std::max(leap, s.energy_stop);
}

Verdict EnergyWatch::judge(double before, const Attempt& attempt) {
  const double t = attempt.t;
  const Scenario& s = stage_.scenario;
  const MPI_Comm comm = stage_.d.mesh.comm();
  const double residual = stage_.ledger.energy_error();
  if (leaps(before, attempt)) {
    check(PetscPrintf(comm, "impact: %s, in one step: another state than the one next to the last\n",
                      text(t, "energy_stop", s.energy_stop).c_str()));
    stage_.ledger.unbook();
    return {false, 0.5};
  }
  const Ledger::Exchanged exchanged = stage_.ledger.exchanged();
  if (exchanged.held > most_held_) {
    most_held_ = exchanged.held;
    strain_then_ = stage_.ledger.energies().total.elastic;
  }
  const bool past_stop = beyond(stops, s.energy_stop, before), past_tol = beyond(warns, s.energy_tol, before);
  // A run without inertia may lose the energy of a crack that ran within a step: no store takes it up.
  const bool must_close = stage_.inertia || residual > 0;
  if (past_stop && steps_beyond_.trial[stops] >= many_steps && must_close) {
    check(PetscPrintf(comm, "impact: %s\n", text(t, "energy_stop", s.energy_stop).c_str()));
    throw UserError(ExitCode::solver, std::string("stopped by -energy_stop: ") +
                                          (damages_in_cycles(stage_) ? "" : "this is no solution; ") +
                                          remedy() + " (-energy_stop 0 goes on)");
  }
  if (!past_tol) return {};
  const std::string said = text(t, "energy_tol", s.energy_tol);
  if (s.energy_action == Scenario::EnergyAction::warn) {
    if (steps_beyond_.trial[warns] < many_steps || !warning_.empty()) return {};
    warning_ = said;
    check(PetscPrintf(comm, "impact: WARNING: %s; %s\n", said.c_str(), remedy().c_str()));
    return {};
  }
  if (std::abs(residual) <= std::abs(before)) return {};
  check(PetscPrintf(comm, "impact: %s\n", said.c_str()));
  if (s.energy_action == Scenario::EnergyAction::stop)
    throw UserError(ExitCode::solver,
                    "stopped by -energy_action stop; take smaller steps or more coupling passes");
  stage_.ledger.unbook();
  return {false, 0.5};
}

void EnergyWatch::report_end(double t) const {
  const Scenario& s = stage_.scenario;
  const MPI_Comm comm = stage_.d.mesh.comm();
  const double left = stage_.ledger.energy_error();
  tell_of_impacts();
  tell_of_penalties();
  tell_of_flutter();
  tell_of_untouched();
  tell_of_small_loads();
  if (!warning_.empty())
    check(PetscPrintf(comm, "impact: WARNING, first of its kind: %s; at the end %.3g\n", warning_.c_str(),
                      left));
  else if (s.energy_tol > 0 && std::abs(left) > s.energy_tol && stage_.ledger.energy_scale() >= least_)
    check(PetscPrintf(comm, "impact: WARNING: %s; %s\n", text(t, "energy_tol", s.energy_tol).c_str(),
                      remedy().c_str()));
}

void EnergyWatch::tell_of_small_loads() const {
  if (stage_.ledger.unanswered() == 0) return;
  PetscReal atol = 0;
  check(SNESGetTolerances(stage_.coupling.motion_solver().snes(), &atol, nullptr, nullptr, nullptr, nullptr));
  check(PetscPrintf(stage_.d.mesh.comm(),
                    "impact: WARNING: in %d steps loads moved nothing, for they are less than the absolute "
                    "tolerance of the motion, %.3g: give a smaller -motion_snes_atol\n",
                    stage_.ledger.unanswered(), static_cast<double>(atol)));
}

// The update of a step closes gaps as an impact of plastic bodies does. Points that strike one after the
// other, as on round bodies, do so each by itself.
void EnergyWatch::tell_of_impacts() const {
  const Scenario& s = stage_.scenario;
  const double part = stage_.ledger.exchanged().struck / stage_.ledger.energy_scale();
  const ContactSet& contacts = stage_.setup->contacts;
  if (s.energy_tol == 0 || part <= s.energy_tol ||
      std::ranges::any_of(contacts, [](const ContactInterface& contact) { return contact.by_impulse(); }))
    return;
  check(PetscPrintf(
      stage_.d.mesh.comm(), "impact: %s took %.2g of the largest energy (dissipated_contact), %s\n",
      s.explicit_steps() ? "springs of contacts that were lost" : "impacts", part,
      s.explicit_steps() ? "where places went deeper than surfaces are seen or round an edge: a larger "
                           "-contact_<id>_penalty or smaller facets there lose less"
                         : "as those of plastic bodies do: shorter steps take less, -contact_<id>_impact "
                           "conserving nothing"));
}

// A contact whose springs hold as much as the bodies is as soft as these are.
void EnergyWatch::tell_of_penalties() const {
  const Scenario& s = stage_.scenario;
  if (s.energy_tol == 0 || !(strain_then_ > 0) || most_held_ < least_ ||
      most_held_ <= soft * (most_held_ + strain_then_))
    return;
  check(PetscPrintf(
      stage_.d.mesh.comm(),
      "impact: penalties of contacts held %.2g of the elastic energy of bodies when they held most "
      "(energy_contact): what presses goes in by about that part of its way; finer cells or a larger "
      "-contact_<id>_penalty make them stiffer%s\n",
      most_held_ / strain_then_,
      s.explicit_steps() ? ", with -contact_<id>_enforce impulse there are none" : ""));
}

// What slides and has inertia but no damping takes up energy from friction at any speed (theory.md, 7).
void EnergyWatch::tell_of_flutter() const {
  if (!stage_.inertia) return;
  for (const ContactInterface& contact : stage_.setup->contacts) {
    const double times = contact.reopenings();
    if (!contact.frictional() || times <= restless) continue;
    check(PetscPrintf(
        stage_.d.mesh.comm(),
        "impact: contact %s: what pressed opened and closed again %.0f times, on average: bodies that rub "
        "and have no damping take up vibrations (flutter), slip farther by them and lose more than in a slow "
        "process; where that is what is meant, give them %s\n",
        contact.settings().id.c_str(), times,
        stage_.scenario.explicit_steps()
            ? "a viscosity: -material_<id>_b_d of about friction/5 * sqrt(E rho) * thickness"
            : "-ts_newmark_rho 0.5"));
  }
}

// Sides that are not those that meet, or a plane whose normal points into the bodies, bear nothing.
void EnergyWatch::tell_of_untouched() const {
  for (const ContactInterface& contact : stage_.setup->contacts) {
    const ContactMeasures m = contact.measures(stage_.u);
    if (m.active > 0 || m.work != 0 || std::ranges::any_of(m.impulse, [](double part) { return part != 0; }))
      continue;
    const ContactSettings& settings = contact.settings();
    // Facets that are long beside a round obstacle are apart from it in the mean where one point touches.
    const bool coarse = settings.radius > 0 && settings.method == ContactMethod::mortar &&
                        contact.constraints().mean_length() > settings.radius / 4;
    check(PetscPrintf(
        stage_.d.mesh.comm(),
        "impact: contact %s: nothing pressed in this run, %s; where something should have: are these "
        "the sides that meet, and does the normal of a plane point away from its body%s\n",
        contact.id().c_str(),
        std::isnan(m.gap_min) ? "and nothing faces the other side"
                              : text_of("the smallest gap at its end is %.4g", m.gap_min).c_str(),
        coarse ? text_of(", or are facets of %.3g too long beside a radius of %.3g, for gaps that are means "
                         "over them (-contact_%s_method gpts looks at points)",
                         contact.constraints().mean_length(), settings.radius, contact.id().c_str())
                     .c_str()
               : ""));
  }
}

std::string EnergyWatch::text(double t, const char* option, double bound) const {
  const double residual = stage_.ledger.energy_error(), scale = stage_.ledger.energy_scale();
  const double first_law = stage_.ledger.balance_first_law();
  const bool gain = residual - std::max(0.0, first_law) > std::abs(first_law);
  char text[240];
  std::snprintf(
      text, sizeof(text),
      "energy balance: %s %.3g exceeds -%s %.3g at t = %.10g: %.4g of energy %s since t = 0, the largest is "
      "%.4g",
      gain ? "`gain` of contact and integrator" : "first-law residual", std::abs(residual), option, bound, t,
      std::abs(residual) * scale, residual > 0 ? "gained" : "lost", scale);
  return text;
}

std::string EnergyWatch::remedy() const {
  std::string text = step_remedy();
  for (const MaterialAssignment& material : stage_.d.materials)
    if (material.law.parameters.locking == Locking::fbar) {
      text += "; the forces of -material_" + material.id +
              "_locking fbar have no energy, and under large strains no step closes their balance";
      break;
    }
  for (const InitialCondition& ic : stage_.scenario.ics)
    if (ic.phi)
      return text + "; if the first step alone made the error, the damage of -ic_" + ic.id +
             "_phi is not that of a crack at rest, and relaxes: the run is sound without the bound";
  return text;
}

namespace {

// A condition that moves nodes at t = 0 already, where the rest of a body stands still; empty: none.
std::string moved_at_start(const Scenario& s) {
  constexpr double origin[3] = {0, 0, 0}, other[3] = {1, 1, 1};
  for (const BoundaryCondition& bc : s.bcs)
    for (const std::optional<Expression>& u : bc.component)
      if (bc.type == BcType::displacement && u && ((*u)(origin, 3, 0) != 0 || (*u)(other, 3, 0) != 0))
        return u->key();
  return "";
}

// What friction has turned into heat, and whether what rubs opens and closes all the time.
std::pair<double, bool> rubbing(const RunStage& stage) {
  std::pair<double, bool> all = {0, false};
  for (const ContactInterface& contact : stage.setup->contacts) {
    if (!contact.frictional()) continue;
    all.first += contact.measures(stage.u).dissipated;
    all.second = all.second || contact.reopenings() > restless;
  }
  return all;
}

std::string lag_of_damage(const Scenario& s) {
  for (const MaterialScenario& m : s.materials)
    if (m.law.damage != Damage::none && m.law.ge == Degradation::ductile)
      return "likely damage lags behind by a step: -material_" + m.id +
             "_ge ductile knows the plastic strain of the step's start (theory, E17), whatever the passes; "
             "take smaller steps, as -ts_adapt_dalpha 0.01 does, to tell";
  return "likely a crack ran within a step, whose energy nothing takes up without inertia, or damage lags "
         "behind: take smaller steps or more coupling passes (-coupling_snes_max_it) to tell";
}

} // namespace

std::string EnergyWatch::step_remedy() const {
  const bool inertia = stage_.inertia, damage = stage_.d.has_damage();
  const double error = stage_.ledger.energy_error() * stage_.ledger.energy_scale();
  const bool gained = error > 0;
  const bool by_itself = stage_.scenario.explicit_steps();
  const int passes = stage_.scenario.coupling.max_it;
  const bool few = damage && passes < 10 && !by_itself;
  const double missed = stage_.ledger.exchanged().missed;
  const auto [rubbed, flutters] = rubbing(stage_);
  if (!inertia && gained && rubbed > error)
    return "likely friction began or grew within steps, by which its work, the mean of both ends, is not "
           "what "
           "turns into heat: take a shorter -ts_dt to tell";
  if (!inertia && !gained && !stage_.setup->contacts.empty() && missed > -0.5 * error)
    return "likely because gaps of contacts closed within steps, by which the work of their pressure is too "
           "large, as if it had acted all along: take a shorter -ts_dt to tell";
  if (!inertia && !gained && damage) return lag_of_damage(stage_.scenario);
  if (damages_in_cycles(stage_))
    return "likely much of a body damaged within a step of a cycle, whose work the trapezoidal rule takes "
           "from the forces at both ends alone: take a shorter -ts_dt to tell; damage itself knows of no "
           "error, and -energy_stop 0 lets two steps make a cycle";
  if (const std::string key = moved_at_start(stage_.scenario);
      !inertia && !gained && !key.empty() && stage_.scenario.ics.empty())
    return "likely because of " + key +
           ", which is not 0 at the start: its nodes stand moved there beside a body at rest, and the energy "
           "of that is lost in the first step; let it grow from 0, as in 0.001*min(t,1)";
  if (!inertia && !gained && !stage_.d.has_heat())
    return "likely a body snapped or buckled within a step, whose energy nothing takes up without inertia, "
           "or steps are too long: take a shorter -ts_dt to tell";
  if (by_itself && gained && stage_.ledger.exchanged().struck < -0.5 * error)
    return "likely because places of a contact came to lie deep in facets that they had not seen, at a "
           "corner or "
           "under the front of what slides, and were pushed out: exchange the sides of the contact, the "
           "larger one "
           "as _primary, or take smaller facets there";
  std::string text = gained ? "likely the steps are too long for what changes its stiffness in them"
                            : "likely the steps are too long";
  if (few)
    text += ", or damage lags behind the motion in " + std::to_string(passes) + " pass" +
            (passes == 1 ? "" : "es");
  if (by_itself) {
    const int every = stage_.scenario.coupling.damage_every;
    if (gained && flutters)
      text += ", or what rubs takes up vibrations (flutter): give bodies a viscosity (-material_<id>_b_d)";
    return text + (every > 1 ? ", or damage is solved too rarely: take a smaller -ts_dt_cfl or -damage_every"
                             : ": take a smaller -ts_dt_cfl");
  }
  text += ": take a shorter -ts_dt";
  if (!inertia && gained) text += ", or -energy_action cut for the steps that gain";
  if (few) text += ", -coupling_snes_max_it 50";
  // Beside contact the trapezoidal rule exchanges nothing with its forces (src/theory.md, S4).
  const bool damps = integrator_of(stage_.ts).alpha_m > 1;
  if (inertia && gained)
    text += damps && !stage_.setup->contacts.empty() ? ", -ts_newmark_rho 1" : ", -ts_newmark_rho 0.5";
  // The form of the entropy misses the square of the change of temperature in a step.
  if (stage_.d.has_heat() && stage_.scenario.heat.form == HeatForm::entropy) text += ", -heat_form energy";
  return text;
}

} // namespace impact
