#include "law_sampler.hpp"

#include <gtest/gtest.h>
#include <impact/material/modulus.hpp>

using namespace impact;
using reference::aluminium;
using reference::dense;
using reference::Matrix;
using reference::Sampler;

namespace {

using Complex = std::complex<double>;

MaterialParameters spectral() {
  MaterialParameters m = aluminium();
  m.model = Model::elastic;
  m.split = Split::spectral;
  return m;
}

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

TEST(SpectralSplit, PartsAddUpToTheEnergyAndAreNeverNegative) {
  Sampler random(71);
  for (int k = 0; k < 500; ++k) {
    const double size = k % 3 == 0 ? 0.3 : k % 3 == 1 ? 1e-3 : 1e-9;
    const PointInput<double, 3> in{random.gradient<3>(size), virgin_history<double, 3>(), 0.3,
                                   k % 2 ? 298.15 : random.uniform(250, 350)};
    const auto split = evaluate(PointLaw{spectral()}, in);
    MaterialParameters whole = spectral();
    whole.split = Split::none;
    const auto all = evaluate(PointLaw{whole}, in);
    const double sum = all.energy.plus + all.energy.minus;
    EXPECT_NEAR(split.energy.plus + split.energy.minus, sum, 1e-11 * sum) << size;
    EXPECT_GE(split.energy.plus, 0);
    EXPECT_GE(split.energy.minus, 0);
  }
}

TEST(SpectralSplit, StressIsTheDerivativeOfTheEnergyAlsoWhereStretchesAreEqual) {
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

TEST(SpectralSplit, ModulusIsSymmetricAndTheDerivativeOfTheStressEverywhere) {
  Sampler random(73);
  const MaterialParameters m = spectral();
  const double phi = 0.4;
  const auto tau_of = [&](const auto& H) {
    using T = std::decay_t<decltype(H[0])>;
    const auto s = spectral_split(m, left_strain(H), detm1(H), T(1.0));
    const Degradations<T> g = degradations(m, T(phi), T(0.0));
    return g.e1.g * s.tau_plus + g.e2.g * s.tau_minus;
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

TEST(SpectralSplit, IsObjectiveAndTheSameInEveryLayout) {
  Sampler random(74);
  const PointLaw law{spectral()};
  for (int k = 0; k < 100; ++k) {
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

TEST(SpectralSplit, CompressionDrivesNothingTensionAndShearDo) {
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
