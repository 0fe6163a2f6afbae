#include <impact/kernel/contact_slip.hpp>

namespace impact {

namespace {

using detail::dot;

// Rows of the opening vector and of the edge vector e = x_1 - x_0 are multiples of the node's unit rows.
constexpr std::array<double, 4> edge_rows = {-1, 1, 0, 0};
std::array<double, 4> opening_rows(const SlipAnchor& anchor) {
  return {anchor.c[0], anchor.c[1], -anchor.m[0], -anchor.m[1]};
}

struct Geometry {
  double length = 0, along = 0, across = 0; // of the edge; of the opening vector along t and n
  Point2<double> t{}, n{};
};

Geometry geometry(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p,
                  const SlipAnchor& anchor) {
  Geometry g;
  const Point2<double> e = detail::minus(x[1], x[0]);
  g.length = std::sqrt(dot(e, e));
  g.t = {e[0] / g.length, e[1] / g.length};
  g.n = {g.t[1], -g.t[0]};
  // Both coefficients add to the same number: taken from a node, rounding is that of the distances.
  Point2<double> v{};
  for (std::size_t k = 0; k < 2; ++k)
    v[k] = anchor.c[1] * e[k] - anchor.m[0] * (p[0][k] - x[0][k]) - anchor.m[1] * (p[1][k] - x[0][k]);
  g.along = dot(g.t, v);
  g.across = dot(g.n, v);
  return g;
}

} // namespace

Slip slip_of(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p,
             const SlipAnchor& anchor) {
  // ds = t.dv + (n.v)(n.de)/L, since dt = n (n.de)/L.
  const Geometry g = geometry(x, p, anchor);
  const std::array<double, 4> v = opening_rows(anchor);
  Slip slip;
  slip.value = g.along;
  for (std::size_t node = 0; node < 4; ++node)
    for (std::size_t k = 0; k < 2; ++k)
      slip.gradient[2 * node + k] = v[node] * g.t[k] + g.across / g.length * edge_rows[node] * g.n[k];
  return slip;
}

std::array<double, 64> slip_hessian(const std::array<Point2<double>, 2>& x,
                                    const std::array<Point2<double>, 2>& p, const SlipAnchor& anchor) {
  // With a = n.de, b = t.de: da = -(t.de)(n.de)/L, d(n.v) = n.dv - (t.v) a/L, dL = b, so that
  // d2s = (n.dv (x) a + a (x) n.dv)/L - (t.v)/L^2 a (x) a - (n.v)/L^2 (a (x) b + b (x) a).
  const Geometry g = geometry(x, p, anchor);
  const std::array<double, 4> v = opening_rows(anchor);
  std::array<double, 8> a{}, b{}, dv{};
  for (std::size_t node = 0; node < 4; ++node)
    for (std::size_t k = 0; k < 2; ++k) {
      a[2 * node + k] = edge_rows[node] * g.n[k];
      b[2 * node + k] = edge_rows[node] * g.t[k];
      dv[2 * node + k] = v[node] * g.n[k];
    }
  std::array<double, 64> H{};
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j)
      H[8 * i + j] = (dv[i] * a[j] + a[i] * dv[j]) / g.length -
                     (g.along * a[i] * a[j] + g.across * (a[i] * b[j] + b[i] * a[j])) / (g.length * g.length);
  return H;
}

} // namespace impact
