#pragma once
#include <impact/contact/constraint.hpp>
#include <impact/contact/obstacle.hpp>
#include <impact/contact/pair_search.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/mesh/state_table.hpp>
#include <limits>
#include <span>

/// How a contact is discretised: a list of gap constraints with their derivatives. What becomes of them, the
/// enforcement, is the business of an EnforcementMethod, the same for every form.
///   potential  sum_c w_c psi(g_c, lambda_c),  psi = (p^2 - lambda^2) / (2 eps),  p = <lambda - eps g>
/// w_c: reference area; g_c: gap, or mean gap over that area. The gaps do not change under rigid motions, so
/// that the forces -w p dg conserve linear and angular momentum to rounding.
namespace impact {

inline PairSearch::Primary what_it_meets(const ContactSettings& settings) {
  return settings.rigid()                         ? PairSearch::Primary::rigid
         : settings.primary == settings.secondary ? PairSearch::Primary::itself
                                                  : PairSearch::Primary::other;
}

/// Of what a form is made.
struct FormRequest {
  const Mesh& mesh; ///< must outlive the form, as the layout
  const FieldLayout& layout;
  const ContactSettings& settings; ///< without automatic values
  Frame frame;
  ContactSurface secondary;
  const ContactSurface& primary; ///< empty against the rigid body of the settings
  double hold_gap;               ///< by which the gap of what a point is tied to may differ from the nearest
};

/// Holding on to what a constraint faces while Newton's method works. At a kink of a surface, the end of a
/// facet, the side of a step, what lies nearest changes with the iterates and the direction of the force with
/// it: Newton's method jumps to and fro. What was chosen between the solves is therefore held in them, and
/// what changes it too often within an attempt at a step is held no longer, or no longer changed.
/// Of the points of a form, in units of their facet's coordinates.
struct HoldRule {
  double overlap; ///< a point is held as long as it stands at most this far beyond the facet,
  double limit;   ///< and in an iterate, which may stray, this far
};
/// Half an edge is one unit: 1/40 of its length, and a quarter.
inline constexpr HoldRule hold_on_edge = {0.05, 0.5};
/// A triangle's height, or half the width of a quadrilateral, is one unit: 1/40 of it, and all of it.
inline constexpr HoldRule hold_on_triangle = {0.025, 1};
/// A point is held to what is nearer than this part of its own facet's size.
inline constexpr double hold_range = 0.1;

/// How often what a constraint, or a facet, faces has changed in an attempt while it pressed.
class Switches {
public:
  bool exhausted() const { return count_ >= most; }
  void note() { ++count_; }

private:
  static constexpr int most = 4;
  int count_ = 0;
};

/// Nodes of the primary facet that a place of the secondary surface lay opposite of at the start of a step.
struct Opposite {
  GlobalFacet node{};
  int part = 0; ///< of the facet
  /// In the nodes of the contact, -1: not there; of a facet that was cut then the corners of the part.
  std::array<int, std::tuple_size_v<GlobalFacet>> slot{};

  void locate(const ContactNodes& nodes) {
    for (std::size_t b = 0; b < node.size(); ++b)
      slot[b] = b > 0 && node[b] == node[b - 1] ? slot[b - 1] : nodes.slot(node[b]);
  }
  /// Where the slots of its nodes are known.
  void stand(std::span<const int> nodes) {
    for (std::size_t b = 0; b < slot.size(); ++b) slot[b] = nodes[std::min(b, nodes.size() - 1)];
  }
  bool found() const { return *std::min_element(slot.begin(), slot.end()) >= 0; }
};

/// More functions than usual: one form serves implicit and explicit steps, friction, rigid obstacles and
/// erosion.
class ContactForm {
public:
  explicit ContactForm(const FormRequest& request)
      : settings_(request.settings), rigid_(settings_.rigid()), obstacle_(request.mesh) {}
  virtual ~ContactForm() = default;
  /// The rigid obstacle moves as a body of the mesh does. Before the first update.
  void carry(Obstacle obstacle) {
    obstacle_ = std::move(obstacle);
    search_.add_nodes(obstacle_.nodes());
  }

