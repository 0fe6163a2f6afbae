#pragma once
#include <array>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/erosion.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/explicit_bodies.hpp>
#include <impact/solve/explicit_contact.hpp>
#include <petscts.h>
#include <string>
#include <vector>

/// A step of the motion by central differences: the displacement is known, the forces there give the
/// acceleration by the lumped mass, and no equation is solved (theory.md, 7). How long a step may be comes
/// from the cells (kernel/stable_step.hpp) and the penalties of the contacts.
namespace impact {

// Members beyond twelve: what it is given, and what bounds a step.
class ExplicitStep {
public:
  /// Adds a row of its own to the table; the references must outlive the object.
  /// `erosion` may be null.
  ExplicitStep(TS ts, MotionProblem& motion, StateTable& state, Erosion* erosion,
               const ExplicitScenario& settings);
  ExplicitStep(const ExplicitStep&) = delete;
  ExplicitStep& operator=(const ExplicitStep&) = delete;

  /// Into the committed halves of the rows, at the start of a run: the stable step at u, v and the automatic
  /// penalties of contacts that go with it. Collective.
  void start(Vec u, Vec v);
  /// After a restart. Collective.
  void resume();
  /// The longest step from the committed state on. Collective when called first.
  double longest();
  /// How long the steps are, for the head of the log; `asked`: -ts_dt, or 0.
  std::string text(double asked);

  /// Acceleration at the start, from the forces and those of contact, null for none. Collective.
  void start_acceleration(Vec u, Vec v, Vec contact, Vec a);
  /// The forces at u and from them the new acceleration of the TS; flow and what drives damage, as
  /// MotionProblem::advance has it. False where a cell lost its meaning. Collective.
  bool take(Vec u, MotionProblem::Increments& sums, const HeatRows& heat);
  /// Damage has grown at u: its forces, and the acceleration, are those of phi, [local node]. Collective.
  void follow_damage(Vec u, const std::vector<double>& phi);
  const ForceParts& forces() const { return forces_; }
  /// Cells have left: contacts find the surfaces that are there at u, and steps go with them. Collective.
  void expose(Vec u) {
    contacts_.expose(u);
    weigh_foundations();
  }
  const ExplicitBodies& bodies() const { return bodies_; }
  /// The step is accepted, and what its parts had to sum up has been. Collective.
  void accept();

private:
  /// What prescribed dofs know at a time: u, v, the last a; null for none.
  struct Rates {
    double t, dt;
    Vec u, v, a;
  };
  void invert_mass();
  void divide_by_mass(const Rates& now, Vec a);
  void prescribe(const Rates& now, Vec a);
  void weigh_foundations();
  double stable_without_contact() const;
  CellsOfStep cells_of_step() const;
  void scale_mass(Vec u, const std::vector<double>& before, double dt);
  void tell_of_collapse(double dt);

  /// Components of the row "stable_step": that of the cells; steps between two looks at them, and until the
  /// next; bound of the square of the frequencies by penalties at work, on their own;
  /// ExplicitContact::closing.
  enum { of_cells, interval, left, of_penalties, of_closing, components };
  TS ts_;
  MotionProblem& motion_;
  StateTable& state_;
  Erosion* erosion_;
  ExplicitScenario settings_;
  StateRow& row_;
  double first_step_ = 0;     ///< of the cells when the program started; 0: its fall has been told
  double of_foundations_ = 0; ///< Foundations::frequency
  ForceParts forces_;
  ExplicitContact contacts_;
  ExplicitBodies bodies_;
  struct {
    Handle<Vec> u_n;
    Handle<Vec> inverse_mass; ///< 0 at prescribed dofs
    Handle<Vec> change;       ///< of the internal force by damage
  } work_;                    ///< each once it is asked for
};

} // namespace impact
