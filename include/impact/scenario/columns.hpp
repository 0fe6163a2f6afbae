#pragma once
#include <impact/input/units.hpp>
#include <span>

/// What every number that a run writes means: the columns of the history and of the terminal, and the fields.
/// The writers take units from here and refuse a name that is not described; the reference page prints it.
namespace impact {

struct FieldNote {
  const char* name;
  int components; ///< 1; 3: a vector, two columns in a plane problem; 6: a tensor
  bool on_nodes;
  const char* unit; ///< SI
  const char* about;
};

/// The line above the steps on the terminal.
std::string terminal_heads();
std::span<const FieldNote> field_notes();

/// Name of a component as columns have it: u -> ux, stress -> stress_xx.
std::string component_name(const std::string& field, int component, int components);

/// " [MPa]" in the run's system, "" without a unit. `plane`: plane strain or stress. Throws std::logic_error
/// for a column of the history that no note describes.
std::string column_unit(const std::string& column, const UnitSystem& units, bool plane);

/// The three tables as Markdown.
std::string column_reference();

} // namespace impact
