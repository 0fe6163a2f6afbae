#pragma once
#include <array>
#include <impact/contact/impulses.hpp>
#include <impact/problem/motion.hpp>
#include <impact/solve/explicit_bodies.hpp>
#include <vector>

/// Contacts of an explicit step: penalties as stiff as its length allows, their forces and how stiff those
/// are, and the impulses of contacts that take them (theory.md, 7).
namespace impact {

class ExplicitContact {
public:
  /// Of the depth at which facets are seen, by which the sides of a contact may approach each other in a step
  /// and a penalty may give way.
  static constexpr double part_of_depth = 0.2;

  explicit ExplicitContact(MotionProblem& motion);

  /// Automatic penalties where cells allow steps of this length, of which `cfl` is used, and the nodes have
  /// the velocities v. Those that a state of another scheme rests on stay. Collective.
  void set_penalties(double longest_of_cells, double cfl, const std::vector<double>& v);
  /// Ids of contacts and their penalties; empty where none presses by one.
  std::string penalties() const;
  /// Says what energy contacts give that go on from the multipliers of another scheme. Collective.
  void report_multipliers(Vec u) const;
  /// Largest quotient of the velocity at which the sides of a contact approach each other and the depth at
  /// which its facets are seen: at the start, by the velocities v of the nodes. Collective.
  double closing(const std::vector<double>& v) const;
  /// The same over the step dt that contacts have been updated for, by their ways. Not collective.
  double closing_in(double dt) const;
  /// Square of the frequency of a whole surface on its penalties that meets one like it, 0 without any.
  /// Collective when called first, and after an exposure.
  double frequency();
  /// Cells have left: contacts find the surfaces that are there at u. Collective.
  void expose(Vec u);

  /// force = that of the penalties on the bodies at u, where the step from u_n ends. Collective.
  void find_forces(Vec u_n, Vec u, Vec force);
  /// Of the last forces: bound of the square of the frequencies of nodes by penalties at work, on their own,
  /// once the tally of the motion has been reduced; and stiffness at each rigid body.
  double frequency_at_work() const { return at_work_.frequency; }
  const std::vector<double>& on_bodies() const { return on_bodies_; }
  bool by_impulse() const { return struck_.before; }
  /// What moves on from u freely in the next step, if it is as long as this one, with the velocity v and the
  /// acceleration a_n at its start and `a` at its end, is pushed where it would meet something: into force
  /// and a, which are those of the bodies' nodes too once bodies.push has seen the force. Inverse masses are
  /// 0 at prescribed dofs and on rigid bodies. Collective.
  struct Motion {
    double t, dt;
    Vec u_n, u, v, a_n;
  };
  void add_impulses(const Motion& now, Vec inverse_mass, const ExplicitBodies& bodies, Vec force, Vec a);
  /// Once an accepted step has been booked. Collective.
  void tell_of_depth();

private:
  /// Of a contact over its penalty, bounds of the squared frequency at each dof, and of each rigid body.
  struct Loads {
    std::vector<double> nodes, bodies;
    void add(const Loads& other, double factor);
    double largest() const;
  };
  double closing(const ContactInterface& contact, const std::vector<double>& v) const;
  Loads no_loads() const;
  Loads loads(const ContactInterface& contact);
  void add_load_on_obstacle(const ContactInterface& contact, const std::vector<double>& area,
                            std::vector<double>& of_bodies) const;
  void add_forces(Vec u_n, Vec u, bool by_impulse, Vec force);
  void find_frequency();

  MotionProblem& motion_;
  ContactImpulses impulses_;
  struct {
    Handle<Vec> before, free, force; // velocities
  } struck_;                         // with contacts by impulse
  double frequency_ = -1;            // negative: not known yet
  Handle<Vec> stiffness_;            // of penalties at work, zero between steps
  std::vector<double> on_bodies_;
  /// Of the last forces; `deepest`, in depths at which facets are lost.
  struct {
    double frequency = 0, deepest = 0;
    std::span<double> numbers() { return {&frequency, 2}; }
  } at_work_;
  bool told_ = false;
};

} // namespace impact
