#pragma once
#include <algorithm>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/rigid_bodies.hpp>

/// What the sources of rigid bodies share.
namespace impact {

inline Vector3 plus(const Vector3& a, const Vector3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

/// int rho (r.q 1 - r q^T) for arms r = A Y, q = B Y and E = int rho Y Y^T.
inline Matrix3 inertia_of(const Matrix3& A, const Matrix3& E, const Matrix3& B) {
  Matrix3 J = A * E * transposed(B);
  const double t = trace(J);
  for (std::size_t i = 0; i < 9; ++i) J[i] = (i % 4 == 0 ? t : 0) - J[i];
  return J;
}

/// Slope at t of data over t at a place, one-sided: towards t + h.
inline double slope(const Expression& data, const double* x, int dim, double t, double h) {
  return (-3 * data(x, dim, t) + 4 * data(x, dim, t + h) - data(x, dim, t + 2 * h)) / (2 * h);
}

template <class Field> void RigidBodies::set_nodes(Vec u, Field&& field) const {
  double* values = nullptr;
  check(VecGetArray(u, &values));
  for (std::size_t i = 0; i < owned_; ++i) {
    const Vector3 value = field(at(body_[i]), arm(i));
    std::copy_n(value.begin(), dim_, values + row_[i]);
  }
  check(VecRestoreArray(u, &values));
}

} // namespace impact
