#include "reference_cell.hpp"

using namespace impact;

namespace {

template <class Cell> struct Locate : testing::Test {};
using Cells = testing::Types<Tri3, Quad4, Tet4, Hex8, Tri6, Tet10, Quad9, Hex27, Quad8, Hex20>;
TYPED_TEST_SUITE(Locate, Cells);

template <class Cell>
using Case = reference::CellCase<Cell, Cell::dim == 2 ? Frame::plane_strain : Frame::solid>;

template <class Cell> Shape shape_of() { return find_shape(Cell::dim, Cell::names.polytope, Cell::nodes); }

/// What the functions make of the nodes.
template <class Cell> std::array<double, 3> place(const double* N, const double* X) {
  std::array<double, 3> x{};
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < Cell::dim; ++i) x[unsigned(i)] += N[a] * X[a * Cell::dim + i];
  return x;
}

template <class Cell> double distance(const std::array<double, 3>& x, const std::array<double, 3>& y) {
  double square = 0;
  for (unsigned i = 0; i < Cell::dim; ++i) square += (x[i] - y[i]) * (x[i] - y[i]);
  return std::sqrt(square);
}

} // namespace

// At the nodes, and between each of them and the middle.
TYPED_TEST(Locate, FindsPointsOfTheCell) {
  reference::Sampler random{11};
  for (int trial = 0; trial < 200; ++trial) {
    const Case<TypeParam> c(random, 0, 1);
    for (int a = 0; a < TypeParam::nodes; ++a)
      for (const double part : {1.0, 0.9, 0.3}) {
        auto xi = TypeParam::centroid();
        for (unsigned k = 0; k < TypeParam::dim; ++k)
          xi[k] += part * (place_of_node<TypeParam>(unsigned(a))[k] - xi[k]);
        const auto wanted = TypeParam::N(xi);
        const auto x = place<TypeParam>(wanted.data(), c.X);
        double N[max_nodes];
        ASSERT_TRUE(locate(shape_of<TypeParam>(), c.X, x.data(), N)) << "node " << a << ", part " << part;
        for (int b = 0; b < TypeParam::nodes; ++b) EXPECT_NEAR(N[b], wanted[unsigned(b)], 1e-9);
      }
  }
}

// Newton's method may wander far outside, and end anywhere.
TYPED_TEST(Locate, WhatItFindsIsThere) {
  reference::Sampler random{12};
  int found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Case<TypeParam> c(random, 0, 1);
    for (int k = 0; k < 200; ++k) {
      const double reach = k % 2 ? 10 : 1;
      std::array<double, 3> x{};
      for (unsigned i = 0; i < TypeParam::dim; ++i) x[i] = random.uniform(-reach, 1 + reach);
      double N[max_nodes];
      if (!locate(shape_of<TypeParam>(), c.X, x.data(), N)) continue;
      ++found;
      ASSERT_LT(distance<TypeParam>(place<TypeParam>(N, c.X), x), 1e-9);
    }
  }
  EXPECT_GT(found, 100);
}
