#include <impact/kernel/mortar_segment.hpp>

namespace impact {

namespace {

// The weighted gaps with the dofs of the pair as independent variables, made by seed_of(value, number).
template <class T, class Seed>
std::array<T, 2> seeded_gaps(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                             Seed&& seed_of) {
  std::array<Point2<T>, 2> X, P;
  for (std::size_t node = 0; node < 2; ++node)
    for (std::size_t k = 0; k < 2; ++k) {
      X[node][k] = seed_of(x[node][k], static_cast<int>(2 * node + k));
      P[node][k] = seed_of(p[node][k], static_cast<int>(4 + 2 * node + k));
    }
  return weighted_gaps(covered_part(X, P), edge);
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

Point3 facet_normal(const EdgeCorners& x) {
  const Point2<double> n = detail::right_normal(x[0], x[1]);
  return {n[0], n[1], 0};
}

FacetView view_facet(const EdgeCorners& x, const EdgeCorners& p) {
  const CoveredPart<double> part = covered_part(x, p);
  const double mean = (part.gap_begin + part.gap_end) / 2;
  if (part.end > part.begin)
    return {(part.end - part.begin) / 2, std::min(part.gap_begin, part.gap_end),
            std::max(part.gap_begin, part.gap_end), mean};
  const double end = part.end < -1 ? part.gap_end : part.gap_begin;
  return {0, end, end, mean};
}

double common_part(const EdgeCorners& x, const EdgeCorners& a, const EdgeCorners& b) {
  const CoveredPart<double> first = covered_part(x, a), second = covered_part(x, b);
  return std::min(first.end, second.end) - std::max(first.begin, second.begin);
}

bool corner_gap(const EdgeCorners& x, int corner, const EdgeCorners& p, double& gap) {
  const CoveredPart<double> part = covered_part(x, p);
  gap = corner == 0 ? part.gap_begin : part.gap_end;
  return part.end > part.begin && (corner == 0 ? part.begin <= -1 : part.end >= 1);
}

MortarPair mortar_pair(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                       bool with_gradient) {
  MortarPair pair;
  CoveredPart<double> part = covered_part(x, p);
  pair.covered = pair.touched = part.end > part.begin;
  if (!pair.covered) return pair;
  const std::array<double, 2> gap = weighted_gaps(part, edge);
  part.gap_begin = part.gap_end = 1;
  const std::array<double, 2> cover = weighted_gaps(part, edge);
  std::copy(gap.begin(), gap.end(), pair.gap.begin());
  std::copy(cover.begin(), cover.end(), pair.cover.begin());
  if (!with_gradient) return pair;
  const auto G = seeded_gaps<Dual<double, 8>>(x, p, edge, seed<double, 8>);
  for (std::size_t a = 0; a < 2; ++a) std::copy_n(G[a].d, 8, pair.gradient[a].begin());
  return pair;
}

bool add_mortar_hessian(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                        const std::array<double, 4>& factor, std::span<double> hessian) {
  if (const CoveredPart<double> part = covered_part(x, p); !(part.end > part.begin)) return false;
  using D = Dual<double, 8>;
  const auto G = seeded_gaps<Dual<D, 8>>(x, p, edge, [](double v, int i) {
    Dual<D, 8> y(seed<double, 8>(v, i));
    y.d[i] = D(1.0);
    return y;
  });
  for (std::size_t i = 0; i < 8; ++i)
    for (std::size_t j = 0; j < 8; ++j)
      hessian[8 * i + j] += factor[0] * G[0].d[i].d[j] + factor[1] * G[1].d[i].d[j];
  return true;
}

void visit_covered(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge,
                   const PieceVisitor& visitor) {
  const CoveredPart<double> part = covered_part(x, p);
  if (!(part.end > part.begin)) return;
  const Point2<double> t = detail::minus(x[1], x[0]);
  // Place on the secondary edge of the primary's nodes: the primary's coordinate is linear in it.
  const auto place = [&](const Point2<double>& y) {
    return 2 * detail::dot(detail::minus(y, x[0]), t) / detail::dot(t, t) - 1;
  };
  const double at0 = place(p[0]), at1 = place(p[1]);
  CoveredPiece piece;
  piece.area = edge.length / 2 * (part.end - part.begin);
  piece.normal = facet_normal(x);
  for (std::size_t v = 0; v < 2; ++v) {
    const double xi = v == 0 ? part.begin : part.end, on_primary = (xi - at0) / (at1 - at0);
    const std::array<double, 2> N = {(1 - xi) / 2, (1 + xi) / 2};
    std::copy(N.begin(), N.end(), piece.secondary[v].begin());
    piece.primary[v] = {1 - on_primary, on_primary, 0, 0};
    piece.ring[v] = edge.ring[0] * N[0] + edge.ring[1] * N[1];
    for (std::size_t a = 0; a < 2; ++a) piece.phi[v][a] = edge.phi[a][0] * N[0] + edge.phi[a][1] * N[1];
  }
  visitor(piece);
}

MortarWeights mortar_weights(const EdgeCorners& x, const EdgeCorners& p, const MortarEdge& edge) {
  MortarWeights w;
  visit_covered(x, p, edge, [&](const CoveredPiece& piece) {
    w.covered = true;
    for (const double s : {-0.57735026918962576, 0.57735026918962576}) {
      const std::array<double, 2> at = {(1 - s) / 2, (1 + s) / 2};
      const auto here = [&](const TriangleWeights& of, std::size_t b) {
        return at[0] * of[0][b] + at[1] * of[1][b];
      };
      const double weight = piece.area / 2 * (at[0] * piece.ring[0] + at[1] * piece.ring[1]);
      for (std::size_t a = 0; a < 2; ++a)
        for (std::size_t b = 0; b < 2; ++b) {
          w.D[a][b] += weight * here(piece.phi, a) * here(piece.secondary, b);
          w.M[a][b] += weight * here(piece.phi, a) * here(piece.primary, b);
        }
    }
  });
  return w;
}

} // namespace impact
