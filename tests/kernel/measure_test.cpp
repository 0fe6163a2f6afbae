#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <impact/kernel/measure.hpp>

using namespace impact;
using reference::aluminium;
using reference::Sampler;

namespace {

template <class> struct Measure : testing::Test {};
TYPED_TEST_SUITE(Measure, reference::Elements);

} // namespace

TYPED_TEST(Measure, StoredEnergyIsThatOfThePlainElement) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(41);
  for (int k = 0; k < 20; ++k) {
    MaterialParameters m = aluminium();
    m.locking = k % 2 ? Locking::mean : Locking::none;
    m.split = k % 3 ? Split::volumetric : Split::none;
    m.gp = k % 5 ? PlasticDegradation::one : PlasticDegradation::ge;
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    EnergyInput in;
    in.X = batch.X, in.u = batch.u, in.v = batch.accel, in.phi = batch.phi, in.theta = batch.theta;
    in.history = batch.history;
    EnergySums sums;
    kernels<Cell, frame>().stored_energy(PointLaw{m}, in, sums);
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      const std::vector<double> u(c.u, c.u + c.dofs);
      EXPECT_NEAR((sums.elastic + sums.fracture)[l],
                  reference::energy(m, c, u) +
                      [&] { // local part of the crack energy
                        double local = 0;
                        for (const auto& q : reference::points<Cell, frame>(c.X))
                          local += q.weight * m.Gc / (2 * m.gamma) * q.at(c.phi) * q.at(c.phi);
                        return local;
                      }(),
                  1e-10 * sums.elastic[l]);
      double plastic = 0, mass = 0, kinetic = 0, momentum[3] = {0, 0, 0};
      int p = 0;
      for (const auto& q : reference::points<Cell, frame>(c.X)) {
        const double a = c.history[p++].alpha;
        const double H = m.sigma_y * a + m.voce_r * (a + (std::exp(-m.voce_s * a) - 1) / m.voce_s);
        plastic += q.weight * reference::g_p(m, q.at(c.phi)) * (1 - m.taylor_quinney) * H;
        mass += q.weight * m.rho;
        for (int i = 0; i < Cell::dim; ++i) {
          double v = 0;
          for (int b = 0; b < Cell::nodes; ++b) v += q.N[b] * c.accel[b * Cell::dim + i];
          kinetic += q.weight * m.rho / 2 * v * v;
          momentum[i] += q.weight * m.rho * v;
        }
      }
      EXPECT_NEAR(sums.plastic[l], plastic, 1e-11 * plastic);
      EXPECT_NEAR(sums.mass[l], mass, 1e-13 * mass);
      EXPECT_NEAR(sums.kinetic[l], kinetic, 1e-12 * kinetic);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(sums.momentum[i][l], momentum[i], 1e-12 * mass * 1e6);
    }
  }
}

