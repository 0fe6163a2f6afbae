#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <impact/kernel/cell_kernels.hpp>

using namespace impact;
using reference::aluminium;
using reference::Complex;
using reference::Matrix;
using reference::Sampler;

namespace {

template <class> struct HeatCell : testing::Test {};
TYPED_TEST_SUITE(HeatCell, reference::Elements);

/// Free energy of heat and volume, psi_theta + g_v U(J/J_th), as it is written, or (52d).
template <class T> T free_energy(const MaterialParameters& m, double J, double phi, const T& theta) {
  const T J_th = reference::J_theta(m, theta), Je = J / J_th;
  const double g = real(Complex(Je)) >= 1 ? reference::g_e1(m, phi) : reference::g_e2(m, phi);
  T free = 0.0; // what an equation of state has at its volume without stress
  if (m.equation_of_state != EquationOfState::none) {
    const auto at = reference::isotherm(m, J_th);
    free = at.U - at.dU * (J_th - 1.0);
  }
  return free + g * reference::volume_energy(m, T(J), J_th) -
         m.c_v * (theta * std::log(theta / m.theta0) - (theta - m.theta0));
}

/// eta = -d psi/d theta by the complex step.
double entropy(const MaterialParameters& m, double J, double phi, double theta) {
  return -imag(free_energy(m, J, phi, Complex(theta, 1e-20))) / 1e-20;
}

/// The volume ratio of the locking cure at each point.
template <class Cell, Frame frame>
std::vector<double> volumes(const MaterialParameters& m, const reference::CellCase<Cell, frame>& c,
                            const double* u) {
  const auto at = reference::points<Cell, frame>(c.X);
  if (m.locking == Locking::mean) return reference::shared_volume(c.X, at, u);
  std::vector<double> J;
  for (const auto& q : at) J.push_back(reference::det(q.F(u)));
  const reference::Point<Cell, frame> centre(c.X, Cell::centroid(), 1);
  if (m.locking == Locking::fbar) std::ranges::fill(J, reference::det(centre.F(u)));
  return J;
}

/// Nodal fields at t_n beside those of the case, and what the motion tells of the points.
struct More {
  std::vector<double> phi_n, theta_n, dissipation;
};

/// kappa grad theta at a point in the reference configuration.
template <class P>
std::vector<double> flux(const MaterialParameters& m, const P& q, int dim, const double* u, double phi,
                         const double* theta) {
  const Matrix<double> F = q.F(u), Ci = reference::inverse(reference::right_cauchy_green(F));
  const double g = m.gtheta == ConductionDegradation::ge ? reference::g_e1(m, phi) : 1;
  std::vector<double> f(3, 0.0), grad(3, 0.0);
  for (std::size_t a = 0; a < std::size(q.N); ++a)
    for (int i = 0; i < dim; ++i) grad[unsigned(i)] += theta[a] * q.dN[a][i];
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned j = 0; j < 3; ++j)
      f[i] += m.conductivity * g *
              (m.conduction == Conduction::spatial ? reference::det(F) * Ci[3 * i + j] : double(i == j)) *
              grad[j];
  return f;
}

/// Parts of the volume of a cell that stand at its nodes: int N_a dV, of second order int N_a^2 dV, scaled.
template <class Cell, Frame frame>
std::vector<double> nodal_volumes(const reference::CellCase<Cell, frame>& c) {
  std::vector<double> plain(Cell::nodes, 0.0), squared(plain);
  double all = 0, sum = 0;
  for (const auto& q : reference::points<Cell, frame>(c.X)) {
    all += q.weight;
    for (unsigned a = 0; a < Cell::nodes; ++a) {
      plain[a] += q.weight * q.N[a];
      squared[a] += q.weight * q.N[a] * q.N[a];
    }
  }
  if (!is_second_order<Cell>) return plain;
  for (double part : squared) sum += part;
  for (double& part : squared) part *= all / sum;
  return squared;
}

