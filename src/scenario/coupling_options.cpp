#include "classes.hpp"
#include <algorithm>
#include <cmath>

/// The options of the coupling of motion, damage and heat, of their solution, and of the damage and heat
/// equations.
namespace impact {

namespace {

/// Half of an unsymmetric matrix would be taken for all of it without a word: why it would be, "" = not.
std::string asymmetry(const Scenario& scenario) {
  const auto reason = [](const std::string& what, const std::string& allowed) {
    return "needs a symmetric tangent, that of " + what + " is not; allowed: " + allowed +
           "choose -motion_mat_type aij";
  };
  if (scenario.matrix != MatrixFormat::sbaij) return "";
  if (const auto [what, allowed] = unsymmetric_force(scenario); !what.empty())
    return reason(what, allowed + "; ");
  if (scenario.tangent == TangentChoice::symmetric) return "";
  for (const MaterialScenario& material : scenario.materials) {
    const bool flows = material.law.model == Model::j2, fbar = material.law.locking == Locking::fbar;
    if (flows || fbar)
      return reason("-material_" + material.id + (flows ? "_model j2" : "_locking fbar"),
                    "elastic materials without F-bar; add -motion_tangent symmetric, or ");
  }
  return "";
}

/// A wrong power of ten in the length of sub-steps makes a step that does not end.
template <class Length> void limit_substeps(OptionRow<Scenario>& row, Length length) {
  const auto count = [=](const Scenario& s) {
    return length(s) > 0 && s.time.dt > 0 ? s.time.dt / length(s) : 0;
  };
  row.barred([=](const Scenario& s) { return count(s) > s.time.most_substeps; },
             [=](const Scenario& s) {
               return ": makes " + number_text(std::round(count(s))) +
                      " sub-steps in each step of -ts_dt; allowed: at most " +
                      number_text(s.time.most_substeps) +
                      " (-ts_substeps); take longer ones, a shorter -ts_dt, or raise -ts_substeps";
             });
}

void add_passes(std::vector<OptionRow<Scenario>>& rows) {
  using Coupling = CouplingScenario;
  Rows row(rows, RestartKey::free, &Scenario::coupling);
  row.count("coupling_snes_max_it", &Coupling::max_it, 1, "largest number of passes in a step")
      .otherwise("1; with -ts_type static and damage or thermal expansion 200, not counting passes in which "
                 "a crack grows");
  row.number("coupling_snes_atol", &Coupling::atol, "1", positive,
             "passes end when phi changes less than this anywhere, and the temperature less than this part "
             "of itself")
      .otherwise("1e-4");
  row.number("coupling_theta_tol", &Coupling::theta_tol, "1", positive,
             "passes end when the temperature changes less than this part of its largest value, where a "
             "material expands with it")
      .otherwise("-coupling_snes_atol")
      .idle([](const Scenario& s) { return s.has_damage() && !s.has_heat(); },
            "no temperature is solved for");
  row.flag("coupling_error", &Coupling::report_error,
           "column coupling_error: nodal forces that the phi and theta of the end of a step would change, "
           "over those that the last pass balanced; costs one residual in a step");
  row.choice(
      "coupling_relaxation", &Coupling::relaxation,
      "what the next pass starts from: phi extrapolated along the last two passes (Aitken), or phi itself",
      "aitken", PassRelaxation::aitken, "none", PassRelaxation::none);
  for (OptionRow<Scenario>& each : rows)
    if (each.name.starts_with("coupling_"))
      each.idle([](const Scenario& s) { return !s.has_damage() && !s.has_heat(); },
                "neither damage nor a temperature is solved for")
          .idle([](const Scenario& s) { return s.explicit_steps() && (s.has_damage() || s.has_heat()); },
                "explicit steps pass once");
}

/// Order of a scalar field, which cannot exceed that of the cells.
OptionRow<Scenario>& order_of_field(OptionRow<Scenario>& row, int (*order)(const Scenario&)) {
  return row.refused([=](const Scenario& s) { return order(s) == 2 && s.mesh.order == 1; },
                     "is more than that of the cells; allowed: 1, or -order 2");
}

bool damages_at_once(const Scenario& s) {
  return std::ranges::any_of(s.materials, [](const MaterialScenario& m) {
    return m.law.damage != Damage::none && !std::isfinite(m.law.c);
  });
}

void add_damage_equation(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::guarded, &Scenario::damage);
  row.choice("damage_form", &DamageScenario::form,
             "damage equation as it stands, or divided by its rate coefficient (the paper's)", "multiplied",
             DamageForm::multiplied, "divided", DamageForm::divided)
      .notation("(111)")
      .refused([](const Scenario& s) { return s.damage.form == DamageForm::divided && damages_at_once(s); },
               "divides by a rate, and without one damage is in balance at once; give each material that "
               "damages a finite -material_<id>_c");
  order_of_field(
      row.count("damage_order", &DamageScenario::order, 1,
                "order of phi: 1 on cells of second order takes the mean of the corners in the middles", 2)
          .otherwise("1 with -damage_bounds vi on tetrahedra and serendipity cells, else that of the cells"),
      [](const Scenario& s) { return s.damage.order; })
      .refused([](const Scenario& s) { return s.damage.order == 1 && s.damage.explicit_substeps > 0; },
               "goes without -damage_substeps, which lump the equation at the nodes; remove one of them");
  row.number("damage_theta", &DamageScenario::theta, "1 theta", {0, 1, true, false},
             "time weight of the damage equation: 1 backward Euler, 0.5 trapezoid");
  limit_substeps(row.number("damage_ts_dt", &DamageScenario::substep, "s", positive,
                            "the damage equation takes sub-steps of that length at most, with form "
                            "multiplied and theta 1; their own method is chosen by -damage_ts_type")
                     .otherwise("none"),
                 [](const Scenario& s) { return s.damage.substep; });
  const auto by_rate = [](auto when) {
    return [=](const Scenario& s) { return s.damage.explicit_substeps > 0 && when(s); };
  };
  row.count(
         "damage_substeps", &DamageScenario::explicit_substeps, 0,
         "the rate law of damage explicitly, lumped at the nodes: no equation is solved, but each step has "
         "as many sub-steps as are stable, at most so many; nodes for which they are too long follow more "
         "slowly, and the log tells what part of its growth that takes; their method is "
         "-damage_ts_type euler, the default, or ssp; 0: the equation is solved")
      .refused(by_rate(damages_at_once),
               "without a rate damage is in balance at once; give each material that damages a finite "
               "-material_<id>_c")
      .refused(by_rate([](const Scenario& s) {
                 return s.damage.form != DamageForm::multiplied || s.damage.theta != 1 ||
                        s.damage.bounds != DamageBounds::vi || s.damage.substep > 0;
               }),
               "goes without -damage_form divided, -damage_theta, -damage_ts_dt and other bounds than vi; "
               "remove them, or this");
  Rows(rows, RestartKey::guarded, &Scenario::coupling)
      .count("damage_every", &CouplingScenario::damage_every, 1,
             "of central differences: damage is solved in every so many steps, over the time of all of them")
      .refused(
          [](const Scenario& s) {
            return !s.explicit_steps() || s.damage.theta != 1 || s.damage.bounds == DamageBounds::history;
          },
          "is for -ts_type central_difference, -damage_theta 1 and other -damage_bounds than history; take "
          "these, or remove it");
  row.choice("damage_bounds", &DamageScenario::bounds,
             "how phi_n <= phi <= 1 is kept: bound-constrained solve, committed largest drive, cut off "
             "afterwards, not at all",
             "vi", DamageBounds::vi, "history", DamageBounds::history, "clip", DamageBounds::clip, "none",
             DamageBounds::none);
  for (OptionRow<Scenario>& each : rows)
    if (each.name.starts_with("damage_")) each.idle(undamaged, no_damage);
}

void add_matrix(std::vector<OptionRow<Scenario>>& rows) {
  Rows row(rows, RestartKey::free);
  row.choice("motion_tangent", &Scenario::tangent,
             "derivative of the residual, or its symmetric part (auto: where the linear solver needs it)",
             "auto", TangentChoice::automatic, "consistent", TangentChoice::consistent, "symmetric",
             TangentChoice::symmetric);
  row.choice("motion_mat_type", &Scenario::matrix,
             "matrix of motion: all entries, or the blocks on and above the diagonal, which need a symmetric "
             "tangent and one of the preconditioners cholesky, icc, bjacobi, jacobi, two_level and none "
             "(auto: the "
             "blocks where the program chooses conjugate gradients and nothing hinders)",
             "auto", std::nullopt, "aij", MatrixFormat::aij, "sbaij", MatrixFormat::sbaij)
      .refused([](const Scenario& s) { return !asymmetry(s).empty(); }, asymmetry);
  Rows(rows, RestartKey::free, &Scenario::coupling)
      .number("motion_reuse_tangent", &CouplingScenario::reuse_tangent, "1", {0, 1, false, false},
              "the tangent serves on while an iteration with it leaves at most this part of the residual; 0: "
              "full Newton")
      .otherwise("0.1 with preonly and a direct solver, else 0");
  Rows(rows, RestartKey::free, &Scenario::coupling)
      .number("motion_reuse_preconditioner", &CouplingScenario::reuse_preconditioner, "1",
              {0, 1e6, false, false},
              "factors or a hierarchy serve on, over iterations and steps, until they took this many linear "
              "iterations more than new ones; 0: new ones for each solve")
      .otherwise("15 where a Krylov method has factors or a hierarchy, else 0");
  Rows(rows, RestartKey::free, &Scenario::coupling)
      .choice("motion_leave_unstable", &CouplingScenario::leave_unstable,
              "a static step that finds an unstable equilibrium, as past a load at which bodies buckle, goes "
              "on along its modes to a stable one (auto: where the body lies to one side); not with damage, "
              "flow, viscosity, contact, rigid bodies, F-bar, follower pressure",
              "auto", LeaveUnstable::imperfect, "on", LeaveUnstable::always, "off", LeaveUnstable::never)
      .idle([](const Scenario& s) { return s.has_inertia() || s.coupling.path_length > 0; },
            [](const Scenario& s) {
              return std::string(s.has_inertia() ? "the run has inertia"
                                                 : "-ts_path_length follows the bodies");
            });
  row.choice("contact_operator", &Scenario::contact_operator,
             "contact terms in the matrix, or beside it as an operator", "assembled",
             ContactOperator::assembled, "shell", ContactOperator::shell)
      .idle([](const Scenario& s) { return s.contacts.empty(); }, "there is no contact");
}

/// Whether motion waits for what damage and heat make of its solution.
bool iterates(const Scenario& scenario) {
  return scenario.has_damage() ||
         (scenario.has_heat() && std::ranges::any_of(scenario.materials, [](const auto& material) {
            return material.law.alpha_t != 0 || material.law.softening != Softening::none;
          }));
}

void complete_coupling(Scenario& scenario) {
  CouplingScenario& coupling = scenario.coupling;
  if (coupling.max_it == 0) { // not given
    const bool iterated = scenario.has_motion() && !scenario.has_inertia() && iterates(scenario);
    coupling.follow_cracks = iterated && scenario.has_damage() && coupling.path_dissipation == 0;
    coupling.max_it = iterated ? 200 : 1;
  }
  coupling.moves = scenario.has_motion();
  const TimeScenario& time = scenario.time;
  coupling.by_central_differences = {
      time.cfl, {time.bulk_linear, time.bulk_quadratic}, time.scaled_step, time.scaling_limit};
  coupling.crack_level = scenario.crack_level;
  coupling.length_unit = scenario.units.length == -3 ? "mm" : "m";
  const auto& steps = scenario.time.table_dts;
  coupling.dt = steps.empty() ? scenario.time.dt : *std::ranges::max_element(steps);
}

} // namespace

