#pragma once
#include <impact/kernel/damage.hpp>
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/settings.hpp>
#include <optional>

/// The damage balance of one step: SNES `damage_`, with the bounds phi_n <= phi <= 1. The
/// unconstrained solution comes first; where it keeps the bounds it is the answer, else the variational
/// inequality starts from its clipped values (SNESVINEWTONRSLS under the same prefix). With AT1 and with
/// degradations that are not convex the inequality starts from the guess, and takes full steps.
namespace impact {

struct DamageStep {
  double t = 0, dt = 0;
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1}, local [node][dim]
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi_n = nullptr; ///< local [node]
};

class DamageProblem {
public:
  /// Rows "drive" (and "damage_history" for DamageBounds::history, added here) of the table are read and
  /// written.
  DamageProblem(const Discretisation& discretisation, StateTable& state, const BoundaryData& boundary,
                const DamageScenario& settings);

  /// Solves for phi at t_{n+1} from the trial half of "drive"; phi (local, ghosts consistent) holds the guess
  /// on entry. Collective.
  ScalarOutcome solve(const DamageStep& step, std::vector<double>& phi);

  /// What the rate of phi dissipated in the last solve, per volume at the points: the sum over sub-steps.
  const std::vector<double>& dissipated() const { return dissipated_; }
  /// Work of the microforces on nodes where phi is prescribed in the last solve, and in a first step of what
  /// holds rate-independent damage that is not in balance at the start; all ranks, per unit thickness.
  double prescribed_work() const { return work_; }
  /// Microforces of the start of a run at displacement u, local [node][dim]. Collective.
  void start(const std::vector<double>& u);

  Mat matrix() const { return assembly_->matrix(); }
  /// The solver of the bounded equation, where there is one, else that of the unbounded one.
  SNES snes() const { return bounded_ ? bounded_ : unconstrained_; }
  /// Drops what its linear solvers keep. Collective.
  void forget_factors();

private:
  void residual(Vec x, Vec f);
  void microforces(const std::vector<double>& phi, double dt, std::vector<double>& force);
  bool assemble_forces(Vec x, Vec f);
  void keep_held(std::vector<double>& force) const;
  double held_work(const std::vector<double>& force, const std::vector<double>& from,
                   const std::vector<double>& to) const;
  void book_rate(const std::vector<double>& from, const std::vector<double>& to, double dt);
  void book_energy(const std::vector<double>& from, const std::vector<double>& to);
  std::vector<SNES> solvers() const;
  void tangent(Vec x);
  template <class Output> bool evaluate(Vec x, bool with_tangent, Output&& output);
  void raise_history();
  void set_tolerances(SNES snes);
  static void take_full_steps(SNES snes);
  bool within_bounds(Vec x) const;
  void make_substeps();
  void start_substep(TS ts);
  void finish_substep(TS ts);
  void substep_residual(TS ts, Vec x, Vec rate, Vec f);
  ScalarOutcome solve_substeps(const DamageStep& step, std::vector<double>& phi);

  const Discretisation& d_;
  StateTable& state_;
  const BoundaryData& boundary_;
  DamageScenario settings_;
  DamageStep step_;
  Mailbox mailbox_;
  std::vector<double> X_, x_, r_;
  std::vector<double> free_; ///< 1 where phi is solved for, 0 where prescribed or without damage
  std::vector<int> owned_held_;
  std::vector<std::size_t> drive_offset_;
  std::vector<std::size_t> flow_offset_;    ///< of the row "history", plastic
  std::vector<std::size_t> history_offset_; ///< of the row "damage_history"
  std::optional<SparseAssembly> assembly_;
  Handle<SNES> unconstrained_, bounded_;
  Handle<TS> substeps_; ///< when -damage_ts_dt asks for sub-steps
  PetscReal substep_ = 0;
  std::vector<double> substep_start_, substep_end_;
  std::vector<double> dissipated_;
  StateRow* microforce_ = nullptr; ///< on nodes with prescribed phi, of the energy alone
  bool prescribes_ = false;        ///< phi of any node
  double work_ = 0;
  Handle<Vec> solution_, residual_, diagonal_, lower_, upper_;
  double residual_tol_ = 0; // absolute, as the options say
  double reference_ = 0;
  bool bounded_at_once_ = false;
};

} // namespace impact
