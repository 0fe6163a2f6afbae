#include "face_pairs.hpp"
#include <gtest/gtest.h>

using namespace impact;
using namespace impact::face_test;

namespace {

MortarPair evaluate(const Pair& pair, bool with_gradient = true) {
  return mortar_pair(pair.x, pair.p, pair.face, with_gradient);
}

struct Triangle {
  std::array<Point3, 3> x;
  std::array<std::array<double, 4>, 3> shape; // of the face's corners at the triangle's
};

std::vector<Triangle> triangles(int corners, const FaceCorners& x) {
  if (corners == 3) return {{{x[0], x[1], x[2]}, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}}};
  std::vector<Triangle> list;
  Point3 middle{};
  for (const Point3& corner : x)
    for (std::size_t k = 0; k < 3; ++k) middle[k] += corner[k] / 4;
  for (std::size_t i = 0; i < 4; ++i) {
    Triangle t{{x[i], x[(i + 1) % 4], middle}, {}};
    t.shape[0][i] = t.shape[1][(i + 1) % 4] = 1;
    t.shape[2] = {0.25, 0.25, 0.25, 0.25};
    list.push_back(t);
  }
  return list;
}

// G_a by the definition: many points on the secondary face, a ray along the normal to the primary triangles.
std::array<double, 4> by_rays(const Pair& pair) {
  std::array<double, 4> G{};
  constexpr int n = 200;
  const auto secondary = triangles(pair.corners, pair.x);
  for (std::size_t i = 0; i < secondary.size(); ++i) {
    const Triangle& s = secondary[i];
    const Point3 normal = cross(minus(s.x[1], s.x[0]), minus(s.x[2], s.x[0]));
    const double length = std::sqrt(dot(normal, normal));
    for (int row = 0; row < n; ++row)
      for (int column = 0; column < 2 * (n - row) - 1; ++column) {
        const double shift = column % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
        const double b = (column / 2 + shift) / n, c = (row + shift) / n;
        Point3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = (1 - b - c) * s.x[0][k] + b * s.x[1][k] + c * s.x[2][k];
        for (const Triangle& t : triangles(pair.primary_corners, pair.p)) {
          const Point3 q1 = minus(t.x[1], t.x[0]), q2 = minus(t.x[2], t.x[0]), m = cross(q1, q2);
          if (dot(m, normal) >= 0) continue;
          const double g = dot(minus(t.x[0], x), m) / dot(normal, m) * length;
          Point3 y;
          for (std::size_t k = 0; k < 3; ++k) y[k] = x[k] + g * normal[k] / length - t.x[0][k];
          const double r1 = dot(cross(y, q2), m) / dot(m, m), r2 = dot(cross(q1, y), m) / dot(m, m);
          if (r1 < 0 || r2 < 0 || r1 + r2 > 1) continue;
          for (std::size_t a = 0; a < 4; ++a) {
            double phi = 0;
            for (std::size_t d = 0; d < 4; ++d)
              phi +=
                  pair.face.phi[a][d] * ((1 - b - c) * s.shape[0][d] + b * s.shape[1][d] + c * s.shape[2][d]);
            G[a] += phi * g * pair.face.area[i] / (n * n);
          }
        }
      }
  }
  return G;
}

} // namespace

TEST(MortarFace, WeightedGapsAreTheIntegralsAlongTheNormal) {
  std::mt19937 random(1);
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 3; ++trial) {
      const Pair pair = random_pair(random, corners, primary, trial == 2);
      const MortarPair direct = evaluate(pair, false);
      const std::array<double, 4> reference = by_rays(pair);
      for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(direct.gap[a], reference[a], 5e-4);
    }
}

TEST(MortarFace, GradientIsTheDerivativeOfTheGaps) {
  std::mt19937 random(2);
  constexpr double h = 1e-6;
  int covered = 0;
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 10; ++trial) {
      const Pair pair = random_pair(random, corners, primary, trial % 2 == 1);
      const MortarPair at = evaluate(pair);
      covered += at.covered;
      for (std::size_t i = 0; i < 24; ++i) {
        Pair up = pair, down = pair;
        shift(up, i, h);
        shift(down, i, -h);
        const MortarPair right = evaluate(up, false), left = evaluate(down, false);
        for (std::size_t a = 0; a < 4; ++a)
          EXPECT_NEAR(at.gradient[a][i], repeated(pair, i) ? 0 : (right.gap[a] - left.gap[a]) / (2 * h),
                      2e-9);
      }
    }
  EXPECT_GT(covered, 35);
}

