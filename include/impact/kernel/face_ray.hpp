#pragma once
#include <array>
#include <cmath>
#include <impact/element/facets.hpp>
#include <impact/kernel/mortar_face.hpp>

/// Contact of one point of a secondary face with one triangle of a primary face in space (theory.md,
/// contact). The gap is measured along the secondary face's own normal n, at the middle of a quadrilateral,
/// to the plane of the triangle,
///   g = (v_0 - x).m / (n.m),   m = (v_1 - v_0) x (v_2 - v_0),
/// so that every place of the secondary surface looks at one place of the primary, over its edges too. The
/// gap depends on the nodes of the two faces alone and does not change under rigid motions: forces that are
/// multiples of its gradient keep linear and angular momentum exactly. A quadrilateral primary is the four
/// triangles of mortar_face.hpp.
namespace impact {

/// A point of a secondary face, `shape` the weights of its corners, and a triangle of a primary face.
struct FaceRay {
  FaceCorners x;
  std::array<double, 4> shape;
  FaceCorners p;
  TriangleWeights triangle;
};

struct RayFoot {
  double gap = 0;                  ///< negative behind the triangle
  double opposition = 0;           ///< product of the two unit normals, -1 where they oppose
  std::array<double, 3> part{};    ///< of the triangle's corners in the foot, sum 1; negative beyond a side
  std::array<double, 3> normal{};  ///< of the triangle
  std::array<double, 4> weights{}; ///< of the primary face's corners in the foot
};

RayFoot cast_ray(const FaceRay& ray);

/// dg as a row over the dofs of (secondary corners 0 .. 3, primary corners 0 .. 3), x before y before z. Dofs
/// of a corner that a triangle repeats are zero.
std::array<double, 24> ray_gradient(const FaceRay& ray);

/// Adds factor d2g, 24 x 24 row by row, to `hessian`; symmetric and exact.
void add_ray_hessian(const FaceRay& ray, double factor, std::span<double> hessian);

/// The same between facets of second order, Line3 in the plane, Tri6, Quad8 and Quad9 in space
/// (element/facets.hpp): the
/// normal is that at the point, and the primary facet is met as it is, curved, beyond its sides as its
/// functions go on:
///   x + g n = y(xi)   (71c)
template <class Facet> struct CurvedRay {
  static constexpr std::size_t dim = Facet::dim + 1, nodes = Facet::nodes, dofs = 2 * dim * nodes;
  using Nodes = std::array<std::array<double, dim>, nodes>;
  Nodes x;
  FacetPlace<Facet> at; ///< the point
  Nodes p;
};

template <class Facet> struct CurvedFoot {
  double gap = 0, opposition = 1; ///< as of RayFoot
  /// Likewise; the parts of its corners.
  std::array<double, Facet::Corners::nodes> part{};
  std::array<double, Facet::dim + 1> normal{};
  typename Facet::Point xi{};
  FacetPlace<Facet> place; ///< on the primary facet, at xi
};

/// By Newton's method from a reference place of the primary facet; far from it, or where the method fails,
/// the parts are minus infinity.
template <class Facet>
CurvedFoot<Facet> cast_ray(const CurvedRay<Facet>& ray,
                           const typename Facet::Point& start = Facet::Corners::centroid());

/// dg and factor d2g over the dofs of (secondary nodes, primary nodes), of a ray with its foot.
template <class Facet>
std::array<double, CurvedRay<Facet>::dofs> ray_gradient(const CurvedRay<Facet>& ray,
                                                        const CurvedFoot<Facet>& foot);
template <class Facet>
void add_ray_hessian(const CurvedRay<Facet>& ray, const CurvedFoot<Facet>& foot, double factor,
                     std::span<double> hessian);

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
