#include "classes.hpp"
#include <algorithm>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>

/// What the rows of the option tables demand of each other and of the mesh, asked of a whole Scenario.
namespace impact {

namespace {

/// Throws UserError(usage) by the first rule that speaks, of those about absence or of the others.
template <class Struct>
void ask_rules(const std::vector<OptionRow<Struct>>& rows, const Struct& target, const std::string& prefix,
               const Scenario& scenario, bool of_absence) {
  using Of = typename OptionRule<Struct>::Of;
  for (const OptionRow<Struct>& row : rows) {
    if (row.rules.empty() || row.given(target) == of_absence) continue;
    for (const OptionRule<Struct>& rule : row.rules) {
      std::string words = (rule.of == Of::absence) == of_absence ? rule.words(target, scenario) : "";
      if (words.empty()) continue;
      words = replaced(words, "<>", "-" + prefix);
      if (!scenario.materials.empty()) words = replaced(words, "{material}", scenario.materials.front().id);
      for (const OptionRow<Struct>& other : rows)
        words = replaced(words, "{" + other.name + "}", other.text(target));
      for (const OptionRow<Scenario>& other : global_rows())
        words = replaced(words, "{" + other.name + "}", other.text(scenario));
      const std::string key = rule.of == Of::other ? "" : "-" + prefix + row.name;
      throw UserError(ExitCode::usage, key +
                                           (of_absence             ? ": missing; "
                                            : rule.of == Of::value ? " \"" + row.text(target) + "\": "
                                                                   : "") +
                                           words);
    }
  }
}

std::string groups_text(const std::vector<Group>& groups) {
  std::vector<std::string> text;
  for (int dim = 3; dim >= 0; --dim) {
    std::vector<std::string> names;
    for (const Group& group : groups)
      if (group.dim == dim) names.push_back(group.name);
    if (!names.empty()) text.push_back(join(names) + " (" + std::to_string(dim) + "D)");
  }
  return text.empty() ? "none" : join(text, "; ");
}

/// `dim`: that the group must have, 0 for any.
void check_group(const std::string& option, const std::string& name, int dim,
                 const std::vector<Group>& groups) {
  const auto found = std::ranges::find_if(groups, [&](const Group& g) { return g.name == name; });
  const std::string has = "; mesh has: " + groups_text(groups);
  if (found == groups.end())
    throw UserError(ExitCode::data, option + " \"" + name + "\": no such physical group" + has);
  if (dim != 0 && found->dim != dim)
    throw UserError(ExitCode::data, option + " \"" + name + "\": is a group of dimension " +
                                        std::to_string(found->dim) + "; allowed: dimension " +
                                        std::to_string(dim) + has);
}

template <class Struct>
void check_on_mesh(const std::vector<OptionRow<Struct>>& rows, const Struct& target,
                   const std::string& prefix, const std::vector<Group>& groups, int dim) {
  for (const OptionRow<Struct>& row : rows) {
    const std::string option = "-" + prefix + row.name, text = row.text(target);
    if (row.group_dimension && !text.empty())
      if (const int wanted = row.group_dimension(target, dim); wanted >= 0)
        for (const std::string& name : split_list(text)) check_group(option, name, wanted, groups);
    if (row.misfit && row.given(target))
      if (const std::string why = row.misfit(target, dim); !why.empty())
        throw UserError(ExitCode::data, option + " \"" + text + "\": " + why);
  }
}

} // namespace

void complete_and_check(Scenario& scenario) {
  // A mesh may be converted before there is a run for it.
  if (!scenario.mesh.convert.empty() && scenario.materials.empty())
    return ask_rules(global_rows(), scenario, "", scenario, false);
  if (scenario.materials.empty())
    throw UserError(ExitCode::usage,
                    "-materials: missing; allowed: a comma list of ids, one for each material");
  const auto ask = [&](bool of_absence) {
    for_each_target(scenario, [&](const auto& rows, const auto& target, const std::string& prefix) {
      ask_rules(rows, target, prefix, scenario, of_absence);
    });
  };
  ask(true);
  for_each_class([&](const auto& table) {
    if (table.complete)
      for (auto& one : scenario.*table.member) table.complete(one, scenario);
  });
  for (const OptionGroup& group : global_groups())
    if (group.complete) group.complete(scenario);
  ask(false);
}

void check_groups(const Scenario& scenario, const std::vector<Group>& groups, int dim) {
  check_on_mesh(global_rows(), scenario, "", groups, dim);
  for_each_class([&](const auto& table) {
    for (const auto& one : scenario.*table.member)
      check_on_mesh(table.rows, one, table.word + "_" + one.id + "_", groups, dim);
  });
  check_obstacle_motion(scenario, dim);
}

} // namespace impact
