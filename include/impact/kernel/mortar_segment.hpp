#pragma once
#include <algorithm>
#include <array>
#include <impact/kernel/contact_pair.hpp>
#include <impact/kernel/mortar_face.hpp>
#include <impact/math/dual.hpp>

/// Mortar contact of one secondary edge with one primary edge in the plane (theory.md, contact). The primary
/// edge is projected along the secondary edge's own normal; on the part of the secondary edge that it covers
/// the gap is linear, so that the weighted gaps
///   G_a = int Phi_a g dA_0,   a = 0, 1
/// have a closed form. They depend on the four nodes alone and do not change under rigid motions: forces that
/// are multiples of their gradients keep linear and angular momentum exactly. Neighbouring primary edges
/// share the end of their parts and the gap there, so that sliding from one to the next is smooth.
namespace impact {

using EdgeCorners = std::array<Point2<double>, 2>;

/// A secondary edge in the reference configuration: Phi_a = sum_b phi[a][b] N_b over dA_0, with
/// dA_0 = ring dS_0 and ring = sum_b ring[b] N_b: 1 in the plane, 2 pi R with an axis.
struct MortarEdge {
  double length = 0;
  std::array<double, 2> ring = {1, 1};
  std::array<std::array<double, 2>, 2> phi = {{{1, 0}, {0, 1}}};
};

/// Coefficients of the functions biorthogonal to N_b over the whole edge: int Phi_a N_b = delta_ab int N_b.
std::array<std::array<double, 2>, 2> dual_functions(const MortarEdge& edge);

namespace detail {
template <class B, int n> double real_part(const Dual<B, n>& x) { return real_part(x.v); }
} // namespace detail

/// The part of the secondary edge that a primary edge covers, in [-1, 1] from x0 to x1, and the gap at its
/// ends; empty when `end <= begin`.
template <class T> struct CoveredPart {
  T begin{}, end{};
  T gap_begin{}, gap_end{};
};

/// `x`: secondary nodes, `p`: primary nodes, both with their body to the left. Gap: distance from the
/// secondary to the primary along the secondary's outward normal, negative where they overlap.
template <class T>
CoveredPart<T> covered_part(const std::array<Point2<T>, 2>& x, const std::array<Point2<T>, 2>& p) {
  using detail::dot, detail::minus, detail::real_part;
  const Point2<T> t = minus(x[1], x[0]);
  const T square = dot(t, t);
  const Point2<T> n = detail::right_normal(x[0], x[1]);
  // The primary runs against the secondary: its second node comes first.
  const Point2<T> d0 = minus(p[1], x[0]), d1 = minus(p[0], x[0]);
  const T xi0 = 2.0 * dot(d0, t) / square - T(1.0), xi1 = 2.0 * dot(d1, t) / square - T(1.0);
  const T g0 = dot(d0, n), g1 = dot(d1, n);
  CoveredPart<T> part{xi0, xi1, g0, g1};
  if (!(real_part(xi1) > real_part(xi0))) return {T(0.0), T(0.0), T(0.0), T(0.0)};
  const T slope = (g1 - g0) / (xi1 - xi0);
  if (real_part(xi0) < -1) {
    part.begin = T(-1.0);
    part.gap_begin = g0 + slope * (T(-1.0) - xi0);
  }
  if (real_part(xi1) > 1) {
    part.end = T(1.0);
    part.gap_end = g1 + slope * (T(1.0) - xi1);
  }
  return part;
}

/// G_a of the part. Two Gauss points are exact: the integrand is of degree three at most.
template <class T> std::array<T, 2> weighted_gaps(const CoveredPart<T>& part, const MortarEdge& edge) {
  std::array<T, 2> G{T(0.0), T(0.0)};
  const T half = 0.5 * (part.end - part.begin);
  for (const double s : {-0.57735026918962576, 0.57735026918962576}) {
    const double at_begin = (1 - s) / 2, at_end = (1 + s) / 2;
    const T xi = at_begin * part.begin + at_end * part.end;
    const T gap = at_begin * part.gap_begin + at_end * part.gap_end;
    const T N0 = 0.5 * (T(1.0) - xi), N1 = 0.5 * (T(1.0) + xi);
    const T weighted = (0.5 * edge.length) * (half * (edge.ring[0] * N0 + edge.ring[1] * N1) * gap);
    for (std::size_t a = 0; a < 2; ++a) G[a] += weighted * (edge.phi[a][0] * N0 + edge.phi[a][1] * N1);
  }
  return G;
}

/// What mortar_face.hpp says of two faces, of two edges; the common part in halves of the edge, and a gap at
/// an end of the edge where the primary edge reaches it. A hessian is 8 x 8.
Point3 facet_normal(const EdgeCorners& x);
FacetView view_facet(const EdgeCorners& x, const EdgeCorners& p);
double common_part(const EdgeCorners& x, const EdgeCorners& a, const EdgeCorners& b);
bool corner_gap(const EdgeCorners& x, int corner, const EdgeCorners& p, double& gap);
MortarPair mortar_pair(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                       bool with_gradient);
bool add_mortar_hessian(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                        const std::array<double, 4>& factor, std::span<double> hessian);
MortarWeights mortar_weights(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge);
void visit_covered(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                   const PieceVisitor& visitor);

} // namespace impact
