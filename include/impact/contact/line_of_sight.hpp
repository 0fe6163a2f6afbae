#pragma once
#include <algorithm>
#include <cmath>
#include <impact/kernel/face_ray.hpp>
#include <impact/kernel/facet_slip.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>

/// What points that look along their normal pass over before they cast a ray: outlines of the primary facets
/// that a secondary facet may see, made once for all of its points. Of both kinds below
///   View     what the points of a secondary facet have in common,
///   Line     the line of sight of one of them,
///   Outline  of a primary facet in such a view, which has been found to see the ball about that facet.
namespace impact {

struct SightLimits {
  double far;     ///< nothing is seen farther ahead
  double beyond;  ///< part of a primary face by which it is continued beyond its sides
  double weights; ///< most that the weights of a facet's nodes come to without their signs, there
};

/// About the mean of a primary facet's nodes, with all of them in it.
template <class Place> struct FacetBall {
  template <class Nodes> explicit FacetBall(const Nodes& p) {
    for (const Place& node : p)
      for (std::size_t k = 0; k < centre.size(); ++k) centre[k] += node[k] / static_cast<double>(p.size());
    double farthest = 0;
    for (const Place& node : p) {
      double square = 0;
      for (std::size_t k = 0; k < centre.size(); ++k) square += (node[k] - centre[k]) * (node[k] - centre[k]);
      farthest = std::max(farthest, square);
    }
    radius = std::sqrt(farthest);
  }
  Place centre{};
  double radius;
};

/// Of a straight face in space: all its points look along one unit vector n, over the plane across it.
struct FaceView {
  using Line = std::array<double, 2>; ///< where a line of sight meets that plane

  FaceView(const FaceCorners& x, const Point3& n, const SightLimits& given)
      : normal(n), across_normal(tangents_of(n)), limits(given) {
    for (const Point3& corner : x)
      for (std::size_t k = 0; k < 3; ++k) origin[k] += corner[k] / 4;
    for (const Point3& corner : x) {
      const Point3 d = from_origin(corner);
      reach = std::max(reach, dot(d, d));
    }
    reach = std::sqrt(reach);
  }
  Point3 from_origin(const Point3& x) const { return {x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]}; }
  Line across(const Point3& d) const { return {dot(across_normal[0], d), dot(across_normal[1], d)}; }
  Line line(const Point3& x, const Point3& /*n*/) const { return across(from_origin(x)); }
  /// Whether any point of the face may see what lies in a ball.
  bool sees(const FacetBall<Point3>& ball) const {
    const Point3 d = from_origin(ball.centre);
    const double along = dot(normal, d), wide = limits.weights * ball.radius + reach;
    return dot(d, d) - along * along <= (1 + 1e-9) * wide * wide && along - wide <= limits.far;
  }
  /// Whether a line of sight passes a ball, with room for what its facet is beyond its sides.
  bool misses(const Line& x, const FacetBall<Point3>& ball) const {
    const Line centre = across(from_origin(ball.centre));
    const double a = centre[0] - x[0], b = centre[1] - x[1], wide = limits.weights * ball.radius;
    return a * a + b * b > wide * wide;
  }

  Point3 origin{}, normal;
  std::array<Point3, 2> across_normal;
  double reach = 0; ///< of its corners from the origin
  SightLimits limits;
};

/// A face of first order: the triangles about the mean of its corners.
class FaceOutline {
public:
  FaceOutline(const FaceCorners& p, int corners, const FaceView& view)
      : corners_(at(corners)), beyond_(view.limits.beyond) {
    for (std::size_t c = 0; c < 4; ++c) {
      seen_[c] = view.across(view.from_origin(p[c]));
      for (std::size_t k = 0; k < 2; ++k) middle_[k] += seen_[c][k] / 4;
    }
  }
  /// Whether a line of sight passes it by more than the part `beyond` of a triangle, with room for what is
  /// bent; what is seen from its side is not judged.
  bool misses(const FaceView::Line& x) const {
    for (std::size_t t = 0; t < (corners_ == 3 ? 1 : corners_); ++t)
      if (!misses(x, t)) return false;
    return true;
  }

private:
  using Line = FaceView::Line;

  bool misses(const Line& x, std::size_t t) const {
    const Line p = from(x, seen_[t]), q = from(x, seen_[(t + 1) % corners_]),
               r = from(x, corners_ == 3 ? seen_[2] : middle_);
    const double parts[3] = {area(q, r), area(r, p), area(p, q)}, all = parts[0] + parts[1] + parts[2];
    const double size = std::abs(parts[0]) + std::abs(parts[1]) + std::abs(parts[2]);
    if (!(std::abs(all) > 1e-6 * size)) return false;
    // The least part of all, without a division.
    const double least =
        all > 0 ? std::min({parts[0], parts[1], parts[2]}) : -std::max({parts[0], parts[1], parts[2]});
    return least < -1.5 * beyond_ * std::abs(all);
  }
  static Line from(const Line& x, const Line& p) { return {p[0] - x[0], p[1] - x[1]}; }
  static double area(const Line& p, const Line& q) { return p[0] * q[1] - p[1] * q[0]; }

  std::size_t corners_;
  double beyond_;
  std::array<Line, 4> seen_;
  Line middle_{};
};

} // namespace impact