TYPED_TEST(Measure, StepSumsAreTheDissipationsOfThePlainElement) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int d = Cell::dim;
  Sampler random(42);
  double flowed = 0;
  for (int k = 0; k < 20; ++k) {
    MaterialParameters m = aluminium();
    m.gp = k % 2 ? PlasticDegradation::one : PlasticDegradation::ge;
    m.b_d = 3e6;
    m.visc_degrade = k % 3 == 0;
    const auto cases = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch trial[Cell::points * history_size(frame)], drive[Cell::points * drive_size];
    StepSums sums;
    kernels<Cell, frame>().motion_advance(PointLaw{m}, batch.input(cases[0].dt), trial, drive, sums, {});
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      double dissipated = 0, viscous = 0, work = 0;
      int p = 0;
      for (const auto& q : reference::points<Cell, frame>(c.X)) {
        const double phi = q.at(c.phi);
        const auto F = q.F(c.u);
        const auto old = c.history[p];
        const auto flow = reference::return_map(m, F, reference::dense<d>(old.A), old.alpha, phi);
        dissipated += q.weight * reference::g_p(m, phi) * m.taylor_quinney *
                      reference::static_stress(m, flow.alpha) * (flow.alpha - old.alpha);
        const auto C = reference::right_cauchy_green(F), C_n = reference::right_cauchy_green(q.F(c.u_n));
        double square = 0, trial_W = 0, new_W = 0;
        const auto A = reference::dense<d>(old.A);
        for (unsigned i = 0; i < 9; ++i) {
          square += (C[i] - C_n[i]) * (C[i] - C_n[i]);
          trial_W += C[i] * A[i];
          new_W += C[i] * flow.A[i];
        }
        const double scale = std::pow(reference::det(C), -1.0 / 3) * m.G / 2, ge = reference::g_e1(m, phi);
        viscous += q.weight * m.b_d * (m.visc_degrade ? ge : 1) * square / c.dt;
        work += q.weight * ge * scale * (trial_W - new_W);
        EXPECT_NEAR(trial[p * history_size(frame) + history_size(frame) - 1][l], flow.alpha, 1e-13);
        for (int i = 0; i < symmetric_size(d); ++i)
          EXPECT_NEAR(trial[p * history_size(frame) + i][l], reference::symmetric<d>(flow.A)[i], 1e-12);
        const double W = scale * new_W - 1.5 * m.G,
                     E = drive[p * drive_size][l] + drive[p * drive_size + 1][l];
        const double J = reference::det(F) / reference::J_theta(m, q.at(c.theta)),
                     U = m.K / 2 * ((J * J - 1) / 2 - std::log(J));
        EXPECT_NEAR(E, W + U, 1e-10 * (W + U) + 1e-15 * m.K); // the plain formula loses digits
        EXPECT_NEAR(drive[p * drive_size + 1][l], J >= 1 ? 0 : U, 1e-10 * U + 1e-15 * m.K);
        ++p;
      }
      EXPECT_NEAR(sums.plastic_dissipation[l], dissipated, 1e-10 * dissipated);
      EXPECT_NEAR(sums.viscous_dissipation[l], viscous, 1e-11 * viscous);
      EXPECT_NEAR(sums.plastic_work[l], work, 1e-9 * work);
      flowed += dissipated;
    }
  }
  EXPECT_GT(flowed, 0);
}

TYPED_TEST(Measure, CellOutputOfAUniformStateIsThatState) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dim = Cell::dim;
  Sampler random(43);
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  auto cases = reference::cases<Cell, frame>(random, 0.0);
  for (auto& cell : cases)
    for (int a = 0; a < Cell::nodes; ++a) {
      cell.phi[a] = 0.25;
      for (int i = 0; i < dim; ++i) // axisymmetric: u_R = 0.02 R
        cell.u[a * dim + i] =
            (i == 1 ? -0.01 : 0.02) * cell.X[a * dim + i] +
            (frame == Frame::axisymmetric && i == 0 ? 0 : 0.015 * cell.X[a * dim + (i + 1) % dim]);
    }
  const reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1);
  in.theta = nullptr;
  CellOutput out;
  kernels<Cell, frame>().cell_output(PointLaw{m}, in, out);
  const auto F = reference::points<Cell, frame>(cases[0].X)[0].F(cases[0].u);
  auto sigma = reference::kirchhoff(m, F, reference::unit<double>(), 0.0, 0.25, m.theta0);
  for (double& x : sigma) x /= reference::det(F);
  const int at[6] = {0, 4, 8, 1, 5, 2};
  double size = 0;
  for (double x : sigma) size = std::fmax(size, std::fabs(x));
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(out.stress[i][0], sigma[unsigned(at[i])], 1e-11 * size);
  const double p = -(sigma[0] + sigma[4] + sigma[8]) / 3;
  double square = 0;
  for (unsigned i = 0; i < 9; ++i)
    square += (sigma[i] + (i % 4 == 0 ? p : 0)) * (sigma[i] + (i % 4 == 0 ? p : 0));
  EXPECT_NEAR(out.pressure[0], p, 1e-11 * size);
  EXPECT_NEAR(out.von_mises[0], std::sqrt(1.5 * square), 1e-11 * size);
  EXPECT_NEAR(out.phi[0], 0.25, 1e-14);
  EXPECT_EQ(out.alpha[0], 0);
}

