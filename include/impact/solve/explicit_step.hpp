#pragma once
#include <array>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/explicit_bodies.hpp>
#include <petscts.h>
#include <string>
#include <vector>

/// A step of the motion by central differences: the displacement is known, the forces there give the
/// acceleration by the lumped mass, and no equation is solved (theory.md, 7). How long a step may be comes
/// from the cells (kernel/stable_step.hpp) and the penalties of the contacts.
namespace impact {

class ExplicitStep {
public:
  /// Adds a row of its own to the table; the references must outlive the object.
  ExplicitStep(TS ts, MotionProblem& motion, StateTable& state, const ExplicitScenario& settings);
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

  /// Acceleration at the start, from the forces without contact. Collective.
  void start_acceleration(Vec u, Vec v, Vec a);
  /// The forces at u and from them the new acceleration of the TS; flow and what drives damage, as
  /// MotionProblem::advance has it. False where a cell lost its meaning. Collective.
  bool take(Vec u, MotionProblem::Increments& sums, const HeatRows& heat);
  const ForceParts& forces() const { return forces_; }
  const ExplicitBodies& bodies() const { return bodies_; }
  /// Tells contacts of an accepted step what they did in it. Collective.
  void advance_contacts(Vec u_n, Vec u, double dt);

private:
  /// What prescribed dofs know at a time: u, v, the last a; null for none.
  struct Rates {
    double t, dt;
    Vec u, v, a;
  };
  void find_contact_forces(Vec u);
  void divide_by_mass(const Rates& now, Vec a);
  /// Of a contact over its penalty, bounds of the squared frequency at each dof, and of each rigid body.
  struct ContactLoads {
    std::vector<double> nodes, bodies;
    void add(const ContactLoads& other, double factor);
    double largest() const;
  };
  ContactLoads no_loads() const;
  ContactLoads contact_loads(const ContactInterface& contact);
  void add_load_on_obstacle(const ContactInterface& contact, const std::vector<double>& area,
                            std::vector<double>& of_bodies) const;
  double stable_without_contact() const;
  void scale_mass(Vec u, const std::vector<double>& before, double dt);
  void set_penalties(double longest_of_cells);
  double contact_frequency();

  /// Components of the row "stable_step": that of the cells; steps between two looks at them, and until the
  /// next; bound of the square of the frequencies by penalties at work, on their own.
  enum { of_cells, interval, left, of_penalties, components };
  TS ts_;
  MotionProblem& motion_;
  StateTable& state_;
  ExplicitScenario settings_;
  StateRow& row_;
  ForceParts forces_;
  struct ContactForce {
    Handle<Vec> residual;
    std::array<double, 3> part{};
  };
  std::vector<ContactForce> of_contacts_;
  double contact_frequency_ =
      -1;                 ///< likewise of a whole surface that meets one like it; negative: not known yet
  Handle<Vec> stiffness_; ///< of penalties at work
  ExplicitBodies bodies_;
  std::vector<double> stiffness_of_bodies_;
  struct Held {
    std::vector<double> u, v, before, goal, speed;
  } held_; ///< work space for prescribed dofs, [node][dim]
};

} // namespace impact
