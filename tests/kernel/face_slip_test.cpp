#include "face_pairs.hpp"
#include <complex>
#include <gtest/gtest.h>
#include <impact/kernel/face_slip.hpp>

using namespace impact;
using namespace impact::face_test;

namespace {

struct Anchored {
  Pair pair;
  FaceMap map;
  FacetAnchor anchor;
};

// Anchored where it stands, then moved on and bent.
Anchored random_anchored(std::mt19937& random, int corners, int primary_corners) {
  std::uniform_real_distribution<double> u(-1, 1);
  for (;;) {
    Anchored a{random_pair(random, corners, primary_corners, true), {}, {}};
    a.map = make_face_map(a.pair.x);
    a.anchor.weights = mortar_weights(a.pair.x, a.pair.p, a.pair.face);
    if (!a.anchor.weights.covered) continue;
    a.anchor.start = facet_slips(a.pair.x, a.pair.p, a.map, a.anchor, false).value;
    for (std::size_t i = 0; i < 24; ++i)
      if (!repeated(a.pair, i)) shift(a.pair, i, 0.1 * u(random));
    return a;
  }
}

FacetSlips evaluate(const Anchored& a, bool with_gradient = true) {
  return facet_slips(a.pair.x, a.pair.p, a.map, a.anchor, with_gradient);
}

using Complex = std::complex<double>;
using ComplexVector = std::array<Complex, 3>;
Complex dot(const ComplexVector& a, const ComplexVector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// s by its definition with R = G (G^T G)^(-1/2), in complex numbers; `perturbed`: a dof or -1.
std::array<std::array<Complex, 2>, 4> by_definition(const Anchored& a, int perturbed) {
  constexpr double h = 1e-30;
  Pair pair = a.pair;
  std::array<ComplexVector, 8> y;
  for (std::size_t i = 0; i < 24; ++i) y[i / 3][i % 3] = dof(pair, i);
  if (perturbed >= 0) {
    const auto i = static_cast<std::size_t>(perturbed);
    y[i / 3][i % 3] += Complex(0, h);
    if (i % 12 / 3 == 2 && repeated(pair, i + 3)) y[i / 3 + 1][i % 3] += Complex(0, h);
  }
  std::array<ComplexVector, 2> G{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t b = 0; b < 4; ++b)
      for (std::size_t k = 0; k < 3; ++k) G[i][k] += a.map.row[i][b] * y[b][k];
  // (C^(1/2))^-1 of C = ((p q) (q r)): C^(1/2) = (C + sqrt(det))/sqrt(trace + 2 sqrt(det)).
  const Complex p = dot(G[0], G[0]), q = dot(G[0], G[1]), r = dot(G[1], G[1]);
  const Complex root = std::sqrt(p * r - q * q), scale = std::sqrt(p + r + 2.0 * root);
  const Complex U00 = (p + root) / scale, U01 = q / scale, U11 = (r + root) / scale,
                det = U00 * U11 - U01 * U01;
  std::array<ComplexVector, 2> R;
  for (std::size_t k = 0; k < 3; ++k) {
    R[0][k] = (U11 * G[0][k] - U01 * G[1][k]) / det;
    R[1][k] = (U00 * G[1][k] - U01 * G[0][k]) / det;
  }
  std::array<std::array<Complex, 2>, 4> s{};
  for (std::size_t f = 0; f < 4; ++f) {
    ComplexVector v{};
    for (std::size_t b = 0; b < 4; ++b)
      for (std::size_t k = 0; k < 3; ++k)
        v[k] += a.anchor.weights.D[f][b] * y[b][k] - a.anchor.weights.M[f][b] * y[4 + b][k];
    for (std::size_t i = 0; i < 2; ++i) s[f][i] = dot(R[i], v) - a.anchor.start[f][i];
  }
  return s;
}

Point3 rotated(const Point3& axis, double angle, const Point3& x) {
  const double c = std::cos(angle), s = std::sin(angle), along = face_test::dot(axis, x) * (1 - c);
  const Point3 w = cross(axis, x);
  return {c * x[0] + s * w[0] + along * axis[0], c * x[1] + s * w[1] + along * axis[1],
          c * x[2] + s * w[2] + along * axis[2]};
}

} // namespace

TEST(FaceSlip, WeightsHaveEqualSumsAndOpenAlongTheNormalByTheWeightedGap) {
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

TEST(FaceSlip, GradientIsTheComplexStepOfTheSlip) {
  std::mt19937 random(2);
  for (const auto& [corners, primary_corners] : kinds)
    for (int trial = 0; trial < 20; ++trial) {
      Anchored a = random_anchored(random, corners, primary_corners);
      const FacetSlips slips = evaluate(a), values = evaluate(a, false);
      const auto exact = by_definition(a, -1);
      double largest = 0;
      for (std::size_t f = 0; f < 4; ++f)
        for (std::size_t i = 0; i < 2; ++i) {
          EXPECT_NEAR(slips.value[f][i], exact[f][i].real(), 1e-14);
          EXPECT_NEAR(values.value[f][i], exact[f][i].real(), 1e-14);
          largest = std::max(largest, std::abs(slips.value[f][i]));
        }
      EXPECT_GT(largest, 1e-4);
      for (int j = 0; j < 24; ++j) {
        if (repeated(a.pair, static_cast<std::size_t>(j))) continue;
        const auto moved = by_definition(a, j);
        for (std::size_t f = 0; f < 4; ++f)
          for (std::size_t i = 0; i < 2; ++i)
            EXPECT_NEAR(slips.gradient[f][i][static_cast<std::size_t>(j)], moved[f][i].imag() / 1e-30, 1e-13);
      }
    }
}

TEST(FaceSlip, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const auto& [corners, primary_corners] : kinds)
    for (int trial = 0; trial < 10; ++trial) {
      Anchored a = random_anchored(random, corners, primary_corners);
      std::array<std::array<double, 2>, 4> factor;
      for (auto& row : factor) row = {u(random), u(random)};
      std::array<double, 576> H{};
      add_slip_hessian(a.pair.x, a.pair.p, a.map, a.anchor, factor, H);
      const auto gradient = [&](const Anchored& at) {
        const FacetSlips slips = evaluate(at);
        std::array<double, 24> sum{};
        for (std::size_t f = 0; f < 4; ++f)
          for (std::size_t i = 0; i < 2; ++i)
            for (std::size_t k = 0; k < 24; ++k) sum[k] += factor[f][i] * slips.gradient[f][i][k];
        return sum;
      };
      double largest = 0;
      for (std::size_t j = 0; j < 24; ++j) {
        if (repeated(a.pair, j)) continue;
        constexpr double h = 1e-5;
        Anchored up = a, down = a;
        shift(up.pair, j, h);
        shift(down.pair, j, -h);
        const auto above = gradient(up), below = gradient(down);
        for (std::size_t k = 0; k < 24; ++k) {
          EXPECT_NEAR(H[24 * k + j], (above[k] - below[k]) / (2 * h), 1e-8);
          EXPECT_NEAR(H[24 * k + j], H[24 * j + k], 1e-13);
          largest = std::max(largest, std::abs(H[24 * k + j]));
        }
      }
      EXPECT_GT(largest, 1e-3);
    }
}

TEST(FaceSlip, RigidMotionsDoNotSlipAndForcesBalance) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-3, 3);
  for (const auto& [corners, primary_corners] : kinds)
    for (int trial = 0; trial < 20; ++trial) {
      Anchored a = random_anchored(random, corners, primary_corners), moved = a;
      Point3 axis = {u(random), u(random), u(random)};
      const double length = std::sqrt(face_test::dot(axis, axis)), angle = u(random);
      for (double& component : axis) component /= length;
      const Point3 by = {u(random), u(random), u(random)};
      for (FaceCorners* face : {&moved.pair.x, &moved.pair.p})
        for (Point3& x : *face) {
          x = rotated(axis, angle, x);
          for (std::size_t k = 0; k < 3; ++k) x[k] += by[k];
        }
      const FacetSlips before = evaluate(a), slips = evaluate(moved);
      for (std::size_t f = 0; f < 4; ++f)
        for (std::size_t i = 0; i < 2; ++i) {
          EXPECT_NEAR(slips.value[f][i], before.value[f][i], 1e-13);
          Point3 force{}, moment{};
          for (std::size_t node = 0; node < 8; ++node) {
            const double* g = &slips.gradient[f][i][3 * node];
            const Point3 x = node < 4 ? moved.pair.x[node] : moved.pair.p[node - 4],
                         m = cross(x, {g[0], g[1], g[2]});
            for (std::size_t k = 0; k < 3; ++k) {
              force[k] += g[k];
              moment[k] += m[k];
            }
          }
          for (std::size_t k = 0; k < 3; ++k) {
            EXPECT_NEAR(force[k], 0, 1e-13);
            EXPECT_NEAR(moment[k], 0, 1e-12);
          }
        }
    }
}

