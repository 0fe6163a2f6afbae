#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/tensor.hpp>

/// Crack energy psi_phi = G_c (a gamma/2 Grad phi . C^-1 Grad phi + w(phi)/gamma) (56) and the Kirchhoff form
/// of its stress S_phi = -a G_c gamma w (x) w, w = C^-1 Grad phi (61): tau_phi = -a G_c gamma h (x) h with
/// the spatial gradient h = F^-T Grad phi. With DamageGradient::material C^-1 is replaced by 1 and the stress
/// vanishes.
///   AT2: a = 1, w = phi^2/2; a crack is exp(-|x|/gamma); damage begins with the load
///   AT1: a = 3/4, w = 3 phi/8; a crack is (1 - |x|/2 gamma)^2; elastic until g' E+ outweighs 3 G_c/(8 gamma)
/// A crack costs G_c in both.
namespace impact {

/// w = quadratic phi^2/2 + linear phi, and a.
struct Regularisation {
  double a, quadratic, linear;
};
inline Regularisation regularisation(const MaterialParameters& m) {
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
  for (int i = 0; i < d; ++i) {
    h[i] = inverse_F[tensor_index(d, 0, i)] * g[0];
    for (int j = 1; j < d; ++j) h[i] += inverse_F[tensor_index(d, j, i)] * g[j];
  }
  return h;
}

template <class T, int d> T square(const Vector<T, d>& g) {
  T s = g[0] * g[0];
  for (int i = 1; i < d; ++i) s += g[i] * g[i];
  return s;
}

/// tau_phi from the spatial gradient h.
template <class T, int d> Symmetric<T, d> crack_stress(const MaterialParameters& m, const Vector<T, d>& h) {
  Symmetric<T, d> tau;
  for (int i = 0; i < symmetric_size(d); ++i) tau[i] = T(0.0);
  for (int i = 0; i < d; ++i)
    for (int j = i; j < d; ++j) tau[symmetric_index(d, i, j)] = (-crack_flux(m)) * (h[i] * h[j]);
  return tau;
}

} // namespace impact
