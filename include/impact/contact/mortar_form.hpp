#pragma once
#include <algorithm>
#include <array>
#include <impact/contact/form.hpp>
#include <impact/contact/hold.hpp>
#include <impact/kernel/face_slip.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/kernel/mortar_face.hpp>
#include <impact/kernel/mortar_segment.hpp>
#include <utility>
#include <vector>

/// Mortar contact, one constraint per secondary node, evaluated by the owner of the node from all the facets
/// that meet there, whoever owns their cells: the mean gap g_A = (1/w_A) int Phi_A g dA_0 (80') over all
/// pairs of facets (mortar_segment.hpp in the plane, mortar_face.hpp in space). What the primary does not
/// cover counts zero. Against a rigid body the gap is its distance, integrated by points on the secondary
/// facets: exact for a plane. Which primary facets a secondary facet faces, and which functions Phi are dual,
/// is chosen by update and stays fixed in between.
namespace impact {

class MortarForm : public ContactForm {
public:
  /// Throws UserError(data): more than two edges meet in a node. Collective.
  explicit MortarForm(const FormRequest& request);

  std::pair<StateRow, std::size_t> constraint_row(const std::string& name, int components) const override;
  void anchor(Vec u) override;
  PairSearch::Outcome update(Vec u, const Presses& presses) override;
  NodePairs couplings() const override;
  void visit(const std::vector<double>& u, Derivatives derivatives,
             const ConstraintVisitor& visitor) const override;
  void visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                       const BlockVisitor& visitor) const override;
  void visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const override;
  const std::vector<double>& nodal_area() const override { return nodal_area_; }
  void visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const override;

private:
  void release() override;
  // A point of the integrals over the gap to a rigid body: weights of the facet's corners in its place, and
  // Phi_a dA_0.
  struct FacetPoint {
    std::array<double, 4> shape{}, weight{};
  };
  struct Facet {
    std::array<PetscInt, 4> node{};              // global; an edge has two, a triangle repeats its third
    int corners = 2;                             // different ones
    std::array<int, 4> owned = {-1, -1, -1, -1}; // [corner] place in owned_, -1: another rank's
    MortarEdge edge;                             // in the plane
    MortarFace face;                             // in space
    FaceMap map;                                 // in space, with friction
    std::vector<FacetPoint> points;              // against a rigid body
    FaceWeights onto; // likewise: D = M, of the facet on its own place at the start
    std::array<std::array<double, 4>, 4> dual{}; // Phi where the whole facet is covered,
    bool whole = false;                          // as it is taken to be,
    Switches changes;                            // from one kind to the other
  };
  struct Incident {
    int facet, corner;
    std::array<std::array<double, 2>, 2> turn = {}; // with friction in space: the node's tangents in it
  };
  struct Node {
    int local = 0; // in the mesh
    std::vector<Incident> facets;
    double weight = 0;
  };
  // Nodes of the primary facet that lay opposite at the start of the step; none of a rigid body, which
  // carries along the places of the secondary facet itself.
  template <std::size_t corners> struct Opposite {
    std::array<PetscInt, corners> node{}; // global
    std::array<int, corners> slot{};      // in nodes(), -1: not there

    void locate(const ContactNodes& nodes) {
      for (std::size_t b = 0; b < corners; ++b) slot[b] = nodes.slot(node[b]);
    }
  };
  template <std::size_t corners> bool found(const Opposite<corners>& opposite) const {
    return rigid() || *std::min_element(opposite.slot.begin(), opposite.slot.end()) >= 0;
  }
  // What lay opposite an edge of the node at the start of the step.
  struct Anchor {
    int facet = -1;
    Opposite<2> opposite;
    SlipAnchor pair;
  };
  // What lay opposite a facet at the start of the step.
  struct FacetAnchor {
    Opposite<4> opposite;
    FaceAnchor pair;
  };
  // Slip of a constraint while a visit gathers its nodes.
  struct SlipRows {
    std::vector<double> gradient;   // [direction][node][dim]
    std::vector<FaceSlips> face;    // [facet anchor], all facets in a row
    std::vector<std::size_t> first; // [facet]
  };
  // A pair of facets that cover a part of each other.
  struct Piece {
    int facet, candidate; // candidate -1: the rigid body
    MortarFacePair pair;  // dofs: secondary corners, primary corners; in the plane two of each
  };
  using Facing = std::vector<std::vector<int>>; // [facet]: candidates that face it, ascending

