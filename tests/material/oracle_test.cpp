#include "law_sampler.hpp"
#include "oracle_values.hpp"

#include <gtest/gtest.h>
#include <impact/material/crack.hpp>
#include <impact/material/modulus.hpp>
#include <string>

using namespace impact;
using reference::aluminium;
using reference::dense;
using reference::Matrix;
using reference::oracle;

namespace {

void expect_row(const std::string& name, double value, double tolerance = 1e-9) {
  const double expected = oracle(name.c_str());
  EXPECT_NEAR(value, expected, tolerance * std::fabs(expected) + 1e-20) << name;
}

/// A path of displacement gradients at phi = 0, theta = theta_0; check(step, response) after each step.
template <class Path, class Check> void drive(const PointLaw& law, int steps, Path&& path, Check&& check) {
  auto state = virgin_history<double, 2>();
  for (int n = 1; n <= steps; ++n) {
    const auto out = evaluate(law, PointInput<double, 2>{path(n), state, 0, law.parameters.theta0});
    state = out.history;
    check(n, out);
  }
}

PointHistory<double, 2> prestrained(const PointLaw& law) {
  PointHistory<double, 2> state;
  drive(
      law, 5,
      [](int n) {
        return Tensor<double, 2>{{0.004 * n / 5, 0.02 * n / 5, 0, 0, 0}};
      },
      [&](int, const auto& out) { state = out.history; });
  return state;
}

Matrix<double> second_piola(const Tensor<double, 2>& H, const Symmetric<double, 2>& tau) {
  const Matrix<double> Fi = dense<2>(kinematics(H).inverse_F);
  return reference::multiply(reference::multiply(Fi, dense<2>(tau)), reference::transpose(Fi));
}

} // namespace

TEST(Oracle, Moduli) {
  expect_row("elastic.G", aluminium().G);
  expect_row("elastic.K", aluminium().K);
}

TEST(Oracle, UniaxialStrainLoadsAndUnloads) {
  drive(
      PointLaw{aluminium()}, 30,
      [](int n) {
        return Tensor<double, 2>{{n <= 20 ? 0.02 * n / 20 : 0.02 - 0.01 * (n - 20) / 10, 0, 0, 0, 0}};
      },
      [](int n, const auto& out) {
        if (n != 5 && n != 20 && n != 30) return;
        const std::string row = "uniax.det.step" + std::to_string(n);
        const auto P = first_piola(out.tau, out.k.inverse_F);
        expect_row(row + ".P11", P[0]);
        expect_row(row + ".P22", P[3]);
        expect_row(row + ".alpha", out.history.alpha);
        expect_row(row + ".Cpinv11", out.history.A[0]);
      });
}

TEST(Oracle, SimpleShearForwardAndBack) {
  const PointLaw law{aluminium()};
  const auto shear = [](int n) {
    return n <= 10 ? 0.005 * n : n <= 20 ? 0.05 - 0.003 * (n - 10) : 0.02 + 0.006 * (n - 20);
  };
  drive(
      law, 30,
      [&](int n) {
        return Tensor<double, 2>{{0, shear(n), 0, 0, 0}};
      },
      [&](int n, const auto& out) {
        if (n != 1 && n % 10 != 0) return;
        const std::string row = "shear.det.step" + std::to_string(n);
        expect_row(row + ".tau12", out.tau[3]);
        expect_row(row + ".tau11", out.tau[0]);
        expect_row(row + ".tau33", out.tau[2]);
        expect_row(row + ".S12", second_piola({{0, shear(n), 0, 0, 0}}, out.tau)[1]);
        expect_row(row + ".alpha", out.history.alpha);
        expect_row(row + ".detCpinv", det(out.history.A), 1e-12);
        expect_row(row + ".Wbar", out.energy.plus + out.energy.minus);
      });
}

