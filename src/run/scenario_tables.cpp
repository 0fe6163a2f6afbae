#include "scenario_tables.hpp"
#include <cmath>
#include <impact/petsc/error.hpp>
#include <sstream>

namespace impact {

namespace {

using Global = Scenario;

OptionGroup general_group() {
  return {
      "General",
      "",
      {
          text_row<Global>("title", &Scenario::title, {"printed at the head of the log and of the outputs"},
                           "text"),
          text_row<Global>("output_dir", &Scenario::output_dir,
                           {"everything that a run writes goes below it; made if missing", "."}, "path"),
          flag_row<Global>("output_overwrite", &Scenario::overwrite,
                           {"a run that starts anew replaces what an earlier one left in its folder, instead "
                            "of moving it to earlier_1, earlier_2, ..",
                            "off"}),
          choice_row<Global, UnitSystem>("units", &Scenario::units,
                                         {"system of bare numbers and of everything that is written", "SI"},
                                         {{"SI", *unit_system("SI")},
                                          {"mm_t_s_MPa", *unit_system("mm_t_s_MPa")},
                                          {"mm_kg_ms_GPa", *unit_system("mm_kg_ms_GPa")}}),
          count_row<Global>("dim", &Scenario::dim, {"expected dimension of the mesh", "from the mesh"}, 2, 3),
          choice_row<Global, PlaneMode>("plane", &Scenario::plane,
                                        {"kind of a 2D problem: a body that cannot expand along z, a sheet "
                                         "that may, or a ring, where x "
                                         "is the radius",
                                         "strain"},
                                        {{"strain", PlaneMode::strain},
                                         {"stress", PlaneMode::stress},
                                         {"axisymmetric", PlaneMode::axisymmetric}}),
          list_row<Global>("physics", &Scenario::physics,
                           {"balances that are solved; of what is left out, options and conditions have no "
                            "effect, and without motion bodies stay where they are",
                            "motion, and what has data of damage and heat"},
                           {"motion", "damage", "heat"}),
          number_row<Global>("thickness", &Scenario::thickness,
                             {"of a plane problem; forces and energies are for it", "1", "m"}, positive),
          flag_row<Global>("dry_run", &Scenario::dry_run,
                           {"check everything, print the resolved input and the reports, stop", "off"}),
          flag_row<Global>(
              "options_strict", &Scenario::strict,
              {"options of PETSc's that the solvers of this run do not read are refused, not only told",
               "off"}),
          flag_row<Global>("test_restep", &Scenario::restep,
                           {"every step is solved, refused and solved again: a test of the program", "off"}),
      }};
}

// A restart takes the mesh from its checkpoint and may do without the file.
OptionRow<Global> mesh_row() {
  auto row =
      file_row<Global>("mesh", [](auto& s) -> auto& { return s.mesh.file; },
                       {"a .msh file (4.1), or a .geo file from which gmsh makes one; a restart goes on "
                        "with the mesh in its checkpoint",
                        "required"});
  const auto existing = row.read;
  row.read = [existing](Global& s, const GivenOption& option, const OptionContext& context) {
    const std::string restart = option_text("restart").value_or("none");
    try {
      existing(s, option, context);
    } catch (const UserError&) {
      if (restart == "none" || option.text.empty()) throw;
      s.mesh.file = option.text;
    }
  };
  return row;
}

OptionGroup mesh_group() {
  return {
      "Mesh",
      "`-mesh_set_<name> value` sets the constant `<name>` of a .geo file to a number or one word. A .geo "
      "file is a "
      "program: gmsh runs shell commands that stand in it (`SystemCall`), so take none from people you do "
      "not trust.",
      {
          mesh_row(),
          number_row<Global>(
              "mesh_scale", [](auto& s) -> auto& { return s.mesh.scale; },
              {"factor of all coordinates of the file", "1", "1"}, positive),
          count_row<Global>(
              "dm_refine", [](auto& s) -> auto& { return s.mesh.refine; },
              {"uniform refinements after reading", "0"}, 0, 10),
          number_row<Global>(
              "mesh_cells", [](auto& s) -> auto& { return s.mesh.most_cells; },
              {"most cells that -dm_refine may make", "2e6", "1"}, positive),
          number_row<Global>(
              "mesh_wall", [](auto& s) -> auto& { return s.mesh.patience; },
              {"seconds on the clock after which gmsh is stopped; 0: never", "600", "1"}, not_negative),
      }};
}

OptionGroup coupling_group() {
  return {
      "Coupling and damage",
      "Motion and damage are solved in turn, each with the other one frozen; each such turn is a pass.",
      {
          count_row<Global>(
              "coupling_snes_max_it", [](auto& s) -> auto& { return s.coupling.max_it; },
              {"largest number of passes in a step",
               "1; with -ts_type static and damage or thermal "
               "expansion 200, not counting passes in which a crack grows"},
              1),
          number_row<Global>(
              "coupling_snes_atol", [](auto& s) -> auto& { return s.coupling.atol; },
              {"passes end when phi changes less than this anywhere, and the temperature less than this part "
               "of itself",
               "1e-4", "1"},
              positive),
          number_row<Global>(
              "coupling_theta_tol", [](auto& s) -> auto& { return s.coupling.theta_tol; },
              {"passes end when the temperature changes less than this part of its largest value, where a "
               "material expands with it",
               "-coupling_snes_atol", "1"},
              positive, {{"", -1.}}),
          flag_row<Global>("coupling_error", [](auto& s) -> auto& { return s.coupling.report_error; },
                           {"column coupling_error: nodal forces that the phi and theta of the end of a step "
                            "would change, "
                            "over those that the last pass balanced; costs one residual in a step",
                            "off"}),
          choice_row<Global, PassRelaxation>(
              "coupling_relaxation", [](auto& s) -> auto& { return s.coupling.relaxation; },
              {"what the next pass starts from: phi extrapolated along the last two passes (Aitken), or phi "
               "itself",
               "aitken"},
              {{"aitken", PassRelaxation::aitken}, {"none", PassRelaxation::none}}),
          choice_row<Global, DamageForm>(
              "damage_form", [](auto& s) -> auto& { return s.damage.form; },
              {"damage equation as it stands, or divided by its rate coefficient (the paper's)", "multiplied",
               "", "", "(111)"},
              {{"multiplied", DamageForm::multiplied}, {"divided", DamageForm::divided}}),
          number_row<Global>(
              "damage_theta", [](auto& s) -> auto& { return s.damage.theta; },
              {"time weight of the damage equation: 1 backward Euler, 0.5 trapezoid", "1", "1", "theta"},
              {0, 1, true, false}),
          number_row<Global>(
              "damage_ts_dt", [](auto& s) -> auto& { return s.damage.substep; },
              {"the damage equation takes sub-steps of that length at most, with form multiplied "
               "and theta 1; their own method is chosen by -damage_ts_type",
               "none", "s"},
              positive, {{"", 0.}}),
          choice_row<Global, DamageBounds>("damage_bounds", [](auto& s) -> auto& { return s.damage.bounds; },
                                           {"how phi_n <= phi <= 1 is kept: bound-constrained solve, "
                                            "committed largest drive, cut off afterwards, "
                                            "not at all",
                                            "vi"},
                                           {{"vi", DamageBounds::vi},
                                            {"history", DamageBounds::history},
                                            {"clip", DamageBounds::clip},
                                            {"none", DamageBounds::none}}),
          choice_row<Global, TangentChoice>(
              "motion_tangent", &Scenario::tangent,
              {"derivative of the residual, or its symmetric part (auto: where the linear solver needs it)",
               "auto"},
              {{"auto", TangentChoice::automatic},
               {"consistent", TangentChoice::consistent},
               {"symmetric", TangentChoice::symmetric}}),
          choice_row<Global, std::optional<MatrixFormat>>(
              "motion_mat_type", &Scenario::matrix,
              {"matrix of motion: all entries, or the blocks on and above the diagonal, which need a "
               "symmetric tangent and one of the preconditioners cholesky, icc, bjacobi, jacobi and none "
               "(auto: the blocks where the program chooses conjugate gradients and nothing hinders)",
               "auto"},
              {{"auto", std::nullopt}, {"aij", MatrixFormat::aij}, {"sbaij", MatrixFormat::sbaij}}),
          number_row<Global>(
              "motion_reuse_tangent", [](auto& s) -> auto& { return s.coupling.reuse; },
              {"the tangent serves on while an iteration with it leaves at most this part of the "
               "residual; 0: full Newton",
               "0.1 with a direct solver, else 0", "1"},
              {0, 1, false, false}, {{"", -1.}}),
          choice_row<Global, ContactOperator>(
              "contact_operator", &Scenario::contact_operator,
              {"contact terms in the matrix, or beside it as an operator", "assembled"},
              {{"assembled", ContactOperator::assembled}, {"shell", ContactOperator::shell}}),
      }};
}

OptionGroup heat_group() {
  return {"Heat",
          "Solved after motion and damage in each pass, where materials have a heat capacity.",
          {
              choice_row<Global, HeatForm>(
                  "heat_form", [](auto& s) -> auto& { return s.heat.form; },
                  {"which balance is solved: that of entropy never loses any (second law), that of internal "
                   "energy "
                   "closes the first law to rounding; they differ by the error of the time step",
                   "entropy", "", "", "(45')"},
                  {{"entropy", HeatForm::entropy}, {"energy", HeatForm::energy}}),
              number_row<Global>(
                  "heat_theta", [](auto& s) -> auto& { return s.heat.theta; },
                  {"time weight of the heat balance: 1 backward Euler, 0.5 trapezoid", "1", "1", "theta"},
                  {0.5, 1, false, false}),
              number_row<Global>("heat_ts_dt", [](auto& s) -> auto& { return s.heat.substep; },
                                 {"heat takes sub-steps of that length at most, over which motion and damage "
                                  "go on evenly; not where heat passes contacts",
                                  "none", "s"},
                                 positive, {{"", 0.}}),
          }};
}

// What PETSc's integrator reads itself: checked and listed here, handed over as a plain number.
OptionRow<Global> time_row(const std::string& name, const OptionNote& note, const Interval& range,
                           bool whole = false) {
  const int least = whole ? static_cast<int>(range.low) : 0;
  return {name,
          note,
          whole ? any_number : range,
          whole ? "whole number >= " + std::to_string(least) : "",
          [=](Global& s, const GivenOption& option, const OptionContext& context) {
            s.time.of_petsc[name] = whole ? read_count(option, least, std::numeric_limits<int>::max())
                                          : read_number(option, note.unit, range, {}, context.units);
          },
          [=](const Global& s) {
            const auto found = s.time.of_petsc.find(name);
            return found == s.time.of_petsc.end() ? std::string() : number_text(found->second);
          }};
}

OptionGroup time_group() {
  return {
      "Time",
      "`-ts_max_time`, `-ts_times` and the `_times` of outputs are hit exactly.",
      {
          choice_row<Global, std::string>(
              "ts_type", [](auto& s) -> auto& { return s.time.type; },
              {"Newmark's method, or no inertia (t is the load factor)", "newmark", "", "", "(97)-(98)"},
              {{"newmark", "newmark"}, {"static", "static"}}),
          number_row<Global>("ts_dt", [](auto& s) -> auto& { return s.time.dt; },
                             {"time step; after a cut it grows back up to this", "required without -ts_times",
                              "s", "Delta t"},
                             positive, {{"", 0.}}),
          number_row<Global>("ts_adapt_dphi", [](auto& s) -> auto& { return s.coupling.max_dphi; },
                             {"largest growth of phi in a step: dt shrinks down to a thousandth of -ts_dt "
                              "while a crack runs faster; 0: no limit",
                              "0", "1"},
                             {0, 1}),
          number_row<Global>(
              "ts_adapt_dalpha", [](auto& s) -> auto& { return s.coupling.max_dalpha; },
              {"largest growth of the plastic strain at a point in a step, likewise; 0: no limit", "0", "1"},
              not_negative),
          number_row<Global>(
              "ts_adapt_dtheta", [](auto& s) -> auto& { return s.coupling.max_dtheta; },
              {"largest change of the temperature at a node in a step, likewise; 0: no limit", "0", "K"},
              not_negative),
          number_row<Global>(
              "ts_adapt_closing", [](auto& s) -> auto& { return s.coupling.max_closing; },
              {"with inertia: a step in which the bodies, at their present speeds, would go deeper into each "
               "other "
               "than this many mean secondary facets is cut before it is solved; 0: no limit",
               "1", "1"},
              not_negative),
          number_row<Global>(
              "ts_period", [](auto& s) -> auto& { return s.time.period; },
              {"of a cyclic load: steps hit the ends and the middles of its cycles exactly", "none", "s"},
              positive, {{"", 0.}}),
          number_row<Global>("ts_max_time", [](auto& s) -> auto& { return s.time.max_time; },
                             {"end of the run", "required without -ts_times", "s"}, positive, {{"", 0.}}),
          count_row<Global>(
              "ts_max_steps", [](auto& s) -> auto& { return s.time.max_steps; },
              {"largest number of steps", "no limit"}, 1),
          number_row<Global>(
              "ts_substeps", [](auto& s) -> auto& { return s.time.most_substeps; },
              {"most sub-steps in a step that -damage_ts_dt and -heat_ts_dt may make", "1e5", "1"}, {1}),
          numbers_row<Global>(
              "ts_times", [](auto& s) -> auto& { return s.time.table_times; },
              {"times between which the steps of -ts_dts hold, one more than these", "", "s"}, not_negative),
          numbers_row<Global>(
              "ts_dts", [](auto& s) -> auto& { return s.time.table_dts; },
              {"time steps between the times of -ts_times", "", "s"}, positive),
          time_row("ts_newmark_rho",
                   {"spectral radius at infinite frequency: 1 damps nothing, 0 most; sets beta and gamma",
                    "1", "1", "rho", "(97)-(98)"},
                   {0, 1, false, false}),
          time_row("ts_newmark_beta", {"Newmark's beta, without -ts_newmark_rho", "1/4", "1", "beta"},
                   {0, 1, true, false}),
          time_row("ts_newmark_gamma", {"Newmark's gamma, without -ts_newmark_rho", "1/2", "1", "gamma"},
                   {0.5, 2, false, false}),
          time_row("ts_adapt_grow", {"factor of the step after enough easy ones", "1.5", "1"}, {1}),
          time_row("ts_adapt_easy_steps", {"easy steps in a row before the step grows", "4"}, {1}, true),
          time_row("ts_adapt_easy_its", {"most iterations of an easy step", "10"}, {0}, true),
          time_row("ts_adapt_scale_solve_failed", {"factor of the step after a failed try", "0.5", "1"},
                   {0, 1}),
          time_row("ts_adapt_dt_min", {"shortest step", "1e-10 of -ts_dt", "s"}, positive),
          time_row("ts_adapt_dt_max", {"longest step", "-ts_dt", "s"}, positive),
          time_row("ts_max_reject", {"refused tries of a step after which the run gives up", "10"}, {0},
                   true),
      }};
}

OptionGroup history_group() {
  return {
      "Energy balance and cracks",
      "",
      {
          number_row<Global>("energy_tol", &Scenario::energy_tol,
                             {"bound of the first law's residual, with what is gained, over the largest "
                              "energy: a warning in "
                              "the fifth step in a row beyond it, and at the end of a run beyond it; 0: none",
                              "0.02", "1"},
                             not_negative),
          number_row<Global>("energy_stop", &Scenario::energy_stop,
                             {"residual that ends the run, but for losses in statics; 0: none", "0.2", "1"},
                             not_negative),
          choice_row<Global, Scenario::EnergyAction>("energy_action", &Scenario::energy_action,
                                                     {"what happens beyond the bound", "warn"},
                                                     {{"warn", Scenario::EnergyAction::warn},
                                                      {"cut", Scenario::EnergyAction::cut},
                                                      {"stop", Scenario::EnergyAction::stop}}),
          number_row<Global>("crack_level", &Scenario::crack_level,
                             {"phi from which a node counts as cracked in the history", "0.9", "1"},
                             {0, 1, true, false}),
          count_row<Global>(
              "crack_tips", &Scenario::crack_tips,
              {"cracks of each material whose origins and tips are in the history, by age", "1"}, 1, 99),
          flag_row<Global>(
              "history_materials", &Scenario::history_materials,
              {"energies of fracture and fatigue and all dissipations of each material in the history",
               "off"}),
      }};
}

constexpr const char* duration_form = "seconds, m:ss or h:mm:ss";

/// Seconds of "3:50:00", "50:00" or "3000"; nothing else. Minutes and seconds behind a colon are below 60.
double read_duration(const GivenOption& option) {
  double seconds = 0;
  std::istringstream parts(option.text);
  int count = 0;
  bool good = !option.text.empty() && option.text.back() != ':';
  for (std::string part; good && std::getline(parts, part, ':'); ++count) {
    const bool digits = part.find_first_not_of("0123456789.") == std::string::npos;
    const auto value = digits ? parse_number(part) : std::nullopt;
    good = value && (count == 0 || *value < 60) && count < 3;
    if (good) seconds = 60 * seconds + *value;
  }
  if (!good || !(seconds > 0) || !std::isfinite(seconds))
    refuse_option(option, std::string("is no duration; allowed: ") + duration_form);
  return seconds;
}

OptionRow<Scenario> walltime_row() {
  return {"walltime",
          {"wall time of the job: in time before it ends the run writes a checkpoint and stops with exit "
           "status 0",
           "none"},
          {},
          duration_form,
          [](Scenario& s, const GivenOption& option, const OptionContext&) {
            s.checkpoint.walltime = read_duration(option);
          },
          [](const Scenario& s) {
            return s.checkpoint.walltime > 0 ? number_text(s.checkpoint.walltime) : std::string();
          }};
}

OptionGroup checkpoint_group() {
  return {
      "Checkpoints",
      "SIGUSR1 asks for a checkpoint; SIGUSR2, SIGTERM, SIGXCPU, SIGINT (Ctrl-C) and SIGHUP for a checkpoint "
      "and the end of the run (exit status 0), each at the end of the step; one rank is enough, and a second "
      "SIGINT ends it at once. However a run ends, its last state is in a checkpoint, so that a later end "
      "computes nothing twice. On restart mesh, dimension and units cannot change; parameters, materials, "
      "conditions, contacts, the damage equation and the time scheme only with `-restart_allow`; solvers, "
      "output, end time and time step at will.",
      {
          text_row<Global>(
              "checkpoint_dir", [](auto& s) -> auto& { return s.checkpoint.dir; },
              {"folder of the checkpoints", "<output_dir>/checkpoints"}, "path"),
          number_row<Global>(
              "checkpoint_wall", [](auto& s) -> auto& { return s.checkpoint.wall; },
              {"seconds on the clock between checkpoints; 0: none by the clock", "600", "1"}, not_negative),
          count_row<Global>(
              "checkpoint_every", [](auto& s) -> auto& { return s.checkpoint.every; },
              {"steps between checkpoints; 0: none by steps", "0"}, 0),
          count_row<Global>(
              "checkpoint_keep", [](auto& s) -> auto& { return s.checkpoint.keep; },
              {"newest checkpoints that stay", "2"}, 1),
          number_row<Global>(
              "checkpoint_patience", [](auto& s) -> auto& { return s.checkpoint.patience; },
              {"seconds, beside one per megabyte, after which a write that does not end is given up with "
               "exit "
               "status 4",
               "60", "1"},
              positive),
          walltime_row(),
          number_row<Global>(
              "walltime_margin", [](auto& s) -> auto& { return s.checkpoint.walltime_margin; },
              {"seconds of -walltime that are left when the run stops, beside one step and one checkpoint",
               "auto: a tenth, at most 60", "1"},
              not_negative, {{"auto", -1.}}),
          text_row<Global>(
              "restart", [](auto& s) -> auto& { return s.checkpoint.restart; },
              {"go on from the newest checkpoint if there is one, from the start, or from a file", "none"},
              "auto, none, path of a checkpoint"),
          list_row<Global>(
              "restart_allow", [](auto& s) -> auto& { return s.checkpoint.restart_allow; },
              {"options, or their beginnings such as bc_push, that may differ from the checkpoint's"}),
      }};
}

} // namespace

std::vector<OptionGroup> global_groups() {
  return {general_group(), mesh_group(),    coupling_group(),  heat_group(),
          time_group(),    history_group(), checkpoint_group()};
}

std::vector<OptionRow<Scenario>> global_rows() {
  std::vector<OptionRow<Scenario>> rows;
  for (OptionGroup& group : global_groups())
    rows.insert(rows.end(), std::make_move_iterator(group.rows.begin()),
                std::make_move_iterator(group.rows.end()));
  return rows;
}

std::vector<std::string> other_global_names() {
  return {"params",  "functions", "materials", "bcs",   "ics",  "contacts",
          "outputs", "probes",    "measures",  "stops", "help", "reference"};
}

} // namespace impact