  /// A row that holds so many numbers per constraint, [constraint][component], and its length.
  virtual std::pair<StateRow, std::size_t> constraint_row(const std::string& name, int components) const = 0;
  /// Beginning of an attempt; `pose`: of the rigid body, where the primary is one; `u_n`: where the attempt
  /// starts, or null. Slip counts from there. Collective.
  void begin_attempt(const ObstaclePose& pose, Vec u_n) {
    switched_ = turned_ = false;
    last_way_ = 0;
    release();
    if (u_n) {
      search_.begin_attempt(u_n);
      if (search_.restored()) obstacle_.locate(nodes());
      anchor(u_n);
    }
    obstacle_.begin_attempt(pose);
  }
  /// Slip counts from u and from the rigid body's present place from now on. Collective.
  virtual void anchor(Vec u) = 0;
  /// Brings the candidate pairs, and whatever the form keeps fixed during a Newton solve, up to date at u.
  /// Collective.
  virtual PairSearch::Outcome update(Vec u, const ConstraintFilter& presses) = 0;
  /// Slips are measured in what the secondary side sees opposite at the displacement u of nodes() (81').
  virtual void follow_slip(const ContactValues& /*u*/) {}
  /// In this attempt friction acts across the normal force at the first u that comes here (81''').
  void turn_slip_once(const ContactValues& u) {
    if (!turned_) turn_slip(u);
    turned_ = true;
  }
  /// True when the last update changed what a constraint with pressure faces, on this rank.
  bool switched() const { return switched_; }
  void clear_switched() { switched_ = false; }
  PairSearch& search() { return search_; }
  const PairSearch& search() const { return search_; }
  /// The longest steps that penalties are made for, over the present one.
  void set_longest_step(double steps) { longest_step_ = steps; }
  /// How deep the facet of a constraint is seen.
  virtual double sight(int /*constraint*/) const { return 0.6 * search_.range(); }
  double longest_step() const { return longest_step_; }
  /// How far the sides move in such a step. Until the next attempt a form that takes the place of another one
  /// sees as deep as that one did.
  double way() const { return std::max(last_way_, longest_step_ * search_.motion()); }
  void keep_way(double way) { last_way_ = way; }
  const ContactNodes& nodes() const { return search_.nodes(); }
  /// The corners of facets and where they stand: the nodes, or vertices in their place.
  virtual const ContactNodes& vertices() const { return nodes(); }
  /// Pairs of global nodes whose dofs tangents may couple: sorted, each once.
  virtual NodePairs couplings() const = 0;
  /// Whether it has far more constraints than its surface has nodes.
  virtual bool overdetermined() const { return false; }
  /// All constraints that face something at the displacement u of nodes(), in an order that every evaluation
  /// repeats; those that are not `wanted` may be left out.
  virtual void visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
                     const ConstraintFilter& wanted) const = 0;
  /// sum_c (gap factor d2g_c + slip factors d2s_c) in blocks, over the same constraints as a visit.
  virtual void visit_curvature(const ContactValues& u, const CurvatureFactors& factors,
                               const BlockVisitor& visitor) const = 0;
  /// Where the sides meet at the displacement u of nodes(), of all that a visit there brings.
  virtual void visit_meetings(const ContactValues& u, const MeetingVisitor& visitor) const = 0;
  /// Reference area of the whole secondary surface by nodes, [local node of the mesh].
  virtual const std::vector<double>& nodal_area() const = 0;
  /// Overlap of the secondary nodes at the coordinates x: depth and outward direction at places of nodes().
  /// A node that lies on several facets may come several times, on any rank.
  using OverlapVisitor = std::function<void(int node, double depth, const std::array<double, 3>& direction)>;
  virtual void visit_overlaps(const ContactValues& x, const OverlapVisitor& visitor) const = 0;

protected:
  /// What was kept fixed during the solves of the last attempt is free again.
  virtual void release() = 0;
  virtual void turn_slip(const ContactValues& u) = 0;
  bool rigid() const { return rigid_; }
  bool frictional() const { return settings_.friction > 0; }
  /// Whether friction acts across the normal force. Cells that leave lay jagged faces open, at any angle,
  /// with a spring of the step alone: there it acts along the facets.
  bool leans() const { return !settings_.changing; }
  /// Whether an anchor finds the directions of slip. With Newton's method a step ends with those that its
  /// solves took, so that the forces that are told are those that were in balance.
  bool leans_at_anchor() const { return leans() && (!settings_.iterated || search_.restored()); }
  /// A rigid plane has directions of its own.
  bool on_plane() const { return rigid() && obstacle_.plane(); }
  PairSearch::Outcome update_pairs(Vec u) {
    const PairSearch::Outcome outcome = search_.update(u);
    if (outcome != PairSearch::Outcome::kept) obstacle_.locate(nodes());
    return outcome;
  }