TEST(Oracle, DamagedShearYieldsByEitherDegradation) {
  for (int gp = 0; gp < 2; ++gp) {
    MaterialParameters m = aluminium();
    m.gp = gp ? PlasticDegradation::ge : PlasticDegradation::one;
    const auto out = evaluate(
        PointLaw{m}, PointInput<double, 2>{{{0, 0.05, 0, 0, 0}}, virgin_history<double, 2>(), 0.3, m.theta0});
    expect_row("shear1.phi0.3.gp" + std::to_string(gp) + ".tau12", out.tau[3]);
    expect_row("shear1.phi0.3.gp" + std::to_string(gp) + ".alpha", out.history.alpha);
  }
}

TEST(Oracle, VolumetricSplit) {
  for (int split = 0; split < 2; ++split)
    for (int compressed = 0; compressed < 2; ++compressed) {
      MaterialParameters m = aluminium();
      m.split = split ? Split::volumetric : Split::none;
      const double e = compressed ? -0.01 : 0.01;
      const Tensor<double, 2> H{{e, 0, 0, e, e}};
      const auto out =
          evaluate(PointLaw{m}, PointInput<double, 2>{H, virgin_history<double, 2>(), 0.3, m.theta0});
      const auto g = degradations(m, 0.3, 0.0);
      const std::string row =
          std::string("vol.") + (compressed ? "0.99" : "1.01") + ".split" + std::to_string(split);
      expect_row(row + ".S11", second_piola(H, out.tau)[0]);
      expect_row(row + ".psi_e", g.e1.g * out.energy.plus + g.e2.g * out.energy.minus);
      expect_row(row + ".Eplus", out.energy.plus);
      expect_row(row + ".Eminus", out.energy.minus);
    }
}

TEST(Oracle, ThermalExpansion) {
  MaterialParameters m = aluminium();
  const double theta = 348.15, J_th = thermal_volume(m, theta), stretch = std::cbrt(J_th);
  expect_row("thermal.Jtheta(dT=50)", J_th);
  expect_row("thermal.free_stretch", stretch);
  const Tensor<double, 2> free{{stretch - 1, 0, 0, stretch - 1, stretch - 1}};
  const auto out = evaluate(PointLaw{m}, PointInput<double, 2>{free, virgin_history<double, 2>(), 0, theta});
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(out.tau[i], 0, 1e-14 * m.K);
  const auto held = evaluate(PointLaw{m}, PointInput<double, 2>{{}, virgin_history<double, 2>(), 0, theta});
  expect_row("thermal.constrained.S11", held.tau[0]);
}

/// Root of f between low and high, by bisection.
template <class F> double bisect(F&& f, double low, double high) {
  const bool rises = f(high) > f(low);
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    ((f(middle) > 0) == rises ? high : low) = middle;
  }
  return (low + high) / 2;
}

/// Entropy of a point of elastic volume ratio J/J_th, undamaged.
double entropy(const MaterialParameters& m, double theta, double J) {
  const double Je_minus_1 = J / thermal_volume(m, theta) - 1;
  return m.c_v * log_ratio(theta, m.theta0) + thermoelastic_entropy(m, Je_minus_1, 1.0);
}

TEST(Oracle, HeatAtConstantEntropy) {
  MaterialParameters m = aluminium();
  m.c_v = 2.43e6;
  const double capacity = heat_capacity(m, 0.0, 1.0, m.theta0);
  expect_row("thermal.c_eff(th0,J=1)", capacity);
  // d eta/d ln J = 3 alpha_t g_v K J_e^2 against c_eff/theta.
  const double h = 1e-6, slope = (entropy(m, m.theta0, 1 + h) - entropy(m, m.theta0, 1 - h)) / (2 * h);
  expect_row("thermal.isentropic_slope_dT_per_lnJ", -m.theta0 * slope / capacity, 1e-8);
  const double theta = bisect([&](double x) { return entropy(m, x, 1.002); }, 290, 300);
  expect_row("thermal.isentropic.theta(J=1.002)", theta);
}

