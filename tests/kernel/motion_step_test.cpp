#include "every_law.hpp"
#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <memory>

using namespace impact;
using reference::aluminium;
using reference::Sampler;

namespace {

template <int n> double largest(const Batch (&x)[n]) {
  double size = 0;
  for (const Batch& value : x)
    for (int l = 0; l < lanes; ++l) size = std::fmax(size, std::fabs(value[l]));
  return size;
}

/// EXPECT that two arrays agree to rounding of their largest entry, in every lane.
template <int n> void expect_same(const Batch (&one)[n], const Batch (&other)[n], const std::string& name) {
  double gap = 0;
  for (int i = 0; i < n; ++i)
    for (int l = 0; l < lanes; ++l) gap = std::fmax(gap, std::fabs(one[i][l] - other[i][l]));
  EXPECT_LE(gap, 1e-12 * largest(other)) << name;
}

void expect_same(const StepSums& one, const StepSums& other, const std::string& name) {
  const Batch first[] = {one.plastic_dissipation, one.viscous_dissipation, one.plastic_work,
                         one.least_dissipation};
  const Batch second[] = {other.plastic_dissipation, other.viscous_dissipation, other.plastic_work,
                          other.least_dissipation};
  for (int i = 0; i < 4; ++i)
    for (int l = 0; l < lanes; ++l)
      EXPECT_NEAR(first[i][l], second[i][l], 1e-12 * std::fabs(second[i][l])) << name << " sum " << i;
}

template <class Cell, Frame frame>
void one_pass_is_both(const MaterialParameters& m, const std::string& name, Sampler& random, bool heats) {
  constexpr int dofs = Cell::nodes * Cell::dim, points = Cell::points, size = history_size(frame),
                gradients = stress_size(frame);
  const PointLaw law{m};
  const auto cases = reference::cases<Cell, frame>(random, 0.02);
  const reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1e-3);
  Batch drive_n[points * drive_size];
  for (auto& x : drive_n) x = 1e6;
  in.drive = drive_n;
  Batch r[dofs], r_step[dofs], trial[points * size], trial_step[points * size], drive[points * drive_size],
      drive_step[points * drive_size], heat[points], heat_step[points], P[points * gradients],
      P_step[points * gradients];
  const auto clear = [](auto& array) {
    for (auto& x : array) x = 0.0;
  };
  clear(r), clear(r_step), clear(trial), clear(trial_step), clear(drive), clear(drive_step), clear(heat),
      clear(heat_step), clear(P), clear(P_step);
  StepSums sums, sums_step;
  const HeatFeed feed = heats ? HeatFeed{heat, P} : HeatFeed{},
                 feed_step = heats ? HeatFeed{heat_step, P_step} : HeatFeed{};
  const CellKernels& k = kernels<Cell, frame>();
  EXPECT_EQ(k.motion_residual(law, in, r).bad, 0) << name;
  const CellStatus advanced = k.motion_advance(law, in, trial, drive, sums, feed);
  for (auto& x : r_step) x = 1e3; // the kernel adds
  const CellStatus stepped = k.motion_step(law, in, trial_step, drive_step, sums_step, feed_step, r_step);
  for (auto& x : r_step) x -= 1e3;
  EXPECT_EQ(stepped.bad, advanced.bad) << name;
  for (int l = 0; l < lanes; ++l) EXPECT_NEAR(stepped.min_J[l], advanced.min_J[l], 1e-14) << name;
  expect_same(r_step, r, name);
  expect_same(trial_step, trial, name + " history");
  expect_same(drive_step, drive, name + " drive");
  expect_same(sums_step, sums, name);
  EXPECT_GT(largest(r), 1) << name;
  if (heats) {
    expect_same(heat_step, heat, name + " heat");
    expect_same(P_step, P, name + " stress");
  }
}

template <class Cell, Frame frame> void every_law(unsigned seed) {
  Sampler random(seed);
  int number = 0;
  reference::for_every_law([&](const MaterialParameters& m, const std::string& name) {
    if (frame == Frame::plane_stress && (m.locking != Locking::none || has_state(m))) return;
    if (++number % reference::law_stride<Cell>() == 0)
      one_pass_is_both<Cell, frame>(m, name, random, number % 2 == 0);
  });
  EXPECT_GT(number, 100);
}

