#include "reference_cell.hpp"

#include <gtest/gtest.h>

using namespace impact;
using reference::aluminium;
using reference::Complex;
using reference::Sampler;

namespace {

template <class> struct Motion : testing::Test {};
TYPED_TEST_SUITE(Motion, reference::Elements);

/// The displacement of the cell with a complex step in dof k.
template <class Case> std::vector<Complex> complex_u(const Case& c, int k) {
  std::vector<Complex> u(c.u, c.u + Case::dofs);
  u[unsigned(k)] += Complex(0, reference::step);
  return u;
}

double largest(const std::vector<double>& x) {
  double m = 0;
  for (double v : x) m = std::fmax(m, std::fabs(v));
  return m;
}

} // namespace

TYPED_TEST(Motion, ResidualIsThatOfThePlainElement) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim;
  Sampler random(11);
  for (int k = 0; k < 80; ++k) {
    const PointLaw law{reference::every_option(k)};
    const auto cases = reference::cases<Cell, frame>(random, k % 2 ? 0.03 : 0.003);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs];
    for (auto& x : r) x = 1.0; // the kernel adds
    const CellStatus status = kernels<Cell, frame>().motion_residual(law, batch.input(cases[0].dt), r);
    EXPECT_EQ(status.bad, 0);
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      const auto f = reference::force(law.parameters, c, std::vector<double>(c.u, c.u + dofs));
      for (int i = 0; i < dofs; ++i) EXPECT_NEAR(r[i][l] - 1, f[unsigned(i)], 1e-11 * largest(f) + 1e-9);
    }
  }
}

// every locking cure, frame and split; elastic and flowing
TYPED_TEST(Motion, TangentIsTheComplexStepOfTheForce) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim;
  Sampler random(12);
  for (int k = 0; k < (250 + lanes - 1) / lanes * 4; ++k) { // 1000 cells
    const PointLaw law{reference::every_option(k)};
    const auto cases = reference::cases<Cell, frame>(random, k % 2 ? 0.03 : 0.003);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs], K[dofs * dofs], only[dofs];
    for (auto& x : r) x = 0.0;
    for (auto& x : only) x = 0.0;
    for (auto& x : K) x = 0.0;
    kernels<Cell, frame>().motion_tangent(law, batch.input(cases[0].dt), r, K);
    kernels<Cell, frame>().motion_residual(law, batch.input(cases[0].dt), only);
    for (int l = 0; l < lanes; ++l) {
      std::vector<double> exact(unsigned(dofs * dofs));
      // A third of the columns of a larger cell, which the cells of a batch share; a ninth of the largest
      // ones', which three batches do.
      constexpr int columns = dofs > 48 ? 9 : dofs > 12 ? 3 : 1;
      const int first = (l + lanes * k) % columns;
      for (int j = first; j < dofs; j += columns) {
        const auto f = reference::force(law.parameters, cases[unsigned(l)], complex_u(cases[unsigned(l)], j));
        for (int i = 0; i < dofs; ++i)
          exact[unsigned(i * dofs + j)] = f[unsigned(i)].imag() / reference::step;
      }
      double worst = 0;
      for (int i = 0; i < dofs; ++i)
        for (int j = first; j < dofs; j += columns)
          worst = std::fmax(worst, std::fabs(K[i * dofs + j][l] - exact[unsigned(i * dofs + j)]));
      EXPECT_LT(worst, 1e-10 * largest(exact)) << "option " << k;
      for (int i = 0; i < dofs; ++i) EXPECT_NEAR(r[i][l], only[i][l], 1e-12 * largest(exact) * 1e-3);
    }
  }
}

