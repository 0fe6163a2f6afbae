#pragma once
#include <impact/kernel/motion.hpp>
#include <impact/problem/cell_loop.hpp>

/// What the kernels of motion read of one batch of cells.
namespace impact {

/// Nodal fields as local arrays [node][components], the committed history as a row; a null pointer leaves the
/// term out.
struct MotionFields {
  const std::vector<double>*X, *u, *u_n, *accel, *phi, *history;
  double dt;
};

/// Gathered copies of the fields of one batch, and the input that points to them. Not to be copied.
template <class Cell, Frame frame> struct MotionBatch {
  static constexpr std::size_t vector_size = static_cast<std::size_t>(Cell::nodes * Cell::dim);
  std::array<Batch, vector_size> X, u, u_n, accel;
  std::array<Batch, static_cast<std::size_t>(Cell::nodes)> phi;
  PointValues<Cell, history_size(frame)> history;
  MotionInput in;

  MotionBatch(const CellGroup& group, int batch, const MotionFields& fields, std::size_t history_offset) {
    const auto read = [&](const std::vector<double>* field, int components, auto& values) -> const Batch* {
      if (field == nullptr) return nullptr;
      gather(group, batch, components, field->data(), values.data());
      return values.data();
    };
    in.X = read(fields.X, Cell::dim, X);
    in.u = read(fields.u, Cell::dim, u);
    in.u_n = read(fields.u_n, Cell::dim, u_n);
    in.accel = read(fields.accel, Cell::dim, accel);
    in.phi = read(fields.phi, 1, phi);
    history.load(*fields.history, history_offset, batch);
    in.history = history.data();
    in.dt = fields.dt;
  }
  MotionBatch(const MotionBatch&) = delete;
  MotionBatch& operator=(const MotionBatch&) = delete;
};

} // namespace impact