/// The entropy form written out point by point (section 6 of the model), with c_V at the points or `lumped`.
template <class Cell, Frame frame>
std::vector<double> weak_form(const MaterialParameters& m, const reference::CellCase<Cell, frame>& c,
                              const More& e, double theta_h, bool lumped) {
  std::vector<double> r(Cell::nodes, 0.0);
  const auto volume = nodal_volumes(c);
  for (unsigned a = 0; lumped && a < Cell::nodes; ++a)
    r[a] = volume[a] * (theta_h * c.theta[a] + (1 - theta_h) * e.theta_n[a]) * m.c_v *
           std::log(c.theta[a] / e.theta_n[a]);
  const auto J = volumes(m, c, c.u), J_n = volumes(m, c, c.u_n);
  std::size_t k = 0;
  for (const auto& q : reference::points<Cell, frame>(c.X)) {
    const double theta = q.at(c.theta), theta_n = q.at(e.theta_n.data());
    const double phi = q.at(c.phi), phi_n = q.at(e.phi_n.data());
    const double produced = e.dissipation[k];
    double change = entropy(m, J[k], phi, theta) - entropy(m, J_n[k], phi_n, theta_n);
    if (lumped) change -= m.c_v * std::log(theta / theta_n);
    const double local = (theta_h * theta + (1 - theta_h) * theta_n) * change - produced;
    const auto now = flux(m, q, Cell::dim, c.u, phi, c.theta),
               before = flux(m, q, Cell::dim, c.u_n, phi_n, e.theta_n.data());
    for (unsigned a = 0; a < Cell::nodes; ++a) {
      r[a] += q.weight * q.N[a] * local;
      for (unsigned i = 0; i < Cell::dim; ++i)
        r[a] += q.weight * c.dt * q.dN[a][i] * (theta_h * now[i] + (1 - theta_h) * before[i]);
    }
    ++k;
  }
  return r;
}

MaterialParameters hot_aluminium(int k) {
  MaterialParameters m = aluminium();
  m.c_v = 2.43e6;
  m.conductivity = 150;
  m.conduction = k % 2 ? Conduction::spatial : Conduction::material;
  m.gtheta = k % 3 ? ConductionDegradation::ge : ConductionDegradation::one;
  m.locking = k % 4 == 0 ? Locking::mean : k % 4 == 1 ? Locking::fbar : Locking::none;
  m.split = k % 5 ? Split::volumetric : Split::none;
  m.gp = k % 7 ? PlasticDegradation::one : PlasticDegradation::ge;
  m.damage_gradient = k % 6 ? DamageGradient::spatial : DamageGradient::material;
  if (k % 3 == 1) reference::set_state(m, true);
  return m;
}

/// One batch with random fields at both ends of a step.
template <class Cell, Frame frame> struct Case {
  std::vector<reference::CellCase<Cell, frame>> cells;
  reference::CellBatch<Cell, frame> batch;
  std::vector<More> more;
  Batch phi_n[Cell::nodes], theta_n[Cell::nodes], dissipation[Cell::points];

  explicit Case(Sampler& random) : cells(reference::cases<Cell, frame>(random, 0.02)), batch(cells) {
    for (int l = 0; l < lanes; ++l) {
      More& e = more.emplace_back();
      for (int a = 0; a < Cell::nodes; ++a) {
        e.phi_n.push_back(random.uniform(0, 0.7));
        e.theta_n.push_back(random.uniform(290, 400));
        phi_n[a].set(l, e.phi_n.back());
        theta_n[a].set(l, e.theta_n.back());
      }
      for (int q = 0; q < Cell::points; ++q) {
        e.dissipation.push_back(random.uniform(0, 1e6));
        dissipation[q].set(l, e.dissipation.back());
      }
    }
  }
  HeatInput input() const {
    HeatInput in;
    in.X = batch.X, in.u = batch.u, in.u_n = batch.u_n, in.phi = batch.phi, in.phi_n = phi_n;
    in.theta = batch.theta, in.theta_n = theta_n, in.dissipation = dissipation, in.dt = cells[0].dt;
    return in;
  }
};

double lane_total(const Batch& x) {
  double sum = 0;
  for (int l = 0; l < lanes; ++l) sum += x[l];
  return sum;
}

template <class Cell, Frame frame>
std::vector<Batch> whole_residual(const PointLaw& law, const HeatInput& in) {
  Batch points[Cell::points * heat_point_size];
  std::vector<Batch> r(Cell::nodes, Batch(0.0));
  EXPECT_EQ((kernels<Cell, frame>().heat_step(law, in, points, r.data())), 0);
  EXPECT_EQ((kernels<Cell, frame>().heat_residual(law, in, points, r.data())), 0);
  return r;
}

} // namespace

