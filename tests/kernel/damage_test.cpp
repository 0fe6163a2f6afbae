#include "../material/oracle_values.hpp"
#include "reference_cell.hpp"

#include <gtest/gtest.h>
#include <impact/kernel/cell_kernels.hpp>

using namespace impact;
using reference::aluminium;
using reference::Complex;
using reference::Matrix;
using reference::oracle;
using reference::Sampler;

namespace {

template <class> struct DamageCell : testing::Test {};
TYPED_TEST_SUITE(DamageCell, reference::Elements);

/// g' of the degradations by the complex step of g.
template <class T>
T slope(T (*g)(const MaterialParameters&, const T&, double), const MaterialParameters& m, const T& phi,
        double alpha) {
  const double h = 1e-4; // cubic polynomials: a five-point difference is exact
  return (8.0 * (g(m, T(phi + h), alpha) - g(m, T(phi - h), alpha)) -
          (g(m, T(phi + 2 * h), alpha) - g(m, T(phi - 2 * h), alpha))) /
         (12 * h);
}

struct Drives {
  double now[max_points][3], old[max_points][3], fatigue[max_points];
};

/// The weak form written out point by point (5.1, 5.2 of the model).
template <class Cell, Frame frame, class T>
std::vector<T> weak_form(const MaterialParameters& m, const reference::CellCase<Cell, frame>& c,
                         const Drives& e, const double* phi_n, const std::vector<T>& phi, double dt,
                         DamageForm form, double theta) {
  std::vector<T> r(phi.size(), T(0.0));
  int k = 0;
  for (const auto& q : reference::points<Cell, frame>(c.X)) {
    T f = 0.0, grad[3] = {0.0, 0.0, 0.0};
    double old = 0, grad_n[3] = {0, 0, 0};
    for (unsigned a = 0; a < Cell::nodes; ++a) {
      f += q.N[a] * phi[a];
      old += q.N[a] * phi_n[a];
      for (int i = 0; i < Cell::dim; ++i) grad[i] += q.dN[a][i] * phi[a], grad_n[i] += q.dN[a][i] * phi_n[a];
    }
    const auto Y = [&](const auto& p, const double* drive) {
      using S = std::decay_t<decltype(p)>;
      const double alpha = c.history[k].alpha;
      return slope<S>(reference::g_e1<S>, m, p, alpha) * drive[0] +
             slope<S>(reference::g_e2<S>, m, p, alpha) * drive[1] +
             slope<S>(reference::g_p<S>, m, p, alpha) * drive[2] +
             m.Gc / m.gamma * reference::crack_slope(m, p) - e.fatigue[k] / m.gamma;
    };
    Matrix<double> Ci = reference::inverse(reference::right_cauchy_green(q.F(c.u)));
    Matrix<double> Ci_n = reference::inverse(reference::right_cauchy_green(q.F(c.u_n)));
    if (m.damage_gradient == DamageGradient::material) Ci = Ci_n = reference::unit<double>();
    const double lambda = std::pow(1 + m.delta - old, m.zeta) / m.c;
    const double slope_of_inverse = m.zeta * m.c * std::pow(1 + m.delta - old, -m.zeta - 1);
    const double flux_size = reference::gradient_share(m) * m.Gc * m.gamma;
    T flux[3] = {0.0, 0.0, 0.0}, mixed = 0.0;
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) {
        flux[i] += flux_size * (theta * Ci[3 * i + j] * grad[j] + (1 - theta) * Ci_n[3 * i + j] * grad_n[j]);
        mixed += flux_size * slope_of_inverse * grad_n[i] *
                 (theta * Ci[3 * i + j] + (1 - theta) * Ci_n[3 * i + j]) * grad_n[j];
      }
    const T source = theta * Y(f, e.now[k]) + (1 - theta) * Y(old, e.old[k]);
    for (unsigned a = 0; a < Cell::nodes; ++a) {
      T work = q.N[a] * source;
      for (int i = 0; i < Cell::dim; ++i) work += q.dN[a][i] * flux[i];
      if (form == DamageForm::multiplied)
        r[a] += q.weight * (q.N[a] * lambda * (f - old) / dt + work);
      else
        r[a] += q.weight * (q.N[a] * (f - old) + dt / lambda * work + dt * q.N[a] * mixed);
    }
    ++k;
  }
  return r;
}

