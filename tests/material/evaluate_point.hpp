#pragma once
#include <impact/material/energy_split.hpp>
#include <impact/material/equation_of_state.hpp>
#include <impact/material/modulus.hpp>
#include <impact/material/point_law.hpp>

/// The whole law at one point by itself, where p comes from the J of the point: what the oracles of these
/// tests are compared with. The kernels put it together from the same parts.
namespace impact {

/// Everything at one point where p comes from the J of the point itself: tau_c, the new history and the
/// energies.
template <class T, int d> struct PointInput {
  Tensor<T, d> H; ///< Grad u
  PointHistory<T, d> old;
  T phi, theta;
  double dt = 0;  ///< 0: at rest
  T H_n = T(0.0); ///< plastic energy at t_n, read where the law softens
};
template <class T, int d> struct PointResponse {
  Kinematics<T, d> k;
  Return<T, d> flow;
  Symmetric<T, d> tau;
  PointHistory<T, d> history;
  PointEnergies<T> energy;
};

/// What a split by principal stretches is asked at a point by itself.
template <class T, int d> SplitState<T, d> split_state_of(const PointLaw& law, const PointInput<T, d>& in) {
  const Kinematics<T, d> k = kinematics(in.H);
  SplitState<T, d> s{left_strain(in.H),
                     k.J_minus_1,
                     k.J_minus_1,
                     thermal_volume(law.parameters, in.theta),
                     in.old.alpha,
                     degradations(law.parameters, in.phi, in.old.alpha),
                     T(0.0),
                     law.conditions(in.theta, in.dt)};
  s.pressed = s.g.e2.g;
  if (law.flows()) s.left = s.left + push(k.F, in.old.A - identity<T, d>());
  return s;
}

template <class T, int d> PointResponse<T, d> evaluate(const PointLaw& law, const PointInput<T, d>& in) {
  PointResponse<T, d> out;
  const Degradations<T> g = degradations(law.parameters, in.phi, in.old.alpha);
  out.k = kinematics(in.H);
  SplitState<T, d> state;
  SplitResponse<T, d> split;
  if (law.principal()) {
    state = split_state_of(law, in);
    split = split_response(law, state);
    out.flow = split.flow;
  } else {
    out.flow = law.isochoric(in.H, out.k, in.old, g, law.conditions(in.theta, in.dt));
  }
  const T J_th = thermal_volume(law, in.theta);
  const Volumetric<T> v = law.pressure(out.k.J_minus_1, J_th, g);
  out.tau = (law.parameters.G * g.e1.g) * out.flow.dev_b;
  for (int i = 0; i < 3; ++i) out.tau[i] = out.tau[i] + v.p * out.k.J;
  const T z = trace_excess(out.flow.dev_b, value(out.flow.y) - Value<T>(1.0));
  out.history = law.updated(out.k, in.old, out.flow, z);
  out.energy = law.energies(z, {v.Je_minus_1, J_th}, out.history.alpha);
  if (law.softens()) out.energy.plastic = law.plastic_energy(out.flow, in.old.alpha, in.H_n);
  if (!law.principal()) return out;
  out.tau = split_stress(state, split.of);
  out.energy.plus = split.of.plus;
  out.energy.minus = split.of.minus;
  return out;
}

/// The closed-form modulus of `evaluate` (p from the J of the point).
template <int n, class T, int d>
Modulus<T, n> point_modulus(const PointLaw& law, const PointInput<T, d>& in, bool symmetric = false) {
  const Degradations<T> g = degradations(law.parameters, in.phi, in.old.alpha);
  const Kinematics<T, d> k = kinematics(in.H);
  const Return<T, d> flow = law.isochoric(in.H, k, in.old, g, law.conditions(in.theta, in.dt));
  const Volumetric<T> v = law.pressure(k.J_minus_1, thermal_volume(law, in.theta), g);
  return assemble_modulus<n>(law_modulus<n>(law.parameters, flow, g.e1.g, g.p.g / g.e1.g, v.p * k.J,
                                            v.dp * k.J * k.J, T(1.0), false, symmetric));
}

} // namespace impact
