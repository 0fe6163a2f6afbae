#include <algorithm>
#include <impact/kernel/contact_pair.hpp>
#include <limits>

namespace impact {

namespace {

// Cosine between the two outward normals above which a pair is none. It lies a little beyond the right angle
// so that the side of a square block that stands on a face is not accepted and refused in turn by rounding.
constexpr double facing_limit = 0.2;

void add_product(double factor, const std::array<double, 8>& a, const std::array<double, 8>& b,
                 std::array<double, 64>& sum) {
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j) sum[8 * i + j] += factor * a[i] * b[j];
}

// The row of (dx_s - dx_foot) . w.
std::array<double, 8> relative_motion(const std::array<double, 2>& N, double xi, const Point2<double>& w) {
  Foot<double> along;
  along.xi = xi;
  along.normal = w;
  return gap_gradient(N, along);
}

} // namespace

std::array<double, 64> gap_hessian(const std::array<double, 2>& N, const PrimaryEdge<double>& edge,
                                   const Foot<double>& foot) {
  std::array<double, 64> d2g{};
  if (foot.part == FootPart::edge) {
    const Point2<double> a = {(edge.x1[0] - edge.x0[0]) / 2, (edge.x1[1] - edge.x0[1]) / 2};
    const double m = detail::dot(a, a);
    std::array<double, 8> v_xi = relative_motion(N, foot.xi, a);
    std::array<double, 8> v_d{};
    for (std::size_t k = 0; k < 2; ++k) {
      v_d[4 + k] = -foot.normal[k] / 2;
      v_d[6 + k] = foot.normal[k] / 2;
    }
    for (std::size_t i = 0; i < 8; ++i) v_xi[i] = (v_xi[i] + foot.gap * v_d[i]) / m;
    add_product(-1, v_d, v_xi, d2g);
    add_product(-1, v_xi, v_d, d2g);
    add_product(foot.gap / m, v_d, v_d, d2g);
  } else if (foot.part != FootPart::none) {
    const std::array<double, 8> v_t = relative_motion(N, foot.xi, {-foot.normal[1], foot.normal[0]});
    add_product(1 / foot.gap, v_t, v_t, d2g);
  }
  return d2g;
}

double retraction(const Foot<double>& foot, const Point2<double>& point_normal, double reach) {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (foot.part == FootPart::none || !(std::abs(foot.gap) <= reach)) return none;
  const double cosine = detail::dot(foot.normal, point_normal);
  if (!(cosine <= facing_limit)) return none;
  return foot.gap >= 0 ? foot.gap : -foot.gap / std::clamp(-2 * cosine, 1e-3, 1.0);
}

} // namespace impact
