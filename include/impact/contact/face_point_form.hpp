#pragma once
#include <array>
#include <impact/contact/form.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/face_ray.hpp>
#include <impact/kernel/face_slip.hpp>

/// Gauss-point contact in space: one gap constraint at every point of the secondary faces, along the face's
/// normal to the triangle of the primary surface that lies there (face_ray.hpp), or to a rigid body
/// (theory.md, contact).
///
/// `update` ties every point near the surface to its triangle, continued flat beyond its sides, until the
/// next call, and lets go only when the foot has left the triangle by more than an overlap: across a kink of
/// the surface Newton's method would jump to and fro. The tie begins afresh with every attempt of a step, so
/// it is no state.
namespace impact {

class FacePointForm : public ContactForm {
public:
  /// `primary` is empty against the rigid body of the settings. Settings without automatic values;
  /// `hold_gap`: by which a held triangle's gap may differ from the nearest one's. Throws UserError(usage):
  /// a number of points out of range. Collective.
  FacePointForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings,
                ContactSurface secondary, const ContactSurface& primary, double hold_gap);

  bool overdetermined() const override { return true; }
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
  // A triangle of a candidate, as a point sees it.
  struct Seen {
    int candidate = -1, triangle = 0; // -1: none
    RayFoot foot;
  };
  // The triangle that a point is tied to; the candidate is its place in the list, -1: not there.
  struct Hold {
    std::array<PetscInt, 4> face = {-1, -1, -1, -1};
    int triangle = 0, candidate = -1;
    int switches = 0; // in this attempt, while it carried a pressure
  };
  // What a point lay opposite of at the start of the step.
  struct Anchor {
    bool valid = false;
    std::array<PetscInt, 4> node = {-1, -1, -1, -1}; // of the primary face, global
    std::array<int, 4> slot = {-1, -1, -1, -1};      // in nodes(), -1: not there
    FaceAnchor pair;                                 // in its first function
    FaceCorners place{}; // of the secondary face then, which a rigid body carries along
  };
  struct Workspace {
    std::vector<int> node;
    std::vector<double> gradient, slip_gradient; // [node][3], [direction][node][3]
    std::size_t place(int slot);
  };

  std::size_t index(int facet, int point) const {
    return static_cast<std::size_t>(facet * per_facet_ + point);
  }
  void make_points();
  const int* secondary_slots(int facet) const;
  const int* primary_slots(int candidate) const;
  int primary_corners(int candidate) const;
  FaceCorners secondary_face(int facet, const std::vector<double>& x) const;
  FaceCorners primary_face(int candidate, const std::vector<double>& x) const;
  // Both at the displacement u, seen from the secondary's first corner.
  FaceCorners secondary_from_corner(int facet, const std::vector<double>& u) const;
  FaceCorners primary_from_corner(int facet, int candidate, const std::vector<double>& u) const;
  Point3 point_at(const std::array<double, 4>& shape, int facet, const std::vector<double>& u) const;
  // Whether the two may be in contact, by normals and depth.
  bool may_touch(const Seen& seen, int facet, const std::array<double, 4>& shape) const;
  Seen look(int facet, const std::array<double, 4>& shape, const FaceCorners& s, int candidate, int triangle,
            const std::vector<double>& x) const;
  // The triangle before the point, or behind it: the nearest; beside the surface, the one next to it.
  Seen nearest(int facet, const std::array<double, 4>& shape, const FaceCorners& s,
               const std::vector<double>& x) const;
  // The held triangle, else the nearest.
  Seen face(int facet, int point, const FaceCorners& s, const std::vector<double>& x, const Hold& hold) const;
  bool precedes(int candidate, int triangle, const Seen& other) const;
  void hold_triangles(const std::vector<double>& x, const Presses& presses);
  void locate_anchors();
  void locate_holds();
  // Visits the points that face something: visitor(constraint, facet, what is seen).
  template <class Visitor> void visit_points(const std::vector<double>& u, Visitor&& visitor) const;
  CarriedFunction carried_gap_of(int facet, int point, const std::vector<double>& u) const;
  void add_gap_gradient(int facet, const Seen& seen, const std::vector<double>& u, Workspace& w,
                        Constraint& c) const;
  // What a point's anchor looks like at u.
  struct SlipFaces {
    FaceCorners s{}, p{};
    std::array<int, 8> slot{}; // secondary, primary
  };
  bool slip_faces(int facet, int point, const std::vector<double>& u, SlipFaces& faces) const;
  void add_slip(int facet, int point, const SlipFaces& faces, const std::vector<double>& u,
                bool with_gradient, Workspace& w, Constraint& c) const;

  ContactSettings settings_;
  ContactSurface secondary_;
  std::vector<int> corners_; // [secondary facet] different ones
  std::vector<FaceMap> map_; // [secondary facet], with friction
  std::vector<double> area_; // [secondary facet] reference
  int per_facet_ = 0;
  std::vector<std::array<double, 4>> shape_; // [secondary facet][point]
  std::vector<double> weight_;               // [secondary facet][point] reference area, 0: no such point
  std::vector<double> nodal_area_;
  std::vector<Hold> holds_;     // [secondary facet][point]
  std::vector<Anchor> anchors_; // [secondary facet][point], empty without friction
  double hold_gap_;
};

} // namespace impact
