#include "law_sampler.hpp"

#include <gtest/gtest.h>
#include <impact/material/modulus.hpp>

using namespace impact;
using reference::aluminium;
using reference::Complex;
using reference::dense;
using reference::Matrix;
using reference::Sampler;

namespace {

/// a_ijkl of the plain implementation by the complex step: d(tau F^-T)/dF pushed forward.
template <int n>
Modulus<double, n> complex_modulus(const MaterialParameters& m, const Matrix<double>& F,
                                   const PointInput<double, layout_of<n>>& in) {
  constexpr int d = layout_of<n>;
  Modulus<double, n> a{};
  for (int K = 0; K < n; ++K) {
    const unsigned k = unsigned(row_of<n>(K)), L = unsigned(column_of<n>(K));
    Matrix<Complex> z;
    for (unsigned i = 0; i < 9; ++i) z[i] = F[i];
    z[3 * k + L] += Complex(0, reference::step);
    const Matrix<Complex> P =
        reference::multiply(reference::kirchhoff(m, z, dense<d>(in.old.A), in.old.alpha, Complex(in.phi),
                                                 Complex(in.theta), in.dt),
                            reference::transpose(reference::inverse(z)));
    for (int I = 0; I < n; ++I)
      for (int N = 0; N < n; ++N) {
        const unsigned i = unsigned(row_of<n>(I)), j = unsigned(column_of<n>(I)),
                       l = unsigned(column_of<n>(N));
        if (row_of<n>(N) != int(k)) continue;
        for (unsigned J = 0; J < 3; ++J)
          a.c[I][N] += P[3 * i + J].imag() / reference::step * F[3 * j + J] * F[3 * l + L];
      }
  }
  return a;
}

template <int n> double difference(const Modulus<double, n>& a, const Modulus<double, n>& b) {
  double worst = 0, size = 0;
  for (int I = 0; I < n; ++I)
    for (int K = 0; K < n; ++K) {
      worst = std::fmax(worst, std::fabs(a.c[I][K] - b.c[I][K]));
      size = std::fmax(size, std::fabs(b.c[I][K]));
    }
  return worst / size;
}

template <int n> void compare(unsigned seed_number) {
  constexpr int d = layout_of<n>;
  Sampler random(seed_number);
  int flowing = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    MaterialParameters m = aluminium();
    m.model = trial % 5 ? Model::j2 : Model::elastic;
    m.split = trial % 2 ? Split::none : Split::volumetric;
    m.gp = trial % 3 ? PlasticDegradation::one : PlasticDegradation::ge;
    m.ge = trial % 7 ? Degradation::quadratic : Degradation::cubic;
    reference::set_hardening(m, trial % reference::hardening_kinds);
    if (trial % 9 == 4) reference::set_state(m, trial % 2);
    const PointLaw law{m};
    PointInput<double, d> in{random.gradient<d>(trial % 2 ? 0.03 : 0.004), random.history<d>(0.005),
                             random.uniform(0, 0.8), random.uniform(280, 400), 1e-3};
    if (trial % 11 == 0) in.old.alpha = 0; // where the power law is vertical
    if (n == 4) in.H[4] = 0;
    if (!law.flows()) in.old = virgin_history<double, d>();
    const auto closed = point_modulus<n>(law, in);
    const auto dual = dual_modulus<n>(in.H, [&](const auto& H) {
      using D = Dual<double, n>;
      PointInput<D, d> x{H, {}, D(in.phi), D(in.theta), in.dt};
      for (int i = 0; i < symmetric_size(d); ++i) x.old.A[i] = D(in.old.A[i]);
      x.old.alpha = D(in.old.alpha);
      return evaluate(law, x).tau;
    });
    Matrix<double> F = dense<d>(in.H);
    for (unsigned i = 0; i < 3; ++i) F[4 * i] += 1;
    EXPECT_LT(difference<n>(closed, dual), 1e-12);
    EXPECT_LT(difference<n>(closed, complex_modulus<n>(m, F, in)), 1e-10);
    flowing += evaluate(law, in).flow.plastic;
  }
  EXPECT_GT(flowing, 300);
  EXPECT_LT(flowing, 900);
}

} // namespace