TEST(Oracle, HeatOfPlasticShear) {
  MaterialParameters m = aluminium();
  m.c_v = 2.43e6;
  auto old = virgin_history<double, 2>();
  double work = 0;
  for (int i = 1; i <= 200; ++i) {
    const Tensor<double, 2> H{{0, 0.2 * i / 200, 0, 0, 0}};
    const auto out = evaluate(PointLaw{m}, PointInput<double, 2>{H, old, 0, m.theta0});
    work += hardening(m, out.history.alpha).k * (out.history.alpha - old.alpha);
    old = out.history;
  }
  expect_row("heat.shear0.2.alpha", old.alpha, 1e-8);
  expect_row("heat.shear0.2.Wp_backward_Euler", work, 1e-8);
  expect_row("heat.shear0.2.H0(alpha)", plastic_potential(m, old.alpha), 1e-8);
  const auto energy = [&](double theta) { // at J = 1
    const double Je_minus_1 = 1 / thermal_volume(m, theta) - 1;
    return volumetric_energy(m, Je_minus_1) + m.c_v * (theta - m.theta0) +
           thermoelastic_energy(m, Je_minus_1, 1.0, theta);
  };
  for (const auto& [chi, name] : {std::pair{1.0, "1.0"}, {0.9, "0.9"}}) {
    const std::string row = name;
    const double share = chi;
    expect_row("heat.shear0.2.theta.chi" + row,
               bisect([&](double x) { return energy(x) - share * work; }, m.theta0, 400), 1e-8);
    expect_row("heat.shear0.2.theta_simple(cV only).chi" + row, m.theta0 + share * work / m.c_v, 1e-8);
  }
}

TEST(Oracle, FatigueAtConstantPower) {
  MaterialParameters m = aluminium();
  m.fatigue_a = 5e-7;
  expect_row("fatigue.F(1e-3)", fatigue_growth(m, 0.1, 1e9 * 1e-3));
}

TEST(Oracle, ViscousStress) {
  const double b_d = 3e6, rate = 10, t = 1e-3, dt = 1e-4;
  const Tensor<double, 2> H{{rate * t, 0, 0, 0, 0}}, dH{{rate * dt, 0, 0, 0, 0}};
  expect_row("visc.Sd11.discrete", 2 * b_d / dt * right_increment(plus_identity(H), dH)[0]);
  const double fine = 1e-8; // the step that goes to 0 gives the exact rate
  const Tensor<double, 2> small{{rate * fine, 0, 0, 0, 0}};
  expect_row("visc.Sd11.exact", 2 * b_d / fine * right_increment(plus_identity(H), small)[0], 1e-6);
}

TEST(Oracle, GeneralState) { // every stress part and energy; in-plane Grad phi
  MaterialParameters m = aluminium();
  const auto old = prestrained(PointLaw{m});
  expect_row("state.alpha", old.alpha);
  expect_row("state.Cpinv11", old.A[0]);
  expect_row("state.Cpinv22", old.A[1]);
  expect_row("state.Cpinv33", old.A[2]);
  expect_row("state.Cpinv12", old.A[3]);
  expect_row("state.psi_p", plastic_potential(m, old.alpha));

  m.sigma_y = 1e12; // the rows are the elastic law at fixed history
  const double phi = 0.3, theta = 320;
  const Tensor<double, 2> H{{0.02, 0.03, -0.01, -0.005, 0}};
  const auto out = evaluate(PointLaw{m}, PointInput<double, 2>{H, old, phi, theta});
  const Matrix<double> S = second_piola(H, out.tau);
  expect_row("state.Sc11", S[0]);
  expect_row("state.Sc22", S[4]);
  expect_row("state.Sc12", S[1]);
  expect_row("state.Sc33", S[8]);
  expect_row("state.psi_e", degradations(m, phi, 0.0).e1.g * out.energy.plus + out.energy.minus);
  expect_row("state.Eplus", out.energy.plus);
  EXPECT_EQ(out.energy.minus, oracle("state.Eminus"));

  const Vector<double, 2> h = spatial_gradient(out.k.inverse_F, Vector<double, 2>{{300, -450}});
  const Matrix<double> S_phi = second_piola(H, crack_stress(m, h));
  expect_row("state.Sphi11", S_phi[0]);
  expect_row("state.Sphi22", S_phi[4]);
  expect_row("state.Sphi12", S_phi[1]);
  EXPECT_EQ(S_phi[8], 0);
  expect_row("state.psi_phi", crack_energy(m, phi, dot(h, h)));
  m.c_v = 2.43e6; // psi_theta = e - theta eta
  expect_row("state.psi_theta", m.c_v * (theta - m.theta0) + thermoelastic_energy(m, 0.0, 1.0, theta) -
                                    theta * m.c_v * log_ratio(theta, m.theta0));
}

