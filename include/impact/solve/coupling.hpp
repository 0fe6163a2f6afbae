#pragma once
#include <impact/problem/damage.hpp>
#include <impact/problem/failure.hpp>
#include <impact/problem/fatigue.hpp>
#include <impact/problem/heat.hpp>
#include <impact/problem/toughness.hpp>
#include <impact/solve/augmentation.hpp>
#include <impact/solve/explicit_step.hpp>
#include <impact/solve/path_control.hpp>
#include <impact/solve/phi_passes.hpp>
#include <impact/solve/stabilised_update.hpp>
#include <impact/solve/step_limits.hpp>
#include <impact/solve/step_record.hpp>
#include <optional>

/// One step's staggered fixed point, SNES shell `coupling_` of the TS. Its pass solves one field after
/// another with the others frozen, until phi and theta rest (theory.md, 10):
///   motion (Augmentation, MotionSolver; ExplicitStep), failure, damage (SNES `damage_`), fatigue, heat
///   (SNES `heat_`)
namespace impact {

/// The fields that a step couples; damage, heat and erosion may be null. All must outlive who uses them.
struct Fields {
  MotionProblem& motion;
  DamageProblem* damage;
  HeatProblem* heat;
  StateTable& state;
  Erosion* erosion = nullptr; ///< null: no cell leaves
};

// Members beyond twelve and functions beyond twenty: the collaborators of a pass stand here by value, and
// nowhere else; hooks of the TS, reports of a step.
class Coupling {
public:
  /// Hangs itself into `ts` (type set, options not yet read): its SNES; the hooks are the caller's. Without
  /// `settings.moves` the displacement stays as it is. `stabilise_contact` counts with inertia. Collective.
  Coupling(TS ts, const Fields& fields, const CouplingScenario& settings, const SolverDefaults& defaults,
           bool stabilise_contact);
  Coupling(const Coupling&) = delete;
  Coupling& operator=(const Coupling&) = delete;

  /// Sets the motion's step data so that forces can be evaluated at a state between steps (start, restart).
  /// Collective.
  void begin_between_steps(double t, Vec u, Vec v);
  /// After that, at the start of a run: the committed rows that heat and damage take from the motion and,
  /// with inertia, the acceleration into a, whose prescribed dofs come from the row. Collective.
  void start(Vec u, Vec v, Vec a);
  /// The acceleration alone, under the forces `contact`, or null.
  void start_acceleration(Vec u, Vec v, Vec contact, Vec a);

  /// Hooks of the TS. `predict` and `correct` want inertia; `corrects` says whether there is anything to do.
  void before_attempt(const Attempt& attempt);
  void predict(const Attempt& attempt, Vec u_tilde, Vec v);
  void guess(const Attempt& attempt, Vec u);
  bool is_adrift(double t);
  bool corrects() const { return explicit_ ? !explicit_->bodies().empty() : update_.corrects(); }
  void correct(Vec u, Vec v, Vec a);
  void reject() { fields_.state.rollback(); }

  /// The attempt with the load parameters between which its motion begins, or was solved, in the place of its
  /// times: what conditions are evaluated at.
  Attempt first_loads(const Attempt& attempt) const;
  Attempt loads(const Attempt& attempt) const;

  /// What the solved attempt, which ended at u, was made of. Collective.
  StepRecord record(Vec u);
  StepCounts counts() const;
  /// Part of the limits on increments that the attempt used up (StepLimits).
  double utilisation() const { return limits_.utilisation(); }
  /// Why the last attempt failed; empty when it did not. Collective: names the worst cell of all ranks.
  std::string failure_text() const;
  /// How far a crack ran in the attempt at a load that it held fixed; empty when none did. Collective.
  std::string crack_text() const { return phi_passes_.text(pass_.number, fields_.state); }

  /// Steps by central differences, or null.
  ExplicitStep* explicit_step() { return explicit_ ? &*explicit_ : nullptr; }
  bool stabilised() const { return update_.stabilised(); }
  bool unilateral() const { return update_.unilateral(); }
  MotionSolver& motion_solver() { return solver_; }
  /// Contacts find their surfaces where cells have left. Collective.
  void expose_contacts(Vec u);
  /// Drops lagged factors, so that a run behaves after a checkpoint as one that resumed from it. Collective.
  void forget_factors();

private:
  PassResult pass(PetscInt number, Vec u);
  bool motion_pass(Vec u, PassResult& result);
  bool advance_points(Vec u, PassResult& result);
  bool damage_pass(PassResult& result); ///< whether damage was solved and may stay
  void failure_pass(PassResult& result);
  void fatigue_pass(PassResult& result);
  void toughness_pass();
  void heat_pass(Vec u, PassResult& result);
  void compare_temperatures(const StateRow& theta, PassResult& result);
  void let_lost_cells_go(const Attempt& attempt);
  void refuse(PassResult& result, SNESConvergedReason reason, std::string cause);
  bool keeps_to(StepLimits::Refusal refusal, PassResult& result);
  void give_up(PetscInt passes, PetscReal change);
  MotionStep frozen_step() const;

  /// What the passes of an attempt hand to each other. Local arrays with ghosts.
  struct Pass {
    PetscInt number = 0;
    std::vector<double> phi, theta;  ///< that the motion sees
    std::vector<double> warming;     ///< of that theta
    std::vector<double> u;           ///< that it found
    std::vector<double> dissipation; ///< of the motion and of damage, at the points
    MotionProblem::Increments increments;
    const char* changing = "phi"; ///< what the pass changed most
    bool law_failed = false;
  };

  TS ts_;
  Fields fields_;
  CouplingScenario settings_;
  StateRow& last_step_; // how long it was; 0: there was none
  bool let_go_ = true;  // until something holds them, nothing lets go of loose bodies
  MotionSolver solver_;
  Augmentation augmentation_;
  StabilisedUpdate update_;
  std::optional<ExplicitStep> explicit_;
  const StateRow* warming_ = nullptr; // of points whose temperature follows their volume
  StateRow* damage_wait_ = nullptr;   // steps and time since damage was solved
  PhiPasses phi_passes_;
  std::optional<PathControl> path_;
  StepLimits limits_;
  FatigueGrowth fatigue_;
  PassShell shell_;
  StepCounts counts_; // of damage and heat
  Pass pass_;
  std::string failure_;
  std::vector<std::size_t> lost_cells_; // of this rank, which tries of the step found without volume
  std::vector<double> u_before_;        // begin_between_steps
  std::vector<double> velocity_offset_; // MotionStep's
  ForceParts forces_, next_;            // of the record
};

} // namespace impact
