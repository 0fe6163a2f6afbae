#include "dense_matrix.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <impact/math/eigen.hpp>

using namespace impact;
using reference::dense;
using reference::Matrix;

namespace {

/// Largest error of a = sum value_i n_i (x) n_i and of n_i . n_j = delta_ij.
template <int d> void expect_decomposes(const Symmetric<double, d>& a, double tolerance) {
  const EigenSystem<double> e = eigen_system(a);
  const Matrix<double> m = dense<d>(a);
  double size = 0;
  for (double x : m) size = std::fmax(size, std::fabs(x));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0, product = 0;
      for (int k = 0; k < 3; ++k) {
        sum += e.value[k] * e.vector[k][i] * e.vector[k][j];
        product += e.vector[i][k] * e.vector[j][k];
      }
      EXPECT_NEAR(sum, m[unsigned(3 * i + j)], tolerance * size);
      EXPECT_NEAR(product, i == j, tolerance);
    }
}

} // namespace

TEST(Eigen, DecomposesAnySymmetricTensor) {
  reference::TensorSampler random(61);
  for (int k = 0; k < 500; ++k) {
    Symmetric<double, 3> a;
    Symmetric<double, 2> b;
    for (int i = 0; i < 6; ++i) a[i] = random.uniform(-1, 1);
    for (int i = 0; i < 4; ++i) b[i] = random.uniform(-1, 1);
    expect_decomposes(a, 3e-15);
    expect_decomposes(b, 3e-15);
  }
}

TEST(Eigen, EqualAndNearlyEqualValuesLoseNothing) {
  reference::TensorSampler random(62);
  for (const double gap : {0.0, 1e-16, 1e-12, 1e-8, 1e-4})
    for (int k = 0; k < 50; ++k) { // R diag(1, 1 + gap, x) R^T
      const Matrix<double> F = dense<3>(random.gradient<3>(1));
      Symmetric<double, 3> noise;
      for (int i = 0; i < 6; ++i) noise[i] = F[unsigned(i)];
      const EigenSystem<double> R = eigen_system(noise);
      const double value[3] = {1, 1 + gap, random.uniform(-2, 2)};
      Symmetric<double, 3> a;
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) {
          double s = 0;
          for (int n = 0; n < 3; ++n) s += value[n] * R.vector[n][i] * R.vector[n][j];
          a[symmetric_index(3, i, j)] = s;
        }
      expect_decomposes(a, 5e-15);
    }
  expect_decomposes(identity<double, 3>(), 0);
  expect_decomposes(Symmetric<double, 3>{{0, 0, 0, 0, 0, 0}}, 0);
  expect_decomposes(Symmetric<double, 2>{{1, 1, 1, 1e-20}}, 1e-15);
}
