#pragma once
#include <impact/kernel/point_data.hpp>

/// The weak forms on one batch of cells of one shape in one frame, as functions. Who loops over batches holds
/// the kernels of the batch's group and knows nothing of shapes. Where an int is returned it is the bit mask
/// of lanes whose result is not finite or whose state has no meaning (det F <= 0, a temperature that is not
/// positive).
namespace impact {

/// Fields of a batch at the end of a step and (_n) at its start: [node][component] of nodal ones,
/// [point][component] of those of points. Null pointers stand for zero, theta_0 and a virgin history. A
/// kernel reads what its equation asks for.
struct CellFields {
  const Batch* X = nullptr;                             ///< [dim] reference coordinates
  const Batch *u = nullptr, *u_n = nullptr;             ///< [dim] displacement
  const Batch *phi = nullptr, *phi_n = nullptr;         ///< damage
  const Batch *theta = nullptr, *theta_n = nullptr;     ///< temperature
  const Batch *history = nullptr, *history_n = nullptr; ///< [history_size]; null for Model::elastic
  const Batch *drive = nullptr, *drive_n = nullptr;     ///< [drive_size]
  const Batch *fatigue = nullptr, *fatigue_n = nullptr; ///< Fat
  double dt = 1;
};

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
  const Batch* accel = nullptr; ///< [node][dim] acceleration minus body force per mass; nullptr = none
  bool held = false;            ///< the history is that of u: nothing flows
  double unilateral = 1;        ///< factor of the unilateral stress m tau-
  double mass_shift = 0;        ///< tangent += mass_shift rho N_a N_b delta_ik
  bool symmetric = false;       ///< symmetrised tangent: plastic n (x) dev n^2 term, and the F-bar coupling
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

/// What the heat balance takes from the motion, at the points.
struct HeatFeed {
  Batch* dissipation =
      nullptr;             ///< [point] g_p k_d dalpha + b_d |C - C_n|^2/dt, energy per volume of the step
  Batch* stress = nullptr; ///< [point][gradient_size] P = tau F^-T, all parts
};

// Damage balance of one batch of cells, with Y = g_1' E+ + g_2' E- + g_p' D_p + G_c w'(phi)/gamma -
// Fat/gamma and h = a G_c gamma C^-1 Grad phi (or a G_c gamma Grad phi for DamageGradient::material); w, a:
// crack.hpp.
//   multiplied: int w lambda_n (phi - phi_n)/dt + [ w Y + Grad w . h ]_theta
//   divided:    int w (phi - phi_n) + dt [ (w Y + Grad w . h)/lambda_n ]_theta
//                 + dt w G_c gamma Grad(1/lambda_n) . [C^-1]_theta Grad phi_n (111)-(112)
// []_theta weighs t_{n+1} with theta_d and t_n with 1 - theta_d; lambda_n = (1 + delta - phi_n)^zeta / c.
// Both forms have the same root where phi_n is uniform. The history-field variant hands max(H_n, E+) in as
// E_plus of the drive.

enum class DamageForm { multiplied, divided };

/// u is the accepted displacement; u_n and drive_n are read only when theta_d < 1. The history is that at
/// t_n, for the alpha of a ductile degradation, and fatigue is Fat_n.
struct DamageInput : CellFields {
  DamageForm form = DamageForm::multiplied;
  double theta_d = 1;  ///< 1 backward Euler, 1/2 trapezoid (the paper)
  bool convex = false; ///< tangent of a concave degradation bent up to positive curvature
};

// Growth of the fatigue variable of one batch of cells over a step (F1'), after the damage solve:
//   Fat = Fat_n + (a/gamma) (1 - phi) phi |W|,   W = 1/2 [ 1/2 (S_c + S_c,n) + S_d ] : (C - C_n)
// S_c is the elastic stress of the undamaged body with the plastic state and the locking cure of the motion,
// S_d = 2 b_d (C - C_n)/dt. In an elastic body 1/2 (S_c + S_c,n) : (C - C_n)/2 is the change of its energy
// to third order, so that a few steps resolve a cycle; no rotation counts.

/// The temperatures are those that the motion solves saw; Fat_n is read, Fat comes out.
using FatigueInput = CellFields;

/// Sums over the points, per lane; fatigue_advance adds to them.
struct FatigueSums {
  Batch dissipation = 0; ///< int phi (Fat - Fat_n)/gamma
  Batch least = 0;       ///< smallest dissipation per volume at a point, at most 0
};

// Heat balance of one batch of cells over a step, as energies (all rates times dt), with the heat flux
// q = -kappa grad theta and []_h weighing t_{n+1} with theta_h and t_n with 1 - theta_h:
//   entropy: int w ([theta]_h (eta - eta_n) - D) + dt [grad w . kappa grad theta]_h           (45')
//            D = dissipation of the step by plasticity, viscosity and the rate of damage
//              + phi (Fat - Fat_n)/gamma + x (PointLaw::plastic_exchange)
//   energy:  int w (e - e_n - W) + grad w . h (phi - phi_n) + dt [grad w . kappa grad theta]_h (5')
//            e = internal energy, W = 1/2 (P + P_n) : (F - F_n), h = a G_c gamma C^-1 Grad phi
// eta = c_V ln(theta/theta_0) + 3 alpha_t g_v K/2 (J_e^2 - 1) with the J_e of the chosen locking cure. Loads
// are added by the caller. The summed energy form is the discrete first law with the work that the motion
// solves did.

enum class HeatForm { entropy, energy };

/// What heat_step leaves at each point for heat_residual and heat_tangent.
struct HeatPoint {
  Batch volume;    ///< J - 1 of the locking cure
  Batch entropy_n; ///< 3 alpha_t g_v K/2 (J_e^2 - 1) at t_n
};
inline constexpr int heat_point_size = sizeof(HeatPoint) / sizeof(Batch);
inline HeatPoint& heat_point_at(Batch* points, int q) { return reinterpret_cast<HeatPoint*>(points)[q]; }
inline const HeatPoint& heat_point_at(const Batch* points, int q) {
  return reinterpret_cast<const HeatPoint*>(points)[q];
}

/// theta is the iterate. The histories are read of moved laws that flow in the energy form, that exchange or
/// are ductile, and in plane stress; the drives of laws that soften in the energy form, of those that
/// exchange in the entropy form.
struct HeatInput : CellFields {
  const Batch* dissipation = nullptr; ///< [point] of the step per volume; nullptr = none
  const Batch* stress = nullptr;   ///< [point][gradient_size] P of the motion at t_{n+1}; energy form with u
  const Batch* stress_n = nullptr; ///< at t_n
  double theta_h = 1;
  HeatForm form = HeatForm::entropy;
};

// Integrals over a batch of cells that the ledger and the output read; nothing here enters an equation.

/// All of one time. The drive is read where the law softens.
struct EnergyInput : CellFields {
  const Batch* v = nullptr; ///< [node][dim] velocity, or nullptr (= 0)
};

/// Sums over the points, per lane; stored_energy adds to them.
struct EnergySums {
  Batch elastic = 0;             ///< int g_1 E+ + g_2 E-   (with the J of the chosen locking cure)
  Batch plastic = 0;             ///< int g_p H_s,  H_s = (1 - chi) H_0 (with softening: the sum in drive)
  Batch fracture = 0;            ///< int psi_phi
  Batch fatigue = 0;             ///< int Fat H_f(phi)/gamma
  Batch kinetic = 0;             ///< int rho/2 v.v
  Batch mass = 0;                ///< int rho
  Batch momentum[3] = {0, 0, 0}; ///< int rho v
};

/// Sums over the points, per lane; stored_heat adds to them.
struct HeatSums {
  Batch energy = 0;  ///< int c_V (theta - theta_0) + theta s: the thermal part of the internal energy
  Batch entropy = 0; ///< int c_V ln(theta/theta_0) + s,   s = 3 alpha_t g_v K/2 (J_e^2 - 1)
};

/// Averages over the reference volume of each cell.
struct CellOutput {
  Batch stress[6]; ///< Cauchy stress 11 22 33 12 23 13 (all parts of the motion's stress)
  Batch von_mises; ///< of the average stress
  Batch pressure;  ///< -tr sigma / 3 of the average stress
  Batch alpha, phi;
};

struct CellKernels {
  // motion
  /// r [node][dim] += residual.
  CellStatus (*motion_residual)(const PointLaw&, const MotionInput&, Batch* r);
  /// K [node][dim][node][dim] = the exact derivative of the residual (symmetrised where asked); r += residual
  /// unless nullptr.
  CellStatus (*motion_tangent)(const PointLaw&, const MotionInput&, Batch* r, Batch* K);
  /// Evaluates the law at the accepted u: writes trial_history [point][history_size] and drive
  /// [point][drive_size] and adds to the step sums. trial_history may be nullptr for Model::elastic but in
  /// plane stress; it must not alias in.history. What heat asks for is written where it is not nullptr.
  CellStatus (*motion_advance)(const PointLaw&, const MotionInput&, Batch* trial_history, Batch* drive,
                               StepSums&, const HeatFeed&);

