#pragma once
#include <impact/material/crack.hpp>
#include <impact/material/degradation.hpp>
#include <impact/material/elasticity.hpp>
#include <impact/material/equation_of_state.hpp>
#include <impact/material/parameters.hpp>
#include <impact/material/plasticity.hpp>
#include <impact/material/thermal.hpp>
#include <impact/math/tensor.hpp>

/// The law of one material point: value in, value out, one template for Batch, double, std::complex and Dual.
/// Kirchhoff stress tau = s + p J 1 with s = g_e1 G dev b and p = g_v U'(J_e)/J_th; the kernels may take p
/// from another J (mean dilatation, F-bar). g_v = g_e1 where J_e >= 1, else g_e2. The splits by principal
/// stretches have a tau of their own, g_e1 tau+ + g_e2 tau- (energy_split.hpp).
namespace impact {

template <class T, int d> struct Kinematics {
  Tensor<T, d> F, inverse_F;
  T J_minus_1, J, J23; ///< J23 = J^(-2/3)
};

/// H = Grad u.
template <class T, int d> Kinematics<T, d> kinematics(const Tensor<T, d>& H) {
  Kinematics<T, d> k;
  k.F = plus_identity(H);
  k.J_minus_1 = detm1(H);
  k.J = T(1.0) + k.J_minus_1;
  k.inverse_F = inverse(k.F, k.J);
  const T r = inverse_cbrt(k.J);
  k.J23 = r * r;
  return k;
}

/// History of one point at t_n.
template <class T, int d> struct PointHistory {
  Symmetric<T, d> A; ///< Cp^-1
  T alpha;
};

template <class T, int d> PointHistory<T, d> virgin_history() { return {identity<T, d>(), T(0.0)}; }

/// E+, E- and H_0: what drives the damage, and what the stored energy is made of.
template <class T> struct PointEnergies { T plus, minus, plastic; };

struct PointLaw {
  MaterialParameters parameters;

  bool flows() const { return parameters.model == Model::j2; }
  /// No law at all: the cells of a rigid body have mass alone.
  bool rigid() const { return parameters.model == Model::rigid; }
  /// Plastic energy is a sum over the steps, not a function of alpha.
  bool softens() const {
    return flows() && (parameters.softening != Softening::none || parameters.failure_softening > 0);
  }
  bool viscous() const { return parameters.b_d > 0; }
  bool fatigues() const { return parameters.damage != Damage::none && parameters.fatigue_a > 0; }
  bool fails() const { return flows() && parameters.jc_failure; }
  bool crack_stress() const {
    return parameters.damage != Damage::none && parameters.damage_gradient == DamageGradient::spatial;
  }
  /// Whether tau is that of a split by principal stretches; without damage all splits are the same.
  bool principal() const { return parameters.damage != Damage::none && by_principal(parameters.split); }

  /// Isochoric part: dev b after return, alpha_{n+1}; s = g.e1.g * G * dev_b.
  template <class T, int d>
  Return<T, d> isochoric(const Tensor<T, d>& H, const Kinematics<T, d>& k, const PointHistory<T, d>& old,
                         const Degradations<T>& g, const FlowConditions<T>& at = {}) const {
    Symmetric<T, d> e = left_strain(H);
    if (!flows()) return predictor(e, k.J23, old.alpha, at);
    e = e + push(k.F, old.A - identity<T, d>());
    const bool undegraded = parameters.damage == Damage::none || parameters.gp == PlasticDegradation::ge;
    return return_map(parameters, e, k.J23, old.alpha, undegraded ? T(1.0) : g.p.g / g.e1.g, at);
  }

  /// g_v p, g_v dp/dJ at a volume ratio J, and which degradation g_v is.
  template <class T>
  Volumetric<T> pressure(const T& J_minus_1, const T& J_th, const Degradations<T>& g) const {
    Volumetric<T> v = has_state(parameters) ? volumetric_of_state(parameters, J_minus_1, J_th)
                                            : volumetric(parameters, J_minus_1, J_th);
    const T g_v = select(value(v.Je_minus_1) >= Value<T>(0.0), g.e1.g, g.e2.g);
    v.p = v.p * g_v;
    v.dp = v.dp * g_v;
    return v;
  }

  /// What the flow stress hangs on beside alpha, at the temperature theta in a step dt that begins with a
  /// failure measure.
  template <class T>
  FlowConditions<T> conditions(const T& theta, double dt, const T& failure_n = T(0.0)) const {
    if (!softens()) return {T(1.0), dt, false};
    const T f = softening(parameters, theta);
    return {parameters.failure_softening > 0 ? f * weakening(parameters, failure_n) : f, dt, false};
  }

  /// H_0 at the end of the return: with softening what was reached before plus f w times its growth.
  template <class T, int d> T plastic_energy(const Return<T, d>& flow, const T& alpha_n, const T& H_n) const {
    if (!softens()) return plastic_potential(parameters, flow.alpha);
    const T growth = plastic_potential(parameters, flow.alpha) - plastic_potential(parameters, alpha_n);
    return H_n + flow.at.softening * growth;
  }

  /// E+, E- from the isochoric excess z and the volume that the stress uses, of which an equation of state
  /// alone reads J_th; H_0 from alpha.
  template <class T> PointEnergies<T> energies(const T& z, const ElasticVolume<T>& v, const T& alpha) const {
    const T W = isochoric_energy(parameters, z);
    const T U = has_state(parameters) ? energy_of_state(parameters, v.Je_minus_1, v.J_th)
                                      : volumetric_energy(parameters, v.Je_minus_1);
    const auto tension = value(v.Je_minus_1) >= Value<T>(0.0);
    return {select(tension, W + U, W), select(tension, T(0.0), U),
            flows() ? plastic_potential(parameters, alpha) : T(0.0)};
  }

