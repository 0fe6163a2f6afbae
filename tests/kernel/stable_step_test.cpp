#include "reference_cell.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

using namespace impact;
using reference::aluminium;
using reference::Sampler;

namespace {

template <class> struct StableStep : testing::Test {};
using ElementsAndSheets = testing::Types<
    reference::Element<Tri3, Frame::plane_strain>, reference::Element<Tri3, Frame::axisymmetric>,
    reference::Element<Tri3, Frame::plane_stress>, reference::Element<Quad4, Frame::plane_strain>,
    reference::Element<Quad4, Frame::axisymmetric>, reference::Element<Quad4, Frame::plane_stress>,
    reference::Element<Tet4, Frame::solid>, reference::Element<Hex8, Frame::solid>,
    reference::Element<Tri6, Frame::plane_strain>, reference::Element<Tri6, Frame::axisymmetric>,
    reference::Element<Tri6, Frame::plane_stress>, reference::Element<Tet10, Frame::solid>,
    reference::Element<Quad9, Frame::plane_strain>, reference::Element<Quad9, Frame::axisymmetric>,
    reference::Element<Quad8, Frame::plane_strain>>;
TYPED_TEST_SUITE(StableStep, ElementsAndSheets);

MaterialParameters elastic(double nu, Locking locking = Locking::none) {
  MaterialParameters m = aluminium();
  const double E = 72e9;
  m.G = E / (2 * (1 + nu));
  m.K = E / (3 * (1 - 2 * nu));
  m.model = Model::elastic;
  m.damage = Damage::none;
  m.locking = locking;
  return m;
}

/// The cures of a frame: none stands in a sheet but that one.
template <Frame frame> std::vector<Locking> cures() {
  if (frame == Frame::plane_stress) return {Locking::none};
  return {Locking::none, Locking::mean, Locking::fbar};
}

/// Dense rows x rows matrices of one lane.
using Dense = std::vector<double>;

// Without the checks of the sanitizers, which take most of the time of these tests.
[[gnu::no_sanitize("address", "undefined")]] void add_row(double a, const double* row, int n, double* sum) {
  for (int j = 0; j < n; ++j) sum[j] += a * row[j];
}
Dense product(const Dense& A, const Dense& B, int n) {
  Dense C(A.size(), 0.0);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) add_row(A[unsigned(i * n + k)], &B[unsigned(k * n)], n, &C[unsigned(i * n)]);
  return C;
}

/// By squaring, which converges whatever the eigenvalues and their multiplicities are.
double spectral_radius(Dense A, int n) {
  double logarithm = 0, power = 1;
  for (int k = 0; k < 22; ++k) {
    double size = 0;
    for (double x : A) size = std::max(size, std::fabs(x));
    if (size == 0) return 0;
    for (double& x : A) x /= size;
    logarithm += std::log(size) / power;
    A = product(A, A, n);
    power *= 2;
  }
  return std::exp(logarithm);
}

/// A cell alone with the mass at its nodes.
template <class Cell, Frame frame> struct Alone {
  static constexpr int dofs = Cell::nodes * Cell::dim;
  PointLaw law;
  MotionInput in;
  Batch K[dofs * dofs], mass[Cell::nodes], history[Cell::points * history_size(frame)], step;
  int bad = 0;

  Alone(const MaterialParameters& m, const MotionInput& given) : law{m}, in(given) {
    Batch M[Cell::nodes * Cell::nodes], r[dofs];
    if (frame == Frame::plane_stress) { // the thickness at u
      constexpr int size = history_size(frame);
      Batch drive[Cell::points * drive_size], trial[Cell::points * size];
      StepSums sums;
      kernels<Cell, frame>().motion_advance(law, in, trial, drive, sums, {});
      for (int k = 0; k < Cell::points * size; ++k)
        history[k] = in.history && k % size != size - 1 ? in.history[k] : trial[k];
      in.history = history;
    }
    for (auto& x : M) x = 0.0;
    for (auto& x : K) x = 0.0;
    for (auto& x : r) x = 0.0;
    kernels<Cell, frame>().mass_matrix(law, in.X, M);
    reference::lump<Cell>(M, mass);
    bad = kernels<Cell, frame>().motion_tangent(law, in, r, K).bad;
    step = kernels<Cell, frame>().highest_frequency(law, in, nullptr).longest_step();
  }

  Dense over_mass(const Batch* matrix, int lane) const {
    Dense A(unsigned(dofs * dofs));
    for (int i = 0; i < dofs; ++i)
      for (int j = 0; j < dofs; ++j)
        A[unsigned(i * dofs + j)] = matrix[i * dofs + j][lane] / mass[i / Cell::dim][lane];
    return A;
  }
  double true_step(int lane) const { return 2 / std::sqrt(spectral_radius(over_mass(K, lane), dofs)); }
};

