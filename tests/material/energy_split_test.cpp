#include "law_sampler.hpp"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <impact/material/modulus.hpp>
#include <vector>

using namespace impact;
using reference::aluminium;
using reference::dense;
using reference::Matrix;
using reference::Sampler;

namespace {

using Complex = std::complex<double>;

MaterialParameters with_split(Split split) {
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  m.split = split;
  m.star_gamma = 2;
  m.cone = 0.3;
  return m;
}
MaterialParameters spectral() { return with_split(Split::spectral); }

/// g_1 E+ + g_2 E- of principal stretches, written out with logarithms and without any care for small
/// numbers.
Complex energy(const MaterialParameters& m, const Complex (&stretch)[3], double g1) {
  const Complex J = stretch[0] * stretch[1] * stretch[2], w = std::pow(J, -2.0 / 3), log_J = std::log(J);
  const Complex V =
      m.K / 2 * ((J * J - 1.0) / 2.0 - log_J) + m.G / 2 * ((w - 1.0) * (3.0 + 2.0 * log_J) + 2.0 * log_J);
  Complex sum = (J.real() >= 1 ? g1 : 1) * V;
  for (const Complex& s : stretch)
    sum += (s.real() >= 1 ? g1 : 1) * m.G / 2 * w * (s * s - 1.0 - 2.0 * std::log(s));
  return sum;
}

/// R diag(stretch) Q with random rotations.
struct Motion {
  Matrix<double> F, R;
  explicit Motion(Sampler& random, const double (&stretch)[3]) {
    Symmetric<double, 3> a, b;
    for (int i = 0; i < 6; ++i) a[i] = random.uniform(-1, 1), b[i] = random.uniform(-1, 1);
    const EigenSystem<double> left = eigen_system(a), right = eigen_system(b);
    Matrix<double> U{};
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) {
        R[3 * i + j] = left.vector[j][i];
        for (unsigned k = 0; k < 3; ++k) U[3 * i + j] += left.vector[k][i] * stretch[k] * right.vector[k][j];
      }
    F = U;
    if (reference::det(F) < 0)
      for (double& x : F) x = -x;
  }
  Tensor<double, 3> H() const {
    Matrix<double> h = F;
    for (unsigned i = 0; i < 3; ++i) h[4 * i] -= 1;
    return reference::tensor<3>(h);
  }
};

/// Stretches of all signs, equal, nearly equal and equal to one.
std::vector<std::array<double, 3>> states() {
  std::vector<std::array<double, 3>> all = {{1.1, 0.95, 1.02}, {1.05, 1.05, 0.9},  {0.9, 0.9, 0.9},
                                            {1.1, 1.1, 1.1},   {1.2, 1, 1},        {0.8, 1, 1},
                                            {1, 1, 1},         {0.97, 0.97, 1.08}, {1.001, 0.999, 1.0}};
  for (const double gap : {1e-16, 1e-13, 1e-9, 1e-5})
    for (const double base : {1.07, 0.93, 1.0})
      all.push_back({base, base * (1 + gap), 1.03}), all.push_back({base, base * (1 - gap), 0.96});
  return all;
}

} // namespace

TEST(EnergySplit, PartsAddUpToTheEnergyAndAreNeverNegative) {
  Sampler random(71);
  for (const Split kind : {Split::spectral, Split::no_tension, Split::drucker_prager})
    for (int k = 0; k < 500; ++k) {
      const double size = k % 3 == 0 ? 0.3 : k % 3 == 1 ? 1e-3 : 1e-9;
      const PointInput<double, 3> in{random.gradient<3>(size), virgin_history<double, 3>(), 0.3,
                                     k % 2 ? 298.15 : random.uniform(250, 350)};
      const auto split = evaluate(PointLaw{with_split(kind)}, in);
      const auto all = evaluate(PointLaw{with_split(Split::none)}, in);
      const double sum = all.energy.plus + all.energy.minus;
      EXPECT_NEAR(split.energy.plus + split.energy.minus, sum, (kind == Split::spectral ? 1e-11 : 1e-9) * sum)
          << size;
      EXPECT_GE(split.energy.plus, 0);
      EXPECT_GE(split.energy.minus, 0);
    }
}

