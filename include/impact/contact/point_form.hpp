#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <impact/contact/form.hpp>
#include <impact/contact/line_of_sight.hpp>
#include <impact/kernel/face_ray.hpp>
#include <impact/kernel/facet_slip.hpp>
#include <impact/kernel/mortar_segment.hpp>
#include <impact/math/index.hpp>
#include <memory>
#include <optional>

/// Contact at Gauss points of the secondary facets: one gap constraint at every point, to what lies opposite
/// on the primary surface or to a rigid body (theory.md, contact). Here stands what edges and faces have in
/// common; `Geometry` brings the rest (edge_points.hpp, ray_points.hpp):
///   dim, nodes                of a facet
///   Point                     a place of a facet, whose `weights` are those of its nodes
///   Seen                      what a point faces: a candidate, -1 for none, and the foot on it
///   View, Outline             of those that look along their normal (line_of_sight.hpp)
///   curved                    whether normals differ along a facet
/// and functions of points, of which Facet says where their secondary facet stands.
///
/// `update` ties every point near the surface to what it faces, continued beyond its sides, until the next
/// call (form.hpp). The tie begins afresh with every attempt of a step, so it is no state.
namespace impact {

using ShapeValues = std::array<double, 4>; ///< weights of a facet's corners in a place
/// The points of the secondary facets: their places, and reference areas.
template <class Point> struct FormPoints {
  int per_facet = 0;
  std::vector<Point> shape;   ///< [facet][point]
  std::vector<double> weight; ///< [facet][point] 0: no such point
  std::vector<int> nodes;     ///< [facet] different ones
  std::vector<double> size; ///< [facet] reference area; of curved facets [facet][point] over that of the rule

  std::size_t index(int facet, int point) const {
    return static_cast<std::size_t>(facet * per_facet + point);
  }
  /// The same areas, lumped at the corners, of which a facet has no more than points.
  void move_to_corners() requires std::same_as<Point, ShapeValues> {
    for (std::size_t first = 0; first < weight.size(); first += static_cast<std::size_t>(per_facet)) {
      ShapeValues lumped{};
      for (std::size_t q = 0; q < static_cast<std::size_t>(per_facet); ++q)
        for (std::size_t a = 0; a < lumped.size(); ++a) lumped[a] += weight[first + q] * shape[first + q][a];
      for (std::size_t a = 0; a < static_cast<std::size_t>(per_facet); ++a) {
        weight[first + a] = lumped[a];
        shape[first + a] = {};
        shape[first + a][a] = 1;
      }
    }
  }
};

/// What the geometries of straight facets have in common.
struct StraightPoints {
  static constexpr bool curved = false;
  using Point = ShapeValues;
  static const ShapeValues& weights(const ShapeValues& point) { return point; }
  /// None negative, for means at the nodes.
  static const ShapeValues& spread(const ShapeValues& point) { return point; }
  /// Most that the weights of a facet's nodes come to without their signs, a little beyond its sides.
  static constexpr double weight_sum = 1.05;
  /// The place of a node.
  static ShapeValues node(std::size_t a) {
    ShapeValues shape{};
    shape[a] = 1;
    return shape;
  }
};

template <class Geometry> class PointForm : public ContactForm {
public:
  static constexpr std::size_t dim = Geometry::dim, width = Geometry::nodes, dofs = 2 * dim * width;
  using Place = std::array<double, dim>;
  using Nodes = std::array<Place, width>;
  using Point = typename Geometry::Point;
  using Seen = typename Geometry::Seen;
  /// A row, or a matrix, over the dofs of (secondary nodes, primary nodes).
  using Row = std::array<double, dofs>;
  using Matrix = std::array<double, dofs * dofs>;

  explicit PointForm(const FormRequest& request);

  bool overdetermined() const override { return dim == 3; }
  std::pair<StateRow, std::size_t> constraint_row(const std::string& name, int components) const override;
  void anchor(Vec u) override;
  PairSearch::Outcome update(Vec u, const ConstraintFilter& presses) override;
  NodePairs couplings() const override;
  void visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
             const ConstraintFilter& wanted) const override;
  void visit_curvature(const ContactValues& u, const CurvatureFactors& factors,
                       const BlockVisitor& visitor) const override;
  void visit_meetings(const ContactValues& u, const MeetingVisitor& visitor) const override;
  double sight(int constraint) const override { return depth(constraint / points_.per_facet); }
  const std::vector<double>& nodal_area() const override { return nodal_area_; }
  void visit_overlaps(const ContactValues& x, const OverlapVisitor& visitor) const override;

private:
  void turn_slip(const ContactValues& u) override;
  void release() override { std::fill(holds_.begin(), holds_.end(), Hold()); }
  // What the points of a secondary facet that look around share, made by the first one that does; and what
  // all facets share at these coordinates.
  struct Surroundings {
    struct Near {
      int candidate;
      const FacetBall<Place>* ball;
      std::optional<typename Geometry::Outline> outline; // once a line of sight meets the ball
    };
    std::optional<typename Geometry::View> view;
    std::vector<Near> near;              // candidates in sight
    std::vector<FacetBall<Place>> balls; // of the primary facets
  };
  // A secondary facet at coordinates, and at the displacement seen from its first node, where that is known:
  // differences of displacements keep the digits that coordinates lose, and a penalty makes a pressure of
  // what is lost.
  struct Facet {
    int number = 0;
    Nodes node{};
    Place normal{}; // of a straight one
    Surroundings* around = nullptr;
    const ContactValues* u = nullptr;
    Nodes from{};
  };
  // What a point is tied to: a candidate by its place in the list, -1: not there, and by its nodes.
  struct Hold {
    GlobalFacet node = {-1};
    int candidate = -1;
    Switches switches;
  };
  // What a point lay opposite of at the start of the step.
  struct Anchor {
    bool valid = false;
    Opposite opposite{};
    Opening<width> opening{};
    std::array<double, dim> start{}; // its components then, in the frame of the facet
    Lean lean = upright<dim>();
  };
  // Both facets of an anchor at a displacement, seen from the secondary's first corner.
  struct SlipPlaces {
    Nodes s{}, p{};
  };
  struct Workspace {
    NodePlaces place;
    std::array<std::size_t, 2 * width> of_facets; // places of the nodes of both
    std::vector<double> gradient, slip_gradient;  // [node][dim], [direction][node][dim]
    // Directions of slip, and the tangents that they were made of: those of a facet, or of a point.
    const TangentRows<dim, width>* tangents = nullptr;
    Nodes secondary{};
    std::optional<SlipDirections<dim, width>> directions;
  };

