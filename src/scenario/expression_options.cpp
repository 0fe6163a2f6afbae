#include "classes.hpp"

/// Names of the user's in expressions: the options -param_<id> and -function_<id>_...
namespace impact {

namespace {

/// Names that stand beside the variables in expressions must not hide them or each other.
void check_name(const std::string& registry, const std::string& id, const ExpressionContext& names) {
  const GivenOption option = *given_option(registry);
  if (id[0] >= '0' && id[0] <= '9')
    refuse_option(option,
                  "'" + id + "' begins with a digit; allowed: a name for expressions, a letter first");
  bool taken = reserved_in_expressions(id);
  for (const auto& [name, value] : names.parameters) taken = taken || name == id;
  if (taken) refuse_option(option, "'" + id + "' has a meaning in expressions already; choose another id");
}

} // namespace

OptionClass<ParameterScenario> parameter_class() {
  OptionClass<ParameterScenario> table{"param", "params", "Parameters of expressions",
                                       "Parameters are names in every expression, with values in run units.",
                                       &Scenario::params};
  auto& row = Rows(table.rows)
                  .number("", &ParameterScenario::value, "any", any_number,
                          "value of the parameter `<id>` in every expression")
                  .required();
  row.read = [](ParameterScenario& target, const GivenOption& option, const OptionContext& context) {
    try {
      target.value = parse_any_quantity(option.text, context.units);
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, reason.what());
    }
  };
  row.allowed = "number, alone or with a unit";
  table.finish = [](const ParameterScenario& parameter, OptionContext& context) {
    check_name("params", parameter.id, context.names);
    context.names.parameters.emplace_back(parameter.id, parameter.value);
  };
  return table;
}

OptionClass<FunctionScenario> function_class() {
  OptionClass<FunctionScenario> table{
      "function", "functions", "Tables in expressions",
      "`<id>(t)` in an expression interpolates the table linearly; beyond its ends it is constant.",
      &Scenario::functions};
  Rows(table.rows).file("table", &FunctionScenario::file, "two columns of numbers: t, value").required();
  table.finish = [](const FunctionScenario& function, OptionContext& context) {
    check_name("functions", function.id, context.names);
    const GivenOption option = *given_option("function_" + function.id + "_table");
    try {
      context.names.tables.emplace_back(function.id,
                                        parse_table(read_input_file(context.comm, option, function.file)));
    } catch (const std::invalid_argument& reason) {
      refuse_option(option, std::string(reason.what()) +
                                "; allowed: a file with two columns of numbers, t and value");
    }
  };
  return table;
}

} // namespace impact
