#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/tensor.hpp>
#include <numbers>

/// Crack energy psi_phi = G_c (a gamma/2 Grad phi . C^-1 Grad phi + w(phi)/gamma) (56) and the Kirchhoff form
/// of its stress S_phi = -a G_c gamma w (x) w, w = C^-1 Grad phi (61): tau_phi = -a G_c gamma h (x) h with
/// the spatial gradient h = F^-T Grad phi. With DamageGradient::material C^-1 is replaced by 1 and the stress
/// vanishes.
///   AT2: a = 1, w = phi^2/2; a crack is exp(-|x|/gamma); damage begins with the load
///   AT1: a = 3/4, w = 3 phi/8; a crack is (1 - |x|/2 gamma)^2; elastic until g' E+ outweighs 3 G_c/(8 gamma)
///   wu: a = 2/pi, w = (2 phi - phi^2)/pi (Wu 2017); a crack is 1 - sin(|x|/gamma) up to pi gamma/2; elastic
///   up to a strength of its own, by a degradation that knows it (cohesive.hpp)
/// A crack costs G_c in all of them.
namespace impact {

/// w = quadratic phi^2/2 + linear phi, and a.
struct Regularisation {
  double a, quadratic, linear;

  double broken() const { return 0.5 * quadratic + linear; } ///< w(1)
};
inline Regularisation regularisation(const MaterialParameters& m) {
  constexpr double two_over_pi = 2 * std::numbers::inv_pi;
  if (m.damage == Damage::wu) return {two_over_pi, -two_over_pi, two_over_pi};
  return m.damage == Damage::at1 ? Regularisation{0.75, 0, 0.375} : Regularisation{1, 1, 0};
}

/// a G_c gamma, the factor of Grad phi in the flux.
inline double crack_flux(const MaterialParameters& m) { return regularisation(m).a * (m.Gc * m.gamma); }

template <class T> T crack_energy(const MaterialParameters& m, const T& phi, const T& gradient_squared) {
  const Regularisation r = regularisation(m);
  return m.Gc * ((0.5 * r.a * m.gamma) * gradient_squared + (0.5 * r.quadratic / m.gamma) * (phi * phi) +
                 (r.linear / m.gamma) * phi);
}

/// F^-T g for the in-plane (d = 2) or spatial gradient g.
template <class T, int d>
Vector<T, d> spatial_gradient(const Tensor<T, d>& inverse_F, const Vector<T, d>& g) {
  Vector<T, d> h;
  for (int i = 0; i < d; ++i) h[i] = sum<d>([&](int j) { return inverse_F[tensor_index(d, j, i)] * g[j]; });
  return h;
}

/// C^-1 g.
template <class T, int d> Vector<T, d> raised_gradient(const Tensor<T, d>& inverse_F, const Vector<T, d>& g) {
  const Vector<T, d> h = spatial_gradient(inverse_F, g);
  Vector<T, d> w;
  for (int i = 0; i < d; ++i) w[i] = sum<d>([&](int j) { return inverse_F[tensor_index(d, i, j)] * h[j]; });
  return w;
}

/// What the crack energy takes for C^-1 g.
template <class T, int d>
Vector<T, d> crack_direction(const MaterialParameters& m, const Tensor<T, d>& inverse_F,
                             const Vector<T, d>& g) {
  return m.damage_gradient == DamageGradient::material ? g : raised_gradient(inverse_F, g);
}

/// psi_phi at a point with Grad phi = g.
template <class T, int d>
T crack_energy(const MaterialParameters& m, const T& phi, const Tensor<T, d>& inverse_F,
               const Vector<T, d>& g) {
  const Vector<T, d> h = m.damage_gradient == DamageGradient::material ? g : spatial_gradient(inverse_F, g);
  return crack_energy(m, phi, dot(h, h));
}

/// tau_phi from the spatial gradient h.
template <class T, int d> Symmetric<T, d> crack_stress(const MaterialParameters& m, const Vector<T, d>& h) {
  Symmetric<T, d> tau;
  for (int i = 0; i < symmetric_size(d); ++i) tau[i] = T(0.0);
  for (int i = 0; i < d; ++i)
    for (int j = i; j < d; ++j) tau[symmetric_index(d, i, j)] = (-crack_flux(m)) * (h[i] * h[j]);
  return tau;
}

/// Damage viscosity lambda = (1 + delta - phi)^zeta / c (63); 1/c is zero for c = infinity (rate-independent
/// damage).
template <class T> T damage_viscosity(const MaterialParameters& m, const T& phi) {
  const T x = T(1.0 + m.delta) - phi;
  const T base = select(value(x) > Value<T>(0.0), x, T(0.0));
  const double inverse_c = 1 / m.c;
  if (m.zeta == 1) return inverse_c * base;
  if (m.zeta == 0) return T(inverse_c);
  return inverse_c * pow(base, m.zeta);
}

/// C - C_n from Grad u = H and its increment dH = H - H_n, without cancellation: F^T dH + dH^T F - dH^T dH.
/// Of it is the viscous stress S_d = 2 b_d (C - C_n)/dt (110).
template <class T, int d> Symmetric<T, d> right_increment(const Tensor<T, d>& F, const Tensor<T, d>& dH) {
  Symmetric<T, d> r;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      if (tensor_index(d, i, j) < 0) continue;
      T s = T(0.0);
      for (int k = 0; k < 3; ++k) {
        const int ki = tensor_index(d, k, i), kj = tensor_index(d, k, j);
        if (ki >= 0 && kj >= 0) s += F[ki] * dH[kj] + dH[ki] * F[kj] - dH[ki] * dH[kj];
      }
      r[symmetric_index(d, i, j)] = s;
    }
  return r;
}

// Fatigue: a variable Fat (energy per area, like G_c) with the free energy psi_F = Fat H_f(phi)/gamma, H_f =
/// -phi on [0, 1], 0 below and -1 above (48'), and the law of growth
///   dFat/dt = -(Fhat/gamma) H_f,   Fhat = a (1 - phi) |1/2 (S_c + S_d) : Cdot|,  S_c that of the undamaged
///   body (F1)
/// which makes its dissipation -(1/gamma) H_f dFat/dt = Fhat (H_f/gamma)^2 (25'). Over a step phi is that of
/// its end, so that Fat grows by growth(phi, |work|), the work per volume of the step, and what is stored and
/// dissipated changes by psi_F(phi, Fat) - psi_F(phi, Fat_n) = -dissipation(phi, Fat - Fat_n) exactly.

/// H_f(phi).
template <class T> T fatigue_activity(const T& phi) {
  const T above = select(value(phi) > Value<T>(0.0), phi, T(0.0));
  return -select(value(above) < Value<T>(1.0), above, T(1.0));
}

/// psi_F per reference volume.
template <class T> T fatigue_energy(const MaterialParameters& m, const T& phi, const T& fatigue) {
  return (1 / m.gamma) * (fatigue * fatigue_activity(phi));
}

/// Fat - Fat_n for the stress power of the step, of either sign.
template <class T> T fatigue_growth(const MaterialParameters& m, const T& phi, const T& work) {
  const T H = fatigue_activity(phi), size = select(value(work) < Value<T>(0.0), -work, work);
  return (-m.fatigue_a / m.gamma) * ((T(1.0) + H) * (H * size));
}

/// Energy per reference volume that growth by `growth` dissipates.
template <class T> T fatigue_dissipation(const MaterialParameters& m, const T& phi, const T& growth) {
  return (-1 / m.gamma) * (fatigue_activity(phi) * growth);
}

} // namespace impact
