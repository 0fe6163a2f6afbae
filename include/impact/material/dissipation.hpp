#pragma once
#include <impact/material/parameters.hpp>
#include <impact/math/tensor.hpp>

#include <cmath>

/// Rate terms: damage viscosity lambda = (1 + delta - phi)^zeta / c (63) and the viscous stress S_d = 2 b_d
/// (C - C_n)/dt (110).
namespace impact {

/// 1/c is zero for c = infinity (rate-independent damage).
template <class T> T damage_viscosity(const MaterialParameters& m, const T& phi) {
  const T x = T(1.0 + m.delta) - phi;
  const T base = select(value(x) > Value<T>(0.0), x, T(0.0));
  const double inverse_c = 1 / m.c;
  if (m.zeta == 1) return inverse_c * base;
  if (m.zeta == 0) return T(inverse_c);
  return inverse_c * pow(base, m.zeta);
}

/// C - C_n from Grad u = H and its increment dH = H - H_n, without cancellation: F^T dH + dH^T F - dH^T dH.
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

} // namespace impact
