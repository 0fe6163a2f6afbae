#pragma once
#include <functional>
#include <petscts.h>

/// Newmark's method and its damped family with all forces at t_{n+1}: find u with
///   F(t_{n+1}, u, v_{n+1}, alpha_m a_{n+1} + (1 - alpha_m) a_n) = 0,
///   a_{n+1} = chi1 (u - u_tilde) - chi3 a_n,             u_tilde = u_n + dt v_n               (98)
///   v_{n+1} = v_n + chi4 (u - u_tilde) + chi6 a_n                                           (97)
/// which are the paper's formulas with chi2 = chi1 dt and chi5 = 1 - chi4 dt folded into u_tilde (99-104).
///
/// Options, behind the prefix of the TS: -ts_newmark_beta (1/4), -ts_newmark_gamma (1/2); or -ts_newmark_rho,
/// the spectral radius at infinite frequency: alpha_m = 2/(1+rho), gamma = alpha_m - 1/2, beta = alpha_m^2/4
/// (W. L. Wood, M. Bossak, O. C. Zienkiewicz, Int. J. Numer. Meth. Engng 15 (1980) 1562), second order for
/// every rho; -ts_newmark_guess extrapolated/previous: Newton starts at u_tilde + dt^2/2 a_n (default) or at
/// u_n; -ts_newmark_start_ksp_* and -ts_newmark_start_pc_* steer the solve for the initial acceleration.
namespace impact {

struct NewmarkParameters {
  PetscReal beta = 0.25;
  PetscReal gamma = 0.5;
  PetscReal alpha_m = 1; // 1: Newmark
};

/// The member of the damped family with spectral radius rho in [0, 1]. rho = 1 is the set above.
NewmarkParameters newmark_with_radius(PetscReal rho);

/// Coefficients of (97-98).
struct NewmarkCoefficients {
  PetscReal chi1, chi2, chi3, chi4, chi5, chi6;
};
NewmarkCoefficients newmark_coefficients(const NewmarkParameters& parameters, PetscReal dt);

/// Changes of the scheme, for contact-stabilised Newmark (P. Deuflhard, R. Krause, S. Ertel, Int. J. Numer.
/// Meth. Engng 73 (2008) 1274). Empty functions are skipped.
struct NewmarkHooks {
  /// u_tilde = u_n + dt v and v = v_n on entry; the step goes on from what they are afterwards. A shock that
  /// changes v changes u_tilde by dt times that.
  std::function<void(TS, PetscReal t_n, PetscReal dt, Vec u_tilde, Vec v)> predict = {};
  /// After a converged solve, before the step is judged: v and a may be changed, u must not.
  /// With the acceleration a_c that the contact force f gives the mass, M alpha_m a_c = f, being part of a:
  /// a -= a_c and v += dt (2 beta - gamma) a_c let the contact force act fully implicitly.
  std::function<void(TS, Vec u, Vec v, Vec a)> correct = {};
  /// Fills a with the acceleration at the start. Without it M a = -F(t, u, v, 0) is solved with
  /// M = (J(shift) - J(0))/shift from the I2Jacobian; rows without mass get a = 0.
  std::function<void(TS, PetscReal t, Vec u, Vec v, Vec a)> initial_acceleration = {};
};

/// All of these need a TS of type newmark (hooks and parameters are lost when the type changes).
void set_newmark_hooks(TS ts, NewmarkHooks hooks);
void set_newmark_parameters(TS ts, const NewmarkParameters& parameters);
NewmarkParameters newmark_parameters(TS ts);

/// The acceleration at the current time; owned by the TS. Before the first step it is null unless it was set.
Vec newmark_acceleration(TS ts);

/// Sets the acceleration at the current time (copied). It is then never computed again. Collective.
void newmark_set_acceleration(TS ts, Vec a);

/// v at the start of the try in progress: v_n, or what the hook `predict` made of it; owned by the TS.
Vec newmark_start_velocity(TS ts);

/// A step as it was taken, M being the mass matrix of all unknowns, held ones too.
struct NewmarkStep {
  PetscReal dt = 0;
  Vec du = nullptr;                            ///< u - u_n
  Vec v_start = nullptr;                       ///< after the hook `predict`
  Vec v = nullptr, a_n = nullptr, a = nullptr; ///< after the hook `correct`
  Vec f = nullptr;  ///< 2 beta a_c, a_c what that hook took out of the acceleration
  Vec df = nullptr; ///< change of f since the last step
  Vec Ma_n = nullptr, Ma = nullptr, Mf = nullptr, Mdf = nullptr; ///< M times a_n, a, f, df
  Vec lag = nullptr;    ///< (alpha_m - 1) M (a_n - a_{n-1}); 0 in the first step
  Vec struck = nullptr; ///< v_start - v_n
  PetscReal grown = 0;  ///< NewmarkEnergy::grown of the last step
};

/// What the scheme itself does to the energy in a step, in closed form from its weights (theory.md, N1 to
/// N3): no force of the problem and no kinetic energy enters.
struct NewmarkEnergy {
  PetscReal loss = 0;  ///< T(v_start) - T(v) + du . (mean inertia + M f)                       (N1)
  PetscReal kept = 0;  ///< what of it v and the accelerations hold and give back, of any sign  (N2)
  PetscReal grown = 0; ///< part of -kept: theta |dt df|^2
  /// Of any sign, because f changed: the damped family's loss less the change of `kept` and this is a square,
  /// in steps of one length.                                                                     (N3)
  PetscReal exchange = 0;
};
/// Collective.
NewmarkEnergy newmark_energy(const NewmarkParameters& parameters, const NewmarkStep& step);
/// `kept` at a start, where no acceleration was before. Collective.
PetscReal newmark_kept_at_start(const NewmarkParameters& parameters, PetscReal dt, Vec a, Vec Ma);

} // namespace impact