  // damage and fatigue
  /// r [node] += residual.
  int (*damage_residual)(const PointLaw&, const DamageInput&, Batch* r);
  /// r [node] += residual and K [node][node] += its derivative: symmetric in both forms, and constant for the
  /// quadratic degradation. With `convex` a curvature g'' E that outweighs that of the crack energy is raised
  /// to where a tenth of both is left, so that K is positive definite (and larger than the derivative, so
  /// that a step is never longer than Newton's).
  int (*damage_tangent)(const PointLaw&, const DamageInput&, Batch* r, Batch* K);
  /// lambda(phi_n) (phi - phi_n)^2 / dt per volume is added to each of `points`. phi, phi_n [node].
  void (*damage_dissipation)(const PointLaw&, const Batch* phi, const Batch* phi_n, double dt, Batch* points);
  /// Writes fatigue [point].
  int (*fatigue_advance)(const PointLaw&, const FatigueInput&, Batch* fatigue, FatigueSums&);

  // heat
  /// What does not depend on the iterate: writes points [point][heat_point_size] and adds to r [node]. To be
  /// called once per solve.
  int (*heat_step)(const PointLaw&, const HeatInput&, Batch* points, Batch* r);
  /// r [node] += what depends on the iterate.
  int (*heat_residual)(const PointLaw&, const HeatInput&, const Batch* points, Batch* r);
  /// r [node] += the same and K [node][node] += its derivative, symmetric.
  int (*heat_tangent)(const PointLaw&, const HeatInput&, const Batch* points, Batch* r, Batch* K);
  /// r [node] += int N_a source dV_0 with source [point] per reference volume; sum (per lane) += int source
  /// dV_0.
  void (*heat_source)(const Batch* X, const Batch* source, Batch* r, Batch& sum);

