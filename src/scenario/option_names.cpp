#include "classes.hpp"
#include <algorithm>
#include <cctype>
#include <impact/input/known_options.hpp>
#include <impact/petsc/error.hpp>
#include <set>
#include <sstream>

/// The check of option names: the set of legal names of ours is closed, PETSc is asked for its own.
namespace impact {

namespace {

const char* const solver_prefixes[] = {"motion_", "damage_", "heat_", "coupling_", "uzawa_"};
/// Beginnings under which no other name than ours exists.
const char* const own_prefixes[] = {"mesh_",   "checkpoint_", "restart_", "walltime_",
                                    "energy_", "crack_",      "history_"};
/// Refused by name, so that nobody believes that they had an effect.
const char* const not_available[] = {"ts_static_start", "ts_dt_cfl"};
/// PETSc's, behind the prefix of a solver whose name they end or begin: they would be displaced, or displace
/// what the solver lives on.
struct Displaced {
  const char *prefix, *beginning, *why;
};
const char* const no_grid = "no solver here has a PETSc grid or knows the exact solution";
const char* const cuts = "a solve that fails cuts the step; -ts_max_reject 0 ends the run then";
const char* const forgets =
    "a checkpoint keeps neither tangent nor factors; without it they serve on within a solve";
const Displaced displaced[] = {
    {"", "snes_fd", "the tangent is the exact derivative already"},
    {"", "snes_mf", "the tangent is the exact derivative already"},
    {"", "snes_test_jacobian", "the tangent is the exact derivative already; see -motion_tangent"},
    {"", "snes_convergence_test", "a solve ends when its residual is small; see _snes_rtol and _snes_atol"},
    {"", "snes_convergence_estimate", no_grid},
    {"", "snes_npc_", "the nonlinear solvers take no preconditioner"},
    {"", "snes_grid_sequence", "there is one mesh; see -dm_refine"},
    {"", "snes_norm_schedule", "Newton's method looks at the norm of each residual"},
    {"", "snes_function_type", "Newton's method looks at the norm of each residual"},
    {"", "snes_error_if_not_converged", cuts},
    {"", "snes_linesearch_norms", "Newton's method looks at the norm of each residual"},
    {"", "snes_linesearch_precheck_picard", "the steps are Newton's, not Picard's"},
    {"", "snes_monitor_fields", no_grid},
    {"", "snes_monitor_jacupdate_spectrum", "it assembles tangents that the solver does not know of"},
    {"", "ksp_error_if_not_converged", cuts},
    {"", "ksp_monitor_error", no_grid},
    {"", "ksp_view_diagonal_scale", no_grid},
    {"", "ksp_diagonal_scale", "a matrix that serves on would be scaled again; _pc_type jacobi scales"},
    {"", "ksp_constant_null_space", "constant vectors are no null space of any matrix here"},
    {"", "ksp_guess_type", "PETSc's guesses start anew with each matrix; see _ksp_initial_guess_nonzero"},
    {"", "ksp_matsolve_batch_size", "systems are solved one at a time"},
    {"motion_", "ksp_reuse_preconditioner",
     "SNES sets it in each iteration; see -motion_reuse_preconditioner"},
    {"", "ksp_reuse_preconditioner", "SNES sets it in each iteration; see _snes_lag_preconditioner"},
    {"", "pc_factor_in_place", "the factors have another pattern than the matrix"},
    {"", "pc_factor_nonzeros_along_diagonal", "no diagonal here has zeros, and PETSc crashes"},
    {"", "mat_factor_view", "see _ksp_view"},
    {"motion_", "snes_monitor_solution_update",
     "no update leads to a first iterate; see _snes_monitor_solution"},
    {"motion_", "snes_force_iteration", "a balanced step needs no iteration; see -motion_snes_rtol"},
    {"", "snes_lag_jacobian_persists", forgets},
    {"", "snes_lag_preconditioner_persists", forgets},
    {"motion_", "snes_lag_", "the program says when the tangent serves on; see -motion_reuse_tangent"},
    {"motion_", "ts_", "the integrator has no prefix; give -ts_..."},
    {"heat_", "ts_", "the heat's sub-steps take -heat_ts_dt alone"},
};
/// What a loop over passes reads, which is no solver in itself.
const char* const of_passes[] = {"snes_type",    "snes_max_it",           "snes_atol", "snes_stol",
                                 "snes_monitor", "snes_converged_reason", "snes_view"};
/// What the integrator reads beside our own options; PETSc's others are for integrators with an error
/// estimate.
const char* const of_time[] = {"ts_adapt_monitor", "ts_adapt_view", "ts_monitor", "ts_view",
                               "ts_max_snes_failures"};
/// Monitors that crash or tell nothing.
const Displaced blind_monitors[] = {
    {"ts_", "monitor_frequency", "the monitors tell of each step; see -output_<id>_every"},
    {"ts_", "monitor_envelope", "nothing asks for it; see -ts_monitor_extreme"},
    {"ts_", "monitor_error", no_grid},
    {"ts_", "monitor_lg_error", no_grid},
    {"ts_", "monitor_draw_error", no_grid},
    {"ts_", "monitor_draw_solution_function", no_grid},
    {"ts_", "monitor_sp_", no_grid},
    {"ts_", "monitor_dmda", no_grid},
    {"ts_", "monitor_lg_dmda", no_grid},
};

/// The names of a class of options.
struct ClassKeys {
  std::string word, registry;
  std::vector<std::string> attributes; ///< "" for `-param_<id>`
  std::vector<std::string> ids;
};

struct Legal {
  std::map<std::string, std::string> names; ///< lower case to the way we write it
  std::vector<std::string> globals = {"help", "reference"};
  std::vector<ClassKeys> classes;
};

Legal legal_names() {
  Legal legal;
  for_each_class([&](const auto& table) {
    legal.globals.push_back(table.registry);
    ClassKeys& keys = legal.classes.emplace_back(table.word, table.registry);
    for (const auto& row : table.rows) keys.attributes.push_back(row.name);
    if (table.inherits) keys.attributes.push_back("like");
    keys.ids = read_ids(table.registry);
    for (const std::string& id : keys.ids)
      for (const std::string& attribute : keys.attributes) {
        const std::string name = option_name(keys.word, id, attribute);
        legal.names[lower_case(name)] = name;
      }
  });
  for (const auto& row : global_rows()) legal.globals.push_back(row.name);
  for (const std::string& name : legal.globals) legal.names[lower_case(name)] = name;
  return legal;
}

[[noreturn]] void unknown(const std::string& name, const std::string& suggestion, const std::string& known) {
  if (name.find_first_of("*/+(^ ") != std::string::npos)
    throw UserError(ExitCode::usage, "unknown option -" + name +
                                         "; a value that begins with a minus needs brackets: (-" + name +
                                         ")");
  throw UserError(ExitCode::usage, "unknown option -" + name +
                                       (suggestion.empty() ? "" : "; did you mean -" + suggestion + "?") +
                                       (known.empty() ? "" : "   (" + known + ")"));
}

[[noreturn]] void unknown_in_class(const std::string& name, const ClassKeys& keys, const Legal& legal) {
  const std::string declared = keys.registry + ": " + (keys.ids.empty() ? "none declared" : join(keys.ids));
  const std::string rest = name.substr(keys.word.size() + 1);
  const std::size_t end = std::min(rest.find('_'), rest.size());
  const std::string typed_id = rest.substr(0, end), typed = end < rest.size() ? rest.substr(end + 1) : "";
  const std::string id = nearest_name(typed_id, keys.ids, typed_id.size() > 3 ? 2 : 1);
  if (id.empty())
    if (const std::string global = nearest_name(name, legal.globals, 2); !global.empty())
      unknown(name, global, "");
  if (id.empty()) unknown(name, "", "'" + typed_id + "' is not declared; " + declared);
  std::vector<std::string> attributes;
  for (const std::string& attribute : keys.attributes)
    if (!attribute.empty()) attributes.push_back(attribute);
  if (attributes.empty()) unknown(name, option_name(keys.word, id, ""), declared);
  const std::string attribute =
      nearest_name(typed, attributes, std::clamp<int>(static_cast<int>(typed.size()) / 2, 1, 3));
  if (!attribute.empty()) unknown(name, option_name(keys.word, id, attribute), declared);
  unknown(name, "", declared + "; allowed after -" + keys.word + "_<id>_: " + join(attributes));
}

template <class List> bool begins_with(const std::string& name, const List& beginnings) {
  return std::ranges::any_of(beginnings, [&](const char* beginning) { return name.starts_with(beginning); });
}

/// The nearest of the candidates, or else those that go on where the name ends.
std::string nearest_or_longer(const std::string& name, const std::vector<std::string>& candidates) {
  const std::string near = nearest_name(name, candidates, name.size() > 5 ? 2 : 1);
  if (!near.empty() || name.size() < 5) return near;
  std::string longer;
  for (const std::string& candidate : candidates)
    if (lower_case(candidate).starts_with(name + "_")) longer += (longer.empty() ? "" : ", -") + candidate;
  return longer;
}

/// `-motion_mg_levels_ksp_typ` is an option of a solver inside that of the prefix.
std::string nearest_of_solver(const std::string& name, const std::string& prefix, const Legal& legal) {
  const std::string rest = name.substr(prefix.size());
  std::size_t at = 0;
  for (const char* word : {"snes_", "ksp_", "pc_", "mat_"})
    if (const std::size_t found = rest.rfind(word); found != std::string::npos) at = std::max(at, found);
  std::vector<std::string> candidates;
  for (const auto& [known, text] : KnownOptions::get().solver())
    if (!known.starts_with("ts_")) candidates.push_back(prefix + rest.substr(0, at) + known);
  for (const std::string& global : legal.globals)
    if (global.starts_with(prefix)) candidates.push_back(global);
  return nearest_or_longer(name, candidates);
}

void check_solver_name(const std::string& typed, const std::string& prefix, const Legal& legal) {
  const std::string rest = lower_case(typed).substr(prefix.size());
  const bool passes = prefix == "coupling_" || prefix == "uzawa_";
  for (const Displaced& one : displaced)
    if (std::string(one.prefix).empty() || prefix == one.prefix)
      if (rest.starts_with(one.beginning) && nearest_name(typed, legal.globals, 2).empty())
        if (const auto text = option_text(typed))
          refuse_option({"-" + typed, *text}, std::string("not available: ") + one.why + "; remove it");
  if ((!passes || begins_with(rest, of_passes)) && KnownOptions::get().of_solver(rest) != nullptr) return;
  if (!option_text(typed)) return;
  std::set<std::string> own;
  for (const std::string& global : legal.globals)
    if (global.starts_with(prefix)) own.insert(global.substr(prefix.size()));
  if (passes) own.insert(std::begin(of_passes), std::end(of_passes));
  const std::vector<std::string> names(own.begin(), own.end());
  const std::string near = passes ? nearest_or_longer(rest, names) : "";
  unknown(typed,
          !passes        ? nearest_of_solver(lower_case(typed), prefix, legal)
          : near.empty() ? ""
                         : prefix + near,
          "after -" + prefix + ": " + join(names) +
              (passes ? "" : (own.empty() ? "" : ", and ") + std::string("PETSc's options of solvers")));
}

/// Without prefix: PETSc's own, or the nearest name to it.
void check_global_name(const std::string& typed, const Legal& legal) {
  const std::string name = lower_case(typed);
  const auto& of_petsc = KnownOptions::get().global();
  const bool time = name.starts_with("ts_"),
             solver = begins_with(name, std::initializer_list{"snes_", "ksp_", "pc_"});
  for (const Displaced& one : blind_monitors)
    if (name.starts_with(std::string(one.prefix) + one.beginning))
      if (const auto text = option_text(typed))
        refuse_option({"-" + typed, *text}, std::string("not available: ") + one.why + "; remove it");
  if (time ? begins_with(name, of_time) && of_petsc.count(name) : !solver && of_petsc.count(name)) return;
  // Read by objects that a survey of solvers does not make: left to the look at what was used.
  const bool by_others = begins_with(
      name, std::initializer_list{"vec_", "mat_", "matptap_", "matmatmult_", "matstash_", "dm_", "sf_", "is_",
                                  "petscpartitioner_", "use_gpu", "device_", "viewer_"});
  if ((by_others || read_at_the_ends(name)) && nearest_name(name, legal.globals, 2).empty()) return;
  if (!option_text(typed)) return;
  if (solver)
    unknown(typed, nearest_of_solver("motion_" + name, "motion_", legal),
            "each solver has a prefix: motion_, damage_, heat_; coupling_, uzawa_ for passes");
  if (time && of_petsc.count(name))
    refuse_option({"-" + typed, *option_text(typed)},
                  "not available: the integrators have no estimate of their error, and hit their times by "
                  "themselves; see -ts_adapt_dphi, -ts_times; remove it");
  std::vector<std::string> candidates;
  for (const auto& [lower, written] : legal.names) candidates.push_back(written);
  for (const auto& [known, text] : of_petsc)
    if (!known.starts_with("ts_") || begins_with(known, of_time)) candidates.push_back(known);
  const std::string near = nearest_or_longer(name, candidates);
  unknown(typed, near,
          near.empty() ? "`impact -reference` lists all options, `-help` those of PETSc too" : "");
}

void check_name(const std::string& typed, const Legal& legal) {
  const std::string name = lower_case(typed);
  if (legal.names.count(name) || (name.starts_with("mesh_set_") && name.size() > 9)) return;
  if (const std::size_t sign = typed.find('='); sign != std::string::npos)
    unknown(typed, "",
            "a blank parts name and value: -" + typed.substr(0, sign) + " " + typed.substr(sign + 1));
  for (const char* later : not_available)
    if (name == later)
      if (const auto text = option_text(typed))
        refuse_option({"-" + typed, *text}, "not available; remove it");
  for (const std::string prefix : solver_prefixes)
    if (name.starts_with(prefix)) return check_solver_name(typed, prefix, legal);
  for (const ClassKeys& keys : legal.classes)
    if (name.starts_with(keys.word + "_") && option_text(typed)) unknown_in_class(typed, keys, legal);
  for (const std::string prefix : own_prefixes)
    if (name.starts_with(prefix) && option_text(typed))
      unknown(typed, nearest_name(name, legal.globals, 5), "");
  check_global_name(typed, legal);
}

/// The class of an option of an options file whose id that file declared, and a later word left out.
const ClassKeys* left_out_of(const std::string& name, const Legal& legal) {
  if (legal.names.count(lower_case(name)) || on_command_line(name)) return nullptr;
  for (const ClassKeys& keys : legal.classes) {
    const std::string beginning = keys.word + "_";
    if (!lower_case(name).starts_with(beginning)) continue;
    const std::string rest = lower_case(name).substr(beginning.size()), id = rest.substr(0, rest.find('_'));
    if (std::ranges::find(keys.ids, id) != keys.ids.end()) continue;
    for (const std::string& text : texts_in_files(keys.registry)) {
      const std::vector<std::string> ids = split_list(text);
      if (std::ranges::find(ids, id) != ids.end()) return &keys;
    }
  }
  return nullptr;
}

} // namespace

std::vector<std::string> check_option_names() {
  const Legal legal = legal_names();
  std::map<std::string, std::string> without_effect; // of each registry
  for (const std::string& name : option_names()) {
    const ClassKeys* const keys = left_out_of(name, legal);
    if (keys != nullptr && option_text(name)) // read, so that it counts as used
      without_effect[keys->registry] += " -" + name;
    else
      check_name(name, legal);
  }
  std::vector<std::string> notes;
  for (const auto& [registry, names] : without_effect)
    notes.push_back("without effect, because -" + registry + " leaves their id out:" + names);
  return notes;
}

} // namespace impact
