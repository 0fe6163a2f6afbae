#include "face_pairs.hpp"
#include <gtest/gtest.h>
#include <impact/kernel/face_ray.hpp>

using namespace impact;
using namespace impact::face_test;

namespace {

constexpr std::array<double, 4> of_triangle = {0.2, 0.3, 0.5, 0}, of_quadrilateral = {0.1, 0.2, 0.4, 0.3};

const std::array<double, 4>& shape_of(const Pair& pair) {
  return pair.corners == 3 ? of_triangle : of_quadrilateral;
}
int triangles_of(int corners) { return corners == 3 ? 1 : 4; }

RayFoot cast(const Pair& pair, int triangle) {
  return cast_ray({pair.x, shape_of(pair), pair.p, triangle_weights(pair.primary_corners, triangle)});
}
std::array<double, 24> gradient(const Pair& pair, int triangle) {
  return ray_gradient({pair.x, shape_of(pair), pair.p, triangle_weights(pair.primary_corners, triangle)});
}

// Calls f(pair, triangle of the primary) for random pairs of every kind.
template <class F> void for_each_pair(unsigned seed, F&& f) {
  std::mt19937 random(seed);
  for (const auto& [corners, primary] : kinds)
    for (int trial = 0; trial < 5; ++trial) {
      const Pair pair = random_pair(random, corners, primary);
      for (int t = 0; t < triangles_of(primary); ++t) f(pair, t);
    }
}

} // namespace

TEST(FaceRay, FootLiesOnTheTriangleAlongTheNormal) {
  for_each_pair(1, [](const Pair& pair, int triangle) {
    const RayFoot foot = cast(pair, triangle);
    const Point3 n = facet_normal(pair.x);
    const auto w = triangle_weights(pair.primary_corners, triangle);
    std::array<Point3, 3> v{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t b = 0; b < 4; ++b)
        for (std::size_t k = 0; k < 3; ++k) v[i][k] += w[i][b] * pair.p[b][k];
    Point3 x{}, there{}, along{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t a = 0; a < 4; ++a) x[k] += shape_of(pair)[a] * pair.x[a][k];
      for (std::size_t b = 0; b < 4; ++b) there[k] += foot.weights[b] * pair.p[b][k];
      for (std::size_t i = 0; i < 3; ++i) along[k] += foot.part[i] * v[i][k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(there[k], x[k] + foot.gap * n[k], 1e-13);
      EXPECT_NEAR(along[k], there[k], 1e-13);
    }
    EXPECT_NEAR(foot.part[0] + foot.part[1] + foot.part[2], 1, 1e-14);
    EXPECT_NEAR(foot.opposition, dot(n, foot.normal), 1e-14);
    EXPECT_LT(foot.opposition, -0.5);
  });
}

TEST(FaceRay, GapIsOpenPositive) {
  const FaceCorners x = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}; // normal along z
  FaceCorners p = {{{0, 0, 0.3}, {0, 2, 0.3}, {2, 2, 0.3}, {2, 0, 0.3}}};
  const auto first = triangle_weights(4, 0);
  EXPECT_NEAR(cast_ray({x, of_quadrilateral, p, first}).gap, 0.3, 1e-15);
  for (Point3& corner : p) corner[2] = -0.2;
  EXPECT_NEAR(cast_ray({x, of_quadrilateral, p, first}).gap, -0.2, 1e-15);
}

TEST(FaceRay, GradientIsTheDerivativeOfTheGap) {
  constexpr double h = 1e-6;
  for_each_pair(2, [](const Pair& pair, int triangle) {
    const std::array<double, 24> row = gradient(pair, triangle);
    for (std::size_t i = 0; i < 24; ++i) {
      Pair up = pair, down = pair;
      shift(up, i, h);
      shift(down, i, -h);
      const double slope = (cast(up, triangle).gap - cast(down, triangle).gap) / (2 * h);
      EXPECT_NEAR(row[i], repeated(pair, i) ? 0 : slope, 2e-9);
    }
  });
}

TEST(FaceRay, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  constexpr double h = 1e-6;
  for_each_pair(3, [](const Pair& pair, int triangle) {
    std::array<double, 576> H{};
    add_ray_hessian({pair.x, shape_of(pair), pair.p, triangle_weights(pair.primary_corners, triangle)}, 0.7,
                    H);
    for (std::size_t i = 0; i < 24; ++i) {
      if (repeated(pair, i)) continue;
      Pair up = pair, down = pair;
      shift(up, i, h);
      shift(down, i, -h);
      const std::array<double, 24> right = gradient(up, triangle), left = gradient(down, triangle);
      for (std::size_t j = 0; j < 24; ++j) {
        EXPECT_NEAR(H[24 * i + j], 0.7 * (right[j] - left[j]) / (2 * h), 1e-8);
        EXPECT_NEAR(H[24 * i + j], H[24 * j + i], 1e-13);
      }
    }
  });
}

TEST(FaceRay, ForcesAndMomentsBalance) {
  for_each_pair(4, [](const Pair& fixed, int triangle) {
    Pair pair = fixed;
    const std::array<double, 24> row = gradient(pair, triangle);
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
