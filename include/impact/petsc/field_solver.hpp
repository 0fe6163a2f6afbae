#pragma once
#include <impact/petsc/entries.hpp>
#include <impact/petsc/error.hpp>
#include <petscsnes.h>
#include <string>
#include <tuple>

/// What the nonlinear solvers of all fields have in common: only a residual within its tolerance is a
/// solution.
namespace impact {

/// The value that a function of PETSc leaves in its last argument: Get(SNESGetKSP)(snes).
template <class... Parameters> class Get {
public:
  explicit Get(PetscErrorCode (*call)(Parameters...),
               const std::source_location& where = std::source_location::current())
      : call_(call), where_(where) {}
  template <class... Arguments> auto operator()(const Arguments&... arguments) const {
    std::remove_pointer_t<std::tuple_element_t<sizeof...(Arguments), std::tuple<Parameters...>>> value{};
    check(call_(arguments..., &value), where_);
    return value;
  }

private:
  PetscErrorCode (*call_)(Parameters...);
  std::source_location where_;
};

/// Whether an object of PETSc has one of these types.
template <class Object, class... Types> bool has_type(Object object, Types... types) {
  PetscBool has = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(object), &has, types..., ""));
  return has;
}

/// A member function as PETSc calls it back: Callback<&Class::method>::call takes the method's arguments and
/// then the object as its context. The class offers `Mailbox& mailbox()`, where exceptions wait until the
/// solve has returned.
template <auto method> struct Callback;

template <class Object, class... Arguments, void (Object::*method)(Arguments...)> struct Callback<method> {
  static PetscErrorCode call(Arguments... arguments, void* context) {
    auto& self = *static_cast<Object*>(context);
    return self.mailbox().guarded([&] { (self.*method)(arguments...); });
  }
};

/// How the solve for a scalar field ended.
struct ScalarOutcome {
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  PetscInt newton = 0, linear = 0;
  std::string cause = {}; ///< of a failure, where there is more to say than its reason
};

/// Solves for x; rethrows what a callback left in `mailbox`. Collective.
ScalarOutcome solve_field(SNES snes, Vec x, Mailbox& mailbox);

/// Raises the absolute tolerance to the norm of 1e-15 of `sizes`: the terms summed in each row. Collective.
void allow_rounding(SNES snes, Vec sizes);

/// Why the solve ended: SNES_DIVERGED_LINE_SEARCH in place of a convergence that says nothing about the
/// residual, SNES_CONVERGED_FNORM_ABS where a line search found no smaller one than rounding allows.
SNESConvergedReason reason_by_residual(SNES snes);

/// To be called once the options are read: the smoothers of GAMG's levels estimate their own bounds unless
/// the options say otherwise. That of smoothing the prolongators is the first matrix's, which they would keep
/// when they are set up for another one: plastic flow makes them diverge.
void settle_smoothers(PC pc);
/// The same, and on several ranks conjugate gradients by the norm that they find anyway, unless the options
/// name one: they ask all ranks once in an iteration (KSPCGUseSingleReduction), not three times. Collective.
void settle_solver(KSP ksp);

/// Leaves the linear solver of `snes` as if it had never solved: factors, hierarchies, and what a
/// preconditioner keeps beside them. Collective.
void forget_factors(SNES snes);

/// The linear solver that `snes` has: "preonly + lu by mumps".
std::string linear_solver_text(SNES snes);

} // namespace impact
