#pragma once
#include <array>
#include <cmath>
#include <impact/element/facets.hpp>
#include <impact/kernel/mortar_face.hpp>

/// Contact of one point of a secondary facet with a primary facet (theory.md, contact). The gap is measured
/// along the secondary facet's own normal n to the primary facet as it is,
///   x + g n = y(xi)    (71c)
/// beyond its sides as its functions go on, so that every place of the secondary surface looks at one place
/// of the primary, over its edges too. The gap depends on the nodes of the two facets alone and does not
/// change under rigid motions: forces that are multiples of its gradient keep linear and angular momentum
/// exactly.
namespace impact {

/// Faces of first order in space, of three or four corners each. n is that of the middle of a quadrilateral.
struct FaceRay {
  static constexpr std::size_t dim = 3, nodes = 4, dofs = 24, sides = 4;
  using Point = Quad4::Point; ///< of a triangle too
  using Place = FacetPlace<Quad4>;
  static constexpr Point start() { return {}; }
  FaceCorners x;
  std::array<double, 4> shape; ///< weights of its corners in the point
  FaceCorners p;
};

/// Facets of second order, Line3 in the plane, Tri6, Quad8 and Quad9 in space (element/facets.hpp). n is that
/// at the point.
template <class Facet> struct CurvedRay {
  static constexpr std::size_t dim = Facet::dim + 1, nodes = Facet::nodes, dofs = 2 * dim * nodes,
                               sides = Facet::Corners::nodes;
  using Point = typename Facet::Point;
  using Place = FacetPlace<Facet>;
  static constexpr Point start() { return Facet::Corners::centroid(); }
  using Nodes = std::array<std::array<double, dim>, nodes>;
  Nodes x;
  FacetPlace<Facet> at; ///< the point
  Nodes p;
};

template <class Ray> struct RayFoot {
  double gap = 0;        ///< negative behind the facet
  double opposition = 1; ///< product of the two unit normals, -1 where they oppose
  /// Negative beyond a side. Of a curved facet and a triangle the parts of its corners; of a quadrilateral
  /// the ways to its sides, half its width each in the middle as one unit.
  std::array<double, Ray::sides> part{};
  std::array<double, Ray::dim> normal{}; ///< of the primary
  typename Ray::Point xi{};
  typename Ray::Place place{}; ///< on the primary facet, at xi
};

/// By Newton's method from a reference place of the primary facet; far from it, or where the method fails,
/// the parts are minus infinity.
template <class Ray> RayFoot<Ray> cast_ray(const Ray& ray, const typename Ray::Point& start = Ray::start());

/// dg as a row over the dofs of (secondary nodes, primary nodes), x before y before z, of a ray with its
/// foot. Dofs of a corner that a triangle repeats are zero.
template <class Ray> std::array<double, Ray::dofs> ray_gradient(const Ray& ray, const RayFoot<Ray>& foot);

/// Adds factor d2g, dofs x dofs row by row, to `hessian`; symmetric and exact.
template <class Ray>
void add_ray_hessian(const Ray& ray, const RayFoot<Ray>& foot, double factor, std::span<double> hessian);

/// n dA over the area of the reference facet, n outward, of a facet of second order at a place; n alone.
template <class Facet>
std::array<double, Facet::dim + 1> facet_area(const typename CurvedRay<Facet>::Nodes& x,
                                              const FacetPlace<Facet>& place);
template <class Facet>
std::array<double, Facet::dim + 1> facet_normal(const typename CurvedRay<Facet>::Nodes& x,
                                                const FacetPlace<Facet>& place) {
  std::array<double, Facet::dim + 1> n = facet_area<Facet>(x, place);
  double square = 0;
  for (double component : n) square += component * component;
  for (double& component : n) component /= std::sqrt(square);
  return n;
}

} // namespace impact