// the kernels are compiled for elastic, undamaged and all laws: a parameter that one of them forgot shows
// here
TYPED_TEST(Motion, MaterialWithoutDamageIsDamageableMaterialAtZeroDamage) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, values = Cell::points * history_size(frame);
  Sampler random(21);
  for (int k = 0; k < 24; ++k) {
    MaterialParameters m = reference::every_option(k);
    m.model = k % 2 ? Model::j2 : Model::elastic;
    m.b_d = 0;
    m.linear_h = 3e8;
    m.taylor_quinney = 0.7;
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    struct Result {
      Batch r[dofs], K[dofs * dofs], history[values], drive[Cell::points * drive_size];
      StepSums sums;
    } with, without;
    const auto evaluate = [&](Damage damage, Result& out) {
      m.damage = damage;
      const PointLaw law{m};
      Batch phi[Cell::nodes];
      for (Batch& x : phi) x = 0.0;
      MotionInput in = batch.input(1);
      in.phi = damage == Damage::none ? nullptr : phi;
      in.theta = nullptr;
      in.accel = batch.accel;
      in.mass_shift = 1e9;
      in.symmetric = k % 4 < 2;
      for (Batch& x : out.r) x = 0.0;
      kernels<Cell, frame>().motion_tangent(law, in, out.r, out.K);
      kernels<Cell, frame>().motion_advance(law, in, out.history, out.drive, out.sums, {});
    };
    evaluate(Damage::at2, with);
    evaluate(Damage::none, without);
    const auto expect_equal = [&](const Batch* a, const Batch* b, int n) {
      double size = 0;
      for (int i = 0; i < n; ++i) size = std::fmax(size, std::fabs(b[i][0]));
      for (int i = 0; i < n; ++i)
        for (int l = 0; l < lanes; ++l) EXPECT_NEAR(a[i][l], b[i][l], 1e-12 * size) << "option " << k;
    };
    expect_equal(without.r, with.r, dofs);
    expect_equal(without.K, with.K, dofs * dofs);
    expect_equal(without.history, with.history, values);
    expect_equal(without.drive, with.drive, Cell::points * drive_size);
    expect_equal(&without.sums.plastic_dissipation, &with.sums.plastic_dissipation, 1);
    expect_equal(&without.sums.plastic_work, &with.sums.plastic_work, 1);
    EXPECT_EQ(with.sums.plastic_work[0] > 0, m.model == Model::j2);
  }
}

TYPED_TEST(Motion, SymmetricTangentIsTheSymmetricPart) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim;
  Sampler random(13);
  double defect = 0;
  for (int k = 0; k < 12; ++k) {
    const PointLaw law{reference::every_option(k)};
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs], K[dofs * dofs], S[dofs * dofs];
    for (auto& x : r) x = 0.0;
    for (int i = 0; i < dofs * dofs; ++i) K[i] = S[i] = 0.0;
    MotionInput in = batch.input(cases[0].dt);
    kernels<Cell, frame>().motion_tangent(law, in, r, K);
    in.symmetric = true;
    kernels<Cell, frame>().motion_tangent(law, in, r, S);
    double size = 0;
    for (int i = 0; i < dofs * dofs; ++i) size = std::fmax(size, std::fabs(K[i][0]));
    for (int i = 0; i < dofs; ++i)
      for (int j = 0; j < dofs; ++j) {
        EXPECT_NEAR(S[i * dofs + j][0], 0.5 * (K[i * dofs + j][0] + K[j * dofs + i][0]), 1e-12 * size);
        defect = std::fmax(defect, std::fabs(K[i * dofs + j][0] - K[j * dofs + i][0]) / size);
      }
  }
  EXPECT_GT(defect, 1e-4); // the flowing tangent is unsymmetric, so that the option does something
}