/// A unit square cell with uniform data in every lane; solves for uniform phi by Newton and returns it.
struct UniformCell {
  PointLaw law{aluminium()};
  Batch X[8], u[8], phi[4], phi_n[4], drive[12];
  DamageInput in;

  UniformCell() {
    const double x[8] = {0, 0, 1e-3, 0, 1e-3, 1e-3, 0, 1e-3};
    for (int i = 0; i < 8; ++i) X[i] = x[i], u[i] = 0.0;
    for (int a = 0; a < 4; ++a) phi[a] = phi_n[a] = 0.0;
    for (auto& d : drive) d = 0.0;
    in = {};
    in.X = X, in.u = in.u_n = u, in.phi = phi, in.phi_n = phi_n, in.drive = in.drive_n = drive;
  }
  void set_drive(double E_plus) {
    for (int q = 0; q < 4; ++q) drive[3 * q] = E_plus;
  }
  double advance() {
    for (int a = 0; a < 4; ++a) phi_n[a] = phi[a];
    for (int it = 0; it < 3; ++it) { // linear: one would do
      Batch r[4], K[16];
      for (auto& x : r) x = 0.0;
      for (auto& x : K) x = 0.0;
      kernels<Quad4, Frame::plane_strain>().damage_tangent(law, in, r, K);
      double sum = 0, slope = 0;
      for (auto& x : r) sum += x[0];
      for (auto& x : K) slope += x[0];
      for (auto& p : phi) p -= sum / slope;
    }
    return phi[0][0];
  }
};

} // namespace

TYPED_TEST(DamageCell, ResidualAndTangentAreThoseOfTheWeakForm) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int n = Cell::nodes;
  Sampler random(31);
  for (int k = 0; k < 60; ++k) {
    MaterialParameters m = aluminium();
    m.ge = k % 3 == 2 ? Degradation::ductile : k % 2 ? Degradation::cubic : Degradation::quadratic;
    m.alpha_c = 0.03;
    m.damage = k % 7 < 3 ? Damage::at1 : Damage::at2;
    m.split = k % 3 ? Split::volumetric : Split::none;
    m.gp = k % 5 ? PlasticDegradation::one : PlasticDegradation::ge;
    m.zeta = k % 4 == 0 ? 0 : k % 4 == 1 ? 1 : 1.5;
    m.delta = 1e-4;
    m.damage_gradient = k % 11 ? DamageGradient::spatial : DamageGradient::material;
    m.residual_stiffness = 1e-6;
    if (k % 4 == 3) {
      m.damage = Damage::wu;
      m.ge = k % 8 == 3 ? Degradation::cornelissen : Degradation::exponential;
      reference::set_strength(m, 300e6);
    }
    const DamageForm form = k % 2 == (k / 2) % 2 ? DamageForm::divided : DamageForm::multiplied;
    const double theta = k % 3 == 0 ? 0.5 : 1, dt = 1e-4;
    const auto cases = reference::cases<Cell, frame>(random, 0.05);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch drive[Cell::points * 3], drive_n[Cell::points * 3], fatigue[Cell::points], phi_n[n];
    Drives e[lanes];
    for (int l = 0; l < lanes; ++l)
      for (int q = 0; q < Cell::points; ++q) {
        for (int i = 0; i < 3; ++i) {
          drive[3 * q + i].set(l, e[l].now[q][i] = random.uniform(0, 2e7));
          drive_n[3 * q + i].set(l, e[l].old[q][i] = random.uniform(0, 2e7));
        }
        fatigue[q].set(l, e[l].fatigue[q] = random.uniform(0, 500));
      }
    double old[lanes][n];
    for (int a = 0; a < n; ++a)
      for (int l = 0; l < lanes; ++l) old[l][a] = random.uniform(0, 0.7);
    for (int l = 0; l < lanes; ++l) {
      reference::hold_between_nodes<Cell>(old[l], 0.7);
      for (int a = 0; a < n; ++a) phi_n[a].set(l, old[l][a]);
    }
    DamageInput in;
    in.X = batch.X, in.u = batch.u, in.u_n = batch.u_n, in.phi = batch.phi, in.phi_n = phi_n;
    in.drive = drive, in.drive_n = drive_n, in.fatigue = fatigue, in.history = batch.history;
    in.dt = dt, in.form = form, in.theta_d = theta;
    Batch r[n], only[n], K[n * n];
    for (int a = 0; a < n; ++a) r[a] = only[a] = 0.0;
    for (auto& x : K) x = 0.0;
    EXPECT_EQ((kernels<Cell, frame>().damage_tangent(PointLaw{m}, in, r, K)), 0);
    EXPECT_EQ((kernels<Cell, frame>().damage_residual(PointLaw{m}, in, only)), 0);
    for (int l = 0; l < lanes; ++l) {
      const auto& c = cases[unsigned(l)];
      const std::vector<double> phi(c.phi, c.phi + n);
      const auto exact = weak_form<Cell, frame>(m, c, e[l], old[l], phi, dt, form, theta);
      double size = 0, stiffness = 0;
      for (double x : exact) size = std::fmax(size, std::fabs(x));
      for (auto& x : K) stiffness = std::fmax(stiffness, std::fabs(x[l]));
      for (int a = 0; a < n; ++a) {
        EXPECT_NEAR(r[a][l], exact[unsigned(a)], 1e-10 * size);
        EXPECT_NEAR(only[a][l], r[a][l], 1e-13 * size);
      }
      for (int b = 0; b < n; ++b) {
        std::vector<Complex> z(phi.begin(), phi.end());
        z[unsigned(b)] += Complex(0, reference::step);
        const auto column = weak_form<Cell, frame>(m, c, e[l], old[l], z, dt, form, theta);
        for (int a = 0; a < n; ++a)
          EXPECT_NEAR(K[a * n + b][l], column[unsigned(a)].imag() / reference::step, 1e-9 * stiffness);
      }
    }
  }
}

