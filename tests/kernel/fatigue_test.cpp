#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/material/crack.hpp>

using namespace impact;
using reference::aluminium;
using reference::Complex;
using reference::Matrix;
using reference::Sampler;

namespace {

template <class> struct FatigueCell : testing::Test {};
TYPED_TEST_SUITE(FatigueCell, reference::Elements);

MaterialParameters fatiguing() {
  MaterialParameters m = aluminium();
  m.fatigue_a = 5e-7;
  return m;
}

/// S_c of the undamaged body at all points, of a plain element.
template <class Cell, Frame frame>
std::vector<Matrix<double>> undamaged_stress(MaterialParameters m, const reference::CellCase<Cell, frame>& c,
                                             const double* u,
                                             const std::vector<PointHistory<double, Cell::dim>>& history) {
  m.damage = Damage::none;
  m.model = Model::elastic; // the plastic state is that of the displacement
  const auto at = reference::points<Cell, frame>(c.X);
  const reference::Point<Cell, frame> centre(c.X, Cell::centroid(), 1);
  const double J_0 = reference::det(centre.template F<double>(u));
  const std::vector<double> p_mean = reference::shared_pressure(m, c, at, u, false);
  std::vector<Matrix<double>> S;
  for (unsigned k = 0; k < at.size(); ++k) {
    const auto& q = at[k];
    const Matrix<double> F = q.template F<double>(u), Fi = reference::inverse(F);
    const double J = reference::det(F), J_th = reference::J_theta(m, q.at(c.theta));
    Matrix<double> tau = reference::return_map(m, F, reference::dense<Cell::dim>(history[k].A), 0, 0.0).s;
    double p = p_mean[k];
    if (m.locking == Locking::none) p = reference::pressure(m, J, J_th, 0.0);
    if (m.locking == Locking::fbar) {
      for (double& x : tau) x *= J / J_0;
      p = reference::pressure(m, J_0, J_th, 0.0);
    }
    for (unsigned i = 0; i < 3; ++i) tau[4 * i] += p * J;
    S.push_back(reference::multiply(reference::multiply(Fi, tau), reference::transpose(Fi)));
  }
  return S;
}

} // namespace

TYPED_TEST(FatigueCell, GrowthIsThatOfThePlainElement) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int d = Cell::dim, size = history_size(frame);
  using History = std::vector<PointHistory<double, d>>;
  Sampler random(61);
  int negative = 0;
  for (int k = 0; k < 18; ++k) {
    MaterialParameters m = fatiguing();
    m.locking = k % 3 == 0 ? Locking::none : k % 3 == 1 ? Locking::mean : Locking::fbar;
    m.b_d = k % 2 ? 1e4 : 0;
    m.visc_degrade = k % 4 == 3;
    m.split = k % 5 ? Split::volumetric : Split::none;
    const double dt = 1e-3;
    const auto cases = reference::cases<Cell, frame>(random, 0.01);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch history_n[Cell::points * size], old[Cell::points], grown[Cell::points];
    History before[lanes];
    for (int l = 0; l < lanes; ++l)
      for (int q = 0; q < Cell::points; ++q) {
        before[l].push_back(random.template history<d>(0.005));
        for (int i = 0; i < symmetric_size(d); ++i) history_n[q * size + i].set(l, before[l].back().A[i]);
        history_n[q * size + size - 1].set(l, before[l].back().alpha);
        old[q].set(l, random.uniform(0, 500));
      }
    FatigueInput in;
    in.X = batch.X, in.u = batch.u, in.u_n = batch.u_n, in.phi = batch.phi;
    in.theta = in.theta_n = batch.theta;
    in.history = batch.history, in.history_n = history_n, in.fatigue_n = old, in.dt = dt;
    FatigueSums sums;
    EXPECT_EQ((kernels<Cell, frame>().fatigue_advance(PointLaw{m}, in, grown, sums)), 0);
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      const auto S = undamaged_stress(m, c, c.u, History(c.history, c.history + Cell::points));
      const auto S_n = undamaged_stress(m, c, c.u_n, before[l]);
      double lost = 0;
      unsigned p = 0;
      for (const auto& q : reference::points<Cell, frame>(c.X)) {
        const auto C = reference::right_cauchy_green(q.template F<double>(c.u)),
                   C_n = reference::right_cauchy_green(q.template F<double>(c.u_n));
        const double phi = q.at(c.phi), b = m.b_d * (m.visc_degrade ? reference::g_e1(m, phi) : 1);
        double work = 0;
        for (unsigned i = 0; i < 9; ++i)
          work += (0.25 * (S[p][i] + S_n[p][i]) + b / dt * (C[i] - C_n[i])) * (C[i] - C_n[i]);
        negative += work < 0;
        const double active = std::fmax(phi, 0); // a parabola may fall below
        const double growth = m.fatigue_a / m.gamma * (1 - phi) * active * std::fabs(work);
        EXPECT_NEAR(grown[p][l] - old[p][l], growth, 1e-9 * growth + 1e-12 * old[p][l]);
        lost += q.weight * active / m.gamma * growth;
        ++p;
      }
      EXPECT_NEAR(sums.dissipation[l], lost, 1e-9 * lost);
      EXPECT_EQ(sums.least[l], 0);
    }
  }
  EXPECT_GT(negative, 10);
}

