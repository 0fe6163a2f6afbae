#pragma once
#include <array>
#include <impact/contact/form.hpp>
#include <impact/contact/settings.hpp>

/// Gauss-point segment-to-segment contact in the plane: one gap constraint at every point of the secondary
/// facets, to the nearest place of the primary surface or to a rigid plane (theory.md, contact).
///
/// Where the surface has a kink, the nearest edge changes from one side of a vertex to the other and with it
/// the direction of the force, so that Newton's method may jump to and fro. `update` therefore ties every
/// point near the surface to its edge, continued straight beyond the ends, until the next call, and lets go
/// only when the point has left the edge by more than an overlap. The tie begins afresh with every attempt of
/// a step, so it is no state.
namespace impact {

class GaussPointForm : public ContactForm {
public:
  /// `primary` is empty against the rigid body of the settings. Settings without automatic values;
  /// `hold_gap`: by which a held edge's gap may differ from the nearest edge's. Collective.
  GaussPointForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings, Frame frame,
                 ContactSurface secondary, const ContactSurface& primary, double hold_gap);

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
  // A point of a secondary facet and what it faces.
  struct Point {
    int facet = 0, index = 0;      // secondary facet of this rank; facet * points + point
    int node_count = 4;            // 4, or 2 against a rigid body that is no mesh
    std::array<int, 4> node{};     // into nodes(): secondary 0, 1, primary 0, 1
    std::array<double, 2> shape{}; // secondary shape functions
    Foot<double> foot;
    PrimaryEdge<double> edge;
  };
  // The edge, by its global nodes, that a point is tied to.
  struct Hold {
    std::array<PetscInt, 2> edge = {-1, -1};
    int switches = 0; // in this attempt, while it carried a pressure
  };

  // What a point lay opposite of at the start of the step.
  struct Anchor {
    bool valid = false;
    std::array<PetscInt, 2> node = {-1, -1}; // of the primary edge, global
    std::array<int, 2> slot = {-1, -1};      // in nodes(), -1: not there
    SlipAnchor pair;
    double start = 0;       // its slip then, where the gap is not along the secondary's own normal
    Point2<double> place{}; // of the point itself, against a rigid plane
  };

  void locate_anchors();
  // A constraint's nodes with those of its anchor, and the derivatives over them.
  struct Workspace {
    std::array<int, 6> node{};
    std::array<double, 12> gradient{}, slip_gradient{};
    std::array<double, 144> hessian{}, slip_hessian{};
  };
  // Visits the points that face something: visitor(constraint without its gap's gradient, point, workspace).
  template <class Visitor>
  void visit_points(const std::vector<double>& u, bool second, Visitor&& visitor) const;
  void add_slip(const Point& point, const std::vector<double>& u, const Point2<double>& x_s, bool second,
                Workspace& w, Constraint& c) const;
  Point on_facet(int facet) const; // which faces nothing yet
  void hold_edges(const std::vector<double>& x, const Presses& presses);
  // Whether the point at x faces the rigid body.
  static bool face_obstacle(const RigidObstacle& obstacle, const Point2<double>& x,
                            const Point2<double>& normal, Point& point);
  // What an obstacle with mass adds to a constraint: its nodes behind the secondary ones.
  void add_carrier(Workspace& w, Constraint& c) const;
  CarriedFunction carried_gap_of(const Point& point, const std::vector<double>& u) const;
  // What the point at x faces: its held edge, else the nearest, else one that it passed in this step.
  bool face(const Point2<double>& x, const Point2<double>& normal, const std::vector<double>& coordinates,
            const Hold& hold, Point& point) const;
  // Whether a surface that may meet itself could touch here, by the normals and the depth; true for others.
  bool may_touch(const Foot<double>& foot, const Point2<double>& normal, double depth) const;
  bool face_nearest(const Point2<double>& x, const Point2<double>& normal,
                    const std::vector<double>& coordinates, Point& point) const;
  bool face_held(const Point2<double>& x, const Point2<double>& normal,
                 const std::vector<double>& coordinates, const Hold& hold, Point& point) const;
  bool face_passed(const Point2<double>& x, const Point2<double>& normal,
                   const std::vector<double>& coordinates, Point& point) const;
  void sharpen(const std::vector<double>& u, Point& point) const;
  static void stand_on(const PrimaryEdge<double>& edge, const Foot<double>& foot, const int* p, Point& point);
  PrimaryEdge<double> primary_edge(int candidate, const std::vector<double>& coordinates) const;

  ContactSettings settings_;
  Frame frame_;
  ContactSurface secondary_;
  SurfacePoints points_;
  std::vector<double> nodal_area_;
  std::vector<Hold> holds_;     // [secondary facet][point]
  std::vector<Anchor> anchors_; // [secondary facet][point], empty without friction
  double hold_gap_;
};

} // namespace impact
