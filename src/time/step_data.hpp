#pragma once
#include "ts_adapter.hpp"
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/time/integrator.hpp>
#include <impact/time/step_hooks.hpp>

/// What the types newmark and static keep in TS::data, and the stages of a step that the step loop calls.
namespace impact::detail {

inline constexpr const char* newmark_type = "newmark";
inline constexpr const char* static_type = "static";

/// u_n and v_n are the TS's own vectors, untouched until a try is accepted, so that nothing needs to be
/// restored.
struct Trial {
  Handle<Vec> u_tilde, v_start, u, v, a; // v_start: v_n, or what the predictor makes of it
  Handle<Vec> a_m;                       // alpha_m a + (1 - alpha_m) a_n; zero for type static
};

struct StepData {
  Integrator integrator;
  bool extrapolate = true; // the first guess
  StepHooks hooks;
  Mailbox mailbox;
  Attempt attempt;
  Handle<Vec> a; // a_n; empty until set
  Trial trial;
};

/// Throws std::logic_error when the TS has neither type.
StepData& step_data(TS ts);

/// v, a and a_m of the trial for displacement u (97-98).
void find_rates(TS ts, StepData& self, Vec u);
/// An implicit stage: predictor, guess and nonlinear solve into trial.u. True when it converged; otherwise
/// TSAdaptCheckStage has cut ts->time_step.
bool solve_stage(TS ts, StepData& self);
/// -ts_newmark_beta, _gamma, _rho, _guess.
void read_newmark_options(StepData& self, OptionItems PetscOptionsObject);
/// Throws UserError for weights of Newmark's family that are out of range.
void check_newmark(const Integrator& integrator);

} // namespace impact::detail
