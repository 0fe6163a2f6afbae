#include "classes.hpp"
#include <cmath>
#include <filesystem>
#include <sstream>

/// The options of the balance of energy and cracks, and of checkpoints and restarts.
namespace impact {

namespace {

constexpr const char* duration_form = "seconds, m:ss, h:mm:ss or none";

/// Seconds of "3:50:00", "50:00" or "3000"; nothing else. Minutes and seconds behind a colon are below 60.
double read_duration(const GivenOption& option) {
  if (option.text == "none") return 0;
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

void add_restart(std::vector<OptionRow<Scenario>>& rows) {
  using Checkpoint = CheckpointScenario;
  Rows row(rows, RestartKey::free, &Scenario::checkpoint);
  auto& walltime = row.number("walltime", &Checkpoint::walltime, "", or_word(any_number, "", 0),
                              "wall time of the job: in time before it ends the run writes a checkpoint and "
                              "stops with exit status 0")
                       .otherwise("none");
  walltime.allowed = duration_form;
  walltime.read = [](Scenario& s, const GivenOption& option, const OptionContext&) {
    s.checkpoint.walltime = read_duration(option);
  };
  row.number("walltime_margin", &Checkpoint::walltime_margin, "1", or_word(not_negative, "auto", -1.),
             "seconds of -walltime that are left when the run stops, beside one step and one checkpoint")
      .otherwise("auto: a tenth, at most 60")
      .refused(
          [](const Scenario& s) {
            return s.checkpoint.walltime > 0 && s.checkpoint.margin() >= s.checkpoint.walltime;
          },
          "leaves nothing of the wall time; allowed: less than -walltime, {walltime}")
      .idle([](const Scenario& s) { return s.checkpoint.walltime == 0; }, "-walltime is not given");
  row.text(
      "restart", &Checkpoint::restart, "auto, none, path of a checkpoint",
      "go on from the newest checkpoint if there is one, from the start, or from a file, which needs its "
      ".manifest beside it");
  row.list("restart_allow", &Checkpoint::restart_allow,
           "options, or their beginnings such as bc_push, that may differ from the checkpoint's; ts_type "
           "with all that belongs to a scheme, such as ts_newmark_rho");
}

} // namespace

OptionGroup balance_options() {
  OptionGroup group{"Energy balance and cracks", ""};
  Rows row(group.rows, RestartKey::free);
  row.number("energy_tol", &Scenario::energy_tol, "1", not_negative,
             "bound of the first law's residual, with what is gained, over the largest energy: a warning in "
             "the fifth step beyond it, in statics not counting those in which it shrinks, and at the end of "
             "a run beyond it; 0: none");
  row.number(
      "energy_stop", &Scenario::energy_stop, "1", not_negative,
      "residual that ends the run, in the fifth step likewise, but for losses in statics, where a step that "
      "strains bodies by 0.8 of the largest energy without work is first tried again with half its length, "
      "up to five "
      "times; 0: none");
  row.choice("energy_action", &Scenario::energy_action, "what happens beyond the bound", "warn",
             Scenario::EnergyAction::warn, "cut", Scenario::EnergyAction::cut, "stop",
             Scenario::EnergyAction::stop);
  row.number("crack_level", &Scenario::crack_level, "1", {0, 1, true, false},
             "phi from which a node counts as cracked in the history")
      .idle(undamaged, no_damage);
  row.count("crack_tips", &Scenario::crack_tips, 1,
            "cracks of each material whose origins and tips are in the history, by age", 99)
      .idle(undamaged, no_damage)
      .restart = RestartKey::guarded;
  row.flag("history_materials", &Scenario::history_materials,
           "energies of fracture and fatigue and all dissipations of each material in the history");
  return group;
}

OptionGroup checkpoint_options() {
  using Checkpoint = CheckpointScenario;
  OptionGroup group{
      "Checkpoints",
      "SIGUSR1 asks for a checkpoint; SIGUSR2, SIGTERM, SIGXCPU, SIGINT (Ctrl-C) and SIGHUP for a checkpoint "
      "and the end of the run (exit status 0), each at the end of the step; one rank is enough, and a second "
      "SIGINT ends it at once. However a run ends, its last state is in a checkpoint, so that a later end "
      "computes nothing twice. On restart mesh, dimension and units cannot change; parameters, materials, "
      "conditions, contacts, the damage equation and the time scheme only with `-restart_allow` (with "
      "`contacts,contact_<id>` a contact that is left out lets go, a tool that is taken away, and a new one "
      "begins); solvers, "
      "output, end time and time step at will. With another `-ts_type` the motion goes on from the "
      "displacement, damage, temperature, history and contact forces that are there, and the energies go on. "
      "Between schemes with inertia velocities stay too; what was loaded statically is let go, or struck by "
      "bodies with the velocities of `-ics`. Such a run has another history file where its columns differ, "
      "the contact method and multipliers of the run before, and no rigid bodies: explicit steps take `gpts` "
      "by a penalty where nothing is said, so that implicit ones that go on from them name "
      "`-contact_<id>_method gpts` and `-contact_<id>_enforce penalty`, and both in `-restart_allow` where "
      "the run before did not."};
  Rows row(group.rows, RestartKey::free, &Scenario::checkpoint);
  row.text("checkpoint_dir", &Checkpoint::dir, "path", "folder of the checkpoints")
      .otherwise("<output_dir>/checkpoints");
  row.number("checkpoint_wall", &Checkpoint::wall, "1", not_negative,
             "seconds on the clock between checkpoints; 0: none by the clock");
  row.count("checkpoint_every", &Checkpoint::every, 0, "steps between checkpoints; 0: none by steps");
  row.count("checkpoint_keep", &Checkpoint::keep, 1, "newest checkpoints that stay");
  row.number("checkpoint_patience", &Checkpoint::patience, "1", positive,
             "seconds, beside one per megabyte, after which a write that does not end is given up with exit "
             "status 4");
  add_restart(group.rows);
  group.complete = [](Scenario& s) {
    if (s.checkpoint.dir.empty()) s.checkpoint.dir = default_checkpoint_dir(s);
  };
  return group;
}

std::string default_checkpoint_dir(const Scenario& scenario) {
  return (std::filesystem::path(scenario.output_dir) / "checkpoints").string();
}

} // namespace impact
