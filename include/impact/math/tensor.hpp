#pragma once
#include <impact/math/dual.hpp>
#include <impact/math/unroll.hpp>

/// Three-dimensional second-order tensors of a scalar T in two layouts. d = 3: full 3x3. d = 2: the plane
/// layout, where 13, 23, 31, 32 vanish but 33 does not (plane strain, axisymmetry); sums, products and
/// inverses stay in the layout.
///   Tensor<T, 2>    11 12 21 22 33            Tensor<T, 3>    row-major 3x3
///   Symmetric<T, 2> 11 22 33 12               Symmetric<T, 3> 11 22 33 12 23 13   (the order of the point
///   history)
namespace impact {

template <class T, int n> struct Vector {
  T c[n];
  T& operator[](int i) { return c[i]; }
  const T& operator[](int i) const { return c[i]; }

  friend Vector operator+(Vector a, const Vector& b) {
    for (int i = 0; i < n; ++i) a.c[i] += b.c[i];
    return a;
  }
  friend Vector operator*(const T& s, const Vector& a) {
    Vector r;
    for (int i = 0; i < n; ++i) r.c[i] = s * a.c[i];
    return r;
  }
};

template <class T, int n> T dot(const Vector<T, n>& a, const Vector<T, n>& b) {
  return sum<n>([&](int i) { return a[i] * b[i]; });
}

inline constexpr int tensor_size(int d) { return d == 2 ? 5 : 9; }
inline constexpr int symmetric_size(int d) { return d == 2 ? 4 : 6; }

/// Position of component (i, j), counted from 0, or -1 where the plane layout has a zero.
inline constexpr int tensor_index(int d, int i, int j) {
  return d == 3 ? 3 * i + j : i < 2 && j < 2 ? 2 * i + j : i == 2 && j == 2 ? 4 : -1;
}
inline constexpr int symmetric_index(int d, int i, int j) {
  if (i == j) return i;
  const int s = i + j;
  return s == 1 ? 3 : d == 2 ? -1 : s == 3 ? 4 : 5;
}

template <class T, int d> struct Tensor {
  T c[tensor_size(d)];
  T& operator[](int i) { return c[i]; }
  const T& operator[](int i) const { return c[i]; }
};

template <class T, int d> struct Symmetric {
  T c[symmetric_size(d)];
  T& operator[](int i) { return c[i]; }
  const T& operator[](int i) const { return c[i]; }

  friend Symmetric operator+(const Symmetric& a, const Symmetric& b) {
    Symmetric r;
    for (int i = 0; i < symmetric_size(d); ++i) r.c[i] = a.c[i] + b.c[i];
    return r;
  }
  friend Symmetric operator-(const Symmetric& a, const Symmetric& b) {
    Symmetric r;
    for (int i = 0; i < symmetric_size(d); ++i) r.c[i] = a.c[i] - b.c[i];
    return r;
  }
  friend Symmetric operator*(const T& s, const Symmetric& a) {
    Symmetric r;
    for (int i = 0; i < symmetric_size(d); ++i) r.c[i] = s * a.c[i];
    return r;
  }
};

template <class T, int d> Symmetric<T, d> identity() {
  Symmetric<T, d> r;
  for (int i = 0; i < symmetric_size(d); ++i) r[i] = T(i < 3 ? 1.0 : 0.0);
  return r;
}

template <class T, int d> T trace(const Symmetric<T, d>& a) { return a[0] + a[1] + a[2]; }
template <class T, int d> T trace(const Tensor<T, d>& a) {
  return a[tensor_index(d, 0, 0)] + a[tensor_index(d, 1, 1)] + a[tensor_index(d, 2, 2)];
}

template <class T, int d> Symmetric<T, d> dev(Symmetric<T, d> a) {
  const T mean = trace(a) * (1.0 / 3);
  for (int i = 0; i < 3; ++i) a[i] = a[i] - mean;
  return a;
}

/// a : b
template <class T, int d> T dot(const Symmetric<T, d>& a, const Symmetric<T, d>& b) {
  T off = a[3] * b[3];
  for (int i = 4; i < symmetric_size(d); ++i) off += a[i] * b[i];
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * off;
}

template <class T, int d> T det(const Symmetric<T, d>& a) {
  if constexpr (d == 2)
    return (a[0] * a[1] - a[3] * a[3]) * a[2];
  else
    return a[0] * (a[1] * a[2] - a[4] * a[4]) - a[3] * (a[3] * a[2] - a[4] * a[5]) +
           a[5] * (a[3] * a[4] - a[1] * a[5]);
}

/// Determinant of 1 + h minus 1, without cancellation for small h.
template <class T, int d> T detm1(const Tensor<T, d>& h) {
  if constexpr (d == 2) {
    const T plane = h[0] + h[3] + (h[0] * h[3] - h[1] * h[2]);
    return plane + h[4] + plane * h[4];
  } else {
    const T second = h[0] * h[4] - h[1] * h[3] + (h[4] * h[8] - h[5] * h[7]) + (h[0] * h[8] - h[2] * h[6]);
    const T third = h[0] * (h[4] * h[8] - h[5] * h[7]) - h[1] * (h[3] * h[8] - h[5] * h[6]) +
                    h[2] * (h[3] * h[7] - h[4] * h[6]);
    return h[0] + h[4] + h[8] + second + third;
  }
}

/// 1 + h
template <class T, int d> Tensor<T, d> plus_identity(Tensor<T, d> h) {
  for (int i = 0; i < 3; ++i) h[tensor_index(d, i, i)] = h[tensor_index(d, i, i)] + T(1.0);
  return h;
}

/// det(F) F^-T
template <class T, int d> Tensor<T, d> cofactor(const Tensor<T, d>& F) {
  Tensor<T, d> r;
  if constexpr (d == 2) {
    r[0] = F[3] * F[4];
    r[1] = -(F[2] * F[4]);
    r[2] = -(F[1] * F[4]);
    r[3] = F[0] * F[4];
    r[4] = F[0] * F[3] - F[1] * F[2];
  } else {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int a = (i + 1) % 3, b = (i + 2) % 3, k = (j + 1) % 3, l = (j + 2) % 3;
        r[3 * i + j] = F[3 * a + k] * F[3 * b + l] - F[3 * a + l] * F[3 * b + k];
      }
  }
  return r;
}