// Concentric quadrilaterals of different size: the sides of their triangles lie on each other, and which of
// them cover the strips between is decided by the last digit. What they make together does not depend on it.
TEST(MortarFace, SidesThatLieOnEachOtherLeaveNoTraceInTheDerivatives) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> digit(-1, 1);
  const FaceCorners square = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  const auto evaluate_shaken = [&](double by, double angle) {
    Pair pair;
    pair.corners = pair.primary_corners = 4;
    for (std::size_t a = 0; a < 4; ++a) {
      // A larger primary above, running against the secondary.
      const Point3 p = square[(4 - a) % 4];
      const auto turned = [&](double X, double Y, double Z) -> Point3 {
        return {std::cos(angle) * X - std::sin(angle) * Y + by * digit(random),
                std::sin(angle) * X + std::cos(angle) * Y + by * digit(random), Z};
      };
      pair.x[a] = turned(square[a][0] - 0.5, square[a][1] - 0.5, 0);
      pair.p[a] = turned(1.2 * (p[0] - 0.5), 1.2 * (p[1] - 0.5), 0.2 + 0.03 * p[0]);
    }
    pair.face = make_mortar_face(square, false);
    return evaluate(pair);
  };
  for (const double angle : {0.0, 0.3, 1.1}) {
    const MortarPair reference = evaluate_shaken(0, angle);
    EXPECT_GT(reference.gap[0], 0.01);
    for (const double by : {1e-17, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9})
      for (int trial = 0; trial < 10; ++trial) {
        const MortarPair here = evaluate_shaken(by, angle);
        for (std::size_t a = 0; a < 4; ++a) {
          EXPECT_NEAR(here.gap[a], reference.gap[a], 1e-8);
          for (std::size_t i = 0; i < 24; ++i)
            EXPECT_NEAR(here.gradient[a][i], reference.gradient[a][i], 2e-8)
                << "shaken by " << by << ", angle " << angle << ", dof " << i;
        }
      }
  }
}

TEST(MortarFace, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  std::mt19937 random(3);
  constexpr double h = 1e-6;
  int curved = 0;
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 5; ++trial) {
      const Pair pair = random_pair(random, corners, primary, trial % 2 == 1);
      const std::array<double, 4> factor = {0.7, -0.3, 1.1, 0.4};
      std::array<double, 576> H{};
      add_mortar_hessian(pair.x, pair.p, pair.face, factor, H);
      double largest = 0;
      for (double value : H) largest = std::max(largest, std::abs(value));
      curved += largest > 0.1;
      for (std::size_t i = 0; i < 24; ++i) {
        if (repeated(pair, i)) continue;
        Pair up = pair, down = pair;
        shift(up, i, h);
        shift(down, i, -h);
        const MortarPair right = evaluate(up), left = evaluate(down);
        for (std::size_t j = 0; j < 24; ++j) {
          double difference = 0;
          for (std::size_t a = 0; a < static_cast<std::size_t>(corners); ++a)
            difference += factor[a] * (right.gradient[a][j] - left.gradient[a][j]) / (2 * h);
          EXPECT_NEAR(H[24 * i + j], difference, 1e-7 * std::max(1.0, largest));
          EXPECT_NEAR(H[24 * i + j], H[24 * j + i], 1e-13 * std::max(1.0, largest));
        }
      }
    }
  EXPECT_GT(curved, 12);
}

TEST(MortarFace, ForcesAndMomentsBalance) {
  std::mt19937 random(4);
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 10; ++trial) {
      Pair pair = random_pair(random, corners, primary);
      const MortarPair at = evaluate(pair);
      for (std::size_t a = 0; a < 4; ++a) {
        Point3 force{}, moment{};
        for (std::size_t i = 0; i < 24; i += 3) {
          const Point3 x = {dof(pair, i), dof(pair, i + 1), dof(pair, i + 2)};
          const Point3 f = {at.gradient[a][i], at.gradient[a][i + 1], at.gradient[a][i + 2]};
          const Point3 m = cross(x, f);
          for (std::size_t k = 0; k < 3; ++k) {
            force[k] += f[k];
            moment[k] += m[k];
          }
        }
        for (std::size_t k = 0; k < 3; ++k) {
          EXPECT_NEAR(force[k], 0, 1e-14);
          EXPECT_NEAR(moment[k], 0, 1e-14);
        }
      }
    }
}

