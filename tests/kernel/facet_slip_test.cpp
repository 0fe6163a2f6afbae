#include "face_pairs.hpp"
#include <complex>
#include <gtest/gtest.h>
#include <impact/element/facets.hpp>
#include <impact/kernel/facet_slip.hpp>

using namespace impact;
using face_test::random_pair;

namespace {

// Two facets with an opening of places, moved on and bent since; all of the nodes in one list.
template <class Facet> struct Case {
  static constexpr std::size_t dim = Facet::dim + 1, nodes = Facet::nodes, dofs = 2 * dim * nodes;
  FacetNodes<dim, 2 * nodes> x;
  TangentRows<dim, nodes> rows;
  Opening<nodes> opening;
  Lean lean = upright<dim>();

  FacetNodes<dim, nodes> side(std::size_t i) const {
    FacetNodes<dim, nodes> of;
    std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(i * nodes), nodes, of.begin());
    return of;
  }
  FacetSlip<dim, nodes> slip(bool with_gradient = true) const {
    const FacetNodes<dim, nodes> s = side(0);
    return SlipDirections<dim, nodes>(s, rows, with_gradient).slip(side(1), opening, lean);
  }
};

template <class Facet> typename Facet::Point random_place(std::mt19937& random) {
  std::uniform_real_distribution<double> u(0.1, 0.4);
  typename Facet::Point xi;
  for (double& component : xi) component = u(random);
  return xi;
}

// A straight triangle as contact stores it, with four nodes.
struct Triangle {
  using Point = Tri3::Point;
  static constexpr int dim = 2, nodes = 4;
  static std::array<double, 4> N(const Point& x) { return {1 - x[0] - x[1], x[0], x[1], 0}; }
  static std::array<Point, 4> dN(const Point&) { return {{{-1, -1}, {1, 0}, {0, 1}, {0, 0}}}; }
};
template <class Facet> typename Facet::Point place_of(std::size_t a) { return place_of_node<Facet>(a); }
template <> Triangle::Point place_of<Triangle>(std::size_t a) {
  return place_of_node<Tri3>(std::min<std::size_t>(a, 2));
}

template <class Facet> Case<Facet> random_case(std::mt19937& random) {
  constexpr std::size_t dim = Facet::dim + 1, nodes = Facet::nodes;
  std::uniform_real_distribution<double> u(-1, 1);
  Case<Facet> a;
  const auto scatter = [&](double by) {
    for (auto& x : a.x)
      for (double& component : x) component += by * u(random);
  };
  a.x = {};
  for (std::size_t b = 0; b < 2 * nodes; ++b) {
    const auto xi = place_of<Facet>(b % nodes);
    std::copy(xi.begin(), xi.end(), a.x[b].begin());
  }
  scatter(0.1);
  const auto dN = Facet::dN(random_place<Facet>(random));
  TangentRows<dim, nodes> natural;
  for (std::size_t i = 0; i < dim - 1; ++i)
    for (std::size_t b = 0; b < nodes; ++b) natural[i][b] = dN[b][i];
  a.rows = tangent_rows<dim, nodes>(a.side(0), natural);
  a.opening = {Facet::N(random_place<Facet>(random)), Facet::N(random_place<Facet>(random))};
  scatter(0.1);
  return a;
}

using Complex = std::complex<double>;
template <std::size_t dim> using ComplexVector = std::array<Complex, dim>;
template <std::size_t dim> Complex product(const ComplexVector<dim>& a, const ComplexVector<dim>& b) {
  Complex sum = 0;
  for (std::size_t k = 0; k < dim; ++k) sum += a[k] * b[k];
  return sum;
}

// r.v by its definition with R = G (G^T G)^(-1/2), in complex numbers; `perturbed`: a dof or -1.
template <class Facet> std::array<Complex, 2> by_definition(const Case<Facet>& a, int perturbed) {
  constexpr std::size_t dim = Facet::dim + 1, nodes = Facet::nodes;
  std::array<ComplexVector<dim>, 2 * nodes> y;
  for (std::size_t i = 0; i < a.dofs; ++i) {
    y[i / dim][i % dim] = a.x[i / dim][i % dim];
    if (static_cast<int>(i) == perturbed) y[i / dim][i % dim] += Complex(0, 1e-30);
  }
  std::array<ComplexVector<dim>, dim - 1> G{}, R{};
  ComplexVector<dim> v{};
  for (std::size_t b = 0; b < nodes; ++b)
    for (std::size_t k = 0; k < dim; ++k) {
      for (std::size_t i = 0; i < dim - 1; ++i) G[i][k] += a.rows[i][b] * y[b][k];
      v[k] += a.opening.D[b] * y[b][k] - a.opening.M[b] * y[nodes + b][k];
    }
  if constexpr (dim == 2) return {product<2>(G[0], v) / std::sqrt(product<2>(G[0], G[0])), 0};
  if constexpr (dim == 3) {
    // (C^(1/2))^-1 of C = ((p q) (q r)): C^(1/2) = (C + sqrt(det))/sqrt(trace + 2 sqrt(det)).
    const Complex p = product<3>(G[0], G[0]), q = product<3>(G[0], G[1]), r = product<3>(G[1], G[1]);
    const Complex root = std::sqrt(p * r - q * q), scale = std::sqrt(p + r + 2.0 * root);
    const Complex U00 = (p + root) / scale, U01 = q / scale, U11 = (r + root) / scale,
                  det = U00 * U11 - U01 * U01;
    for (std::size_t k = 0; k < 3; ++k) {
      R[0][k] = (U11 * G[0][k] - U01 * G[1][k]) / det;
      R[1][k] = (U00 * G[1][k] - U01 * G[0][k]) / det;
    }
    return {product<3>(R[0], v), product<3>(R[1], v)};
  }
}

