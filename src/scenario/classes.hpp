#pragma once
#include "rows.hpp"

/// The tables of all options: the only list of what there is. One file declares the options of one class,
/// with what they demand of others.
namespace impact {

/// Why options have no effect.
inline bool undamaged(const Scenario& s) { return !s.has_damage(); }
inline constexpr const char* no_damage = "no damage is solved for";
inline bool unheated(const Scenario& s) { return !s.has_heat(); }
inline constexpr const char* no_heat = "no temperature is solved for";

/// Options `-<word>_<id>_<name>`, with the ids declared in the list `-<registry>`.
template <class Struct> struct OptionClass {
  std::string word, registry, title, about;
  std::vector<Struct> Scenario::*member; ///< what is read goes there
  std::vector<OptionRow<Struct>> rows{};
  bool inherits = false; ///< `-<word>_<id>_like <other>` takes over what another id is told
  /// Called when one id has been read, for what is read after it. Throws UserError(usage).
  std::function<void(Struct&, OptionContext&)> finish{};
  /// Fills what the user left to us, once all options are read and those that are needed are there.
  std::function<void(Struct&, const Scenario&)> complete{};
};

/// One heading of the reference with its global options.
struct OptionGroup {
  std::string title, about;
  std::vector<OptionRow<Scenario>> rows{};
  std::function<void(Scenario&)> complete{};
};

OptionGroup general_options(), mesh_options(), coupling_options(), heat_options(), time_options(),
    balance_options(), checkpoint_options();

OptionClass<ParameterScenario> parameter_class(); ///< one row named "": the key is `-param_<id>`
OptionClass<FunctionScenario> function_class();
OptionClass<MaterialScenario> material_class();
OptionClass<BoundaryCondition> boundary_class();
OptionClass<InitialCondition> initial_class();
OptionClass<ContactScenario> contact_class();
OptionClass<OutputScenario> output_class();
OptionClass<ProbeScenario> probe_class();
OptionClass<MeasureScenario> measure_class();
OptionClass<ReleaseScenario> release_class();
OptionClass<StopScenario> stop_class();

/// The groups in the order of the reference; all their rows in one list.
const std::vector<OptionGroup>& global_groups();
const std::vector<OptionRow<Scenario>>& global_rows();

/// All classes in the order in which they are read: what expressions are made of first, then the laws, which
/// say what physics there is.
inline const auto& all_classes() {
  static const auto classes = std::tuple(parameter_class(), function_class(), material_class(),
                                         boundary_class(), initial_class(), contact_class(), output_class(),
                                         probe_class(), measure_class(), release_class(), stop_class());
  return classes;
}

/// Calls visit(class) for each class.
template <class Visit> void for_each_class(const Visit& visit) {
  std::apply([&](const auto&... one) { (visit(one), ...); }, all_classes());
}

/// Calls visit(rows, target, prefix) for all that is read by a list of rows: `prefix` begins their names.
template <class Any, class Visit> void for_each_target(Any& scenario, const Visit& visit) {
  for_each_class([&](const auto& table) {
    for (auto& one : scenario.*table.member) visit(table.rows, one, table.word + "_" + one.id + "_");
  });
  visit(global_rows(), scenario, std::string());
}

/// "contact", "tip" and "gap_tol": contact_tip_gap_tol.
inline std::string option_name(const std::string& word, const std::string& id, const std::string& row) {
  return word + "_" + id + (row.empty() ? "" : "_") + row;
}

std::optional<GivenOption> given_option(const std::string& name);
/// Ids declared in a registry: lower-case letters and digits, unique, and no word with a meaning of its own.
std::vector<std::string> read_ids(const std::string& registry);

/// Throws UserError(usage) for the first option in the database that is neither ours nor PETSc's, or that
/// this program does not let PETSc read. Returns what to say of options in files whose ids a later word on
/// the registry left out.
std::vector<std::string> check_option_names();

/// Fills what the user left to us (laws, file names, fields, numbers that depend on others). Throws
/// UserError(usage) for what no single option can tell: missing and contradicting options.
std::vector<std::string> complete_and_check(Scenario& scenario);

/// The rows of the families of laws.
void add_hardening(std::vector<OptionRow<MaterialScenario>>& rows);
void add_damage(std::vector<OptionRow<MaterialScenario>>& rows);
void add_erosion(std::vector<OptionRow<MaterialScenario>>& rows);
void add_places(std::vector<OptionRow<MaterialScenario>>& rows);
/// What the rows of hardening make of the law.
void resolve_hardening(MaterialScenario& material);
/// Likewise of a degradation that knows the strength; the moduli and the split are resolved.
void resolve_strength(MaterialScenario& material);
void resolve_fatigue(MaterialScenario& material);
/// Which softening it has, by its option or by the hardening that brings one.
Softening softening_of(const MaterialScenario& material);
/// The rows of rigid obstacles.
void add_obstacle(std::vector<OptionRow<ContactScenario>>& rows);
/// Throws UserError(usage) for an obstacle whose mass changes nothing in a mesh of this dimension.
void check_obstacle_motion(const Scenario& scenario, int dim);

} // namespace impact
