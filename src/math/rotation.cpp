#include <cmath>
#include <impact/math/index.hpp>
#include <impact/math/rotation.hpp>
#include <limits>

namespace impact {

namespace {

std::size_t at(int i, int j) { return static_cast<std::size_t>(3 * i + j); }

double norm(const Matrix3& a) {
  double square = 0;
  for (double entry : a) square += entry * entry;
  return std::sqrt(square);
}

// 1 + a [v] + b [v][v]
Matrix3 by_powers(const Vector3& v, double a, double b) {
  const Matrix3 W = cross_matrix(v), W2 = W * W;
  Matrix3 R = unit_matrix;
  for (std::size_t i = 0; i < 9; ++i) R[i] += a * W[i] + b * W2[i];
  return R;
}

// Half of the axial vector of the antisymmetric part: sin(angle) along the axis of a rotation.
Vector3 sine_vector(const Matrix3& R) {
  const Vector3 w = axial(R);
  return {w[0] / 2, w[1] / 2, w[2] / 2};
}

} // namespace

Matrix3 operator*(const Matrix3& a, const Matrix3& b) {
  Matrix3 c{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) c[at(i, j)] += a[at(i, k)] * b[at(k, j)];
  return c;
}

Vector3 operator*(const Matrix3& a, const Vector3& x) {
  Vector3 y{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) y[at(i)] += a[at(i, j)] * x[at(j)];
  return y;
}

Matrix3 transposed(const Matrix3& a) { return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]}; }

double trace(const Matrix3& a) { return a[0] + a[4] + a[8]; }

double determinant(const Matrix3& a) {
  return a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) +
         a[2] * (a[3] * a[7] - a[4] * a[6]);
}

Matrix3 inverse(const Matrix3& a) {
  Matrix3 b = {a[4] * a[8] - a[5] * a[7], a[2] * a[7] - a[1] * a[8], a[1] * a[5] - a[2] * a[4],
               a[5] * a[6] - a[3] * a[8], a[0] * a[8] - a[2] * a[6], a[2] * a[3] - a[0] * a[5],
               a[3] * a[7] - a[4] * a[6], a[1] * a[6] - a[0] * a[7], a[0] * a[4] - a[1] * a[3]};
  const double det = determinant(a);
  for (double& entry : b) entry /= det;
  return b;
}

Matrix3 cross_matrix(const Vector3& a) { return {0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0}; }

Vector3 axial(const Matrix3& a) {
  return {a[at(2, 1)] - a[at(1, 2)], a[at(0, 2)] - a[at(2, 0)], a[at(1, 0)] - a[at(0, 1)]};
}

Matrix3 nearest_rotation(const Matrix3& a) {
  Matrix3 X = a;
  if (!(determinant(a) > 0)) {
    X.fill(std::numeric_limits<double>::quiet_NaN());
    return X;
  }
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Matrix3 Y = transposed(inverse(X));
    const double scale = std::sqrt(norm(Y) / norm(X));
    Matrix3 next;
    double change = 0;
    for (std::size_t i = 0; i < 9; ++i) {
      next[i] = (scale * X[i] + Y[i] / scale) / 2;
      change = std::fmax(change, std::abs(next[i] - X[i]));
    }
    X = next;
    if (!(change > 1e-15)) break;
  }
  return X;
}

Matrix3 rotation_of(const Vector3& v) {
  const double angle = std::hypot(v[0], v[1], v[2]), half = angle / 2;
  const double a = angle > 1e-6 ? std::sin(angle) / angle : 1 - angle * angle / 6;
  const double s = half > 1e-6 ? std::sin(half) / half : 1 - half * half / 6;
  return by_powers(v, a, s * s / 2);
}

Vector3 rotation_vector(const Matrix3& R) {
  // The unit quaternion from its largest component, which keeps all digits at any angle.
  const double t = trace(R);
  double q0 = 0;
  Vector3 q{};
  if (t > 0) {
    q0 = std::sqrt(1 + t) / 2;
    const Vector3 s = sine_vector(R);
    for (std::size_t i = 0; i < 3; ++i) q[i] = s[i] / (2 * q0);
  } else {
    int i = 0;
    for (int k = 1; k < 3; ++k)
      if (R[at(k, k)] > R[at(i, i)]) i = k;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double qi = std::sqrt(std::fmax(0.0, 1 + R[at(i, i)] - R[at(j, j)] - R[at(k, k)])) / 2;
    q[at(i)] = qi;
    q[at(j)] = (R[at(i, j)] + R[at(j, i)]) / (4 * qi);
    q[at(k)] = (R[at(i, k)] + R[at(k, i)]) / (4 * qi);
    q0 = (R[at(k, j)] - R[at(j, k)]) / (4 * qi);
    if (q0 < 0) {
      q0 = -q0;
      for (double& component : q) component = -component;
    }
  }
  const double sine = std::hypot(q[0], q[1], q[2]);
  const double factor = sine > 1e-12 ? 2 * std::atan2(sine, q0) / sine : 2.0;
  for (double& component : q) component *= factor;
  return q;
}

Matrix3 cayley(const Vector3& c) {
  const double square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2], a = 1 / (1 + square / 4);
  return by_powers(c, a, a / 2);
}

Vector3 cayley_vector(const Matrix3& R) {
  Vector3 c = sine_vector(R);
  for (double& component : c) component *= 4 / (1 + trace(R));
  return c;
}

} // namespace impact
