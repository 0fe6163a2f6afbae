#include <cmath>
#include <gtest/gtest.h>
#include <impact/element/cells.hpp>

using namespace impact;

namespace {

template <class Cell> struct Shapes : testing::Test {};
using Cells = testing::Types<Tri3, Quad4, Tet4, Hex8>;
TYPED_TEST_SUITE(Shapes, Cells);

/// Integral of x^a y^b z^c over the reference cell.
template <class Cell> double exact_moment(const int (&power)[3]) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  if (Cell::nodes == Cell::dim + 1)
    return factorial(power[0]) * factorial(power[1]) * factorial(power[2]) /
           factorial(power[0] + power[1] + power[2] + Cell::dim);
  double m = 1;
  for (int i = 0; i < Cell::dim; ++i) m *= power[i] % 2 ? 0 : 2.0 / (power[i] + 1);
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
        EXPECT_NEAR(sum, exact_moment<TypeParam>(power), 1e-14) << a << b << c;
      }
}

// What a mesh and its files take for a facet: its nodes lie on one side of the cell and every other node on
// the other.
TYPED_TEST(Shapes, FacetsHaveTheirNormalsOutward) {
  using Cell = TypeParam;
  const auto place = [](int node) {
    std::array<double, 3> x{};
    for (unsigned i = 0; i < Cell::dim; ++i)
      if constexpr (Cell::nodes == Cell::dim + 1)
        x[i] = node == int(i) + 1;
      else
        x[i] = Cell::sign[node][i];
    return x;
  };
  for (const CellFacet& facet : Cell::facets) {
    const auto a = place(facet[0]), b = place(facet[1]), c = Cell::dim == 3 ? place(facet[2]) : a;
    std::array<double, 3> n = {b[1] - a[1], a[0] - b[0], 0};
    if (Cell::dim == 3)
      for (unsigned i = 0; i < 3; ++i) {
        const unsigned j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = (b[j] - a[j]) * (c[k] - a[k]) - (b[k] - a[k]) * (c[j] - a[j]);
      }
    int inside = 0;
    for (int node = 0; node < Cell::nodes; ++node) {
      const auto x = place(node);
      double height = 0;
      for (unsigned i = 0; i < 3; ++i) height += n[i] * (x[i] - a[i]);
      EXPECT_LE(height, 0);
      inside += height < 0;
    }
    EXPECT_EQ(inside, Cell::nodes - node_count(facet));
  }
}
