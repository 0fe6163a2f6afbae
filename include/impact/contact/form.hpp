#pragma once
#include <functional>
#include <impact/contact/obstacle_carrier.hpp>
#include <impact/contact/pair_search.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/kernel/contact_slip.hpp>
#include <impact/kernel/rigid_obstacle.hpp>
#include <impact/mesh/state_table.hpp>
#include <limits>
#include <span>

/// How a contact is discretised: a list of gap constraints with their derivatives. What becomes of them, the
/// enforcement, is the business of ContactInterface, the same for every form.
///   potential  sum_c w_c psi(g_c, lambda_c),  psi = (p^2 - lambda^2) / (2 eps),  p = <lambda - eps g>
/// w_c: reference area; g_c: gap, or mean gap over that area. The gaps do not change under rigid motions, so
/// that the forces -w p dg conserve linear and angular momentum to rounding.
namespace impact {

/// How gaps become pressures, for given multipliers.
///   penalty, augmented Lagrangian   p = <lambda - eps g>
///   semismooth Newton               p = lambda where lambda - eps g > 0 (active), else 0
/// In the second form the linear solves make the active gaps vanish, with the weight gamma; the converged
/// state does not know its value.
struct PressureLaw {
  std::span<const double> lambda;
  double eps = 0, gamma = 0;
  bool semismooth = false;

  double multiplier(int index) const { return lambda[static_cast<std::size_t>(index)]; }
  bool active(int index, double gap) const { return multiplier(index) - eps * gap > 0; }
  double pressure(int index, double gap) const {
    return active(index, gap) ? multiplier(index) - (semismooth ? 0 : eps * gap) : 0;
  }
  /// -dp/dg where active, or the weight of the gap in the linear solves, of a constraint that is covered in
  /// part.
  double stiffness(double cover = 1) const { return semismooth ? gamma * (1 / (cover * cover)) : eps; }
};

/// Which derivatives a visit brings: `first`, the gradients along which the forces stand; `tangent`, also
/// those of the gaps where they differ, for linear systems. Forms know the first two.
enum class Derivatives { none, first, tangent };

/// One constraint at one displacement. The spans live as long as the visit.
struct Constraint {
  int index = 0;                  ///< place of its multiplier
  double weight = 0, stretch = 1; ///< reference area; current over reference area
  double gap = 0, lambda = 0, pressure = 0;
  bool active = false;
  double cover = 1; ///< part of the weight that faces something
  /// Mean distance of what faces something; of a penetration the mean over the weight, which is what
  /// pressures close.
  double distance() const { return gap > 0 ? gap / cover : gap; }
  std::span<const int> node;            ///< into ContactForm::nodes(), secondary ones first
  std::span<const double> share;        ///< of the secondary nodes in the constraint, sum 1
  std::span<const double> gradient;     ///< [node][dim]
  std::span<const double> end_gradient; ///< of the gap, where the force stands along another one, else empty
  std::span<const double> gap_gradient() const { return end_gradient.empty() ? gradient : end_gradient; }
  /// Tangential motion since the start of the step, mean over the weight, in directions that the secondary
  /// surface carries along (one in the plane, two in space), and its derivatives over the same nodes; without
  /// friction, or where nothing lay opposite at the start, `slides` is false.
  bool slides = false;
  Tangential slip{};
  std::span<const double> slip_gradient; ///< [direction][node][dim]
};
using ConstraintVisitor = std::function<void(const Constraint&)>;

/// Where the two sides of a constraint meet, for what passes between them: over the covered part of its
/// weight the mean of a nodal field is sum share field, on the secondary side over the first `secondary`
/// nodes, on the other one over the rest. The spans live as long as the visit.
struct Meeting {
  int index = 0;   ///< of the constraint
  double area = 0; ///< reference area of the covered part
  std::size_t secondary = 0;
  std::span<const int> node; ///< into ContactForm::nodes(); one may come on both sides
  /// Sum 1 on either side. A rigid body has none; nor has what covers nothing worth mentioning, area 0.
  std::span<const double> share;
};
using MeetingVisitor = std::function<void(const Meeting&)>;

/// Factors of the second variations, by the index of the constraint.
struct CurvatureFactors {
  std::span<const double> gap;
  std::span<const Tangential> slip; ///< empty without friction

  double of_gap(int index) const { return gap[static_cast<std::size_t>(index)]; }
  Tangential of_slip(int index) const {
    return slip.empty() ? Tangential{} : slip[static_cast<std::size_t>(index)];
  }
};
/// Nodes, and a block [node][dim][node][dim] over their dofs; a node may come twice. Both live as long as the
/// call.
using BlockVisitor = std::function<void(std::span<const int>, std::span<const double>)>;

/// Where a rigid obstacle stands in an attempt; one with mass: in the reference configuration, not moved.
struct ObstaclePose {
  RigidObstacle obstacle;        ///< at the end of the step
  std::array<double, 3> moved{}; ///< its displacement since the start of the step
};

inline PairSearch::Primary what_it_meets(const ContactSettings& settings) {
  return settings.rigid()                         ? PairSearch::Primary::rigid
         : settings.primary == settings.secondary ? PairSearch::Primary::itself
                                                  : PairSearch::Primary::other;
}

class ContactForm {
public:
  virtual ~ContactForm() = default;
  /// The rigid obstacle moves as a body of the mesh does. Before the first update.
  void carry(ObstacleCarrier carrier) {
    carrier_ = std::move(carrier);
    search_.add_nodes(carrier_.nodes());
  }

