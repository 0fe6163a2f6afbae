#pragma once
#include <complex>
#include <impact/material/parameters.hpp>
#include <impact/math/eigen.hpp>

/// Functions of the principal values of a symmetric tensor, and how dual numbers pass through them: a map
/// knows its value at a tensor of values and its derivative along any other, so that no derivative of an
/// eigenvector is ever taken.
namespace impact {

/// What a map gives: a tensor with the axes of its argument, and two scalars.
template <class T, int d> struct PrincipalParts {
  Symmetric<T, d> tensor;
  T first, second;
};

/// The axes of a tensor.
template <class V, int d> class PrincipalFrame {
public:
  explicit PrincipalFrame(const Symmetric<V, d>& a) : eigen(eigen_system(a)) {}

  EigenSystem<V> eigen;

  V component(int i, int j, const Symmetric<V, d>& a) const {
    V s = V(0.0);
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        if (const int kl = symmetric_index(d, k, l); kl >= 0)
          s += eigen.vector[i][k] * (a[kl] * eigen.vector[j][l]);
    return s;
  }
  /// a += s sym(n_i (x) n_j)
  void add_dyad(int i, int j, const V& s, Symmetric<V, d>& a) const {
    for (int k = 0; k < 3; ++k)
      for (int l = k; l < 3; ++l)
        if (const int kl = symmetric_index(d, k, l); kl >= 0)
          a[kl] +=
              (0.5 * s) * (eigen.vector[i][k] * eigen.vector[j][l] + eigen.vector[j][k] * eigen.vector[i][l]);
  }
};

template <class V, int d> PrincipalParts<V, d> no_parts() {
  PrincipalParts<V, d> r;
  r.first = r.second = V(0.0);
  for (int k = 0; k < symmetric_size(d); ++k) r.tensor[k] = V(0.0);
  return r;
}

/// Map(m, e) at a tensor of values, of dual or of complex numbers.
template <template <class, int> class Map, class T, int d> struct Mapped {
  static PrincipalParts<T, d> at(const MaterialParameters& m, const Symmetric<T, d>& e) {
    return Map<T, d>(m, e).at();
  }
};
template <template <class, int> class Map, class V, int n, int d> struct Mapped<Map, Dual<V, n>, d> {
  static PrincipalParts<Dual<V, n>, d> at(const MaterialParameters& m, const Symmetric<Dual<V, n>, d>& e) {
    Symmetric<V, d> values;
    for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].v;
    const Map<V, d> map(m, values);
    PrincipalParts<Dual<V, n>, d> r;
    for (int k = 0; k < symmetric_size(d); ++k) r.tensor[k].v = map.at().tensor[k];
    r.first.v = map.at().first;
    r.second.v = map.at().second;
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].d[i];
      const PrincipalParts<V, d> slope = map.derivative(values);
      for (int k = 0; k < symmetric_size(d); ++k) r.tensor[k].d[i] = slope.tensor[k];
      r.first.d[i] = slope.first;
      r.second.d[i] = slope.second;
    }
    return r;
  }
};
template <template <class, int> class Map, int d> struct Mapped<Map, std::complex<double>, d> {
  using C = std::complex<double>;
  static PrincipalParts<C, d> at(const MaterialParameters& m, const Symmetric<C, d>& e) {
    Symmetric<double, d> values, step;
    for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].real(), step[k] = e[k].imag();
    const Map<double, d> map(m, values);
    const PrincipalParts<double, d> slope = map.derivative(step);
    PrincipalParts<C, d> r;
    for (int k = 0; k < symmetric_size(d); ++k) r.tensor[k] = {map.at().tensor[k], slope.tensor[k]};
    r.first = {map.at().first, slope.first};
    r.second = {map.at().second, slope.second};
    return r;
  }
};

} // namespace impact
