#pragma once
#include <impact/problem/damage.hpp>
#include <impact/problem/fatigue.hpp>
#include <impact/problem/heat.hpp>
#include <impact/problem/loose_bodies.hpp>
#include <impact/problem/motion.hpp>
#include <impact/problem/newton_watch.hpp>
#include <impact/problem/phi_passes.hpp>
#include <impact/problem/solver_defaults.hpp>
#include <impact/problem/tangent_reuse.hpp>
#include <impact/time/newmark.hpp>
#include <impact/time/pass_shell.hpp>
#include <impact/time/step_hooks.hpp>
#include <memory>
#include <optional>
#include <span>

/// One step's staggered fixed point and how it hangs in the TS:
///   TS -> SNES shell `coupling_` -> SNES shell `uzawa_` -> SNES `motion_`;  then SNES `damage_`, fatigue,
///   SNES `heat_`.
/// The residual and tangent reach `motion_` through SNESTSFormFunction, so that the TS supplies v and a.
namespace impact {

/// Work of one attempt, summed over its passes.
struct StepCounts {
  PetscInt newton = 0, linear = 0, uzawa = 0, damage = 0, damage_linear = 0, heat = 0, heat_linear = 0,
           passes = 0;
  PetscInt longest = 0; ///< Newton iterations of the longest motion solve of the step, refused tries included
};

class Coupling {
public:
  /// Hangs itself into `ts` (type set, not yet set up): I2Function, I2Jacobian, SNES, hooks except on_accept.
  /// `damage` and `heat` may be null. Without `settings.moves` the displacement stays as it is. All
  /// references must outlive the TS. Collective.
  Coupling(TS ts, MotionProblem& motion, DamageProblem* damage, HeatProblem* heat, StateTable& state,
           const CouplingScenario& settings, const SolverDefaults& defaults, bool inertia,
           bool stabilise_contact);

  const StepCounts& counts() const { return counts_; }
  /// Tangents of the hardest motion solve of the attempt (its iterations, with full Newton): what the step
  /// control calls its effort.
  PetscInt hardest_solve() const { return hardest_solve_; }
  /// Motion solves of this run that were tried once more, with backtracking.
  long second_ways() const { return second_ways_; }
  /// Largest increment of phi, of the plastic strain or of the temperature in the attempt over its limit
  /// (-ts_adapt_dphi, _dalpha, _dtheta); 0 without limits.
  PetscReal utilisation() const { return utilisation_; }
  /// Drops lagged factors, so that a run behaves after a checkpoint as one that resumed from it. Collective.
  void forget_factors();
  const MotionProblem::Increments& increments() const { return increments_; }
  /// Heat that each condition supplied in the attempt, per unit thickness; empty without heat.
  std::span<const double> heat_supplied() const;
  /// What passed the contacts that pass heat in the attempt, in their order.
  std::span<const ContactHeat::Heat> contact_heat() const {
    return heat_ ? std::span<const ContactHeat::Heat>(heat_->contact_heat())
                 : std::span<const ContactHeat::Heat>();
  }
  /// Of the attempt, per volume at the points (like row "damage_history"): dissipation by plasticity,
  /// viscosity and the rate of damage, and the part of the last; empty where neither heat nor an exchange
  /// of damage and flow asks for the first, without damage.
  const std::vector<double>& dissipation() const { return dissipation_; }
  std::span<const double> damage_dissipation() const {
    return damage_ ? std::span<const double>(damage_->dissipated()) : std::span<const double>();
  }
  /// Work of the microforces that prescribe phi in the attempt, per unit thickness; 0 where the energy form
  /// of the heat balance takes it from the heat.
  double prescribed_damage_work() const;
  /// Growth of fatigue in the attempt; null without.
  const FatigueUpdate* fatigue() const { return fatigue_ ? &*fatigue_ : nullptr; }
  /// Parts of the motion's residual at u with the phi and theta of the end of the attempt in place of those
  /// that its last solve saw: what another pass would have to balance. Costs one evaluation of the residual.
  /// Collective.
  void parts_of_next_pass(Vec u, ForceParts& parts);
  double entropy_supplied() const { return heat_ ? heat_->entropy_supplied() : 0; }
  /// Why the last attempt failed; empty when it did not. Collective: names the worst cell of all ranks.
  std::string failure_text() const;
  /// How far a crack ran in the attempt at a load that it held fixed; empty when none did. Collective.
  std::string crack_text() const;
  SNES motion_snes() const { return motion_snes_; }
  TS integrator() const { return ts_; }

  void before_attempt(const Attempt& attempt);
  void guess(const Attempt& attempt, Vec u);
  void on_reject();
  /// Consistent acceleration of the free dofs at a start, without contact; prescribed dofs keep row "a".
  /// Collective.
  void initial_acceleration(double t, Vec u, Vec v, Vec a);
  /// Hands the motion's present matrix to the solver; needed when the candidates changed outside a step.
  void refresh_matrix();
  /// Sets the motion's step data so that forces can be evaluated at a state between steps (start, restart).
  /// Collective.
  void begin_at_rest_of_step(double t, Vec u, Vec v);

  /// Fills the committed rows that the heat balance takes from the motion, at the start of a run, after
  /// begin_at_rest_of_step. Collective.
  void start_heat(Vec u);
  /// Microforces of the damage at the start of a run, after begin_at_rest_of_step. Collective.
  void start_damage(Vec u);

