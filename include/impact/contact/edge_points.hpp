#pragma once
#include <impact/contact/point_form.hpp>

/// Points of straight edges in the plane: each faces the nearest place of the primary surface (71')
/// (contact_pair.hpp).
namespace impact {

struct EdgePoints : StraightPoints {
  static constexpr std::size_t dim = 2, nodes = 2;
  static constexpr HoldRule hold = hold_on_edge;
  struct View {};
  struct Outline {};
  struct Seen {
    int candidate = -1, part = 0;
    Foot<double> foot;
    PrimaryEdge<double> edge;
  };
  /// Gauss points, 1 to 16 per edge, exact for polynomials of degree 2 points - 1; numbered along the cone of
  /// the facet in the mesh, which is the same for every partition, so that what is kept per point can move to
  /// other ranks. Throws UserError(usage).
  static FormPoints<Point> make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static TangentRows<2, 2> tangents(const ContactSurface&, int, const Point&) { return {{{-1, 1}}}; }
  static Point2<double> normal(const EdgeCorners& x) { return detail::right_normal(x[0], x[1]); }
  static double size(const EdgeCorners& x, const EdgeCorners& /*from_first*/, const Point&) {
    return std::hypot(x[1][0] - x[0][0], x[1][1] - x[0][1]);
  }
  static bool faces(const CarriedFunction& gap, const Point2<double>& normal);
  static bool within(const Seen& seen, double beyond) { return std::abs(seen.foot.xi) <= 1 + beyond; }
  static double size_of(const Seen& seen, double /*secondary*/) {
    const Point2<double> t = detail::minus(seen.edge.x1, seen.edge.x0);
    return std::sqrt(detail::dot(t, t));
  }
  static double force_of(const Seen& /*seen*/) { return 1; } // the gap is the shortest way
  static ShapeValues shares_of(const Seen& seen) {
    return {(1 - seen.foot.xi) / 2, (1 + seen.foot.xi) / 2, 0, 0};
  }
  static std::array<double, 3> way_out(const Seen& seen, const Point2<double>&) {
    return {seen.foot.normal[0], seen.foot.normal[1], 0};
  }
};
using EdgePointForm = PointForm<EdgePoints>;
/// Throws UserError(usage): a number of points out of range. Collective.
std::unique_ptr<ContactForm> make_edge_point_form(const FormRequest& request);

} // namespace impact
