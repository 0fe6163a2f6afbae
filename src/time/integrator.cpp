#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/time/integrator.hpp>
#include <limits>

namespace impact {

Integrator newmark_with_radius(PetscReal rho) {
  const PetscReal alpha_m = 2 / (1 + rho);
  return {.beta = alpha_m * alpha_m / 4, .gamma = alpha_m - 0.5, .alpha_m = alpha_m};
}

Integrator central_differences() { return {.beta = 0, .gamma = 0.5}; }

Integrator::Coefficients Integrator::coefficients(PetscReal dt) const {
  return {.chi1 = 1 / (beta * dt * dt),
          .chi3 = s / (2 * beta) - 1,
          .chi4 = gamma / (beta * dt),
          .chi6 = dt * (1 - s * gamma / (2 * beta))};
}

PetscReal Integrator::velocity(PetscReal dt, const StartOfStep& start, std::vector<double>& offset) const {
  offset.resize(start.u.size());
  const auto [chi1, chi3, chi4, chi6] = inertia ? coefficients(dt) : Coefficients{0, 0, 1 / dt, 0};
  const double rest = inertia ? 1 : 0;
  for (std::size_t i = 0; i < offset.size(); ++i)
    offset[i] = rest * (start.v[i] + chi6 * start.a[i]) - chi4 * (start.u[i] + rest * dt * start.v[i]);
  return chi4;
}

// With z the amplification and y = (z - 1)/(z + 1) the oscillator a + omega^2 u = 0 gives
//   4 y^2 (1 + (2 alpha_m - 1) y) + (omega dt)^2 (1 + y) (1 + b y + c y^2) = 0,
// whose roots have no positive real part under the conditions of Hurwitz, all linear in (omega dt)^2.
PetscReal Integrator::stability_limit() const {
  const PetscReal b = 2 * gamma + s - 2, c = 4 * beta - 2 * gamma - s + 1;
  PetscReal square = std::numeric_limits<PetscReal>::infinity();
  const auto at_least_zero = [&](PetscReal constant, PetscReal slope) {
    if (constant < 0) square = 0;
    if (slope < 0) square = std::min(square, std::max<PetscReal>(-constant / slope, 0));
  };
  at_least_zero(4 * (2 * alpha_m - 1), c);
  at_least_zero(4, b + c);
  at_least_zero(1 + b, 0);
  at_least_zero(4 * (2 + b - 2 * alpha_m), 4 * beta * b);
  return std::sqrt(square);
}

namespace {

PetscReal dot(Vec x, Vec y) { return Get(VecDot)(x, y); }

} // namespace

// With kappa = beta - gamma/2, delta = gamma - 1/2, mu = alpha_m - 1, da = a - a_n:
//   du = dt (v_start + v)/2 + kappa dt^2 da + (s - 1)/2 dt^2 a_n,
//   v - v_start = dt ((a_n + a)/2 + delta da).
IntegratorEnergy Integrator::energy(const IntegratorStep& step) const {
  const PetscReal kappa = beta - gamma / 2, delta = gamma - 0.5, mu = alpha_m - 1, dt = step.dt;
  const PetscReal square_n = dot(step.a_n, step.Ma_n), square = dot(step.a, step.Ma),
                  mixed = dot(step.a_n, step.Ma);
  const PetscReal v_da = dot(step.v, step.Ma) - dot(step.v, step.Ma_n),
                  start_da = dot(step.v_start, step.Ma) - dot(step.v_start, step.Ma_n),
                  du_da = dot(step.du, step.Ma) - dot(step.du, step.Ma_n);
  IntegratorEnergy e;
  e.loss = kappa * dt * dt * (square - square_n) / 2 - delta * dt * (start_da + v_da) / 2 +
           (mu * du_da + dot(step.du, step.lag)) / 2; // (N1)
  if (s != 1) {
    e.loss += (s - 1) / 2 * dt * dt * (square_n + mixed) / 2;
    return e;
  }
  // Products with M: d is the change of a in the step before.
  const auto kept = [&](PetscReal v_d, PetscReal a_a, PetscReal a_d, PetscReal d_d) {
    return kappa / 2 * dt * dt * a_a - mu / 2 * dt * v_d +
           mu / 8 * dt * dt * (2 * (a_a - a_d) + (2 * kappa + delta + 0.5) * d_d);
  };
  e.kept = kept(v_da, square, square - mixed, square - 2 * mixed + square_n); // (N2)
  e.exchange = step.kept - kept(dot(step.v_start, step.Mchange), square_n, dot(step.a_n, step.Mchange),
                                dot(step.change, step.Mchange)); // (N3)
  return e;
}

PetscReal Integrator::kept_at_start(PetscReal dt, Vec a, Vec Ma) const {
  if (s != 1) return 0;
  return (beta - gamma / 2 + (alpha_m - 1) / 2) / 2 * dt * dt * dot(a, Ma);
}

} // namespace impact
