#pragma once
#include <impact/contact/curved_sight.hpp>
#include <impact/contact/point_form.hpp>

/// Points that look along the normal of their own facet at what lies there on the primary surface (71c),
/// face_ray.hpp: those of faces of first order in space, those of edges and faces of second order.
namespace impact {

struct FacePoints : StraightPoints {
  static constexpr std::size_t dim = 3, nodes = 4;
  static constexpr HoldRule hold = hold_on_triangle;
  using View = FaceView;
  using Outline = FaceOutline;
  struct Seen {
    int candidate = -1;
    RayFoot<FaceRay> foot;
  };

  /// Turns the corners so that the one with the smallest coordinates comes first.
  static FormPoints<Point> make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static TangentRows<3, 4> tangents(const ContactSurface& surface, int f, const Point&);
  static Point3 normal(const FaceCorners& x) { return facet_normal(x); }
  static double size(const FaceCorners&, const FaceCorners& from_first, const Point&);
  static bool faces(const CarriedFunction& gap, const Point3& normal) {
    return dot(gap.by_place, normal) < 0;
  }
  static bool within(const Seen& seen, double beyond) {
    return *std::min_element(seen.foot.part.begin(), seen.foot.part.end()) >= -beyond;
  }
  static double size_of(const Seen& /*seen*/, double secondary) { return secondary; }
  static const std::array<double, 4>& shares_of(const Seen& seen) { return seen.foot.place.N; }
  /// The normal force over the pressure, per area.
  static double force_of(const Seen& seen) { return 1 / std::abs(seen.foot.opposition); }
  static std::array<double, 3> way_out(const Seen&, const Point3& n) { return {-n[0], -n[1], -n[2]}; }
};
using FacePointForm = PointForm<FacePoints>;

/// `Shape`: Line3, Tri6, Quad8 or Quad9 (element/facets.hpp).
template <class Shape> struct CurvedPoints {
  static constexpr std::size_t dim = Shape::dim + 1, nodes = Shape::nodes;
  static constexpr bool curved = true;
  static constexpr HoldRule hold = hold_on_triangle;
  /// As of StraightPoints: 5/4 of edges, 5/3 of triangles, 25/16 and 3 of squares with and without a middle
  /// node.
  static constexpr double weight_sum = 1.05 * (dim == 2 ? 1.25 : nodes == 6 ? 1.67 : nodes == 9 ? 1.5625 : 3);
  using Point = FacetPlace<Shape>;
  using Place = std::array<double, dim>;
  using Nodes = typename CurvedRay<Shape>::Nodes;
  using View = CurvedView<Place>;
  using Outline = CurvedOutline<Nodes>;
  struct Seen {
    int candidate = -1;
    RayFoot<CurvedRay<Shape>> foot;
  };

  /// Edges: 1 to 16 Gauss points along the cone of the facet; faces: those of a triangle or a square, whose
  /// corners are turned as of straight ones. Throws UserError(usage).
  static FormPoints<Point> make_points(ContactSurface& surface, const ContactSettings& settings, Frame frame);
  static const auto& weights(const Point& point) { return point.N; }
  /// The integral of a corner's function over a face is zero; those of the squares have the sum of the areas.
  static std::array<double, nodes> spread(const Point& point) {
    std::array<double, nodes> part;
    double sum = 0;
    for (std::size_t a = 0; a < nodes; ++a) sum += part[a] = point.N[a] * point.N[a];
    for (double& component : part) component /= sum;
    return part;
  }
  static Point node(std::size_t a) { return Point::at(place_of_node<Shape>(a)); }
  static TangentRows<dim, nodes> tangents(const ContactSurface& surface, int f, const Point& point);
  static Place normal(const Nodes& x, const Point& point) { return facet_normal<Shape>(x, point); }
  static double size(const Nodes&, const Nodes& from_first, const Point& point);
  static bool faces(const CarriedFunction& gap, const Place& normal) {
    double along = 0;
    for (std::size_t k = 0; k < dim; ++k) along += gap.by_place[k] * normal[k];
    return along < 0;
  }
  static bool within(const Seen& seen, double beyond) {
    return *std::min_element(seen.foot.part.begin(), seen.foot.part.end()) >= -beyond;
  }
  static double size_of(const Seen& /*seen*/, double secondary) { return secondary; }
  static const auto& shares_of(const Seen& seen) { return seen.foot.place.N; }
  static double force_of(const Seen& seen) { return 1 / std::abs(seen.foot.opposition); }
  static std::array<double, 3> way_out(const Seen&, const Place& n) {
    std::array<double, 3> out{};
    for (std::size_t k = 0; k < dim; ++k) out[k] = -n[k];
    return out;
  }
};

/// Of faces of first order, or of facets of second order. Throws UserError(usage): a number of points out of
/// range. Collective.
std::unique_ptr<ContactForm> make_ray_point_form(const FormRequest& request);

} // namespace impact
