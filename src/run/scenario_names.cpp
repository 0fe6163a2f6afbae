#include "scenario_tables.hpp"
#include <cctype>
#include <impact/petsc/error.hpp>
#include <map>
#include <sstream>

/// The check of option names: the set of legal names of ours is closed, PETSc's names are left to PETSc.
namespace impact {

namespace {

const char* const solver_prefixes[] = {"motion_", "damage_", "heat_", "coupling_", "uzawa_"};
const char* const petsc_beginnings[] = {"snes_", "ksp_",        "pc_",  "mat_", "vec_",
                                        "ts_",   "fieldsplit_", "sub_", "mg_"};
/// Beginnings under which no other name than ours exists.
const char* const own_prefixes[] = {"mesh_",   "checkpoint_", "restart_", "walltime_",
                                    "energy_", "crack_",      "history_"};
/// Refused by name, so that nobody believes that they had an effect.
const char* const not_available[] = {"order", "ts_static_start", "ts_dt_cfl"};

struct Legal {
  std::map<std::string, std::string> names; ///< lower case to the way we write it
  std::vector<std::string> globals;
  const std::vector<ClassKeys>* classes;
};

std::string full_name(const ClassKeys& keys, const std::string& id, const std::string& attribute) {
  return keys.word + "_" + id + (attribute.empty() ? "" : "_" + attribute);
}

Legal legal_names(const std::vector<ClassKeys>& classes) {
  Legal legal;
  legal.classes = &classes;
  legal.globals = other_global_names();
  for (const auto& row : global_rows()) legal.globals.push_back(row.name);
  for (const std::string& name : legal.globals) legal.names[lower_case(name)] = name;
  for (const ClassKeys& keys : classes)
    for (const std::string& id : keys.ids)
      for (const std::string& attribute : keys.attributes) {
        const std::string name = full_name(keys, id, attribute);
        legal.names[lower_case(name)] = name;
      }
  return legal;
}

[[noreturn]] void unknown(const std::string& name, const std::string& suggestion, const std::string& known) {
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
  if (attributes.empty()) unknown(name, full_name(keys, id, ""), declared);
  const std::string attribute =
      nearest_name(typed, attributes, std::clamp<int>(static_cast<int>(typed.size()) / 2, 1, 3));
  if (!attribute.empty()) unknown(name, full_name(keys, id, attribute), declared);
  unknown(name, "", declared + "; allowed after -" + keys.word + "_<id>_: " + join(attributes));
}

[[noreturn]] void unknown_in_solver(const std::string& name, const std::string& prefix, const Legal& legal) {
  std::string own, beginnings;
  std::vector<std::string> candidates;
  for (const std::string& global : legal.globals)
    if (global.starts_with(prefix)) {
      own += (own.empty() ? "" : ", ") + global.substr(prefix.size());
      candidates.push_back(global);
    }
  const std::string rest = name.substr(prefix.size());
  const std::size_t word_end = std::min(rest.find('_') + 1, rest.size());
  const std::string word = rest.substr(0, word_end == 0 ? rest.size() : word_end);
  std::vector<std::string> words;
  for (const char* beginning : petsc_beginnings) {
    words.push_back(beginning);
    beginnings += std::string(beginnings.empty() ? "" : " ") + beginning;
  }
  std::string suggestion = nearest_name(name, candidates, 2);
  if (suggestion.empty())
    if (const std::string near = nearest_name(word, words, 2); !near.empty())
      suggestion = prefix + near + rest.substr(word.size());
  unknown(name, suggestion,
          "after -" + prefix + ": " + (own.empty() ? "" : own + ", and ") + "names that start with " +
              beginnings);
}

/// A misspelled global name: close to one of ours, and not in a family of PETSc's names.
std::string global_misspelling(const std::string& name, const Legal& legal) {
  static const std::vector<std::string> petsc_families = {
      "snes", "ksp", "pc",  "mat", "vec", "dm",  "ts",      "sf",     "is",  "ao",  "pf",
      "log",  "mg",  "tao", "st",  "eps", "svd", "options", "malloc", "sub", "help"};
  const std::string family = name.substr(0, name.find('_'));
  const bool of_petsc =
      std::find(petsc_families.begin(), petsc_families.end(), family) != petsc_families.end();
  std::vector<std::string> candidates;
  for (const auto& [lower, written] : legal.names)
    if (!of_petsc || lower.starts_with(family + "_")) candidates.push_back(written);
  return nearest_name(name, candidates, name.size() > 5 ? 2 : 1);
}

bool petsc_name(const std::string& name, const std::string& prefix) {
  return std::any_of(std::begin(petsc_beginnings), std::end(petsc_beginnings), [&](const char* beginning) {
    return name.substr(prefix.size()).starts_with(beginning);
  });
}

/// -coupling_snes_max_it and -coupling_snes_atol are ours and look like PETSc's.
bool misspells_ours(const std::string& name, const Legal& legal) {
  if (name.ends_with("_rtol") || name.ends_with("_stol")) return false;
  return !nearest_name(name, legal.globals, 1).empty();
}

void check_name(const std::string& typed, const Legal& legal) {
  const std::string name = lower_case(typed);
  if (legal.names.count(name) || (name.starts_with("mesh_set_") && name.size() > 9)) return;
  for (const char* later : not_available)
    if (name == later)
      if (const auto text = option_text(typed))
        refuse_option({"-" + typed, *text}, "not available; remove it");
  for (const std::string prefix : solver_prefixes) {
    if (!name.starts_with(prefix)) continue;
    if (petsc_name(name, prefix) && !misspells_ours(name, legal)) return;
    if (option_text(typed)) unknown_in_solver(typed, prefix, legal);
  }
  for (const ClassKeys& keys : *legal.classes)
    if (name.starts_with(keys.word + "_") && option_text(typed)) unknown_in_class(typed, keys, legal);
  const std::string near = global_misspelling(name, legal);
  if (!near.empty() && option_text(typed)) unknown(typed, near, "");
  for (const std::string prefix : own_prefixes)
    if (name.starts_with(prefix) && option_text(typed))
      unknown(typed, nearest_name(name, legal.globals, 5), "");
}

/// The class of an option of an options file whose id that file declared, and a later word left out.
const ClassKeys* left_out_of(const std::string& name, const Legal& legal) {
  if (legal.names.count(lower_case(name)) || on_command_line(name)) return nullptr;
  for (const ClassKeys& keys : *legal.classes) {
    const std::string beginning = keys.word + "_";
    if (!lower_case(name).starts_with(beginning)) continue;
    const std::string rest = lower_case(name).substr(beginning.size()), id = rest.substr(0, rest.find('_'));
    if (std::find(keys.ids.begin(), keys.ids.end(), id) != keys.ids.end()) continue;
    for (const std::string& text : texts_in_files(keys.registry)) {
      const std::vector<std::string> ids = split_list(text);
      if (std::find(ids.begin(), ids.end(), id) != ids.end()) return &keys;
    }
  }
  return nullptr;
}

/// The lines of a file on which each option stands, in the order of the names.
std::map<std::string, std::vector<int>> option_places(const std::string& text) {
  std::map<std::string, std::vector<int>> places;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::size_t dash = line.find_first_not_of(" \t");
    if (dash == std::string::npos || line[dash] != '-' || dash + 1 == line.size()) continue;
    if (std::isalpha(static_cast<unsigned char>(line[dash + 1])) == 0) continue;
    const std::size_t end = line.find_first_of(" \t\r", dash);
    places[lower_case(line.substr(dash + 1, end == std::string::npos ? end : end - dash - 1))].push_back(
        number);
  }
  return places;
}

} // namespace

void check_repeated_options(MPI_Comm comm) {
  int count = 0;
  char** arguments = nullptr;
  check(PetscGetArgs(&count, &arguments));
  for (int i = 1; i + 1 < count; ++i) {
    if (lower_case(arguments[i]) != "-options_file") continue;
    const std::string file = arguments[i + 1];
    if (file.ends_with(".yml") || file.ends_with(".yaml")) continue;
    const auto places = option_places(read_input_file(comm, {"-options_file", file}, file));
    for (const auto& [name, lines] : places)
      if (lines.size() > 1)
        throw UserError(ExitCode::usage, "-" + name + ": given twice in " + file + ", lines " +
                                             std::to_string(lines[0]) + " and " + std::to_string(lines[1]) +
                                             "; remove one of them");
  }
}

std::vector<std::string> check_option_names(const std::vector<ClassKeys>& classes) {
  const Legal legal = legal_names(classes);
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