  // `around`: of the facet before, where points look around; u: where x is that of a displacement.
  Facet facet_at(int number, const ContactValues& x, Surroundings* around = nullptr,
                 const ContactValues* u = nullptr) const {
    const int* slot = secondary_slots(number);
    Facet facet;
    facet.number = number;
    facet.around = around;
    if (around != nullptr) around->view.reset();
    facet.node = corners_at<Nodes>(slot, x);
    if constexpr (!Geometry::curved) facet.normal = Geometry::normal(facet.node);
    facet.u = u;
    if (u != nullptr) facet.from = corners_from<Nodes>(slot[0], slot, *u);
    return facet;
  }
  static Place normal_at(const Facet& facet, const Point& point) {
    if constexpr (Geometry::curved) return Geometry::normal(facet.node, point);
    return facet.normal;
  }
  static Place place_on(const Nodes& node, const Point& point) {
    const auto& shape = Geometry::weights(point);
    Place x{};
    for (std::size_t k = 0; k < dim; ++k) {
      x[k] = shape[0] * node[0][k] + shape[1] * node[1][k];
      for (std::size_t a = 2; a < width; ++a) x[k] += shape[a] * node[a][k];
    }
    return x;
  }
  static std::array<double, 3> in_space(const Place& x) {
    std::array<double, 3> y{};
    std::copy(x.begin(), x.end(), y.begin());
    return y;
  }
  std::span<const double> share_of(std::size_t number, int facet) const {
    return {Geometry::weights(points_.shape[number]).data(), at(points_.nodes[at(facet)])};
  }
  // What all points faced at the places `at`, for the visits that a step makes there: found once where no
  // ties of iterates change it.
  struct Views {
    ContactValues at;
    std::vector<Seen> seen; // [secondary facet][point]
  };

