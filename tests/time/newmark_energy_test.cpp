#include "simulation.hpp"
#include <gtest/gtest.h>

namespace impact {

using time_test::Simulation;

namespace {

/// Hard springs with masses of 2, whose scheme is disturbed by shocks, by cut steps and, where that moves
/// nothing, by forces that are taken out of the acceleration.
struct Springs {
  static constexpr PetscReal mass = 2, longest = 0.3;
  Simulation simulation{time_test::equations_of({.m = mass, .k = 1, .cubic = 4}), 5};
  Integrator weights;
  bool disturbed;
  Handle<Vec> f, lag, inertia, a_before;
  PetscReal kept = 0, largest_error = 0, least_loss = 0, left = 0, energy_of_wrong = 0, left_of_wrong = 0;
  Integrator wrong;
  int steps = 0;

  Springs(const Integrator& given, bool with_hooks) : weights(given), disturbed(with_hooks), wrong(given) {
    for (Handle<Vec>* vec : {&f, &lag, &inertia, &a_before}) {
      check(VecDuplicate(simulation.u, vec->out()));
      check(VecSet(*vec, 0));
    }
    time_test::fill(simulation.u, [](PetscInt i) { return 1 - 0.3 * static_cast<PetscReal>(i); });
    time_test::fill(simulation.v, [](PetscInt i) { return 0.2 * static_cast<PetscReal>(i % 3); });
    set_integrator(simulation.ts, weights);
    StepHooks hooks;
    if (disturbed) {
      hooks.predict = [](TS, const Attempt& attempt, Vec u_tilde, Vec v) {
        check(VecShift(v, -0.02));
        check(VecShift(u_tilde, -0.02 * attempt.dt));
      };
    }
    if (disturbed && weights.moves_by_mean_velocity()) {
      hooks.correct = [this](TS, Vec u, Vec, Vec a) {
        check(VecCopy(u, f));
        check(VecScale(f, 0.1 * 2 * weights.beta));
        check(VecAXPY(a, -1 / (2 * weights.beta), f));
      };
    }
    hooks.accept = [this](TS ts, const Attempt& attempt, Vec u, Vec v, Vec a) {
      if (disturbed && attempt.number == 1 && (steps == 3 || steps == 9))
        return Verdict{.accept = false, .factor = 0.6};
      audit(ts, attempt.dt, u, v, a);
      return Verdict{};
    };
    set_step_hooks(simulation.ts, hooks);
  }

  static PetscReal dot(Vec x, Vec y) {
    PetscReal value = 0;
    check(VecDot(x, y, &value));
    return value;
  }
  static Handle<Vec> combine(PetscReal p, Vec x, PetscReal q, Vec y) {
    Handle<Vec> sum;
    check(VecDuplicate(x, sum.out()));
    check(VecCopy(x, sum));
    check(VecAXPBY(sum, q, p, y));
    return sum;
  }