  /// Numbers in vertices() of the corners of a secondary facet, and of the facet of a candidate pair. Facets
  /// and candidates are counted by their parts.
  const int* secondary_slots(int facet) const {
    return &vertices().secondary[static_cast<std::size_t>(vertices().per_facet * facet)];
  }
  const int* primary_slots(int candidate) const {
    return &vertices().primary[static_cast<std::size_t>(vertices().per_facet * primary_part(candidate))];
  }
  int primary_part(int candidate) const { return parts_ * primary_facet(candidate) + candidate % parts_; }
  /// The facet of a candidate pair, and its global nodes.
  int primary_facet(int candidate) const {
    return search_.candidates().facet[static_cast<std::size_t>(candidate / parts_)];
  }
  const GlobalFacet& primary_nodes(int candidate) const {
    return search_.candidates().primary[static_cast<std::size_t>(primary_facet(candidate))].node;
  }
  /// Different corners of that facet, one of first order.
  int primary_corners(int candidate) const {
    const int* slot = primary_slots(candidate);
    return nodes().per_facet == 2 ? 2 : slot[3] == slot[2] ? 3 : 4;
  }
  /// Corners of a facet, an array of places, at coordinates x [node][dim] of nodes(); or at a displacement,
  /// seen from a node.
  template <class Corners> static Corners corners_at(const int* slot, const ContactValues& x) {
    Corners corner;
    for (auto& place : corner)
      std::copy_n(&x[place.size() * static_cast<std::size_t>(*slot++)], place.size(), place.begin());
    return corner;
  }
  template <class Corners> Corners corners_from(int origin, const int* slot, const ContactValues& u) const {
    Corners corner;
    for (auto& place : corner)
      place = vertices().place<std::tuple_size_v<typename Corners::value_type>>(*slot++, origin, u);
    return corner;
  }
  /// Places of what lay opposite a facet at a displacement, seen from its first corner.
  template <class Corners>
  Corners opposite(const Opposite& opposite, int facet, const ContactValues& u) const {
    const int origin = secondary_slots(facet)[0];
    if (!rigid()) return corners_from<Corners>(origin, opposite.slot.data(), u);
    Corners corner;
    for (std::size_t b = 0; b < corner.size(); ++b)
      corner[b] =
          obstacle_.place<std::tuple_size_v<typename Corners::value_type>>(vertices(), facet, b, origin, u);
    return corner;
  }
  /// Corners of a secondary facet and of the carrier of the obstacle.
  std::vector<int> with_carrier(int facet, std::size_t corners) const {
    std::vector<int> node(secondary_slots(facet), secondary_slots(facet) + corners);
    node.insert(node.end(), obstacle_.slots().begin(), obstacle_.slots().end());
    return node;
  }
  /// Visits a block over the corners of a facet and what lay opposite: what a rigid body carries along has
  /// derivatives by its carrier.
  void visit_slip_block(int facet, const Opposite& opposite, std::span<const double> block,
                        const BlockVisitor& visitor) const {
    const auto corners = static_cast<std::size_t>(vertices().per_facet);
    std::vector<int> node = with_carrier(facet, corners);
    std::vector<double> chained;
    if (rigid()) {
      obstacle_.chain_block(facet, block, chained);
      block = chained;
    } else {
      node.insert(node.end(), opposite.slot.begin(), opposite.slot.begin() + vertices().per_facet);
    }
    visitor(node, block);
  }

  ContactSettings settings_;
  double longest_step_ = 1, last_way_ = 0;
  bool rigid_;
  PairSearch search_;
  Obstacle obstacle_;
  int parts_ = 1; // of a facet
  bool switched_ = false, turned_ = false;
};

/// Nodes of a constraint, each once, in the order in which they came.
struct NodePlaces {
  std::vector<int> node;

  std::size_t operator()(int n) {
    const auto place = static_cast<std::size_t>(std::find(node.begin(), node.end(), n) - node.begin());
    if (place == node.size()) node.push_back(n);
    return place;
  }
};

} // namespace impact
