#pragma once
#include <impact/mesh/state_table.hpp>
#include <memory>
#include <vector>

/// A row of the state table with numbers for each constraint of a contact, which lives on where the surface
/// changes: the table counts by the facets of the start, whoever reads it by those that are there.
namespace impact {

class SurfaceRow {
public:
  SurfaceRow() = default; ///< there is none
  explicit SurfaceRow(StateRow& table) : table_(&table) {}

  explicit operator bool() const { return table_ != nullptr; }
  /// Of the constraints that are there.
  StateRow* operator->() const { return own_ ? own_.get() : table_; }
  /// Of the constraints from now on the numbers in the table, -1 for what came free: that has no place in it,
  /// and 0 here.
  void change_surface(std::vector<int> place);
  bool changed() const { return own_ != nullptr; }
  bool lacks(int constraint) const { return changed() && place_[static_cast<std::size_t>(constraint)] < 0; }
  /// The step is accepted with the trial half: the table hears of it.
  void tell_table();

private:
  StateRow* table_ = nullptr;
  std::unique_ptr<StateRow> own_; // of a surface that has changed
  std::vector<int> place_;
};

} // namespace impact