  /// A row that holds so many numbers per constraint, [constraint][component], and its length.
  virtual std::pair<StateRow, std::size_t> constraint_row(const std::string& name, int components) const = 0;
  /// Beginning of an attempt; `pose`: of the rigid body, where the primary is one; `u_n`: where the attempt
  /// starts, or null. Slip counts from there. Collective.
  void begin_attempt(const ObstaclePose& pose, Vec u_n) {
    switched_ = false;
    release();
    if (u_n) {
      search_.begin_attempt(u_n);
      if (list_restored()) carrier_.locate(nodes());
      anchor(u_n);
    }
    pose_ = pose;
  }
  /// Slip counts from u and from the rigid body's present place from now on. Collective.
  virtual void anchor(Vec u) = 0;
  /// Brings the candidate pairs, and whatever the form keeps fixed during a Newton solve, up to date at u.
  /// Collective.
  virtual PairSearch::Outcome update(Vec u, const PressureLaw& law) = 0;
  /// The next update builds the pairs afresh.
  void forget() { search_.forget(); }
  /// True from a begin_attempt that brought the nodes of an earlier list back until the next update.
  bool list_restored() const { return search_.restored(); }
  /// True when the last update changed what a constraint with pressure faces, on this rank.
  bool switched() const { return switched_; }
  void clear_switched() { switched_ = false; }
  const ContactNodes& nodes() const { return search_.nodes(); }
  /// Pairs of global nodes whose dofs tangents may couple: sorted, each once.
  virtual NodePairs couplings() const = 0;
  /// False where the coordinates x of nodes() left the range of the pairs.
  bool pairs_hold(const std::vector<double>& x) const { return search_.holds_for(x); }
  /// Distance of the nearest nodes of this rank's pairs at the displacement u of nodes(); infinite without
  /// any.
  double nearest_nodes(const std::vector<double>& u) const { return search_.nearest_nodes(u); }
  double pairs_per_facet() const { return search_.pairs_per_facet(); }
  /// Whether it has far more constraints than its surface has nodes.
  virtual bool overdetermined() const { return false; }
  /// Gap below which a constraint lies deeper than the search can judge, in this step or the next; -infinity
  /// where it always can.
  double deepest() const {
    return search_.meets_rigid() ? -std::numeric_limits<double>::infinity() : -search_.range();
  }
  /// All constraints that face something at the displacement u of nodes(), in an order that every evaluation
  /// repeats.
  virtual void visit(const std::vector<double>& u, Derivatives derivatives, const PressureLaw& law,
                     const ConstraintVisitor& visitor) const = 0;
  /// sum_c (gap factor d2g_c + slip factors d2s_c) in blocks, over the same constraints as a visit.
  virtual void visit_curvature(const std::vector<double>& u, const PressureLaw& law,
                               const CurvatureFactors& factors, const BlockVisitor& visitor) const = 0;
  /// Where the sides meet at the displacement u of nodes(), of all that a visit there brings.
  virtual void visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const = 0;
  /// Reference area of the whole secondary surface by nodes, [local node of the mesh].
  virtual const std::vector<double>& nodal_area() const = 0;
  /// Overlap of the secondary nodes at the coordinates x: depth and outward direction at places of nodes().
  /// A node that lies on several facets may come several times, on any rank.
  using OverlapVisitor = std::function<void(int node, double depth, const std::array<double, 3>& direction)>;
  virtual void visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const = 0;

protected:
  /// What was kept fixed during the solves of the last attempt is free again.
  virtual void release() = 0;
  bool carried() const { return !carrier_.empty(); }
  /// A rigid plane has directions of its own.
  bool on_plane() const {
    return search_.meets_rigid() && pose_.obstacle.shape == RigidObstacle::Shape::plane;
  }
  /// The rigid obstacle at the displacement u of nodes().
  RigidObstacle obstacle_at(const std::vector<double>& u) const {
    return carried() ? carrier_.obstacle(u) : pose_.obstacle;
  }
  PairSearch::Outcome update_pairs(Vec u) {
    const PairSearch::Outcome outcome = search_.update(u);
    if (outcome != PairSearch::Outcome::kept) carrier_.locate(nodes());
    return outcome;
  }

  PairSearch search_;
  ObstaclePose pose_;
  ObstacleCarrier carrier_; ///< empty: the obstacle, where there is one, moves as told
  bool switched_ = false;
};

} // namespace impact
