#include <cmath>
#include <impact/kernel/rigid_obstacle.hpp>

namespace impact {

ObstacleGap gap_to(const RigidObstacle& obstacle, const std::array<double, 3>& x) {
  const auto& a = obstacle.direction;
  std::array<double, 3> r{};
  for (std::size_t k = 0; k < 3; ++k) r[k] = x[k] - obstacle.point[k];
  const double along = r[0] * a[0] + r[1] * a[1] + r[2] * a[2];
  ObstacleGap result;
  if (obstacle.shape == RigidObstacle::Shape::plane) {
    result.gap = along;
    result.normal = a;
    return result;
  }
  const bool cylinder = obstacle.shape == RigidObstacle::Shape::cylinder;
  if (cylinder)
    for (std::size_t k = 0; k < 3; ++k) r[k] -= along * a[k];
  // With the pole p, r = (x - p) + R n and |r| - R = (|r|^2 - R^2)/(|r| + R).
  const auto& n = obstacle.outward;
  const bool from_pole = n[0] != 0 || n[1] != 0 || n[2] != 0;
  double along_pole = 0, square = 0;
  if (from_pole) {
    std::array<double, 3> d{};
    double d_along = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      d[k] = x[k] - obstacle.pole[k];
      d_along += d[k] * a[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (cylinder) d[k] -= d_along * a[k];
      along_pole += d[k] * n[k];
      square += d[k] * d[k];
      r[k] = d[k] + obstacle.radius * n[k];
    }
  }
  const double distance = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  result.gap = from_pole ? (2 * obstacle.radius * along_pole + square) / (distance + obstacle.radius)
                         : distance - obstacle.radius;
  if (!(distance > 1e-9 * obstacle.radius)) {
    // Any direction across the axis.
    std::size_t least = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (std::abs(a[k]) < std::abs(a[least])) least = k;
    result.normal[least] = 1;
    return result;
  }
  for (std::size_t k = 0; k < 3; ++k) result.normal[k] = r[k] / distance;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      result.curvature[3 * i + j] =
          ((i == j ? 1 : 0) - (cylinder ? a[i] * a[j] : 0) - result.normal[i] * result.normal[j]) / distance;
  return result;
}

} // namespace impact
