#pragma once
#include <impact/kernel/damage_input.hpp>
#include <impact/kernel/heat_input.hpp>
#include <impact/kernel/measure_input.hpp>
#include <impact/kernel/motion_input.hpp>

/// The weak forms on one batch of cells of one shape in one frame, as functions. Who loops over batches holds
/// the kernels of the batch's group and knows nothing of shapes. Where an int is returned it is the bit mask
/// of lanes whose result is not finite or whose state has no meaning (det F <= 0, a temperature that is not
/// positive).
namespace impact {

struct CellKernels {
  // motion
  /// r [node][dim] += residual.
  CellStatus (*motion_residual)(const PointLaw&, const MotionInput&, Batch* r);
  /// K [node][dim][node][dim] = the exact derivative of the residual (symmetrised where asked); r += residual
  /// unless nullptr.
  CellStatus (*motion_tangent)(const PointLaw&, const MotionInput&, Batch* r, Batch* K);
  /// Evaluates the law at the accepted u: writes trial_history [point][history_size] and drive
  /// [point][drive_size], where not nullptr, and adds to the step sums. trial_history may be nullptr for
  /// Model::elastic but in plane stress; it must not alias in.history. What heat asks for is written where it
  /// is not nullptr.
  CellStatus (*motion_advance)(const PointLaw&, const MotionInput&, Batch* trial_history, Batch* drive,
                               StepSums&, const HeatFeed&);
  /// The same, and r [node][dim] += the internal force, bulk viscosity among it: the one pass over the cells
  /// of an explicit step.
  CellStatus (*motion_step)(const PointLaw&, const MotionInput&, Batch* trial_history, Batch* drive,
                            StepSums&, const HeatFeed&, Batch* r);
  /// How fast each cell swings alone; nodal_mass [node] = its mass there, unless nullptr.
  CellFrequency (*highest_frequency)(const PointLaw&, const MotionInput&, Batch* nodal_mass);

  // patches of linear triangles and tetrahedra, which share one volume ratio
  /// Reference volume of each cell, and what it has grown by: int (J - 1) dV_0.
  void (*cell_volume)(const Batch* X, const Batch* u, Batch& volume, Batch& growth);
  /// v [node][dim] = int dJ/du dV_0.
  void (*volume_slope)(const Batch* X, const Batch* u, Batch* v);
  /// int p dV_0 and int dp/dJ dV_0, with g, at the volume ratio in.patch.
  void (*cell_pressure)(const PointLaw&, const MotionInput& in, Batch& p, Batch& dp);

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

  // failure
  /// Writes failure [point] at the end of a step from failure_n: in.history is that of the end already,
  /// history_n that of the start. For laws that flow.
  int (*failure_advance)(const PointLaw&, const MotionInput& in, const Batch* history_n,
                         const Batch* failure_n, Batch* failure);

  // heat
  /// What does not depend on the iterate: writes points [point][heat_point_size] and adds to r [node]. To be
  /// called once per solve.
  int (*heat_step)(const PointLaw&, const HeatInput&, Batch* points, Batch* r);
  /// r [node] += what depends on the iterate; the excess at the points.
  int (*heat_residual)(const PointLaw&, const HeatInput&, Batch* points, Batch* r);
  /// r [node] += the same and K [node][node] += its derivative, symmetric.
  int (*heat_tangent)(const PointLaw&, const HeatInput&, const Batch* points, Batch* r, Batch* K);
  /// r [node] += int N_a source dV_0 with source [point] per reference volume; sum (per lane) += int source
  /// dV_0.
  void (*heat_source)(const Batch* X, const Batch* source, Batch* r, Batch& sum);
  /// Work of the pressure p of in.stress on the volumes of cells of a patch, in the energy form.
  Batch (*pressure_work)(const HeatInput& in);

  // measures
  void (*stored_energy)(const PointLaw&, const EnergyInput&, EnergySums&);
  /// Needs in.theta.
  void (*stored_heat)(const PointLaw&, const EnergyInput&, HeatSums&);
  /// Integral over the reference volume of each cell of what is given at its points. X [node][dim], values
  /// [point].
  Batch (*cell_integral)(const Batch* X, const Batch* values);
  /// int rho a . (Grad u moved) dV, per lane (J1); u, a and moved [node][dim].
  Batch (*inertial_release)(const PointLaw&, const Batch* X, const Batch* u, const Batch* a,
                            const Batch* moved);
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
  /// Of in.X and in.u; needs the history in plane stress.
  void (*cell_distortion)(const PointLaw&, const MotionInput& in, CellDistortion& out);
  /// M [node][node] += int rho N_a N_b (2 pi R in the axisymmetric frame).
  void (*mass_matrix)(const PointLaw&, const Batch* X, Batch* M);
};

} // namespace impact
