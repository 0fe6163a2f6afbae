#pragma once
#include <impact/kernel/heat_input.hpp>
#include <impact/kernel/motion_point.hpp>
#include <impact/kernel/point_geometry.hpp>

/// The work of the stress in a step, as the energy form of the heat balance counts it (5').
namespace impact {

/// 1/2 (P + P_n) : (F - F_n).
template <class Cell, Frame frame>
Batch work_of_stress(const HeatInput& in, const Tensor<Batch, Cell::dim>& H,
                     const Tensor<Batch, Cell::dim>& H_n, int q) {
  constexpr int n = stress_size(frame);
  Batch work = Batch(0.0);
  for (int i = 0; i < gradient_size(frame); ++i)
    work += (0.5 * (in.stress[q * n + i] + in.stress_n[q * n + i])) * (H[i] - H_n[i]);
  return work;
}

/// That of p on the volume of the point itself, 1/2 (p cof F + p_n cof F_n) : (F - F_n).
template <Frame frame, int d>
Batch work_of_pressure(const HeatInput& in, const Tensor<Batch, d>& H, const Tensor<Batch, d>& H_n, int q) {
  constexpr int n = stress_size(frame);
  const auto along = [&](const Batch& p, const Tensor<Batch, d>& at) {
    const Batch J = Batch(1.0) + detm1(at);
    const Tensor<Batch, d> inverse_F = inverse(plus_identity(at), J);
    Batch growth = Batch(0.0);
    for (int i = 0; i < d; ++i)
      for (int j = 0; j < d; ++j) growth += inverse_F[j * d + i] * (H[i * d + j] - H_n[i * d + j]);
    if constexpr (d == 2) growth += inverse_F[4] * (H[4] - H_n[4]);
    return p * (J * growth);
  };
  return 0.5 * (along(in.stress[q * n + n - 1], H) + along(in.stress_n[q * n + n - 1], H_n));
}

/// Under a cure of locking p hangs on the volume that points share, and so does the energy that it stores:
/// its work on theirs alone would warm one point and cool another. more [point] = that work less what the
/// point has of it by the shared volume; the sum over the cell, or its patch, is 0.
template <class Cell, Frame frame>
[[gnu::noinline]] void unshared_work(const HeatInput& in, const CellState<Cell, frame>& now,
                                     const CellState<Cell, frame>& before, Batch* more) {
  constexpr int n = stress_size(frame);
  Batch sum = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const Batch p = 0.5 * (in.stress[q * n + n - 1] + in.stress_n[q * n + n - 1]),
                shared = is_linear_simplex<Cell> && in.patch_work
                             ? *in.patch_work
                             : p * (now.shared_volume(q) - before.shared_volume(q));
    more[q] = work_of_pressure<frame>(in, now.H[q], before.H[q], q) - shared;
    sum += now.map[q].weight * more[q];
  }
  if (is_linear_simplex<Cell> && in.patch_work) return;
  for (int q = 0; q < Cell::points; ++q) more[q] -= sum / now.modes.volume; // p and J are not linear in u
}

/// The integral of that work over a cell of a patch.
template <class Cell, Frame frame> Batch pressure_work(const HeatInput& in) {
  if constexpr (!is_linear_simplex<Cell>) return Batch(0.0); // which are in none
  Batch sum = Batch(0.0);
  if (!in.u) return sum;
  for (int q = 0; q < Cell::points; ++q) {
    const auto X = point_geometry<Cell, frame>(in.X, q);
    sum += X.weight * work_of_pressure<frame>(in, gradient_of_vector<Cell, frame>(X, in.u),
                                              gradient_of_vector<Cell, frame>(X, in.u_n), q);
  }
  return sum;
}

} // namespace impact
