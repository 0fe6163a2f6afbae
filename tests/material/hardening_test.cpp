#include "law_sampler.hpp"

#include <array>
#include <gtest/gtest.h>
#include <impact/material/flow_stress.hpp>
#include <impact/material/plasticity.hpp>
#include <random>

using namespace impact;
using reference::aluminium;
using reference::Complex;

namespace {

MaterialParameters steel() { // 42CrMo4, Johnson-Cook (stress in MPa)
  MaterialParameters m = aluminium();
  m.hardening = HardeningKind::power;
  m.sigma_y = 806, m.power_b = 614, m.power_n = 0.168;
  m.rate_c = 0.0089, m.rate_0 = 1;
  m.softening = Softening::johnson_cook;
  m.theta_ref = 293.15, m.theta_melt = 1813.15, m.softening_m = 1.1;
  m.G = 79.23e3;
  return m;
}

} // namespace

TEST(Hardening, SlopeAndPotentialAreTheDerivativeAndTheIntegralOfTheFlowStress) {
  for (int kind = 0; kind < reference::hardening_kinds; ++kind) {
    MaterialParameters m = aluminium();
    reference::set_hardening(m, kind);
    EXPECT_NEAR(plastic_potential(m, 0.0), 0, 1e-290) << kind;
    for (const double alpha : {1e-9, 1e-5, 0.0037, 0.011, 0.019, 0.043, 0.07, 0.9}) {
      const double h = 1e-25 * alpha, k = hardening(m, alpha).k;
      const Complex z(alpha, h);
      EXPECT_NEAR(hardening(m, alpha).dk, imag(hardening(m, z).k) / h, 1e-12 * k / alpha) << kind;
      EXPECT_NEAR(k, imag(plastic_potential(m, z)) / h, 1e-13 * k) << kind;
      EXPECT_NEAR(k, reference::static_stress(m, alpha), 1e-14 * k) << kind;
      Batch all;
      for (int l = 0; l < lanes; ++l) all.set(l, alpha * (1 + l));
      for (int l = 0; l < lanes; ++l) {
        const auto one = hardening(m, alpha * (1 + l));
        EXPECT_NEAR(hardening(m, all).k[l], one.k, 1e-14 * k);
        EXPECT_NEAR(hardening(m, all).dk[l], one.dk, 1e-13 * std::fabs(one.dk));
        EXPECT_NEAR(plastic_potential(m, all)[l], plastic_potential(m, alpha * (1 + l)),
                    1e-12 * k * alpha * lanes);
      }
    }
  }
}

// k(alpha = 0.1, rate, theta) of the steel by hand: 806 + 614 0.1^0.168 = 1223.03103; 1 + 0.0089 ln 1000 =
// 1.06147902; T* = (600 - 293.15)/1520 = 0.20187500, 1 - T*^1.1 = 0.82797531
TEST(Hardening, JohnsonCookAtGivenRateAndTemperature) {
  const MaterialParameters m = steel();
  const double dt = 1e-5, dalpha = 1e3 * dt;
  const FlowConditions<double> cold{softening(m, 293.15), dt}, warm{softening(m, 600.0), dt};
  EXPECT_NEAR(softening(m, 600.0), 0.827975, 1e-6);
  EXPECT_NEAR(hardening(m, 0.1).k, 1223.03103, 1e-5);
  EXPECT_NEAR(flow_stress(m, cold, 0.1, dalpha).k, 1223.03103 * 1.06147902, 2e-3);
  EXPECT_NEAR(flow_stress(m, warm, 0.1, dalpha).k, 1223.03103 * 1.06147902 * 0.82797531, 2e-3);
  // slower than rate_0, colder than theta_ref, hotter than the melt
  EXPECT_EQ(flow_stress(m, cold, 0.1, 0.5 * dt).k, hardening(m, 0.1).k);
  EXPECT_EQ(softening(m, 200.0), 1);
  EXPECT_EQ(softening(m, 1813.2), 0);
  EXPECT_EQ(softening(m, 3000.0), 0);
}

