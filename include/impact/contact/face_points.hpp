#pragma once
#include <impact/contact/point_form.hpp>
#include <impact/kernel/face_ray.hpp>

/// Points of faces in space: each faces the triangle of the primary surface that lies along the normal of its
/// own face (71'') (face_ray.hpp).
namespace impact {

struct FacePoints {
  static constexpr std::size_t dim = 3, corners = 4;
  static constexpr HoldRule hold = hold_on_triangle;
  using Corners = FaceCorners;
  struct Seen {
    int candidate = -1, part = 0; // part: triangle of the candidate
    RayFoot foot;
  };
  using Pair = FaceAnchor; // in its first function
  using Map = FaceMap;

  /// Turns the corners so that the one with the smallest coordinates comes first.
  static FormPoints make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static std::vector<Map> make_maps(const ContactSurface& surface, const FormPoints& points);
  static Point3 normal(const Corners& x) { return face_normal(x); }
  static double stretch(const Corners& x, const Corners& from_corner, const ContactSurface& surface, int f);
  static bool faces(const CarriedFunction& gap, const Point3& normal) {
    return dot(gap.by_place, normal) < 0;
  }
  static bool within(const Seen& seen, double beyond) {
    return *std::min_element(seen.foot.part.begin(), seen.foot.part.end()) >= -beyond;
  }
  static double size_of(const Seen& /*seen*/, double secondary) { return secondary; }
  static const std::array<double, 4>& shares_of(const Seen& seen) { return seen.foot.weights; }
  static Pair pair_of(const ShapeValues& shape, const Seen* seen);
  static void start(const Corners& s, const Corners& p, const Map& map, Pair& pair) {
    pair.start = face_slips(s, p, map, pair, false).value;
  }
  static void add_slips(const Corners& s, const Corners& p, const Map& map, const Pair& pair,
                        bool with_gradient, Tangential& value, std::array<std::array<double, 24>, 2>& rows);
  static void add_slip_hessian(const Corners& s, const Corners& p, const Map& map, const Pair& pair,
                               const Tangential& factor, std::array<double, 576>& hessian) {
    add_face_slip_hessian(s, p, map, pair, {{{factor[0], factor[1]}}}, hessian);
  }
};
using FacePointForm = PointForm<FacePoints>;
/// Throws UserError(usage): a number of points out of range. Collective.
std::unique_ptr<ContactForm> make_face_point_form(const FormRequest& request);

} // namespace impact