TEST(Oracle, PlasticTangent) {
  MaterialParameters m = aluminium();
  const PointLaw law{m};
  const auto old = prestrained(law);
  PointInput<double, 3> in{{{0.008, 0.035, 0, 0, 0, 0, 0, 0, 0}},
                           {reference::symmetric<3>(dense<2>(old.A)), old.alpha},
                           0.05,
                           320};
  const auto out = evaluate(law, in);
  expect_row("tang.dbeta", out.flow.dbeta);
  expect_row("tang.alpha", out.history.alpha);

  // A_iJkL = F^-1_Jj F^-1_Ll a_ijkl
  const auto a = point_modulus<9>(law, in);
  const auto& Fi = out.k.inverse_F;
  double A[3][3][3][3], norm = 0;
  for (int i = 0; i < 3; ++i)
    for (int J = 0; J < 3; ++J)
      for (int k = 0; k < 3; ++k)
        for (int L = 0; L < 3; ++L) {
          A[i][J][k][L] = 0;
          for (int j = 0; j < 3; ++j)
            for (int l = 0; l < 3; ++l)
              A[i][J][k][L] += Fi[3 * J + j] * Fi[3 * L + l] * a.c[3 * i + j][3 * k + l];
          norm += A[i][J][k][L] * A[i][J][k][L];
        }
  const char* rows[] = {"1111", "1112", "1212", "1221", "2222", "1122", "2211", "3311"};
  for (const char* r : rows)
    expect_row(std::string("tang.A") + r, A[r[0] - '1'][r[1] - '1'][r[2] - '1'][r[3] - '1']);
  expect_row("tang.Frobenius", std::sqrt(norm));
}

TEST(Oracle, TangentIsUnsymmetricByTheKnownAmount) { // defect of c = a - delta_ik tau_jl, relative to max |c|
  for (int gp = 0; gp < 2; ++gp) {
    MaterialParameters m = aluminium();
    m.gp = gp ? PlasticDegradation::ge : PlasticDegradation::one;
    const PointLaw law{m};
    const auto old = prestrained(law);
    const PointInput<double, 3> in{{{0.008, 0.035, 0, 0, 0, 0.012, -0.004, 0, 0}},
                                   {reference::symmetric<3>(dense<2>(old.A)), old.alpha},
                                   0.05,
                                   320};
    const auto tau = evaluate(law, in).tau;
    const auto a = point_modulus<9>(law, in), symmetrised = point_modulus<9>(law, in, true);
    double defect = 0, largest = 0;
    for (int I = 0; I < 9; ++I)
      for (int K = 0; K < 9; ++K) {
        const int i = I / 3, j = I % 3, k = K / 3, l = K % 3;
        defect = std::fmax(defect, std::fabs(a.c[I][K] - a.c[K][I]));
        largest = std::fmax(largest, std::fabs(a.c[I][K] - (i == k ? tau[symmetric_index(3, j, l)] : 0)));
        EXPECT_NEAR(symmetrised.c[I][K], 0.5 * (a.c[I][K] + a.c[K][I]), 1e-13 * m.K);
      }
    expect_row("tangent.asym_defect.det.gp" + std::to_string(gp), defect / largest, 1e-8);
  }
}