// (1 + 1e3/1)^0.0089 = 1.0634176477 of the steel, and at rest 1 without a kink.
TEST(Hardening, RateFactorAsAPower) {
  MaterialParameters m = steel();
  m.rate_form = RateForm::power;
  EXPECT_NEAR(rate_factor(m, 1e-5, 1e-2).k, 1.0634176477, 1e-10);
  EXPECT_EQ(rate_factor(m, 1e-5, 0.0).k, 1);
  EXPECT_NEAR(rate_factor(m, 1e-5, 0.0).dk, 0.0089 / 1e-5, 1e-9);
}

TEST(Hardening, FlowStressAndItsSlopeAlongTheStep) {
  for (int kind = 0; kind < reference::hardening_kinds; ++kind) {
    MaterialParameters m = aluminium();
    reference::set_hardening(m, kind);
    for (const double theta : {250.0, 330.0, 700.0, 1100.0})
      for (const double dalpha : {1e-6, 1.1e-3, 0.02, 0.5}) {
        const double alpha_n = 0.0041, dt = 1e-3, h = 1e-20;
        const FlowConditions<double> at{softening(m, theta), dt};
        const auto k = flow_stress(m, at, alpha_n + dalpha, dalpha);
        const Complex a(alpha_n + dalpha, h), da(dalpha, h);
        const Complex expected = reference::flow_stress(m, a, da, theta, dt);
        EXPECT_NEAR(k.k, real(expected), 1e-13 * m.sigma_y) << kind;
        EXPECT_NEAR(k.dk, imag(expected) / h, 1e-12 * (std::fabs(k.dk) + m.sigma_y)) << kind;
        EXPECT_GE(dissipative_stress(m, at, alpha_n + dalpha, dalpha), 0);
      }
  }
}

TEST(Hardening, VerticalStartIsSolvedInEveryDecade) { // alpha from 1e-90 to 1e-3, in lanes of one batch
  MaterialParameters m = steel();
  m.rate_c = 0;
  m.softening = Softening::none;
  const double q = std::sqrt(2.0 / 3);
  for (int decade = 0; decade <= 15; ++decade) {
    Symmetric<Batch, 3> e;
    for (int i = 0; i < 6; ++i) e[i] = 0.0;
    for (int l = 0; l < lanes; ++l)
      e[3].set(l, q * m.sigma_y * (1 + std::pow(10.0, -decade) * (1 + l)) / m.G / std::sqrt(2.0));
    const auto flow = return_map(m, e, Batch(1.0), Batch(0.0), Batch(1.0));
    EXPECT_EQ(flow.failed, 0) << decade;
    for (int l = 0; l < lanes; ++l) {
      Symmetric<double, 3> s;
      for (int i = 0; i < 6; ++i) s[i] = flow.dev_b[i][l];
      const double norm = m.G * std::sqrt(dot(s, s)),
                   k = m.sigma_y + m.power_b * std::pow(flow.alpha[l], 0.168);
      EXPECT_NEAR(norm, q * k, 4e-15 * norm) << decade;
      if (decade < 14) {
        EXPECT_GT(flow.alpha[l], 0) << decade;
      }
    }
  }
}

