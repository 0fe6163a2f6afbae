#pragma once
#include <array>
#include <cmath>
#include <complex>
#include <impact/math/tensor.hpp>
#include <random>

/// Dense 3x3 matrices over double or complex as the plain counterpart of the library's tensor layouts, the
/// way between the two, and random tensors.
namespace reference {

using Complex = std::complex<double>;
template <class T> using Matrix = std::array<T, 9>;

inline double real(double x) { return x; }
inline double real(const Complex& x) { return x.real(); }

inline constexpr double step = 1e-30; ///< of the complex derivative

template <class T> Matrix<T> unit() { return {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}; }
template <class T> T trace(const Matrix<T>& a) { return a[0] + a[4] + a[8]; }
template <class T> T det(const Matrix<T>& a) {
  return a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) +
         a[2] * (a[3] * a[7] - a[4] * a[6]);
}
template <class T> Matrix<T> transpose(const Matrix<T>& a) {
  return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]};
}
template <class T, class S> auto multiply(const Matrix<T>& a, const Matrix<S>& b) {
  Matrix<decltype(T() * S())> r{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      for (unsigned k = 0; k < 3; ++k) r[3 * i + j] += a[3 * i + k] * b[3 * k + j];
  return r;
}
template <class T> Matrix<T> inverse(const Matrix<T>& a) {
  Matrix<T> r;
  const T d = det(a);
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j) {
      const unsigned k = (i + 1) % 3, l = (i + 2) % 3, m = (j + 1) % 3, n = (j + 2) % 3;
      r[3 * j + i] = (a[3 * k + m] * a[3 * l + n] - a[3 * k + n] * a[3 * l + m]) / d;
    }
  return r;
}
template <class T> T dot(const Matrix<T>& a, const Matrix<T>& b) {
  T s = 0.0;
  for (unsigned i = 0; i < 9; ++i) s += a[i] * b[i];
  return s;
}

template <int d, class T> Matrix<T> dense(const impact::Tensor<T, d>& t) {
  Matrix<T> r{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (impact::tensor_index(d, i, j) >= 0) r[unsigned(3 * i + j)] = t[impact::tensor_index(d, i, j)];
  return r;
}
template <int d, class T> Matrix<T> dense(const impact::Symmetric<T, d>& t) {
  Matrix<T> r{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (impact::symmetric_index(d, i, j) >= 0) r[unsigned(3 * i + j)] = t[impact::symmetric_index(d, i, j)];
  return r;
}
template <int d, class T> impact::Tensor<T, d> tensor(const Matrix<T>& m) {
  impact::Tensor<T, d> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (impact::tensor_index(d, i, j) >= 0) r[impact::tensor_index(d, i, j)] = m[unsigned(3 * i + j)];
  return r;
}
template <int d, class T> impact::Symmetric<T, d> symmetric(const Matrix<T>& m) {
  impact::Symmetric<T, d> r;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      if (impact::symmetric_index(d, i, j) >= 0) r[impact::symmetric_index(d, i, j)] = m[unsigned(3 * i + j)];
  return r;
}

struct TensorSampler {
  std::mt19937 engine;
  explicit TensorSampler(unsigned seed) : engine(seed) {}
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }

  /// Displacement gradient with entries up to `size`; in the plane layout 33 varies too.
  template <int d> impact::Tensor<double, d> gradient(double size) {
    impact::Tensor<double, d> H;
    for (int i = 0; i < impact::tensor_size(d); ++i) H[i] = uniform(-size, size);
    return H;
  }

  /// Unimodular, symmetric, positive Q Q^T / det^(1/3) with Q = 1 + R, entries of R up to `size`.
  template <int d> impact::Symmetric<double, d> unimodular(double size) {
    Matrix<double> Q = dense<d>(gradient<d>(size));
    for (unsigned i = 0; i < 3; ++i) Q[4 * i] += 1;
    Matrix<double> A = multiply(Q, transpose(Q));
    const double scale = std::cbrt(det(A));
    for (double& x : A) x /= scale;
    return symmetric<d>(A);
  }
};

} // namespace reference
