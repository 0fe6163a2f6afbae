#include <impact/kernel/mortar_segment.hpp>

namespace impact {

namespace {

// The dofs of the pair as independent variables of type T.
template <class T, class Seed>
void seeded(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p, Seed&& seed_of,
            std::array<Point2<T>, 2>& X, std::array<Point2<T>, 2>& P) {
  for (std::size_t node = 0; node < 2; ++node)
    for (std::size_t k = 0; k < 2; ++k) {
      X[node][k] = seed_of(x[node][k], static_cast<int>(2 * node + k));
      P[node][k] = seed_of(p[node][k], static_cast<int>(4 + 2 * node + k));
    }
}

bool covers(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p) {
  const CoveredPart<double> part = covered_part(x, p);
  return part.end > part.begin;
}

} // namespace

std::array<std::array<double, 2>, 2> dual_functions(const MortarEdge& edge) {
  // phi = diag(int N_a) (int N_a N_b)^-1
  const double r0 = edge.ring[0], r1 = edge.ring[1];
  const double m00 = (3 * r0 + r1) / 12, m11 = (r0 + 3 * r1) / 12, m01 = (r0 + r1) / 12;
  const double det = m00 * m11 - m01 * m01;
  const double d0 = m00 + m01, d1 = m01 + m11;
  return {{{d0 * m11 / det, -d0 * m01 / det}, {-d1 * m01 / det, d1 * m00 / det}}};
}

MortarPair mortar_pair(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p,
                       const MortarEdge& edge) {
  MortarPair pair;
  if (!covers(x, p)) return pair;
  pair.covered = true;
  using D = Dual<double, 8>;
  std::array<Point2<D>, 2> X, P;
  seeded<D>(
      x, p, [](double v, int i) { return seed<double, 8>(v, i); }, X, P);
  const std::array<D, 2> G = weighted_gaps(covered_part(X, P), edge);
  for (std::size_t a = 0; a < 2; ++a) {
    pair.gap[a] = G[a].v;
    for (std::size_t i = 0; i < 8; ++i) pair.gradient[a][i] = G[a].d[i];
  }
  return pair;
}

std::array<double, 64> mortar_pair_hessian(const std::array<Point2<double>, 2>& x,
                                           const std::array<Point2<double>, 2>& p, const MortarEdge& edge,
                                           const std::array<double, 2>& factor) {
  std::array<double, 64> H{};
  if (!covers(x, p)) return H;
  using D = Dual<double, 8>;
  using DD = Dual<D, 8>;
  std::array<Point2<DD>, 2> X, P;
  seeded<DD>(
      x, p,
      [](double v, int i) {
        DD y(seed<double, 8>(v, i));
        y.d[i] = D(1.0);
        return y;
      },
      X, P);
  const std::array<DD, 2> G = weighted_gaps(covered_part(X, P), edge);
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j)
      H[8 * i + j] = factor[0] * G[0].d[i].d[j] + factor[1] * G[1].d[i].d[j];
  return H;
}

MortarWeights mortar_weights(const std::array<Point2<double>, 2>& x, const std::array<Point2<double>, 2>& p,
                             const MortarEdge& edge) {
  MortarWeights w;
  const CoveredPart<double> part = covered_part(x, p);
  if (!(part.end > part.begin)) return w;
  const Point2<double> t = detail::minus(x[1], x[0]);
  const double square = detail::dot(t, t);
  // Place on the secondary edge of the primary's nodes: the primary's coordinate is linear in it.
  const auto place = [&](const Point2<double>& y) {
    return 2 * detail::dot(detail::minus(y, x[0]), t) / square - 1;
  };
  const double at0 = place(p[0]), at1 = place(p[1]);
  for (const double s : {-0.57735026918962576, 0.57735026918962576}) {
    const double xi = (part.begin + part.end) / 2 + s * (part.end - part.begin) / 2;
    const std::array<double, 2> N = {(1 - xi) / 2, (1 + xi) / 2};
    const double weight =
        edge.length / 4 * (part.end - part.begin) * (edge.ring[0] * N[0] + edge.ring[1] * N[1]);
    const double on_primary = (xi - at0) / (at1 - at0);
    const std::array<double, 2> Np = {1 - on_primary, on_primary};
    for (std::size_t a = 0; a < 2; ++a) {
      const double f = edge.phi[a][0] * N[0] + edge.phi[a][1] * N[1];
      for (std::size_t b = 0; b < 2; ++b) {
        w.D[a][b] += weight * f * N[b];
        w.M[a][b] += weight * f * Np[b];
      }
    }
  }
  return w;
}

} // namespace impact
