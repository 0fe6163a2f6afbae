#pragma once
#include "../math/dense_matrix.hpp"

#include <impact/material/hardening.hpp>
#include <impact/material/parameters.hpp>
#include <numbers>

/// A second, plain implementation of the point law on dense 3x3 arrays, after the reference script of the
/// equations and not after the library: full tensors, textbook return map, no cancellation-free forms. T is
/// double or std::complex<double>, so that any derivative can be taken by the complex step.
namespace reference {

using impact::MaterialParameters;

inline MaterialParameters aluminium() {
  MaterialParameters m;
  const double E = 72.0e9, nu = 0.33;
  m.G = E / (2 * (1 + nu));
  m.K = E / (3 * (1 - 2 * nu));
  m.rho = 2810;
  m.model = impact::Model::j2;
  m.sigma_y = 368e6;
  m.voce_r = 78e6;
  m.voce_s = 32;
  m.alpha_t = 2.3e-5;
  m.theta0 = 298.15;
  m.damage = impact::Damage::at2;
  m.Gc = 4950.6;
  m.gamma = 0.5e-3;
  m.c = 1e-3;
  m.b_d = 0;
  m.residual_stiffness = 0;
  return m;
}

/// alpha: that of the start of the step.
template <class T> T g_e1(const MaterialParameters& m, const T& phi, double alpha = 0) {
  const T x = 1.0 - phi;
  const T power = std::pow(x, m.cohesive.p),
          soft = m.cohesive.a1 *
                 (phi + m.cohesive.a2 * phi * phi + m.cohesive.a2 * m.cohesive.a3 * phi * phi * phi);
  const T g = m.ge == impact::Degradation::quadratic ? x * x
              : m.ge == impact::Degradation::ductile ? std::pow(x, 2 * alpha / m.alpha_c)
              : m.ge == impact::Degradation::cubic   ? (3 - m.cubic_s) * x * x - (2 - m.cubic_s) * x * x * x
                                                     : power / (power + soft);
  const double k = m.residual_stiffness;
  return m.damage == impact::Damage::none ? T(1.0) : (1 - k) * g + k;
}
template <class T> T g_e2(const MaterialParameters& m, const T& phi, double alpha = 0) {
  return m.split == impact::Split::none ? g_e1(m, phi, alpha) : T(1.0);
}
template <class T> T g_p(const MaterialParameters& m, const T& phi, double alpha = 0) {
  return m.gp == impact::PlasticDegradation::ge ? g_e1(m, phi, alpha) : T(1.0);
}
/// a and w' of the crack energy G_c (a gamma/2 |grad phi|^2 + w/gamma).
inline double gradient_share(const MaterialParameters& m) {
  return m.damage == impact::Damage::at1 ? 0.75 : m.damage == impact::Damage::wu ? 2 / std::numbers::pi : 1;
}
template <class T> T crack_slope(const MaterialParameters& m, const T& phi) {
  return m.damage == impact::Damage::at1  ? T(0.375)
         : m.damage == impact::Damage::wu ? (2 / std::numbers::pi) * (1.0 - phi)
                                          : phi;
}

/// Energy and its slope along the isotherm theta_0 of an equation of state, at J = 1 - eta: the isentrope as
/// a power series, whose coefficients its differential equation E' = p_H (1 - Gamma eta/2) + Gamma E gives.
template <class T> struct Isotherm { T U, dU, ddU; };
template <class T> Isotherm<T> isotherm(const MaterialParameters& m, const T& J) {
  const T eta = 1.0 - J;
  const double s = std::real(eta) > 0 ? m.eos_s : 0, G = m.eos_gamma, c = m.c_v * m.theta0;
  T E = 0.0, dE = 0.0, ddE = 0.0, power = 1.0; // power = eta^(n-1)
  double a = 0;
  for (int n = 1; n < 400 && (n < 3 || std::abs(a * n * n * power) > 1e-20 * m.K); ++n) {
    // p_H (1 - Gamma eta/2) = K sum_n (n s^(n-1) - (n-1) Gamma/2 s^(n-2)) eta^n
    const double q = n * std::pow(s, n - 1) - (n > 1 ? (n - 1) * G / 2 * std::pow(s, n - 2) : 0);
    a = (G * a + m.K * q) / (n + 1); // of eta^(n+1)
    E += a * power * eta * eta;
    dE += (n + 1) * a * power * eta;
    ddE += (n + 1) * n * a * power;
    power *= eta;
  }
  const T x = std::exp(G * eta);
  return {E - c * (x - 1.0 - G * eta), -(dE - c * G * (x - 1.0)), ddE - c * G * G * x};
}

template <class T> T J_theta(const MaterialParameters& m, const T& theta) {
  if (m.equation_of_state != impact::EquationOfState::none) {
    T J = 1.0;
    for (int i = 0; i < 30; ++i) {
      const Isotherm<T> at = isotherm(m, J);
      J -= (at.dU - m.eos_gamma * m.c_v * (theta - m.theta0)) / at.ddU;
    }
    return J;
  }
  return std::exp(3 * m.alpha_t * (theta - m.theta0));
}
/// k_0(alpha), every law written out.
template <class T> T static_stress(const MaterialParameters& m, const T& a) {
  if (m.hardening == impact::HardeningKind::power)
    return m.sigma_y + (a == 0.0 ? T(0.0) : m.power_b * std::pow(a, m.power_n));
  if (m.hardening == impact::HardeningKind::table) {
    const auto& p = m.table->pieces;
    for (std::size_t i = 0; i + 1 < p.size(); ++i)
      if (std::real(a) < p[i + 1].alpha)
        return p[i].k + (p[i + 1].k - p[i].k) * (a - p[i].alpha) / (p[i + 1].alpha - p[i].alpha);
    return p.back().k;
  }
  return m.sigma_y + m.voce_r * (1.0 - std::exp(-m.voce_s * a)) + m.linear_h * a;
}
/// k(alpha, theta, rate) of a step; dt = 0: at rest.
template <class T>
T flow_stress(const MaterialParameters& m, const T& a, const T& da, double theta, double dt) {
  T k = static_stress(m, a);
  if (m.rate_c > 0 && dt > 0 && m.rate_form == impact::RateForm::power)
    k *= std::pow(1.0 + da / (dt * m.rate_0), m.rate_c);
  else if (m.rate_c > 0 && dt > 0 && std::real(da) / dt > m.rate_0)
    k *= 1.0 + m.rate_c * std::log(da / (dt * m.rate_0));
  if (m.softening == impact::Softening::linear) k *= std::max(0.0, 1 - m.softening_w * (theta - m.theta0));
  if (m.softening == impact::Softening::johnson_cook && theta > m.theta_ref)
    k *= theta < m.theta_melt
             ? 1 - std::pow((theta - m.theta_ref) / (m.theta_melt - m.theta_ref), m.softening_m)
             : 0;
  return k;
}

/// Degraded volumetric pressure dU/dJ at the ratio J.
template <class T>
T pressure(const MaterialParameters& m, const T& J, const T& J_th, const T& phi, double alpha = 0) {
  const T Je = J / J_th;
  const T g = real(Je) >= 1 ? g_e1(m, phi, alpha) : g_e2(m, phi, alpha);
  if (m.equation_of_state != impact::EquationOfState::none)
    return g * (isotherm(m, J).dU - isotherm(m, J_th).dU);
  return g * (m.K / 2) * (Je - 1.0 / Je) / J_th;
}

template <class T> struct Flow {
  Matrix<T> s, A;
  T alpha, dbeta;
};

/// Isochoric Kirchhoff stress, plastic metric and accumulated strain. The multiplier by bisection; in T its
/// derivative follows from three more Newton steps.
template <class T>
Flow<T> return_map(const MaterialParameters& m, const Matrix<T>& F, const Matrix<double>& A_n, double alpha_n,
                   const T& phi, double theta = 298.15, double dt = 0) {
  const double q = std::sqrt(2.0 / 3);
  const T J = det(F), scale = std::pow(J, -1.0 / 3);
  Matrix<T> Fb = F;
  for (T& x : Fb) x *= scale;
  const Matrix<T> b = multiply(multiply(Fb, A_n), transpose(Fb));
  const T ge = g_e1(m, phi, alpha_n), gp = g_p(m, phi, alpha_n), mu = ge * m.G * trace(b) / 3.0;
  Matrix<T> s = b;
  for (unsigned i = 0; i < 3; ++i) s[4 * i] -= trace(b) / 3.0;
  for (T& x : s) x *= ge * m.G;
  const T norm = std::sqrt(dot(s, s));
  const auto k_of = [&](const auto& x) {
    return flow_stress(m, decltype(x + x)(alpha_n + q * x), decltype(x + x)(q * x), theta, dt);
  };
  const T f = norm - q * gp * k_of(0.0);
  Flow<T> out{s, {}, T(alpha_n), T(0.0)};
  for (unsigned i = 0; i < 9; ++i) out.A[i] = A_n[i];
  if (m.model != impact::Model::j2 || real(f) <= 0) return out;
  const double N = std::real(norm), two_mu = 2 * std::real(mu), c = q * std::real(gp);
  double low = 0, high = N / two_mu;
  for (int i = 0; i < 2000 && low < high; ++i) {
    const double x = 0.5 * (low + high);
    if (x == low || x == high) break;
    (N - two_mu * x - c * k_of(x) > 0 ? low : high) = x;
  }
  const double slope = two_mu + c * k_of(std::complex<double>(low, 1e-30 * low)).imag() / (1e-30 * low);
  T db = low;
  for (int i = 0; i < 3; ++i) db += (norm - 2.0 * mu * db - q * gp * k_of(db)) / slope;
  Matrix<T> d;
  for (unsigned i = 0; i < 9; ++i) {
    out.s[i] = s[i] - 2.0 * mu * db * s[i] / norm;
    d[i] = out.s[i] / (ge * m.G);
  }
  const T J2 = dot(d, d) / 2.0, J3 = det(d);
  T y = 1.0;
  for (int i = 0; i < 60; ++i) y -= (y * y * y - J2 * y + J3 - 1.0) / (3.0 * y * y - J2);
  for (unsigned i = 0; i < 3; ++i) d[4 * i] += y;
  const Matrix<T> Fi = inverse(Fb);
  out.A = multiply(multiply(Fi, d), transpose(Fi));
  out.alpha = alpha_n + q * db;
  out.dbeta = db;
  return out;
}

/// tau_c with p from the J of the point.
template <class T>
Matrix<T> kirchhoff(const MaterialParameters& m, const Matrix<T>& F, const Matrix<double>& A_n,
                    double alpha_n, const T& phi, const T& theta, double dt = 0) {
  Matrix<T> tau = return_map(m, F, A_n, alpha_n, phi, std::real(theta), dt).s;
  const T J = det(F), p = pressure(m, J, J_theta(m, theta), phi, alpha_n);
  for (unsigned i = 0; i < 3; ++i) tau[4 * i] += p * J;
  return tau;
}

/// U(J/J_th), or what of the energy of an equation of state lies above its least value.
template <class T> T volume_energy(const MaterialParameters& m, const T& J, const T& J_th) {
  if (m.equation_of_state != impact::EquationOfState::none) {
    const Isotherm<T> free = isotherm(m, J_th);
    return isotherm(m, J).U - free.U - free.dU * (J - J_th);
  }
  const T Je = J / J_th;
  return m.K / 2 * ((Je * Je - 1.0) / 2.0 - std::log(Je));
}

/// Elastic energy g_1 E+ + g_2 E- as a function of C and A.
template <class T>
T elastic_energy(const MaterialParameters& m, const Matrix<T>& C, const Matrix<double>& A, const T& J_vol,
                 const T& phi, const T& J_th, double alpha = 0) {
  T CA = 0.0;
  for (unsigned i = 0; i < 9; ++i) CA += C[i] * A[i];
  const T W = m.G / 2 * (std::pow(det(C), -1.0 / 3) * CA - 3.0), Je = J_vol / J_th;
  const T U = volume_energy(m, J_vol, J_th);
  return g_e1(m, phi, alpha) * W + (real(Je) >= 1 ? g_e1(m, phi, alpha) : g_e2(m, phi, alpha)) * U;
}

} // namespace reference
