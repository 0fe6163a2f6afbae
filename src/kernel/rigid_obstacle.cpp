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

CarriedFunction carried_product(const std::array<double, 3>& q, const std::array<double, 3>& d) {
  CarriedFunction f;
  f.value = q[0] * d[0] + q[1] * d[1] + q[2] * d[2];
  f.by_place = d;
  f.by_direction = q;
  for (std::size_t k = 0; k < 9; k += 4) f.place_direction[k] = 1;
  return f;
}

CarriedFunction carried_gap(const RigidObstacle& obstacle, const std::array<double, 3>& x) {
  std::array<double, 3> q{};
  for (std::size_t k = 0; k < 3; ++k) q[k] = x[k] - obstacle.point[k];
  const std::array<double, 3>& d = obstacle.direction;
  if (obstacle.shape == RigidObstacle::Shape::plane) return carried_product(q, d);
  CarriedFunction f;
  const auto take = [&](const ObstacleGap& gap) {
    f.value = gap.gap;
    f.by_place = gap.normal;
    f.place_place = gap.curvature;
  };
  if (obstacle.shape == RigidObstacle::Shape::sphere) {
    take(gap_to(obstacle, x));
    return f;
  }
  RigidObstacle straight = obstacle;
  const double size = std::hypot(d[0], d[1], d[2]);
  for (double& component : straight.direction) component /= size;
  const auto& a = straight.direction;
  const ObstacleGap gap = gap_to(straight, x);
  take(gap);
  // With s = q.a, r = q - s a and n = r/|r|: dg/dd = -s n/|d|, because n.a = 0, and its derivatives; T/|r| is
  // the curvature, T = 1 - a a - n n.
  const double along = q[0] * a[0] + q[1] * a[1] + q[2] * a[2], distance = gap.gap + obstacle.radius;
  const auto& n = gap.normal;
  for (std::size_t i = 0; i < 3; ++i) {
    f.by_direction[i] = -along * n[i] / size;
    for (std::size_t j = 0; j < 3; ++j) {
      const double bend = along * gap.curvature[3 * i + j];
      f.place_direction[3 * i + j] = -(a[i] * n[j] + bend) / size;
      f.direction_direction[3 * i + j] =
          (along * (n[i] * a[j] + a[i] * n[j] + bend) - distance * n[i] * n[j]) / (size * size);
    }
  }
  return f;
}

std::array<double, 3> gradient_by(const CarriedFunction& f, const CarriedShare& node) {
  std::array<double, 3> gradient{};
  for (std::size_t k = 0; k < 3; ++k)
    gradient[k] = node.place * f.by_place[k] + node.direction * f.by_direction[k];
  return gradient;
}

std::array<double, 9> hessian_by(const CarriedFunction& f, const CarriedShare& row,
                                 const CarriedShare& column) {
  std::array<double, 9> H{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      H[3 * i + j] = row.place * column.place * f.place_place[3 * i + j] +
                     row.place * column.direction * f.place_direction[3 * i + j] +
                     row.direction * column.place * f.place_direction[3 * j + i] +
                     row.direction * column.direction * f.direction_direction[3 * i + j];
  return H;
}

} // namespace impact