template <class> struct MotionStepKernel : testing::Test {};
using Shapes = testing::Types<
    reference::Element<Tri3, Frame::plane_strain>, reference::Element<Tri3, Frame::axisymmetric>,
    reference::Element<Tri3, Frame::plane_stress>, reference::Element<Quad4, Frame::plane_strain>,
    reference::Element<Quad4, Frame::axisymmetric>, reference::Element<Quad4, Frame::plane_stress>,
    reference::Element<Tet4, Frame::solid>, reference::Element<Hex8, Frame::solid>,
    reference::Element<Tri6, Frame::plane_strain>, reference::Element<Tet10, Frame::solid>,
    reference::Element<Quad9, Frame::plane_strain>, reference::Element<Hex27, Frame::solid>>;
TYPED_TEST_SUITE(MotionStepKernel, Shapes);

} // namespace

TYPED_TEST(MotionStepKernel, IsResidualAndAdvanceInOnePassForEveryLaw) {
  every_law<typename TypeParam::Cell, TypeParam::frame>(71);
}

// A measure D makes a point as strong as one whose flow stress is 1 - D_c D of that of the law, in force,
// tangent, flow and what is lost; and one of the step's start is no part of the tangent.
TYPED_TEST(MotionStepKernel, FailureWeakensLikeASmallerFlowStress) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, size = history_size(frame);
  Sampler random(73);
  MaterialParameters m = aluminium(), weaker = m;
  m.failure_softening = 0.5;
  for (double* k : {&weaker.sigma_y, &weaker.voce_r, &weaker.linear_h}) *k *= 1 - 0.5 * 0.7;
  const auto cases = reference::cases<Cell, frame>(random, 0.02);
  const reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1e-3);
  Batch measure[Cell::points];
  for (auto& x : measure) x = 0.7;
  struct Outcome {
    Batch r[dofs], K[dofs * dofs], history[Cell::points * size], drive[Cell::points * drive_size];
    StepSums sums;
  };
  const auto step = [&](const MaterialParameters& law, const Batch* failure) {
    auto out = std::make_unique<Outcome>();
    in.failure = failure;
    for (auto& x : out->r) x = 0.0;
    EXPECT_EQ((kernels<Cell, frame>().motion_tangent(PointLaw{law}, in, nullptr, out->K).bad), 0);
    EXPECT_EQ((kernels<Cell, frame>()
                   .motion_step(PointLaw{law}, in, out->history, out->drive, out->sums, {}, out->r)
                   .bad),
              0);
    return out;
  };
  const auto one = step(m, measure), other = step(weaker, nullptr), sound = step(m, nullptr);
  expect_same(one->r, other->r, "force");
  expect_same(one->K, other->K, "tangent");
  expect_same(one->history, other->history, "history");
  expect_same(one->sums, other->sums, "sums");
  Batch taken[dofs];
  for (int i = 0; i < dofs; ++i) taken[i] = sound->r[i] - one->r[i];
  EXPECT_GT(largest(taken), 1e-3 * largest(one->r));
}

TYPED_TEST(MotionStepKernel, MarksInvertedCellsAndOverflow) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(72);
  MaterialParameters m = aluminium();
  m.model = Model::elastic, m.damage = Damage::none;
  const PointLaw law{m};
  const auto cases = reference::cases<Cell, frame>(random, 0.01);
  reference::CellBatch<Cell, frame> batch(cases);
  for (int i = 1; i < Cell::nodes * Cell::dim; i += Cell::dim) batch.u[i].set(1, -2.5 * batch.X[i][1]);
  MotionInput in = batch.input(1e-3);
  in.phi = in.theta = nullptr;
  Batch r[Cell::nodes * Cell::dim], trial[Cell::points * history_size(frame)],
      drive[Cell::points * drive_size];
  for (auto& x : r) x = 0.0;
  StepSums sums;
  EXPECT_EQ((kernels<Cell, frame>().motion_step(law, in, trial, drive, sums, {}, r).bad), 2);
}

