#pragma once
#include <array>
#include <cmath>
#include <complex>

/// Frictionless contact of one secondary point with one straight primary edge in the plane: foot point, gap
/// (open positive), its exact first and second variation, and from them the force and tangent of the
/// potential (p^2 - lambda^2) / (2 eps) with p = <lambda - eps g> (theory.md, contact). In reference area
/// weights the force is -p dg and the tangent eps H(p) dg dg - p d2g. Where the foot leaves the edge it
/// stands on a vertex and the normal turns to the direction of the point seen from it, so that the distance
/// stays continuous along a chain of edges.
namespace impact {

template <class T> using Point2 = std::array<T, 2>;

namespace detail {
inline double real_part(double x) { return x; }
inline double real_part(const std::complex<double>& x) { return x.real(); }
template <class T> T dot(const Point2<T>& a, const Point2<T>& b) { return a[0] * b[0] + a[1] * b[1]; }
template <class T> Point2<T> minus(const Point2<T>& a, const Point2<T>& b) {
  return {a[0] - b[0], a[1] - b[1]};
}
/// Unit normal to the right of the way from a to b.
template <class T> Point2<T> right_normal(const Point2<T>& a, const Point2<T>& b) {
  using std::sqrt;
  const Point2<T> t = minus(b, a);
  const T length = sqrt(dot(t, t));
  return {t[1] / length, -t[0] / length};
}
} // namespace detail

/// A primary edge in the current configuration; its body lies to the left of the way from x0 to x1, so that
/// the outward normal is (t_y, -t_x). `previous` and `next` are the far nodes of the neighbouring edges of
/// the surface.
template <class T> struct PrimaryEdge {
  Point2<T> x0, x1;
  bool has_previous = false, has_next = false;
  Point2<T> previous{}, next{};
};

enum class FootPart {
  edge,          ///< between the two nodes
  first_vertex,  ///< at x0
  second_vertex, ///< at x1
  none           ///< beyond an end of the whole surface, or nearer to the neighbouring edge
};

template <class T> struct Foot {
  FootPart part = FootPart::none;
  T gap{};            ///< signed distance, negative inside the primary body
  T xi{};             ///< place on the edge, -1 at x0, 1 at x1
  Point2<T> normal{}; ///< unit vector along which the gap grows
};

/// An open end of a surface is continued straight by this part of half an edge before contact ends.
inline constexpr double end_margin = 0.02;

/// Foot, gap and normal on the straight line through the edge, without regard to its ends.
template <class T> Foot<T> foot_on_line(const Point2<T>& x, const PrimaryEdge<T>& edge) {
  using detail::dot;
  const Point2<T> a = {(edge.x1[0] - edge.x0[0]) / 2.0, (edge.x1[1] - edge.x0[1]) / 2.0};
  const Point2<T> centre = {(edge.x1[0] + edge.x0[0]) / 2.0, (edge.x1[1] + edge.x0[1]) / 2.0};
  const Point2<T> d = detail::minus(x, centre);
  Foot<T> foot;
  foot.xi = dot(d, a) / dot(a, a);
  foot.normal = detail::right_normal(edge.x0, edge.x1);
  foot.gap = dot(d, foot.normal);
  foot.part = FootPart::edge;
  return foot;
}

/// The nearest point of the surface when it lies on this edge. At a vertex the sign of the distance is that
/// of the sum of the two edges' normals, which is right for convex and concave corners of any angle.
template <class T> Foot<T> closest_point(const Point2<T>& x, const PrimaryEdge<T>& edge) {
  using detail::dot, detail::minus, detail::real_part;
  using std::sqrt;
  const Point2<T> a = {(edge.x1[0] - edge.x0[0]) / 2.0, (edge.x1[1] - edge.x0[1]) / 2.0};
  Foot<T> foot = foot_on_line(x, edge);
  const double xi = real_part(foot.xi);
  if (std::abs(xi) <= 1) return foot;

  const bool first = xi < 0;
  if (!(first ? edge.has_previous : edge.has_next)) {
    if (!(std::abs(xi) <= 1 + end_margin)) foot.part = FootPart::none;
    return foot;
  }
  const Point2<T> v = first ? edge.x0 : edge.x1;
  const Point2<T> r = minus(x, v);
  const T distance = sqrt(dot(r, r));
  // On the vertex itself the direction is lost; the edge's own normal is as good and keeps everything finite.
  if (!(real_part(distance) > 1e-9 * std::sqrt(real_part(dot(a, a))))) return foot;
  const Point2<T> neighbour = minus(first ? edge.previous : edge.next, v);
  // The small number lets both edges claim a point on the border between them, so that rounding cannot lose
  // it.
  if (real_part(dot(r, neighbour)) > 1e-12 * real_part(dot(neighbour, neighbour))) {
    foot.part = FootPart::none;
    return foot;
  }
  const Point2<T> other =
      first ? detail::right_normal(edge.previous, edge.x0) : detail::right_normal(edge.x1, edge.next);
  const double side = real_part(dot(r, foot.normal) + dot(r, other)) < 0 ? -1 : 1;
  foot.part = first ? FootPart::first_vertex : FootPart::second_vertex;
  foot.xi = T(first ? -1.0 : 1.0);
  foot.gap = side * distance;
  foot.normal = {r[0] / foot.gap, r[1] / foot.gap};
  return foot;
}

/// dg as a row over the dofs of (secondary node 0, 1, primary node 0, 1), x before y. `N`: the secondary
/// shape functions at the point. Valid on edges and vertices alike, because the foot is a stationary point of
/// the distance.
template <class T> std::array<T, 8> gap_gradient(const std::array<double, 2>& N, const Foot<T>& foot) {
  const T M0 = (1.0 - foot.xi) / 2.0, M1 = (1.0 + foot.xi) / 2.0;
  std::array<T, 8> dg;
  for (std::size_t k = 0; k < 2; ++k) {
    dg[k] = N[0] * foot.normal[k];
    dg[2 + k] = N[1] * foot.normal[k];
    dg[4 + k] = -M0 * foot.normal[k];
    dg[6 + k] = -M1 * foot.normal[k];
  }
  return dg;
}

/// Second variation of the gap, 8 x 8 row by row in the order of gap_gradient; symmetric and exact.
std::array<double, 64> gap_hessian(const std::array<double, 2>& N, const PrimaryEdge<double>& edge,
                                   const Foot<double>& foot);

/// Nominal pressure p = <lambda - eps g> (75').
inline double contact_pressure(double lambda, double eps, double gap) {
  const double p = lambda - eps * gap;
  return p > 0 ? p : 0;
}

/// Potential of the pressure per reference area, (p^2 - lambda^2) / (2 eps): its derivative by the gap is -p.
inline double contact_potential(double lambda, double eps, double gap) {
  const double p = contact_pressure(lambda, eps, gap);
  return (p * p - lambda * lambda) / (2 * eps);
}

/// Pressure of a penalty whose work over a step is exact (T. A. Laursen, V. Chawla, Int. J. Numer. Meth.
/// Engng. 40 (1997)): p = -(psi(g1) - psi(g0)) / (g1 - g0), psi = eps <-g>^2 / 2.
struct SecantPressure {
  double p = 0;
  double slope = 0; ///< dp/dg1 <= 0
};
inline SecantPressure secant_pressure(double eps, double g0, double g1) {
  if (g0 < 0 && g1 < 0) return {-eps * (g0 + g1) / 2, -eps / 2};
  if (g1 < 0) { // closes: g0 >= 0
    const double d = g0 - g1;
    return {eps * g1 * g1 / (2 * d), eps * g1 * (2 * g0 - g1) / (2 * d * d)};
  }
  if (g0 < 0) { // opens: g1 >= 0
    const double d = g1 - g0;
    return {eps * g0 * g0 / (2 * d), -eps * g0 * g0 / (2 * d * d)};
  }
  return {};
}

/// How far the point must move back along its own normal to be free, or its distance when it is open: the
/// primary edge with the smallest value is the one that the point faces. Infinite when the pair is none: past
/// an end, farther or deeper than `reach`, or with the point's own normal turned the same way as the
/// primary's (the back of a thin body). Depths count by the plain distance up to 60 degrees between the
/// surfaces, so that the choice between the edges of a curved surface is continuous; steeper ones count more,
/// so that a deep point near a corner leaves through the face it came by.
double retraction(const Foot<double>& foot, const Point2<double>& point_normal, double reach);

} // namespace impact