TEST(EnergySplit, StressIsTheDerivativeOfTheEnergyAlsoWhereStretchesAreEqual) {
  Sampler random(72);
  const PointLaw law{spectral()};
  const double phi = 0.4, g1 = 0.36, h = 1e-30;
  for (const auto& s : states()) {
    const double stretch[3] = {s[0], s[1], s[2]};
    const Motion motion(random, stretch);
    const auto out = evaluate(
        law, PointInput<double, 3>{motion.H(), virgin_history<double, 3>(), phi, law.parameters.theta0});
    double principal[3];
    for (int i = 0; i < 3; ++i) { // tau_i = dE/d ln(stretch_i)
      Complex z[3] = {s[0], s[1], s[2]};
      z[i] += Complex(0, h);
      principal[i] = s[unsigned(i)] * energy(law.parameters, z, g1).imag() / h;
    }
    const Matrix<double> tau = dense<3>(out.tau);
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) {
        double expected = 0;
        for (unsigned k = 0; k < 3; ++k) expected += principal[k] * motion.R[3 * i + k] * motion.R[3 * j + k];
        EXPECT_NEAR(tau[3 * i + j], expected, 3e-15 * law.parameters.K);
      }
    EXPECT_NEAR(g1 * out.energy.plus + out.energy.minus,
                energy(law.parameters, {s[0], s[1], s[2]}, g1).real(), 1e-15 * law.parameters.K);
  }
}

/// The modulus of a law that does not flow, against central differences.
void expect_exact_modulus(Split kind) {
  Sampler random(73);
  const PointLaw law{with_split(kind)};
  const double phi = 0.4;
  const auto tau_of = [&](const auto& H) {
    using T = std::decay_t<decltype(H[0])>;
    return evaluate(law, PointInput<T, 3>{H, virgin_history<T, 3>(), T(phi), T(law.parameters.theta0)}).tau;
  };
  for (const auto& s : states()) {
    bool at_kink = false; // one-sided there: the modulus jumps where a stretch passes 1
    for (const double x : s) at_kink = at_kink || std::fabs(x - 1) < 1e-4;
    const double stretch[3] = {s[0], s[1], s[2]};
    const Tensor<double, 3> H = Motion(random, stretch).H();
    const Modulus<double, 9> a = dual_modulus<9>(H, tau_of);
    double size = 0;
    for (const auto& row : a.c)
      for (double x : row) size = std::fmax(size, std::fabs(x));
    for (int I = 0; I < 9; ++I)
      for (int K = 0; K < 9; ++K) EXPECT_NEAR(a.c[I][K], a.c[K][I], 1e-14 * size);
    if (at_kink) continue;
    // delta P F^T along grad du = D: tau(F + h D F) against the modulus, central differences
    Matrix<double> D{}, F = dense<3>(H);
    for (double& x : D) x = random.uniform(-1, 1);
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    const Matrix<double> DF = reference::multiply(D, F);
    const double h = 1e-6;
    Matrix<double> P[2];
    for (int side = 0; side < 2; ++side) {
      Matrix<double> Hs = dense<3>(H);
      for (unsigned i = 0; i < 9; ++i) Hs[i] += (side ? -h : h) * DF[i];
      Matrix<double> Fs = Hs;
      for (unsigned i = 0; i < 3; ++i) Fs[4 * i] += 1;
      P[side] = reference::multiply(dense<3>(tau_of(reference::tensor<3>(Hs))),
                                    reference::transpose(reference::inverse(Fs)));
    }
    Matrix<double> dP;
    for (unsigned i = 0; i < 9; ++i) dP[i] = (P[0][i] - P[1][i]) / (2 * h);
    const Matrix<double> pushed = reference::multiply(dP, reference::transpose(F));
    for (int I = 0; I < 9; ++I) {
      double sum = 0;
      for (int K = 0; K < 9; ++K) sum += a.c[I][K] * D[unsigned(K)];
      EXPECT_NEAR(sum, pushed[unsigned(I)], 2e-9 * size) << s[0] << ' ' << s[1] << ' ' << s[2];
    }
  }
}

