#pragma once
#include <impact/kernel/cell_kernels.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/motion.hpp>

/// What the kernels of motion read of one batch of cells.
namespace impact {

/// Nodal fields as local arrays [node][components], the committed history and what the temperature belongs to
/// as rows; a null pointer leaves the term, or the history of a law without flow, out.
struct MotionFields {
  const std::vector<double>*X, *u, *u_n, *accel, *phi, *theta, *warming, *history;
  double dt;
  const std::vector<double>* drive = nullptr;   ///< the committed row, for laws that soften
  double unilateral = 1;                        ///< factor of the unilateral stress
  const std::vector<double>* failure = nullptr; ///< the committed row, for laws that it weakens
  BulkViscosity bulk = {};                      ///< wants u_n
  const PatchState* patches = nullptr;          ///< of u
};

/// Gathered copies of the fields of one batch, and the input that points to them. Not to be copied.
struct MotionBatch {
  NodalValues X, u, u_n, accel;
  BatchArray<max_nodes> phi, theta;
  PointValues<max_history_size> history;
  PointValues<drive_size> drive;
  PointValues<1> failure;
  PointValues<warming_size> warming;
  BatchArray<1> patch{1};
  BatchArray<2> patch_pressure{2};
  MotionInput in;

  MotionBatch(const CellBatch& batch, const MotionFields& fields)
      : X(batch.nodes() * batch.d.dim()), u(X.size), u_n(X.size), accel(X.size), phi(batch.nodes()),
        theta(batch.nodes()), history(batch.histories()), drive(batch.points<drive_size>()),
        failure(batch.points<1>()), warming(batch.points<warming_size>()) {
    in.X = batch.read(fields.X, X);
    in.u = batch.read(fields.u, u);
    in.u_n = batch.read(fields.u_n, u_n);
    batch.forget_eroded(u);
    if (in.u_n) batch.forget_eroded(u_n);
    in.accel = batch.read(fields.accel, accel);
    in.phi = batch.read(fields.phi, phi);
    in.theta = batch.read(fields.theta, theta);
    in.warming = batch.read(fields.warming, warming);
    in.history = batch.read(fields.history, history);
    in.drive = batch.read(fields.drive, drive);
    in.failure = batch.read(fields.failure, failure);
    if (fields.patches) {
      in.patch = batch.read_shared(fields.patches->J_minus_1, patch);
      in.patch_pressure = batch.read_shared(fields.patches->pressure, patch_pressure);
    }
    in.dt = fields.dt;
    in.unilateral = fields.unilateral;
    in.bulk_linear = fields.bulk.linear;
    in.bulk_quadratic = fields.bulk.quadratic;
  }
  MotionBatch(const MotionBatch&) = delete;
  MotionBatch& operator=(const MotionBatch&) = delete;
};

} // namespace impact
