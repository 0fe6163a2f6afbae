#include "reference_cell.hpp"

#include <gtest/gtest.h>

using namespace impact;
using reference::aluminium;
using reference::Sampler;

namespace {

template <class> struct MotionInvariance : testing::Test {};
TYPED_TEST_SUITE(MotionInvariance, reference::Elements);

} // namespace

// unstressed and plastically pre-strained, with every locking cure
TYPED_TEST(MotionInvariance, RigidMotionMakesNoForce) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(16);
  const double h = 1e-3;
  for (int k = 0; k < 30; ++k) {
    MaterialParameters m = reference::every_option(k);
    m.b_d = 0;
    const PointLaw law{m};
    auto cases = reference::cases<Cell, frame>(random, 0.0, 0.0);
    // pre-strain: A = 1 and alpha > 0 rotated rigidly is free of stress
    const double angle = frame == Frame::axisymmetric ? 0 : random.uniform(-3, 3), c = std::cos(angle),
                 s = std::sin(angle);
    const double Q[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
    for (auto& cell : cases)
      for (int a = 0; a < Cell::nodes; ++a) {
        cell.theta[a] = m.theta0;
        cell.phi[a] = 0.4; // uniform: no crack stress
        for (int i = 0; i < dim; ++i) {
          cell.u[a * dim + i] = (frame == Frame::axisymmetric && i == 0 ? 0 : 0.7 * h) - cell.X[a * dim + i];
          for (int j = 0; j < dim; ++j) cell.u[a * dim + i] += Q[i][j] * cell.X[a * dim + j];
        }
      }
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs];
    for (auto& x : r) x = 0.0;
    const auto status = kernels<Cell, frame>().motion_residual(law, batch.input(1), r);
    EXPECT_EQ(status.bad, 0);
    const double bound = 1e-10 * 72e9 * h * (dim == 2 ? 1 : h);
    for (auto& x : r)
      for (int l = 0; l < lanes; ++l) EXPECT_NEAR(x[l], 0, bound);
    EXPECT_NEAR(status.min_J[0], 1, 1e-12);
  }
}

TYPED_TEST(MotionInvariance, RotatingAPlasticallyStrainedCellTurnsItsForceAndNothingElse) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  const double angle =
      frame == Frame::axisymmetric ? 0 : 2.1; // there only translations along the axis are rigid
  Sampler random(17);
  double dissipated = 0;
  for (int k = 0; k < 30; ++k) {
    MaterialParameters m = reference::every_option(k);
    m.b_d = 0;
    const PointLaw law{m};
    auto cases = reference::cases<Cell, frame>(random, 0.03, 0.0);
    const reference::CellBatch<Cell, frame> before(cases);
    constexpr int points = Cell::points, size = history_size(frame);
    Batch committed[points * size], again[points * size], drive[points * drive_size],
        turned_drive[points * drive_size];
    StepSums sums, more;
    MotionInput in = before.input(1);
    kernels<Cell, frame>().motion_advance(law, in, committed, drive, sums, {});
    Batch r[dofs], turned[dofs];
    for (int i = 0; i < dofs; ++i) r[i] = turned[i] = 0.0;
    in.history = committed;
    kernels<Cell, frame>().motion_residual(law, in, r);

    const double c = std::cos(angle), s = std::sin(angle), Q[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
    for (auto& cell : cases)
      for (int a = 0; a < Cell::nodes; ++a) {
        double x[3] = {0, 0, 0};
        for (int i = 0; i < dim; ++i)
          for (int j = 0; j < dim; ++j) x[i] += Q[i][j] * (cell.X[a * dim + j] + cell.u[a * dim + j]);
        for (int i = 0; i < dim; ++i) cell.u[a * dim + i] = x[i] - cell.X[a * dim + i] + (i == 1 ? 3e-3 : 0);
      }
    const reference::CellBatch<Cell, frame> after(cases);
    in.u = after.u;
    kernels<Cell, frame>().motion_residual(law, in, turned);
    kernels<Cell, frame>().motion_advance(law, in, again, turned_drive, more, {});
    double force = 0;
    for (auto& x : r) force = std::fmax(force, std::fabs(x[0]));
    for (int a = 0; a < Cell::nodes; ++a)
      for (int i = 0; i < dim; ++i) {
        double expected = 0;
        for (int j = 0; j < dim; ++j) expected += Q[i][j] * r[a * dim + j][0];
        EXPECT_NEAR(turned[a * dim + i][0], expected, 1e-11 * force);
      }
    for (int i = 0; i < points * size; ++i) EXPECT_NEAR(again[i][0], committed[i][0], 1e-12);
    for (int i = 0; i < points * drive_size; ++i)
      EXPECT_NEAR(turned_drive[i][0], drive[i][0], 1e-11 * m.K * 1e-3);
    EXPECT_NEAR(more.plastic_dissipation[0], 0, 1e-9 * sums.plastic_dissipation[0]);
    dissipated += sums.plastic_dissipation[0];
  }
  EXPECT_GT(dissipated, 0);
}

