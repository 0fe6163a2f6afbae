#include "law_sampler.hpp"

#include <gtest/gtest.h>

using namespace impact;
using reference::aluminium;
using reference::dense;
using reference::Matrix;
using reference::Sampler;

namespace {

using Complex = reference::Complex;

PointInput<double, 3> point(const Matrix<double>& F, const PointHistory<double, 3>& old, double phi,
                            double theta) {
  Matrix<double> H = F;
  for (unsigned i = 0; i < 3; ++i) H[4 * i] -= 1;
  return {reference::tensor<3>(H), old, phi, theta};
}

Matrix<double> rotation(Sampler& random) {
  const double a = random.uniform(-3, 3), b = random.uniform(-3, 3);
  const Matrix<double> z{std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1};
  const Matrix<double> x{1, 0, 0, 0, std::cos(b), -std::sin(b), 0, std::sin(b), std::cos(b)};
  return reference::multiply(z, x);
}

double largest(const Matrix<double>& a) {
  double m = 0;
  for (double x : a) m = std::fmax(m, std::fabs(x));
  return m;
}
double distance(const Matrix<double>& a, const Matrix<double>& b) {
  double m = 0;
  for (unsigned i = 0; i < 9; ++i) m = std::fmax(m, std::fabs(a[i] - b[i]));
  return m;
}

} // namespace

TEST(PointLaw, StressIsTheDerivativeOfTheEnergy) { // S = 2 dpsi/dC, both splits, both signs of the volume
  Sampler random(1);
  for (int trial = 0; trial < 200; ++trial) {
    MaterialParameters m = aluminium();
    m.model = Model::elastic;
    m.split = trial % 2 ? Split::none : Split::volumetric;
    m.ge = trial % 3 == 0   ? Degradation::cubic
           : trial % 3 == 1 ? Degradation::quadratic
                            : Degradation::ductile;
    m.alpha_c = 0.1;
    Matrix<double> F = dense<3>(random.gradient<3>(0.1));
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    const auto old = PointHistory<double, 3>{identity<double, 3>(), random.uniform(0, 0.2)};
    const double phi = random.uniform(0, 0.9), theta = random.uniform(280, 400);
    const auto response = evaluate(PointLaw{m}, point(F, old, phi, theta));
    const Matrix<double> C = reference::multiply(reference::transpose(F), F), Fi = reference::inverse(F);
    Matrix<double> S{};
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) {
        Matrix<Complex> z{};
        for (unsigned k = 0; k < 9; ++k) z[k] = C[k];
        z[3 * i + j] += Complex(0, 0.5 * reference::step);
        z[3 * j + i] += Complex(0, 0.5 * reference::step);
        S[3 * i + j] =
            2 *
            reference::elastic_energy(m, z, dense<3>(old.A), std::sqrt(reference::det(z)), Complex(phi),
                                      reference::J_theta(m, Complex(theta)), old.alpha)
                .imag() /
            reference::step;
      }
    const Matrix<double> mine =
        reference::multiply(reference::multiply(Fi, dense<3>(response.tau)), reference::transpose(Fi));
    EXPECT_LT(distance(mine, S), 1e-12 * largest(S));
  }
}

TEST(PointLaw, AgreesWithThePlainImplementationInEveryLayout) {
  Sampler random(2);
  int flowing = 0;
  for (int trial = 0; trial < 500; ++trial) {
    MaterialParameters m = aluminium();
    m.gp = trial % 2 ? PlasticDegradation::ge : PlasticDegradation::one;
    m.linear_h = trial % 3 ? 0 : 1e9;
    const auto old = random.history<2>(0.02);
    const auto H = random.gradient<2>(0.02);
    const double phi = random.uniform(0, 0.6), theta = random.uniform(280, 400);
    const auto response = evaluate(PointLaw{m}, PointInput<double, 2>{H, old, phi, theta});
    Matrix<double> F = dense<2>(H);
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    const Matrix<double> tau = reference::kirchhoff(m, F, dense<2>(old.A), old.alpha, phi, theta);
    const auto flow = reference::return_map(m, F, dense<2>(old.A), old.alpha, phi);
    EXPECT_LT(distance(dense<2>(response.tau), tau), 1e-12 * largest(tau) + 1e-14 * m.K);
    EXPECT_LT(distance(dense<2>(response.history.A), flow.A), 1e-12);
    EXPECT_NEAR(response.history.alpha, flow.alpha, 1e-13);
    flowing += flow.dbeta > 0;

    PointInput<double, 3> solid{{}, {}, phi, theta};
    solid.H = reference::tensor<3>(dense<2>(H));
    solid.old = {reference::symmetric<3>(dense<2>(old.A)), old.alpha};
    EXPECT_LT(distance(dense<3>(evaluate(PointLaw{m}, solid).tau), tau), 1e-12 * largest(tau) + 1e-14 * m.K);
  }
  EXPECT_GT(flowing, 200);
  EXPECT_LT(flowing, 500);
}

