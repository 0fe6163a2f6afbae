#pragma once
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/scalar_field.hpp>
#include <impact/problem/settings.hpp>
#include <memory>

/// The damage balance of one step: SNES `damage_`, with the bounds phi_n <= phi <= 1 of type vinewtonqp
/// (bounded_newton.hpp).
namespace impact {

struct NodalRate;

struct DamageStep {
  double t = 0, dt = 0;
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1}, local [node][dim]
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi_n = nullptr; ///< local [node]
  double drive_factor = 1;                    ///< of the energies that drive phi: those of another load
};

// Members beyond twelve: solvers of two kinds, bounds and bookings of one step.
class DamageProblem {
public:
  /// Rows "drive" (and "damage_history" for DamageBounds::history, added here) of the table are read and
  /// written.
  DamageProblem(const Discretisation& discretisation, StateTable& state, const BoundaryData& boundary,
                const DamageScenario& settings);
  ~DamageProblem();

  /// Solves for phi at t_{n+1} from the trial half of "drive"; phi (local, ghosts consistent) holds the guess
  /// on entry. Collective.
  ScalarOutcome solve(const DamageStep& step, std::vector<double>& phi);
  /// A step in which phi stays as it is.
  void rest();

  /// What the rate of phi dissipated in the last solve, per volume at the points: the sum over sub-steps.
  const std::vector<double>& dissipated() const { return dissipated_; }
  /// Work of the microforces on nodes where phi is prescribed in the last solve, and in a first step of what
  /// holds rate-independent damage that is not in balance at the start; all ranks, per unit thickness.
  double prescribed_work() const { return work_; }
  /// Microforces of the start of a run at displacement u, local [node][dim]. Collective.
  void start(const std::vector<double>& u);

  /// int psi_phi at the displacement of a step, of all ranks, for the whole thickness. Collective.
  double crack_energy(const DamageStep& step, const std::vector<double>& phi) const;

  /// Of the energy that the forces gave to the growth of phi since the run began or resumed, the part that
  /// explicit sub-steps hold back; negative: there are none. Collective.
  double held_back() const;

  SNES snes() const { return snes_; }
  /// Drops what its linear solvers keep. Collective.
  void forget_factors();

  Mailbox& mailbox() { return mailbox_; }

private:
  void residual(SNES, Vec x, Vec f);
  void tangent(SNES, Vec x, Mat, Mat);
  void make_solver();
  void prepare(SNES snes);
  /// What the kernels are given beside the fields.
  struct Equation {
    DamageForm form;
    double theta, dt;
    const std::vector<double>* phi_n; ///< local [node]
  };
  template <class Body> bool visit_batches(const Equation& equation, Vec x, Body&& body);
  bool assemble_forces(const Equation& equation, Vec x, Vec f);
  void microforces(const std::vector<double>& phi, const std::vector<double>& phi_n, double dt,
                   std::vector<double>& force);
  void keep_held(std::vector<double>& force) const;
  double held_work(const std::vector<double>& force, const std::vector<double>& from,
                   const std::vector<double>& to) const;
  void book_rate(const std::vector<double>& from, const std::vector<double>& to, double dt);
  void book_energy(const std::vector<double>& from, const std::vector<double>& to);
  Batch toughness(const CellBatch& batch) const;
  std::vector<SNES> solvers() const;
  void raise_history();
  static void take_full_steps(SNES snes);
  static void suit_linear_solver(SNES snes);
  void set_bounds(const std::vector<double>& phi_n, const std::vector<double>& phi);
  void clip();
  void make_substeps();
  void set_implicit(TS ts);
  void set_explicit(TS ts);
  template <void (DamageProblem::*method)(TS)> static PetscErrorCode call(TS ts);
  void start_substep(TS ts);
  void finish_substep(TS ts);
  void substep_residual(TS ts, PetscReal, Vec x, Vec, Vec f);
  void substep_tangent(TS, PetscReal, Vec x, Vec, PetscReal shift, Mat, Mat);
  ScalarOutcome solve_substeps(const DamageStep& step, std::vector<double>& phi);
  void find_volumes();
  void find_driving_force(const std::vector<double>& phi, bool with_stiffness);
  void find_capacity(const std::vector<double>& phi);
  void weigh_nodes(double dt);
  double substep_that_fits(double dt, PetscInt most, const std::vector<double>& phi);
  void substep_rate(TS, PetscReal, Vec x, Vec rate);
  void book_substep(double dt);

  const Discretisation& d_;
  const BoundaryData& boundary_;
  DamageScenario settings_;
  ScalarField field_;
  DamageStep step_;
  Equation equation_; ///< of the step or sub-step that is being solved
  Mailbox mailbox_;
  StateRow &phi_, &drive_, &flow_;
  StateRow* worn_ = nullptr;       ///< row "fatigue"
  StateRow* toughness_ = nullptr;  ///< row of that name
  StateRow* history_ = nullptr;    ///< with DamageBounds::history
  StateRow* microforce_ = nullptr; ///< on nodes with prescribed phi, of the energy alone
  std::vector<double> x_, r_;
  Handle<SNES> snes_;
  Handle<TS> substeps_; ///< when -damage_ts_dt asks for sub-steps
  PetscReal substep_ = 0;
  std::unique_ptr<NodalRate> rate_; ///< when -damage_substeps asks for explicit ones
  std::vector<double> substep_start_, substep_end_;
  std::vector<double> dissipated_;
  bool prescribes_ = false; ///< phi of any node
  double work_ = 0;
  Handle<Vec> lower_, upper_;
  double residual_tol_ = 0; // absolute, as the options say
  double reference_ = 0;
  double width_ = 0; // largest gamma
  bool bounded_at_once_ = false;
};

} // namespace impact
