#include "classes.hpp"
#include <algorithm>
#include <cctype>
#include <cstring>
#include <impact/mesh/two_level.hpp>
#include <impact/petsc/bounded_newton.hpp>
#include <impact/petsc/slope_search.hpp>
#include <impact/scenario/petsc_options.hpp>
#include <impact/time/types.hpp>
#include <sstream>

/// From the options database to the Scenario.
namespace impact {

namespace {

template <class Struct>
void require(const std::vector<OptionRow<Struct>>& rows, const std::string& prefix,
             const OptionContext& context) {
  for (const OptionRow<Struct>& row : rows) {
    if (row.note.fallback != "required") continue;
    std::string name = prefix + row.name;
    if (row.name.empty()) name.pop_back();
    if (given_option(name)) continue;
    const std::string range =
        interval_text(row.range, row.note.unit == "any" ? "1" : row.note.unit, context.units);
    throw UserError(ExitCode::usage, "-" + name + ": missing; allowed: " +
                                         (range.empty() ? row.allowed : range) + "; it is " + row.note.about);
  }
}

using Attributes = std::map<std::string, GivenOption>;

/// What an id is told by the rows' names, with what it takes over from others (`_like`), its own options
/// last.
template <class Struct>
Attributes attributes_of(const OptionClass<Struct>& table, const std::string& id,
                         const std::vector<std::string>& ids, std::vector<std::string> followed = {}) {
  followed.push_back(id);
  Attributes all, own;
  if (const auto like = given_option(option_name(table.word, id, "like")); like && table.inherits) {
    if (std::ranges::find(ids, like->text) == ids.end())
      refuse_option(*like, "no such " + table.word + "; allowed: " + join(ids));
    if (std::ranges::find(followed, like->text) != followed.end())
      refuse_option(*like, "goes round in a circle: " + join(followed) + ", " + like->text);
    all = attributes_of(table, like->text, ids, followed);
    all.erase("region");
  }
  for (const auto& row : table.rows)
    if (auto option = given_option(option_name(table.word, id, row.name))) own[row.name] = std::move(*option);
  // The two pairs of moduli exclude each other, and an equation of state all but G: the nearer one wins.
  const auto drop = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) all.erase(name);
  };
  const bool young = own.count("E") || own.count("nu");
  if (young) drop({"K", "G"});
  if (own.count("K") || own.count("G")) drop({"E", "nu"});
  if (young || own.count("K") || own.count("eos")) drop({"eos", "eos_c0", "eos_s", "eos_gamma"});
  if (own.count("eos_c0")) drop({"E", "nu", "K", "alpha_t"});
  for (auto& [name, option] : own) all[name] = std::move(option);
  return all;
}

template <class Struct>
void read_class(const OptionClass<Struct>& table, Scenario& scenario, OptionContext& context) {
  const std::vector<std::string> ids = read_ids(table.registry);
  for (const std::string& id : ids) {
    Struct target;
    target.id = id;
    require(table.rows, table.word + "_" + id + "_", context);
    const Attributes given = attributes_of(table, id, ids);
    for (const OptionRow<Struct>& row : table.rows) {
      const auto found = given.find(row.name);
      if (found != given.end()) row.read(target, found->second, context);
    }
    if (table.finish) table.finish(target, context);
    if constexpr (requires { target.options; })
      for (const OptionRow<Struct>& row : table.rows) {
        const auto found = given.find(row.name);
        const std::string said = found == given.end() ? "" : found->second.text, text = row.text(target);
        if (!text.empty() || !said.empty())
          target.options.push_back({row.name, text.empty() ? said : text, said});
      }
    (scenario.*table.member).push_back(std::move(target));
  }
}

void read_mesh_settings(Scenario& scenario) {
  const std::string prefix = "mesh_set_";
  for (const std::string& name : option_names()) {
    if (!lower_case(name).starts_with(prefix) || name.size() == prefix.size()) continue;
    const auto option = given_option(name);
    if (!option) continue;
    const auto of_word = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_.-", c);
    };
    if (option->text.empty() || (!parse_number(option->text) && !std::ranges::all_of(option->text, of_word)))
      refuse_option(*option, "allowed: a number or one word of letters, digits, _ . and -");
    scenario.mesh.set[name.substr(prefix.size())] = option->text;
  }
}

void read_globals(Scenario& scenario, OptionContext& context) {
  for (const bool is_units : {true, false}) // units first: the others are read in them
    for (const OptionRow<Scenario>& row : global_rows())
      if ((row.name == "units") == is_units) {
        if (const auto option = given_option(row.name)) row.read(scenario, *option, context);
        context.units = scenario.units;
      }
  require(global_rows(), "", context);
  read_mesh_settings(scenario);
}

