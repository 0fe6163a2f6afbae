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
template <class Cell, Frame frame> struct MotionBatch {
  Batches<Cell::nodes * Cell::dim> X, u, u_n, accel;
  Batches<Cell::nodes> phi, theta;
  PointValues<Cell, history_size(frame)> history;
  PointValues<Cell, drive_size> drive;
  MotionInput in;

  MotionBatch(const CellBatch<Cell, frame>& batch, const MotionFields& fields) {
    const auto nodal = [&]<int components>(const std::vector<double>* field, auto& values) -> const Batch* {
      if (field == nullptr) return nullptr;
      gather<Cell, components>(batch.group, batch.number, field->data(), values.data());
      return values.data();
    };
    const auto points = [&](const std::vector<double>* row, auto& values) -> const Batch* {
      if (row == nullptr) return nullptr;
      batch.load(*row, values);
      return values.data();
    };
    in.X = nodal.template operator()<Cell::dim>(fields.X, X);
    in.u = nodal.template operator()<Cell::dim>(fields.u, u);
    in.u_n = nodal.template operator()<Cell::dim>(fields.u_n, u_n);
    in.accel = nodal.template operator()<Cell::dim>(fields.accel, accel);
    in.phi = nodal.template operator()<1>(fields.phi, phi);
    in.theta = nodal.template operator()<1>(fields.theta, theta);
    in.history = points(fields.history, history);
    in.drive = points(fields.drive, drive);
    in.dt = fields.dt;
    in.unilateral = fields.unilateral;
  }
  MotionBatch(const MotionBatch&) = delete;
  MotionBatch& operator=(const MotionBatch&) = delete;
};

} // namespace impact
