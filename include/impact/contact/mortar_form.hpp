#pragma once
#include <array>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/form.hpp>
#include <impact/contact/vertices.hpp>
#include <impact/kernel/facet_slip.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/kernel/mortar_segment.hpp>
#include <vector>

/// Mortar contact, one constraint per secondary node, evaluated by the owner of the node from all the facets
/// that meet there, whoever owns their cells: the mean gap g_A = (1/w_A) int Phi_A g dA_0 (80') over all
/// pairs of facets (mortar_segment.hpp in the plane, mortar_face.hpp in space). What the primary does not
/// cover counts zero. Against a rigid body the gap is its distance, integrated by points on the secondary
/// facets: exact for a plane. Facets of second order are cut into straight ones (facet_parts.hpp), with a
/// constraint for each of their nodes: facets and candidates below are those parts. Which primary facets a
/// secondary facet faces, and which functions Phi are dual, is chosen by update and stays fixed in between;
/// so does by how much curved facets lie before their parts (mortar_bulge.cpp).
namespace impact {

class MortarForm : public ContactForm {
public:
  /// Throws UserError(data): more than two edges meet in a node. Collective.
  explicit MortarForm(const FormRequest& request);

  std::pair<StateRow, std::size_t> constraint_row(const std::string& name, int components) const override;
  void anchor(Vec u) override;
  void follow_slip(const ContactValues& u) override;
  PairSearch::Outcome update(Vec u, const ConstraintFilter& presses) override;
  NodePairs couplings() const override;
  void visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
             const ConstraintFilter& wanted) const override;
  void visit_curvature(const ContactValues& u, const CurvatureFactors& factors,
                       const BlockVisitor& visitor) const override;
  void visit_meetings(const ContactValues& u, const MeetingVisitor& visitor) const override;
  const std::vector<double>& nodal_area() const override { return nodal_area_; }
  const ContactNodes& vertices() const override { return vertices_.empty() ? nodes() : places_; }
  void visit_overlaps(const ContactValues& x, const OverlapVisitor& visitor) const override;

private:
  void release() override;
  void turn_slip(const ContactValues& u) override;
  // A point of the integrals over the gap to a rigid body: weights of the facet's corners in its place, and
  // Phi_a dA_0.
  struct FacetPoint {
    std::array<double, 4> shape{}, weight{};
  };
  struct Facet {
    GlobalFacet node{};                          // global, of the facet that was cut
    int corners = 2;                             // different ones, and functions
    std::array<int, 4> owned = {-1, -1, -1, -1}; // [function] place in owned_, -1: another rank's, or none
    MortarEdge edge;                             // in the plane
    MortarFace face;                             // in space
    FaceMap map;                                 // in space, with friction
    std::vector<FacetPoint> points;              // against a rigid body
    MortarWeights onto; // likewise: D = M, of the facet on its own place at the start
    std::array<std::array<double, 4>, 4> dual{}; // Phi where the whole half is covered,
    std::array<double, 4> slid{};                // int Phi over what lay opposite at the start of the step,
    std::array<double, 4> growth = {1, 1, 1, 1}; // and what it is where the slip was followed last, over that
    std::array<Lean, 4> lean{};                  // [function] of the directions of slip
    bool whole = false;                          // as it is taken to be,
    Switches changes;                            // from one kind to the other

    const MortarEdge& reference(const EdgeCorners&) const { return edge; }
    const MortarFace& reference(const FaceCorners&) const { return face; }
    // The one direction of an edge needs no map.
    static TangentRows<2, 2> tangents(const EdgeCorners&) { return {{{-1, 1}}}; }
    const TangentRows<3, 4>& tangents(const FaceCorners&) const { return map.row; }
  };
  struct Incident {
    int facet, corner;                              // of first order; else number of the node's function
    std::array<std::array<double, 2>, 2> turn = {}; // with friction in space: the node's tangents in it
  };
  struct Node {
    int local = 0; // in the mesh
    PetscInt global = 0;
    int slot = 0; // in nodes()
    std::vector<Incident> facets;
    double weight = 0;
    double bulge = 0;    // its gap for curved facets less that for their parts,
    Switches bulges;     // which changes in an attempt,
    bool bulged = false; // and is known
  };
  // What lay opposite a facet at the start of the step. Weights of edges are over those of their nodes.
  struct Anchor {
    Opposite opposite; // none of a rigid body, which carries along the places of the secondary facet itself
    MortarWeights weights;
    std::array<std::array<double, 3>, 4> start{}; // components of the openings of Phi_a at the start
  };
  // Of each function Phi_a: components of the slip, and their derivatives by the dofs of MortarPair.
  struct FacetSlips {
    std::array<Tangential, 4> value{};
    std::array<std::array<std::array<double, 24>, 2>, 4> gradient{};
  };
  // Slip of the facets, and of a constraint while a visit gathers its nodes.
  struct SlipRows {
    std::vector<std::vector<FacetSlips>> facet; // [facet][anchor]
    std::vector<double> gradient;               // [direction][node][dim]
  };
  // What covers a part of a secondary facet.
  struct Piece {
    int candidate; // -1: the rigid body
    MortarPair pair;
  };
  using Pieces = std::vector<std::vector<Piece>>; // [facet]
  using Facing = std::vector<std::vector<int>>;   // [facet]: candidates that face it, ascending