  template <std::size_t n>
  static double distance(const std::array<double, n>& a, const std::array<double, n>& b) {
    double square = 0;
    for (std::size_t k = 0; k < n; ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(square);
  }
  std::array<double, 4> measure(int facet, const std::vector<double>& X);
  void find_facets(const Mesh& mesh, const ContactSurface& secondary);
  void find_tangents(const std::vector<double>& X); // [facet][corner][dim]
  void anchor_on_round();
  void anchor_edges(const Facing& facing, const std::vector<double>& x);
  void anchor_faces(const Facing& facing, const std::vector<double>& x);
  void locate_anchors();
  FaceCorners secondary_face(int facet, const std::vector<double>& x) const {
    return corners_at<4, 3>(secondary_slots(facet), x);
  }
  FaceCorners primary_face(int candidate, const std::vector<double>& x) const {
    return corners_at<4, 3>(primary_slots(candidate), x);
  }
  std::array<Point2<double>, 2> secondary_edge(int facet, const std::vector<double>& x) const {
    return corners_at<2, 2>(secondary_slots(facet), x);
  }
  std::array<Point2<double>, 2> primary_edge(int candidate, const std::vector<double>& x) const {
    return corners_at<2, 2>(primary_slots(candidate), x);
  }

  FaceView view(int facet, int candidate, const std::vector<double>& x) const;
  bool opposed(int facet, int candidate, const std::vector<double>& x) const;
  // Whether an accepted candidate lies before this one.
  bool hidden(int facet, int candidate, const std::vector<int>& accepted, const std::vector<double>& x) const;
  bool share_a_node(int candidate, int other) const;
  double size_of(int facet, const std::vector<double>& x) const; // longest side
  // Whether a pair that is deep now was not so at the start of the step.
  bool came_through(int facet, int candidate) const;
  Facing facing_at(const std::vector<double>& x) const;
  // Dual functions on the facets that are covered as a whole, standard ones on the others.
  void choose_functions(const Facing& facing, const std::vector<double>& x);
  static void set_functions(Facet& facet, const std::array<std::array<double, 4>, 4>& phi);
  // Whether the node is active with these pairs.
  bool active(const Node& node, const std::vector<double>& u, const Presses& presses,
              const Facing& facing) const;
  std::vector<int> covering(int facet, const std::vector<double>& x, const Facing& facing) const;
  std::vector<Piece> pieces_at(const std::vector<double>& u, bool with_gradient,
                               std::vector<std::size_t>& first) const;
  FaceWeights weights_at(int facet, int candidate, const std::vector<double>& u) const;
  MortarFacePair pair_at(int facet, int candidate, const std::vector<double>& u, bool with_gradient) const;
  // Places of what lay opposite a facet at u, seen from a secondary node.
  template <std::size_t n, std::size_t d>
  std::array<std::array<double, d>, n> place_opposite(const Opposite<n>& opposite, int facet, int origin,
                                                      const std::vector<double>& u) const {
    if (!rigid()) return corners_from<n, d>(origin, opposite.slot.data(), u);
    std::array<std::array<double, d>, n> p;
    for (std::size_t b = 0; b < n; ++b) p[b] = obstacle_.place<d>(nodes(), facet, b, origin, u);
    return p;
  }
  // The secondary edge and the primary one of an anchor at u, seen from the secondary's first node.
  void place_anchor(const Anchor& anchor, const std::vector<double>& u, std::array<int, 4>& slots,
                    std::array<Point2<double>, 2>& s, std::array<Point2<double>, 2>& p) const;
  Slip slip_at(const Anchor& anchor, const std::vector<double>& u, std::array<int, 4>& slots) const;
  // The secondary facet and the primary one of an anchor at u, likewise.
  void place_anchor(int facet, const FacetAnchor& anchor, const std::vector<double>& u,
                    std::array<int, 8>& slots, FaceCorners& s, FaceCorners& p) const;
  // Of the constraint's slip: whether there is one, and where the slip is a function of more nodes than the
  // gap, these.
  bool slip_nodes(std::size_t number, NodePlaces& place_of) const;
  void visit_face_slips(const std::vector<double>& u, bool with_gradient, SlipRows& rows) const;
  // Slip and its gradient.
  void add_slip(std::size_t number, const std::vector<double>& u, NodePlaces& place_of, SlipRows& rows,
                Constraint& c) const;
  void add_plane_slip(const Node& owner, const std::vector<double>& u, NodePlaces& place_of, SlipRows& rows,
                      Constraint& c) const;
  // Weights of the corners of a facet in the mean over a node's constraint.
  std::array<double, 4> weights_of(const Incident& incident, const Node& owner) const;
  // Of an edge's or a face's slip: what a rigid body carries along has derivatives by its carrier.
  void visit_slip_block(int facet, std::span<const int> slots, std::span<const double> block,
                        const BlockVisitor& visitor) const;
  void visit_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                            const BlockVisitor& visitor) const;
  void visit_plane_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                  const BlockVisitor& visitor) const;
  static std::vector<FacetPoint> points_of(const MortarEdge& edge);
  static std::vector<FacetPoint> points_of(const MortarFace& face);
  Point3 place_of(const Facet& facet, const FacetPoint& point, const int* slot,
                  const std::vector<double>& u) const;
  // Weighted gaps of a whole facet to the rigid body, in the form of a pair without a primary, or with the
  // carrier of the obstacle in its place.
  MortarFacePair obstacle_gaps(int facet, const RigidObstacle& obstacle, const std::vector<double>& u) const;
  // Nodes behind those of the secondary facet in the gradient of a pair.
  std::span<const int> opposite_slots(int candidate) const {
    if (candidate < 0) return obstacle_.slots();
    return {primary_slots(candidate), corners_};
  }
  // [corner] nodal areas of a secondary facet at u.
  std::array<double, 4> areas_at(int facet, const std::vector<double>& u) const;

  int dim_;
  std::size_t corners_; // stored per facet
  Frame frame_;
  std::vector<Facet> facets_; // of the nodes owned by this rank
  std::vector<Node> owned_;
  std::size_t node_count_ = 0; // of the mesh on this rank
  std::vector<double> nodal_area_;
  Facing facing_;
  std::vector<std::vector<Anchor>> anchors_;            // [owned node] in the plane, empty without friction
  std::vector<std::vector<FacetAnchor>> facet_anchors_; // [facet] in space, likewise
  std::vector<Switches> switches_;                      // [facet] of its pairs
};

} // namespace impact
