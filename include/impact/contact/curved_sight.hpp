#pragma once
#include <algorithm>
#include <cmath>
#include <impact/contact/line_of_sight.hpp>

/// Lines of sight of points on facets of second order.
namespace impact {

/// Of a facet of second order, whose points look along normals of their own.
template <class Place> struct CurvedView {
  struct Line {
    Place x, n;
    double far;
  };
  template <class Nodes>
  CurvedView(const Nodes& /*x*/, const Place& /*n*/, const SightLimits& given) : limits(given) {}
  Line line(const Place& x, const Place& n) const { return {x, n, limits.far}; }

  SightLimits limits;
};

/// A ball about the mean of its nodes, with every place sum w_a p_a with sum w_a = 1 and sum |w_a| <= weights
/// in it.
template <class Nodes> class CurvedOutline {
public:
  using Place = typename Nodes::value_type;
  static constexpr std::size_t dim = std::tuple_size_v<Place>, nodes = std::tuple_size_v<Nodes>;

  CurvedOutline(const Nodes& p, int /*corners*/, const CurvedView<Place>& view) {
    for (const Place& node : p)
      for (std::size_t k = 0; k < dim; ++k) centre_[k] += node[k] / static_cast<double>(nodes);
    double farthest = 0;
    for (const Place& node : p) {
      double square = 0;
      for (std::size_t k = 0; k < dim; ++k) square += (node[k] - centre_[k]) * (node[k] - centre_[k]);
      farthest = std::max(farthest, square);
    }
    radius_ = view.limits.weights * std::sqrt(farthest);
  }
  static bool in_sight() { return true; }
  bool misses(const typename CurvedView<Place>::Line& line) const {
    double along = 0, distance = 0;
    for (std::size_t k = 0; k < dim; ++k) along += (centre_[k] - line.x[k]) * line.n[k];
    for (std::size_t k = 0; k < dim; ++k) {
      const double across = centre_[k] - line.x[k] - along * line.n[k];
      distance += across * across;
    }
    return distance > radius_ * radius_ || along - radius_ > line.far;
  }

private:
  Place centre_{};
  double radius_ = 0;
};

} // namespace impact