  // call(Corners) with a value of the type of the corners: of edges in the plane, of faces in space.
  template <class Call> auto by_dimension(Call&& call) const {
    return dim_ == 2 ? call(EdgeCorners()) : call(FaceCorners());
  }
  // call(secondary corners, primary corners) of a pair at coordinates x; or at a displacement u seen from the
  // secondary's first node, also of a facet and what lay opposite it at the start of the step.
  template <class Call> auto at_pair(int facet, int candidate, const ContactValues& x, Call&& call) const {
    return by_dimension([&]<class Corners>(const Corners&) {
      return call(corners_at<Corners>(secondary_slots(facet), x),
                  corners_at<Corners>(primary_slots(candidate), x));
    });
  }
  template <class Call> auto from_pair(int facet, int candidate, const ContactValues& u, Call&& call) const {
    const int* s = secondary_slots(facet);
    return by_dimension([&]<class Corners>(const Corners&) {
      return call(corners_from<Corners>(s[0], s, u),
                  corners_from<Corners>(s[0], primary_slots(candidate), u));
    });
  }
  template <class Call>
  auto from_anchor(int facet, const Anchor& anchor, const ContactValues& u, Call&& call) const {
    const int* s = secondary_slots(facet);
    return by_dimension([&]<class Corners>(const Corners&) {
      return call(corners_from<Corners>(s[0], s, u), opposite<Corners>(anchor.opposite, facet, u));
    });
  }

  std::array<double, 4> measure(int facet, const std::vector<double>& X); // [vertex][dim] of the cut facet
  void set_obstacle_points(Facet& facet) const;
  void find_facets(const Mesh& mesh, const ContactSurface& secondary);
  const FacetParts& cut_of(int facet) const {
    return cuts_.of(facets_[static_cast<std::size_t>(facet)].node.data());
  }
  const FacetParts::Part& part_of(int facet) const {
    return cut_of(facet).parts[static_cast<std::size_t>(facet % parts_)];
  }
  // [node][dim] of the facet that is cut to [vertex][dim]
  std::vector<double> vertices_of(int facet, const double* X) const;
  // Values at the vertices, of which all that is private here is a function.
  const ContactValues& at_vertices(const ContactValues& of_nodes, ContactValues& store) const {
    return vertices_.from(of_nodes, static_cast<std::size_t>(dim_), store);
  }
  // To be called when nodes() or what lay opposite are other ones.
  void find_vertices();
  void find_tangents(const std::vector<double>& X); // [facet][corner][dim]
  bool found(const Anchor& anchor) const { return rigid() || anchor.opposite.found(); }
  // What a facet sees of a function, int Phi_a, and the normal force of a unit pressure there.
  struct Seen {
    double cover = 0;
    Point3 force{};
  };
  using FacetNormals = std::vector<std::array<Seen, 4>>; // [facet][function]
  // Adds what the rigid body, or a candidate, covers of the functions.
  void add_normal(int facet, const RigidObstacle& obstacle, const ContactValues& u,
                  FacetNormals& normals) const;
  void add_normal(int facet, int candidate, const ContactValues& x, const std::array<double, 4>& cover,
                  FacetNormals& normals) const;
  void anchor_facet(int facet, const Facing& facing, const ContactValues& x, FacetNormals& normals);
  // Friction of a node acts across its normal force.
  void lean(const ContactValues& x, const FacetNormals& normals);