// Flat faces of any shape that touch: the primary is one large triangle, or the secondary's own corners.
TEST(MortarFace, UniformPressureOnAFlatFaceMakesTheForcesOfItsBilinearFunctions) {
  const FaceCorners x = {{{0, 0, 0}, {2, 0.1, 0}, {1.5, 1.2, 0}, {0.2, 0.9, 0}}};
  const MortarFace face = make_mortar_face(x, false);
  const FaceCorners large = {{{-9, -9, 0}, {0, 20, 0}, {20, -9, 0}, {20, -9, 0}}};
  const FaceCorners same = {{x[3], x[2], x[1], x[0]}};
  // int N_a dA with 2 x 2 Gauss points, exact for bilinear functions and a linear Jacobian.
  std::array<double, 4> load{};
  const double g = 1 / std::sqrt(3.0);
  for (const auto& [r, s] : std::array<std::array<double, 2>, 4>{{{-g, -g}, {g, -g}, {g, g}, {-g, g}}}) {
    const std::array<double, 4> N = {(1 - r) * (1 - s) / 4, (1 + r) * (1 - s) / 4, (1 + r) * (1 + s) / 4,
                                     (1 - r) * (1 + s) / 4};
    const std::array<double, 4> Nr = {-(1 - s) / 4, (1 - s) / 4, (1 + s) / 4, -(1 + s) / 4};
    const std::array<double, 4> Ns = {-(1 - r) / 4, -(1 + r) / 4, (1 + r) / 4, (1 - r) / 4};
    double xr = 0, yr = 0, xs = 0, ys = 0;
    for (std::size_t a = 0; a < 4; ++a) {
      xr += Nr[a] * x[a][0];
      yr += Nr[a] * x[a][1];
      xs += Ns[a] * x[a][0];
      ys += Ns[a] * x[a][1];
    }
    for (std::size_t a = 0; a < 4; ++a) load[a] += N[a] * (xr * ys - yr * xs);
  }
  const MortarPair on_large = mortar_pair(x, large, face, true);
  const MortarPair on_same = mortar_pair(x, same, face, true);
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t k = 0; k < 3; ++k) {
      double from_large = 0, from_same = 0, on_primary = 0;
      for (std::size_t b = 0; b < 4; ++b) {
        from_large += on_large.gradient[b][3 * a + k];
        from_same += on_same.gradient[b][3 * a + k];
        on_primary += on_same.gradient[b][12 + 3 * (3 - a) + k];
      }
      EXPECT_NEAR(from_large, k == 2 ? -load[a] : 0, 1e-13);
      EXPECT_NEAR(from_same, k == 2 ? -load[a] : 0, 1e-13);
      EXPECT_NEAR(on_primary, k == 2 ? load[a] : 0, 1e-13);
    }
}

TEST(MortarFace, DualFunctionsAreBiorthogonalWithTheSameIntegrals) {
  std::mt19937 random(5);
  for (int corners : {3, 4}) {
    const Pair pair = random_pair(random, corners, 4, true);
    const auto list = triangles(corners, pair.x);
    FaceCorners X = pair.x;
    for (Point3& point : X) point[0] *= 1.2;
    const std::array<double, 4> integral = nodal_areas(X);
    for (std::size_t a = 0; a < static_cast<std::size_t>(corners); ++a)
      for (std::size_t b = 0; b < static_cast<std::size_t>(corners); ++b) {
        double product = 0; // int Phi_a N_b by the middles of the sides
        for (std::size_t i = 0; i < list.size(); ++i)
          for (std::size_t side = 0; side < 3; ++side) {
            double phi = 0, N = 0;
            for (std::size_t d = 0; d < 4; ++d) {
              const double shape = (list[i].shape[side][d] + list[i].shape[(side + 1) % 3][d]) / 2;
              phi += pair.face.phi[a][d] * shape;
              if (d == b) N = shape;
            }
            product += pair.face.area[i] / 3 * phi * N;
          }
        EXPECT_NEAR(product, a == b ? integral[a] : 0, 1e-14);
      }
  }
}