template <class T, int d> Tensor<T, d> transpose(const Tensor<T, d>& a) {
  Tensor<T, d> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (tensor_index(d, i, j) >= 0) r[tensor_index(d, i, j)] = a[tensor_index(d, j, i)];
  return r;
}

/// F^-1 from its cofactor and determinant.
template <class T, int d> Tensor<T, d> inverse(const Tensor<T, d>& F, const T& det_F) {
  Tensor<T, d> r = transpose(cofactor(F));
  const T s = T(1.0) / det_F;
  for (int i = 0; i < tensor_size(d); ++i) r[i] = r[i] * s;
  return r;
}

/// F A F^T
template <class T, int d> Symmetric<T, d> push(const Tensor<T, d>& F, const Symmetric<T, d>& A) {
  Symmetric<T, d> r;
  if constexpr (d == 2) {
    const T a = F[0] * A[0] + F[1] * A[3], b = F[0] * A[3] + F[1] * A[1];
    const T c = F[2] * A[0] + F[3] * A[3], e = F[2] * A[3] + F[3] * A[1];
    r[0] = a * F[0] + b * F[1];
    r[1] = c * F[2] + e * F[3];
    r[2] = F[4] * F[4] * A[2];
    r[3] = a * F[2] + b * F[3];
  } else {
    Tensor<T, 3> m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        m[3 * i + j] = F[3 * i] * A[symmetric_index(3, 0, j)] + F[3 * i + 1] * A[symmetric_index(3, 1, j)] +
                       F[3 * i + 2] * A[symmetric_index(3, 2, j)];
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j)
        r[symmetric_index(3, i, j)] =
            m[3 * i] * F[3 * j] + m[3 * i + 1] * F[3 * j + 1] + m[3 * i + 2] * F[3 * j + 2];
  }
  return r;
}

/// h + h^T + h h^T = F F^T - 1 for F = 1 + h, without cancellation.
template <class T, int d> Symmetric<T, d> left_strain(const Tensor<T, d>& h) {
  Symmetric<T, d> r = push(h, identity<T, d>());
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      if (tensor_index(d, i, j) >= 0)
        r[symmetric_index(d, i, j)] += h[tensor_index(d, i, j)] + h[tensor_index(d, j, i)];
  return r;
}

/// sym(a b) of two symmetric tensors that need not commute; (n n) for a = b = n.
template <class T, int d> Symmetric<T, d> product(const Symmetric<T, d>& a, const Symmetric<T, d>& b) {
  Symmetric<T, d> r;
  if constexpr (d == 2) {
    r[0] = a[0] * b[0] + a[3] * b[3];
    r[1] = a[1] * b[1] + a[3] * b[3];
    r[2] = a[2] * b[2];
    r[3] = 0.5 * (a[0] * b[3] + a[3] * b[1] + b[0] * a[3] + b[3] * a[1]);
  } else {
    const auto m = [&](int i, int j) {
      return a[symmetric_index(3, i, 0)] * b[symmetric_index(3, 0, j)] +
             a[symmetric_index(3, i, 1)] * b[symmetric_index(3, 1, j)] +
             a[symmetric_index(3, i, 2)] * b[symmetric_index(3, 2, j)];
    };
    for (int i = 0; i < 3; ++i) r[i] = m(i, i);
    r[3] = 0.5 * (m(0, 1) + m(1, 0));
    r[4] = 0.5 * (m(1, 2) + m(2, 1));
    r[5] = 0.5 * (m(0, 2) + m(2, 0));
  }
  return r;
}

} // namespace impact
