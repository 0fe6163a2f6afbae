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
  static constexpr std::size_t vector_size = at(Cell::nodes * Cell::dim);
  std::array<Batch, vector_size> X, u, u_n, accel;
  std::array<Batch, at(Cell::nodes)> phi, theta;
  PointValues<Cell, history_size(frame)> history;
  PointValues<Cell, drive_size> drive;
  MotionInput in;

  MotionBatch(const CellGroup& group, int batch, const MotionFields& fields, std::size_t history_offset,
              std::size_t drive_offset = 0) {
    const auto read = [&]<int components>(const std::vector<double>* field, auto& values) -> const Batch* {
      if (field == nullptr) return nullptr;
      gather<Cell, components>(group, batch, field->data(), values.data());
      return values.data();
    };
    in.X = read.template operator()<Cell::dim>(fields.X, X);
    in.u = read.template operator()<Cell::dim>(fields.u, u);
    in.u_n = read.template operator()<Cell::dim>(fields.u_n, u_n);
    in.accel = read.template operator()<Cell::dim>(fields.accel, accel);
    in.phi = read.template operator()<1>(fields.phi, phi);
    in.theta = read.template operator()<1>(fields.theta, theta);
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