/// Smallest and largest stable step found over the true one, over all cells that have a meaning.
struct Range {
  double least = HUGE_VAL, most = 0;
  int cells = 0;
  void add(double ratio) {
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    ++cells;
  }
};

/// The same cell undeformed in all lanes but for noise in its nodes: 0 gives the regular one.
template <class Cell, Frame frame>
std::vector<reference::CellCase<Cell, frame>> plain_cases(Sampler& random, double noise, double aspect = 1) {
  auto cases = reference::cases<Cell, frame>(random, 0.01);
  for (auto& c : cases) {
    std::fill_n(c.u, c.dofs, 0.0);
    std::fill_n(c.u_n, c.dofs, 0.0);
    const double bend = is_second_order<Cell> ? noise / 3 : noise;
    for (int a = 0; a < c.nodes; ++a)
      for (int i = 0; i < c.dim; ++i) {
        const double x = reference::node_place<Cell>(a)[unsigned(i)];
        c.X[a * c.dim + i] = 1e-3 * ((i == 0 ? aspect : 1) * x + random.uniform(-bend, bend) +
                                     (frame == Frame::axisymmetric && i == 0 ? 2 : 0));
      }
  }
  return cases;
}

template <class Cell, Frame frame> MotionInput virgin(const reference::CellBatch<Cell, frame>& batch) {
  MotionInput in = batch.input(1e-3);
  in.phi = in.theta = in.history = nullptr;
  return in;
}

} // namespace

// Noise in the corners, sides of 1 to 5, nu to 0.45.
TYPED_TEST(StableStep, UndeformedElasticCellsUseMostOfTheTrueLimit) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(61);
  Range range, fbar;
  for (const double nu : {0.0, 0.2, 0.33, 0.45})
    for (const Locking cure : cures<frame>())
      for (const double aspect : {1.0, 1.0, 2.0, 5.0}) {
        const auto cases = plain_cases<Cell, frame>(random, 0.1, aspect);
        const reference::CellBatch<Cell, frame> batch(cases);
        const Alone<Cell, frame> alone(elastic(nu, cure), virgin(batch));
        ASSERT_EQ(alone.bad, 0);
        for (int l = 0; l < lanes; ++l)
          (cure == Locking::fbar ? fbar : range).add(alone.step[l] / alone.true_step(l));
      }
  EXPECT_LE(std::max(range.most, fbar.most), 1 + 1e-9);
  // What is left out: that a top eigenvector need not be the worst gradient everywhere, in cells of second
  // order less than in others, least in those of serendipity.
  constexpr bool serendipity = is_second_order<Cell> && reference::corners<Cell> == 4 && !has_faces<Cell>;
  constexpr bool sheet = frame == Frame::plane_stress;
  EXPECT_GE(range.least, serendipity ? 0.35 : is_second_order<Cell> ? 0.6 : sheet ? 0.8 : 0.93);
  EXPECT_GE(fbar.least, serendipity ? 0.25 : is_second_order<Cell> ? 0.35 : 0.6);
}

TEST(StableStepOfOneCell, IsTheTrueLimitOfARegularCellWithoutPoissonsRatio) {
  Sampler random(62);
  const auto exact = [&]<class Cell, Frame frame>(double missed) {
    const auto cases = plain_cases<Cell, frame>(random, 0);
    const reference::CellBatch<Cell, frame> batch(cases);
    const Alone<Cell, frame> alone(elastic(0), virgin(batch));
    EXPECT_NEAR(alone.true_step(0) / (1e-3 / std::sqrt(72e9 / 2810)), 1, 1e-6) << Cell::names.polytope;
    EXPECT_NEAR(alone.step[0] / alone.true_step(0), 1 - missed, 1e-5) << Cell::names.polytope;
  };
  exact.template operator()<Quad4, Frame::plane_strain>(0.001207);
  exact.template operator()<Quad4, Frame::plane_stress>(0.001207);
  exact.template operator()<Hex8, Frame::solid>(0.02502);
}

TYPED_TEST(StableStep, IsNeverLongerThanTheTrueLimitOfDeformedElasticCells) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(63);
  for (const double strain : {0.01, 0.1, 0.3, 0.6}) {
    Range range;
    for (int k = 0; k < 24; ++k)
      for (const Locking cure : cures<frame>())
        for (const double nu : {0.0, 0.33}) {
          const auto cases = reference::cases<Cell, frame>(random, strain);
          const reference::CellBatch<Cell, frame> batch(cases);
          MotionInput in = virgin(batch);
          const Alone<Cell, frame> alone(elastic(nu, cure), in);
          for (int l = 0; l < lanes; ++l)
            if (!(alone.bad >> l & 1)) range.add(alone.step[l] / alone.true_step(l));
        }
    EXPECT_GT(range.cells, 100) << strain;
    EXPECT_LE(range.most, 1 + 1e-9) << strain;
  }
}