TEST(MortarFace, PartsOfFacesThatTileTheSecondarySumToOne) {
  const FaceCorners x = {{{0, 0, 0}, {1, 0, 0.1}, {1, 1, 0}, {0, 1, 0.1}}};
  const MortarFace face = make_mortar_face(x, false);
  std::array<double, 4> cover{};
  double tiled = 0;
  const double at[] = {-0.5, 0.3, 0.8, 1.6};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const auto corner = [&](std::size_t a, std::size_t b) { return Point3{at[a], at[b], 0.2}; };
      const FaceCorners p = {{corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)}};
      const MortarPair pair = mortar_pair(x, p, face, false);
      for (std::size_t a = 0; a < 4; ++a) cover[a] += pair.cover[a];
      tiled += view_facet(x, p).part;
    }
  const std::array<double, 4> whole = nodal_areas(x);
  for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(cover[a], whole[a], 1e-13);
  EXPECT_NEAR(tiled, 1, 1e-13);
  const FaceCorners flat = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  const FaceCorners near = {{{0, 0, 1}, {0, 2, 1}, {0.5, 2, 1}, {0.5, 0, 1}}};
  const FaceCorners far = {{{-1, 0, 2}, {-1, 0.5, 2}, {2, 0.5, 2}, {2, 0, 2}}};
  EXPECT_NEAR(common_part(flat, near, far), 0.25, 1e-14);
  double gap = 0;
  EXPECT_TRUE(corner_gap(flat, 0, far, gap));
  EXPECT_NEAR(gap, 2, 1e-14);
  EXPECT_FALSE(corner_gap(flat, 2, far, gap));
}

TEST(MortarFace, PiecesOfWhatIsCoveredHaveTheIntegralsOfTheWeights) {
  std::mt19937 random(5);
  for (const auto& [corners, primary_corners] : kinds)
    for (int trial = 0; trial < 10; ++trial) {
      const Pair pair = random_pair(random, corners, primary_corners, trial % 2 == 1);
      const MortarWeights w = mortar_weights(pair.x, pair.p, pair.face);
      MortarWeights sum;
      visit_covered(pair.x, pair.p, pair.face, [&](const CoveredPiece& piece) {
        EXPECT_NEAR(dot(piece.normal, piece.normal), 1, 1e-14);
        // Products of linear functions over a triangle: 1/6 and 1/12 of its area.
        for (std::size_t v = 0; v < 3; ++v)
          for (std::size_t u = 0; u < 3; ++u)
            for (std::size_t a = 0; a < 4; ++a)
              for (std::size_t b = 0; b < 4; ++b) {
                const double part = piece.area / (u == v ? 6 : 12) * piece.phi[v][a];
                sum.D[a][b] += part * piece.secondary[u][b];
                sum.M[a][b] += part * piece.primary[u][b];
              }
      });
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
          EXPECT_NEAR(sum.D[a][b], w.D[a][b], 1e-13);
          EXPECT_NEAR(sum.M[a][b], w.M[a][b], 1e-13);
        }
    }
}

TEST(MortarFace, WeightsHaveEqualSumsAndOpenAlongTheNormalByTheWeightedGap) {
  std::mt19937 random(1);
  for (const auto& [corners, primary_corners] : kinds)
    for (int trial = 0; trial < 30; ++trial) {
      Pair pair = random_pair(random, corners, primary_corners, trial % 2 == 1);
      if (trial % 3 == 0) // flat: one normal
        for (Point3& x : pair.x) x[2] = 0;
      const MortarPair gaps = mortar_pair(pair.x, pair.p, pair.face, false);
      const MortarWeights w = mortar_weights(pair.x, pair.p, pair.face);
      ASSERT_EQ(w.covered, gaps.covered);
      for (std::size_t a = 0; a < 4; ++a) {
        double D = 0, M = 0;
        Point3 v{};
        for (std::size_t b = 0; b < 4; ++b) {
          D += w.D[a][b];
          M += w.M[a][b];
          for (std::size_t k = 0; k < 3; ++k) v[k] += w.D[a][b] * pair.x[b][k] - w.M[a][b] * pair.p[b][k];
        }
        EXPECT_NEAR(D, gaps.cover[a], 1e-14);
        EXPECT_NEAR(M, gaps.cover[a], 1e-14);
        if (trial % 3 != 0) continue;
        EXPECT_NEAR(v[0], 0, 1e-13);
        EXPECT_NEAR(v[1], 0, 1e-13);
        EXPECT_NEAR(v[2], -gaps.gap[a], 1e-13);
      }
    }
}