TYPED_TEST(HeatCell, EntropyFormIsTheWeakFormWrittenOut) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(51);
  for (int k = 0; k < 24; ++k) {
    const MaterialParameters m = hot_aluminium(k);
    const Case<Cell, frame> c(random);
    HeatInput in = c.input();
    in.theta_h = k % 2 ? 1 : 0.5;
    in.lumped = k % 3 == 0;
    const std::vector<Batch> r = whole_residual<Cell, frame>(PointLaw{m}, in);
    for (int l = 0; l < lanes; ++l) {
      const auto expected = weak_form(m, c.cells[unsigned(l)], c.more[unsigned(l)], in.theta_h, in.lumped);
      double size = 0;
      for (double x : expected) size = std::max(size, std::abs(x));
      for (unsigned a = 0; a < Cell::nodes; ++a) EXPECT_NEAR(r[a][l], expected[a], 1e-11 * size) << k;
    }
  }
}

TYPED_TEST(HeatCell, TangentIsTheDerivativeOfTheResidualAndSymmetric) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(52);
  for (int k = 0; k < 12; ++k) {
    const PointLaw law{hot_aluminium(k)};
    const Case<Cell, frame> c(random);
    HeatInput in = c.input();
    in.form = k % 2 ? HeatForm::entropy : HeatForm::energy;
    in.theta_h = k % 3 ? 1 : 0.5;
    in.lumped = k / 2 % 2 == 1;
    Batch points[Cell::points * heat_point_size], theta[Cell::nodes];
    std::vector<Batch> r(Cell::nodes, Batch(0.0)), K(Cell::nodes * Cell::nodes, Batch(0.0));
    kernels<Cell, frame>().heat_step(law, in, points, r.data());
    EXPECT_EQ((kernels<Cell, frame>().heat_tangent(law, in, points, r.data(), K.data())), 0);
    const auto at = [&](int node, double h) {
      for (int a = 0; a < Cell::nodes; ++a) theta[a] = in.theta[a];
      theta[node] += Batch(h);
      HeatInput moved = in;
      moved.theta = theta;
      std::vector<Batch> f(Cell::nodes, Batch(0.0));
      kernels<Cell, frame>().heat_residual(law, moved, points, f.data());
      return f;
    };
    for (int b = 0; b < Cell::nodes; ++b) {
      const double h = 0.02; // the difference of fourth order
      const auto p1 = at(b, h), m1 = at(b, -h), p2 = at(b, 2 * h), m2 = at(b, -2 * h);
      for (int a = 0; a < Cell::nodes; ++a)
        for (int l = 0; l < lanes; ++l) {
          const unsigned i = unsigned(a);
          const double slope = (8 * (p1[i][l] - m1[i][l]) - (p2[i][l] - m2[i][l])) / (12 * h);
          const double size = K[unsigned(b * Cell::nodes + b)][l];
          EXPECT_NEAR(K[unsigned(a * Cell::nodes + b)][l], slope, 1e-8 * size);
          EXPECT_EQ(K[unsigned(a * Cell::nodes + b)][l], K[unsigned(b * Cell::nodes + a)][l]);
        }
    }
  }
}

// Where a capacity at the nodes is all that stores heat, what a node gains over its temperature is the
// entropy that the ledger sums.
TYPED_TEST(HeatCell, LumpedEntropyIsThatOfTheNodes) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(56);
  MaterialParameters m = hot_aluminium(2);
  m.alpha_t = m.conductivity = 0;
  m.damage = Damage::none;
  const PointLaw law{m};
  const Case<Cell, frame> c(random);
  HeatInput in = c.input();
  in.dissipation = nullptr;
  in.lumped = true;
  Batch gained = 0;
  const std::vector<Batch> r = whole_residual<Cell, frame>(law, in);
  for (int a = 0; a < Cell::nodes; ++a) gained += r[unsigned(a)] / in.theta[a];
  HeatSums now, before;
  EnergyInput at;
  at.X = in.X, at.lumped_capacity = true;
  at.u = in.u, at.theta = in.theta;
  kernels<Cell, frame>().stored_heat(law, at, now);
  at.u = in.u_n, at.theta = in.theta_n;
  kernels<Cell, frame>().stored_heat(law, at, before);
  for (int l = 0; l < lanes; ++l)
    EXPECT_NEAR(gained[l], (now.entropy - before.entropy)[l], 1e-10 * std::abs(now.entropy[l]));
}

