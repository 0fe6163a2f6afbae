#pragma once
#include <impact/contact/point_form.hpp>

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

  /// Turns the corners so that the one with the smallest coordinates comes first.
  static FormPoints make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static void make_map(const ContactSurface& surface, int f, FaceMap& map);
  static Point3 normal(const Corners& x) { return facet_normal(x); }
  static double stretch(const Corners& x, const Corners& from_corner, const ContactSurface& surface, int f);
  static bool faces(const CarriedFunction& gap, const Point3& normal) {
    return dot(gap.by_place, normal) < 0;
  }
  static bool within(const Seen& seen, double beyond) {
    return *std::min_element(seen.foot.part.begin(), seen.foot.part.end()) >= -beyond;
  }
  static double size_of(const Seen& /*seen*/, double secondary) { return secondary; }
  static const std::array<double, 4>& shares_of(const Seen& seen) { return seen.foot.weights; }
  static std::array<double, 3> way_out(const Seen&, const Point3& n) { return {-n[0], -n[1], -n[2]}; }
};
using FacePointForm = PointForm<FacePoints>;
/// Throws UserError(usage): a number of points out of range. Collective.
std::unique_ptr<ContactForm> make_face_point_form(const FormRequest& request);

} // namespace impact