TEST(EnergySplit, ModulusIsSymmetricAndTheDerivativeOfTheStressEverywhere) {
  expect_exact_modulus(Split::spectral);
  expect_exact_modulus(Split::no_tension);
  expect_exact_modulus(Split::drucker_prager);
}

TEST(EnergySplit, IsObjectiveAndTheSameInEveryLayout) {
  Sampler random(74);
  for (int k = 0; k < 200; ++k) {
    const PointLaw law{with_split(k % 2 ? Split::spectral : Split::no_tension)};
    const auto H = random.gradient<2>(0.1);
    PointInput<double, 2> plane{H, virgin_history<double, 2>(), 0.4, 310};
    PointInput<double, 3> solid{reference::tensor<3>(dense<2>(H)), virgin_history<double, 3>(), 0.4, 310};
    const auto a = evaluate(law, plane);
    const auto b = evaluate(law, solid);
    const Matrix<double> tau = dense<3>(b.tau);
    for (unsigned i = 0; i < 9; ++i) EXPECT_NEAR(dense<2>(a.tau)[i], tau[i], 1e-14 * law.parameters.K);
    const double one[3] = {1, 1, 1};
    const Matrix<double> Q = Motion(random, one).F;
    Matrix<double> F = dense<3>(solid.H);
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    Matrix<double> QF = reference::multiply(Q, F);
    for (unsigned i = 0; i < 3; ++i) QF[4 * i] -= 1;
    solid.H = reference::tensor<3>(QF);
    const Matrix<double> turned = reference::multiply(reference::multiply(Q, tau), reference::transpose(Q));
    const auto c = evaluate(law, solid);
    for (unsigned i = 0; i < 9; ++i) EXPECT_NEAR(dense<3>(c.tau)[i], turned[i], 1e-13 * law.parameters.K);
    EXPECT_NEAR(c.energy.plus, b.energy.plus, 1e-12 * (b.energy.plus + b.energy.minus));
  }
}

TEST(EnergySplit, CompressionDrivesNothingTensionAndShearDo) {
  const PointLaw law{spectral()};
  const auto drive = [&](double xx, double yy, double xy) {
    const PointInput<double, 2> in{
        {{xx, xy, 0, yy, 0}}, virgin_history<double, 2>(), 0, law.parameters.theta0};
    return evaluate(law, in).energy;
  };
  const double G = law.parameters.G, lame = law.parameters.K - 2.0 / 3 * G, e = 1e-6;
  EXPECT_EQ(drive(-0.1, 0, 0).plus, 0);
  EXPECT_EQ(drive(-0.1, -0.2, 0).plus, 0);
  EXPECT_EQ(drive(0.1, 0, 0).minus, 0);
  EXPECT_NEAR(drive(e, 0, 0).plus / ((lame / 2 + G) * e * e), 1, 1e-5); // small strains: Miehe's split
  EXPECT_NEAR(drive(e, -3 * e, 0).plus / (G * e * e), 1, 1e-5);
  EXPECT_NEAR(drive(e, -3 * e, 0).minus / ((2 * lame + 9 * G) * e * e), 1, 1e-5);
  EXPECT_NEAR(drive(0, 0, e).plus / drive(0, 0, e).minus, 1, 1e-5); // half of a shear
  MaterialParameters volumetric = spectral();
  volumetric.split = Split::volumetric;
  EXPECT_GT(evaluate(PointLaw{volumetric},
                     PointInput<double, 2>{{{-0.1, 0, 0, 0, 0}}, virgin_history<double, 2>(), 0, 298.15})
                .energy.plus,
            1e-3 * G);
}

