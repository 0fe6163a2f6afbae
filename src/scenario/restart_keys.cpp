#include "classes.hpp"
#include <algorithm>
#include <filesystem>
#include <impact/petsc/error.hpp>
#include <impact/scenario/restart_keys.hpp>
#include <set>
#include <sstream>

namespace impact {

namespace {

using Values = std::map<std::string, std::string>;

Values values_of(const std::string& lines) {
  Values values;
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) {
    if (line.size() < 2 || line[0] != '-') continue;
    const std::size_t blank = line.find(' ');
    std::string value = blank == std::string::npos ? "" : line.substr(blank + 1);
    if (value.size() > 1 && value.front() == '"' && value.back() == '"')
      value = value.substr(1, value.size() - 2);
    values[line.substr(1, blank == std::string::npos ? blank : blank - 1)] = value;
  }
  return values;
}

std::string text_of(const Values& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "(not given)" : "\"" + found->second + "\"";
}

bool same(const std::string& key, const std::string& a, const std::string& b) {
  const bool path = key == "mesh" || (key.starts_with("function_") && key.ends_with("_file"));
  const auto name = [](const std::string& text) { return std::filesystem::path(text).filename(); };
  return path ? name(a) == name(b) : a == b;
}

/// Keys whose values differ, in alphabetical order.
std::vector<std::string> changed_keys(const Values& before, const Values& now) {
  std::set<std::string> keys;
  for (const Values* values : {&before, &now})
    for (const auto& [key, value] : *values) keys.insert(key);
  std::vector<std::string> changed;
  for (const std::string& key : keys) {
    const auto a = before.find(key), b = now.find(key);
    const bool both = a != before.end() && b != now.end();
    if (key == "dim" && !both) continue;          // a check of the mesh that was added or dropped
    if (key == "mesh_content" && !both) continue; // the file is gone: its mesh is in the checkpoint
    if (!both || !same(key, a->second, b->second)) changed.push_back(key);
  }
  return changed;
}

bool covers(const std::string& entry, const std::string& key) {
  return key == entry || key.starts_with(entry + "_");
}

/// An entry may carry the dash of its option and any case.
std::string bare(const std::string& entry) {
  return lower_case(entry.starts_with("-") ? entry.substr(1) : entry);
}

/// What an entry may be: guarded options, those of one material, condition or contact by their common
/// beginning.
std::string allowed_entries(const std::vector<std::string>& names) {
  std::set<std::string> entries;
  for (const std::string& name : names) {
    if (restart_key(name) != RestartKey::guarded) continue;
    bool one_of_many = false;
    for_each_class([&](const auto& table) { one_of_many |= name.starts_with(table.word + "_"); });
    entries.insert(one_of_many ? name.substr(0, name.find('_', name.find('_') + 1)) : name);
  }
  std::string list;
  for (const std::string& entry : entries) list += (list.empty() ? "" : ", ") + entry;
  return list;
}

void check_entries(const std::vector<std::string>& allow, const Values& before, const Values& now) {
  std::vector<std::string> names;
  for (const Values* values : {&before, &now})
    for (const auto& [key, value] : *values) names.push_back(key);
  for (const std::string& entry : allow) {
    const bool fits = std::any_of(names.begin(), names.end(), [&](const std::string& name) {
      return covers(bare(entry), lower_case(name));
    });
    if (fits) continue;
    const std::string near = nearest_name(bare(entry), names, 3);
    throw UserError(ExitCode::usage, "-restart_allow \"" + entry +
                                         "\": no option of this run or of its checkpoint" +
                                         (near.empty() ? "" : "; did you mean " + near + "?") +
                                         "; allowed: " + allowed_entries(names) + " and names that begin so");
  }
}

} // namespace

RestartKey restart_key(const std::string& name) {
  RestartKey key = name.starts_with("mesh_set_") ? RestartKey::frozen : RestartKey::guarded;
  for_each_class([&](const auto& table) {
    if (name == table.registry || name.starts_with(table.word + "_")) key = table.rows[0].restart;
  });
  for (const OptionRow<Scenario>& row : global_rows())
    if (row.name == name) key = row.restart;
  return key;
}

std::vector<std::string> check_restart_options(const std::string& stored, const std::string& now,
                                               const std::vector<std::string>& allow,
                                               const std::string& checkpoint) {
  const Values before = values_of(stored), after = values_of(now);
  check_entries(allow, before, after);
  std::vector<std::string> notes;
  std::string refused, names;
  for (const std::string& key : changed_keys(before, after)) {
    const RestartKey kind = restart_key(key);
    if (kind == RestartKey::free) continue;
    const std::string change =
        key == "mesh_content" ? "the file of -mesh has changed; the run would go on with the mesh of before"
                              : text_of(after, key) + " instead of " + text_of(before, key);
    if (kind == RestartKey::frozen)
      throw UserError(ExitCode::usage, "-" + key + ": " + change + " in checkpoint " + checkpoint +
                                           "; mesh, dimension and units cannot change on restart; "
                                           "give the old value, or start anew without -restart");
    const bool allowed = std::any_of(allow.begin(), allow.end(), [&](const std::string& entry) {
      return covers(bare(entry), lower_case(key));
    });
    if (allowed) {
      notes.push_back("restart with a changed option: -" + key + " " + change);
      continue;
    }
    refused += (refused.empty() ? "-" : "; -") + key + ": " + change;
    names += (names.empty() ? "" : ",") + key;
  }
  if (!refused.empty())
    throw UserError(ExitCode::usage, refused + " in checkpoint " + checkpoint +
                                         "; the physics of a run changes on restart only with "
                                         "-restart_allow " +
                                         names);
  return notes;
}

} // namespace impact