// Summed over its nodes, the energy form is the first law of the cell: what is stored now, less what was
// stored before, less the work of the forces that the motion balanced, at both ends of the step.
TYPED_TEST(HeatCell, EnergyFormIsTheFirstLawWithTheWorkOfTheForces) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int dofs = Cell::nodes * Cell::dim, parts = history_size(frame);
  Sampler random(53);
  for (int k = 0; k < 24; ++k) {
    MaterialParameters m = hot_aluminium(k);
    m.model = k % 2 ? Model::j2 : Model::elastic;
    reference::set_hardening(m, k / 2 % reference::hardening_kinds);
    m.b_d = k % 3 ? 3e3 : 0;
    if (k % 8 == 3) m.ge = Degradation::ductile, m.alpha_c = 0.05;
    const PointLaw law{m};
    const Case<Cell, frame> c(random);
    Batch history[2][Cell::points * parts], stress[2][Cell::points * stress_size(frame)], force[2][dofs],
        drive_n[Cell::points * drive_size], drive[2][Cell::points * drive_size];
    for (auto& x : drive_n) x = random.uniform(0, 1e6);
    const Batch *u[2] = {c.batch.u_n, c.batch.u}, *phi[2] = {c.phi_n, c.batch.phi},
                *theta[2] = {c.theta_n, c.batch.theta};
    Batch stored = 0, work = 0;
    for (int end = 0; end < 2; ++end) {
      MotionInput in = c.batch.input(c.cells[0].dt);
      in.u = u[end], in.phi = phi[end], in.theta = theta[end];
      in.drive = end ? drive[0] : drive_n;
      StepSums sums;
      kernels<Cell, frame>().motion_advance(law, in, history[end], drive[end], sums, {nullptr, stress[end]});
      for (auto& f : force[end]) f = 0;
      kernels<Cell, frame>().motion_residual(law, in, force[end]);
      EnergyInput at;
      at.X = c.batch.X, at.u = u[end], at.phi = phi[end], at.theta = theta[end];
      at.history = m.model == Model::j2 ? history[end] : nullptr;
      at.drive = drive[end];
      at.lumped_capacity = k / 2 % 2 == 1;
      EnergySums energies;
      HeatSums heat;
      kernels<Cell, frame>().stored_energy(law, at, energies);
      kernels<Cell, frame>().stored_heat(law, at, heat);
      stored += (end ? 1.0 : -1.0) * (energies.elastic + energies.plastic + energies.fracture + heat.energy);
    }
    for (int i = 0; i < dofs; ++i) work += 0.5 * (force[0][i] + force[1][i]) * (u[1][i] - u[0][i]);
    HeatInput in = c.input();
    in.form = HeatForm::energy;
    in.theta_h = k % 2 ? 1 : 0.5;
    in.lumped = k / 2 % 2 == 1;
    if (m.model == Model::j2) in.history = history[1], in.history_n = history[0];
    in.drive = drive[1], in.drive_n = drive[0];
    in.stress = stress[1], in.stress_n = stress[0];
    Batch sum = 0, size = 0;
    for (const Batch& x : whole_residual<Cell, frame>(law, in)) sum += x, size += abs(x);
    for (int l = 0; l < lanes; ++l) EXPECT_NEAR(sum[l], (stored - work)[l], 1e-11 * size[l]) << k;
  }
}

