#include <cmath>
#include <gtest/gtest.h>
#include <impact/kernel/face_ray.hpp>
#include <random>

using namespace impact;

namespace {

// Two facets of second order roughly opposite to each other, with bent sides, shifted and turned.
template <class Facet> struct Pair {
  static constexpr std::size_t dim = Facet::dim + 1, dofs = CurvedRay<Facet>::dofs;
  CurvedRay<Facet> ray;

  double& dof(std::size_t i) {
    auto& side = i < dofs / 2 ? ray.x : ray.p;
    return side[i % (dofs / 2) / dim][i % dim];
  }
  RayFoot<CurvedRay<Facet>> foot() const { return cast_ray(ray); }
  std::array<double, dofs> gradient() const { return ray_gradient(ray, foot()); }
};

// From the unit square, of which a triangle is the half at the origin.
template <class Facet> typename Facet::Point place_of(double r, double s) {
  if constexpr (Facet::dim == 1)
    return {2 * r - 1};
  else if constexpr (Facet::Corners::nodes == 4)
    return {2 * r - 1, 2 * s - 1};
  else
    return {r, s};
}

template <class Facet> Pair<Facet> random_pair(std::mt19937& random) {
  constexpr std::size_t dim = Facet::dim + 1;
  std::uniform_real_distribution<double> u(-1, 1);
  Pair<Facet> pair;
  // Along a line the first facet runs backwards, so that its normal points up; a triangle counter-clockwise.
  const double angle = 0.4 * u(random), size = 1.2 + 0.3 * u(random);
  for (std::size_t a = 0; a < Facet::nodes; ++a) {
    const auto xi = place_of_node<Facet>(a);
    constexpr bool box = Facet::Corners::nodes == 1 << Facet::dim;
    const double r = box ? (1 + xi[0]) / 2 : xi[0], x = dim == 2 ? 1 - r : r,
                 y = dim == 2 ? 0
                     : box    ? (1 + xi[dim - 2]) / 2
                              : xi[dim - 2];
    // Mirrored, so that the normal of the second one points down.
    const double X = dim == 2 ? 1 - x : y, Y = dim == 2 ? 0 : x;
    const double turned_x = 0.2 + size * (std::cos(angle) * (X - 0.3) - std::sin(angle) * (Y - 0.3)),
                 turned_y = 0.2 + size * (std::sin(angle) * (X - 0.3) + std::cos(angle) * (Y - 0.3));
    if constexpr (dim == 2) {
      pair.ray.x[a] = {x + 0.05 * u(random), 0.1 * u(random)};
      pair.ray.p[a] = {0.5 + size * (X - 0.5) + 0.05 * u(random), -0.1 + 0.1 * u(random)};
    } else {
      pair.ray.x[a] = {x + 0.05 * u(random), y + 0.05 * u(random), 0.1 * u(random)};
      pair.ray.p[a] = {turned_x + 0.05 * u(random), turned_y + 0.05 * u(random), -0.1 + 0.1 * u(random)};
    }
  }
  const double r = 0.3 + 0.2 * u(random), s = 0.3 + 0.2 * u(random);
  pair.ray.at = FacetPlace<Facet>::at(place_of<Facet>(r, s));
  return pair;
}

template <class Facet> class CurvedRayTest : public testing::Test {
protected:
  template <class F> static void for_each_pair(unsigned seed, F&& f) {
    std::mt19937 random(seed);
    for (int trial = 0; trial < 12; ++trial) f(random_pair<Facet>(random));
  }
};
using Facets = testing::Types<Line3, Tri6, Quad8, Quad9>;
TYPED_TEST_SUITE(CurvedRayTest, Facets);

} // namespace

TYPED_TEST(CurvedRayTest, FootLiesOnThePrimaryAlongTheNormal) {
  using P = Pair<TypeParam>;
  this->for_each_pair(1, [](const P& pair) {
    const RayFoot<CurvedRay<TypeParam>> foot = pair.foot();
    const auto n = facet_normal<TypeParam>(pair.ray.x, pair.ray.at),
               m = facet_normal<TypeParam>(pair.ray.p, foot.place);
    double opposition = 0, parts = 0;
    for (std::size_t k = 0; k < P::dim; ++k) {
      double x = 0, y = 0;
      for (std::size_t a = 0; a < TypeParam::nodes; ++a) {
        x += pair.ray.at.N[a] * pair.ray.x[a][k];
        y += foot.place.N[a] * pair.ray.p[a][k];
      }
      EXPECT_NEAR(y, x + foot.gap * n[k], 1e-14);
      EXPECT_NEAR(foot.normal[k], m[k], 1e-14);
      opposition += n[k] * m[k];
    }
    for (const double part : foot.part) parts += part;
    EXPECT_NEAR(foot.opposition, opposition, 1e-14);
    EXPECT_LT(foot.opposition, -0.5);
    EXPECT_NEAR(parts, 1, 1e-14);
  });
}

