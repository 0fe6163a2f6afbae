#include "classes.hpp"
#include <impact/input/database.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <utility>

/// What the rows of the option tables demand of each other, asked of a whole Scenario.
namespace impact {

namespace {

/// What is without effect, by the reason.
using Idle = std::map<std::string, std::string>;

/// Throws UserError(usage) by the first rule that speaks, of those about absence or of the others.
template <class Struct>
void ask_rules(const std::vector<OptionRow<Struct>>& rows, const Struct& target, const std::string& prefix,
               const Scenario& scenario, bool of_absence, Idle& idle) {
  using Of = typename OptionRule<Struct>::Of;
  for (const OptionRow<Struct>& row : rows) {
    if (row.rules.empty() || row.given(target) == of_absence) continue;
    bool told = false; // one reason is enough
    for (const OptionRule<Struct>& rule : row.rules) {
      std::string words = (rule.of == Of::absence) == of_absence ? rule.words(target, scenario) : "";
      if (words.empty()) continue;
      words = replaced(words, "<>", "-" + prefix);
      if (!scenario.materials.empty()) words = replaced(words, "{material}", scenario.materials.front().id);
      for (const OptionRow<Struct>& other : rows)
        words = replaced(words, "{" + other.name + "}", other.text(target));
      for (const OptionRow<Scenario>& other : global_rows())
        words = replaced(words, "{" + other.name + "}", other.text(scenario));
      if (rule.of == Of::idle) {
        // What was taken from another material with -material_<id>_like is not told.
        if (!std::exchange(told, true) && option_text(prefix + row.name))
          idle[words] += " -" + prefix + row.name;
        continue;
      }
      const std::string key = rule.of == Of::other ? "" : "-" + prefix + row.name;
      throw UserError(ExitCode::usage, key +
                                           (of_absence             ? ": missing; "
                                            : rule.of == Of::value ? " \"" + row.text(target) + "\": "
                                                                   : "") +
                                           words);
    }
  }
}

} // namespace

std::vector<std::string> complete_and_check(Scenario& scenario) {
  Idle idle;
  // A mesh may be converted before there is a run for it.
  if (!scenario.mesh.convert.empty() && scenario.materials.empty()) {
    ask_rules(global_rows(), scenario, "", scenario, false, idle);
    return {};
  }
  if (scenario.materials.empty())
    throw UserError(ExitCode::usage,
                    "-materials: missing; allowed: a comma list of ids, one for each material");
  const auto ask = [&](bool of_absence) {
    for_each_target(scenario, [&](const auto& rows, const auto& target, const std::string& prefix) {
      ask_rules(rows, target, prefix, scenario, of_absence, idle);
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
  std::vector<std::string> notes;
  for (const auto& [reason, keys] : idle) {
    if (scenario.strict)
      throw UserError(ExitCode::usage,
                      "without effect, because " + reason + ":" + keys + " (-options_strict)");
    notes.push_back("without effect, because " + reason + ":" + keys);
  }
  return notes;
}

} // namespace impact
