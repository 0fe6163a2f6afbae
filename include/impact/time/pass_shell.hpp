#pragma once
#include <functional>
#include <impact/petsc/error.hpp>
#include <petscsnes.h>

/// A SNES whose iteration is a pass of other solvers over the same unknown: staggering, augmentation. It
/// stays a SNES for the command line: -<prefix>snes_max_it, _atol, _monitor, _converged_reason.
namespace impact {

/// One pass: what its inner solves said (negative: the pass failed) and how much it changed the state.
struct PassResult {
  SNESConvergedReason inner = SNES_CONVERGED_ITS;
  PetscReal change = 0;
  bool rough = false; ///< by inner solves that want another pass however small the change
  bool counts = true; ///< against -<prefix>snes_max_it; a pass that does not begins the count anew
};

/// Runs pass 1, 2, .. on x until the change of one that is not rough is below -<prefix>snes_atol. A failed
/// pass ends with SNES_DIVERGED_INNER;
/// -<prefix>snes_max_it passes that count, in a row and without convergence, with SNES_DIVERGED_MAX_IT,
/// except that a single pass (max_it 1) counts as converged where it is a method of its own. The same on all
/// ranks as far as `pass` answers the same.
struct PassShell {
  std::function<PassResult(PetscInt pass, Vec x)> pass;
  Mailbox* mailbox = nullptr; // takes the exceptions of `pass`
  bool single_pass = true;    // a method of its own where max_it is 1: what it leaves counts as converged
  /// Told of the passes without convergence and of the last one's change, before the shell gives up.
  std::function<void(PetscInt passes, PetscReal change)> gives_up = {};
};

/// Makes `snes` such a shell; `shell` must outlive it. To be called before SNESSetFromOptions.
void make_pass_shell(SNES snes, PassShell& shell);

} // namespace impact