TYPED_TEST(CurvedRayTest, GradientIsTheDerivativeOfTheGap) {
  using P = Pair<TypeParam>;
  this->for_each_pair(2, [](const P& pair) {
    constexpr double h = 1e-6;
    const auto row = pair.gradient();
    for (std::size_t i = 0; i < P::dofs; ++i) {
      P up = pair, down = pair;
      up.dof(i) += h;
      down.dof(i) -= h;
      EXPECT_NEAR(row[i], (up.foot().gap - down.foot().gap) / (2 * h), 2e-9);
    }
  });
}

TYPED_TEST(CurvedRayTest, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  using P = Pair<TypeParam>;
  double largest = 0;
  this->for_each_pair(3, [&](const P& pair) {
    constexpr double h = 1e-6;
    std::vector<double> H(P::dofs * P::dofs, 0.0);
    add_ray_hessian(pair.ray, pair.foot(), 0.7, H);
    for (std::size_t i = 0; i < P::dofs; ++i) {
      P up = pair, down = pair;
      up.dof(i) += h;
      down.dof(i) -= h;
      const auto right = up.gradient(), left = down.gradient();
      for (std::size_t j = 0; j < P::dofs; ++j) {
        EXPECT_NEAR(H[P::dofs * i + j], 0.7 * (right[j] - left[j]) / (2 * h), 3e-8);
        EXPECT_NEAR(H[P::dofs * i + j], H[P::dofs * j + i], 1e-12);
        largest = std::max(largest, std::abs(H[P::dofs * i + j]));
      }
    }
  });
  EXPECT_GT(largest, 0.5);
}

TYPED_TEST(CurvedRayTest, ForcesAndMomentsBalance) {
  using P = Pair<TypeParam>;
  this->for_each_pair(4, [](P pair) {
    const auto row = pair.gradient();
    std::array<double, 3> force{}, moment{};
    for (std::size_t i = 0; i < P::dofs; i += P::dim) {
      std::array<double, 3> x{}, f{};
      for (std::size_t k = 0; k < P::dim; ++k) {
        x[k] = pair.dof(i + k);
        f[k] = row[i + k];
        force[k] += f[k];
      }
      for (std::size_t k = 0; k < 3; ++k)
        moment[k] += x[(k + 1) % 3] * f[(k + 2) % 3] - x[(k + 2) % 3] * f[(k + 1) % 3];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(force[k], 0, 1e-14);
      EXPECT_NEAR(moment[k], 0, 1e-14);
    }
  });
}

// On the arc of a parabola the gap has a closed form.
TEST(CurvedRay, TheEdgeIsMetWhereItIsAndNotOnItsChord) {
  CurvedRay<Line3> ray;
  ray.x = {{{1, 0}, {-1, 0}, {0, 0}}}; // normal upwards
  ray.p = {{{-1, 1}, {1, 1}, {0, 0.5}}};
  for (const double x : {-0.9, -0.3, 0.0, 0.7}) {
    ray.at = FacetPlace<Line3>::at({-x});
    EXPECT_NEAR(cast_ray(ray).gap, 0.5 + 0.5 * x * x, 1e-15);
  }
}

TEST(CurvedRay, FacetsWithStraightSidesAreThoseOfFirstOrder) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 10; ++trial) {
    FaceRay linear{{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}, {0.2, 0.3, 0.5}, {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}}}};
    CurvedRay<Tri6> curved;
    for (auto* side : {&linear.x, &linear.p})
      for (std::size_t a = 0; a < 3; ++a)
        for (double& component : (*side)[a]) component += 0.1 * u(random);
    const std::array<std::size_t, 6> from = {0, 1, 2, 0, 1, 2}, to = {0, 1, 2, 1, 2, 0};
    for (std::size_t a = 0; a < 6; ++a)
      for (std::size_t k = 0; k < 3; ++k) {
        curved.x[a][k] = (linear.x[from[a]][k] + linear.x[to[a]][k]) / 2;
        curved.p[a][k] = (linear.p[from[a]][k] + linear.p[to[a]][k]) / 2;
      }
    linear.x[3] = linear.x[2];
    linear.p[3] = linear.p[2];
    curved.at = FacetPlace<Tri6>::at({linear.shape[1], linear.shape[2]});
    const RayFoot<FaceRay> flat = cast_ray(linear);
    const RayFoot<CurvedRay<Tri6>> foot = cast_ray(curved);
    EXPECT_NEAR(foot.gap, flat.gap, 1e-14);
    EXPECT_NEAR(foot.opposition, flat.opposition, 1e-14);
    for (std::size_t v = 0; v < 3; ++v) EXPECT_NEAR(foot.part[v], flat.part[v], 1e-13);
  }
}

TEST(CurvedRay, WhatLiesFarFromThePrimaryIsNotSeen) {
  CurvedRay<Line3> ray;
  ray.x = {{{9, 0}, {8, 0}, {8.5, 0}}};
  ray.p = {{{-1, 1}, {1, 1}, {0, 0.5}}};
  ray.at = FacetPlace<Line3>::at({0});
  EXPECT_LT(cast_ray(ray).part[0], -1e300);
}