TYPED_TEST(DamageCell, ABentUpTangentIsPositiveAndNeverSofterThanTheDerivative) {
  using Cell = typename TypeParam::Cell;
  constexpr Frame frame = TypeParam::frame;
  constexpr int n = Cell::nodes;
  Sampler random(32);
  int bent = 0;
  for (int k = 0; k < 30; ++k) {
    MaterialParameters m = aluminium();
    m.c = std::numeric_limits<double>::infinity();
    m.alpha_c = 0.1;
    m.ge = k % 3 == 0 ? Degradation::quadratic : k % 3 == 1 ? Degradation::cubic : Degradation::ductile;
    m.damage = k % 2 ? Damage::at1 : Damage::at2;
    if (k % 5 == 4) {
      m.damage = Damage::wu, m.ge = Degradation::exponential;
      reference::set_strength(m, 300e6);
    }
    const auto cases = reference::cases<Cell, frame>(random, 0.05);
    const reference::CellBatch<Cell, frame> batch(cases);
    Batch drive[Cell::points * 3], r[n], K[2][n * n];
    for (auto& x : drive) x = random.uniform(0, 2e8);
    DamageInput in;
    in.X = batch.X, in.u = batch.u, in.phi = in.phi_n = batch.phi, in.drive = drive,
    in.history = batch.history;
    for (auto& x : r) x = 0.0;
    for (auto& side : K)
      for (auto& x : side) x = 0.0;
    for (const bool convex : {false, true}) {
      in.convex = convex;
      EXPECT_EQ((kernels<Cell, frame>().damage_tangent(PointLaw{m}, in, r, K[convex])), 0);
    }
    for (int trial = 0; trial < 20; ++trial) {
      double x[n], quadratic[2] = {0, 0}, size = 0;
      for (double& v : x) v = trial ? random.uniform(-1, 1) : 1;
      for (int side = 0; side < 2; ++side)
        for (int a = 0; a < n; ++a)
          for (int b = 0; b < n; ++b) {
            quadratic[side] += x[a] * K[side][a * n + b][0] * x[b];
            size = std::fmax(size, std::fabs(K[side][a * n + b][0]));
          }
      EXPECT_GT(quadratic[1], 0);
      EXPECT_GE(quadratic[1], quadratic[0] - 1e-13 * size);
      if (is_convex(m) && m.damage != Damage::wu)
        EXPECT_EQ(quadratic[1], quadratic[0]);
      else
        bent += quadratic[1] > quadratic[0] + 1e-6 * size;
    }
  }
  EXPECT_GT(bent, 20);
}