namespace {

/// Of a small strain in a body of the split: the share of the energy that drives damage, and the stiffness
/// against more pressure and against shear that a broken point keeps, over K and G.
struct Response {
  double share, bulk, shear;
};
Response response_of(const MaterialParameters& m, const std::array<double, 4>& strain) {
  const PointLaw law{m};
  const auto at = [&](double phi, double volume, double shear) {
    const double size = 1e-5;
    PointInput<double, 2> in{{}, virgin_history<double, 2>(), phi, m.theta0};
    in.H = {{size * (strain[0] + volume), size * (strain[3] + shear), size * (strain[3] + shear),
             size * (strain[1] + volume), size * (strain[2] + volume)}};
    return evaluate(law, in);
  };
  const double h = 1e-3, size = 1e-5;
  const auto E = at(0, 0, 0).energy;
  return {(E.plus + compressed_share(m) * E.minus) / (E.plus + E.minus),
          (trace(at(1, 0, 0).tau) - trace(at(1, -h, 0).tau)) / (9 * m.K * size * h),
          (at(1, 0, h).tau[3] - at(1, 0, -h).tau[3]) / (4 * m.G * size * h)};
}

} // namespace

// The table of theory.md, for nu = 0.3 and gamma* = 2.
TEST(EnergySplit, WhatEachSplitDoesUnderTensionCompressionShearAndPressure) {
  const double nu = 0.3, gamma = 2, K_over_G = 2 * (1 + nu) / (3 * (1 - 2 * nu)), lame = K_over_G - 2.0 / 3;
  const std::array<double, 4> tension{1, -nu, -nu, 0}, compression{-1, nu, nu, 0}, shear{0, 0, 0, 1},
      pressure{-1, -1, -1, 0};
  struct Row {
    Split split;
    Response tension, compression, shear, pressure;
  };
  const double U = (1 - 2 * nu) / 3, lateral = 2 * nu * nu / (1 + nu);
  const double plane = 1 / (2 * (1 - nu)), sheet = 2 * (1 - 2 * nu) / (3 * (1 - nu)); // pressed in a plane
  const double L = lame / K_over_G, S = 2 / (9 * K_over_G); // of lambda and of one principal strain in K
  // Of tr eps = v and sqrt(J_2(eps)) = j, with twice the whole energy.
  const double B = with_split(Split::drucker_prager).cone, D = 2 + 18 * B * B * K_over_G, E = 2 * (1 + nu);
  const auto cone = [&](double v, double j, double twice) {
    const double c = 2 * j + 3 * B * K_over_G * v;
    return Response{2 * c * c / D / twice, 2 / D, 3 * B * K_over_G * (6 * B * j - v) / (D * j)};
  };
  const std::vector<Row> table = {{Split::none, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
                                  {Split::volumetric, {1, 0, 0}, {1 - U, 1, 0}, {1, 1, 0}, {0, 1, 0}},
                                  {Split::star_convex,
                                   {1, 0, 0},
                                   {1 - (1 + gamma) * U, 1 + gamma, 0},
                                   {1, 1 + gamma, 0},
                                   {-gamma, 1 + gamma, 0}},
                                  {Split::spectral,
                                   {1 - lateral, 2 * S, nu / (1 + nu)},
                                   {lateral, L + S, 1 / (1 + nu)},
                                   {0.5, L + 2 * S, 0.5},
                                   {0, 1, 1}},
                                  {Split::no_tension,
                                   {1 - 2 * nu * nu / (1 - nu), sheet, nu / (1 - nu)},
                                   {0, 1, 1},
                                   {1 - plane, sheet, plane},
                                   {0, 1, 1}},
                                  {Split::drucker_prager,
                                   cone(1 - 2 * nu, (1 + nu) / std::sqrt(3.0), E),
                                   cone(2 * nu - 1, (1 + nu) / std::sqrt(3.0), E),
                                   cone(0, 1, 4),
                                   {0, 1, 1}}};
  for (const Row& row : table) {
    MaterialParameters m = with_split(row.split);
    m.G = 1, m.K = K_over_G, m.star_gamma = gamma, m.residual_stiffness = 0;
    const auto expect = [&](const char* name, const std::array<double, 4>& strain, const Response& r) {
      const Response is = response_of(m, strain);
      EXPECT_NEAR(is.share, r.share, 2e-4) << int(row.split) << ' ' << name;
      EXPECT_NEAR(is.bulk, r.bulk, 2e-4) << int(row.split) << ' ' << name;
      EXPECT_NEAR(is.shear, r.shear, 2e-4) << int(row.split) << ' ' << name;
    };
    expect("tension", tension, row.tension);
    expect("compression", compression, row.compression);
    expect("shear", shear, row.shear);
    expect("pressure", pressure, row.pressure);
  }
}

// The strength of sound material: sqrt(J_2) + B I_1 of its stress alone, as far as its debris bears anything.
// What a broken point keeps lies on the cone of that B.
TEST(EnergySplit, DamageOnACone) {
  const MaterialParameters m = with_split(Split::drucker_prager);
  const double B = m.cone, most = 2 * m.G + 18 * B * B * m.K;
  Sampler random(78);
  std::array<int, 3> seen{};
  const auto invariants = [](const Symmetric<double, 3>& tau) {
    const Symmetric<double, 3> s = dev(tau);
    return std::array<double, 2>{trace(tau), std::sqrt(0.5 * dot(s, s))};
  };
  for (int k = 0; k < 500; ++k) {
    const auto H = random.gradient<3>(k % 2 ? 1e-6 : 1e-3);
    const auto at = [&](double phi) {
      return evaluate(PointLaw{m}, PointInput<double, 3>{H, virgin_history<double, 3>(), phi, m.theta0});
    };
    const auto [I_1, root] = invariants(at(0).tau);
    const auto energy = at(0).energy;
    const double all = energy.plus + energy.minus, c = root + B * I_1;
    const double opening = I_1 / (3 * m.K) - 3 * B * root / m.G;
    ++seen[c <= 0 ? 0 : opening >= 0 ? 2 : 1];
    const double expected = c <= 0 ? 0 : opening >= 0 ? all : c * c / most;
    EXPECT_NEAR(energy.plus, expected, (k % 2 ? 1e-5 : 1e-2) * all);
    MaterialParameters empty = m;
    empty.residual_stiffness = 0;
    const auto broken =
        evaluate(PointLaw{empty}, PointInput<double, 3>{H, virgin_history<double, 3>(), 1.0, m.theta0});
    const auto [p, q] = invariants(broken.tau);
    EXPECT_NEAR(c > 0 ? q + B * p : 0, 0, 1e-2 * (q - p) + 1e-12 * std::sqrt(all * m.K));
  }
  for (const int count : seen) EXPECT_GT(count, 20);
}

// B of a ratio of strengths gives that ratio, on both sides of the state that tension opens as a whole.
TEST(EnergySplit, ConeOfARatioOfStrengths) {
  MaterialParameters m = with_split(Split::drucker_prager);
  for (const double nu : {-0.3, 0.0, 0.2, 0.4})
    for (const double ratio : {1.05, 1.2, 1.6, 2.0, 10.0, 100.0}) {
      m.K = 2 * m.G * (1 + nu) / (3 * (1 - 2 * nu));
      m.cone = cone_of(m, ratio);
      EXPECT_EQ(m.cone > 0, ratio > least_strength_ratio(m)) << nu << ' ' << ratio;
      if (m.cone > 0) {
        EXPECT_NEAR(cone_energy(m, 1) / cone_energy(m, -ratio), 1, 1e-12) << nu << ' ' << ratio;
      }
    }
}

// min over y <= x of W + U by a search that knows nothing of the cases.
TEST(EnergySplit, WithoutTensionIsTheLeastEnergyOfABodyWhoseCracksOpen) {
  const MaterialParameters m = with_split(Split::no_tension);
  const auto whole = [&](const std::array<double, 3>& y) {
    double s = y[0] + y[1] + y[2], sum = 0;
    for (double x : y) sum += std::exp(2 * x - 2 * s / 3) - 1;
    return m.K / 2 * ((std::exp(2 * s) - 1) / 2 - s) + m.G / 2 * sum;
  };
  Sampler random(75);
  for (int k = 0; k < 60; ++k) {
    const double size = k % 2 ? 0.3 : 0.01;
    std::array<double, 3> x, stretch;
    for (unsigned i = 0; i < 3; ++i) x[i] = random.uniform(-size, size), stretch[i] = std::exp(x[i]);
    std::array<double, 3> y{std::fmin(x[0], 0), std::fmin(x[1], 0), std::fmin(x[2], 0)};
    for (double step = size / 4; step > 1e-9; step /= 2) // compass search, the energy is convex there
      for (bool better = true; better;) {
        better = false;
        for (int move = 0; move < 26; ++move) {
          std::array<double, 3> z = y;
          const int code = move < 13 ? move : move + 1;
          z[0] += step * (code % 3 - 1), z[1] += step * (code / 3 % 3 - 1), z[2] += step * (code / 9 - 1);
          for (unsigned i = 0; i < 3; ++i) z[i] = std::fmin(z[i], x[i]);
          if (whole(z) < whole(y)) y = z, better = true;
        }
      }
    const double axes[3] = {stretch[0], stretch[1], stretch[2]};
    const auto out = evaluate(PointLaw{m}, PointInput<double, 3>{Motion(random, axes).H(),
                                                                 virgin_history<double, 3>(), 0, m.theta0});
    EXPECT_NEAR(out.energy.minus, whole(y), 1e-9 * whole(x) + 1e-14 * m.K);
    EXPECT_NEAR(out.energy.plus, whole(x) - whole(y), 1e-9 * whole(x) + 1e-14 * m.K);
  }
}

TEST(EnergySplit, WithoutTensionTheStressIsTheDerivativeOfTheEnergyAndNeverTension) {
  Sampler random(76);
  const PointLaw law{with_split(Split::no_tension)};
  for (int k = 0; k < 100; ++k) {
    const auto H = random.gradient<3>(k % 2 ? 0.2 : 0.01), D = random.gradient<3>(1);
    const auto at = [&](double t) {
      PointInput<double, 3> in{H, virgin_history<double, 3>(), 1, law.parameters.theta0};
      for (int i = 0; i < 9; ++i) in.H[i] += t * D[i];
      return evaluate(law, in);
    };
    const double h = 1e-6;
    const auto now = at(0);
    const SplitState<double, 3> state =
        split_state_of(law, PointInput<double, 3>{H, virgin_history<double, 3>(), 1, law.parameters.theta0});
    const SplitEnergies<double, 3> of = split_response(law, state).of;
    const Tensor<double, 3> P = first_piola(of.tau_minus, now.k.inverse_F),
                            Q = first_piola(of.tau_plus, now.k.inverse_F);
    double work = 0, other = 0;
    for (int i = 0; i < 9; ++i) work += P[i] * D[i], other += Q[i] * D[i];
    const double size = 1e-8 * law.parameters.K;
    EXPECT_NEAR((at(h).energy.minus - at(-h).energy.minus) / (2 * h), work, size);
    EXPECT_NEAR((at(h).energy.plus - at(-h).energy.plus) / (2 * h), other, size);
    for (double x : eigen_system(of.tau_minus).value) EXPECT_LT(x, 1e-12 * law.parameters.K);
  }
}

// Work = stored + dissipated along a path with flow at constant damage, to the first order of the steps; the
// flow rule (67') itself is one of small elastic strains, under any split.
TEST(EnergySplit, FlowClosesTheFirstLaw) {
  for (const PlasticDegradation gp : {PlasticDegradation::one, PlasticDegradation::ge})
    for (const double sign : {1.0, -1.0}) {
      MaterialParameters m = with_split(Split::spectral);
      m.model = Model::j2, m.gp = gp, m.taylor_quinney = 0.6;
      m.sigma_y *= 0.01, m.voce_r *= 0.01;
      const PointLaw law{m};
      const double phi = 0.3;
      const auto lost_balance = [&](int steps) {
        PointHistory<Batch, 3> old = virgin_history<Batch, 3>();
        Tensor<Batch, 3> H_n, P_n;
        for (int i = 0; i < 9; ++i) H_n[i] = P_n[i] = Batch(0.0);
        double work = 0, lost = 0, stored = 0;
        for (int s = 1; s <= steps; ++s) {
          const double t = sign * 0.04 * s / steps;
          PointInput<Batch, 3> in{H_n, old, Batch(phi), Batch(m.theta0)};
          const double path[9] = {t, 0.4 * t, 0, 0, -0.6 * t, 0.1 * t, 0.3 * t * s / steps, 0, 0.5 * t};
          for (int i = 0; i < 9; ++i) in.H[i] = path[i];
          const auto now = evaluate(law, in);
          const Tensor<Batch, 3> P = first_piola(now.tau, now.k.inverse_F);
          for (int i = 0; i < 9; ++i) work += (0.5 * (P[i] + P_n[i]) * (in.H[i] - H_n[i]))[0];
          const SplitState<Batch, 3> state = split_state_of(law, in);
          const SplitFlow flow = split_work(law, state, now.flow);
          const double dalpha = (now.history.alpha - old.alpha)[0], g_p = state.g.p.g[0];
          const double k = hardening(m, now.history.alpha).k[0];
          const double step = (g_p * m.taylor_quinney + flow.power[0] - g_p) * k * dalpha;
          EXPECT_GE(step, 0);
          if (dalpha > 0) {
            // the projected stress is at the yield stress, or that of the sound body is
            const double norm = std::sqrt(dot(now.flow.trial, now.flow.trial)[0]);
            const double drive = gp == PlasticDegradation::one
                                     ? dot(now.tau, now.flow.trial)[0] / norm
                                     : m.G * std::sqrt(dot(now.flow.dev_b, now.flow.dev_b)[0]);
            EXPECT_NEAR(drive, std::sqrt(2.0 / 3) * k, 1e-10 * k);
          }
          lost += step;
          const auto& E = now.energy;
          stored = (state.g.e1.g * E.plus + state.g.e2.g * E.minus +
                    (1 - m.taylor_quinney) * state.g.p.g * E.plastic)[0];
          H_n = in.H, P_n = P, old = now.history;
        }
        EXPECT_GT(old.alpha[0], 0.01);
        return std::fabs(work - stored - lost) / work;
      };
      const double coarse = lost_balance(100), fine = lost_balance(400);
      EXPECT_LT(coarse, 5e-5);
      EXPECT_LT(fine, 0.3 * coarse) << coarse;
    }
}

// s = -d psi/d theta at fixed strain, and the capacity theta ds/dtheta.
TEST(EnergySplit, EntropyIsTheDerivativeOfTheFreeEnergy) {
  Sampler random(77);
  for (const Split kind : {Split::spectral, Split::no_tension, Split::drucker_prager})
    for (int k = 0; k < 50; ++k) {
      MaterialParameters m = with_split(kind);
      m.alpha_t = 2e-5;
      const PointLaw law{m};
      const auto H = random.gradient<3>(0.02);
      const auto heat = [&](double theta) {
        PointInput<Batch, 3> in{{}, virgin_history<Batch, 3>(), Batch(0.5), Batch(theta)};
        for (int i = 0; i < 9; ++i) in.H[i] = H[i];
        return split_heat(law, split_state_of(law, in));
      };
      const SplitHeat up = heat(341), down = heat(339), now = heat(340);
      const double largest = m.K * m.alpha_t * 0.1;
      EXPECT_NEAR((down.elastic - up.elastic)[0] / 2, now.entropy[0], 1e-4 * largest);
      EXPECT_NEAR((up.entropy - down.entropy)[0] / 2, now.entropy_slope[0], 1e-4 * largest);
    }
}

// With the closed form of its authors: the strength under compression over that under tension is
// sqrt((3K + G)/(3K - gamma* G)).
TEST(EnergySplit, StarConvexStrengthInCompressionIsThatAskedFor) {
  MaterialParameters m = with_split(Split::star_convex);
  for (const double ratio : {1.5, 3.0}) {
    m.star_gamma = (3 * m.K - (3 * m.K + m.G) / (ratio * ratio)) / m.G;
    const double nu = (3 * m.K - 2 * m.G) / (2 * (3 * m.K + m.G));
    const auto drive = [&](double e) {
      const PointInput<double, 2> in{{{e, 0, 0, -nu * e, -nu * e}}, virgin_history<double, 2>(), 0, m.theta0};
      const auto E = evaluate(PointLaw{m}, in).energy;
      return E.plus + compressed_share(m) * E.minus;
    };
    EXPECT_NEAR(std::sqrt(drive(1e-6) / drive(-1e-6)), ratio, 1e-4 * ratio);
  }
}
