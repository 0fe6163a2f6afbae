#pragma once
#include <algorithm>
#include <array>
#include <impact/contact/form.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/face_slip.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/kernel/mortar_face.hpp>
#include <impact/kernel/mortar_segment.hpp>
#include <utility>
#include <vector>

/// Mortar contact, one constraint per secondary node, evaluated by the owner of the node from all the facets
/// that meet there, whoever owns their cells: the mean gap g_A = (1/w_A) int Phi_A g dA_0 over all pairs of
/// facets (mortar_segment.hpp in the plane, mortar_face.hpp in space). What the primary does not cover counts
/// zero. Against a rigid body the gap is its distance, integrated by points on the secondary facets: exact
/// for a plane. Which primary facets a secondary facet faces, and which functions Phi are dual, is chosen by
/// update and stays fixed in between.
namespace impact {

class MortarForm : public ContactForm {
public:
  /// Mesh and layout must outlive the form. Throws UserError(data): more than two edges meet in a node.
  /// Collective.
  MortarForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings, Frame frame,
             const ContactSurface& secondary, const ContactSurface& primary);

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
    int changes = 0;                             // after so many changes of mind in this attempt
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
  // Nodes that lay opposite at the start of the step: of a primary facet, or, on a round rigid body, the
  // places of the secondary facet itself, which that body carries along.
  template <std::size_t corners, std::size_t dim> struct Opposite {
    std::array<PetscInt, corners> node{}; // global
    std::array<int, corners> slot{};      // in nodes(), -1: not there, or a place
    bool carried = false;
    std::array<std::array<double, dim>, corners> place{}; // where carried

    bool found() const { return carried || *std::min_element(slot.begin(), slot.end()) >= 0; }
    void locate(const ContactNodes& nodes) {
      for (std::size_t b = 0; b < corners; ++b) slot[b] = carried ? -1 : nodes.slot(node[b]);
    }
  };
  // What lay opposite an edge of the node at the start of the step.
  struct Anchor {
    int facet = -1;
    Opposite<2, 2> opposite;
    SlipAnchor pair;
  };
  // What lay opposite a facet at the start of the step.
  struct FacetAnchor {
    Opposite<4, 3> opposite;
    FaceAnchor pair;
  };
  // Nodes of a constraint, each once, in the order in which they came.
  struct NodePlaces {
    std::vector<int> node;

    std::size_t operator()(int n) {
      const auto place = static_cast<std::size_t>(std::find(node.begin(), node.end(), n) - node.begin());
      if (place == node.size()) node.push_back(n);
      return place;
    }
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

  void find_facets(const Mesh& mesh, const ContactSurface& secondary);
  void find_tangents(const std::vector<double>& X); // [facet][corner][dim]
  void anchor_on_round(const std::vector<double>& x);
  void anchor_edges(const Facing& facing, const std::vector<double>& x);
  void anchor_faces(const Facing& facing, const std::vector<double>& x);
  void locate_anchors();
  // Corners of a facet at coordinates, or as seen from the first corner of a secondary facet.
  FaceCorners secondary_face(int facet, const std::vector<double>& x) const;
  FaceCorners primary_face(int candidate, const std::vector<double>& x) const;
  std::array<Point2<double>, 2> secondary_edge(int facet, const std::vector<double>& x) const;
  std::array<Point2<double>, 2> primary_edge(int candidate, const std::vector<double>& x) const;
  const int* secondary_slots(int facet) const;
  const int* primary_slots(int candidate) const;
  int primary_corners(int candidate) const;
  // Both facets of a pair at the displacement u, seen from the secondary's first corner.
  void place_edges(int facet, int candidate, const std::vector<double>& u, std::array<Point2<double>, 2>& s,
                   std::array<Point2<double>, 2>& p) const;
  void place_faces(int facet, int candidate, const std::vector<double>& u, FaceCorners& s,
                   FaceCorners& p) const;

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
  MortarFacePair pair_at(int facet, int candidate, const std::vector<double>& u, bool with_gradient) const;
  // The secondary edge and the primary one of an anchor at u, seen from the secondary's first node.
  // Places of what lay opposite, seen from a secondary node.
  template <std::size_t corners, std::size_t dim>
  std::array<std::array<double, dim>, corners> place_opposite(const Opposite<corners, dim>& opposite,
                                                              int facet, int origin,
                                                              const std::vector<double>& u) const {
    std::array<std::array<double, dim>, corners> p;
    for (std::size_t b = 0; b < corners; ++b)
      if (opposite.carried && carried())
        p[b] = carrier_.place<dim>(nodes(), facet, static_cast<int>(b), origin, u);
      else if (!opposite.carried)
        p[b] = nodes().place<dim>(opposite.slot[b], origin, u);
      else
        for (std::size_t k = 0; k < dim; ++k) {
          const std::size_t i = dim * static_cast<std::size_t>(origin) + k;
          p[b][k] = opposite.place[b][k] + pose_.moved[k] - nodes().X[i] - u[i];
        }
    return p;
  }
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
  std::array<Point3, 2> plane_tangents() const; // of one with mass: in the reference configuration
  void add_plane_slip(const Node& owner, const std::vector<double>& u, NodePlaces& place_of, SlipRows& rows,
                      Constraint& c) const;
  // Of an edge's or a face's slip: the derivatives by what lay opposite become those by the carrier.
  void visit_slip_block(int facet, bool carried_along, std::span<const int> slots,
                        std::span<const double> block, const BlockVisitor& visitor) const;
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
    if (candidate < 0) return carrier_.slots();
    return {primary_slots(candidate), corners_};
  }
  // [corner] nodal areas of a secondary facet at u.
  std::array<double, 4> areas_at(int facet, const std::vector<double>& u) const;

  int dim_;
  std::size_t corners_; // stored per facet
  ContactSettings settings_;
  Frame frame_;
  std::vector<Facet> facets_; // of the nodes owned by this rank
  std::vector<Node> owned_;
  std::size_t node_count_ = 0; // of the mesh on this rank
  std::vector<double> nodal_area_;
  Facing facing_;
  std::vector<std::vector<Anchor>> anchors_;            // [owned node] in the plane, empty without friction
  std::vector<std::vector<FacetAnchor>> facet_anchors_; // [facet] in space, likewise
  std::vector<int> switches_;                           // [facet] in this attempt
};

} // namespace impact
