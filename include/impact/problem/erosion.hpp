#pragma once
#include <impact/problem/cell_loop.hpp>
#include <petscvec.h>
#include <utility>

/// Cells that fail leave their bodies (theory.md, 7): no force, no energy, no bound of the step comes from
/// them any more; their heat and crack energy stay with their nodes, and their mass unless the rule of their
/// material says otherwise. The row "eroded" says which, 1 at all points of a cell, the row "erosion_totals"
/// what went with them.
namespace impact {

class Erosion {
public:
  /// Both must outlive it; the rows are those of declare_state.
  Erosion(Discretisation& discretisation, StateTable& state);

  /// Whether any material erodes. Without it nothing else here may be called.
  bool on() const { return eroded_ != nullptr; }
  /// From the trial halves, which a rollback, a restart or a new attempt left: which cells are there.
  void follow_rows();

  /// Cells that lost their volume in the step at work: they leave before it is evaluated again, with what
  /// they held at t_n. Places as CellBatch::first_cell + number lanes + lane. False where there are none on
  /// any rank. Collective.
  bool remove(const std::vector<std::size_t>& inverted);
  /// Whether the criteria of its material let a cell go that has no volume any more: one without damage, or
  /// one broken at all its nodes. phi [node], null without damage.
  static bool may_invert(const CellBatch& batch, int lane, const std::vector<double>* phi);
  /// Cells that the criteria of their materials take out at the end of a step, which the trial halves and u
  /// hold. Collective.
  void find_failed(Vec u);

  /// Between steps: the mass of those cells whose material keeps none is gone from here on; whoever keeps
  /// sums of it makes them anew.
  void shed_mass();
  /// Before the table commits: what leaves keeps no history.
  void settle();
  /// Since the last call cells have left; counts as of the trial halves. Equal on all ranks.
  bool news() { return std::exchange(news_, false); }
  /// Whether a tenth more cells have left than when it was last so.
  bool worth_telling();
  /// How many have left so far, their mass, what went with them.
  std::string text() const;

private:
  int failed_lanes(const CellBatch& batch, const std::vector<double>& u) const;
  bool take_out(const std::vector<int>& lanes_of, const std::vector<double>& u, bool trial);
  double energy_of(const CellBatch& batch, int lanes_of, const std::vector<double>& u, bool trial, bool gone,
                   const PatchState& patches, double& mass) const;
  void keep_ratios(const PatchState& before, const std::vector<double>& u);
  double patched_energy(const std::vector<int>& lanes_of, const std::vector<double>& u, bool trial,
                        const PatchState& patches) const;

  Discretisation& d_;
  StateTable& state_;
  StateRow *eroded_ = nullptr, *totals_ = nullptr;
  StateRow* scale_ = nullptr; // Discretisation::patch_scale less 1, at all points of the cells that are left
  double left_ = 0;           // cells of all ranks that `d_.eroded` was made for
  double told_ = 0;           // cells, likewise
  bool news_ = false;
};

} // namespace impact
