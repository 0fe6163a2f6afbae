#pragma once
#include <impact/contact/contact_heat.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/heat_loads.hpp>
#include <impact/problem/motion.hpp>
#include <impact/problem/scalar_field.hpp>
#include <impact/problem/settings.hpp>
#include <string>

/// The heat balance of one step: SNES `heat_` for the temperature at t_{n+1} with displacement and damage
/// frozen (45'), (5'). Everything is an energy per step.
namespace impact {

struct HeatStep {
  const std::vector<double>* u = nullptr; ///< accepted displacement at t_{n+1}, local; null without motion
  const std::vector<double>* u_n = nullptr;
  const std::vector<double>* phi = nullptr; ///< local [node]; null without damage
  const std::vector<double>* phi_n = nullptr;
  /// [point of row "drive"] of the step by plasticity, viscosity and the rate of damage, per volume; or null
  const std::vector<double>* dissipation = nullptr;
  Vec displacement = nullptr;    ///< u as the contacts read it
  bool points_keep_heat = false; ///< that the nodal temperature does not show (45b)
};

// Members beyond twelve: the frozen data of a window, and what is booked of it.
class HeatProblem {
public:
  /// Reads the row "theta" and the trial half of "history" of the table. With HeatForm::energy and motion
  /// adds the row "stress", P of the motion solves at the points. `contacts`: null, or those that heat may
  /// pass; without motion their pairs have been found.
  HeatProblem(const Discretisation& discretisation, StateTable& state, const BoundaryData& boundary,
              const HeatScenario& settings, bool moves, const ContactSet* contacts = nullptr);

  SNES snes() const { return snes_; }

  /// Evaluates sources, fluxes and convection at both ends of the step. Collective. Throws UserError(data).
  void begin(double t_n, double t);

  /// Solves for the temperature at t_{n+1}; theta (local, ghosts consistent) holds the guess on entry. With
  /// -heat_ts_dt in equal sub-steps of that length at most, over which motion and damage go on evenly.
  /// Collective.
  ScalarOutcome solve(const HeatStep& step, std::vector<double>& theta);

  /// Whether it balances the energy with the work of microforces, of prescribed ones too.
  bool takes_work_of_damage() const { return settings_.form == HeatForm::energy; }
  /// Where MotionProblem::advance leaves what this balance takes from it.
  HeatRows rows();

  /// What came in during the solved step: all ranks, per unit thickness.
  struct Supply {
    std::vector<double> by_condition;          ///< through prescribed temperatures too
    std::vector<ContactHeat::Heat> by_contact; ///< that passes heat, in their order
    double entropy = 0;                        ///< the same heat node by node over the temperature at t_{n+1}
  };
  const Supply& supplied() const { return supplied_; }
  /// Ids of the contacts that pass heat.
  std::vector<std::string> contacts() const;
  /// Drops lagged factors. Collective.
  void forget_factors();

  Mailbox& mailbox() { return mailbox_; }

private:
  /// Part of the step that is being solved, 0 to 1: all of it without sub-steps.
  struct Window {
    double begin = 0, end = 1;
    bool whole() const { return begin == 0 && end == 1; }
  };

  static std::vector<char> held_nodes(const BoundaryData& boundary);
  const std::vector<double>& theta_at_start() const; ///< of the window
  ScalarOutcome solve_window(std::vector<double>& theta);
  void refuse_below_zero(ScalarOutcome& outcome);
  ScalarOutcome solve_substeps(int count, std::vector<double>& theta);
  void make_matrix();
  void begin_contacts();
  bool assemble_residual(const std::vector<double>& theta, Vec solution, Vec f);
  /// What kernels read: of both ends of the window and of the way between them, or what is left of that once
  /// the constant part is made.
  enum class Reads { window, end };
  template <class Body> bool visit_batches(const std::vector<double>& theta, Reads reads, Body&& body);
  bool make_constant_part();
  void share_volume(double part, PatchState& patches) const;
  void share_work();
  void residual(SNES, Vec x, Vec f);
  void tangent(SNES, Vec x, Mat, Mat);
  void book();
  void keep_warming();

  const Discretisation& d_;
  const BoundaryData& boundary_;
  HeatScenario settings_;
  HeatLoads loads_;
  ScalarField field_;
  HeatStep step_;
  Window window_;
  double t_n_ = 0, t_ = 0; ///< of the window
  Mailbox mailbox_;
  StateRow &theta_, &history_;
  const StateRow* drive_; // null where nothing reads it
  // rows "fatigue"; "stress", of the energy form with motion; "warming", of bodies that expand
  StateRow *worn_ = nullptr, *stress_ = nullptr, *warming_ = nullptr;
  std::vector<double> theta_before_, x_, r_, constant_;
  std::vector<double> points_;      ///< like rows of the table
  std::vector<double> step_stress_; // HeatRows
  Supply supplied_;
  std::vector<double> load_,
      load_supplied_;              ///< nodal heat by what the temperature does not change, and its sums
  PatchState patches_, patches_n_; ///< at the ends of the window
  std::vector<double> patch_work_; ///< of their pressures, a row like theirs
  double residual_tol_ = 0;        ///< absolute, as the options say
  bool flows_, holds_ = false;     // whether anything flows; holds temperatures
  std::vector<ContactHeat> contacts_;
  Handle<SNES> snes_;
  Handle<Vec> held_nodes_;
};

} // namespace impact