TEST(PointLaw, BatchLanesAreIndependentPoints) {
  Sampler random(3);
  const PointLaw law{aluminium()};
  PointInput<Batch, 3> all;
  PointInput<double, 3> one[lanes];
  for (int l = 0; l < lanes; ++l) {
    one[l] = {random.gradient<3>(l ? 0.03 : 0.001), random.history<3>(0.001), random.uniform(0, 0.5),
              300 + 10.0 * l};
    for (int i = 0; i < 9; ++i) all.H[i].set(l, one[l].H[i]);
    for (int i = 0; i < 6; ++i) all.old.A[i].set(l, one[l].old.A[i]);
    all.old.alpha.set(l, one[l].old.alpha);
    all.phi.set(l, one[l].phi);
    all.theta.set(l, one[l].theta);
  }
  const auto batch = evaluate(law, all);
  for (int l = 0; l < lanes; ++l) {
    const auto single = evaluate(law, one[l]);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(batch.tau[i][l], single.tau[i], 1e-12 * law.parameters.K * 0.03);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(batch.history.A[i][l], single.history.A[i], 1e-13);
    EXPECT_NEAR(batch.energy.plus[l], single.energy.plus, 1e-12 * std::fabs(single.energy.plus));
  }
}

TEST(PointLaw, IsObjective) { // tau(Q F) = Q tau(F) Q^T, A and alpha unchanged
  Sampler random(4);
  for (int trial = 0; trial < 200; ++trial) {
    MaterialParameters m = aluminium();
    reference::set_hardening(m, trial % reference::hardening_kinds);
    const PointLaw law{m};
    Matrix<double> F = dense<3>(random.gradient<3>(0.03));
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    const auto old = random.history<3>(0.01);
    const Matrix<double> Q = rotation(random);
    PointInput<double, 3> straight = point(F, old, 0.2, 320),
                          round = point(reference::multiply(Q, F), old, 0.2, 320);
    straight.dt = round.dt = 1e-3;
    const auto a = evaluate(law, straight), b = evaluate(law, round);
    const Matrix<double> turned =
        reference::multiply(reference::multiply(Q, dense<3>(a.tau)), reference::transpose(Q));
    EXPECT_LT(distance(dense<3>(b.tau), turned), 1e-13 * law.parameters.K);
    EXPECT_LT(distance(dense<3>(a.history.A), dense<3>(b.history.A)), 1e-13);
    EXPECT_NEAR(a.history.alpha, b.history.alpha, 1e-14);
  }
}

TEST(PointLaw, DissipatesAndKeepsVolumeAlongRandomPaths) {
  Sampler random(5);
  double flowed = 0;
  for (int path = 0; path < 40; ++path) {
    MaterialParameters m = aluminium();
    reference::set_hardening(m, path % reference::hardening_kinds);
    const PointLaw law{m};
    auto state = virgin_history<double, 3>();
    Tensor<double, 3> H{};
    for (int n = 0; n < 50; ++n) {
      const auto dH = random.gradient<3>(0.004);
      for (int i = 0; i < 9; ++i) H[i] += dH[i];
      const PointInput<double, 3> in{H, state, 0.1, 320, 1e-3};
      const auto now = evaluate(law, in);
      const double z_trial = trace_excess(now.flow.trial, now.flow.y - 1),
                   z = trace_excess(now.flow.dev_b, now.flow.y - 1);
      const double released = isochoric_energy(m, z_trial - z); // W(b_trial) - W(b)
      EXPECT_GE(released, 0);
      EXPECT_GE(now.history.alpha, state.alpha);
      // plastic work = ||s|| dbeta up to O(dbeta^2) and the flow-rule approximation of theory.md, E10
      const double norm = m.G * std::sqrt(dot(now.flow.dev_b, now.flow.dev_b)),
                   expected = norm * now.flow.dbeta;
      EXPECT_NEAR(released, expected, 0.03 * expected + 2 * m.G * now.flow.dbeta * now.flow.dbeta);
      EXPECT_NEAR(det(now.history.A), 1, 1e-12);
      // ||s|| dbeta = g_p k dalpha / g_1: what is stored and what becomes heat, rate and all, are that work
      const double dalpha = now.history.alpha - state.alpha,
                   heat = dissipative_stress(m, now.flow.at, now.history.alpha, dalpha) * dalpha;
      const double kept = (1 - m.taylor_quinney) * now.flow.at.softening *
                          (plastic_potential(m, now.history.alpha) - plastic_potential(m, state.alpha));
      const double g_1 = degradations(m, 0.1, state.alpha).e1.g, k = hardening(m, now.history.alpha).k;
      double change = 0; // of k_0 over the step: what is stored is its integral, not its end times dalpha
      for (int i = 0; i <= 50; ++i)
        change = std::fmax(change, std::fabs(hardening(m, state.alpha + i * dalpha / 50).k - k));
      EXPECT_GE(heat, 0);
      EXPECT_GE(kept, 0);
      EXPECT_NEAR(kept + heat, g_1 * expected, 1e-9 * g_1 * expected + 0.1 * change * dalpha);
      state = now.history;
    }
    flowed += state.alpha;
  }
  EXPECT_GT(flowed, 1.0);
}

