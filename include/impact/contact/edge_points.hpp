#pragma once
#include <impact/contact/point_form.hpp>

/// Points of edges in the plane: each faces the nearest place of the primary surface (71')
/// (contact_pair.hpp).
namespace impact {

struct EdgePoints {
  static constexpr std::size_t dim = 2, corners = 2;
  static constexpr HoldRule hold = hold_on_edge;
  using Corners = std::array<Point2<double>, 2>;
  struct Seen {
    int candidate = -1, part = 0;
    Foot<double> foot;
    PrimaryEdge<double> edge;
  };
  struct Pair {
    SlipAnchor anchor;
    double start = 0; // slip then, where the gap is not along the secondary's own normal
  };
  struct Map {};

  static FormPoints make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static std::vector<Map> make_maps(const ContactSurface& surface, const FormPoints& /*points*/) {
    return std::vector<Map>(static_cast<std::size_t>(surface.count()));
  }
  static Point2<double> normal(const Corners& x) { return detail::right_normal(x[0], x[1]); }
  static double stretch(const Corners& x, const Corners& /*from_corner*/, const ContactSurface& surface,
                        int f) {
    return std::hypot(x[1][0] - x[0][0], x[1][1] - x[0][1]) / surface.length[static_cast<std::size_t>(f)];
  }
  static bool faces(const CarriedFunction& gap, const Point2<double>& normal);
  static bool within(const Seen& seen, double beyond) { return std::abs(seen.foot.xi) <= 1 + beyond; }
  static double size_of(const Seen& seen, double /*secondary*/) {
    const Point2<double> t = detail::minus(seen.edge.x1, seen.edge.x0);
    return std::sqrt(detail::dot(t, t));
  }
  static std::array<double, 2> shares_of(const Seen& seen) {
    return {(1 - seen.foot.xi) / 2, (1 + seen.foot.xi) / 2};
  }
  static Pair pair_of(const ShapeValues& shape, const Seen* seen);
  static void start(const Corners& s, const Corners& p, const Map& /*map*/, Pair& pair) {
    pair.start = slip_of(s, p, pair.anchor).value;
  }
  static void add_slips(const Corners& s, const Corners& p, const Map& map, const Pair& pair,
                        bool with_gradient, Tangential& value, std::array<std::array<double, 8>, 1>& rows);
  static void add_slip_hessian(const Corners& s, const Corners& p, const Map& map, const Pair& pair,
                               const Tangential& factor, std::array<double, 64>& hessian);
};
using EdgePointForm = PointForm<EdgePoints>;
/// Throws UserError(usage): a number of points out of range. Collective.
std::unique_ptr<ContactForm> make_edge_point_form(const FormRequest& request);

} // namespace impact