// sum of forces zero; in the plane and in space the sum of moments x cross f too
TYPED_TEST(MotionInvariance, NodalForcesBalance) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(18);
  for (int k = 0; k < 20; ++k) {
    const PointLaw law{reference::every_option(k)};
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs];
    for (auto& x : r) x = 0.0;
    kernels<Cell, frame>().motion_residual(law, batch.input(cases[0].dt), r);
    double size = 0, moment = 0;
    for (auto& x : r) size = std::fmax(size, std::fabs(x[0]));
    for (int i = frame == Frame::axisymmetric ? 1 : 0; i < dim; ++i) {
      double sum = 0;
      for (int a = 0; a < Cell::nodes; ++a) sum += r[a * dim + i][0];
      EXPECT_NEAR(sum, 0, 1e-12 * size);
    }
    if (frame == Frame::axisymmetric) continue;
    for (int a = 0; a < Cell::nodes; ++a) {
      const double x = cases[0].X[a * dim] + cases[0].u[a * dim],
                   y = cases[0].X[a * dim + 1] + cases[0].u[a * dim + 1];
      moment += x * r[a * dim + 1][0] - y * r[a * dim][0];
    }
    EXPECT_NEAR(moment, 0, 1e-12 * size * 1e-3);
  }
}

// patch identity
TYPED_TEST(MotionInvariance, UniformGradientGivesTheSameForceWithEveryLockingCure) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(19);
  auto cases = reference::cases<Cell, frame>(random, 0.0, 0.0);
  for (auto& cell : cases)
    for (int a = 0; a < Cell::nodes; ++a) {
      cell.phi[a] = 0.2;
      cell.theta[a] = 310;
      for (int i = 0; i < dim; ++i) { // axisymmetric: u_R = c R keeps F_33 uniform
        cell.u[a * dim + i] = 0.02 * (i + 1) * cell.X[a * dim + i];
        if (i == 1 || frame != Frame::axisymmetric)
          cell.u[a * dim + i] += 0.01 * cell.X[a * dim + (i + 1) % dim];
      }
    }
  const reference::CellBatch<Cell, frame> batch(cases);
  MaterialParameters m = aluminium();
  Batch r[3][dofs];
  for (int k = 0; k < 3; ++k) {
    m.locking = k == 0 ? Locking::none : k == 1 ? Locking::mean : Locking::fbar;
    for (auto& x : r[k]) x = 0.0;
    MotionInput in = batch.input(1);
    std::vector<Batch> virgin(unsigned(Cell::points * history_size(frame)));
    for (int q = 0; q < Cell::points; ++q)
      static_cast<PointHistory<Batch, dim>&>(history_at<frame>(virgin.data(), q)) =
          virgin_history<Batch, dim>();
    in.history = virgin.data();
    kernels<Cell, frame>().motion_residual(PointLaw{m}, in, r[k]);
  }
  double size = 0;
  for (auto& x : r[0]) size = std::fmax(size, std::fabs(x[0]));
  for (int i = 0; i < dofs; ++i)
    for (int k = 1; k < 3; ++k) EXPECT_NEAR(r[k][i][0], r[0][i][0], 1e-12 * size);
}

TYPED_TEST(MotionInvariance, BadLanesAreNamedAndLeaveTheOthersAlone) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(20);
  auto cases = reference::cases<Cell, frame>(random, 0.01);
  const reference::CellBatch<Cell, frame> good(cases);
  for (int a = 0; a < Cell::nodes; ++a) // lane 1 is turned inside out
    cases[1].u[a * dim + dim - 1] = -2 * cases[1].X[a * dim + dim - 1];
  cases[2].u[0] = std::nan("");
  const reference::CellBatch<Cell, frame> batch(cases);
  const PointLaw law{aluminium()};
  Batch r[dofs], K[dofs * dofs], expected[dofs];
  for (int i = 0; i < dofs; ++i) r[i] = expected[i] = 0.0;
  for (auto& x : K) x = 0.0;
  EXPECT_EQ((kernels<Cell, frame>().motion_residual(law, good.input(1), expected).bad), 0);
  const CellStatus status = kernels<Cell, frame>().motion_tangent(law, batch.input(1), r, K);
  EXPECT_EQ(status.bad, 2 | 4);
  EXPECT_LT(status.min_J[1], 0);
  double size = 0;
  for (auto& x : expected) size = std::fmax(size, std::fabs(x[0]));
  for (int i = 0; i < dofs; ++i) EXPECT_NEAR(r[i][0], expected[i][0], 1e-12 * size);
  Batch trial[Cell::points * history_size(frame)], drive[Cell::points * drive_size];
  StepSums sums;
  EXPECT_EQ((kernels<Cell, frame>().motion_advance(law, batch.input(1), trial, drive, sums, {}).bad), 2 | 4);
}
