#pragma once
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/volume_patches.hpp>

/// What the pressure of one batch of cells hangs on.
namespace impact {

/// Gathered copies of the fields, and the input that points to them; `J_minus_1` of the cells must stay. Not
/// to be copied.
struct PressureBatch {
  NodalValues X, phi, theta;
  PointValues<max_history_size> history;
  PointValues<warming_size> warming;
  MotionInput in;

  PressureBatch(const CellBatch& batch, const PatchFields& fields, const Batch* J_minus_1)
      : X(batch.vectors(batch.d.mesh.coordinates())), phi(batch.nodal(1)), theta(batch.nodal(1)),
        history(batch.histories()), warming(batch.points<warming_size>()) {
    in.X = X.data();
    in.phi = batch.read(fields.phi, phi);
    in.theta = batch.read(fields.theta, theta);
    in.history = batch.read(fields.history, history);
    in.warming = batch.read(fields.warming, warming);
    in.unilateral = fields.unilateral;
    in.patch = J_minus_1;
  }
  PressureBatch(const PressureBatch&) = delete;
  PressureBatch& operator=(const PressureBatch&) = delete;
};

} // namespace impact
