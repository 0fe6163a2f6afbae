#pragma once
#include "ts_adapter.hpp"
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/time/newmark.hpp>
#include <impact/time/step_hooks.hpp>

/// What the types newmark and static keep in TS::data, and the parts of the scheme that the step loop calls.
namespace impact::detail {

inline constexpr const char* newmark_type = "newmark";
inline constexpr const char* static_type = "static";

struct Scheme {
  bool inertia = true; // false: type static
  bool extrapolate = true;
  NewmarkParameters parameters;
  NewmarkHooks hooks;
};

/// u_n and v_n are the TS's own vectors, untouched until a try is accepted, so that nothing needs to be
/// restored.
struct Trial {
  Handle<Vec> u_tilde, v_start, u, v, a; // v_start: v_n, or what the predictor makes of it
  Handle<Vec> a_m;                       // alpha_m a + (1 - alpha_m) a_n; zero for type static
};

struct Integrator {
  Scheme scheme;
  StepHooks hooks;
  Mailbox mailbox;
  Attempt attempt;
  Handle<Vec> a; // a_n; empty until set or computed
  Trial trial;
};

/// Throws std::logic_error when the TS has neither type.
Integrator& integrator(TS ts);

/// Sets u_tilde and the first guess of trial.u.
void predict(TS ts, Integrator& self);
/// v, a and a_m of the trial for displacement u (97-98).
void rates(TS ts, Integrator& self, Vec u);
/// dv/du and da_m/du.
struct Shifts {
  PetscReal v, a;
};
Shifts shifts(const Integrator& self);
/// Fills self.a when it is empty.
void start(TS ts, Integrator& self);
void read_newmark_options(TS ts, Integrator& self, OptionItems PetscOptionsObject);

} // namespace impact::detail
