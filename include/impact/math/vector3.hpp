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

} // namespace impact