TEST(Damage, StepsAreThoseOfTheHomogeneousOracle) { // backward Euler and trapezoid, multiplied and divided
  for (const DamageForm form : {DamageForm::multiplied, DamageForm::divided})
    for (const double dt : {1e-5, 1e-3})
      for (const double theta : {1.0, 0.5}) {
        UniformCell cell;
        cell.set_drive(5e6);
        cell.in.form = form, cell.in.dt = dt, cell.in.theta_d = theta;
        const std::string row = std::string("dmg.") + (theta == 1 ? "BE" : "TR") + ".dt" +
                                (dt == 1e-5 ? "1e-05" : "1e-03") + ".step";
        for (int step = 1; step <= 10; ++step) {
          const double phi = cell.advance();
          if (step > 2 && step < 10) continue;
          EXPECT_NEAR(phi, oracle((row + std::to_string(step)).c_str()), 1e-9) << row << step;
        }
      }
}

TEST(Damage, ApproachesTheClosedFormOfTheRateLaw) { // D3: first order in dt, because lambda stays at t_n
  double error[2];
  for (int k = 0; k < 2; ++k) {
    UniformCell cell;
    cell.set_drive(5e6);
    const int steps = 200 << k;
    cell.in.dt = 1e-4 / steps;
    double phi = 0;
    for (int n = 1; n <= steps; ++n) {
      phi = cell.advance();
      if (n == steps / 5) {
        EXPECT_NEAR(phi, oracle("dmg.phi(2e-05)"), 2e-3);
      }
      if (n == steps / 2) {
        EXPECT_NEAR(phi, oracle("dmg.phi(5e-05)"), 2e-3);
      }
    }
    error[k] = phi - oracle("dmg.phi(1e-04)");
  }
  EXPECT_NEAR(error[0] / error[1], 2, 0.05);
  EXPECT_LT(std::fabs(error[1]), 1e-3);

  UniformCell constant; // zeta = 0: exponential, second order with the trapezoid
  constant.law.parameters.zeta = 0;
  constant.set_drive(5e6);
  constant.in.dt = 1e-7, constant.in.theta_d = 0.5;
  double phi = 0;
  for (int n = 0; n < 100; ++n) phi = constant.advance();
  EXPECT_NEAR(phi, oracle("dmg.zeta0.phi(1e-5)"), 1e-6);
}

TEST(Damage, ExponentAndShiftOfTheRateAreThoseOfTheRateLaw) {
  // lambda phi' = 2 E (1 - phi) - G_c phi/gamma, lambda = (1 + delta - phi)^zeta/c, at t = 3e-5 s: scipy's
  // DOP853 at a tolerance of 1e-13
  const double table[4][3] = {{0, 0, 0.22589556061779253},
                              {2, 0.1, 0.23522285785492872},
                              {1, 0.1, 0.230426665289952},
                              {0.5, 0, 0.23783190532622814}};
  for (const auto& row : table) {
    double phi[2];
    for (int k = 0; k < 2; ++k) {
      UniformCell cell;
      cell.law.parameters.zeta = row[0], cell.law.parameters.delta = row[1];
      cell.set_drive(5e6);
      const int steps = 1000 << k;
      cell.in.dt = 3e-5 / steps;
      for (int n = 0; n < steps; ++n) phi[k] = cell.advance();
    }
    EXPECT_NEAR((phi[0] - row[2]) / (phi[1] - row[2]), 2, 0.01) << row[0];
    EXPECT_NEAR(2 * phi[1] - phi[0], row[2], 1e-7) << row[0]; // extrapolated
  }
}

TEST(Damage, At1IsElasticUpToItsStrengthAndSoftensByTheClosedForm) {
  // 2 (1 - phi) E+ = 3 G_c/(8 gamma): phi = 1 - 3 G_c/(16 gamma E+), sigma_c = sqrt(3 E G_c/(8 gamma))
  UniformCell cell;
  MaterialParameters& m = cell.law.parameters;
  m.damage = Damage::at1;
  m.c = std::numeric_limits<double>::infinity();
  const double E = 72e9, sigma_c = std::sqrt(3 * E * m.Gc / (8 * m.gamma));
  for (const double sigma : {0.5, 0.999999, 1.000001, 2.0, 10.0}) {
    const double psi = std::pow(sigma * sigma_c, 2) / (2 * E);
    cell.set_drive(psi);
    const double phi = cell.advance(); // below the strength it is negative: the bound of the solve holds it
    EXPECT_NEAR(phi, 1 - 1 / (sigma * sigma), 1e-12 / (sigma * sigma)) << sigma;
    EXPECT_EQ(phi > 0, sigma > 1);
  }
}