namespace {

struct Pressed {
  double power = 0, booked = 0, force = 0, heat = 0;
};

/// What bulk viscosity adds to an elastic cell that deforms by `grow` of its size in dt, beside noise.
template <class Cell, Frame frame>
Pressed pressed_at(double grow, double noise, double linear, double quadratic, unsigned seed) {
  constexpr int dofs = Cell::nodes * Cell::dim, points = Cell::points;
  Sampler random(seed);
  MaterialParameters m = aluminium();
  m.model = Model::elastic, m.damage = Damage::none, m.alpha_t = 0;
  const PointLaw law{m};
  auto cases = reference::cases<Cell, frame>(random, 0.02);
  for (auto& c : cases)
    for (int i = 0; i < dofs; ++i)
      c.u_n[i] = c.u[i] - grow * (c.X[i] + c.u[i]) - noise * 1e-3 * random.uniform(-1, 1);
  const reference::CellBatch<Cell, frame> batch(cases);
  MotionInput in = batch.input(1e-9);
  in.phi = in.theta = in.history = nullptr;
  Batch r[2][dofs], trial[points * history_size(frame)], drive[points * drive_size], heat[2][points];
  StepSums sums[2];
  Batch energy(0.0);
  for (const int with : {0, 1}) {
    for (auto& x : r[with]) x = 0.0;
    in.bulk_linear = with * linear, in.bulk_quadratic = with * quadratic;
    const CellStatus status = kernels<Cell, frame>().motion_step(law, in, trial, drive, sums[with],
                                                                 {.dissipation = heat[with]}, r[with]);
    EXPECT_EQ(status.bad, 0);
  }
  Pressed p;
  for (int i = 0; i < dofs; ++i) {
    const double force = r[1][i][0] - r[0][i][0];
    p.power += force * (batch.u[i][0] - batch.u_n[i][0]);
    p.force = std::fmax(p.force, std::fabs(force));
  }
  p.booked = sums[1].viscous_dissipation[0] - sums[0].viscous_dissipation[0];
  Batch added[points];
  for (int q = 0; q < points; ++q) added[q] = heat[1][q] - heat[0][q];
  p.heat = kernels<Cell, frame>().cell_integral(in.X, added)[0];
  return p;
}

} // namespace

TYPED_TEST(MotionStepKernel, BulkViscosityIsForCellsThatShrinkAndOnlyDissipates) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Pressed wide = pressed_at<Cell, frame>(1e-5, 0, 0.06, 1.2, seed);
    EXPECT_EQ(wide.force, 0);
    EXPECT_EQ(wide.booked, 0);
    const Pressed noisy = pressed_at<Cell, frame>(0, 1e-5, 0.06, 1.2, seed);
    EXPECT_GE(noisy.booked, 0);
    const Pressed shut = pressed_at<Cell, frame>(-1e-5, 0, 0.06, 1.2, seed);
    EXPECT_GT(shut.force, 0);
    EXPECT_GT(shut.booked, 0);
    EXPECT_NEAR(shut.heat, shut.booked, 1e-12 * shut.booked);
  }
}

// Power = force times rate, to the order in which a step's change of volume is its rate.
TYPED_TEST(MotionStepKernel, WorkOfBulkViscosityIsWhatItDissipates) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Pressed shut = pressed_at<Cell, frame>(-1e-6, 1e-7, 0.06, 1.2, seed);
    ASSERT_GT(shut.booked, 0);
    EXPECT_NEAR(shut.power / shut.booked, 1, 5e-6) << seed;
  }
}