// Flow only makes cells softer; with temperature and elastic strains of their own.
TYPED_TEST(StableStep, IsNeverLongerThanTheTrueLimitOfCellsThatFlow) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(64);
  for (const double strain : {0.003, 0.03, 0.3}) {
    Range range;
    for (int k = 0; k < 24; ++k)
      for (const Locking cure : cures<frame>()) {
        MaterialParameters m = aluminium();
        m.damage = Damage::none;
        m.locking = cure;
        reference::set_hardening(m, k % reference::hardening_kinds);
        const auto cases = reference::cases<Cell, frame>(random, strain);
        const reference::CellBatch<Cell, frame> batch(cases);
        MotionInput in = batch.input(1e-3);
        in.phi = nullptr;
        const Alone<Cell, frame> alone(m, in);
        for (int l = 0; l < lanes; ++l)
          if (!(alone.bad >> l & 1)) range.add(alone.step[l] / alone.true_step(l));
      }
    EXPECT_GT(range.cells, 50) << strain;
    EXPECT_LE(range.most, 1 + 1e-9) << strain;
  }
}

namespace {

/// A cell alone under the steps of the program: forces by motion_step, u_n for the velocity.
template <class Cell, Frame frame> struct March {
  using Numbers = reference::CellBatch<Cell, frame>;
  static constexpr int dofs = Cell::nodes * Cell::dim;
  PointLaw law;
  Numbers batch;
  MotionInput in;
  Batch mass[Cell::nodes], v[dofs], drive[Cell::points * drive_size],
      history[Cell::points * history_size(frame)];

  March(const MaterialParameters& m, const Numbers& start) : law{m}, batch(start), in(virgin(batch)) {
    Batch M[Cell::nodes * Cell::nodes];
    for (auto& x : M) x = 0.0;
    kernels<Cell, frame>().mass_matrix(law, in.X, M);
    reference::lump<Cell>(M, mass);
    for (auto& x : v) x = 0.0;
  }

  /// Half-step velocities v, steps of dt.
  void run(int steps) {
    for (int step = 0; step < steps; ++step) {
      Batch r[dofs];
      for (auto& x : r) x = 0.0;
      StepSums sums;
      kernels<Cell, frame>().motion_step(law, in, frame == Frame::plane_stress ? history : nullptr, drive,
                                         sums, {}, r);
      for (int i = 0; i < dofs; ++i) {
        v[i] -= in.dt * r[i] / mass[i / Cell::dim];
        batch.u_n[i] = batch.u[i];
        batch.u[i] += in.dt * v[i];
      }
    }
  }
  double size(int lane) const {
    double s = 0;
    for (int i = 0; i < dofs; ++i) {
      const double u = std::fabs(batch.u[i][lane]);
      if (!(u < 1)) return HUGE_VAL; // or not a number
      s = std::max(s, u);
    }
    return s;
  }
};

/// A small disturbance of an undeformed cell.
template <class Cell, Frame frame> reference::CellBatch<Cell, frame> disturbed(Sampler& random, double size) {
  auto cases = plain_cases<Cell, frame>(random, 0.1);
  for (auto& c : cases)
    for (int i = 0; i < c.dofs; ++i) c.u[i] = c.u_n[i] = size * random.uniform(-1, 1);
  return reference::CellBatch<Cell, frame>(cases);
}

} // namespace

// The steps of a cell with viscosity stay bounded at the step that is said to be stable, and with the
// material's grow at twice it. Bulk viscosity acts in compression alone, which the limit does not know: at
// the whole step for the usual b = 0.06, at 0.8 of it for b = 0.2. Much larger ones do grow.
TYPED_TEST(StableStep, DampedCellsStayBoundedAtIt) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(65);
  const double h = 1e-3, c = std::sqrt(72e9 / 2810);
  struct Damping {
    double material, bulk, at; // parts of the critical one, about; part of the stable step
  };
  for (const auto& [material, bulk, at] : {Damping{0.05, 0, 1}, Damping{0.5, 0, 1}, Damping{5, 0, 1},
                                           Damping{0, 0.06, 0.95}, Damping{0, 0.2, 0.8}}) {
    MaterialParameters m = elastic(0.2);
    m.b_d = material * 72e9 * h / c / 4;
    const auto start = disturbed<Cell, frame>(random, 1e-9);
    for (const bool late : {false, true}) {
      March<Cell, frame> march(m, start);
      march.in.bulk_linear = bulk;
      const Batch step =
          kernels<Cell, frame>().highest_frequency(march.law, march.in, nullptr).longest_step();
      double shortest = HUGE_VAL, longest = 0, grown = 0;
      for (int l = 0; l < lanes; ++l) {
        shortest = std::min(shortest, step[l]);
        longest = std::max(longest, step[l]);
      }
      march.in.dt = late ? 2 * longest : at * shortest;
      march.run(late ? 300 : 3000);
      for (int l = 0; l < lanes; ++l) grown = std::max(grown, march.size(l) / 1e-9);
      if (!late) {
        EXPECT_LT(grown, 10) << "material " << material << " bulk " << bulk;
      } else if (material > 0) {
        EXPECT_GT(grown, 1e3) << "material " << material;
      }
    }
  }
}

