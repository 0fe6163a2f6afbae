#include "face_pairs.hpp"
#include <algorithm>
#include <gtest/gtest.h>
#include <impact/kernel/face_ray.hpp>

using namespace impact;
using namespace impact::face_test;

namespace {

constexpr std::array<double, 4> of_triangle = {0.2, 0.3, 0.5, 0}, of_quadrilateral = {0.1, 0.2, 0.4, 0.3};

const std::array<double, 4>& shape_of(const Pair& pair) {
  return pair.corners == 3 ? of_triangle : of_quadrilateral;
}
FaceRay ray_of(const Pair& pair) { return {pair.x, shape_of(pair), pair.p}; }
RayFoot<FaceRay> cast(const Pair& pair) { return cast_ray(ray_of(pair)); }
std::array<double, 24> gradient(const Pair& pair) { return ray_gradient(ray_of(pair), cast(pair)); }

// Random pairs of every kind.
template <class F> void for_each_pair(unsigned seed, F&& f) {
  std::mt19937 random(seed);
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 20; ++trial) f(random_pair(random, corners, primary));
}

} // namespace

TEST(FaceRay, FootLiesOnTheFacetAlongTheNormal) {
  for_each_pair(1, [](const Pair& pair) {
    const RayFoot<FaceRay> foot = cast(pair);
    const Point3 n = facet_normal(pair.x);
    const double r = foot.xi[0], s = foot.xi[1];
    const std::array<double, 4> N = pair.primary_corners == 3
                                        ? std::array<double, 4>{1 - r - s, r, s, 0}
                                        : std::array<double, 4>{(1 - r) * (1 - s) / 4, (1 + r) * (1 - s) / 4,
                                                                (1 + r) * (1 + s) / 4, (1 - r) * (1 + s) / 4};
    Point3 x{}, there{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t a = 0; a < 4; ++a) {
        x[k] += shape_of(pair)[a] * pair.x[a][k];
        there[k] += N[a] * pair.p[a][k];
      }
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(there[k], x[k] + foot.gap * n[k], 1e-13);
    for (std::size_t a = 0; a < 4; ++a) EXPECT_NEAR(foot.place.N[a], N[a], 1e-14);
    EXPECT_NEAR(foot.opposition, dot(n, foot.normal), 1e-14);
    EXPECT_LT(foot.opposition, -0.5);
  });
}

// Where a side is passed a part is negative.
TEST(FaceRay, PartsTellTheSides) {
  const FaceCorners x = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}; // normal along z
  const FaceCorners p = {{{0, 0, 0.3}, {0, 2, 0.3}, {2, 2, 0.3}, {2, 0, 0.3}}};
  for (const double r : {0.25, 0.75, 1.25})
    for (const double s : {0.25, 0.75, 1.25}) {
      const std::array<double, 4> shape = {(1 - 2 * r) * (1 - 2 * s), 2 * r * (1 - 2 * s), 4 * r * s,
                                           (1 - 2 * r) * 2 * s}; // at (2r, 2s)
      const RayFoot<FaceRay> foot = cast_ray(FaceRay{x, shape, p});
      EXPECT_NEAR(foot.gap, 0.3, 1e-15);
      EXPECT_NEAR(*std::min_element(foot.part.begin(), foot.part.end()),
                  std::min({2 * r, 2 * s, 2 - 2 * r, 2 - 2 * s}), 1e-14);
    }
}

// The surface of a quadrilateral is smooth: no point of it is a corner of the gap.
TEST(FaceRay, GapOverABentQuadrilateralHasOneSlopeAtItsDiagonal) {
  Pair pair;
  pair.x = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  pair.p = {{{0, 0, 0.3}, {0, 1, 0.1}, {1, 1, 0.3}, {1, 0, 0.1}}};
  const auto at = [&](double r, double s) {
    return ray_gradient(
        {pair.x, {(1 - r) * (1 - s), r * (1 - s), r * s, (1 - r) * s}, pair.p},
        cast_ray(FaceRay{pair.x, {(1 - r) * (1 - s), r * (1 - s), r * s, (1 - r) * s}, pair.p}));
  };
  const auto left = at(0.3 - 1e-9, 0.3), right = at(0.3 + 1e-9, 0.3);
  for (std::size_t i = 0; i < 24; ++i) EXPECT_NEAR(left[i], right[i], 1e-7);
}

TEST(FaceRay, GapIsOpenPositive) {
  const FaceCorners x = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  FaceCorners p = {{{0, 0, 0.3}, {0, 2, 0.3}, {2, 2, 0.3}, {2, 0, 0.3}}};
  EXPECT_NEAR(cast_ray(FaceRay{x, of_quadrilateral, p}).gap, 0.3, 1e-15);
  for (Point3& corner : p) corner[2] = -0.2;
  EXPECT_NEAR(cast_ray(FaceRay{x, of_quadrilateral, p}).gap, -0.2, 1e-15);
}

TEST(FaceRay, GradientIsTheDerivativeOfTheGap) {
  constexpr double h = 1e-6;
  for_each_pair(2, [](const Pair& pair) {
    const std::array<double, 24> row = gradient(pair);
    for (std::size_t i = 0; i < 24; ++i) {
      Pair up = pair, down = pair;
      shift(up, i, h);
      shift(down, i, -h);
      const double slope = (cast(up).gap - cast(down).gap) / (2 * h);
      EXPECT_NEAR(row[i], repeated(pair, i) ? 0 : slope, 2e-9);
    }
  });
}

TEST(FaceRay, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  constexpr double h = 1e-6;
  for_each_pair(3, [](const Pair& pair) {
    std::array<double, 576> H{};
    add_ray_hessian(ray_of(pair), cast(pair), 0.7, H);
    for (std::size_t i = 0; i < 24; ++i) {
      if (repeated(pair, i)) continue;
      Pair up = pair, down = pair;
      shift(up, i, h);
      shift(down, i, -h);
      const std::array<double, 24> right = gradient(up), left = gradient(down);
      for (std::size_t j = 0; j < 24; ++j) {
        EXPECT_NEAR(H[24 * i + j], 0.7 * (right[j] - left[j]) / (2 * h), 1e-8);
        EXPECT_NEAR(H[24 * i + j], H[24 * j + i], 1e-13);
      }
    }
  });
}

TEST(FaceRay, ForcesAndMomentsBalance) {
  for_each_pair(4, [](const Pair& fixed) {
    Pair pair = fixed;
    const std::array<double, 24> row = gradient(pair);
    Point3 force{}, moment{};
    for (std::size_t i = 0; i < 24; i += 3) {
      const Point3 x = {dof(pair, i), dof(pair, i + 1), dof(pair, i + 2)},
                   f = {row[i], row[i + 1], row[i + 2]};
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
  });
}