// One cell by hand: q = rho l |D| (a^2 l |D| + b c) of a square or a cube
TEST(BulkViscosity, IsThePressureOfTheFormula) {
  const auto check = [&]<class Cell, Frame frame>() {
    constexpr int dofs = Cell::nodes * Cell::dim, points = Cell::points;
    Sampler random(1);
    MaterialParameters m = aluminium();
    m.model = Model::elastic, m.damage = Damage::none;
    const PointLaw law{m};
    auto cases = reference::cases<Cell, frame>(random, 0);
    const double corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    const double h = 1e-3, dt = 1e-9, grow = -1e-8;
    for (auto& c : cases)
      for (int a = 0; a < Cell::nodes; ++a)
        for (int i = 0; i < Cell::dim; ++i) {
          const int k = a * Cell::dim + i;
          c.X[k] = h * corner[a][i];
          c.u[k] = 0;
          c.u_n[k] = i == 0 ? -grow * c.X[k] : 0;
        }
    const reference::CellBatch<Cell, frame> batch(cases);
    MotionInput in = batch.input(dt);
    in.phi = in.theta = in.history = nullptr;
    in.bulk_linear = 0.06, in.bulk_quadratic = 1.2;
    Batch r[dofs], trial[points * history_size(frame)], drive[points * drive_size];
    for (auto& x : r) x = 0.0;
    StepSums sums;
    kernels<Cell, frame>().motion_step(law, in, trial, drive, sums, {}, r);
    const double rate = -grow / dt, c = std::sqrt((m.K + 4 * m.G / 3) / m.rho),
                 q = m.rho * h * rate * (1.2 * 1.2 * h * rate + 0.06 * c);
    double side = 0; // the force on the side x = h, against the motion
    for (int a = 0; a < Cell::nodes; ++a)
      if (corner[a][0] == 1) side += r[a * Cell::dim][0];
    const double area = Cell::dim == 2 ? h : h * h;
    EXPECT_NEAR(-side / (q * area), 1, 1e-6) << Cell::names.polytope;
    EXPECT_NEAR(sums.viscous_dissipation[0] / (q * rate * dt * area * h), 1, 1e-6);
  };
  check.template operator()<Quad4, Frame::plane_strain>();
  check.template operator()<Hex8, Frame::solid>();
}

// A lumped mass stands at the nodes: its sum is the whole, a rigid velocity has the same energy, and a
// velocity that varies has more than with the consistent mass.
TYPED_TEST(MotionStepKernel, LumpedMassIsPositiveAndTheWholeMass) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, n = Cell::nodes;
  Sampler random(73);
  MaterialParameters m = aluminium();
  m.model = Model::elastic, m.damage = Damage::none;
  const PointLaw law{m};
  for (int k = 0; k < 50; ++k) {
    const auto cases = reference::cases<Cell, frame>(random, 0.02);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch M[n * n], v[dofs], even[dofs];
    for (auto& x : M) x = 0.0;
    kernels<Cell, frame>().mass_matrix(law, batch.X, M);
    Batch whole(0.0), speed[Cell::dim];
    for (auto& x : speed) x = random.uniform(-1, 1);
    for (int i = 0; i < dofs; ++i) v[i] = random.uniform(-1, 1), even[i] = speed[i % Cell::dim];
    Batch at_nodes(0.0), consistent(0.0), mass[n], momentum(0.0);
    reference::lump<Cell>(M, mass);
    for (int a = 0; a < n; ++a) {
      for (int b = 0; b < n; ++b)
        for (int i = 0; i < Cell::dim; ++i)
          consistent += 0.5 * M[a * n + b] * v[a * Cell::dim + i] * v[b * Cell::dim + i];
      for (int l = 0; l < lanes; ++l) EXPECT_GT(mass[a][l], 0);
      whole += mass[a];
      momentum += mass[a] * v[a * Cell::dim];
      for (int i = 0; i < Cell::dim; ++i)
        at_nodes += 0.5 * mass[a] * v[a * Cell::dim + i] * v[a * Cell::dim + i];
    }
    EnergyInput e;
    e.X = batch.X, e.u = batch.u;
    const auto measure = [&](const Batch* of, bool lumped) {
      e.v = of, e.lumped = lumped;
      EnergySums sums;
      kernels<Cell, frame>().stored_energy(law, e, sums);
      return sums;
    };
    const EnergySums lumped = measure(v, true), plain = measure(v, false), rigid = measure(even, true),
                     rigid_plain = measure(even, false);
    for (int l = 0; l < lanes; ++l) {
      EXPECT_NEAR(lumped.mass[l] / whole[l], 1, 1e-13);
      EXPECT_NEAR(lumped.kinetic[l] / at_nodes[l], 1, 1e-13);
      EXPECT_NEAR(plain.kinetic[l] / consistent[l], 1, 1e-13);
      EXPECT_NEAR(rigid.kinetic[l] / rigid_plain.kinetic[l], 1, 1e-13);
      EXPECT_NEAR(lumped.momentum[0][l], momentum[l], 1e-12 * whole[l]);
      if (!is_second_order<Cell>) { // row sums of what is positive
        EXPECT_GT(lumped.kinetic[l], plain.kinetic[l]);
      }
    }
  }
}
