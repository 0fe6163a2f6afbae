#pragma once
#include <impact/kernel/motion.hpp>
#include <impact/problem/cell_loop.hpp>

/// What the kernels of motion read of one batch of cells.
namespace impact {

/// Nodal fields as local arrays [node][components], the committed history as a row; a null pointer leaves the
/// term, or the history of a law without flow, out.
struct MotionFields {
  const std::vector<double>*X, *u, *u_n, *accel, *phi, *theta, *history;
  double dt;
  const std::vector<double>* drive = nullptr; ///< the committed row, for laws that soften
  double unilateral = 1;                      ///< factor of the unilateral stress
};

/// Gathered copies of the fields of one batch, and the input that points to them. Not to be copied.
struct MotionBatch {
  BatchArray<3 * max_nodes> X, u, u_n, accel;
  BatchArray<max_nodes> phi, theta;
  PointValues<max_history_size> history;
  PointValues<drive_size> drive;
  MotionInput in;

  MotionBatch(const CellGroup& group, Frame frame, int batch, const MotionFields& fields,
              std::size_t history_offset, std::size_t drive_offset = 0)
      : X(group.shape->nodes * group.shape->dim), u(X.size), u_n(X.size), accel(X.size),
        phi(group.shape->nodes), theta(phi.size), history(group, history_size(frame)), drive(group) {
    const auto read = [&](const std::vector<double>* field, auto& values) -> const Batch* {
      if (field == nullptr) return nullptr;
      gather(group, batch, values.size / group.shape->nodes, field->data(), values.data());
      return values.data();
    };
    in.X = read(fields.X, X);
    in.u = read(fields.u, u);
    in.u_n = read(fields.u_n, u_n);
    in.accel = read(fields.accel, accel);
    in.phi = read(fields.phi, phi);
    in.theta = read(fields.theta, theta);
    if (fields.history != nullptr) {
      history.load(*fields.history, history_offset, batch);
      in.history = history.data();
    }
    if (fields.drive != nullptr) {
      drive.load(*fields.drive, drive_offset, batch);
      in.drive = drive.data();
    }
    in.dt = fields.dt;
    in.unilateral = fields.unilateral;
  }
  MotionBatch(const MotionBatch&) = delete;
  MotionBatch& operator=(const MotionBatch&) = delete;
};

} // namespace impact