// A point slightly above its yield stress at rest flows at the rate that carries the rest, in every decade of
// overstress, hardening, step and degradation. Reference: bisection.
TEST(Hardening, SlightOverstressFlowsAtTheRateThatCarriesIt) {
  const double q = std::sqrt(2.0 / 3);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  const auto decades = [&](double from, double to) {
    return std::pow(10.0, from + (to - from) * part(random));
  };
  for (int trial = 0; trial < 4000; ++trial) {
    MaterialParameters m = aluminium();
    reference::set_hardening(m, trial % reference::hardening_kinds);
    m.softening = Softening::none;
    m.rate_c = decades(-3, -1.5), m.rate_0 = 1;
    m.rate_form = trial / reference::hardening_kinds % 2 ? RateForm::power : RateForm::logarithm;
    const FlowConditions<double> at{1, decades(-9, -3)};
    std::array<double, lanes> alpha, ratio, N;
    Batch alphas, ratios;
    Symmetric<Batch, 3> e;
    for (int i = 0; i < 6; ++i) e[i] = 0.0;
    for (int l = 0; l < lanes; ++l) {
      alpha[l] = decades(-4, 0), ratio[l] = decades(0, 1.2);
      N[l] = q * ratio[l] * hardening(m, alpha[l]).k * (1 + decades(-9, -1));
      alphas.set(l, alpha[l]), ratios.set(l, ratio[l]);
      e[3].set(l, N[l] / m.G / std::sqrt(2.0));
    }
    const auto flow = return_map(m, e, Batch(1.0), alphas, ratios, {Batch(1.0), at.dt});
    ASSERT_EQ(flow.failed, 0);
    for (int l = 0; l < lanes; ++l) {
      double low = 0, high = N[l] / (2 * m.G);
      for (int i = 0; i < 200; ++i) {
        const double x = (low + high) / 2, k = flow_stress(m, at, alpha[l] + q * x, q * x).k;
        (N[l] - 2 * m.G * x > q * ratio[l] * k ? low : high) = x;
      }
      EXPECT_NEAR(flow.scale[l] * N[l], N[l] - 2 * m.G * low, 1e-9 * N[l])
          << "law " << trial % reference::hardening_kinds << ", dt " << at.dt << ", alpha " << alpha[l];
    }
  }
}

TEST(Hardening, TableOfVoceIsVoceToTheSquareOfItsSpacing) {
  MaterialParameters voce = aluminium();
  double before = 0;
  for (const int rows : {26, 51, 101}) {
    MaterialParameters m = voce;
    std::vector<std::pair<double, double>> points;
    for (int i = 0; i < rows; ++i)
      points.emplace_back(0.1 * i / (rows - 1), hardening(voce, 0.1 * i / (rows - 1)).k);
    m.hardening = HardeningKind::table;
    const HardeningTable table(points);
    m.table = &table;
    double worst = 0;
    for (double alpha = 0; alpha < 0.1; alpha += 1.3e-4)
      worst = std::fmax(worst, std::fabs(hardening(m, alpha).k - hardening(voce, alpha).k));
    const double h = 0.1 / (rows - 1), bound = voce.voce_r * voce.voce_s * voce.voce_s * h * h / 8;
    EXPECT_LT(worst, bound);
    EXPECT_GT(worst, 0.7 * bound);
    EXPECT_NEAR(plastic_potential(m, 0.1), plastic_potential(voce, 0.1), bound * 0.1);
    EXPECT_EQ(hardening(m, 0.3).k, points.back().second); // constant after the last row
    if (before > 0) {
      EXPECT_NEAR(before / worst, 4, 0.2);
    }
    before = worst;
  }
}

TEST(Hardening, TableRefusesWhatIsNoFlowCurve) {
  const auto message = [](const std::vector<std::pair<double, double>>& points) {
    try {
      HardeningTable table(points);
    } catch (const std::invalid_argument& reason) {
      return std::string(reason.what());
    }
    return std::string();
  };
  EXPECT_EQ(message({}), "no rows");
  EXPECT_EQ(message({{0.1, 5}}), "row 1: the first alpha must be 0");
  EXPECT_EQ(message({{0, 5}, {0.1, 6}, {0.1, 7}}), "row 3: alpha must grow from row to row");
  EXPECT_EQ(message({{0, 5}, {0.1, 0}}), "row 2: the flow stress must be positive");
  EXPECT_EQ(message({{0, 5}}), "");
}