TEST(Damage, PlasticExchangeIsWhatTheStoredEnergyLacks) {
  // stored + crack drive + exchange close the balance of a step at fixed u, whatever is stored of H_0
  Sampler random(35);
  for (int k = 0; k < 100; ++k) {
    MaterialParameters m = aluminium();
    m.gp = k % 2 ? PlasticDegradation::ge : PlasticDegradation::one;
    m.ge = k % 3 ? Degradation::ductile : Degradation::quadratic;
    m.alpha_c = 0.08;
    m.taylor_quinney = random.uniform(0, 1);
    m.plastic_threshold = k % 5 ? 0 : 1e7;
    const PointLaw law{m};
    const double phi_n = random.uniform(0, 0.5), phi = phi_n + random.uniform(0, 0.4),
                 alpha_n = random.uniform(0, 0.05), alpha = alpha_n + random.uniform(0, 0.05);
    const PointEnergies<double> e{random.uniform(0, 1e7), random.uniform(0, 1e7),
                                  plastic_potential(m, alpha)};
    const double chi = m.taylor_quinney;
    const auto stored = [&](double p, double a) {
      return reference::g_e1(m, p, a) * e.plus + reference::g_e2(m, p, a) * e.minus +
             reference::g_p(m, p, a) * (1 - chi) * e.plastic;
    };
    // what damage took at alpha_n, by its own drive
    const double drive = law.plastic_drive(e.plastic);
    EXPECT_NEAR(drive, std::fmax(0, e.plastic - m.plastic_threshold), 1e-9);
    const double taken = (reference::g_e1(m, phi_n, alpha_n) - reference::g_e1(m, phi, alpha_n)) * e.plus +
                         (reference::g_e2(m, phi_n, alpha_n) - reference::g_e2(m, phi, alpha_n)) * e.minus +
                         (reference::g_p(m, phi_n, alpha_n) - reference::g_p(m, phi, alpha_n)) * drive;
    EXPECT_NEAR(stored(phi, alpha) - stored(phi_n, alpha_n) + taken +
                    law.plastic_exchange(phi, phi_n, alpha, alpha_n, e),
                0, 1e-8 * (e.plus + e.plastic));
  }
}

TEST(Damage, RestStateOfTheRateLaw) { // phi_e = A/(A+B) for three energies (Table 1)
  const double psi[3] = {1e6, 5e6, 2e7}, phi_e[3] = {0.168050, 0.502482, 0.801584};
  for (int k = 0; k < 3; ++k) {
    UniformCell cell;
    cell.set_drive(psi[k]);
    cell.in.dt = 1e3;
    cell.advance();
    EXPECT_NEAR(cell.advance(), phi_e[k], 5e-7);
  }
}

TEST(Damage, HomogeneousBarHasTheStrengthOfTheClosedForm) { // D2 and sigma_c of Table 1, rate-independent
  const double table[2][3] = {{210e3, 2.7, 0.015}, {72e9, 4950.6, 0.5e-3}};
  const double strength[2] = {1996.68, oracle("at2.sigma_c_uniaxial_stress")};
  const double critical[2] = {0.0169031, oracle("at2.eps_c_uniaxial_stress")};
  for (int k = 0; k < 2; ++k) {
    const double E = table[k][0];
    double peak = 0, at = 0, phi_at = 0;
    for (int n = 1; n <= 2000; ++n) {
      const double strain = critical[k] * n / 1000;
      UniformCell cell;
      cell.law.parameters.Gc = table[k][1];
      cell.law.parameters.gamma = table[k][2];
      cell.law.parameters.c = std::numeric_limits<double>::infinity();
      cell.set_drive(E * strain * strain / 2);
      const double phi = cell.advance(), sigma = (1 - phi) * (1 - phi) * E * strain;
      if (sigma > peak) peak = sigma, at = strain, phi_at = phi;
    }
    EXPECT_NEAR(peak / strength[k], 1, 3e-6);
    EXPECT_NEAR(at / critical[k], 1, 2e-3);
    EXPECT_NEAR(phi_at, 0.25, 1e-3);
  }
}