Point3 rotated(const Point3& axis, double angle, const Point3& x) {
  const double c = std::cos(angle), s = std::sin(angle), along = dot(axis, x) * (1 - c);
  const Point3 w = cross(axis, x);
  return {c * x[0] + s * w[0] + along * axis[0], c * x[1] + s * w[1] + along * axis[1],
          c * x[2] + s * w[2] + along * axis[2]};
}

template <class Facet> class FacetSlipTest : public testing::Test {};
using Facets = testing::Types<Line2, Line3, Triangle, Quad4, Tri6, Quad8, Quad9>;
TYPED_TEST_SUITE(FacetSlipTest, Facets);

} // namespace

TYPED_TEST(FacetSlipTest, TangentsAreUnitVectorsAcrossEachOtherAtTheReference) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 10; ++trial) {
    Case<TypeParam> a = random_case<TypeParam>(random);
    a.rows = tangent_rows<a.dim, a.nodes>(a.side(0), a.rows);
    std::array<std::array<double, a.dim>, a.dim - 1> g{};
    for (std::size_t i = 0; i < g.size(); ++i)
      for (std::size_t b = 0; b < a.nodes; ++b)
        for (std::size_t k = 0; k < a.dim; ++k) g[i][k] += a.rows[i][b] * a.x[b][k];
    for (std::size_t i = 0; i < g.size(); ++i)
      for (std::size_t j = 0; j < g.size(); ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < a.dim; ++k) sum += g[i][k] * g[j][k];
        EXPECT_NEAR(sum, i == j, 1e-14);
      }
  }
}

// Turned with the normal the shortest way, and longer.
TYPED_TEST(FacetSlipTest, LeaningDirectionsLieAcrossTheNormalForce) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> u(-1, 1);
  constexpr std::size_t dim = TypeParam::dim + 1;
  for (int trial = 0; trial < 20; ++trial) {
    std::array<double, dim> n;
    for (double& component : n) component = u(random);
    const Lean lean = lean_to<dim>(n, 1.5);
    for (std::size_t i = 0; i + 1 < dim; ++i) {
      double along = 0;
      for (std::size_t k = 0; k < dim; ++k) along += lean[i][k] * n[k];
      EXPECT_NEAR(along, 0, 1e-14);
      for (std::size_t j = 0; j + 1 < dim; ++j) {
        double product = 0;
        for (std::size_t k = 0; k < dim; ++k) product += lean[i][k] * lean[j][k];
        EXPECT_NEAR(product, i == j ? 1.5 * 1.5 : 0, 1e-14);
      }
      EXPECT_GT(lean[i][i], -1e-14);
    }
    const Case<TypeParam> a = random_case<TypeParam>(random);
    const FacetNodes<dim, a.nodes> s = a.side(0);
    const SlipDirections<dim, a.nodes> directions(s, a.rows, false);
    const auto opened = directions.opened(a.side(1), a.opening);
    const auto slip = directions.slip(a.side(1), a.opening, lean).value;
    for (std::size_t i = 0; i + 1 < dim; ++i) {
      double of_frame = 0;
      for (std::size_t k = 0; k < dim; ++k) of_frame += lean[i][k] * opened[k];
      EXPECT_NEAR(slip[i], of_frame, 1e-14);
    }
  }
}

TYPED_TEST(FacetSlipTest, GradientIsTheComplexStepOfTheSlip) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Case<TypeParam> a = random_case<TypeParam>(random);
    const auto slip = a.slip(), value = a.slip(false);
    const auto exact = by_definition(a, -1);
    double largest = 0;
    for (std::size_t i = 0; i < a.dim - 1; ++i) {
      EXPECT_NEAR(slip.value[i], exact[i].real(), 1e-14);
      EXPECT_NEAR(value.value[i], exact[i].real(), 1e-14);
      largest = std::max(largest, std::abs(slip.value[i]));
      for (std::size_t j = 0; j < a.dofs; ++j)
        EXPECT_NEAR(slip.gradient[i][j], by_definition(a, static_cast<int>(j))[i].imag() / 1e-30, 1e-13);
    }
    EXPECT_GT(largest, 1e-4);
  }
}

