#include <algorithm>
#include <cmath>
#include <impact/kernel/face_slip.hpp>
#include <impact/math/dual.hpp>
#include <impact/math/vector3.hpp>

namespace impact {

namespace {

// The rotation of (g_1 g_2) = R U. With J = |g_1 x g_2| and n across both, U is ((g_1 g_2)^T (g_1 g_2) +
// J)/s, s^2 = |g_1|^2 + |g_2|^2 + 2 J, from which r_1 = (g_1 + g_2 x n)/s, r_2 = n x r_1.
template <class T> std::array<Vector3Of<T>, 2> rotation_of(const Vector3Of<T>& g1, const Vector3Of<T>& g2) {
  using std::sqrt;
  Vector3Of<T> n = cross(g1, g2);
  const T J = sqrt(dot(n, n)), inverse_J = T(1.0) / J;
  for (T& component : n) component *= inverse_J;
  const T inverse_s = T(1.0) / sqrt(dot(g1, g1) + dot(g2, g2) + 2.0 * J);
  Vector3Of<T> r1 = cross(g2, n);
  for (std::size_t k = 0; k < 3; ++k) r1[k] = (g1[k] + r1[k]) * inverse_s;
  return {r1, cross(n, r1)};
}

constexpr int variables = 6; // g_1, g_2
using First = Dual<double, variables>;
using Second = Dual<First, variables>;

template <class T, class Seed>
std::array<Vector3Of<T>, 2> seeded_rotation(const std::array<Point3, 2>& g, Seed&& seed_of) {
  std::array<Vector3Of<T>, 2> y;
  for (std::size_t i = 0; i < variables; ++i) y[i / 3][i % 3] = seed_of(g[i / 3][i % 3], static_cast<int>(i));
  return rotation_of(y[0], y[1]);
}

std::array<Vector3Of<First>, 2> rotation_with_gradient(const std::array<Point3, 2>& g) {
  return seeded_rotation<First>(g, [](double v, int i) { return seed<double, variables>(v, i); });
}

// Both sums are differences from the first corner: their weights add to zero, and rounding is that of
// distances.
std::array<Point3, 2> plane_of(const FaceMap& map, const FaceCorners& x) {
  std::array<Point3, 2> g{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t a = 1; a < 4; ++a)
      for (std::size_t k = 0; k < 3; ++k) g[i][k] += map.row[i][a] * (x[a][k] - x[0][k]);
  return g;
}

Point3 opening(const FaceCorners& x, const FaceCorners& p, const MortarWeights& w, std::size_t a) {
  Point3 v{};
  for (std::size_t b = 0; b < 4; ++b)
    for (std::size_t k = 0; k < 3; ++k)
      v[k] += w.D[a][b] * (x[b][k] - x[0][k]) - w.M[a][b] * (p[b][k] - x[0][k]);
  return v;
}

SlipAnchor edge_anchor(const FacetAnchor& anchor, std::size_t a) {
  const auto &D = anchor.weights.D[a], &M = anchor.weights.M[a];
  return {{D[0], D[1]}, {M[0], M[1]}};
}

} // namespace

FaceMap make_face_map(const FaceCorners& X) {
  // Derivatives of the shape functions at the middle, whose differences of corners are natural directions.
  const std::array<std::array<double, 4>, 2> natural =
      corners_of(X) == 3
          ? std::array<std::array<double, 4>, 2>{{{-1, 1, 0, 0}, {-1, 0, 1, 0}}}
          : std::array<std::array<double, 4>, 2>{{{-0.25, 0.25, 0.25, -0.25}, {-0.25, -0.25, 0.25, 0.25}}};
  std::array<Point3, 2> G{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t k = 0; k < 3; ++k) G[i][k] += natural[i][a] * X[a][k];
  FaceMap map;
  map.normal = unit(cross(G[0], G[1]));
  map.axis[0] = unit(G[0]);
  map.axis[1] = cross(map.normal, map.axis[0]);
  const double a = dot(G[0], map.axis[0]), b = dot(G[1], map.axis[0]), d = dot(G[1], map.axis[1]);
  for (std::size_t corner = 0; corner < 4; ++corner) { // G = axes ((a b), (0 d))
    map.row[0][corner] = natural[0][corner] / a;
    map.row[1][corner] = (natural[1][corner] - b / a * natural[0][corner]) / d;
  }
  return map;
}

std::array<Point3, 2> tangents_of(const Point3& n) {
  // An odd bound, which the normals of usual bodies are not on: rounding must not choose.
  const std::size_t axis = std::abs(n[0]) < 0.8137 ? 0 : 1;
  Point3 t{};
  for (std::size_t k = 0; k < 3; ++k) t[k] = (k == axis ? 1 : 0) - n[axis] * n[k];
  t = unit(t);
  return {t, cross(n, t)};
}

std::array<std::array<double, 2>, 2> turned_into(const FaceMap& face, const Point3& n,
                                                 const std::array<Point3, 2>& t) {
  // Q t = t + w x t + w x (w x t)/(1 + n.m), w = n x m; of t at right angles to n this is
  // t - (m.t)/(1 + n.m) (n + m).
  const double fold = std::max(1 + dot(n, face.normal), 1e-6); // of opposite normals every way is as short
  std::array<std::array<double, 2>, 2> turn{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j)
      turn[i][j] = dot(t[i], face.axis[j]) - dot(face.normal, t[i]) / fold * dot(n, face.axis[j]);
  return turn;
}

FacetSlips facet_slips(const FaceCorners& x, const FaceCorners& p, const FaceMap& map,
                       const FacetAnchor& anchor, bool with_gradient) {
  FacetSlips slips;
  const std::array<Point3, 2> g = plane_of(map, x);
  const MortarWeights& w = anchor.weights;
  if (!with_gradient) {
    const std::array<Point3, 2> r = rotation_of(g[0], g[1]);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t i = 0; i < 2; ++i)
        slips.value[a][i] = dot(r[i], opening(x, p, w, a)) - anchor.start[a][i];
    return slips;
  }
  const std::array<Vector3Of<First>, 2> r = rotation_with_gradient(g);
  for (std::size_t a = 0; a < 4; ++a) {
    const Point3 v = opening(x, p, w, a);
    for (std::size_t i = 0; i < 2; ++i) {
      slips.value[a][i] = r[i][0].v * v[0] + r[i][1].v * v[1] + r[i][2].v * v[2] - anchor.start[a][i];
      for (std::size_t k = 0; k < 3; ++k) {
        std::array<double, 2> turn{}; // of the direction, by g_1 and g_2
        for (std::size_t j = 0; j < 2; ++j)
          for (std::size_t m = 0; m < 3; ++m) turn[j] += v[m] * r[i][m].d[3 * j + k];
        for (std::size_t b = 0; b < 4; ++b) {
          slips.gradient[a][i][3 * b + k] =
              w.D[a][b] * r[i][k].v + map.row[0][b] * turn[0] + map.row[1][b] * turn[1];
          slips.gradient[a][i][12 + 3 * b + k] = -w.M[a][b] * r[i][k].v;
        }
      }
    }
  }
  return slips;
}