// at fixed random history; viscous potential and crack energy too
TYPED_TEST(Motion, ElasticForceIsTheDerivativeOfTheEnergy) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim;
  Sampler random(14);
  for (int k = 0; k < 40; ++k) {
    MaterialParameters m = reference::every_option(2 * k);
    if (m.locking == Locking::fbar) m.locking = Locking::none;
    m.sigma_y = 1e15;
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch r[dofs], K[dofs * dofs];
    for (auto& x : r) x = 0.0;
    for (auto& x : K) x = 0.0;
    kernels<Cell, frame>().motion_tangent(PointLaw{m}, batch.input(cases[0].dt), r, K);
    double size = 0;
    for (auto& x : K) size = std::fmax(size, std::fabs(x[0]));
    for (int i = 0; i < dofs; ++i)
      for (int j = 0; j < i; ++j) EXPECT_NEAR(K[i * dofs + j][0], K[j * dofs + i][0], 1e-13 * size);
    for (int l = 0; l < lanes; ++l) {
      std::vector<double> f(unsigned(dofs), 0.0);
      for (int i = 0; i < dofs; ++i)
        f[unsigned(i)] = reference::energy(m, cases[unsigned(l)], complex_u(cases[unsigned(l)], i)).imag() /
                         reference::step;
      for (int i = 0; i < dofs; ++i) EXPECT_NEAR(r[i][l], f[unsigned(i)], 1e-11 * largest(f));
    }
  }
}

TYPED_TEST(Motion, InertiaIsTheConsistentMass) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(15);
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  m.damage = Damage::none;
  const auto cases = reference::cases<Cell, frame>(random, 0.0);
  const reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1);
  in.theta = nullptr;
  Batch r[dofs], K[dofs * dofs], zero[dofs], without[dofs * dofs];
  for (int i = 0; i < dofs; ++i) r[i] = zero[i] = 0.0;
  for (int i = 0; i < dofs * dofs; ++i) K[i] = without[i] = 0.0;
  in.u = zero;
  Batch unused[dofs];
  for (auto& x : unused) x = 0.0;
  kernels<Cell, frame>().motion_tangent(PointLaw{m}, in, unused, without);
  in.accel = batch.accel;
  in.mass_shift = 7e9;
  kernels<Cell, frame>().motion_tangent(PointLaw{m}, in, r, K);
  for (int l = 0; l < lanes; ++l) {
    const auto& c = cases[unsigned(l)];
    const auto at = reference::points<Cell, frame>(c.X);
    double size = 0;
    for (int i = 0; i < dofs * dofs; ++i) size = std::fmax(size, std::fabs(K[i][l]));
    for (int a = 0; a < Cell::nodes; ++a)
      for (int i = 0; i < dim; ++i) {
        double f = 0;
        for (int b = 0; b < Cell::nodes; ++b) {
          double mass = 0;
          for (const auto& q : at) mass += q.weight * m.rho * q.N[a] * q.N[b];
          f += mass * c.accel[b * dim + i];
          for (int j = 0; j < dim; ++j) {
            const int entry = (a * dim + i) * dofs + b * dim + j;
            EXPECT_NEAR(K[entry][l] - without[entry][l], i == j ? 7e9 * mass : 0, 1e-13 * size);
          }
        }
        EXPECT_NEAR(r[a * dim + i][l], f, 1e-12 * std::fabs(f) + 1e-10);
      }
  }
}

// Beyond 1 - s eta = 0, at J = 0.253, numbers are finite again, and wrong.
TYPED_TEST(Motion, CellBeyondTheEndOfItsEquationOfStateIsBroken) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, dim = Cell::dim;
  Sampler random(16);
  for (const Locking locking : {Locking::none, Locking::mean, Locking::fbar}) {
    MaterialParameters m = aluminium();
    m.model = Model::elastic, m.damage = Damage::none, m.locking = locking;
    reference::set_state(m, false);
    const reference::CellBatch<Cell, frame> batch(reference::cases<Cell, frame>(random, 0.0));
    MotionInput in = batch.input(1);
    in.theta = nullptr;
    Batch r[dofs], u[dofs];
    in.u = u;
    for (const double eta : {0.74, 0.76}) {
      for (int i = 0; i < dofs; ++i) r[i] = 0.0, u[i] = i % dim == dim - 1 ? -eta * batch.X[i] : Batch(0.0);
      const CellStatus status = kernels<Cell, frame>().motion_residual(PointLaw{m}, in, r);
      EXPECT_EQ(status.bad, eta < 0.75 ? 0 : (1 << lanes) - 1);
      EXPECT_NEAR(status.min_J[0], 1 - eta, 1e-12);
    }
  }
}