TEST(FaceSlip, MotionAlongAFlatFaceIsTheSlipWhateverTheCellsOfThePlane) {
  // A translation slips by itself times the covered integral of Phi_a, in the tangents of the node whichever
  // the directions of the face.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const int corners : {3, 4})
    for (int trial = 0; trial < 20; ++trial) {
      Anchored a{random_pair(random, corners, 4, true), {}, {}};
      for (Point3& x : a.pair.x) x[2] = 0;
      a.map = make_face_map(a.pair.x);
      a.anchor.weights = mortar_weights(a.pair.x, a.pair.p, a.pair.face);
      a.anchor.start = evaluate(a, false).value;
      const auto cover = mortar_pair(a.pair.x, a.pair.p, a.pair.face, false).cover;
      const Point3 by = {u(random), u(random), 0};
      for (Point3& x : a.pair.x)
        for (std::size_t k = 0; k < 3; ++k) x[k] += by[k];
      const Point3 n = {0, 0, 1};
      const auto turn = turned_into(a.map, n, tangents_of(n));
      for (std::size_t f = 0; f < static_cast<std::size_t>(corners); ++f) {
        std::array<double, 2> s{};
        for (std::size_t i = 0; i < 2; ++i)
          for (std::size_t e = 0; e < 2; ++e) s[i] += turn[i][e] * evaluate(a, false).value[f][e];
        EXPECT_NEAR(s[0], cover[f] * by[0], 1e-13); // tangents along x and y
        EXPECT_NEAR(s[1], cover[f] * by[1], 1e-13);
      }
    }
}

TEST(FaceSlip, TangentsTurnTheShortestWayIntoAFace) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const Pair pair = random_pair(random, 4, 4);
    const FaceMap map = make_face_map(pair.x);
    Point3 n = {u(random), u(random), u(random)};
    const double length = std::sqrt(face_test::dot(n, n));
    for (double& component : n) component /= length;
    const auto t = tangents_of(n);
    EXPECT_NEAR(face_test::dot(t[0], t[1]), 0, 1e-14);
    EXPECT_NEAR(face_test::dot(cross(t[0], t[1]), n), 1, 1e-14);
    if (face_test::dot(n, map.normal) < -0.9) continue;
    Point3 axis = cross(n, map.normal);
    const double sine = std::sqrt(face_test::dot(axis, axis));
    for (double& component : axis) component /= sine;
    const double angle = std::atan2(sine, face_test::dot(n, map.normal));
    const auto turn = turned_into(map, n, t);
    for (std::size_t i = 0; i < 2; ++i)
      for (std::size_t j = 0; j < 2; ++j)
        EXPECT_NEAR(turn[i][j], face_test::dot(rotated(axis, angle, t[i]), map.axis[j]), 1e-12);
  }
}
