#include "law_sampler.hpp"
#include "swift_hardening.hpp"

#include <gtest/gtest.h>
#include <impact/material/modulus.hpp>

/// A hardening law of a user's own, after the recipe of src/README.md: a flow stress and its potential, no
/// slope and no tangent.
using namespace impact;
using reference::Complex;
using reference::Sampler;

namespace impact {

/// Ludwik: k = s_y + B alpha^n, with infinite slope at the start.
struct LudwikHardening {
  template <class T> static T stress(const MaterialParameters&, const T& alpha) {
    return T(3e8) + 5e8 * pow(alpha + T(1e-300), 0.3);
  }
  template <class T> static T potential(const MaterialParameters&, const T& alpha) {
    return 3e8 * alpha + (5e8 / 1.3) * (alpha * pow(alpha + T(1e-300), 0.3));
  }
};

} // namespace impact

namespace {

/// tau of a point with this hardening.
template <class Law, class T>
Symmetric<T, 3> stress(const MaterialParameters& m, const Tensor<T, 3>& H, const PointHistory<double, 3>& old,
                       double theta, double dt, Return<T, 3>* out = nullptr) {
  const Kinematics<T, 3> k = kinematics(H);
  Symmetric<T, 3> A;
  for (int i = 0; i < 6; ++i) A[i] = T(old.A[i]) - T(i < 3 ? 1.0 : 0.0);
  const FlowConditions<T> at{T(softening(m, theta)), dt, false};
  const Return<T, 3> flow =
      return_map<Law>(m, left_strain(H) + push(k.F, A), k.J23, T(old.alpha), T(1.0), at);
  if (out) *out = flow;
  Symmetric<T, 3> tau = m.G * flow.dev_b;
  const Volumetric<T> v = volumetric(m, k.J_minus_1, T(1.0));
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] + v.p * k.J;
  return tau;
}

template <class Law> class OwnHardening : public testing::Test {};
using Laws = testing::Types<SwiftHardening, LudwikHardening>;
TYPED_TEST_SUITE(OwnHardening, Laws);

} // namespace

TYPED_TEST(OwnHardening, PotentialIsTheIntegralOfTheFlowStress) {
  const MaterialParameters m;
  EXPECT_NEAR(TypeParam::potential(m, 0.0), 0, 1e-8); // of some 1e8 alpha
  for (double alpha = 1e-6; alpha < 2; alpha *= 3) {
    const double k = TypeParam::stress(m, alpha);
    EXPECT_NEAR(imag(TypeParam::potential(m, Complex(alpha, 1e-30 * alpha))) / (1e-30 * alpha), k, 1e-13 * k);
  }
}

TYPED_TEST(OwnHardening, ReturnEndsOnTheYieldSurfaceFromTheFirstYieldOn) {
  MaterialParameters m = reference::aluminium();
  for (int decade = 15; decade >= 0; --decade) {
    // shear to just above the first yield: N = sqrt(2/3) k(0) (1 + 10^-decade)
    const double q = std::sqrt(2.0 / 3), k = TypeParam::stress(m, 0.0) * (1 + std::pow(10.0, -decade));
    Symmetric<double, 3> e{};
    e[3] = q * k / m.G / std::sqrt(2.0);
    const auto flow = return_map<TypeParam>(m, e, 1.0, 0.0, 1.0);
    EXPECT_EQ(flow.failed, 0) << decade;
    ASSERT_TRUE(flow.plastic || decade == 15) << decade;
    const double norm = m.G * std::sqrt(dot(flow.dev_b, flow.dev_b));
    EXPECT_NEAR(norm, q * TypeParam::stress(m, flow.alpha), 4e-15 * norm) << decade;
  }
}

TYPED_TEST(OwnHardening, TangentsAgreeWithTheComplexStep) {
  Sampler random(81);
  int flowing = 0;
  for (int trial = 0; trial < 300; ++trial) {
    MaterialParameters m = reference::aluminium();
    m.damage = Damage::none;
    m.rate_c = trial % 2 ? 0.02 : 0;
    m.softening = trial % 3 ? Softening::linear : Softening::none;
    m.softening_w = 1e-3;
    const auto H = random.gradient<3>(0.02);
    auto old = random.history<3>(0.004);
    if (trial % 5 == 0) old.alpha = 0;
    const double theta = random.uniform(280, 500), dt = 1e-3;
    const auto dual =
        dual_modulus<9>(H, [&](const auto& h) { return stress<TypeParam>(m, h, old, theta, dt); });

    Return<double, 3> flow;
    stress<TypeParam>(m, H, old, theta, dt, &flow);
    flowing += flow.plastic;
    const auto k = kinematics(H);
    const auto v = volumetric(m, k.J_minus_1, 1.0);
    const auto closed = assemble_modulus<9>(
        law_modulus<9, TypeParam>(m, flow, 1.0, 1.0, v.p * k.J, v.dp * k.J * k.J, 1.0, false, false));
    for (int K = 0; K < 9; ++K) { // along dF = (e_k (x) e_l) F
      Tensor<Complex, 3> z;
      for (int i = 0; i < 9; ++i) z[i] = H[i];
      for (int j = 0; j < 3; ++j) z[3 * (K / 3) + j] += Complex(0, 1e-25) * k.F[3 * (K % 3) + j];
      const auto tau = stress<TypeParam>(m, z, old, theta, dt);
      for (int I = 0; I < 9; ++I) {
        // d(tau F^-T) F^T = d tau - tau dl^T with dl = e_k (x) e_l
        const int i = I / 3, j = I % 3;
        double a = tau[symmetric_index(3, i, j)].imag() / 1e-25;
        if (j == K / 3) a -= tau[symmetric_index(3, i, K % 3)].real();
        EXPECT_NEAR(dual.c[I][K], a, 1e-9 * m.K) << trial;
        EXPECT_NEAR(closed.c[I][K], a, 1e-9 * m.K) << trial;
      }
    }
  }
  EXPECT_GT(flowing, 200);
}
