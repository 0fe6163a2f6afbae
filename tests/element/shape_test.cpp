#include <cmath>
#include <gtest/gtest.h>
#include <impact/element/shape.hpp>

using namespace impact;

namespace {

template <class Cell> struct Shapes : testing::Test {};
using Cells = testing::Types<Tri3, Quad4, Tet4, Hex8>;
TYPED_TEST_SUITE(Shapes, Cells);

/// Integral of x^a y^b z^c over the reference cell.
double exact_moment(Shape s, const int (&power)[3]) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  if (s == Shape::tri3) return factorial(power[0]) * factorial(power[1]) / factorial(power[0] + power[1] + 2);
  if (s == Shape::tet4)
    return factorial(power[0]) * factorial(power[1]) * factorial(power[2]) /
           factorial(power[0] + power[1] + power[2] + 3);
  double m = 1;
  for (int i = 0; i < dimension(s); ++i) m *= power[i] % 2 ? 0 : 2.0 / (power[i] + 1);
  return m;
}

} // namespace

TYPED_TEST(Shapes, ShapeFunctionsSumToOneAndInterpolateTheNodes) {
  const auto& t = shape_table<TypeParam>;
  for (int q = 0; q < TypeParam::points; ++q) {
    double sum = 0, derivative[3] = {0, 0, 0};
    for (int a = 0; a < TypeParam::nodes; ++a) {
      sum += t.N[q][a];
      for (int i = 0; i < TypeParam::dim; ++i) derivative[i] += t.dN[q][a][i];
    }
    EXPECT_NEAR(sum, 1, 1e-15);
    for (double x : derivative) EXPECT_NEAR(x, 0, 1e-15);
  }
  typename TypeParam::Point node{};
  for (int a = 0; a < TypeParam::nodes; ++a) {
    if constexpr (TypeParam::nodes == TypeParam::dim + 1) {
      for (int i = 0; i < TypeParam::dim; ++i) node[unsigned(i)] = a == i + 1;
    } else {
      for (int i = 0; i < TypeParam::dim; ++i) node[unsigned(i)] = TypeParam::sign[a][i];
    }
    const auto N = TypeParam::N(node);
    for (int b = 0; b < TypeParam::nodes; ++b) EXPECT_NEAR(N[unsigned(b)], a == b, 1e-15);
  }
}

TYPED_TEST(Shapes, DerivativesAreThoseOfTheShapeFunctions) {
  const double h = 1e-4; // products of linear functions: central differences are exact
  for (int q = 0; q < TypeParam::points; ++q)
    for (int i = 0; i < TypeParam::dim; ++i) {
      auto up = TypeParam::point(q), down = up;
      up[unsigned(i)] += h;
      down[unsigned(i)] -= h;
      const auto a = TypeParam::N(up), b = TypeParam::N(down);
      for (int n = 0; n < TypeParam::nodes; ++n)
        EXPECT_NEAR((a[unsigned(n)] - b[unsigned(n)]) / (2 * h), shape_table<TypeParam>.dN[q][n][i], 1e-11);
    }
}

TYPED_TEST(Shapes, RuleIntegratesQuadraticsExactly) { // hence N_a N_b of affine cells
  for (int a = 0; a <= 2; ++a)
    for (int b = 0; a + b <= 2; ++b)
      for (int c = 0; a + b + c <= (TypeParam::dim == 3 ? 2 : a + b); ++c) {
        const int power[3] = {a, b, c};
        double sum = 0;
        for (int q = 0; q < TypeParam::points; ++q) {
          double f = TypeParam::weight(q);
          for (int i = 0; i < TypeParam::dim; ++i) f *= std::pow(TypeParam::point(q)[unsigned(i)], power[i]);
          sum += f;
        }
        EXPECT_NEAR(sum, exact_moment(TypeParam::shape, power), 1e-14) << a << b << c;
      }
}

TYPED_TEST(Shapes, VisitReachesTheShape) {
  visit(TypeParam::shape, [](auto cell) {
    EXPECT_EQ(decltype(cell)::shape, TypeParam::shape);
    EXPECT_EQ(node_count(decltype(cell)::shape), TypeParam::nodes);
    EXPECT_EQ(point_count(decltype(cell)::shape), TypeParam::points);
    EXPECT_EQ(dimension(decltype(cell)::shape), TypeParam::dim);
  });
}