  // call(facet at x, the place of the displacement u, number, anchor) of each point.
  template <class Call> void for_each_anchor(const ContactValues& x, const ContactValues& u, Call&& call);
  // Of the directions of slip on a rigid body.
  Lean lean_on(const Facet& facet, std::size_t number, const RigidObstacle& obstacle) const;
  void look_around(const Facet& facet, const ContactValues& x) const;
  // Of Geometry. What lies before a point or behind it: the nearest that may be in contact, for facets with
  // surroundings.
  Seen nearest(const Facet& facet, const Point& point, const ContactValues& x) const;
  // What the point is tied to; false where an iterate went too far astray.
  bool held(const Facet& facet, const Point& point, const ContactValues& x, const Hold& hold,
            Seen& seen) const;
  // What it came through within this step, however deep, where nothing else is seen.
  Seen passed(const Facet& facet, const Point& point, const ContactValues& x) const;
  Seen face(const Facet& facet, const Point& point, const ContactValues& x, const Hold& hold) const {
    Seen seen;
    if (hold.candidate >= 0 && held(facet, point, x, hold, seen)) return seen;
    seen = nearest(facet, point, x);
    return seen.candidate >= 0 ? seen : passed(facet, point, x);
  }
  Seen look(const Facet& facet, const Point& point, int candidate, const ContactValues& x) const;
  bool may_touch(const Facet& facet, const Point& point, const Seen& seen) const;
  // How deep a point is seen that did not come through a surface within the step. Explicit steps move bodies
  // by far less than a facet: what is deeper lies behind another part of a body. Of a facet that came free no
  // more is seen than a penalty lets in, which is little beside what bodies move in a few steps: it may be
  // seen from behind, and keeps nothing by which a jump could be told (78''). What lies opposite at the start
  // of a step does not depend on the last one.
  double depth(int facet) const {
    const double seen = search_.depth(facet);
    const double length = secondary_.length[at(facet)];
    if (settings_.iterated) return seen;
    if (secondary_.at_start.empty() || secondary_.at_start[at(facet)] >= 0) return std::min(seen, length / 2);
    return std::min({seen, length / 4, anchoring_ ? length : std::max(length / 16, 4 * way())});
  }
  // Whether one part of a surface may lie behind another one.
  bool folded() const { return search_.meets_itself() || settings_.exposed; }
  // With all digits.
  void sharpen(int facet, std::size_t number, const ContactValues& u, Seen& seen) const;
  // Of points that look along their normal: the point and what it sees.
  auto ray_of(const Facet& facet, std::size_t number, const Seen& seen) const;
  // d(gap) and its second variation times a factor, over the dofs of both facets.
  Row gap_gradient(const Facet& facet, std::size_t number, const Seen& seen) const;
  void add_gap_hessian(const Facet& facet, std::size_t number, const Seen& seen, double factor,
                       Matrix& hessian) const;

  void tie(const ContactValues& x, const ConstraintFilter& presses);
  bool is_far_off(int facet, const Nodes& node, const RigidObstacle& obstacle,
                  const ConstraintFilter& wanted) const;
  void anchor_slip(Vec u);
  void find_anchors(const ContactValues& moved);
  void locate_anchors();
  void locate_holds();
  // Where stands what curved facets have for each point.
  static std::size_t own_place(int facet, std::size_t number) {
    return Geometry::curved ? number : at(facet);
  }
  const TangentRows<dim, width>& tangents(int facet, std::size_t number) const {
    return tangents_[own_place(facet, number)];
  }
  bool slip_places(int facet, std::size_t number, const ContactValues& u, SlipPlaces& places) const;
  void add_slip(int facet, const SlipPlaces& places, const ContactValues& u, bool with_gradient, Workspace& w,
                Constraint& c) const;
  void add_facet_slip(int facet, const SlipPlaces& places, bool with_gradient, Workspace& w,
                      Constraint& c) const; // no plane
  void add_gap_gradient(const Facet& facet, const Seen& seen, const CarriedFunction& to_obstacle,
                        Workspace& w, Constraint& c) const;
  // visitor(constraint, facet, what is seen, gap to the obstacle) for the points that face something and are
  // wanted.
  template <class Visitor>
  void visit_points(const ContactValues& u, Visitor&& visitor, const ConstraintFilter& wanted = {}) const;

  ContactSurface secondary_;
  Frame frame_;
  FormPoints<Point> points_;
  std::vector<TangentRows<dim, width>> tangents_; // [secondary facet], of curved ones [point]; with friction
  std::vector<double> nodal_area_;
  std::vector<Hold> holds_;         // [secondary facet][point]
  std::vector<Anchor> anchors_;     // [secondary facet][point], empty without friction
  std::vector<double> anchored_at_; // displacement of nodes()
  mutable Views views_;
  double hold_gap_;
  bool anchoring_ = false;
};

} // namespace impact