OptionGroup coupling_options() {
  OptionGroup group{
      "Coupling and damage",
      "Motion and damage are solved in turn, each with the other one frozen; each such turn is a pass."};
  add_passes(group.rows);
  add_damage_equation(group.rows);
  add_matrix(group.rows);
  group.complete = complete_coupling;
  return group;
}

OptionGroup heat_options() {
  OptionGroup group{"Heat",
                    "Solved after motion and damage in each pass, where materials have a heat capacity."};
  Rows row(group.rows, RestartKey::guarded, &Scenario::heat);
  row.choice("heat_capacity", &HeatScenario::lumped,
             "capacity matrix: lumped at the nodes, where sudden heat or cold leaves no temperature beyond "
             "those around it, or consistent (auto: lumped on cells of first order that conduct, where "
             "conditions, -ics, friction or rigid bodies bring heat; of that of flow and cracks lumping "
             "takes the peaks off, and of explicit steps a third of the time)",
             "auto", std::nullopt, "lumped", true, "consistent", false)
      .refused(
          [](const Scenario& s) { return s.heat.lumped == true && s.heat.order == 1 && s.mesh.order == 2; },
          "goes without -heat_order 1; allowed: auto, consistent")
      .notation("(45'')");
  row.choice(
         "heat_form", &HeatScenario::form_given,
         "which balance is solved: that of entropy never loses any (second law), that of internal energy "
         "closes the first law to rounding whatever integrator and dissipation do, so that -energy_tol then "
         "finds no error of theirs; they differ by the error of the time step (auto: energy where bodies "
         "only conduct, else entropy)",
         "auto", std::nullopt, "entropy", HeatForm::entropy, "energy", HeatForm::energy)
      .notation("(45')");
  order_of_field(row.count("heat_order", &HeatScenario::order, 1,
                           "order of the temperature, as -damage_order; not where heat passes a contact", 2)
                     .otherwise("that of the cells"),
                 [](const Scenario& s) { return s.heat.order; });
  row.number("heat_theta", &HeatScenario::theta, "1 theta", {0.5, 1, false, false},
             "time weight of the heat balance: 1 backward Euler, 0.5 trapezoid");
  limit_substeps(row.number("heat_ts_dt", &HeatScenario::substep, "s", positive,
                            "heat takes sub-steps of that length at most, over which motion and damage go on "
                            "evenly; not where heat passes contacts")
                     .otherwise("none"),
                 [](const Scenario& s) { return s.heat.substep; });
  for (OptionRow<Scenario>& each : group.rows) each.idle(unheated, no_heat);
  group.complete = [](Scenario& s) {
    s.heat.form =
        s.heat.form_given.value_or(s.has_motion() || s.has_damage() ? HeatForm::entropy : HeatForm::energy);
  };
  return group;
}

std::pair<std::string, std::string> unsymmetric_force(const Scenario& scenario) {
  for (const MaterialScenario& material : scenario.materials)
    if (material.law.model == Model::rigid)
      return {"-material_" + material.id + "_model rigid", "other models"};
  for (const BoundaryCondition& bc : scenario.bcs)
    if (bc.type == BcType::pressure) return {"-bc_" + bc.id + "_type pressure", "dead loads"};
  for (const ContactScenario& contact : scenario.contacts) {
    if (contact.rigid_mass > 0)
      return {"-contact_" + contact.id + "_rigid_mass", "rigid bodies that move as told"};
    if (contact.friction > 0) return {"-contact_" + contact.id + "_friction", "no friction"};
  }
  return {};
}

} // namespace impact
