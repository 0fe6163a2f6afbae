#include "integrator.hpp"
#include <cmath>
#include <string>
#include <vector>

namespace impact {

NewmarkParameters newmark_with_radius(PetscReal rho) {
  const PetscReal alpha_m = 2 / (1 + rho);
  return {.beta = alpha_m * alpha_m / 4, .gamma = alpha_m - 0.5, .alpha_m = alpha_m};
}

NewmarkCoefficients newmark_coefficients(const NewmarkParameters& parameters, PetscReal dt) {
  const auto [beta, gamma, alpha_m] = parameters;
  return {.chi1 = 1 / (beta * dt * dt),
          .chi2 = 1 / (beta * dt),
          .chi3 = 1 / (2 * beta) - 1,
          .chi4 = gamma / (beta * dt),
          .chi5 = 1 - gamma / beta,
          .chi6 = dt * (1 - gamma / (2 * beta))}; // (99-104)
}

namespace detail {

void predict(TS ts, Integrator& self) {
  const Attempt& step = self.attempt;
  Trial& trial = self.trial;
  if (!self.scheme.inertia) {
    check(VecCopy(ts->vec_sol, trial.u));
    return;
  }
  check(VecWAXPY(trial.u_tilde, step.dt, ts->vec_dot, ts->vec_sol));
  check(VecCopy(ts->vec_dot, trial.v_start));
  if (self.scheme.hooks.predict)
    self.scheme.hooks.predict(ts, step.t_n, step.dt, trial.u_tilde, trial.v_start);
  if (self.scheme.extrapolate)
    check(VecWAXPY(trial.u, step.dt * step.dt / 2, self.a, trial.u_tilde));
  else
    check(VecCopy(ts->vec_sol, trial.u));
}

void rates(TS ts, Integrator& self, Vec u) {
  Trial& trial = self.trial;
  if (!self.scheme.inertia) {
    check(VecWAXPY(trial.v, -1, ts->vec_sol, u));
    check(VecScale(trial.v, 1 / self.attempt.dt));
    return;
  }
  const NewmarkCoefficients chi = newmark_coefficients(self.scheme.parameters, self.attempt.dt);
  const PetscReal alpha_m = self.scheme.parameters.alpha_m;
  check(VecWAXPY(trial.a, -1, trial.u_tilde, u));
  check(VecCopy(trial.v_start, trial.v));
  check(VecAXPBYPCZ(trial.v, chi.chi4, chi.chi6, 1, trial.a, self.a)); // (97)
  check(VecAXPBY(trial.a, -chi.chi3, chi.chi1, self.a));               // (98)
  check(VecCopy(trial.a, trial.a_m));
  if (alpha_m != 1) check(VecAXPBY(trial.a_m, 1 - alpha_m, alpha_m, self.a));
}

Shifts shifts(const Integrator& self) {
  if (!self.scheme.inertia) return {1 / self.attempt.dt, 0};
  const NewmarkCoefficients chi = newmark_coefficients(self.scheme.parameters, self.attempt.dt);
  return {chi.chi4, self.scheme.parameters.alpha_m * chi.chi1};
}

namespace {

// The mass matrix as a difference quotient of the I2Jacobian. The shift is the step's own, where mass and
// stiffness are of like size; with shift 1 the mass would drown in the stiffness's round-off.
Handle<Mat> mass_matrix(TS ts, Vec zero) {
  Mat J = nullptr, P = nullptr;
  check(TSGetI2Jacobian(ts, &J, &P, nullptr, nullptr));
  if (P == nullptr)
    throw std::logic_error("newmark: no I2Jacobian to take the mass from; call newmark_set_acceleration");
  const PetscReal shift = 4 / (ts->time_step * ts->time_step);
  check(TSComputeI2Jacobian(ts, ts->ptime, ts->vec_sol, ts->vec_dot, zero, 0, shift, J, P));
  Handle<Mat> mass;
  check(MatDuplicate(P, MAT_COPY_VALUES, mass.out()));
  check(TSComputeI2Jacobian(ts, ts->ptime, ts->vec_sol, ts->vec_dot, zero, 0, 0, J, P));
  check(MatAXPY(mass, -1, P, SAME_NONZERO_PATTERN));
  check(MatScale(mass, 1 / shift));
  return mass;
}

// Rows without mass (prescribed displacements) become a = 0.
void close_rows_without_mass(Mat mass, Vec diagonal, Vec force) {
  check(MatGetDiagonal(mass, diagonal));
  PetscInt rows = 0;
  PetscScalar *d = nullptr, *f = nullptr;
  check(VecGetLocalSize(diagonal, &rows));
  check(VecGetArray(diagonal, &d));
  check(VecGetArray(force, &f));
  for (PetscInt i = 0; i < rows; ++i)
    if (d[i] == 0) {
      d[i] = 1;
      f[i] = 0;
    }
  check(VecRestoreArray(force, &f));
  check(VecRestoreArray(diagonal, &d));
  check(MatDiagonalSet(mass, diagonal, INSERT_VALUES));
}

void solve_mass(TS ts, Mat mass, Vec force, Vec a) {
  Handle<KSP> ksp;
  PC pc = nullptr;
  const char* prefix = nullptr;
  check(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(ts)), ksp.out()));
  check(TSGetOptionsPrefix(ts, &prefix));
  check(KSPSetOptionsPrefix(ksp, prefix));
  check(KSPAppendOptionsPrefix(ksp, "ts_newmark_start_"));
  check(KSPSetOperators(ksp, mass, mass));
  check(KSPSetType(ksp, KSPCG));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(ksp, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  check(KSPSetFromOptions(ksp));
  check(KSPSolve(ksp, force, a));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(ksp, &reason));
  if (reason < 0)
    throw UserError(ExitCode::solver, std::string("initial acceleration: the mass solve ended with ") +
                                          KSPConvergedReasons[reason] +
                                          "; see -ts_newmark_start_ksp_monitor");
}

} // namespace

