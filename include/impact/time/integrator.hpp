#pragma once
#include <petscvec.h>
#include <vector>

/// One-step schemes for F(t, u, v, a) = 0 with all forces at t_{n+1}, each the value of four weights: find u
/// with
///   F(t_{n+1}, u, v, alpha_m a + (1 - alpha_m) a_n) = 0,
///   u = u_tilde + dt^2 (beta a + (s/2 - beta) a_n),   u_tilde = u_n + dt v_n                  (98)
///   v = v_n + dt (gamma a + (1 - gamma) a_n)                                                  (97)
/// s = 1 is Newmark's method and, with other alpha_m, its damped family (W. L. Wood, M. Bossak, O. C.
/// Zienkiewicz, Int. J. Numer. Meth. Engng 15 (1980) 1562); alpha_m = beta = gamma = 1 and s = 2 are backward
/// Euler; beta = 0, gamma = 1/2 are central differences: u is known before a, which the forces at u give.
/// Without inertia v = (u - u_n)/dt, and no acceleration enters.
namespace impact {

struct IntegratorStep;
struct IntegratorEnergy;

struct Integrator {
  PetscReal beta = 0.25, gamma = 0.5;
  PetscReal alpha_m = 1; ///< part of the inertia that is taken at t_{n+1}
  PetscReal s = 1;       ///< twice the sum of the weights of a and a_n in u: 1 for second order
  bool inertia = true;

  /// (97-98) solved for the rates: a = chi1 (u - u_tilde) - chi3 a_n, v = v_n + chi4 (u - u_tilde) + chi6
  /// a_n.
  struct Coefficients {
    PetscReal chi1, chi3, chi4, chi6; // (99-104)
  };
  Coefficients coefficients(PetscReal dt) const;

  /// (97) as v = slope u + offset: returns the slope, and the offset to these arrays of t_n, all alike. Not
  /// of central differences.
  struct StartOfStep {
    const std::vector<double>&u, &v, &a;
  };
  PetscReal velocity(PetscReal dt, const StartOfStep& start, std::vector<double>& offset) const;

  /// Whether u is found before the forces are.
  bool is_explicit() const { return inertia && beta == 0; }
  /// Factor of the mass in the tangent, 1/s^2; 0 where none is made.
  PetscReal mass_shift(PetscReal dt) const {
    return inertia && !is_explicit() ? alpha_m / (beta * dt * dt) : 0;
  }
  /// Whether du = dt (v_start + v)/2 whatever the accelerations are.
  bool moves_by_mean_velocity() const { return inertia && s == 1 && 2 * beta == gamma; }
  /// Part of a force in the balance that moves the bodies as much as the force acting over the whole step.
  PetscReal share() const { return inertia && !is_explicit() ? alpha_m / (2 * beta) : 1; }
  /// Largest omega dt of an undamped linear oscillator whose amplitude does not grow; infinite for most.
  PetscReal stability_limit() const;

  /// What the scheme itself does to the energy in a step. Collective.
  IntegratorEnergy energy(const IntegratorStep& step) const;
  /// IntegratorEnergy::kept at a start, where no acceleration was before. Collective.
  PetscReal kept_at_start(PetscReal dt, Vec a, Vec Ma) const;
};

/// The member of Newmark's family with spectral radius rho in [0, 1] at infinite frequency, of second order:
/// alpha_m = 2/(1 + rho), gamma = alpha_m - 1/2, beta = alpha_m^2/4. rho = 1 is the trapezoidal rule.
Integrator newmark_with_radius(PetscReal rho);

/// Central differences in the form of one step (L. Verlet, Phys. Rev. 159 (1967) 98): second order, stable up
/// to omega dt = 2, and the energy T + V - dt^2/8 a . M a of a linear oscillator is constant.
Integrator central_differences();

/// A step as it was taken, M being the mass matrix of all unknowns, held ones too.
struct IntegratorStep {
  PetscReal dt = 0;
  Vec du = nullptr;                                    ///< u - u_n
  Vec v_start = nullptr;                               ///< after the hook `predict`
  Vec v = nullptr, a_n = nullptr, a = nullptr;         ///< after the hook `correct`
  Vec change = nullptr;                                ///< a_n - a_{n-1}; 0 in the first step
  Vec Ma_n = nullptr, Ma = nullptr, Mchange = nullptr; ///< M times a_n, a, change
  Vec lag = nullptr;                                   ///< (alpha_m - 1) M change
  PetscReal kept = 0;                                  ///< IntegratorEnergy::kept of the last step
};

/// Closed forms from the weights (theory.md, N1 to N3): no force of the problem and no kinetic energy enters.
struct IntegratorEnergy {
  /// T(v_start) - T(v) + du . (mean inertia and, where du = dt (v_start + v)/2, what acts beside it) (N1)
  PetscReal loss = 0;
  PetscReal kept = 0; ///< what of it v and the accelerations hold and give back, of any sign        (N2)
  /// What `kept` was less what it is with v_start, this step's length and M: the damped family's loss less
  /// the change of `kept` and this is a square. Only schemes with s = 1 keep and exchange.               (N3)
  PetscReal exchange = 0;
};

} // namespace impact
