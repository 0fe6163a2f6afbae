#include "classes.hpp"
#include <algorithm>
#include <filesystem>
#include <impact/input/database.hpp>
#include <impact/petsc/error.hpp>
#include <set>
#include <sstream>

namespace impact {

namespace {

/// What an option was and is; empty where it was or is not given.
struct Change {
  std::optional<std::string> before, now;
};
using Changes = std::map<std::string, Change>;

/// Puts the options of `lines` into a half of all changes.
void collect(const std::string& lines, std::optional<std::string> Change::*half, Changes& changes) {
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) {
    if (line.size() < 2 || line[0] != '-') continue;
    const std::size_t blank = std::min(line.find(' '), line.size());
    std::string value = line.substr(std::min(blank + 1, line.size()));
    if (value.size() > 1 && value.front() == '"' && value.back() == '"')
      value = value.substr(1, value.size() - 2);
    changes[line.substr(1, blank - 1)].*half = value;
  }
}

std::string quoted(const std::optional<std::string>& value) {
  return value ? "\"" + *value + "\"" : "(not given)";
}

bool is_changed(const std::string& key, const Change& change) {
  // A check of the mesh's dimension may come and go; the checkpoint has the mesh of a file that is gone, and
  // its order.
  if (!change.now && key == "order") return false;
  if (!change.before || !change.now) return key != "dim" && !key.ends_with("_content");
  const bool path = key == "mesh" || key.ends_with("_table"); // of functions and of hardening
  const auto name = [](const std::string& text) { return std::filesystem::path(text).filename(); };
  return path ? name(*change.before) != name(*change.now) : change.before != change.now;
}

bool covers(const std::string& entry, const std::string& key) {
  return key == entry || key.starts_with(entry + "_");
}

/// An entry may carry the dash of its option and any case.
std::string bare(const std::string& entry) {
  return lower_case(entry.starts_with("-") ? entry.substr(1) : entry);
}

/// What an entry may be: options, those of one material, condition or contact by their common beginning.
std::vector<std::string> entries_of(const std::vector<std::string>& names) {
  std::set<std::string> entries;
  for (const std::string& name : names) {
    bool one_of_many = false;
    for_each_class([&](const auto& table) { one_of_many |= name.starts_with(table.word + "_"); });
    entries.insert(one_of_many ? name.substr(0, name.find('_', name.find('_') + 1)) : name);
  }
  return {entries.begin(), entries.end()};
}

std::string allowed_entries(std::vector<std::string> names) {
  std::erase_if(names, [](const std::string& name) { return restart_key(name) != RestartKey::guarded; });
  return join(entries_of(names));
}

/// Initial conditions are for the start, but for velocities of what was at rest.
bool begins_with_inertia(const Changes& changes) {
  const auto type = changes.find("ts_type");
  return type != changes.end() && type->second.before == "static" && type->second.now != "static";
}

/// A script may begin the same run again: what it allowed then need not have changed since.
void check_entries(const std::vector<std::string>& allow, const Changes& changes) {
  const std::vector<std::string> typed = option_names();
  std::vector<std::string> names;
  for (const auto& [key, change] : changes) names.push_back(key);
  for (const std::string& entry : allow) {
    const auto fits = [&](const std::string& name) { return covers(bare(entry), lower_case(name)); };
    if (std::ranges::any_of(names, fits) || std::ranges::any_of(typed, fits)) continue;
    const std::string near = nearest_name(bare(entry), names, 3);
    throw UserError(ExitCode::usage, "-restart_allow \"" + entry +
                                         "\": no option of this run or of its checkpoint" +
                                         (near.empty() ? "" : "; did you mean " + near + "?") +
                                         "; allowed: " + allowed_entries(names) + " and names that begin so");
  }
}

/// One note for a contact, a condition or a material that is gone altogether.
void note_left_out(const std::vector<std::string>& keys, const Changes& changes,
                   std::vector<std::string>& notes) {
  for (const std::string& entry : entries_of(keys)) {
    std::vector<std::string> own;
    std::ranges::copy_if(keys, std::back_inserter(own),
                         [&](const std::string& key) { return covers(entry, key); });
    const bool stays = std::ranges::any_of(
        changes, [&](const auto& change) { return covers(entry, change.first) && change.second.now; });
    if (own.size() > 1 && !stays) own = {entry + "_.., " + std::to_string(own.size()) + " options of before"};
    for (const std::string& key : own) notes.push_back("restart without -" + key);
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
  Changes changes;
  collect(stored, &Change::before, changes);
  collect(now, &Change::now, changes);
  check_entries(allow, changes);
  std::vector<std::string> notes, refused, names, come_or_gone, left_out;
  for (const auto& [key, change] : changes) {
    const RestartKey kind = restart_key(key);
    if (kind == RestartKey::free || !is_changed(key, change)) continue;
    const std::string said =
        key == "mesh_content" ? "the file of -mesh has changed; the run would go on with the mesh of before"
                              : quoted(change.now) + " instead of " + quoted(change.before);
    if (kind == RestartKey::frozen)
      throw UserError(ExitCode::usage, "-" + key + ": " + said + " in checkpoint " + checkpoint +
                                           "; mesh, dimension and units cannot change on restart; "
                                           "give the old value, or start anew without -restart");
    if (std::ranges::any_of(allow, [&, name = key](const std::string& entry) {
          return covers(bare(entry), lower_case(name)) ||
                 (bare(entry) == "ts_type" && name.starts_with("ts_"));
        })) {
      const bool idle = (key == "ics" || key.starts_with("ic_")) && !begins_with_inertia(changes);
      if (!change.now && !idle) {
        left_out.push_back(key);
        continue;
      }
      notes.push_back("restart with a changed option: -" + key + " " + said +
                      (idle ? ": without effect, for the state is that of the checkpoint" : ""));
    } else {
      refused.push_back("-" + key + ": " + said);
      (change.before && change.now ? names : come_or_gone).push_back(key);
    }
  }
  note_left_out(left_out, changes, notes);
  std::ranges::copy(entries_of(come_or_gone), std::back_inserter(names));
  if (!refused.empty())
    throw UserError(ExitCode::usage, join(refused, "; ") + " in checkpoint " + checkpoint +
                                         "; the physics of a run changes on restart only with "
                                         "-restart_allow " +
                                         join(names, ","));
  return notes;
}

} // namespace impact
