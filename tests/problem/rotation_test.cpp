#include "../material/evaluate_point.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <impact/material/point_law.hpp>
#include <random>

// A body on its yield surface is turned: neutral loading, where the trial stress exceeds the yield stress by
// round-off.

namespace impact {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      for (unsigned k = 0; k < 3; ++k) c[i][j] += a[i][k] * b[k][j];
  return c;
}

Tensor<double, 3> gradient(const Matrix& F) {
  Tensor<double, 3> H;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) H[3 * i + j] = F[unsigned(i)][unsigned(j)] - (i == j ? 1 : 0);
  return H;
}

Matrix turn(unsigned axis, double angle) {
  Matrix Q{};
  const unsigned i = (axis + 1) % 3, j = (axis + 2) % 3;
  Q[axis][axis] = 1;
  Q[i][i] = Q[j][j] = std::cos(angle);
  Q[i][j] = -std::sin(angle);
  Q[j][i] = std::sin(angle);
  return Q;
}

TEST(Rotation, OfAPointOnTheYieldSurfaceIsNeutral) {
  MaterialParameters m;
  m.model = Model::j2;
  m.K = 175e3;
  m.G = 80.77e3;
  m.sigma_y = 400;
  m.linear_h = 1000;
  const PointLaw law{m};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(-1, 1);
  int failed = 0;
  double most = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Matrix F{};
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) F[i][j] = (i == j ? 1 : 0) + 0.05 * number(random);
    const auto first =
        evaluate(law, PointInput<double, 3>{gradient(F), virgin_history<double, 3>(), 0, 298.15});
    if (first.history.alpha == 0) continue;
    const Matrix turned = product(turn(unsigned(trial % 3), 3 * number(random)), F);
    const auto second = evaluate(law, PointInput<double, 3>{gradient(turned), first.history, 0, 298.15});
    failed += second.flow.failed != 0;
    most = std::max(most, std::abs(second.history.alpha - first.history.alpha));
  }
  EXPECT_EQ(failed, 0) << "points whose scalar equation did not converge";
  EXPECT_LT(most, 1e-14);
}

} // namespace
} // namespace impact