  void audit(TS ts, PetscReal dt, Vec u, Vec v, Vec a) {
    Vec u_n = nullptr;
    check(TS2GetSolution(ts, &u_n, nullptr));
    const Vec a_n = acceleration(ts), v_start = start_velocity(ts);
    const PetscReal alpha_m = weights.alpha_m;
    if (steps++ == 0) {
      check(VecAXPY(inertia, mass, a_n));
      check(VecCopy(a_n, a_before));
      const Handle<Vec> Ma = combine(mass, a_n, 0, a_n);
      kept = weights.kept_at_start(dt, a_n, Ma);
    }
    const Handle<Vec> du = combine(1, u, -1, u_n), Ma_n = combine(mass, a_n, 0, a_n),
                      Ma = combine(mass, a, 0, a), of_step = combine(alpha_m, Ma, 1 - alpha_m, Ma_n),
                      mean = combine(0.5, inertia, 0.5, of_step), change_n = combine(1, a_n, -1, a_before),
                      Mchange = combine(mass, change_n, 0, change_n), change = combine(1, a, -1, a_before);
    check(VecWAXPY(lag, -1, Ma_n, inertia));
    const IntegratorStep step{.dt = dt,
                              .du = du,
                              .v_start = v_start,
                              .v = v,
                              .a_n = a_n,
                              .a = a,
                              .change = change_n,
                              .Ma_n = Ma_n,
                              .Ma = Ma,
                              .Mchange = Mchange,
                              .lag = lag,
                              .kept = kept};
    const IntegratorEnergy energy = weights.energy(step);
    const PetscReal rise = mass * (dot(v, v) - dot(v_start, v_start)) / 2,
                    work = dot(du, mean) + mass * dot(du, f);
    largest_error = std::max(largest_error, std::abs(rise - work + energy.loss));
    const IntegratorEnergy of_wrong = wrong.energy(step);
    energy_of_wrong = std::max(energy_of_wrong, std::abs(rise - work + of_wrong.loss));
    const PetscReal kappa = weights.beta - weights.gamma / 2, delta = weights.gamma - 0.5,
                    lost = energy.loss - (energy.kept - kept) - energy.exchange,
                    expected =
                        mass * dt * dt * (alpha_m - 1) / 8 * (0.5 + delta + 2 * kappa) * dot(change, change);
    left = std::max(left, std::abs(lost - expected));
    left_of_wrong = std::max(left_of_wrong,
                             std::abs(energy.loss - (of_wrong.kept - kept) - of_wrong.exchange - expected));
    least_loss = std::min(least_loss, lost);
    kept = energy.kept;
    check(VecCopy(of_step, inertia));
    check(VecCopy(a_n, a_before));
  }
};

const Integrator sets[] = {
    newmark_with_radius(1),          newmark_with_radius(0.8),
    newmark_with_radius(0.3),        {.beta = 0.36, .gamma = 0.7},
    {.beta = 0.35, .gamma = 0.7},    {.beta = 0.3, .gamma = 0.6, .alpha_m = 1.05},
    {.beta = 0.3, .gamma = 0.5},     {.beta = 0.4, .gamma = 0.6, .alpha_m = 1.2},
    {.beta = 1, .gamma = 1, .s = 2}, {.beta = 0.6, .gamma = 0.8, .alpha_m = 0.9, .s = 1.3}};

TEST(NewmarkEnergy, ClosedFormIsTheChangeOfTheKineticEnergyLessTheWorkOfInertia) {
  for (const Integrator& weights : sets)
    for (const bool disturbed : {false, true}) {
      Springs springs(weights, disturbed);
      time_test::run(springs.simulation, Springs::longest, 9);
      EXPECT_GE(springs.steps, 30);
      EXPECT_LT(springs.largest_error, 1e-13) << weights.beta << " " << disturbed; // of an energy of 5
    }
}

TEST(NewmarkEnergy, WrongWeightShows) {
  for (int kind = 0; kind < 3; ++kind) {
    Springs springs(newmark_with_radius(0.9), true);
    (kind == 0 ? springs.wrong.beta : kind == 1 ? springs.wrong.gamma : springs.wrong.alpha_m) *= 1.001;
    time_test::run(springs.simulation, Springs::longest, 9);
    EXPECT_GT(springs.energy_of_wrong, 1e-6) << kind;
    EXPECT_GT(springs.left_of_wrong, 1e-6) << kind;
  }
}

TEST(NewmarkEnergy, DampedFamilyLosesASquareBesideWhatItKeepsAndExchanges) {
  std::vector<Integrator> family{{.beta = 0.4, .gamma = 0.6, .alpha_m = 1.1}};
  for (const PetscReal rho : {1.0, 0.9, 0.5, 0.0}) family.push_back(newmark_with_radius(rho));
  for (const Integrator& weights : family)
    for (const bool disturbed : {false, true}) {
      Springs springs(weights, disturbed);
      time_test::run(springs.simulation, Springs::longest, 30);
      EXPECT_LT(springs.left, 1e-13) << weights.alpha_m << " " << disturbed;
      EXPECT_GE(springs.least_loss, -1e-15) << weights.alpha_m << " " << disturbed;
    }
}

} // namespace
} // namespace impact
