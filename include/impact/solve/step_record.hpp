#pragma once
#include <impact/problem/heat.hpp>
#include <impact/solve/body_work.hpp>
#include <impact/time/integrator.hpp>
#include <petscvec.h>
#include <span>
#include <vector>

/// What the solution of a step was made of, beside u, v and a: all that balances, columns and messages ask of
/// the solvers.
namespace impact {

/// Work of one attempt, summed over its passes.
struct StepCounts {
  PetscInt newton = 0, linear = 0, uzawa = 0, damage = 0, damage_linear = 0, heat = 0, heat_linear = 0,
           passes = 0;
  PetscInt longest = 0; ///< Newton iterations of the longest motion solve of the step, refused tries included
  /// Tangents of the hardest motion solve of the attempt (its iterations, with full Newton).
  PetscInt hardest = 0;
};

/// A view: vectors and spans are the solvers' own and hold until the next attempt begins. Integrals are those
/// of all ranks, of plane problems per unit thickness. Arrays at points are like the row "damage_history".
struct StepRecord {
  double dt = 0;
  bool first = false; ///< of the run
  Integrator integrator;
  Vec start_velocity = nullptr; ///< v_n, or what the projection made of it; with inertia
  StepCounts counts;

  /// Forces at the end of the step; `unilateral` apart where it acts over the step as a whole.
  const ForceParts* forces = nullptr;
  Vec contact_force = nullptr;  ///< on the bodies, that the last converged motion solve found
  Vec contact_at_end = nullptr; ///< what of it acts as other forces do (ForceShare)
  Vec left = nullptr;           ///< what that solve left of the balance; zero on held dofs
  Vec closing_at_end = nullptr; ///< of the unilateral stress; null where that does not act apart
  Vec over_step = nullptr;      ///< of both, acts over the step as a whole beside the mean of both ends
  Vec hidden = nullptr;         ///< and what reactions at its end do not show (StabilisedUpdate)
  Vec contact_shock = nullptr;  ///< impulse over dt by the projection of the velocity; zero elsewhere
  /// What was taken out of the integrator's acceleration: of deformable bodies the shares of the
  /// contact-stabilised update and of the unilateral stress, of rigid ones that of the constraint.
  Vec contact_acceleration = nullptr;
  Vec told_velocity = nullptr; ///< put into the velocity by the data of rigid bodies, after the step's forces
  bool stabilised = false;     ///< the contact-stabilised update is at work
  bool unilateral = false;     ///< the unilateral stress of broken points acts over the step as a whole

  BodyWork bodies; ///< of rigid bodies in a step by central differences

  const MotionProblem::Increments* increments = nullptr;
  std::span<const double> phi; ///< [node] that the last motion solve saw; empty without damage
  /// At the points, per volume: by plasticity, viscosity and the rate of damage; empty where neither heat nor
  /// an exchange of damage and flow asks for it. By the rate of damage alone; empty without damage.
  std::span<const double> dissipation, damage_dissipation;
  /// Work of the microforces that prescribe phi; 0 where the energy form of the heat balance takes it from
  /// the heat.
  double prescribed_damage_work = 0;
  std::span<const double> fatigue_dissipation; ///< by the growth of fatigue, of each material; empty without
  double least_fatigue = 0;                    ///< smallest of it per volume at a point, at most 0

  const HeatProblem::Supply* heat = nullptr; ///< null without heat

  /// With -coupling_error: internal forces with the phi and theta of the end in place of those that the last
  /// motion solve saw, which is what another pass would have to balance. Else null.
  Vec internal_of_next_pass = nullptr;
};

} // namespace impact