void start(TS ts, Integrator& self) {
  if (self.a || !self.scheme.inertia) return;
  self.attempt = {.t_n = ts->ptime, .dt = ts->time_step, .t = ts->ptime, .number = 0};
  Handle<Vec> a;
  check(VecDuplicate(ts->vec_sol, a.out()));
  check(VecZeroEntries(a));
  if (self.scheme.hooks.initial_acceleration) {
    self.scheme.hooks.initial_acceleration(ts, ts->ptime, ts->vec_sol, ts->vec_dot, a);
  } else {
    Handle<Vec> force, diagonal;
    check(VecDuplicate(a, force.out()));
    check(VecDuplicate(a, diagonal.out()));
    const Handle<Mat> mass = mass_matrix(ts, a);
    check(TSComputeI2Function(ts, ts->ptime, ts->vec_sol, ts->vec_dot, a, force));
    check(VecScale(force, -1));
    close_rows_without_mass(mass, diagonal, force);
    PetscReal norm = 0;
    check(VecNorm(force, NORM_2, &norm));
    if (!std::isfinite(norm))
      throw UserError(ExitCode::data,
                      "initial state: the forces at the start are not finite; allowed: det F > 0 "
                      "everywhere; check the initial displacement");
    solve_mass(ts, mass, force, a);
  }
  self.a = std::move(a);
}

namespace {

void check_range(const char* option, PetscReal value, bool allowed, const char* range, const char* remedy) {
  if (!allowed)
    throw UserError(ExitCode::usage, std::string(option) + ": " + std::to_string(value) +
                                         "; allowed: " + range + "; " + remedy);
}

void check_parameters(const NewmarkParameters& p) {
  check_range("-ts_newmark_beta", p.beta, p.beta > 0 && p.beta <= 1, "0 < beta <= 1", "leave it out for 1/4");
  check_range("-ts_newmark_gamma", p.gamma, p.gamma >= 0.5 && p.gamma <= 2,
              "1/2 <= gamma <= 2, stable from 1/2 on", "leave it out for 1/2");
}

} // namespace

void read_newmark_options(TS ts, Integrator& self, OptionItems PetscOptionsObject) {
  NewmarkParameters p = self.scheme.parameters;
  PetscReal rho = 1;
  PetscBool beta = PETSC_FALSE, gamma = PETSC_FALSE, radius = PETSC_FALSE;
  check(PetscOptionsReal("-ts_newmark_beta", "Newmark's beta", nullptr, p.beta, &p.beta, &beta));
  check(PetscOptionsReal("-ts_newmark_gamma", "Newmark's gamma", nullptr, p.gamma, &p.gamma, &gamma));
  check(PetscOptionsReal("-ts_newmark_rho", "Spectral radius at infinite frequency", nullptr, rho, &rho,
                         &radius));
  const char* const guesses[] = {"previous", "extrapolated"};
  PetscInt guess = self.scheme.extrapolate ? 1 : 0;
  check(PetscOptionsEList("-ts_newmark_guess", "Start of the nonlinear solve", nullptr, guesses, 2,
                          guesses[guess], &guess, nullptr));
  self.scheme.extrapolate = guess == 1;
  if (radius) {
    check_range("-ts_newmark_rho", rho, rho >= 0 && rho <= 1, "0 <= rho <= 1", "1 damps nothing, 0 most");
    check_range("-ts_newmark_rho", rho, !beta && !gamma,
                "not together with -ts_newmark_beta or -ts_newmark_gamma", "give one or the other");
    p = newmark_with_radius(rho);
  }
  set_newmark_parameters(ts, p);
}

} // namespace detail

