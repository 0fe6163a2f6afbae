#include "scenario_tables.hpp"
#include <impact/run/columns.hpp>

/// The option tables as text: the echo of a run, `-help`, and the reference page.
namespace impact {

namespace {

template <class Struct>
std::string class_text(const OptionClass<Struct>& table, const std::vector<Struct>& all) {
  if (all.empty()) return "";
  std::string ids, lines;
  for (const Struct& one : all) {
    ids += (ids.empty() ? "" : ",") + one.id;
    lines += rows_text(table.rows, one, table.word + "_" + one.id + "_");
  }
  return option_line(table.registry, ids) + lines;
}

std::string materials_text(const std::vector<MaterialScenario>& materials, bool as_typed) {
  std::string ids, lines;
  for (const MaterialScenario& material : materials) {
    ids += (ids.empty() ? "" : ",") + material.law.id;
    for (const auto& [name, text, said] : material.options)
      lines +=
          option_line("material_" + material.law.id + "_" + name, as_typed && !said.empty() ? said : text);
  }
  return option_line("materials", ids) + lines;
}

std::string params_text(const std::vector<ParameterScenario>& params) {
  std::string ids, lines;
  for (const ParameterScenario& param : params) {
    ids += (ids.empty() ? "" : ",") + param.id;
    lines += option_line("param_" + param.id, number_text(param.value));
  }
  return params.empty() ? "" : option_line("params", ids) + lines;
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
std::vector<Entry> entries(const std::vector<OptionRow<Struct>>& rows, const std::string& prefix) {
  std::vector<Entry> all;
  for (const OptionRow<Struct>& row : rows) {
    const bool number = row.range.low > -unbounded || row.range.high < unbounded;
    std::string allowed = number ? interval_text(row.range, row.note.unit, {}) : "";
    if (!row.allowed.empty()) allowed += (allowed.empty() ? "" : ", ") + row.allowed;
    if (allowed.empty()) allowed = "number";
    std::string key = prefix + row.name;
    if (row.name.empty()) key.pop_back();
    all.push_back({key, allowed, row.note});
  }
  return all;
}

template <class Struct> Section section(const std::string& title, const OptionClass<Struct>& table) {
  Section result{title, table.about, {}};
  result.entries.push_back(
      {"-" + table.registry, "comma list of ids or none", {"declares the ids below", "", "", "", ""}});
  for (Entry& entry : entries(table.rows, "-" + table.word + "_<id>_"))
    result.entries.push_back(std::move(entry));
  return result;
}

std::vector<Section> sections() {
  std::vector<Section> all;
  for (const OptionGroup& group : global_groups())
    all.push_back({group.title, group.about, entries(group.rows, "-")});
  Section materials = section("Materials", material_class());
  materials.entries.insert(
      materials.entries.begin() + 1,
      {"-material_<id>_like",
       "id of another material",
       {"takes over its options, which the material's own ones then override", "", "", "", ""}});
  Section solvers{
      "Solvers",
      "Every solver of PETSc is reached by its prefix: `-motion_ksp_type`, `-damage_pc_type`, "
      "`-uzawa_snes_max_it`, `-coupling_snes_monitor`. The prefixes are `motion_`, "
      "`damage_`, `heat_`, and `coupling_`, `uzawa_` for the passes. A name that PETSc does not know is "
      "refused before the run starts, one that no solver of the run has read after the first step (told, "
      "when it is an option of a field's own solver or stands in an options file). Fragments to "
      "add on the command line are in `options/solver`. `-motion_snes_atol` (1e-12 E h^(d-1) of the softest "
      "material) and `-motion_snes_rtol` (1e-10 of the first residual) hold for each body on its own; no "
      "length of a step ends a solve (`_snes_stol` is 0).",
      {}};
  // In the order in which a run is thought out.
  const std::vector<Section> described = {section("Parameters of expressions", parameter_class()),
                                          section("Tables in expressions", function_class()),
                                          materials,
                                          section("Boundary conditions", boundary_class()),
                                          section("Initial conditions", initial_class()),
                                          section("Contact", contact_class())};
  all.insert(all.begin() + 2, described.begin(), described.end());
  all.push_back(section("Output", output_class()));
  all.push_back(section("Probes", probe_class()));
  all.push_back(section("Measures", measure_class()));
  all.push_back(section("Stops", stop_class()));
  all.push_back(solvers);
  return all;
}

std::string in_table(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string code(const std::string& text) { return text.empty() ? "" : "`" + text + "`"; }

} // namespace

std::string print_scenario(const Scenario& scenario, bool as_typed) {
  std::string lines = rows_text(global_rows(), scenario, "");
  for (const auto& [name, value] : scenario.mesh.set) lines += option_line("mesh_set_" + name, value);
  return lines + params_text(scenario.params) + class_text(function_class(), scenario.functions) +
         materials_text(scenario.materials, as_typed) + class_text(boundary_class(), scenario.bcs) +
         class_text(initial_class(), scenario.ics) + class_text(contact_class(), scenario.contacts) +
         class_text(output_class(), scenario.outputs) + class_text(probe_class(), scenario.probes) +
         class_text(measure_class(), scenario.measures) + class_text(stop_class(), scenario.stops);
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
      if (!note.symbol.empty() || !note.equation.empty())
        text += " (" + note.symbol + (note.symbol.empty() || note.equation.empty() ? "" : " ") +
                note.equation + ")";
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
      std::string symbol = note.symbol;
      if (!note.equation.empty()) symbol += (symbol.empty() ? "" : " ") + note.equation;
      page += "| " + code(entry.key) + " | " + in_table(note.fallback) + " | " + in_table(entry.allowed) +
              " | " + (note.unit == "1" ? "" : note.unit) + " | " + in_table(note.about) + " | " + symbol +
              " |\n";
    }
  }
  return page + "\n" + column_reference();
}

} // namespace impact
