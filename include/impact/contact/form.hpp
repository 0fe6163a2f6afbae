#pragma once
#include <impact/contact/constraint.hpp>
#include <impact/contact/obstacle.hpp>
#include <impact/contact/pair_search.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/mesh/state_table.hpp>
#include <limits>

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

class ContactForm {
public:
  explicit ContactForm(const FormRequest& request)
      : settings_(request.settings), obstacle_(request.mesh.dim()) {}
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
    switched_ = false;
    release();
    if (u_n) {
      search_.begin_attempt(u_n);
      if (list_restored()) obstacle_.locate(nodes());
      anchor(u_n);
    }
    obstacle_.begin_attempt(pose);
  }
  /// Slip counts from u and from the rigid body's present place from now on. Collective.
  virtual void anchor(Vec u) = 0;
  /// Brings the candidate pairs, and whatever the form keeps fixed during a Newton solve, up to date at u.
  /// Collective.
  virtual PairSearch::Outcome update(Vec u, const Presses& presses) = 0;
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
  virtual void visit(const std::vector<double>& u, Derivatives derivatives,
                     const ConstraintVisitor& visitor) const = 0;
  /// sum_c (gap factor d2g_c + slip factors d2s_c) in blocks, over the same constraints as a visit.
  virtual void visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                               const BlockVisitor& visitor) const = 0;
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
  bool rigid() const { return settings_.rigid(); }
  bool frictional() const { return settings_.friction > 0; }
  /// A rigid plane has directions of its own.
  bool on_plane() const { return rigid() && obstacle_.plane(); }
  PairSearch::Outcome update_pairs(Vec u) {
    const PairSearch::Outcome outcome = search_.update(u);
    if (outcome != PairSearch::Outcome::kept) obstacle_.locate(nodes());
    return outcome;
  }

  /// Places in nodes() of the corners of a secondary facet, and of the facet of a candidate pair.
  const int* secondary_slots(int facet) const {
    return &nodes().secondary[static_cast<std::size_t>(nodes().corners * facet)];
  }
  const int* primary_slots(int candidate) const {
    const int facet = search_.candidates().facet[static_cast<std::size_t>(candidate)];
    return &nodes().primary[static_cast<std::size_t>(nodes().corners * facet)];
  }
  /// Global nodes of the facet of a candidate pair, of which one with fewer than four repeats the last.
  const std::array<PetscInt, 4>& primary_nodes(int candidate) const {
    const Candidates& list = search_.candidates();
    return list.primary[static_cast<std::size_t>(list.facet[static_cast<std::size_t>(candidate)])].node;
  }
  /// Different corners of that facet.
  int primary_corners(int candidate) const {
    const int* slot = primary_slots(candidate);
    return nodes().corners == 2 ? 2 : slot[3] == slot[2] ? 3 : 4;
  }
  /// Corners of a facet at coordinates x [node][d] of nodes(); or at a displacement, seen from a node.
  template <std::size_t n, std::size_t d>
  static std::array<std::array<double, d>, n> corners_at(const int* slot, const std::vector<double>& x) {
    std::array<std::array<double, d>, n> corner;
    for (std::size_t a = 0; a < n; ++a)
      std::copy_n(&x[d * static_cast<std::size_t>(slot[a])], d, corner[a].begin());
    return corner;
  }
  template <std::size_t n, std::size_t d>
  std::array<std::array<double, d>, n> corners_from(int origin, const int* slot,
                                                    const std::vector<double>& u) const {
    std::array<std::array<double, d>, n> corner;
    for (std::size_t a = 0; a < n; ++a) corner[a] = nodes().place<d>(slot[a], origin, u);
    return corner;
  }

  ContactSettings settings_;
  PairSearch search_;
  Obstacle obstacle_;
  bool switched_ = false;
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
