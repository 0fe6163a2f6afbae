#include "every_law.hpp"
#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <impact/kernel/cell_kernels.hpp>

using namespace impact;
using reference::aluminium;
using reference::for_every_law;
using reference::law_stride;
using reference::Sampler;

namespace {

template <class> struct Registry : testing::Test {};
TYPED_TEST_SUITE(Registry, reference::Elements);

template <class> struct RegistryOfSheets : testing::Test {};
template <class Cell> using Sheet = reference::Element<Cell, Frame::plane_stress>;
using Sheets = testing::Types<Sheet<Tri3>, Sheet<Quad4>, Sheet<Tri6>, Sheet<Quad9>>;
TYPED_TEST_SUITE(RegistryOfSheets, Sheets);

template <class Cell, Frame frame>
void one_step_of(const MaterialParameters& m, const std::string& name, Sampler& random) {
  constexpr int dofs = Cell::nodes * Cell::dim, n = Cell::nodes, points = Cell::points,
                size = history_size(frame);
  MaterialParameters in_frame = m;
  in_frame.sheet = frame == Frame::plane_stress;
  const PointLaw law{in_frame};
  const auto cases = reference::cases<Cell, frame>(random, 0.02);
  reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1e-3);
  Batch drive_n[points * drive_size];
  for (auto& x : drive_n) x = 1e6;
  in.drive = drive_n;
  Batch r[dofs], K[dofs * dofs], up[dofs], down[dofs], trial[points * size], drive[points * drive_size];
  for (int i = 0; i < dofs; ++i) r[i] = up[i] = down[i] = 0.0;
  for (auto& x : K) x = 0.0;
  StepSums sums;
  ASSERT_EQ((kernels<Cell, frame>().motion_tangent(law, in, r, K).bad), 0) << name;
  ASSERT_EQ((kernels<Cell, frame>().motion_advance(law, in, trial, drive, sums, {}).bad), 0) << name;

  // the tangent along a random direction against a central difference, too short to pass a yield surface
  Batch direction[dofs];
  const double h = 1e-11;
  for (auto& x : direction) x = random.uniform(-1, 1);
  for (int i = 0; i < dofs; ++i) batch.u[i] += h * direction[i];
  kernels<Cell, frame>().motion_residual(law, in, up);
  for (int i = 0; i < dofs; ++i) batch.u[i] -= 2 * h * direction[i];
  kernels<Cell, frame>().motion_residual(law, in, down);
  for (int i = 0; i < dofs; ++i) batch.u[i] += h * direction[i];
  double error = 0, stiffness = 0;
  for (int i = 0; i < dofs; ++i) {
    double s = 0;
    for (int j = 0; j < dofs; ++j) s += K[i * dofs + j][0] * direction[j][0];
    error = std::fmax(error, std::fabs(s - (up[i][0] - down[i][0]) / (2 * h)));
    stiffness = std::fmax(stiffness, std::fabs(s));
  }
  EXPECT_LT(error, 1e-5 * stiffness) << name;
  EXPECT_GE(sums.plastic_dissipation[0], 0) << name;
  EXPECT_GE(sums.viscous_dissipation[0], 0) << name;
  EXPECT_EQ(sums.viscous_dissipation[0] > 0, m.b_d > 0) << name;

  if (m.damage != Damage::none)
    for (const DamageForm form : {DamageForm::multiplied, DamageForm::divided}) {
      Batch f[n], J[n * n], phi_n[n];
      for (int a = 0; a < n; ++a) f[a] = 0.0, phi_n[a] = 0.5 * batch.phi[a];
      for (auto& x : J) x = 0.0;
      DamageInput d;
      d.X = in.X, d.u = in.u, d.u_n = in.u_n, d.phi = in.phi, d.phi_n = phi_n, d.drive = d.drive_n = drive;
      d.dt = 1e-4, d.form = form, d.theta_d = form == DamageForm::divided ? 0.5 : 1;
      d.history = in.history, d.convex = true;
      EXPECT_EQ((kernels<Cell, frame>().damage_tangent(law, d, f, J)), 0) << name;
      for (int a = 0; a < n; ++a) {
        EXPECT_TRUE(std::isfinite(J[a * n + a][0])) << name;
        EXPECT_GT(J[a * n + a][0], 0) << name;
      }
    }
  EnergyInput e;
  e.X = in.X, e.u = in.u, e.v = in.u_n, e.phi = in.phi, e.theta = in.theta, e.history = trial,
  e.drive = drive;
  EnergySums energy;
  kernels<Cell, frame>().stored_energy(law, e, energy);
  EXPECT_GT(energy.elastic[0], 0) << name;
  EXPECT_EQ(energy.plastic[0] > 0, m.model == Model::j2) << name;
  EXPECT_EQ(energy.fracture[0] > 0, m.damage != Damage::none) << name;
  if (law.exchanges()) {
    Batch exchanged[Cell::points], zero[n];
    for (auto& x : zero) x = 0.0;
    kernels<Cell, frame>().plastic_exchange(
        law, {.phi = in.phi, .phi_n = zero, .history = trial, .history_n = in.history, .drive = drive},
        exchanged);
    EXPECT_TRUE(std::isfinite(exchanged[0][0])) << name;
  }
  const Batch* const history_n = in.history;
  in.history = trial;
  if (law.flows()) { // D1 alone: the measure is the plastic strain of the step over D1
    MaterialParameters fragile = m;
    fragile.jc_failure = true, fragile.jc_d1 = 0.5;
    Batch failure[points], failure_n[points];
    for (auto& x : failure_n) x = 0.25;
    EXPECT_EQ((kernels<Cell, frame>().failure_advance(PointLaw{fragile}, in, history_n, failure_n, failure)),
              0)
        << name;
    const int alpha = symmetric_size(Cell::dim);
    for (int q = 0; q < points; ++q)
      EXPECT_NEAR(failure[q][0], 0.25 + (trial[q * size + alpha][0] - history_n[q * size + alpha][0]) / 0.5,
                  1e-14)
          << name;
  }
  CellOutput out;
  kernels<Cell, frame>().cell_output(law, in, out);
  EXPECT_GT(out.von_mises[0], 0) << name;
  EXPECT_LT(out.von_mises[0], 1e11) << name;
}

} // namespace

TYPED_TEST(Registry, EveryLawTakesAStep) {
  using Cell = typename TypeParam::Cell;
  Sampler random(51);
  int law = 0;
  for_every_law([&](const MaterialParameters& m, const std::string& name) {
    if (law++ % law_stride<Cell>() == 0) one_step_of<Cell, TypeParam::frame>(m, name, random);
  });
  EXPECT_GT(law, 700);
}

// Locking cures have no meaning in a sheet, whose volume is free, and are refused there, as is an equation of
// state.
TYPED_TEST(RegistryOfSheets, EveryLawTakesAStep) {
  using Cell = typename TypeParam::Cell;
  Sampler random(55);
  int laws = 0;
  for_every_law([&](const MaterialParameters& m, const std::string& name) {
    if (m.locking != Locking::none || m.equation_of_state != EquationOfState::none) return;
    if (laws++ % law_stride<Cell>() == 0) one_step_of<Cell, TypeParam::frame>(m, name, random);
  });
  EXPECT_GT(laws, 100);
}
