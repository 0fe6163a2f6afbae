#include "classes.hpp"
#include <impact/scenario/columns.hpp>

/// The option tables as text: the echo of a run, `-help`, and the reference page.
namespace impact {

const std::vector<OptionGroup>& global_groups() {
  static const std::vector<OptionGroup> groups = {general_options(),   mesh_options(), coupling_options(),
                                                  heat_options(),      time_options(), balance_options(),
                                                  checkpoint_options()};
  return groups;
}

const std::vector<OptionRow<Scenario>>& global_rows() {
  static const std::vector<OptionRow<Scenario>> rows = [] {
    std::vector<OptionRow<Scenario>> all;
    for (const OptionGroup& group : global_groups())
      all.insert(all.end(), group.rows.begin(), group.rows.end());
    return all;
  }();
  return rows;
}

namespace {

template <class Struct>
std::string class_text(const OptionClass<Struct>& table, const Scenario& scenario, bool as_typed) {
  std::vector<std::string> ids;
  std::string lines;
  const auto add = [&](const std::string& name, const std::string& text) {
    if (!text.empty()) lines += option_line(option_name(table.word, ids.back(), name), text);
  };
  for (const Struct& one : scenario.*table.member) {
    ids.push_back(one.id);
    if constexpr (requires { one.options; })
      for (const auto& [name, text, said] : one.options) add(name, as_typed && !said.empty() ? said : text);
    else
      for (const OptionRow<Struct>& row : table.rows) add(row.name, row.text(one));
  }
  return ids.empty() ? "" : option_line(table.registry, join(ids, ",")) + lines;
}

/// One row of the reference: full option name and what is said of it.
struct Entry {
  std::string key, allowed;
  OptionNote note;
};
struct Section {
  std::string title, about;
  std::vector<Entry> entries;
};

template <class Struct>
void add_entries(Section& section, const std::vector<OptionRow<Struct>>& rows, const std::string& prefix) {
  for (const OptionRow<Struct>& row : rows) {
    const bool number = row.range.low > -unbounded || row.range.high < unbounded;
    std::string allowed = number ? interval_text(row.range, row.note.unit, {}) : "";
    if (!row.allowed.empty()) allowed += (allowed.empty() ? "" : ", ") + row.allowed;
    std::string key = prefix + row.name;
    if (row.name.empty()) key.pop_back();
    section.entries.push_back({key, allowed.empty() ? "number" : allowed, row.note});
  }
}

template <class Struct> Section section_of(const OptionClass<Struct>& table) {
  Section section{table.title, table.about, {}};
  const std::string beginning = "-" + table.word + "_<id>_";
  section.entries.push_back({"-" + table.registry, "comma list of ids or none", {"declares the ids below"}});
  if (table.inherits)
    section.entries.push_back(
        {beginning + "like",
         "id of another " + table.word,
         {"takes over its options, which the " + table.word + "'s own ones then override"}});
  add_entries(section, table.rows, beginning);
  return section;
}

const char* const about_solvers =
    "Every solver of PETSc is reached by its prefix: `-motion_ksp_type`, `-damage_pc_type`, "
    "`-uzawa_snes_max_it`, `-coupling_snes_monitor`. The prefixes are `motion_`, "
    "`damage_`, `heat_`, and `coupling_`, `uzawa_` for the passes. A name that PETSc does not know is "
    "refused before the run starts, one that no solver of the run has read after the first step (told, "
    "when it is an option of a field's own solver or stands in an options file). What could have no effect, "
    "or ends PETSc, is refused with a word on what serves in its place (`_snes_mf`, "
    "`-motion_snes_lag_jacobian`, "
    "`_ksp_guess_type`); what the chosen solver reads and has no use for (`_ksp_rtol` of a direct one, "
    "`_pc_factor_shift_type` of MUMPS) is told, and refused with `-options_strict`. Fragments to "
    "add on the command line are in `options/solver`. `-motion_snes_atol` (1e-12 E h^(d-1) of the softest "
    "material, times 2 pi R of rings, or k h^d of softer springs of foundations) and `-motion_snes_rtol` "
    "(1e-10 of the first residual) hold for each body on its own; no "
    "length of a step ends a solve (`_snes_stol` is 0). `-motion_snes_max_it` is 25, with friction or "
    "semismooth contact 150, without contact 50 or more.";

/// In the order in which a run is thought out.
std::vector<Section> sections() {
  std::vector<Section> all, classes;
  for (const OptionGroup& group : global_groups())
    add_entries(all.emplace_back(Section{group.title, group.about, {}}), group.rows, "-");
  for_each_class([&](const auto& table) { classes.push_back(section_of(table)); });
  constexpr int before_classes = 2, of_physics = 6; // general and mesh; the classes down to contact
  all.insert(all.begin() + before_classes, classes.begin(), classes.begin() + of_physics);
  all.insert(all.end(), classes.begin() + of_physics, classes.end());
  all.push_back({"Solvers", about_solvers, {}});
  return all;
}

std::string in_table(const std::string& text) { return replaced(text, "|", "\\|"); }

std::string code(const std::string& text) { return text.empty() ? "" : "`" + text + "`"; }

} // namespace

std::string print_scenario(const Scenario& scenario, bool as_typed) {
  std::string lines;
  for (const OptionRow<Scenario>& row : global_rows())
    if (const std::string text = row.text(scenario); !text.empty()) lines += option_line(row.name, text);
  for (const auto& [name, value] : scenario.mesh.set) lines += option_line("mesh_set_" + name, value);
  for_each_class([&](const auto& table) { lines += class_text(table, scenario, as_typed); });
  return lines;
}

std::string option_help() {
  std::string text = "Options of impact (values may carry a unit: -material_beam_E \"72 GPa\")\n";
  for (const Section& section : sections()) {
    text += "\n" + section.title + (section.about.empty() ? "" : ": " + section.about) + "\n";
    for (const Entry& entry : section.entries) {
      const OptionNote& note = entry.note;
      text += "  " + entry.key + " <" + (note.fallback.empty() ? "" : "default: " + note.fallback + "; ") +
              entry.allowed + ">: " + note.about;
      if (!note.unit.empty()) text += " [" + note.unit + "]";
      if (!note.notation.empty()) text += " (" + note.notation + ")";
      text += "\n";
    }
  }
  return text;
}

std::string option_reference() {
  std::string page;
  for (const Section& section : sections()) {
    page += (page.empty() ? "### " : "\n### ") + section.title + "\n\n";
    if (!section.about.empty()) page += section.about + "\n";
    if (section.entries.empty()) continue;
    page += std::string(section.about.empty() ? "" : "\n") +
            "| option | default | allowed | SI unit | meaning | symbol |\n|---|---|---|---|---|---|\n";
    for (const Entry& entry : section.entries) {
      const OptionNote& note = entry.note;
      page += "| " + code(entry.key) + " | " + in_table(note.fallback) + " | " + in_table(entry.allowed) +
              " | " + (note.unit == "1" ? "" : note.unit) + " | " + in_table(note.about) + " | " +
              note.notation + " |\n";
    }
  }
  return page + "\n" + column_reference();
}

} // namespace impact