namespace {

/// Derivatives of the forces of motion_step by u and by the velocity, one lane after another, by differences.
template <class Cell, Frame frame> struct Damped {
  static constexpr int dofs = Cell::nodes * Cell::dim;
  PointLaw law;
  MotionInput in;
  Batch K[dofs * dofs], D[dofs * dofs], mass[Cell::nodes], history[Cell::points * history_size(frame)], step;
  int bad = 0;

  Damped(const MaterialParameters& m, const MotionInput& given, reference::CellBatch<Cell, frame>& batch)
      : law{m}, in(given) {
    const Alone<Cell, frame> alone(m, given);
    std::copy_n(alone.mass, Cell::nodes, mass);
    std::copy_n(alone.history, Cell::points * history_size(frame), history);
    in.history = frame == Frame::plane_stress ? history : nullptr;
    step = kernels<Cell, frame>().highest_frequency(law, in, nullptr).longest_step();
    const double h = 1e-10;
    for (int j = 0; j < dofs; ++j) {
      Batch both[2][dofs], last[2][dofs];
      for (int side = 0; side < 2; ++side) {
        const double by = side ? h : -h;
        batch.u_n[j] += by;
        force(last[side]);
        batch.u[j] += by;
        force(both[side]);
        batch.u_n[j] -= by;
        batch.u[j] -= by;
      }
      for (int i = 0; i < dofs; ++i) {
        K[i * dofs + j] = (both[1][i] - both[0][i]) / (2 * h);
        D[i * dofs + j] = -in.dt * (last[1][i] - last[0][i]) / (2 * h);
      }
    }
  }
  void force(Batch* r) {
    for (int i = 0; i < dofs; ++i) r[i] = 0.0;
    Batch drive[Cell::points * drive_size], trial[Cell::points * history_size(frame)];
    StepSums sums;
    bad |= kernels<Cell, frame>().motion_step(law, in, trial, drive, sums, {}, r).bad;
  }

  /// At which dt^2 K + 2 dt D reaches 4 M.
  double true_step(int lane) const {
    double low = 0, high = 100 * step[lane];
    for (int k = 0; k < 30; ++k) {
      const double dt = (low + high) / 2;
      Dense A(unsigned(dofs * dofs));
      for (int i = 0; i < dofs; ++i)
        for (int j = 0; j < dofs; ++j)
          A[unsigned(i * dofs + j)] =
              (dt * dt * K[i * dofs + j][lane] + 2 * dt * D[i * dofs + j][lane]) / mass[i / Cell::dim][lane];
      (spectral_radius(A, dofs) < 4 ? low : high) = dt;
    }
    return low;
  }
};

} // namespace

TYPED_TEST(StableStep, IsNeverLongerThanTheTrueLimitOfDampedCells) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(66);
  const double h = 1e-3, c = std::sqrt(72e9 / 2810);
  for (int kind = 0; kind < 3; ++kind)
    for (const double strain : {0.0, 0.1, 0.4}) {
      Range range;
      for (const double part : {0.05, 0.5, 5.0}) {
        MaterialParameters m = elastic(0.2);
        if (kind == 0) m.b_d = part * 72e9 * h / c / 4;
        auto cases = reference::cases<Cell, frame>(random, strain);
        const double dt = 0.1 * h / c;
        const double rate = kind == 0 ? 1e-4 : 0.3; // c/h, by which it shrinks evenly
        for (auto& one : cases)
          for (int i = 0; i < one.dofs; ++i) one.u_n[i] = one.u[i] + 0.1 * rate * (one.X[i] + one.u[i]);
        reference::CellBatch<Cell, frame> batch(cases);
        MotionInput in = virgin(batch);
        in.dt = dt;
        if (kind == 1) in.bulk_linear = part;
        if (kind == 2) in.bulk_quadratic = std::sqrt(part / 0.3);
        const Damped<Cell, frame> damped(m, in, batch);
        for (int l = 0; l < lanes; ++l)
          if (!(damped.bad >> l & 1)) range.add(damped.step[l] / damped.true_step(l));
      }
      EXPECT_GT(range.cells, 4) << kind << " " << strain;
      EXPECT_LE(range.most, 1 + 1e-5) << kind << " " << strain;
    }
}