// Of laws whose damage takes other energy from plasticity than is stored, and of a ductile degradation, the
// entropy form lacks what is not named a dissipation: x of section 11.
TYPED_TEST(HeatCell, EntropyFormTakesWhatDamageAndFlowExchange) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int parts = history_size(frame), alpha = symmetric_size(Cell::dim);
  Sampler random(55);
  for (int k = 0; k < 24; ++k) {
    MaterialParameters m = hot_aluminium(2);
    m.model = Model::j2;
    m.locking = Locking::none;
    m.split = k % 3 ? Split::volumetric : Split::none;
    m.gp = k % 4 ? PlasticDegradation::ge : PlasticDegradation::one;
    m.ge = k % 2 ? Degradation::quadratic : Degradation::ductile;
    m.alpha_c = 0.05;
    m.plastic_threshold = k % 5 ? 0 : 1e7;
    const PointLaw law{m};
    const Case<Cell, frame> c(random);
    Batch history[2][Cell::points * parts], drive[Cell::points * drive_size];
    for (auto& end : history)
      for (auto& x : end) x = random.uniform(0, 0.1);
    for (auto& x : drive) x = random.uniform(0, 1e8);
    HeatInput in = c.input();
    in.history = history[1], in.history_n = history[0];
    const auto without = whole_residual<Cell, frame>(law, in);
    in.drive = drive;
    const auto with = whole_residual<Cell, frame>(law, in);
    for (int l = 0; l < lanes; ++l) {
      std::vector<double> expected(Cell::nodes, 0.0);
      double size = 0;
      int q = 0;
      for (const auto& at : reference::points<Cell, frame>(c.cells[unsigned(l)].X)) {
        const double phi = at.at(c.cells[unsigned(l)].phi), phi_n = at.at(c.more[unsigned(l)].phi_n.data()),
                     now = history[1][q * parts + alpha][l], old = history[0][q * parts + alpha][l],
                     H = plastic_potential(m, now), stored = (1 - m.taylor_quinney) * H,
                     driving = std::max(H - m.plastic_threshold, 0.0);
        const auto energy = [&](double a) {
          return reference::g_e1(m, phi, a) * drive[q * drive_size][l] +
                 reference::g_e2(m, phi, a) * drive[q * drive_size + 1][l] +
                 reference::g_p(m, phi, a) * stored;
        };
        const double x = (reference::g_p(m, phi, old) - reference::g_p(m, phi_n, old)) * (driving - stored) +
                         (m.ge == Degradation::ductile ? energy(old) - energy(now) : 0);
        for (unsigned a = 0; a < Cell::nodes; ++a) expected[a] -= at.weight * at.N[a] * x;
        ++q;
      }
      for (unsigned a = 0; a < Cell::nodes; ++a) size = std::max(size, std::abs(without[a][l]));
      EXPECT_GT(law.exchanges() ? std::abs(expected[0]) : 1, 1e-9 * size);
      for (unsigned a = 0; a < Cell::nodes; ++a)
        EXPECT_NEAR(with[a][l] - without[a][l], expected[a], 1e-11 * (size + std::abs(expected[a]))) << k;
    }
  }
}

TYPED_TEST(HeatCell, MotionTellsItsDissipationAtThePoints) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(54);
  for (int kind = 0; kind < reference::hardening_kinds; ++kind) {
    MaterialParameters m = hot_aluminium(2);
    m.b_d = 3e3;
    reference::set_hardening(m, kind);
    const PointLaw law{m};
    const auto cells = reference::cases<Cell, frame>(random, 0.03);
    const reference::CellBatch<Cell, frame> batch(cells);
    Batch history[Cell::points * history_size(frame)], plain[Cell::points * history_size(frame)],
        drive[Cell::points * drive_size], dissipation[Cell::points];
    StepSums sums, without;
    kernels<Cell, frame>().motion_advance(law, batch.input(cells[0].dt), history, drive, sums,
                                          {dissipation, nullptr});
    kernels<Cell, frame>().motion_advance(law, batch.input(cells[0].dt), plain, drive, without, {});
    EXPECT_GT(lane_total(without.plastic_dissipation), 0);
    EXPECT_GT(lane_total(without.viscous_dissipation), 0);
    for (int l = 0; l < lanes; ++l) {
      double total = 0;
      int q = 0;
      for (const auto& at : reference::points<Cell, frame>(cells[unsigned(l)].X))
        total += at.weight * dissipation[q++][l];
      EXPECT_NEAR(total, (without.plastic_dissipation + without.viscous_dissipation)[l], 1e-12 * total);
      for (int i = 0; i < Cell::points * history_size(frame); ++i)
        EXPECT_NEAR(history[i][l], plain[i][l], 1e-15);
    }
  }
}

TYPED_TEST(HeatCell, RefusesATemperatureThatIsNotPositive) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  Sampler random(55);
  const Case<Cell, frame> c(random);
  HeatInput in = c.input();
  Batch points[Cell::points * heat_point_size], theta[Cell::nodes], r[Cell::nodes];
  for (int a = 0; a < Cell::nodes; ++a) {
    theta[a] = in.theta[a];
    theta[a].set(1, -1);
    r[a] = 0;
  }
  const PointLaw law{hot_aluminium(2)};
  kernels<Cell, frame>().heat_step(law, in, points, r);
  in.theta = theta;
  EXPECT_EQ((kernels<Cell, frame>().heat_residual(law, in, points, r)), 2);
}