/// PETSc's TS reads these itself, as plain numbers.
void hand_over_times(const Scenario& scenario) {
  std::map<std::string, double> handed = scenario.time.of_petsc;
  handed["ts_dt"] = scenario.time.dt;
  handed["ts_max_time"] = scenario.time.max_time;
  handed["damage_ts_dt"] = scenario.damage.substep;
  for (const auto& [name, value] : handed)
    if (const auto text = option_text(name); text && !parse_number(*text))
      replace_option(name, number_text(value));
}

/// Whether it is wanted. PETSc's part comes as solvers are made.
bool print_help(MPI_Comm comm) {
  PetscBool wanted = PETSC_FALSE;
  check(PetscOptionsHasHelp(nullptr, &wanted));
  if (!wanted) return false;
  std::istringstream lines(option_help());
  for (std::string line; std::getline(lines, line);) check(PetscPrintf(comm, "%s\n", line.c_str()));
  return true;
}

} // namespace

std::optional<GivenOption> given_option(const std::string& name) {
  if (auto text = option_text(name)) return GivenOption{"-" + name, std::move(*text)};
  return {};
}

std::vector<std::string> read_ids(const std::string& registry) {
  const auto option = given_option(registry);
  if (!option) return {};
  const std::vector<std::string> ids = split_list(option->text);
  if (ids.empty()) refuse_option(*option, "a value is missing; allowed: a comma list of ids or none");
  if (ids == std::vector<std::string>{"none"}) return {};
  std::set<std::string> seen;
  for (const std::string& id : ids) {
    const bool legal = !id.empty() && std::ranges::all_of(id, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z');
    });
    if (!seen.insert(lower_case(id)).second)
      refuse_option(*option, "'" + id + "' is declared twice; ids are unique, whatever their case");
    if (!legal || lower_case(id) != id)
      refuse_option(*option, "'" + id + "' is no id; allowed: lower-case letters and digits, no underscore");
    for (const char* word : {"ksp", "snes", "pc", "mat", "vec", "ts", "fieldsplit", "sub", "mg", "tao", "all",
                             "none", "auto", "plane", "operator", "set"})
      if (id == word) refuse_option(*option, "'" + id + "' is a reserved word; choose another id");
  }
  return ids;
}

bool Scenario::solves(const std::string& name) const {
  return physics.empty() || std::ranges::find(physics, name) != physics.end();
}

bool Scenario::has_heat() const {
  return solves("heat") &&
         std::ranges::any_of(materials, [](const MaterialScenario& m) { return m.law.c_v > 0; });
}

bool Scenario::has_damage() const {
  return solves("damage") && std::ranges::any_of(materials, [](const MaterialScenario& m) {
           return m.law.damage != Damage::none;
         });
}

bool Scenario::any_fatigue() const {
  return has_motion() && has_damage() && std::ranges::any_of(materials, [](const MaterialScenario& m) {
           return m.law.damage != Damage::none && (m.law.fatigue_a > 0 || m.fatigue.works());
         });
}

namespace {

// The same file runs under any -ts_type.
void tell_of_idle_velocities(MPI_Comm comm, const Scenario& s) {
  for (const InitialCondition& ic : s.ics)
    if (!s.has_inertia() && std::ranges::any_of(ic.v, [](const auto& v) { return v.has_value(); }))
      check(PetscPrintf(comm,
                        "impact: without effect, because this run has no inertia: velocities of -ic_%s\n",
                        ic.id.c_str()));
}

} // namespace

Scenario read_scenario(MPI_Comm comm) {
  const bool help = print_help(comm);
  register_time_types();
  register_bounded_newton();
  register_two_level();
  register_slope_search();
  for (const std::string& note : check_option_names()) check(PetscPrintf(comm, "impact: %s\n", note.c_str()));
  Scenario scenario;
  scenario.coupling.max_it = 0; // not given
  OptionContext context;
  context.comm = comm;
  read_globals(scenario, context);
  scenario.dry_run = scenario.dry_run || help;
  for_each_class([&](const auto& table) { read_class(table, scenario, context); });
  for (const std::string& note : complete_and_check(scenario))
    check(PetscPrintf(comm, "impact: %s\n", note.c_str()));
  hand_over_times(scenario);
  try_petsc_options(comm, scenario);
  tell_of_idle_velocities(comm, scenario);
  return scenario;
}

} // namespace impact