TYPED_TEST(FatigueCell, EnergyAndHeatAreThoseOfThePotential) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int n = Cell::nodes;
  Sampler random(62);
  MaterialParameters m = fatiguing();
  m.c_v = 2.43e6;
  for (const HeatForm form : {HeatForm::entropy, HeatForm::energy}) {
    const auto cases = reference::cases<Cell, frame>(random, 0.01);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch phi_n[n], now[Cell::points], old[Cell::points], points[Cell::points * heat_point_size];
    double before[lanes][n];
    for (int l = 0; l < lanes; ++l) {
      for (int a = 0; a < n; ++a) phi_n[a].set(l, before[l][a] = random.uniform(0, 0.5));
      for (int q = 0; q < Cell::points; ++q) {
        old[q].set(l, random.uniform(0, 300));
        now[q].set(l, old[q][l] + random.uniform(0, 100));
      }
    }
    HeatInput in;
    in.X = batch.X, in.u = batch.u, in.u_n = batch.u_n, in.phi = batch.phi, in.phi_n = phi_n;
    in.theta = in.theta_n = batch.theta, in.history = in.history_n = batch.history;
    in.form = form, in.dt = 1e-3;
    Batch with[n], without[n];
    for (int a = 0; a < n; ++a) with[a] = without[a] = 0.0;
    EXPECT_EQ((kernels<Cell, frame>().heat_step(PointLaw{m}, in, points, without)), 0);
    in.fatigue = now, in.fatigue_n = old;
    EXPECT_EQ((kernels<Cell, frame>().heat_step(PointLaw{m}, in, points, with)), 0);
    EnergyInput stored;
    stored.X = batch.X, stored.u = batch.u, stored.phi = batch.phi, stored.history = batch.history;
    stored.fatigue = now;
    EnergySums sums;
    kernels<Cell, frame>().stored_energy(PointLaw{m}, stored, sums);
    const Batch total = kernels<Cell, frame>().cell_integral(batch.X, now);
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      double expected[n] = {}, scale = 0, energy = 0, integral = 0;
      int p = 0;
      for (const auto& q : reference::points<Cell, frame>(c.X)) {
        const double phi = q.at(c.phi), f = now[p][l], f_n = old[p][l];
        const double local = form == HeatForm::energy ? (-f * phi + f_n * q.at(before[l])) / m.gamma
                                                      : -(f - f_n) * phi / m.gamma;
        for (int a = 0; a < n; ++a) expected[a] += q.N[a] * q.weight * local;
        energy -= q.weight * f * phi / m.gamma;
        integral += q.weight * f;
        ++p;
      }
      for (int a = 0; a < n; ++a)
        scale = std::fmax(scale, std::fmax(std::fabs(without[a][l]), std::fabs(with[a][l])));
      for (int a = 0; a < n; ++a) EXPECT_NEAR(with[a][l] - without[a][l], expected[a], 1e-12 * scale);
      EXPECT_NEAR(sums.fatigue[l], energy, 1e-12 * std::fabs(energy));
      EXPECT_NEAR(total[l], integral, 1e-12 * total[l]);
    }
  }
}

TEST(Fatigue, DriveIsTheDerivativeOfTheEnergyAndGrowthLosesWhatTheEnergyGives) {
  const MaterialParameters m = fatiguing();
  for (const double phi : {-0.1, 0.0, 0.05, 0.5, 0.97, 1.0, 1.2}) {
    const double fatigue = 321, growth = fatigue_growth(m, phi, -2e5), inside = phi > 0 && phi < 1 ? 1 : 0;
    const Complex slope = fatigue_energy(m, Complex(phi, 1e-30), Complex(fatigue)) / 1e-30;
    EXPECT_NEAR(slope.imag(), -inside * fatigue / m.gamma, 1e-12 * fatigue / m.gamma) << phi;
    EXPECT_EQ(growth > 0, inside > 0) << phi; // neither sound nor broken material tires
    EXPECT_EQ(growth, fatigue_growth(m, phi, 2e5));
    const double lost = fatigue_dissipation(m, phi, growth);
    EXPECT_GE(lost, 0);
    EXPECT_NEAR(fatigue_energy(m, phi, fatigue + growth) - fatigue_energy(m, phi, fatigue), -lost,
                1e-9 * lost);
  }
}

TEST(Fatigue, WorkOfAStepIsTheChangeOfTheElasticEnergyToThirdOrder) {
  MaterialParameters m = fatiguing();
  m.model = Model::elastic;
  const double x[8] = {0, 0, 1, 0, 1, 1, 0, 1};
  double error[3];
  for (int k = 0; k < 3; ++k) {
    const double step = 0.02 / (1 << k);
    Batch X[8], u[8], u_n[8], phi[4], none[4], grown[4];
    for (int i = 0; i < 8; ++i) {
      const double stretch = i % 2 == 0 ? x[i] : 0.3 * x[i - 1] - 0.2 * x[i];
      X[i] = x[i], u_n[i] = 0.01 * stretch, u[i] = (0.01 + step) * stretch;
    }
    for (int a = 0; a < 4; ++a) phi[a] = 0.5, none[a] = 0.0;
    FatigueInput in;
    in.X = X, in.u = u, in.u_n = u_n, in.phi = phi, in.fatigue_n = none;
    FatigueSums sums;
    kernels<Quad4, Frame::plane_strain>().fatigue_advance(PointLaw{m}, in, grown, sums);
    EnergySums now, before;
    EnergyInput at;
    at.X = X, at.u = u;
    kernels<Quad4, Frame::plane_strain>().stored_energy(PointLaw{m}, at, now);
    at.u = u_n;
    kernels<Quad4, Frame::plane_strain>().stored_energy(PointLaw{m}, at, before);
    const double work = grown[0][0] / (m.fatigue_a / m.gamma * 0.25);
    error[k] = std::fabs(work - (now.elastic[0] - before.elastic[0]));
    EXPECT_LT(error[k], 0.02 * work);
  }
  EXPECT_NEAR(error[0] / error[1], 8, 1);
  EXPECT_NEAR(error[1] / error[2], 8, 0.5);
}