  // measures
  void (*stored_energy)(const PointLaw&, const EnergyInput&, EnergySums&);
  /// Needs in.theta.
  void (*stored_heat)(const PointLaw&, const EnergyInput&, HeatSums&);
  /// Integral over the reference volume of each cell of what is given at its points. X [node][dim], values
  /// [point].
  Batch (*cell_integral)(const Batch* X, const Batch* values);
  /// What damage and flow of a step exchange with the plastic heat, per volume at each point
  /// (PointLaw::plastic_exchange). For laws that exchange anything.
  void (*plastic_exchange)(const PointLaw&, const CellFields&, Batch* points);
  /// int m (E^- - E^-_n), per lane: what a step stores by the unilateral part of the stress; sum is added to.
  /// X [node][dim]; phi [node]; history [point][history_size] of t_n, read where g knows alpha; drive,
  /// drive_n [point][drive_size] at t_{n+1} and t_n.
  void (*unilateral_energy)(const PointLaw&, const Batch* X, const Batch* phi, const Batch* history_n,
                            const Batch* drive, const Batch* drive_n, Batch& sum);
  /// in.history is the history of the same time as in.u, so that no flow happens here.
  void (*cell_output)(const PointLaw&, const MotionInput& in, CellOutput& out);
  /// M [node][node] += int rho N_a N_b (2 pi R in the axisymmetric frame).
  void (*mass_matrix)(const PointLaw&, const Batch* X, Batch* M);
};

} // namespace impact
