#pragma once
#include <impact/balance/energies.hpp>
#include <impact/balance/reactions.hpp>
#include <impact/balance/work.hpp>
#include <impact/problem/heat.hpp>
#include <optional>
#include <string>

/// The balance sheet of a run: energies, dissipation and work since t = 0, per material and total, and two
/// checks.
///   balance            change of the kinetic energy, integrator's own loss by its weights
///   (Integrator::energy) and work of the forces that the motion solves really balanced: they add up to zero.
///   balance_first_law  stored energy + dissipation - external work - start: first order in dt (staggering).
///   With heat: stored energy with the thermal one + what no equation of heat takes up (the integrator's
///   loss) - external work - heat supplied - start; rounding with HeatForm::energy.
/// Both relative to the largest energy or work so far. Plane problems: times the thickness.
namespace impact {

/// Choices beside the columns that every run has.
struct LedgerChoice {
  bool materials = false;            ///< energies and dissipations of each material as columns
  bool coupling_error = false;       ///< how far the last pass was from the next one
  bool unilateral = false;           ///< as StepRecord says of each step
  bool viscous = false;              ///< something other than a law is viscous
  const HeatProblem* heat = nullptr; ///< whose contacts are booked
};

// Members beyond twelve: the books of one sheet, each with its own rows of the table.
class Ledger {
public:
  /// Adds its rows (forces at t_n, totals) to the table. References must outlive the ledger.
  Ledger(MotionProblem& motion, StateTable& state, bool inertia, bool moves = true, LedgerChoice choice = {});

  /// Energies and forces of the start, whose first step is dt long. u, v, a at t = 0; `kept_by_bodies`:
  /// ExplicitBodies::kept. Collective.
  void start(const Integrator& integrator, double dt, Vec u, Vec v, Vec a, double kept_by_bodies = 0);
  /// After a restart: energies of the restored state; totals and forces came with the table. Collective.
  void resume(Vec u, Vec v);
  /// The same under another integrator, whose first step is dt long. What velocities have more than before is
  /// energy of the start, what they have less is the integrator's loss, as is what it holds. Collective.
  void resume_with(const Integrator& integrator, double dt, Vec u, Vec v, Vec a);
  /// Books an accepted step. To be called before the state table commits: rows still hold t_n, trial halves
  /// t_{n+1}. u, v, a: the integrator's values at t_{n+1}. Energies and reactions are only found where the
  /// step is `watched`. Collective.
  void book(const StepRecord& step, Vec u, Vec v, Vec a, bool watched = true);
  /// Between two steps the surfaces of contacts have changed and with them the energy that contacts keep:
  /// cells that left took the difference along.
  void book_exposure(double before, double after);
  /// What hangs on the mass between two steps, u, v and a being those at hand and dt the length of the last
  /// one: of all bodies, and what the integrator holds beside rigid bodies. Collective.
  struct Inertia {
    Energies energies;
    double kept;
  };
  Inertia inertia(Vec u, Vec v, Vec a, double dt);
  /// Likewise cells took their mass along; `force` was on nodes without any now.
  void book_shed_mass(const Inertia& before, const Inertia& after, const std::array<double, 3>& force);
  /// Takes the last booking back, for a step that is refused after it; the table's rollback does the rest.
  void unbook() { energies_ = energies_before_; }

  /// Columns of the history file in the order of the option reference; names as in options/README.md.
  void append(HistoryFile::Row& row) const;
  /// Those of contact heat and of materials, which stand further back.
  void append_contact_heat(HistoryFile::Row& row) const;
  void append_materials(HistoryFile::Row& row) const;
  /// The balance sheet since t = 0, total and of each material, for the end of the log.
  std::string report() const;

  double balance() const;
  double balance_first_law() const;
  /// The first law's residual, a gain positive, and with it `gain`, which closes it.
  double energy_error() const;
  /// The largest so far of what bodies store and of what came from outside: what residuals are relative to.
  double energy_scale() const;
  /// Energies: what penalties of contacts hold, what impacts took, what static steps missed as gaps closed,
  /// and what the last step strained bodies by.
  struct Exchanged {
    double held, struck, missed, strained;
  };
  Exchanged exchanged() const {
    return {sum(contact_store), sum(contact_loss), sum(gap_work),
            energies_.total.elastic - energies_before_.total.elastic};
  }
  /// Steps of this process in which no iteration answered loads, for what they leave is less than the
  /// absolute tolerance of the motion.
  int unanswered() const { return unanswered_; }
  const Energies& energies() const { return energies_; }

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
    exchange,     ///< part of `numerical`, of any sign (IntegratorEnergy::exchange)
    unbalanced,   ///< work of what Newton's method left of the balances
    contact_loss, ///< by the contact-stabilised and the conserving update, by impulses
    external,
    damage_work, ///< part of `external`
    contact_work,
    identity,
    start_energy,
    scale,
    fatigue_loss,
    contact_store, ///< energy of contact as the last step left it
    gap_work,      ///< of contact along gaps that steps without inertia close, which nothing takes up
    closing,       ///< by the unilateral stress of broken points
    least,         ///< smallest dissipation of a step at a point, per volume; at most 0
    kinetic,       ///< energy up to which `identity` is booked
    count
  };
  /// Dissipated since t = 0 in one material.
  enum Loss { viscous_loss, damage_loss, plastic_loss, fatigue_part, losses };
  /// What springs store, what dashpots took since t = 0: of a row of its own, so that a run may begin or let
  /// go foundations at a restart.
  struct FoundationSum {
    enum { store, loss, count };
  };
  /// A line of the sheet: what a run has, of all bodies and of each material.
  struct Line;

  double& sum(Total which) const { return totals_.trial[which]; }
  double& lost_in(std::size_t material, Loss which) const {
    return losses_.trial[material * static_cast<std::size_t>(losses) + static_cast<std::size_t>(which)];
  }
  void measure(Vec u, Vec v, bool trial);
  double book_foundations(const StepWork& work);
  void note_loads(const StepRecord& step);
  void book_contact(const StepWork& work, double work_contact, const StepRecord& step, Vec u, bool watched);
  void book_points(const StepRecord& step, const DamageLosses& by_damage, double work_unilateral);
  void book_damage(const StepRecord& step, const DamageLosses& lost);
  void book_scale(double dt);
  double unilateral_energy(std::span<const double> phi) const;
  void find_coupling_error(const StepRecord& step);
  /// Energy that contact gave by itself, or beside it closing cracks and the integrator; not negative
  /// (theory.md, 11).
  double gain() const;
  bool loses_by_viscosity() const { return motion_.discretisation().has_viscosity() || choice_.viscous; }
  double eroded(int which) const;         // a component of ErosionTotals, 0 where nothing erodes
  double of_foundations(int which) const; // a component of FoundationSum
  double stored() const;
  double dissipated() const;
  double heat_supplied() const { return heat_ ? heat_->supplied() : 0; }
  std::vector<Line> sheet() const;
  bool has_contact() const;
  bool has_friction() const;

  MotionProblem& motion_;
  StateTable& state_;
  BodyRows rows_;
  bool inertia_, moves_, prescribes_damage_;
  LedgerChoice choice_;
  StateRow &totals_, &losses_;
  StateRow* erosion_;     ///< null: no cell leaves
  StateRow& foundations_; ///< FoundationSum, of foundations of before too
  ForceBook forces_;
  Reactions reactions_;
  std::optional<HeatBook> heat_;
  Energies energies_, energies_before_;
  double coupling_error_ = 0;
  int unanswered_ = 0;
  bool springs_apart_ = false; // surfaces overlapped at the start of a run without inertia
};

} // namespace impact
