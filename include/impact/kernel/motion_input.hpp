#pragma once
#include <impact/kernel/cell_fields.hpp>

namespace impact {

// Momentum balance of one batch of cells in the total Lagrangian form (105):
//   r_aI = int N_a,J P_iJ + rho N_a N_b a_b dV_0,   P = P_dev + p cof F + F (S_phi + S_d).
// Volumetric locking (law.parameters.locking): `none` takes p from the J of the point, `mean` from the cell
// mean of J (the force of an energy, symmetric), `fbar` from the J of the centroid with P = (J/J_0) P_dev +
// p(J_0) cof F. S_phi, S_d and the inertia use the unmodified F. Cells are lanes; arrays are of Batch,
// 8*IMPACT_LANES-byte aligned. Nothing here allocates, throws or traps: lanes that are marked bad may hold
// NaN.

/// History and drive are the committed ones, phi is the frozen damage of the pass; u_n is read only where b_d
/// > 0 (and in the step sums), drive by laws that soften, in motion_advance. Without a history in plane
/// stress F_33 is looked for from 1, and the viscous stress is wrong.
struct MotionInput : CellFields {
  const Batch* accel = nullptr;   ///< [node][dim] acceleration minus body force per mass; nullptr = none
  const Batch* failure = nullptr; ///< [point] failure measure at t_n, for laws that it weakens
  const Batch* warming = nullptr; ///< [point] Warming; nullptr: the temperature is that of u
  bool held = false;              ///< the history is that of u: nothing flows
  double unilateral = 1;          ///< factor of the unilateral stress m tau-
  double mass_shift = 0;          ///< tangent += mass_shift rho N_a N_b delta_ik
  bool symmetric = false;         ///< symmetrised tangent: plastic n (x) dev n^2 term, and the F-bar coupling
  double bulk_linear = 0, bulk_quadratic = 0; ///< of motion_step; u_n must be there (bulk_viscosity.hpp)

  bool has_bulk_viscosity() const { return bulk_linear > 0 || bulk_quadratic > 0; }
};

struct CellStatus {
  int bad = 0;     ///< bit l set: lane l has J <= 0, a non-positive trace of b, a failed return map or a
                   ///< non-finite result
  Batch min_J = 0; ///< smallest det F over the points of the cell, per lane
};

/// Sums over the points of the cells, per lane; motion_advance adds to them.
struct StepSums {
  Batch plastic_dissipation = 0; ///< int g_p k_d dalpha,  k_d = `dissipative_stress` at t_{n+1}
  Batch viscous_dissipation = 0; ///< int b_d |C - C_n|^2 / dt   (times g_e1 where b_d is degraded)
  Batch plastic_work = 0;        ///< int g_1 [W(b_trial) - W(b)]
  Batch least_dissipation = 0;   ///< smallest of both integrands of dissipation at a point, at most 0
};

/// The highest frequency of a cell that swings alone, with damping by the velocity of the last step: a step
/// of central differences is stable for square dt^2 + 2 damping dt <= 4. `stiffest`: the square as if all of
/// the cell were strained the way that it resists most.
struct CellFrequency {
  Batch square = 0, damping = 0, stiffest = 0;
  Batch longest_step() const { return (sqrt(damping * damping + 4.0 * square) - damping) / square; }
};

/// What the heat balance takes from the motion, at the points.
struct HeatFeed {
  Batch* dissipation =
      nullptr;             ///< [point] g_p k_d dalpha + b_d |C - C_n|^2/dt, energy per volume of the step
  Batch* stress = nullptr; ///< [point][stress_size] P = tau F^-T, all parts, and of them the p of the cure
};

} // namespace impact
