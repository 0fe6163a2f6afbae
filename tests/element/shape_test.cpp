#include <cmath>
#include <gtest/gtest.h>
#include <impact/element/second_order_products.hpp>

using namespace impact;

namespace {

template <class Cell> struct Shapes : testing::Test {};
using Cells = testing::Types<Tri3, Quad4, Tet4, Hex8, Tri6, Tet10, Quad9, Hex27, Quad8, Hex20>;
TYPED_TEST_SUITE(Shapes, Cells);

template <class Cell> constexpr int corners = Cell::nodes;
template <class Cell>
requires is_second_order<Cell>
constexpr int corners<Cell> = Cell::Corners::nodes;
template <class Cell> constexpr bool is_product = corners<Cell> == 1 << Cell::dim;

/// Integral of x^a y^b z^c over the reference cell.
template <class Cell> double exact_moment(const int (&power)[3]) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  if (!is_product<Cell>)
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
  for (int a = 0; a < TypeParam::nodes; ++a) {
    const auto N = TypeParam::N(place_of_node<TypeParam>(unsigned(a)));
    for (int b = 0; b < TypeParam::nodes; ++b) EXPECT_NEAR(N[unsigned(b)], a == b, 1e-15);
  }
}

TYPED_TEST(Shapes, DerivativesAreThoseOfTheShapeFunctions) {
  const double h = 1e-4; // at most quadratic along an axis: central differences are exact
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

TYPED_TEST(Shapes, RuleIntegratesProductsOfTwoShapeFunctionsExactly) { // of affine cells
  constexpr int degree = is_second_order<TypeParam> ? 4 : 2;
  for (int a = 0; a <= degree; ++a)
    for (int b = 0; a + b <= degree; ++b)
      for (int c = 0; a + b + c <= (TypeParam::dim == 3 ? degree : a + b); ++c) {
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
    for (unsigned i = 0; i < Cell::dim; ++i) x[i] = place_of_node<Cell>(unsigned(node))[i];
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
    const int ends = node_count(facet), on_edges = Cell::dim == 2 ? 1 : ends,
              amid = Cell::dim == 3 && has_faces<Cell> ? 1 : 0;
    EXPECT_EQ(inside, Cell::nodes - ends - (is_second_order<Cell> ? on_edges + amid : 0));
  }
}
