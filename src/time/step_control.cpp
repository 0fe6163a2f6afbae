#include "step_data.hpp"
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <limits>
#include <memory>
#include <string>

namespace impact {

namespace detail {

namespace {

constexpr PetscReal same_time = 1e-6; // fraction of dt
constexpr PetscReal sliver = 0.1;     // fraction of dt
constexpr PetscReal aim = 0.6;        // part of its limits that the next step shall use up

StepControl& self(TSAdapt adapt) { return *static_cast<StepControl*>(adapt->data); }

// The limit on dt for a step that starts at t.
PetscReal limit_at(const StepControl& control, PetscReal t) {
  if (control.table_times.empty()) return control.limit;
  const auto& times = control.table_times;
  const auto later = std::upper_bound(times.begin(), times.end(), t);
  const auto interval = static_cast<std::size_t>(std::max<std::ptrdiff_t>(later - times.begin() - 1, 0));
  return control.table_dts[std::min(interval, control.table_dts.size() - 1)];
}

// The next time to be hit after t: the last of those that count as one with the first.
PetscReal next_time(const StepControl& control, PetscReal t, PetscReal max_time, PetscReal tolerance) {
  const PetscReal half = control.period / 2,
                  of_cycle = control.period > 0 ? half * (std::floor((t + tolerance) / half) + 1) : max_time;
  const auto visit = [&](auto&& see) {
    for (const PetscReal time : control.times) see(time);
    for (const PetscReal time : control.table_times) see(time);
    see(max_time);
    see(of_cycle);
  };
  PetscReal next = std::numeric_limits<PetscReal>::infinity();
  visit([&](PetscReal time) {
    if (time - t > tolerance) next = std::min(next, time);
  });
  const PetscReal cluster = next + tolerance;
  visit([&](PetscReal time) {
    if (time <= cluster) next = std::max(next, time);
  });
  return next;
}

// The number that so many significant digits tell.
PetscReal rounded(PetscReal value, int digits) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, digits);
  std::from_chars(text.data(), end.ptr, value);
  return value;
}

// Sums of a dt that was typed are what their user reads: three steps of 0.1 end at 0.3, where (t<=0.3) holds,
// and not an ulp later. One that was computed has more digits than that.
PetscReal after(PetscReal t, PetscReal dt) {
  const bool typed = std::abs(rounded(dt, 12) - dt) <= 1e-15 * dt; // the product of a number and a unit too
  return typed ? rounded(t + dt, 15) : t + dt;
}

StepPlan plan_from(TSAdapt adapt, StepControl& control, PetscReal t, PetscReal max_time) {
  StepControlState& state = control.state;
  const PetscReal limit = std::min({limit_at(control, t), adapt->dt_max, control.longest});
  state.at_limit = state.at_limit || state.dt <= 0 || state.dt >= limit;
  if (state.at_limit) state.dt = limit;
  const PetscReal target =
      next_time(control, t, max_time, same_time * std::min(state.dt, std::max<PetscReal>(max_time - t, 0)));
  const PetscReal rest = target - t;
  if (rest <= (1 + same_time) * state.dt) return {rest, target};
  if (rest < (1 + sliver) * state.dt) return {rest / 2, t + rest / 2};
  return {state.dt, after(t, state.dt)};
}

// An accepted step of size h: count it, let dt grow, answer with the next step.
PetscErrorCode choose(TSAdapt adapt, TS ts, PetscReal h, PetscInt* next_scheme, PetscReal* next_h,
                      PetscBool* accept, PetscReal* wlte, PetscReal* wltea, PetscReal* wlter) {
  return self(adapt).mailbox.guarded([&] {
    StepControl& control = self(adapt);
    StepControlState& state = control.state;
    if (control.limit <= 0) control.limit = h;
    state.easy_steps = control.effort <= control.easy_its ? state.easy_steps + 1 : 0;
    // A measured increment says more about the next step than a number of easy ones.
    const bool measured = control.utilisation > 0;
    if (state.easy_steps >= (measured ? 1 : control.easy_steps)) {
      state.easy_steps = 0;
      state.dt *= control.grow;
    }
    if (measured && state.dt > aim * h / control.utilisation) {
      state.dt = aim * h / control.utilisation;
      state.at_limit = false;
    }
    *next_scheme = 0;
    *next_h = plan_from(adapt, control, ts->ptime + h, ts->max_time).dt;
    *accept = PETSC_TRUE;
    *wlte = *wltea = *wlter = -1; // no estimate of the local error
  });
}

void check_step(PetscReal dt) {
  if (!(dt > 0) || !std::isfinite(dt))
    throw UserError(ExitCode::usage,
                    "-ts_dt: " + std::to_string(dt) + "; allowed: > 0; give the largest time step");
}

PetscErrorCode set_from_options(TSAdapt adapt, OptionItems PetscOptionsObject) {
  return self(adapt).mailbox.guarded([&] {
    StepControl& control = self(adapt);
    check(PetscOptionsReal("-ts_adapt_grow", "Factor of dt after enough easy steps", nullptr, control.grow,
                           &control.grow, nullptr));
    check(PetscOptionsInt("-ts_adapt_easy_steps", "Easy steps in a row before dt grows", nullptr,
                          control.easy_steps, &control.easy_steps, nullptr));
    check(PetscOptionsInt("-ts_adapt_easy_its", "Most iterations of an easy step", nullptr, control.easy_its,
                          &control.easy_its, nullptr));
    if (!(control.grow >= 1) || control.easy_steps < 1 || control.easy_its < 0)
      throw UserError(ExitCode::usage,
                      "-ts_adapt_grow, _easy_steps, _easy_its: " + std::to_string(control.grow) + ", " +
                          std::to_string(control.easy_steps) + ", " + std::to_string(control.easy_its) +
                          "; allowed: >= 1, >= 1, >= 0; leave them out for 1.5, 4, 10");
  });
}

PetscErrorCode view(TSAdapt adapt, PetscViewer viewer) {
  const StepControlState& state = self(adapt).state;
  return PetscViewerASCIIPrintf(viewer, "  remembered dt %g, easy steps %d, rejected tries %d\n",
                                static_cast<double>(state.dt), static_cast<int>(state.easy_steps),
                                static_cast<int>(state.rejections));
}

PetscErrorCode destroy(TSAdapt adapt) {
  const std::unique_ptr<StepControl> owned(&self(adapt));
  adapt->data = nullptr;
  return {};
}

PetscErrorCode create(TSAdapt adapt) {
  adapt->data = std::make_unique<StepControl>().release();
  adapt->scale_solve_failed = 0.5;
  adapt->ops->choose = choose;
  adapt->ops->setfromoptions = set_from_options;
  adapt->ops->view = view;
  adapt->ops->destroy = destroy;
  return {};
}

} // namespace