TYPED_TEST(FacetSlipTest, HessianIsTheDerivativeOfTheGradientAndSymmetric) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 5; ++trial) {
    Case<TypeParam> a = random_case<TypeParam>(random);
    std::array<double, a.dim> n;
    for (double& component : n) component = u(random);
    n[a.dim - 1] += 1.2;
    if (trial > 0) a.lean = lean_to<a.dim>(n, 1.3);
    std::array<double, 2> factor = {u(random), u(random)};
    std::array<Opening<a.nodes>, a.dim> opening;
    for (std::size_t e = 0; e < opening.size(); ++e)
      for (std::size_t b = 0; b < a.nodes; ++b) {
        const double part = factor[0] * a.lean[0][e] + factor[1] * a.lean[1][e];
        opening[e].D[b] = part * a.opening.D[b];
        opening[e].M[b] = part * a.opening.M[b];
      }
    std::vector<double> H(a.dofs * a.dofs);
    add_slip_hessian<a.dim, a.nodes>(a.side(0), a.side(1), a.rows, opening, H);
    double largest = 0;
    for (double h : H) largest = std::max(largest, std::abs(h));
    EXPECT_GT(largest, 1e-3);
    for (std::size_t j = 0; j < a.dofs; ++j) {
      constexpr double h = 1e-5;
      Case<TypeParam> up = a, down = a;
      up.x[j / a.dim][j % a.dim] += h;
      down.x[j / a.dim][j % a.dim] -= h;
      const auto above = up.slip(), below = down.slip();
      for (std::size_t k = 0; k < a.dofs; ++k) {
        double slope = 0;
        for (std::size_t i = 0; i < a.dim - 1; ++i)
          slope += factor[i] * (above.gradient[i][k] - below.gradient[i][k]) / (2 * h);
        EXPECT_NEAR(H[a.dofs * k + j], slope, 1e-8);
        EXPECT_NEAR(H[a.dofs * k + j], H[a.dofs * j + k], 1e-13);
      }
    }
  }
}

TYPED_TEST(FacetSlipTest, RigidMotionsDoNotSlipAndForcesBalance) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-3, 3);
  constexpr std::size_t dim = Case<TypeParam>::dim;
  for (int trial = 0; trial < 20; ++trial) {
    const Case<TypeParam> a = random_case<TypeParam>(random);
    Case<TypeParam> moved = a;
    const Vector3 axis = dim == 2 ? Vector3{0, 0, 1} : unit({u(random), u(random), u(random)});
    const double angle = u(random);
    const Vector3 by = {u(random), u(random), u(random)};
    for (auto& x : moved.x) {
      Vector3 place{};
      std::copy(x.begin(), x.end(), place.begin());
      place = rotated(axis, angle, place);
      for (std::size_t k = 0; k < dim; ++k) x[k] = place[k] + by[k];
    }
    const auto before = a.slip(), slip = moved.slip();
    for (std::size_t i = 0; i < dim - 1; ++i) {
      EXPECT_NEAR(slip.value[i], before.value[i], 1e-13);
      Vector3 force{}, moment{};
      for (std::size_t node = 0; node < 2 * a.nodes; ++node) {
        Vector3 g{}, x{};
        std::copy_n(&slip.gradient[i][dim * node], dim, g.begin());
        std::copy(moved.x[node].begin(), moved.x[node].end(), x.begin());
        const Vector3 m = cross(x, g);
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

TEST(FaceMap, MotionAlongAFlatFaceIsTheSlipWhateverTheCellsOfThePlane) {
  // A translation slips by itself times the covered integral of Phi_a, in the tangents of the node whichever
  // the directions of the face.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const int corners : {3, 4})
    for (int trial = 0; trial < 20; ++trial) {
      face_test::Pair pair = random_pair(random, corners, 4, true);
      for (Point3& x : pair.x) x[2] = 0;
      const FaceMap map = make_face_map(pair.x);
      const MortarWeights weights = mortar_weights(pair.x, pair.p, pair.face);
      const auto cover = mortar_pair(pair.x, pair.p, pair.face, false).cover;
      const FaceCorners start = pair.x;
      const Point3 by = {u(random), u(random), 0};
      for (Point3& x : pair.x)
        for (std::size_t k = 0; k < 3; ++k) x[k] += by[k];
      const Point3 n = {0, 0, 1};
      const auto turn = turned_into(map, n, tangents_of(n));
      const SlipDirections<3, 4> then(start, map.row, false), now(pair.x, map.row, false);
      for (std::size_t f = 0; f < static_cast<std::size_t>(corners); ++f) {
        const Opening<4> opening{weights.D[f], weights.M[f]};
        const Tangential before = then.slip(pair.p, opening).value, after = now.slip(pair.p, opening).value;
        std::array<double, 2> s{};
        for (std::size_t i = 0; i < 2; ++i)
          for (std::size_t e = 0; e < 2; ++e) s[i] += turn[i][e] * (after[e] - before[e]);
        EXPECT_NEAR(s[0], cover[f] * by[0], 1e-13); // tangents along x and y
        EXPECT_NEAR(s[1], cover[f] * by[1], 1e-13);
      }
    }
}

TEST(FaceMap, TangentsTurnTheShortestWayIntoAFace) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    const face_test::Pair pair = random_pair(random, 4, 4);
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