  /// What drives damage on the side of plasticity: H_0, or what of it is above the threshold W_0.
  template <class T> T plastic_drive(const T& plastic) const {
    if (parameters.plastic_threshold == 0) return plastic;
    const T above = plastic - T(parameters.plastic_threshold);
    return select(value(above) > Value<T>(0.0), above, T(0.0));
  }

  /// What a step moves between stores and heat beside k_d dalpha, counted as plastic dissipation: damage is
  /// driven by more or less of H_0 than is stored, H_s = (1 - chi) H_0, and flow softens through the alpha in
  /// g:
  ///   (g_p(phi) - g_p(phi_n)) (D_p - H_s) + [g_1 E+ + g_2 E- + g_p H_s](phi, alpha_n) - [...](phi, alpha).
  template <class T>
  T plastic_exchange(const T& phi, const T& phi_n, const T& alpha, const T& alpha_n,
                     const PointEnergies<T>& energy) const {
    const MaterialParameters& m = parameters;
    const T stored = (1 - m.taylor_quinney) * energy.plastic;
    const Degradations<T> g = degradations(m, phi, alpha_n);
    T sum = (g.p.g - degradations(m, phi_n, alpha_n).p.g) * (plastic_drive(energy.plastic) - stored);
    if (!is_ductile(m)) return sum;
    const Degradations<T> after = degradations(m, phi, alpha);
    return sum + (g.e1.g - after.e1.g) * energy.plus + (g.e2.g - after.e2.g) * energy.minus +
           (g.p.g - after.p.g) * stored;
  }
  /// Whether there is any such exchange.
  bool exchanges() const {
    return flows() && parameters.damage != Damage::none &&
           (parameters.gp == PlasticDegradation::ge || is_ductile(parameters));
  }

  /// A_{n+1}: pull-back of b = dev_b + (1 + z) 1, unchanged where the point did not flow.
  template <class T, int d>
  PointHistory<T, d> updated(const Kinematics<T, d>& k, const PointHistory<T, d>& old, const Return<T, d>& r,
                             const T& z) const {
    if (!flows() || !any(r.plastic)) return old;
    Symmetric<T, d> b = r.dev_b;
    for (int i = 0; i < 3; ++i) b[i] = b[i] + (T(1.0) + z);
    const Symmetric<T, d> A = (T(1.0) / k.J23) * push(k.inverse_F, b);
    PointHistory<T, d> now{old.A, r.alpha};
    for (int i = 0; i < symmetric_size(d); ++i) now.A[i] = select(r.plastic, A[i], old.A[i]);
    return now;
  }
};

// What the law says of volume and heat, with an equation of state (52d), (57'') or without (thermal.hpp).
template <class T> T thermal_volume(const PointLaw& law, const T& theta) {
  const MaterialParameters& m = law.parameters;
  return has_state(m) ? stress_free_volume(m, theta) : thermal_volume(m, theta);
}
template <class T> T thermoelastic_entropy(const PointLaw& law, const ElasticVolume<T>& v, const T& g_v) {
  const MaterialParameters& m = law.parameters;
  return has_state(m) ? entropy_of_state(m, v, g_v) : thermoelastic_entropy(m, v.Je_minus_1, g_v);
}
template <class T> T entropy_slope(const PointLaw& law, const ElasticVolume<T>& v, const T& g_v) {
  const MaterialParameters& m = law.parameters;
  return has_state(m) ? (m.eos_gamma * m.c_v) * g_v : entropy_slope(m, v.Je_minus_1, v.J_th, g_v);
}
template <class T>
T heat_capacity(const PointLaw& law, const ElasticVolume<T>& v, const T& g_v, const T& theta) {
  const MaterialParameters& m = law.parameters;
  return has_state(m) ? capacity_of_state(m, v, g_v, theta) : heat_capacity(m, v.Je_minus_1, g_v, theta);
}
template <class T>
T thermoelastic_energy(const PointLaw& law, const ElasticVolume<T>& v, const T& g_v, const T& theta) {
  const T heat = theta * thermoelastic_entropy(law, v, g_v);
  return has_state(law.parameters) ? heat + energy_of_free_volume(law.parameters, v.J_th) : heat;
}
template <class T> ElasticVolume<T> elastic_volume(const PointLaw& law, const T& J_minus_1, const T& theta) {
  if (law.parameters.alpha_t == 0) return {J_minus_1, T(1.0)};
  const T J_th = thermal_volume(law, theta);
  return {(J_minus_1 - (J_th - T(1.0))) / J_th, J_th};
}
/// The volumetric part of the free energy.
template <class T> T volume_energy(const PointLaw& law, const ElasticVolume<T>& v, const T& g_v) {
  const MaterialParameters& m = law.parameters;
  if (!has_state(m)) return g_v * volumetric_energy(m, v.Je_minus_1);
  return g_v * energy_of_state(m, v.Je_minus_1, v.J_th) + energy_of_free_volume(m, v.J_th);
}

/// P = tau F^-T
template <class T, int d>
Tensor<T, d> first_piola(const Symmetric<T, d>& tau, const Tensor<T, d>& inverse_F) {
  Tensor<T, d> P;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (tensor_index(d, i, j) < 0) continue;
      T s = T(0.0);
      for (int k = 0; k < 3; ++k)
        if (tensor_index(d, i, k) >= 0 && tensor_index(d, j, k) >= 0)
          s += tau[symmetric_index(d, i, k)] * inverse_F[tensor_index(d, j, k)];
      P[tensor_index(d, i, j)] = s;
    }
  return P;
}

} // namespace impact