void add_slip_hessian(const FaceCorners& x, const FaceCorners& p, const FaceMap& map,
                      const FacetAnchor& anchor, const std::array<std::array<double, 2>, 4>& factor,
                      std::span<double> hessian) {
  // f = r_1.V_1 + r_2.V_2: f'' by the directions alone, and what both change together.
  const std::array<Point3, 2> g = plane_of(map, x);
  std::array<Point3, 2> V{};
  std::array<std::array<double, 8>, 2> weight{}; // of the corners in V
  for (std::size_t a = 0; a < 4; ++a) {
    const Point3 v = opening(x, p, anchor.weights, a);
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t k = 0; k < 3; ++k) V[i][k] += factor[a][i] * v[k];
      for (std::size_t b = 0; b < 4; ++b) {
        weight[i][b] += factor[a][i] * anchor.weights.D[a][b];
        weight[i][4 + b] -= factor[a][i] * anchor.weights.M[a][b];
      }
    }
  }
  const std::array<Vector3Of<Second>, 2> r = seeded_rotation<Second>(g, [](double value, int i) {
    Second y(seed<double, variables>(value, i));
    y.d[i] = First(1.0);
    return y;
  });
  Second f(0.0);
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t k = 0; k < 3; ++k) f += V[i][k] * r[i][k];
  for (std::size_t b = 0; b < 4; ++b)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t row = 3 * b + k;
      std::array<double, variables> by_plane{};
      for (std::size_t q = 0; q < variables; ++q)
        for (std::size_t j = 0; j < 2; ++j) by_plane[q] += map.row[j][b] * f.d[3 * j + k].d[q];
      for (std::size_t c = 0; c < 8; ++c)
        for (std::size_t m = 0; m < 3; ++m) {
          const std::size_t column = 3 * c + m;
          double both = 0;
          for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t j = 0; j < 2; ++j) both += map.row[j][b] * r[i][m].v.d[3 * j + k] * weight[i][c];
          hessian[24 * row + column] += both;
          hessian[24 * column + row] += both;
          if (c < 4)
            hessian[24 * row + column] += map.row[0][c] * by_plane[m] + map.row[1][c] * by_plane[3 + m];
        }
    }
}

FacetSlips facet_slips(const EdgeCorners& x, const EdgeCorners& p, const FaceMap&, const FacetAnchor& anchor,
                       bool) {
  FacetSlips slips;
  for (std::size_t a = 0; a < 2; ++a) {
    const Slip slip = slip_of(x, p, edge_anchor(anchor, a));
    slips.value[a][0] = slip.value - anchor.start[a][0];
    std::copy(slip.gradient.begin(), slip.gradient.end(), slips.gradient[a][0].begin());
  }
  return slips;
}

void add_slip_hessian(const EdgeCorners& x, const EdgeCorners& p, const FaceMap&, const FacetAnchor& anchor,
                      const std::array<std::array<double, 2>, 4>& factor, std::span<double> hessian) {
  for (std::size_t a = 0; a < 2; ++a) {
    if (factor[a][0] == 0) continue;
    const std::array<double, 64> H = slip_hessian(x, p, edge_anchor(anchor, a));
    for (std::size_t i = 0; i < H.size(); ++i) hessian[i] += factor[a][0] * H[i];
  }
}

} // namespace impact