void set_newmark_hooks(TS ts, NewmarkHooks hooks) { detail::integrator(ts).scheme.hooks = std::move(hooks); }

void set_newmark_parameters(TS ts, const NewmarkParameters& parameters) {
  detail::check_parameters(parameters);
  detail::integrator(ts).scheme.parameters = parameters;
}

NewmarkParameters newmark_parameters(TS ts) { return detail::integrator(ts).scheme.parameters; }

Vec newmark_acceleration(TS ts) {
  const detail::Integrator& self = detail::integrator(ts);
  return self.a ? self.a.get() : nullptr;
}

Vec newmark_start_velocity(TS ts) { return detail::integrator(ts).trial.v_start; }

namespace {

PetscReal dot(Vec x, Vec y) {
  PetscReal value = 0;
  check(VecDot(x, y, &value));
  return value;
}

} // namespace

// With kappa = beta - gamma/2, delta = gamma - 1/2, mu = alpha_m - 1, da = a - a_n:
//   du = dt (v_start + v)/2 + kappa dt^2 da,   v - v_start = dt ((a_n + a)/2 + delta da + f).
NewmarkEnergy newmark_energy(const NewmarkParameters& p, const NewmarkStep& s) {
  const PetscReal kappa = p.beta - p.gamma / 2, delta = p.gamma - 0.5, mu = p.alpha_m - 1, dt = s.dt;
  const PetscReal square_n = dot(s.a_n, s.Ma_n), square = dot(s.a, s.Ma), mixed = dot(s.a_n, s.Ma),
                  of_change = square - 2 * mixed + square_n; // da . M da
  const PetscReal v_da = dot(s.v, s.Ma) - dot(s.v, s.Ma_n),
                  start_da = dot(s.v_start, s.Ma) - dot(s.v_start, s.Ma_n),
                  du_da = dot(s.du, s.Ma) - dot(s.du, s.Ma_n);
  const PetscReal f_a = dot(s.f, s.Ma), f_a_n = dot(s.f, s.Ma_n), f_f = dot(s.f, s.Mf);
  NewmarkEnergy e;
  e.loss = kappa * dt * dt * ((square - square_n) / 2 + f_a - f_a_n) - delta * dt * (start_da + v_da) / 2 +
           (mu * du_da + dot(s.du, s.lag)) / 2;                                         // (N1)
  const PetscReal whole = square + 2 * f_a + f_f, whole_n = square_n + 2 * f_a_n + f_f; // with f
  const PetscReal theta = kappa / 2 * ((mu - 0.5) * (mu - 0.5) + 1.5 * mu) + mu / 8 * (2 * mu * mu + delta);
  const PetscReal df_df = dot(s.df, s.Mdf), df_a_n = dot(s.df, s.Ma_n), df_da = dot(s.df, s.Ma) - df_a_n,
                  df_lag = dot(s.df, s.lag), sigma = (0.5 + delta + 2 * kappa) / 2; // 4 times, over mu
  e.grown = theta * dt * dt * df_df;
  e.kept = kappa / 2 * dt * dt * whole - mu / 2 * dt * v_da +
           mu / 8 * dt * dt * (whole + whole_n + (2 * kappa + delta - 0.5) * of_change) - e.grown; // (N2)
  e.exchange = -dt * dt *
                   ((kappa + mu / 2) * (df_a_n + dot(s.df, s.Mf) - df_df / 2) - df_lag / 4 +
                    sigma * (mu * (df_da + df_df) + df_lag)) +
               e.grown - s.grown + dt / 2 * dot(s.struck, s.lag); // (N3)
  return e;
}

PetscReal newmark_kept_at_start(const NewmarkParameters& p, PetscReal dt, Vec a, Vec Ma) {
  return (p.beta - p.gamma / 2 + (p.alpha_m - 1) / 2) / 2 * dt * dt * dot(a, Ma);
}

void newmark_set_acceleration(TS ts, Vec a) {
  detail::Integrator& self = detail::integrator(ts);
  if (!self.a) check(VecDuplicate(a, self.a.out()));
  check(VecCopy(a, self.a));
}

} // namespace impact
