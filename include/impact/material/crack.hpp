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

} // namespace impact
