#pragma once
#include <algorithm>
#include <cmath>
#include <impact/kernel/face_ray.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>

/// What a point that looks along its normal passes over before it casts a ray.
namespace impact {

/// A face as it is seen from a point along a unit vector: the triangles about the mean of its corners, in the
/// plane across that.
class Sight {
public:
  Sight(const FaceCorners& p, int corners, const Point3& x, const Point3& n, double beyond)
      : corners_(at(corners)), beyond_(beyond) {
    // Of the axes the one that n is least along.
    std::size_t least = 0;
    for (std::size_t k = 1; k < 3; ++k)
      if (std::abs(n[k]) < std::abs(n[least])) least = k;
    Point3 axis{};
    axis[least] = 1;
    const Point3 a = cross(n, axis), b = cross(n, a);
    for (std::size_t c = 0; c < corners_; ++c) {
      const Point3 d = {p[c][0] - x[0], p[c][1] - x[1], p[c][2] - x[2]};
      seen_[c] = {dot(a, d), dot(b, d)};
      for (std::size_t k = 0; k < 2; ++k) seen_[4][k] += seen_[c][k] / 4;
    }
  }
  /// Whether the ray passes it by more than the part `beyond` of a triangle, with room for what is bent; what
  /// is seen from its side is not judged.
  bool misses() const {
    for (std::size_t t = 0; t < (corners_ == 3 ? 1 : corners_); ++t)
      if (!misses(t)) return false;
    return true;
  }

private:
  bool misses(std::size_t t) const {
    const Seen2 &p = seen_[t], &q = seen_[(t + 1) % corners_], &r = corners_ == 3 ? seen_[2] : seen_[4];
    const double parts[3] = {area(q, r), area(r, p), area(p, q)}, all = parts[0] + parts[1] + parts[2];
    const double size = std::abs(parts[0]) + std::abs(parts[1]) + std::abs(parts[2]);
    if (!(std::abs(all) > 1e-6 * size)) return false;
    return std::min({parts[0] / all, parts[1] / all, parts[2] / all}) < -1.5 * beyond_;
  }

  using Seen2 = std::array<double, 2>;
  static double area(const Seen2& p, const Seen2& q) { return p[0] * q[1] - p[1] * q[0]; }
  std::size_t corners_;
  double beyond_;
  std::array<Seen2, 5> seen_{};
};
/// A curved face is met as it is.
struct AnySight {
  template <class... Arguments> explicit AnySight(const Arguments&...) {}
  static bool misses() { return false; }
};

/// About the mean of the nodes, with every place sum w_a p_a with sum w_a = 1 and sum |w_a| <= weights in it.
template <class Ball, class Nodes> Ball ball_about(const Nodes& p, double weights) {
  Ball ball;
  const std::size_t dim = ball.centre.size();
  for (const auto& node : p)
    for (std::size_t k = 0; k < dim; ++k) ball.centre[k] += node[k] / static_cast<double>(p.size());
  double radius = 0;
  for (const auto& node : p) {
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) square += (node[k] - ball.centre[k]) * (node[k] - ball.centre[k]);
    radius = std::max(radius, square);
  }
  ball.radius = weights * std::sqrt(radius);
  return ball;
}

/// Whether a line along the unit vector n passes it by, or meets it farther than `far` ahead.
template <class Ball, class Place>
bool passes_by(const Ball& ball, const Place& x, const Place& n, double far) {
  double along = 0, distance = 0;
  for (std::size_t k = 0; k < x.size(); ++k) along += (ball.centre[k] - x[k]) * n[k];
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double across = ball.centre[k] - x[k] - along * n[k];
    distance += across * across;
  }
  return distance > ball.radius * ball.radius || along - ball.radius > far;
}

} // namespace impact
