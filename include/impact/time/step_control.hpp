#pragma once
#include <petscts.h>
#include <vector>

/// Step-size control of the TSAdapt type `step_control`: a failed try halves dt
/// (-ts_adapt_scale_solve_failed), four easy steps in a row (-ts_adapt_easy_steps) let it grow by 1.5
/// (-ts_adapt_grow) up to the limit: -ts_dt, or the step table t_0, t_1, .., d_0, d_1, .. (dt = d_i between
/// t_i and t_{i+1}; the last d goes on). A step is easy when it took at most -ts_adapt_easy_its
/// (default 10) iterations. Where the hook `utilisation` measures the step's increments against limits, dt
/// follows it instead of the count of easy steps: grown after each easy step, and at most what is expected to
/// use up 0.6 of them. The run gives up with TS_DIVERGED_STEP_REJECTED after -ts_max_reject (10) refused
/// tries of one step or when dt falls under -ts_adapt_dt_min.
///
/// Given times, the times of the table and -ts_max_time are hit exactly: the time after such a step equals
/// the given number bit for bit. The step before is shortened, and the remembered dt is not touched by that.
/// A time that one full step would miss by less than a tenth of dt is reached in two halves, so that no
/// sliver of a step is left over. Times closer to each other than 1e-6 dt count as one, the last of them.
namespace impact {

/// All that a restart needs beside t, u, v, a.
struct StepControlState {
  PetscReal dt = 0;        // remembered step, not shortened; 0: none yet
  bool at_limit = true;    // dt is at its limit, so it follows the limit when that changes
  PetscInt easy_steps = 0; // in a row since the last growth, cut or hard step
  PetscInt rejections = 0; // refused tries since the start of the run
};

StepControlState step_control_state(TS ts);
void set_step_control_state(TS ts, const StepControlState& state);

/// Takes the place of the TS's time step as the limit of all steps. Before the first one.
void set_step_limit(TS ts, PetscReal limit);

/// Replaces the list of times to be hit exactly (any order; those in the past are ignored).
void set_exact_times(TS ts, std::vector<PetscReal> times);

/// Makes the middles and the ends of the periods of a cyclic load times to be hit exactly; 0: none.
void set_step_period(TS ts, PetscReal period);

/// Replaces the step table: increasing times, dts > 0, as many as times or one fewer; both empty: none.
void set_step_table(TS ts, std::vector<PetscReal> times, std::vector<PetscReal> dts);

} // namespace impact
