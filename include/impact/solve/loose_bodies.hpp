#pragma once
#include <impact/contact/contact_set.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <petscsnes.h>
#include <string>
#include <vector>

/// Bodies of a static run that contact alone holds. Until enough of their surface is pressed their tangent is
/// singular, and a Newton step throws them through what they touch. The iteration is therefore one of a
/// pseudo-time, in which a mass of unit density resists each step from the iterate at hand:
///   (K + c_b M) du = -R(u),   c_b = (f/m) min(1, f/f_max)                                       (H1), (H2)
/// f: resultant of R on the body over its volume; m: the way that it may approach by; of rigid bodies M
/// stands in the rows of their unknowns. The mass stands in the matrix alone, so that it does no work, and
/// goes with the square of the resultant, so that Newton's method ends as quickly as without.
namespace impact {

class LooseBodies {
public:
  LooseBodies() = default;
  /// Finds the bodies by the prescribed displacements. All must outlive this object. Collective.
  LooseBodies(const Discretisation& d, const BoundaryData& boundary, const ContactSet& contacts,
              const RigidBodies& rigid);

  bool empty() const { return bodies_.empty(); }
  /// Beginnings of an attempt at a step and of a Newton solve. Not collective.
  void start_attempt();
  void start_solve();
  /// Takes c_b from the residual r at u (H2). Collective.
  void weigh(Vec u, Vec r);
  /// Adds c_b M, lumped, to the assembled tangent K. Collective.
  void add_to(Mat K) const;
  /// Whether a body faces nothing yet at u, but has something near that the search sees. Collective.
  bool sees_only(Vec u) const;
  /// Whether each of them presses something at u. Collective.
  bool rest(Vec u) const;
  /// Largest part of the step du, at most 1, that moves no node on the surfaces of these bodies by more than
  /// twice what they may approach by; twice that after a shortened step that did good (H3). Collective.
  double part_of(Vec du);
  /// True from a weigh() that found a body out of balance.
  bool unbalanced() const;
  /// True from a weigh() that found one pushed towards what it does not face yet: what faces what is to be
  /// found again after the next step.
  bool must_look() const { return must_look_; }
  /// For the message of a solve that failed: bodies that met nothing; empty where there are none.
  std::string adrift() const;

private:
  struct Body {
    std::string name;             // for messages
    std::array<double, 3> centre; // of the nodes
    double volume = 0, inertia = 0, size = 0, facet = HUGE_VAL;
    double weight = 0, floor = 0;   // c_b and the least of it
    double approach = 0, limit = 0; // m, m_0
    double largest = 0, now = 0;    // f_max of the attempt, f
    double strides = 1;             // of m_0 that a step may be (H3)
    bool guesses = false;           // pushed towards what it does not face yet
    struct Side {
      std::size_t contact;
      double sign;       // 1: secondary, -1: primary, 0: both
      bool held = false; // something on the other side is not loose
    };
    std::vector<Side> sides;
    std::array<double, 3> force{}; // on the body
    bool pressed = false;          // by any contact
    int blind = 0;                 // weighings in a row that found no partner near
    int rigid = -1;                // its number among the rigid bodies
  };
  void measure(const std::vector<int>& body_of_node);
  void find_approach(Body& body, const std::vector<ContactReach>& reach) const;
  void note_load(Body& body);
  static bool touches(const Body& body, const ContactReach& seen);
  struct Way {
    double length = HUGE_VAL;
    bool guessed = false; // from a distance: nothing faces what is there yet
  };
  // Along a direction: the way to what a body does not touch yet, and that of what it pushes on (0: held).
  static Way open_way(const Body& body, const Vector3& along, const std::vector<ContactReach>& reach);
  Way pushed_way(const Body& body, const Vector3& along, const std::vector<ContactReach>& reach,
                 std::vector<char>& passed) const;

  const Discretisation* d_ = nullptr;
  const ContactSet* contacts_ = nullptr;
  const RigidBodies* rigid_ = nullptr;
  std::vector<Body> bodies_;
  struct Node {
    int local, body;
    double volume;
    bool on_surface;
  };
  std::vector<Node> nodes_; // owned nodes of loose bodies
  std::vector<char> fixed_; // [local dof]
  double stride_ = 1;       // factor of what a step may be
  double load_ = 0;         // largest resultant force of the attempt on what pressed nothing
  bool must_look_ = false;
  bool limited_ = false; // the last step was cut
  PetscReal norm_ = 0;   // of the last residual
};

} // namespace impact
