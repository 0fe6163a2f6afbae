#pragma once
#include <impact/input/options.hpp>
#include <impact/run/scenario.hpp>
#include <limits>

/// The option tables of a run: the only place where our options are declared.
namespace impact {

/// A material as the user describes it: its law and what is turned into it when everything has been read.
struct MaterialInput {
  MaterialInput() { scenario.law.split = Split::automatic; }
  static constexpr double absent = std::numeric_limits<double>::quiet_NaN();
  MaterialScenario scenario;
  double E = absent, nu = absent, K = absent, G = absent;
  double c_mass = absent; ///< heat capacity per mass
  std::vector<std::string> hardening;
  double linear_h = absent, jc_a = absent, rate_0 = absent, theta_ref = absent;
  std::optional<Softening> softening; ///< empty: automatic, and so below
  std::optional<Locking> locking;
};

/// Options `-<word>_<id>_<name>`, with the ids declared in the list `-<registry>`.
template <class Struct> struct OptionClass {
  std::string word, registry, about;
  std::vector<OptionRow<Struct>> rows;
};

/// One heading of the reference with its global options.
struct OptionGroup {
  std::string title, about;
  std::vector<OptionRow<Scenario>> rows;
};

std::vector<OptionGroup> global_groups();
/// All rows of global_groups() in one list.
std::vector<OptionRow<Scenario>> global_rows();

OptionClass<ParameterScenario> parameter_class(); ///< one row named "": the key is `-param_<id>`
OptionClass<FunctionScenario> function_class();
OptionClass<MaterialInput> material_class();
OptionClass<BoundaryCondition> boundary_class();
OptionClass<InitialCondition> initial_class();
OptionClass<ContactScenario> contact_class();
OptionClass<OutputScenario> output_class();
OptionClass<ProbeScenario> probe_class();
OptionClass<MeasureScenario> measure_class();
OptionClass<StopScenario> stop_class();

/// SI unit of the components and of the value of a condition.
std::string condition_unit(BcType type);
/// Range of the value of a condition.
Interval condition_range(BcType type);

/// The names of a class of options, all that the check of keys needs.
struct ClassKeys {
  std::string word, registry;
  std::vector<std::string> attributes; ///< "" for `-param_<id>`
  std::vector<std::string> ids;
};

/// Throws UserError(usage) for the first option in the database that is neither ours nor PETSc's, or that
/// this program does not let PETSc read. Returns what to say of options in files whose ids a later word on
/// the registry left out.
std::vector<std::string> check_option_names(const std::vector<ClassKeys>& classes);

/// Names of the global options that are no rows: registries and switches of the program.
std::vector<std::string> other_global_names();

/// Fills what the user left to us (regions, file names, fields, numbers that depend on others).
void complete(Scenario& scenario);
/// Throws UserError(usage) for what no single option can tell: missing and contradicting options.
void check_scenario(const Scenario& scenario);
/// The law of a material from what the user said; what is required hangs on the physics of the scenario, of
/// which `physics` has been read. Throws UserError(usage).
MaterialScenario resolve_material(const MaterialInput& input, const Scenario& scenario);

} // namespace impact
