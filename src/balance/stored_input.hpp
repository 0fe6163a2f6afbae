#pragma once
#include <impact/balance/energies.hpp>
#include <impact/problem/cell_loop.hpp>

namespace impact {

inline const std::vector<double>* half_of(const StateRow* row, bool trial) {
  return row == nullptr ? nullptr : trial ? &row->trial : &row->committed;
}

/// What the measure kernels read of a batch, of the state at t_n or in the trial halves.
// Members beyond twelve: the arrays that the input points at.
struct StoredInput {
  NodalValues X, u, phi, theta;
  PointValues<max_history_size> history;
  PointValues<1> fatigue;
  PointValues<drive_size> drive;
  BatchArray<1> patch{1};
  EnergyInput in;

  /// `patches`: J - 1 that patches of cells share at this displacement.
  StoredInput(const CellBatch& batch, const BodyRows& rows, std::span<const double> places,
              std::span<const double> displacement, const std::vector<double>& patches, bool trial)
      : X(batch.vectors(places)), u(batch.displaced(displacement)), phi(batch.nodal(1)),
        theta(batch.nodal(1)), history(batch.histories()), fatigue(batch.points<1>()),
        drive(batch.points<drive_size>()) {
    const auto half = [trial](const StateRow* row) { return half_of(row, trial); };
    in.patch = batch.read_shared(patches, patch);
    in.X = X.data();
    in.u = u.data();
    in.phi = batch.read(half(rows.phi), phi);
    in.theta = batch.read(half(rows.theta), theta);
    in.history = batch.read(half(&rows.history), history);
    in.fatigue = batch.read(batch.law.fatigues() ? half(rows.fatigue) : nullptr, fatigue);
    in.drive = batch.read(batch.law.softens() ? half(rows.drive) : nullptr, drive);
  }
  StoredInput(const StoredInput&) = delete;
  StoredInput& operator=(const StoredInput&) = delete;
};

} // namespace impact