  /// Contact-stabilised Newmark: projection of the velocity and removal of the contact acceleration.
  NewmarkHooks newmark_hooks();
  double contact_scale() const { return contact_scale_; }
  /// Contact force on the bodies that the last converged motion solve balanced.
  Vec contact_force() const { return contact_force_; }
  /// What the last converged motion solve left of the balance of momentum; zero on held dofs.
  Vec left() const { return left_; }
  /// Impulse over dt that the projection of the last step's velocity put on the bodies; zero elsewhere.
  Vec contact_shock() const { return contact_shock_; }
  /// What was taken out of the integrator's acceleration in the last step: of deformable bodies the shares of
  /// the contact-stabilised update and of the unilateral stress, of rigid ones that of the constraint.
  Vec contact_acceleration() const { return contact_acceleration_; }
  bool stabilised() const { return stabilise_; }
  /// Whether the unilateral stress of broken points acts over the step as a whole, as stabilised contact
  /// does.
  bool unilateral() const { return unilateral_; }
  /// Forces at the end of the last step, `unilateral` among them; where it acts apart.
  const ForceParts& forces() const { return forces_; }
  /// The damage that the last motion solve saw; empty without.
  const std::vector<double>& frozen_phi() const { return phi_frozen_; }

private:
  PassResult coupling_pass(PetscInt pass, Vec u);
  PassResult uzawa_pass(PetscInt pass, Vec u);
  void damage_pass(PassResult& result);
  void fatigue_pass(PassResult& result);
  void limit_plastic_strain(PassResult& result);
  void limit_closing(PassResult& result, Vec u);
  // Limits of a step do not cut it any more.
  bool at_least_step() const { return step_.dt <= 1e-3 * settings_.dt; }
  void limit(PassResult& result, const char* what, double increment, const char* option, double most);
  void heat_pass(Vec u, PassResult& result);
  void report_crack();
  std::string crack_length(const std::vector<double>& phi) const;
  SNESConvergedReason solve_motion(Vec u);
  SNESConvergedReason run_motion(Vec u);
  SNESConvergedReason go_second_way(Vec u, PetscInt most_iterations);
  void approach(Vec u);
  bool has_second_way() const;
  std::string line_search() const;
  void begin_newton(Vec u, PassResult& result);
  bool take_first_step(Vec u, Vec ahead, double part);
  void add_gaps(Vec u, Vec f);
  bool gives_up(PetscReal norm);
  bool gaps_settle(Vec u);
  bool balanced(Vec u);
  bool refresh_contact(Vec u);
  void read_contact_scale();
  void project_predictor(double t_n, double dt, Vec u_tilde, Vec v);
  KSP projection_solver();
  bool semismooth() const { return motion_.contacts().demands().closes_gaps; }
  bool augments() const { return motion_.contacts().demands().augments; }
  bool frictional() const { return motion_.contacts().demands().frictional; }
  bool reverses() const { return motion_.contacts().demands().reverses; }
  bool closes_gaps() const { return semismooth() || reverses(); }
  void update_multipliers_in(SNES snes);
  void take_out_step_forces(Vec u, Vec v, Vec a);
  void take_out_rigidity(Vec u, Vec v, Vec a);

  TS ts_;
  MotionProblem& motion_;
  DamageProblem* damage_;
  HeatProblem* heat_;
  StateTable& state_;
  std::optional<FatigueUpdate> fatigue_;
  CouplingScenario settings_;
  PhiPasses phi_passes_;
  bool inertia_, stabilise_, unilateral_;
  double contact_scale_ = 1, unilateral_scale_ = 1;
  double residual_rtol_ = 0; // as the options say
  MotionStep step_;
  std::vector<double> phi_frozen_, theta_frozen_, u_local_, u_before_;
  std::vector<double> dissipation_;
  PetscReal utilisation_ = 0;
  bool first_touch_ = false; // bodies that pressed nothing are being brought together
  bool rough_ = false;       // the next pass of augmentations is solved to a rough tolerance
  double open_ = 0;          // largest gap that the last iterate near the solution left, over a facet
  TangentReuse reuse_{0};
  PassShell coupling_shell_, uzawa_shell_;
  Handle<SNES> uzawa_snes_, motion_snes_;
  Handle<KSP> projection_ksp_; // where the motion's own solver needs a definite matrix
  bool projection_failed_ = false;
  Vec iterate_ = nullptr;     // of the Newton solve at work, about which linear solves close gaps
  Handle<Vec> bare_residual_; // what the right-hand side was before they were added
  Handle<Vec> residual_, left_, newton_start_, contact_force_, contact_shock_, contact_acceleration_;
  ForceParts forces_;
  bool first_done_ = false; // the solve to come goes on from a first iteration
  StepCounts counts_;
  PetscInt hardest_solve_ = 0, tangents_ = 0, iterations_ = 0; // iterations_: of one solve
  NewtonWatch watch_;
  bool first_way_ = false; // of solve_motion is at work
  bool watched_ = false;   // and may be given up for the second
  bool second_way_first_ = false;
  long second_ways_ = 0;
  int near_ = 0; // iterates whose residual was beside its tolerance
  MotionProblem::Increments increments_;
  LooseBodies loose_; // empty with inertia
  std::string failure_;
  const char* changing_ = "phi"; // what a pass changed most
  double said_ = 0;              // wall time of the last word about a crack that runs
  bool cell_broke_ = false;
};

} // namespace impact
