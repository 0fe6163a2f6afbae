#include "scenario_tables.hpp"
#include <algorithm>
#include <cctype>
#include <cstring>
#include <impact/input/condition.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/petsc_options.hpp>
#include <impact/time/types.hpp>
#include <set>
#include <sstream>

namespace impact {

namespace {

std::optional<GivenOption> given_option(const std::string& name) {
  if (auto text = option_text(name)) return GivenOption{"-" + name, std::move(*text)};
  return {};
}

/// Ids declared in a registry: lower-case letters and digits, unique, and no word with a meaning of its own.
std::vector<std::string> read_ids(const std::string& registry) {
  const auto option = given_option(registry);
  if (!option) return {};
  const std::vector<std::string> ids = split_list(option->text);
  if (ids.empty()) refuse_option(*option, "a value is missing; allowed: a comma list of ids or none");
  if (ids == std::vector<std::string>{"none"}) return {};
  std::set<std::string> seen;
  for (const std::string& id : ids) {
    const bool legal = !id.empty() && std::all_of(id.begin(), id.end(), [](char c) {
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

template <class Struct> ClassKeys class_keys(const OptionClass<Struct>& table) {
  ClassKeys keys{table.word, table.registry, {}, read_ids(table.registry)};
  for (const auto& row : table.rows) keys.attributes.push_back(row.name);
  if (table.word == "material") keys.attributes.push_back("like");
  return keys;
}

std::string attribute_name(const std::string& word, const std::string& id, const std::string& attribute) {
  return word + "_" + id + (attribute.empty() ? "" : "_" + attribute);
}

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

template <class Struct>
Struct read_struct(const OptionClass<Struct>& table, const std::string& id, const OptionContext& context) {
  Struct target;
  target.id = id;
  require(table.rows, table.word + "_" + id + "_", context);
  read_rows(table.rows, target, context, [&](const std::string& attribute) {
    return given_option(attribute_name(table.word, id, attribute));
  });
  return target;
}

template <class Struct>
std::vector<Struct> read_class(const OptionClass<Struct>& table, const OptionContext& context) {
  std::vector<Struct> all;
  for (const std::string& id : read_ids(table.registry)) all.push_back(read_struct(table, id, context));
  return all;
}

using Attributes = std::map<std::string, GivenOption>;

/// What a material is told, with what it takes over from others (`_like`), its own options last.
Attributes material_attributes(const std::string& id, const std::vector<std::string>& ids,
                               std::vector<std::string> followed) {
  followed.push_back(id);
  Attributes all;
  if (const auto like = given_option("material_" + id + "_like")) {
    if (std::find(ids.begin(), ids.end(), like->text) == ids.end())
      refuse_option(*like, "no such material; allowed: " + join(ids));
    if (std::find(followed.begin(), followed.end(), like->text) != followed.end())
      refuse_option(*like, "goes round in a circle: " + join(followed) + ", " + like->text);
    all = material_attributes(like->text, ids, followed);
    all.erase("region");
  }
  Attributes own;
  for (const auto& row : material_class().rows)
    if (auto option = given_option("material_" + id + "_" + row.name)) own[row.name] = std::move(*option);
  // The two pairs of moduli exclude each other: the nearer one wins.
  if (own.count("E") || own.count("nu")) all.erase("K"), all.erase("G");
  if (own.count("K") || own.count("G")) all.erase("E"), all.erase("nu");
  for (auto& [name, option] : own) all[name] = std::move(option);
  return all;
}

std::vector<MaterialScenario> read_materials(const Scenario& scenario, const OptionContext& context) {
  const OptionClass<MaterialInput> table = material_class();
  const std::vector<std::string> ids = read_ids(table.registry);
  std::vector<MaterialScenario> all;
  for (const std::string& id : ids) {
    const Attributes attributes = material_attributes(id, ids, {});
    MaterialInput input;
    input.scenario.law.id = id;
    read_rows(table.rows, input, context, [&](const std::string& name) {
      const auto found = attributes.find(name);
      return found == attributes.end() ? std::nullopt : std::optional(found->second);
    });
    if (input.scenario.regions.empty()) input.scenario.regions = {id};
    for (const auto& row : table.rows) {
      const auto found = attributes.find(row.name);
      const std::string said = found == attributes.end() ? "" : found->second.text, text = row.text(input);
      if (!text.empty() || !said.empty())
        input.scenario.options.push_back({row.name, text.empty() ? said : text, said});
    }
    all.push_back(resolve_material(input, scenario));
  }
  return all;
}

/// Names that stand beside the variables in expressions must not hide them or each other.
void check_expression_name(const std::string& registry, const std::string& id, const OptionContext& context) {
  const GivenOption option = *given_option(registry);
  if (id[0] >= '0' && id[0] <= '9')
    refuse_option(option,
                  "'" + id + "' begins with a digit; allowed: a name for expressions, a letter first");
  bool taken = reserved_in_expressions(id);
  for (const auto& [name, value] : context.names.parameters) taken = taken || name == id;
  if (taken) refuse_option(option, "'" + id + "' has a meaning in expressions already; choose another id");
}

void read_expression_names(Scenario& scenario, OptionContext& context) {
  const auto params = parameter_class();
  for (const std::string& id : read_ids(params.registry)) {
    check_expression_name(params.registry, id, context);
    scenario.params.push_back(read_struct(params, id, context));
    context.names.parameters.emplace_back(id, scenario.params.back().value);
  }
  const auto functions = function_class();
  for (const std::string& id : read_ids(functions.registry)) {
    check_expression_name(functions.registry, id, context);
    const FunctionScenario function = read_struct(functions, id, context);
    const GivenOption option = *given_option("function_" + id + "_table");
    try {
      context.names.tables.emplace_back(id,
                                        parse_table(read_input_file(context.comm, option, function.file)));
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, std::string(reason.what()) +
                                "; allowed: a file with two columns of numbers, t and value");
    }
    scenario.functions.push_back(function);
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
    if (option->text.empty() ||
        (!parse_number(option->text) && !std::all_of(option->text.begin(), option->text.end(), of_word)))
      refuse_option(*option, "allowed: a number or one word of letters, digits, _ . and -");
    scenario.mesh.set[name.substr(prefix.size())] = option->text;
  }
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

void print_help(MPI_Comm comm) {
  PetscBool wanted = PETSC_FALSE;
  check(PetscOptionsHasHelp(nullptr, &wanted));
  if (!wanted) return;
  std::istringstream lines(option_help());
  for (std::string line; std::getline(lines, line);) check(PetscPrintf(comm, "%s\n", line.c_str()));
}

} // namespace

bool Scenario::solves(const std::string& name) const {
  if (physics.empty()) return name == "motion" || name == "damage" || name == "heat";
  return std::find(physics.begin(), physics.end(), name) != physics.end();
}

bool Scenario::has_heat() const {
  return solves("heat") && std::any_of(materials.begin(), materials.end(),
                                       [](const MaterialScenario& material) { return material.law.c_v > 0; });
}

bool Scenario::has_damage() const {
  return solves("damage") &&
         std::any_of(materials.begin(), materials.end(),
                     [](const MaterialScenario& material) { return material.law.damage != Damage::none; });
}

Scenario read_scenario(MPI_Comm comm) {
  print_help(comm);
  register_time_types();
  for (const std::string& note : check_option_names(
           {class_keys(parameter_class()), class_keys(function_class()), class_keys(material_class()),
            class_keys(boundary_class()), class_keys(initial_class()), class_keys(contact_class()),
            class_keys(output_class()), class_keys(probe_class()), class_keys(measure_class()),
            class_keys(stop_class())}))
    check(PetscPrintf(comm, "impact: %s\n", note.c_str()));
  Scenario scenario;
  scenario.coupling.max_it = 0;  // not given
  scenario.checkpoint.wall = -1; // not given
  OptionContext context;
  context.comm = comm;
  const auto rows = global_rows();
  for (const auto& row : rows)
    if (row.name == "units")
      if (const auto option = given_option(row.name)) row.read(scenario, *option, context);
  context.units = scenario.units;
  read_rows(rows, scenario, context, given_option);
  require(rows, "", context);
  read_expression_names(scenario, context);
  read_mesh_settings(scenario);
  scenario.materials = read_materials(scenario, context);
  scenario.bcs = read_class(boundary_class(), context);
  scenario.ics = read_class(initial_class(), context);
  scenario.contacts = read_class(contact_class(), context);
  scenario.outputs = read_class(output_class(), context);
  scenario.probes = read_class(probe_class(), context);
  scenario.measures = read_class(measure_class(), context);
  scenario.stops = read_class(stop_class(), context);
  for (const StopScenario& stop : scenario.stops) // columns are known when the run starts, the grammar is now
    Condition("-stop_" + stop.id + "_when", stop.when, context.names.parameters);
  complete(scenario);
  check_scenario(scenario);
  hand_over_times(scenario);
  try_petsc_options(comm, scenario);
  return scenario;
}

} // namespace impact
