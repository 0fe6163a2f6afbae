#pragma once
#include <impact/kernel/measure_input.hpp>
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/math/eigen.hpp>

/// How far the points of each cell of a batch have gone, for the criteria by which a cell leaves the body.
namespace impact {

/// Of states, not of steps: in.history is that of in.u, and no lane is marked bad.
template <class Cell, Frame frame>
void cell_distortion(const PointLaw& law, const MotionInput& in, CellDistortion& out) {
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, nullptr, nullptr, s);
  read_thickness<Cell, frame>(in.history, s);
  for (int q = 0; q < Cell::points; ++q) {
    const Batch J = Batch(1.0) + detm1(s.H[q]);
    const EigenSystem<Batch> e = eigen_system(left_strain(s.H[q])); // of b - 1
    const Batch square = Batch(1.0) + max(e.value[0], max(e.value[1], e.value[2]));
    out.least_J = q == 0 ? J : min(out.least_J, J);
    out.largest_stretch = q == 0 ? square : max(out.largest_stretch, square);
  }
  out.largest_stretch = sqrt(out.largest_stretch);
}

} // namespace impact
