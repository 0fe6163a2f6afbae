#pragma once
#include <impact/petsc/handle.hpp>
#include <impact/time/step_control.hpp>
#include <impact/time/types.hpp>
#include <vector>

// The only door to PETSc's private TS header: a TS type or TSAdapt type cannot be written without it. What
// changed between versions is met here, so that the files that include this one read the same for all of
// them.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <petsc/private/tsimpl.h>
#pragma GCC diagnostic pop

#if PETSC_VERSION_LT(3, 18, 0)
#error "impact needs PETSc 3.18 or later"
#endif

/// What our types keep in TS::data and step_control in TSAdapt::data, and what the step
/// loop asks of the control.
namespace impact::detail {

// PetscOptionItems became a pointer in a later version; the slot of the operation knows which it is.
template <class Operation> struct LastArgument;
template <class First, class Last> struct LastArgument<PetscErrorCode (*)(First, Last)> {
  using type = Last;
};
using OptionItems = LastArgument<decltype(_TSOps::setfromoptions)>::type;

#if PETSC_VERSION_GE(3, 22, 0)
inline constexpr PetscInt unlimited = PETSC_UNLIMITED;
#else
inline constexpr PetscInt unlimited = -1;
#endif

inline constexpr const char* step_control_type = "step_control";

struct StepPlan {
  PetscReal dt = 0;
  PetscReal t = 0; // end of the step; bit for bit a given time when one is hit
};

struct StepControl {
  StepControlState state;
  PetscReal limit = 0;                // -ts_dt; 0: taken from the TS at the first step
  PetscReal longest = PETSC_MAX_REAL; // StepHooks::longest
  PetscReal grow = 1.5;
  PetscInt easy_steps = 4, easy_its = 10;
  PetscInt effort = 0;       // iterations of the step under judgement
  PetscReal utilisation = 0; // part of its limits that the step under judgement used up; 0: there are none
  PetscReal period = 0;      // of a cyclic load, whose middles and ends are hit; 0: none
  std::vector<PetscReal> times;
  std::vector<PetscReal> table_times, table_dts;
  Mailbox mailbox;
};

/// The control of this TS, or null when another TSAdapt type was chosen.
StepControl* find_control(TS ts);
/// The next try from the current time with the remembered dt.
StepPlan plan_step(TS ts, StepControl& control);
/// Below it no step is tried at time t: what thirty halvings of -ts_dt did not help does not come from the
/// length of the step.
PetscReal smallest_step(const StepControl& control, PetscReal t);
/// A try was refused; ts->time_step is already the reduced one.
void note_rejection(TS ts, StepControl& control);

void register_step_control();

/// u_n and v_n are the TS's own vectors, untouched until a try is accepted, so that nothing needs to be
/// restored.
struct Trial {
  Handle<Vec> u_tilde, v_start, u, v, a; // v_start: v_n, or what the predictor makes of it
  Handle<Vec> a_m;                       // alpha_m a + (1 - alpha_m) a_n; zero for type static
};

struct StepData {
  Integrator integrator;
  bool reads_weights = false; // -ts_newmark_...
  bool extrapolate = true;    // the first guess
  StepHooks hooks;
  Mailbox mailbox;
  Attempt attempt;
  Handle<Vec> a; // a_n; empty until set
  Trial trial;
};

} // namespace impact::detail