TYPED_TEST(Measure, MassMatrixCarriesTheMassAndTheKineticEnergy) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int n = Cell::nodes, dim = Cell::dim;
  Sampler random(44);
  const PointLaw law{aluminium()};
  const auto cases = reference::cases<Cell, frame>(random, 0.0);
  const reference::CellBatch<Cell, frame> batch(cases);
  Batch M[n * n];
  for (auto& x : M) x = 0.0;
  kernels<Cell, frame>().mass_matrix(law, batch.X, M);
  EnergyInput in;
  in.X = batch.X, in.u = batch.u, in.v = batch.accel;
  EnergySums sums;
  kernels<Cell, frame>().stored_energy(law, in, sums);
  for (int l = 0; l < lanes; ++l) {
    double mass = 0, kinetic = 0;
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        mass += M[a * n + b][l];
        for (int i = 0; i < dim; ++i)
          kinetic += 0.5 * batch.accel[a * dim + i][l] * M[a * n + b][l] * batch.accel[b * dim + i][l];
      }
    EXPECT_NEAR(mass, sums.mass[l], 1e-13 * mass);
    EXPECT_NEAR(kinetic, sums.kinetic[l], 1e-12 * kinetic);
  }
}

TEST(MeasureOfRegularCells, CellSizeIsTheSmallestHeight) {
  const double edge = 0.25;
  Batch quad[8], hex[24], tri[6], tet[12];
  for (int a = 0; a < 4; ++a)
    for (int i = 0; i < 2; ++i) quad[2 * a + i] = edge * (i == 0 ? 3 : 1) * (Quad4::sign[a][i] + 1) / 2;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) hex[3 * a + i] = edge * (1 + i) * (Hex8::sign[a][i] + 1) / 2;
  for (int i = 0; i < 6; ++i) tri[i] = i == 2 || i == 5 ? edge : 0.0;
  for (int i = 0; i < 12; ++i) tet[i] = i == 3 || i == 7 || i == 11 ? edge : 0.0;
  EXPECT_NEAR(Shape::quad4->size(quad)[0], edge, 1e-15);
  EXPECT_NEAR(Shape::hex8->size(hex)[0], edge, 1e-15);
  EXPECT_NEAR(Shape::tri3->size(tri)[0], edge / std::sqrt(2.0), 1e-15);
  EXPECT_NEAR(Shape::tet4->size(tet)[0], edge / std::sqrt(3.0), 1e-15);
}

TEST(MeasureOfRegularCells,
     AxisymmetricVolumeIsThatOfTheRing) { // mass of a ring of rectangular section: 2 pi R_mean area rho
  Batch X[8], u[8];
  const double r0 = 0.01, r1 = 0.03, height = 0.02;
  for (int a = 0; a < 4; ++a) {
    X[2 * a] = Quad4::sign[a][0] < 0 ? r0 : r1;
    X[2 * a + 1] = Quad4::sign[a][1] < 0 ? 0.0 : height;
  }
  for (auto& x : u) x = 0.0;
  EnergyInput in;
  in.X = X, in.u = u;
  EnergySums sums;
  const PointLaw law{aluminium()};
  kernels<Quad4, Frame::axisymmetric>().stored_energy(law, in, sums);
  EXPECT_NEAR(sums.mass[0], law.parameters.rho * std::numbers::pi * (r1 * r1 - r0 * r0) * height,
              1e-13 * sums.mass[0]);
  EXPECT_NEAR(sums.elastic[0], 0, 1e-9);
}