TEST(Modulus, ClosedFormDualAndComplexStepAgreeInPlaneStrain) { compare<4>(1); }
TEST(Modulus, ClosedFormDualAndComplexStepAgreeInAxisymmetry) { compare<5>(2); }
TEST(Modulus, ClosedFormDualAndComplexStepAgreeInSpace) { compare<9>(3); }

TEST(Modulus, BatchOfDualsGivesTheModulusOfEachLane) {
  Sampler random(4);
  const PointLaw law{aluminium()};
  PointInput<Batch, 2> in;
  PointInput<double, 2> one[lanes];
  for (int l = 0; l < lanes; ++l) {
    one[l] = {random.gradient<2>(0.03), random.history<2>(0.005), 0.1 * l, 300};
    for (int i = 0; i < 5; ++i) in.H[i].set(l, one[l].H[i]);
    for (int i = 0; i < 4; ++i) in.old.A[i].set(l, one[l].old.A[i]);
    in.old.alpha.set(l, one[l].old.alpha);
    in.phi.set(l, one[l].phi);
    in.theta.set(l, one[l].theta);
  }
  const auto dual = dual_modulus<5>(in.H, [&](const auto& H) {
    using D = Dual<Batch, 5>;
    PointInput<D, 2> x{H, {}, D(in.phi), D(in.theta)};
    for (int i = 0; i < 4; ++i) x.old.A[i] = D(in.old.A[i]);
    x.old.alpha = D(in.old.alpha);
    return evaluate(law, x).tau;
  });
  for (int l = 0; l < lanes; ++l) {
    const auto closed = point_modulus<5>(law, one[l]);
    for (int I = 0; I < 5; ++I)
      for (int K = 0; K < 5; ++K) EXPECT_NEAR(dual.c[I][K][l], closed.c[I][K], 1e-12 * law.parameters.K);
  }
}

TEST(Modulus, ViscousAndCrackPartsAreTheDerivativesOfTheirStresses) {
  Sampler random(5);
  const MaterialParameters m = aluminium();
  for (int trial = 0; trial < 200; ++trial) {
    const auto H = random.gradient<3>(0.1), H_n = random.gradient<3>(0.1);
    const Vector<double, 3> grad{
        {random.uniform(-500, 500), random.uniform(-500, 500), random.uniform(-500, 500)}};
    const double factor = 2e9;
    const auto k = kinematics(H);
    Tensor<double, 3> dH;
    for (int i = 0; i < 9; ++i) dH[i] = H[i] - H_n[i];
    Symmetric<double, 3> B = left_strain(H), tau_d = factor * push(k.F, right_increment(k.F, dH));
    for (int i = 0; i < 3; ++i) B[i] += 1;

    ModulusParts<double, 3> geometric{};
    geometric.tau = tau_d;
    auto viscous = assemble_modulus<9>(geometric);
    add_viscous(viscous, factor, B, 1.0);
    EXPECT_LT(difference<9>(viscous, dual_modulus<9>(H,
                                                     [&](const auto& x) {
                                                       using D = Dual<double, 9>;
                                                       Tensor<D, 3> step;
                                                       for (int i = 0; i < 9; ++i) step[i] = x[i] - D(H_n[i]);
                                                       const auto F = plus_identity(x);
                                                       return D(factor) * push(F, right_increment(F, step));
                                                     })),
              1e-12);

    const auto h = spatial_gradient(k.inverse_F, grad);
    geometric.tau = crack_stress(m, h);
    auto crack = assemble_modulus<9>(geometric);
    add_crack(crack, m.Gc * m.gamma, h);
    EXPECT_LT(difference<9>(crack, dual_modulus<9>(
                                       H,
                                       [&](const auto& x) {
                                         using D = Dual<double, 9>;
                                         const Vector<D, 3> g{{D(grad[0]), D(grad[1]), D(grad[2])}};
                                         return crack_stress(m, spatial_gradient(kinematics(x).inverse_F, g));
                                       })),
              1e-12);
  }
}
