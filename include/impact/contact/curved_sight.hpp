#pragma once
#include <impact/contact/line_of_sight.hpp>

/// Lines of sight of points on facets of second order.
namespace impact {

/// Of a facet of second order, whose points look along normals of their own.
template <class Place> struct CurvedView {
  struct Line {
    Place x, n;
  };
  template <class Nodes>
  CurvedView(const Nodes& /*x*/, const Place& /*n*/, const SightLimits& given) : limits(given) {}
  static Line line(const Place& x, const Place& n) { return {x, n}; }
  static bool sees(const FacetBall<Place>&) { return true; }
  /// Every place sum w_a p_a of the facet with sum w_a = 1 and sum |w_a| <= limits.weights lies in a ball
  /// that is wider by as much.
  bool misses(const Line& line, const FacetBall<Place>& ball) const {
    const double radius = limits.weights * ball.radius;
    double along = 0, distance = 0;
    for (std::size_t k = 0; k < line.x.size(); ++k) along += (ball.centre[k] - line.x[k]) * line.n[k];
    for (std::size_t k = 0; k < line.x.size(); ++k) {
      const double across = ball.centre[k] - line.x[k] - along * line.n[k];
      distance += across * across;
    }
    return distance > radius * radius || along - radius > limits.far;
  }

  SightLimits limits;
};

/// The ball about a facet of second order is all that is known of it.
template <class Nodes> struct CurvedOutline {
  using View = CurvedView<typename Nodes::value_type>;
  CurvedOutline(const Nodes&, int /*corners*/, const View&) {}
  static bool misses(const typename View::Line&) { return false; }
};

} // namespace impact