TEST(PointLaw, SecondCallFromTheNewHistoryChangesNothing) {
  Sampler random(6);
  const PointLaw law{aluminium()};
  for (int trial = 0; trial < 200; ++trial) {
    PointInput<double, 3> in{random.gradient<3>(0.03), virgin_history<double, 3>(), 0.2, 310};
    const auto first = evaluate(law, in);
    ASSERT_GT(first.history.alpha, 0);
    in.old = first.history;
    const auto second = evaluate(law, in);
    EXPECT_LT(distance(dense<3>(first.tau), dense<3>(second.tau)), 1e-13 * law.parameters.K);
    EXPECT_LT(distance(dense<3>(first.history.A), dense<3>(second.history.A)), 1e-13);
    EXPECT_NEAR(first.history.alpha, second.history.alpha, 1e-14);
  }
}

TEST(PointLaw,
     BrokenPointCarriesNoDeviatorAndDoesNotFlow) { // g_p = 1: the yield stress stays, the stress goes to 0
  MaterialParameters m = aluminium();
  Sampler random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const auto in =
        PointInput<double, 3>{random.gradient<3>(0.05), virgin_history<double, 3>(), 1.0, m.theta0};
    const auto out = evaluate(PointLaw{m}, in);
    EXPECT_EQ(out.history.alpha, 0);
    const auto deviator = dev(out.tau);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(deviator[i], 0, 1e-15 * m.K);
    m.gp = PlasticDegradation::ge; // undegraded yield: the same point flows, independent of phi
    m.residual_stiffness = 1e-6;
    const auto flows = evaluate(PointLaw{m}, in);
    auto sound = in;
    sound.phi = 0;
    EXPECT_GT(flows.history.alpha, 0);
    EXPECT_NEAR(flows.history.alpha, evaluate(PointLaw{m}, sound).history.alpha, 1e-15);
    m.gp = PlasticDegradation::one;
    m.residual_stiffness = 0;
  }
}

TEST(PointLaw,
     SmallStrainEnergyKeepsItsDigits) { // psi -> K/2 tr^2 + G dev:dev, at strains where tr b - 3 is all noise
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  const double e = 1e-9;
  PointInput<double, 2> in{{}, virgin_history<double, 2>(), 0, m.theta0};
  in.H = {{2 * e, 0.5 * e, 0.3 * e, -e, 0}};
  const auto out = evaluate(PointLaw{m}, in);
  const double mean = e / 3, xy = 0.4 * e;
  const double deviator =
      (2 * e - mean) * (2 * e - mean) + (e + mean) * (e + mean) + mean * mean + 2 * xy * xy;
  EXPECT_NEAR((out.energy.plus + out.energy.minus) / (m.K / 2 * e * e + m.G * deviator), 1, 1e-7);
  EXPECT_NEAR(out.tau[3] / (2 * m.G * xy), 1, 1e-7);
}

TEST(PointLaw, LinearHardeningAddsToVoce) { // uniaxial isochoric limit: flow stress at alpha is k(alpha)
  MaterialParameters m = aluminium();
  m.linear_h = 2e9;
  const PointLaw law{m};
  auto state = virgin_history<double, 3>();
  for (int n = 1; n <= 40; ++n) {
    PointInput<double, 3> in{{}, state, 0, m.theta0};
    in.H = Tensor<double, 3>{{0, 0.002 * n, 0, 0, 0, 0, 0, 0, 0}};
    const auto out = evaluate(law, in);
    state = out.history;
    if (state.alpha == 0) continue;
    const auto s = dev(out.tau);
    const double k =
        m.sigma_y + m.voce_r * (1 - std::exp(-m.voce_s * state.alpha)) + m.linear_h * state.alpha;
    EXPECT_NEAR(std::sqrt(1.5 * dot(s, s)), k, 1e-9 * k);
  }
  EXPECT_GT(state.alpha, 0.03);
}
