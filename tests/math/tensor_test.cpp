#include "dense_matrix.hpp"

#include <gtest/gtest.h>

using namespace impact;
using reference::dense;
using reference::Matrix;
using reference::TensorSampler;

namespace {

template <int d> void compare_with_dense(unsigned number) {
  TensorSampler random(number);
  for (int trial = 0; trial < 50; ++trial) {
    const Tensor<double, d> H = random.gradient<d>(0.5), F = plus_identity(H);
    const Symmetric<double, d> A = random.unimodular<d>(0.3), B = random.unimodular<d>(0.3);
    const Matrix<double> f = dense<d>(F), a = dense<d>(A), b = dense<d>(B);
    const auto same = [](const Matrix<double>& x, const Matrix<double>& y) {
      for (unsigned i = 0; i < 9; ++i) EXPECT_NEAR(x[i], y[i], 1e-12);
    };
    EXPECT_NEAR(detm1(H), reference::det(f) - 1, 1e-14);
    EXPECT_NEAR(det(A), reference::det(a), 1e-14);
    EXPECT_NEAR(trace(A), reference::trace(a), 1e-14);
    EXPECT_NEAR(trace(F), reference::trace(f), 1e-14);
    EXPECT_NEAR(dot(A, B), reference::dot(a, b), 1e-13);
    EXPECT_NEAR(trace(dev(A)), 0, 1e-15);
    same(dense<d>(inverse(F, 1 + detm1(H))), reference::inverse(f));
    same(dense<d>(transpose(F)), reference::transpose(f));
    same(dense<d>(push(F, A)), reference::multiply(reference::multiply(f, a), reference::transpose(f)));
    Matrix<double> strain = reference::multiply(f, reference::transpose(f));
    for (unsigned i = 0; i < 3; ++i) strain[4 * i] -= 1;
    same(dense<d>(left_strain(H)), strain);
    Matrix<double> ab = reference::multiply(a, b);
    const Matrix<double> ba = reference::multiply(b, a);
    for (unsigned i = 0; i < 9; ++i) ab[i] = 0.5 * (ab[i] + ba[i]);
    same(dense<d>(product(A, B)), ab);
    const Matrix<double> cof = dense<d>(cofactor(F)),
                         back = reference::multiply(reference::transpose(f), cof);
    for (unsigned i = 0; i < 9; ++i) EXPECT_NEAR(back[i], i % 4 == 0 ? reference::det(f) : 0, 1e-13);
  }
}

} // namespace

TEST(Tensor, PlaneLayoutAgreesWithDenseMatrices) { compare_with_dense<2>(1); }
TEST(Tensor, SpatialLayoutAgreesWithDenseMatrices) { compare_with_dense<3>(2); }

TEST(Tensor, DeterminantMinusOneKeepsTheDigitsOfSmallStrains) {
  const double e = 1e-12;
  const Tensor<double, 3> H{{e, 2 * e, 0, -e, 3 * e, 0, 0, e, -e}};
  EXPECT_NEAR(detm1(H) / (3 * e), 1, 1e-10); // 1 + h loses all but 4 digits here
}
