#pragma once
#include <impact/io/history_file.hpp>
#include <impact/solve/step_record.hpp>
#include <string>
#include <vector>

/// The balance sheet of a run: energies, dissipation and work since t = 0, per material and total, and two
/// checks.
///   balance            change of the kinetic energy, integrator's own loss by its weights
///   (Integrator::energy) and work of the forces that
///                      the motion solves really balanced: they add up to zero.
///   balance_first_law  stored energy + dissipation - external work - start: first order in dt (staggering).
///   With heat: stored energy with the thermal one + what no equation of heat takes up (the integrator's
///   loss) - external work - heat supplied - start; rounding with HeatForm::energy.
/// Both relative to the largest energy or work so far. Plane problems: times the thickness.
namespace impact {

struct MaterialEnergies {
  double kinetic = 0, elastic = 0, plastic = 0, fracture = 0, fatigue = 0, thermal = 0, entropy = 0;
  double momentum[3] = {0, 0, 0};
};

/// What is kept beside the columns that every run has.
struct LedgerChoice {
  bool materials = false;      ///< energies and dissipations of each material as columns
  bool coupling_error = false; ///< how far the last pass was from the next one
  bool unilateral = false;     ///< of the steps (StepRecord)
};

class Ledger {
public:
  /// Adds its rows (forces at t_n, totals) to the table. References must outlive the ledger.
  Ledger(MotionProblem& motion, StateTable& state, bool inertia, bool moves = true, LedgerChoice choice = {});

  /// Energies and forces of the start, whose first step is dt long. u, v, a at t = 0. Collective.
  void start(const Integrator& integrator, double dt, Vec u, Vec v, Vec a);
  /// After a restart: energies of the restored state; totals and forces came with the table. Collective.
  void resume(Vec u, Vec v);
  /// Energies of a state whose integrator tells no forces: work, balance and reactions become nan.
  /// Collective.
  void observe(Vec u, Vec v);
  /// Books an accepted step. To be called before the state table commits: rows still hold t_n, trial halves
  /// t_{n+1}. u, v, a: the integrator's values at t_{n+1}. Collective.
  void book(const StepRecord& step, Vec u, Vec v, Vec a);
  /// Takes the last booking back, for a step that is refused after it; the table's rollback does the rest.
  void unbook();

  /// Columns of the history file in the order of the option reference; names as in options/README.md.
  void append_energies(HistoryFile::Row& row) const;
  void append_reactions(HistoryFile::Row& row) const;
  void append_contact_heat(HistoryFile::Row& row) const;
  void append_materials(HistoryFile::Row& row) const;
  /// The balance sheet since t = 0, total and of each material, for the end of the log.
  std::string report() const;
  double balance() const;
  double balance_first_law() const;
  /// Energy that contact gave by itself, or beside it closing cracks and the integrator; not negative
  /// (theory.md, 11).
  double gain() const;
  /// The first law's residual, a gain positive, and with it `gain`, which closes it.
  double energy_error() const;
  double fracture_energy(std::size_t material) const { return materials_[material].fracture; }
  double phi_max() const { return phi_max_; }
  double alpha_max() const { return alpha_max_; }
  double theta_max() const { return theta_max_; }
  /// The largest so far of what bodies store and of what came from outside: what residuals are relative to.
  double energy_scale() const;
  const MaterialEnergies& total() const { return total_; }

private:
  // Totals since t = 0, one global row, so that a restart continues them.
  enum Total {
    viscous,
    damage,
    plastic_dissipation,
    friction,
    numerical, ///< the integrator's loss without what it keeps, and rigid bodies' without inertia
    kept,      ///< energy that the integrator holds (IntegratorEnergy::kept)
    kept_at_start,
    grown,        ///< part of that (IntegratorEnergy::grown)
    exchange,     ///< part of `numerical`, of any sign (IntegratorEnergy::exchange)
    unbalanced,   ///< work of what Newton's method left of the balances
    contact_loss, ///< of the contact-stabilised and of the conserving update
    external,
    damage_work, ///< part of `external`
    contact_work,
    identity,
    start_energy,
    scale,
    fatigue_loss,
    contact_store, ///< energy_contact as the last step left it
    closing,       ///< by the unilateral stress of broken points
    least,         ///< smallest dissipation of a step at a point, per volume; at most 0
    count
  };
  /// Dissipated since t = 0 in one material.
  enum Loss { viscous_loss, damage_loss, plastic_loss, fatigue_part, losses };

  double& sum(Total which) const { return totals_->trial[which]; }
  double& lost_in(std::size_t material, Loss which) const {
    return losses_->trial[material * static_cast<std::size_t>(losses) + static_cast<std::size_t>(which)];
  }
  /// Work of the velocity's projection at the start of a step.
  struct Shock {
    double contact = 0, supports = 0, rigid = 0; ///< rigid: of what keeps rigid bodies rigid
  };
  Shock find_shock(const StepRecord& step) const;
  IntegratorEnergy find_integrator_energy(const StepRecord& step, Vec u, Vec v, Vec a);
  double unilateral_energy(std::span<const double> phi) const;
  void book_damage(const StepRecord& step);
  void find_coupling_error(Vec internal_of_next_pass, Vec internal);
  void measure(Vec u, Vec v, bool trial);
  void find_extremes(bool trial);
  double dissipated() const;
  double heat_supplied() const;
  double entropy_produced() const;
  void find_reactions(const std::vector<double>& u);
  double contact_energy(Vec u) const;
  Handle<Vec> global_of(const char* row) const; ///< of t_n
  bool in_rigid_body(std::size_t dof) const;
  bool turns(int condition, std::size_t axis) const; // the condition prescribes a rotation of a rigid body
  double stored() const;

  MotionProblem& motion_;
  StateTable& state_;
  bool inertia_, moves_, prescribes_damage_ = false;
  LedgerChoice choice_;
  /// With heat: supplied by each condition since t = 0; conducted into the secondary side of each contact
  /// that passes heat, and what came from outside the bodies there; entropy supplied, entropy at the start.
  StateRow* heat_ = nullptr;
  std::vector<std::string> heat_contacts_; ///< their ids
  StateRow *totals_, *losses_, *internal_, *external_, *contact_, *inertia_force_, *left_;
  StateRow* step_acceleration_; ///< IntegratorStep::f
  std::vector<MaterialEnergies> materials_;
  MaterialEnergies total_, total_before_;
  std::vector<MaterialEnergies> materials_before_;
  double energy_contact_ = 0, phi_max_ = 0, alpha_max_ = 0, theta_max_ = 0;
  double fatigue_max_ = 0, coupling_error_ = 0;
  std::vector<double> reaction_;   ///< [condition][dim]
  std::vector<double> moment_;     ///< [condition][3] about the centres of mass of rigid bodies
  std::vector<double> mean_;       ///< [condition][dim] mean displacement of the condition's nodes
  std::vector<double> mean_theta_; ///< [condition]
  std::vector<std::vector<int>> condition_nodes_;
  std::vector<double>
      reaction_force_; ///< what closes the balance of momentum on prescribed dofs, [node][dim]
  std::vector<double> X_;
};

} // namespace impact