  FacetView view(int facet, int candidate, const ContactValues& x) const;
  double opposition(int facet, int candidate, const ContactValues& x) const; // of their normals, at most 1
  // Whether an accepted candidate lies before this one.
  bool hidden(int facet, int candidate, const std::vector<int>& accepted, const ContactValues& x) const;
  bool is_beside(int facet, int candidate, const ContactValues& x) const;
  bool adjoin(int candidate, int other) const;             // their facets share a node
  double size_of(int facet, const ContactValues& x) const; // longest side
  // Whether a pair that is deep now was not so at the start of the step.
  bool came_through(int facet, int candidate) const;
  Facing facing_at(const ContactValues& x) const;
  // Dual functions on the facets that are covered as a whole, standard ones on the others.
  // Returns the facets whose functions change.
  std::vector<int> choose_functions(const Facing& facing, const ContactValues& x);
  static void set_functions(Facet& facet, const std::array<std::array<double, 4>, 4>& phi);
  std::array<double, 4> of_functions(int facet, const std::array<double, 4>& of_corners) const;
  // Adds int Phi_a (g - g_parts) over what the candidate covers, g the gap of the facets of second order.
  void add_bulge(int facet, int candidate, const ContactValues& x, std::array<double, 4>& sum) const;
  // Takes the curved facets for the gaps as they are now: in an attempt at first, then where that changes
  // gaps.
  void bulge(const ContactValues& u, const ContactValues& x, const ConstraintFilter& presses);
  // Whether the node is active with these pairs.
  bool active(const Node& node, const ContactValues& u, const ConstraintFilter& presses,
              const Facing& facing) const;
  std::vector<int> covering(int facet, const ContactValues& x, const Facing& facing) const;
  MortarPair pair_at(int facet, int candidate, const ContactValues& u, bool with_gradient) const;
  Pieces pieces_at(const ContactValues& u, bool with_gradient) const;
  // A node of whose weight less faces something bears nothing. Where a body comes to lie over an end of the
  // other one that is next to nothing at first, and no pressure there closes a gap in a step with inertia.
  static constexpr double least_cover = 0.01;
  // What rounding covers of a weight where edges lie on each other.
  static constexpr double rounded_part = 1e-10;
  static bool is_covered(const Node& owner, const Pieces& pieces);
  // Of the constraint's slip: whether there is one, and where the slip is a function of more nodes than the
  // gap, these.
  bool slip_nodes(const Node& owner, NodePlaces& place_of) const;
  template <std::size_t dim, std::size_t width>
  static FacetSlips facet_slips(const FacetNodes<dim, width>& s, const FacetNodes<dim, width>& p,
                                const TangentRows<dim, width>& tangents, const std::array<Lean, 4>& lean,
                                const Anchor& anchor, bool with_gradient);
  SlipRows slips_at(const ContactValues& u, bool with_gradient) const;
  // What a facet's slip in direction e adds to the node's in direction a.
  double slip_part(const Incident& incident, const Node& owner, std::size_t a, std::size_t e) const {
    return dim_ == 2 ? 1 : incident.turn[a][e] / owner.weight;
  }
  // Slip and its gradient.
  void add_slip(const Node& owner, const ContactValues& u, NodePlaces& place_of, SlipRows& rows,
                Constraint& c) const;
  // Weights of the corners of a facet in the mean over a node's constraint.
  std::array<double, 4> weights_of(const Incident& incident, const Node& owner) const;
  void visit_facet_slip_curvature(int facet, const std::array<Tangential, 4>& factor, const ContactValues& u,
                                  const BlockVisitor& visitor) const;
  void visit_slip_curvature(const ContactValues& u, const CurvatureFactors& factors,
                            const BlockVisitor& visitor) const;
  void visit_plane_slip_curvature(const ContactValues& u, const CurvatureFactors& factors,
                                  const BlockVisitor& visitor) const;
  std::vector<FacetPoint> points_of(const Facet& facet) const;
  Point3 place_of(const Facet& facet, const FacetPoint& point, const int* slot, const ContactValues& u) const;
  // Weighted gaps of a whole facet to the rigid body, in the form of a pair without a primary, or with the
  // carrier of the obstacle in its place.
  MortarPair obstacle_gaps(int facet, const RigidObstacle& obstacle, const ContactValues& u) const;
  // [corner] nodal areas of a secondary facet at u.
  std::array<double, 4> areas_at(int facet, const ContactValues& u) const;

  int dim_;
  FacetCuts cuts_;
  std::size_t corners_; // stored per part
  Vertices vertices_;
  ContactNodes places_; // of the vertices, without their exchange; unused where all of them are nodes
  Frame frame_;
  std::vector<Facet> facets_; // of the nodes owned by this rank
  std::vector<Node> owned_;
  std::vector<double> nodal_area_; // [node] of the mesh on this rank
  Facing facing_;
  std::vector<std::vector<Anchor>> anchors_; // [facet], empty without friction
  std::vector<Switches> switches_;           // [facet] of its pairs
};

} // namespace impact
