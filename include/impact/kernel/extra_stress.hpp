#pragma once
#include <impact/kernel/motion_point.hpp>

/// The parts of the stress that use the unmodified F: of viscosity and of the gradient of a crack.
namespace impact {

/// Factor b_d g of the viscous stress.
inline Batch viscosity(const MaterialParameters& m, const Degradations<Batch>& g) {
  return m.visc_degrade ? m.b_d * g.e1.g : Batch(m.b_d);
}

/// C - C_n at a point.
template <class Cell, Frame frame>
inline Symmetric<Batch, Cell::dim> step_of_C(const CellState<Cell, frame>& s,
                                             const Tensor<Batch, Cell::dim>& F, const Batch* u_n, int q) {
  constexpr int d = Cell::dim;
  const auto& t = shape_table<Cell>;
  Batch slope[d * d];
  reference_gradient<Cell, d>(t.dN[q], u_n, slope);
  Tensor<Batch, d> dH = mapped_gradient<Cell, frame>(s.map[q], slope, t.N[q], u_n);
  if constexpr (frame == Frame::plane_stress) dH[4] = s.start_33[q];
  for (int i = 0; i < tensor_size(d); ++i) dH[i] = s.H[q][i] - dH[i];
  return right_increment(F, dH);
}

/// tau_phi + tau_d: the parts of the stress that use the unmodified F.
template <class Cell, Frame frame>
inline Symmetric<Batch, Cell::dim>
extra_stress(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s,
             const PointEvaluation<Cell::dim>& e, int q, Vector<Batch, Cell::dim>& h) {
  constexpr int d = Cell::dim;
  Symmetric<Batch, d> tau = Batch(0.0) * e.tau;
  if (law.crack_stress() && in.phi) {
    h = spatial_gradient(e.k.inverse_F, gradient_of_scalar<Cell, frame>(s.map[q], in.phi, q));
    tau = crack_stress(law.parameters, h);
  }
  if (law.viscous() && in.u_n) {
    const auto dC = step_of_C<Cell, frame>(s, e.k.F, in.u_n, q);
    tau = tau + ((2 / in.dt) * viscosity(law.parameters, e.g)) * push(e.k.F, dC);
  }
  return tau;
}

} // namespace impact