namespace {

/// AT2 profile of a half bar of length 10 gamma with phi(0) = 1 as one row of quads stretched by `stretch`;
/// returns phi at x = gamma and the fracture energy of the full bar over G_c.
struct Profile {
  double at_gamma, energy;
};
Profile profile(double h_over_gamma, double stretch) {
  MaterialParameters m = aluminium();
  m.c = std::numeric_limits<double>::infinity();
  const PointLaw law{m};
  const int n = int(std::lround(10 / h_over_gamma));
  const double h = h_over_gamma * m.gamma;
  Batch u[8], zero[4], drive[12], X[8];
  for (auto& x : zero) x = 0.0;
  for (auto& x : drive) x = 0.0;
  const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int a = 0; a < 4; ++a)
    for (int i = 0; i < 2; ++i) {
      X[2 * a + i] = h * corner[a][i];
      u[2 * a + i] = i == 0 ? (stretch - 1) * h * corner[a][0] : 0;
    }
  DamageInput in;
  in.X = X, in.u = u, in.phi = in.phi_n = zero, in.drive = drive;
  Batch r[4], K[16];
  for (auto& x : r) x = 0.0;
  for (auto& x : K) x = 0.0;
  kernels<Quad4, Frame::plane_strain>().damage_tangent(law, in, r, K);
  // nodes 0, 3 on the left and 1, 2 on the right carry the same value: a 2x2 cell matrix, Thomas algorithm
  const int side[4] = {0, 1, 1, 0};
  double k[2][2] = {{0, 0}, {0, 0}};
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) k[side[a]][side[b]] += K[4 * a + b][0];
  std::vector<double> phi(unsigned(n) + 1), factor(unsigned(n) + 1);
  factor[unsigned(n)] = -k[1][0] / k[1][1]; // phi_i = factor_i phi_{i-1}
  for (int i = n - 1; i > 0; --i)
    factor[unsigned(i)] = -k[1][0] / (k[1][1] + k[0][0] + k[0][1] * factor[unsigned(i) + 1]);
  phi[0] = 1;
  for (int i = 1; i <= n; ++i) phi[unsigned(i)] = factor[unsigned(i)] * phi[unsigned(i) - 1];
  double energy = 0;
  for (int c = 0; c < n; ++c) {
    Batch nodal[4];
    for (int a = 0; a < 4; ++a) nodal[a] = phi[unsigned(c + side[a])];
    EnergyInput e;
    e.X = X, e.u = u, e.phi = nodal;
    EnergySums sums;
    kernels<Quad4, Frame::plane_strain>().stored_energy(law, e, sums);
    energy += sums.fracture[0];
  }
  return {phi[unsigned(std::lround(1 / h_over_gamma))], 2 * energy / (m.Gc * h)};
}

} // namespace

TEST(Damage, CrackProfileHasTheToughnessOfTheOracle) {
  for (const auto& [h, row] : {std::pair{0.25, "at2.Q1.h0.25"}, std::pair{0.5, "at2.Q1.h0.50"}}) {
    const Profile p = profile(h, 1);
    EXPECT_NEAR(p.at_gamma, oracle((std::string(row) + ".phi(gam)").c_str()), 1e-9);
    EXPECT_NEAR(p.energy, oracle((std::string(row) + ".energy_over_Gc").c_str()), 1e-9);
  }
  EXPECT_NEAR(profile(0.02, 1).at_gamma, oracle("at2.phi(gam)"), 1e-5);
  EXPECT_NEAR(profile(0.02, 1).energy, oracle("at2.energy_full_bar_over_Gc"), 1e-4);
  // the spatial gradient scales the toughness by 1/stretch
  EXPECT_NEAR(profile(0.02, 1.5).energy, oracle("at2.stretch1.5.energy_over_Gc.spatial_gradient"), 1e-4);
}

TEST(Damage, DissipationOfAStep) { // lambda (phi - phi_n)^2 / dt over the volume
  UniformCell cell;
  for (auto& p : cell.phi_n) p = 0.2;
  for (auto& p : cell.phi) p = 0.25;
  Batch points[Quad4::points] = {};
  kernels<Quad4, Frame::plane_strain>().damage_dissipation(cell.law, cell.phi, cell.phi_n, 1e-5, points);
  const Batch sum = kernels<Quad4, Frame::plane_strain>().cell_integral(cell.X, points);
  EXPECT_NEAR(sum[0], 0.8 / 1e-3 * 0.05 * 0.05 / 1e-5 * 1e-6, 1e-12 * sum[0]);
}
