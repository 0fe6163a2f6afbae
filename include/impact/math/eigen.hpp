#pragma once
#include <impact/math/batch.hpp>
#include <impact/math/tensor.hpp>

/// Eigenvalues and eigenvectors of a symmetric tensor of V = double or Batch by Jacobi rotations: the vectors
/// are orthonormal to rounding whatever the distance of the values, which have no order.
namespace impact {

template <class V> struct EigenSystem {
  V value[3];
  V vector[3][3]; ///< [i] of value[i]
};

template <class V, int d> EigenSystem<V> eigen_system(const Symmetric<V, d>& a) {
  V m[3][3];
  EigenSystem<V> e;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int k = symmetric_index(d, i, j);
      m[i][j] = k < 0 ? V(0.0) : a[k];
      e.vector[i][j] = V(i == j ? 1.0 : 0.0);
    }
  // tan of the rotation that makes (p, q) vanish, the smaller one
  const auto rotate = [&](int p, int q) {
    const V gap = m[q][q] - m[p][p], two = 2.0 * m[p][q];
    const V root = sqrt(gap * gap + two * two);
    const V below = gap + select(gap < V(0.0), -root, root);
    const V t = select(abs(below) > V(0.0), two / below, V(0.0));
    const V c = V(1.0) / sqrt(V(1.0) + t * t), s = t * c;
    const int r = 3 - p - q;
    m[p][p] = m[p][p] - t * m[p][q];
    m[q][q] = m[q][q] + t * m[p][q];
    m[p][q] = m[q][p] = V(0.0);
    const V rp = m[r][p], rq = m[r][q];
    m[r][p] = m[p][r] = c * rp - s * rq;
    m[r][q] = m[q][r] = s * rp + c * rq;
    for (int k = 0; k < 3; ++k) {
      const V x = e.vector[p][k], y = e.vector[q][k];
      e.vector[p][k] = c * x - s * y;
      e.vector[q][k] = s * x + c * y;
    }
  };
  rotate(0, 1);
  if constexpr (d == 3)
    for (int sweep = 0; sweep < 12; ++sweep) { // converges quadratically: four or five
      rotate(0, 2);
      rotate(1, 2);
      rotate(0, 1);
      const V off = abs(m[0][2]) + abs(m[1][2]);
      if (!any(off > V(1e-17) * (abs(m[0][0]) + abs(m[1][1]) + abs(m[2][2])))) break;
    }
  for (int i = 0; i < 3; ++i) e.value[i] = m[i][i];
  return e;
}

} // namespace impact