StepControl* find_control(TS ts) {
  const TSAdapt adapt = Get(TSGetAdapt)(ts);
  if (Get(TSAdaptGetType)(adapt) == nullptr) check(TSAdaptSetType(adapt, step_control_type));
  return has_type(adapt, step_control_type) ? &self(adapt) : nullptr;
}

StepPlan plan_step(TS ts, StepControl& control) {
  if (control.limit <= 0) {
    check_step(ts->time_step);
    control.limit = ts->time_step;
  }
  return plan_from(ts->adapt, control, ts->ptime, ts->max_time);
}

PetscReal smallest_step(const StepControl& control, PetscReal t) {
  return 1e-9 * std::min(limit_at(control, t), control.longest);
}

void note_rejection(TS ts, StepControl& control) {
  StepControlState& state = control.state;
  state.dt = ts->time_step;
  state.at_limit = false;
  // What was just refused is not tried again at once.
  state.easy_steps = control.utilisation > 0 ? -1 : 0;
  ++state.rejections;
}

void register_step_control() { check(TSAdaptRegister(step_control_type, create)); }

} // namespace detail

namespace {

detail::StepControl& control_of(TS ts) {
  detail::StepControl* const control = detail::find_control(ts);
  if (control == nullptr)
    throw UserError(ExitCode::usage,
                    "-ts_adapt_type: another type than step_control was chosen, which keeps neither "
                    "exact times nor a state for restarts; leave the option out");
  return *control;
}

} // namespace

StepControlState step_control_state(TS ts) { return control_of(ts).state; }

void set_step_control_state(TS ts, const StepControlState& state) { control_of(ts).state = state; }

void set_step_limit(TS ts, PetscReal limit) { control_of(ts).limit = limit; }

void set_exact_times(TS ts, std::vector<PetscReal> times) { control_of(ts).times = std::move(times); }

void set_step_period(TS ts, PetscReal period) { control_of(ts).period = period; }

void set_step_table(TS ts, std::vector<PetscReal> times, std::vector<PetscReal> dts) {
  detail::StepControl& control = control_of(ts);
  control.table_times = std::move(times);
  control.table_dts = std::move(dts);
}

} // namespace impact
