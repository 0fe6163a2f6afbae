#pragma once
#include "ts_adapter.hpp"
#include <impact/petsc/error.hpp>
#include <impact/time/step_control.hpp>
#include <vector>

/// What the type step_control keeps in TSAdapt::data, and what the step loop asks of it.
namespace impact::detail {

inline constexpr const char* step_control_type = "step_control";

struct StepPlan {
  PetscReal dt = 0;
  PetscReal t = 0; // end of the step; bit for bit a given time when one is hit
};

struct StepControl {
  StepControlState state;
  PetscReal limit = 0; // -ts_dt; 0: taken from the TS at the first step
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

} // namespace impact::detail
