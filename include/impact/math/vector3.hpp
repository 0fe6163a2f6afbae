#pragma once
#include <array>
#include <cmath>

/// Vectors in space, of doubles or of numbers that carry derivatives along.
namespace impact {

template <class T> using Vector3Of = std::array<T, 3>;
using Vector3 = Vector3Of<double>;

template <class T> T dot(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T> std::array<T, 3> cross(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T> std::array<T, 3> minus(const std::array<T, 3>& a, const std::array<T, 3>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
/// a . (b x c)
template <class T>
T determinant(const std::array<T, 3>& a, const std::array<T, 3>& b, const std::array<T, 3>& c) {
  return dot(a, cross(b, c));
}
inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }
/// a / |a|
inline Vector3 unit(const Vector3& a) {
  const double l = length(a);
  return {a[0] / l, a[1] / l, a[2] / l};
}

/// Of vectors of two or three components, without the loop that a compiler unrolls for many.
inline void add_components(std::size_t dim, double times, const double* of, double* to) {
  to[0] += times * of[0];
  to[1] += times * of[1];
  if (dim == 3) to[2] += times * of[2];
}
inline double square_of_components(std::size_t dim, const double* of) {
  return of[0] * of[0] + of[1] * of[1] + (dim == 3 ? of[2] * of[2] : 0.0);
}

} // namespace impact
