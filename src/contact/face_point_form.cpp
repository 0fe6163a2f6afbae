#include <algorithm>
#include <cmath>
#include <impact/contact/face_point_form.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A foot belongs to a triangle if no part of it is below minus this; beyond the sides of the whole surface
// contact goes on by this part of a triangle.
constexpr double inside = 1e-9, beyond = 0.01;
// A point is held to its triangle as long as its foot lies at most this part beyond the sides,
constexpr double hold_overlap = 0.025;
// and is nearer than this part of the secondary face's size; while Newton's method works the foot may stray
// this far,
constexpr double hold_range = 0.1, hold_limit = 1;
// and a point that changes its triangle more often within an attempt is held no longer.
constexpr int switch_limit = 4;
constexpr int largest_rule = 16;

Point3 point3(const std::vector<double>& x, int node) {
  return {x[at(3 * node)], x[at(3 * node + 1)], x[at(3 * node + 2)]};
}

double least_part(const RayFoot& foot) { return *std::min_element(foot.part.begin(), foot.part.end()); }

int triangles_of(int corners) { return corners == 3 ? 1 : 4; }

double area_at(int corners, const FaceCorners& x) {
  const std::array<double, 4> parts = nodal_areas(corners, x);
  return parts[0] + parts[1] + parts[2] + parts[3];
}

// The corner with the smallest coordinates first: points are then numbered in the same way by every
// partition, so that what is kept per point can move to other ranks.
void start_at_smallest_corner(ContactSurface& surface) {
  for (int f = 0; f < surface.count(); ++f) {
    const auto first = at(4 * f);
    const std::ptrdiff_t corners = surface.node[first + 3] == surface.node[first + 2] ? 3 : 4;
    std::array<Point3, 4> X;
    for (std::size_t a = 0; a < 4; ++a) std::copy_n(&surface.X[3 * (first + a)], 3, X[a].begin());
    const std::ptrdiff_t smallest = std::min_element(X.begin(), X.begin() + corners) - X.begin();
    const auto turn = [&](auto* values) {
      std::rotate(values, values + smallest, values + corners);
      if (corners == 3) values[3] = values[2];
    };
    turn(X.data());
    turn(&surface.node[first]);
    turn(&surface.local[first]);
    for (std::size_t a = 0; a < 4; ++a) std::copy_n(X[a].begin(), 3, &surface.X[3 * (first + a)]);
  }
}

} // namespace

FacePointForm::FacePointForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings,
                             ContactSurface secondary, const ContactSurface& primary, double hold_gap)
    : settings_(settings), secondary_(std::move(secondary)), hold_gap_(hold_gap) {
  start_at_smallest_corner(secondary_);
  for (int f = 0; f < secondary_.count(); ++f) {
    corners_.push_back(secondary_.node[at(4 * f + 3)] == secondary_.node[at(4 * f + 2)] ? 3 : 4);
    FaceCorners X;
    for (int a = 0; a < 4; ++a) X[at(a)] = point3(secondary_.X, 4 * f + a);
    area_.push_back(area_at(corners_.back(), X));
    if (settings.friction > 0) map_.push_back(make_face_map(corners_.back(), X));
  }
  make_points();
  holds_.resize(weight_.size());
  if (settings.friction > 0) anchors_.resize(weight_.size());
  search_ = PairSearch(mesh, layout, secondary_.node, secondary_.X, primary,
                       {settings.search_radius, settings.local_search}, what_it_meets(settings));
  std::vector<double> area = layout.make_local();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int q = 0; q < per_facet_; ++q)
      for (std::size_t a = 0; a < 4; ++a)
        area[at(3 * secondary_.local[at(4 * f) + a])] += weight_[index(f, q)] * shape_[index(f, q)][a];
  const Handle<Vec> sum = layout.make_global();
  layout.add_to_global(area, sum);
  layout.to_local(sum, area);
  for (int node = 0; node < mesh.node_count(); ++node) nodal_area_.push_back(area[at(3 * node)]);
}

void FacePointForm::make_points() {
  const int n = settings_.points;
  if (n < 1 || n > largest_rule)
    throw UserError(ExitCode::usage, "-contact_" + settings_.id + "_points " + std::to_string(n) +
                                         ": allowed on faces are 1 to " + std::to_string(largest_rule) +
                                         " points in each direction");
  per_facet_ = n * n;
  shape_.assign(at(secondary_.count() * per_facet_), {});
  weight_.assign(shape_.size(), 0.0);
  const TriangleRule triangle = triangle_rule(n);
  const GaussRule line = gauss_rule(n);
  for (int f = 0; f < secondary_.count(); ++f) {
    std::size_t number = index(f, 0);
    const auto add = [&](const std::array<double, 4>& shape, double weight) {
      shape_[number] = shape;
      weight_[number++] = weight;
    };
    if (corners_[at(f)] == 3) {
      for (std::size_t q = 0; q < triangle.part.size(); ++q)
        add({triangle.part[q][0], triangle.part[q][1], triangle.part[q][2], 0},
            triangle.weight[q] * area_[at(f)]);
      continue;
    }
    for (std::size_t i = 0; i < line.xi.size(); ++i)
      for (std::size_t j = 0; j < line.xi.size(); ++j) {
        const double r = line.xi[i], s = line.xi[j];
        const std::array<double, 4> of_r = {-(1 - s) / 4, (1 - s) / 4, (1 + s) / 4, -(1 + s) / 4},
                                    of_s = {-(1 - r) / 4, -(1 + r) / 4, (1 + r) / 4, (1 - r) / 4};
        Point3 along_r{}, along_s{};
        for (int a = 0; a < 4; ++a) {
          const Point3 X = point3(secondary_.X, 4 * f + a);
          for (std::size_t k = 0; k < 3; ++k) {
            along_r[k] += of_r[at(a)] * X[k];
            along_s[k] += of_s[at(a)] * X[k];
          }
        }
        const double across = dot(along_r, along_s);
        const double area = std::sqrt(dot(along_r, along_r) * dot(along_s, along_s) - across * across);
        add({(1 - r) * (1 - s) / 4, (1 + r) * (1 - s) / 4, (1 + r) * (1 + s) / 4, (1 - r) * (1 + s) / 4},
            line.weight[i] * line.weight[j] * area);
      }
  }
}

std::pair<StateRow, std::size_t> FacePointForm::constraint_row(const std::string& name,
                                                               int components) const {
  StateRow row{name, Support::facet_point, components};
  row.surface = settings_.secondary;
  return {row, at(components) * weight_.size()};
}

void FacePointForm::release() { std::fill(holds_.begin(), holds_.end(), Hold()); }

void FacePointForm::anchor(Vec u) {
  pose_.moved = {};
  search_.set_start(u);
  if (carried() && !anchors_.empty()) carrier_.anchor(nodes(), nodes().start);
  if (anchors_.empty() || on_plane()) return;
  const std::vector<double>& x = nodes().start;
  for (int f = 0; f < secondary_.count(); ++f) {
    const FaceCorners s = secondary_face(f, x);
    for (int q = 0; q < per_facet_; ++q) {
      Anchor& anchor = anchors_[index(f, q)];
      anchor = {};
      if (weight_[index(f, q)] == 0) continue;
      anchor.pair.weights.covered = true;
      anchor.pair.weights.D[0] = shape_[index(f, q)];
      if (settings_.rigid()) {
        // What lies opposite is the place of the face itself: no matter where on the body that is.
        anchor.pair.weights.M[0] = shape_[index(f, q)];
        anchor.place = s;
        anchor.valid = true;
        continue;
      }
      const Seen seen = nearest(f, shape_[index(f, q)], s, x);
      anchor.valid = seen.candidate >= 0;
      if (!anchor.valid) continue;
      anchor.pair.weights.M[0] = seen.foot.weights;
      anchor.node = search_.candidates().primary[at(search_.candidates().facet[at(seen.candidate)])].node;
      anchor.pair.start =
          face_slips(s, primary_face(seen.candidate, x), map_[at(f)], anchor.pair, false).value;
    }
  }
  locate_anchors();
}

void FacePointForm::locate_anchors() {
  for (Anchor& anchor : anchors_)
    for (std::size_t b = 0; b < 4; ++b) anchor.slot[b] = nodes().slot(anchor.node[b]);
}

void FacePointForm::locate_holds() {
  const Candidates& list = search_.candidates();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int q = 0; q < per_facet_; ++q) {
      Hold& hold = holds_[index(f, q)];
      hold.candidate = -1;
      if (hold.face[0] < 0) continue;
      for (int c = list.offset[at(f)]; c < list.offset[at(f + 1)]; ++c)
        if (list.primary[at(list.facet[at(c)])].node == hold.face) hold.candidate = c;
    }
}

PairSearch::Outcome FacePointForm::update(Vec u, const Presses& presses) {
  const PairSearch::Outcome outcome = update_pairs(u);
  if (outcome != PairSearch::Outcome::kept) {
    locate_anchors();
    if (!settings_.rigid()) locate_holds();
  }
  if (!settings_.rigid()) hold_triangles(nodes().current(u), presses);
  return outcome;
}

NodePairs FacePointForm::couplings() const {
  NodePairs pairs;
  for (int f = 0; f < secondary_.count(); ++f) {
    const std::vector<PetscInt> primary = search_.primary_nodes(f);
    for (PetscInt p : primary)
      for (std::size_t a = 0; a < at(corners_[at(f)]); ++a)
        pairs.emplace_back(secondary_.node[at(4 * f) + a], p);
    // Friction couples the face that a point lay on at the start of the step with the one that it is on now.
    if (!anchors_.empty()) add_pairs_among(primary, pairs);
  }
  sort_unique(pairs);
  return pairs;
}

const int* FacePointForm::secondary_slots(int facet) const { return &nodes().secondary[at(4 * facet)]; }

const int* FacePointForm::primary_slots(int candidate) const {
  return &nodes().primary[at(4 * search_.candidates().facet[at(candidate)])];
}

int FacePointForm::primary_corners(int candidate) const {
  const int* slot = primary_slots(candidate);
  return slot[3] == slot[2] ? 3 : 4;
}

FaceCorners FacePointForm::secondary_face(int facet, const std::vector<double>& x) const {
  const int* slot = secondary_slots(facet);
  return {point3(x, slot[0]), point3(x, slot[1]), point3(x, slot[2]), point3(x, slot[3])};
}

FaceCorners FacePointForm::primary_face(int candidate, const std::vector<double>& x) const {
  const int* slot = primary_slots(candidate);
  return {point3(x, slot[0]), point3(x, slot[1]), point3(x, slot[2]), point3(x, slot[3])};
}

FaceCorners FacePointForm::secondary_from_corner(int facet, const std::vector<double>& u) const {
  const int* slot = secondary_slots(facet);
  FaceCorners s;
  for (std::size_t a = 0; a < 4; ++a) s[a] = nodes().place<3>(slot[a], slot[0], u);
  return s;
}

FaceCorners FacePointForm::primary_from_corner(int facet, int candidate, const std::vector<double>& u) const {
  const int *slot = primary_slots(candidate), *origin = secondary_slots(facet);
  FaceCorners p;
  for (std::size_t b = 0; b < 4; ++b) p[b] = nodes().place<3>(slot[b], origin[0], u);
  return p;
}

Point3 FacePointForm::point_at(const std::array<double, 4>& shape, int facet,
                               const std::vector<double>& u) const {
  const int* slot = secondary_slots(facet);
  Point3 x{};
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = at(3 * slot[a]) + k;
      x[k] += shape[a] * (nodes().X[i] + u[i]);
    }
  return x;
}

FacePointForm::Seen FacePointForm::look(int facet, const std::array<double, 4>& shape, const FaceCorners& s,
                                        int candidate, int triangle, const std::vector<double>& x) const {
  const TriangleWeights weights = triangle_weights(primary_corners(candidate), triangle);
  return {candidate, triangle, cast_ray(corners_[at(facet)], s, shape, primary_face(candidate, x), weights)};
}

bool FacePointForm::may_touch(const Seen& seen, int facet, const std::array<double, 4>& shape) const {
  if (!(seen.foot.opposition < -least_opposition) || !(seen.foot.gap < search_.radius())) return false;
  const double depth = search_.depth(facet);
  if (seen.foot.gap > -depth) return true;
  // So deep only what came through the surface within this step.
  if (nodes().start.empty()) return false;
  const RayFoot before =
      look(facet, shape, secondary_face(facet, nodes().start), seen.candidate, seen.triangle, nodes().start)
          .foot;
  return before.opposition < -least_opposition && before.gap > -depth;
}

bool FacePointForm::precedes(int candidate, int triangle, const Seen& other) const {
  // By reference coordinates: of two equal distances every number of ranks takes the same triangle.
  const auto key = [&](int c, int t) {
    const FaceCorners X = primary_face(c, nodes().X);
    const auto corners = at(primary_corners(c));
    std::array<Point3, 2> side = {X[at(t)], X[(at(t) + 1) % corners]};
    std::sort(side.begin(), side.end());
    std::array<Point3, 4> face = X;
    std::sort(face.begin(), face.end());
    return std::pair(side, face);
  };
  return key(candidate, triangle) < key(other.candidate, other.triangle);
}

FacePointForm::Seen FacePointForm::nearest(int facet, const std::array<double, 4>& shape,
                                           const FaceCorners& s, const std::vector<double>& x) const {
  Seen best;
  bool best_inside = false;
  const double equal = 1e-9 * secondary_.length[at(facet)];
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(facet)]; c < list.offset[at(facet + 1)]; ++c)
    for (int t = 0; t < triangles_of(primary_corners(c)); ++t) {
      const Seen seen = look(facet, shape, s, c, t, x);
      const double least = least_part(seen.foot);
      if (!(least >= -beyond) || !may_touch(seen, facet, shape)) continue;
      const bool is_inside = least >= -inside;
      bool better = best.candidate < 0;
      if (!better && is_inside != best_inside) {
        better = is_inside;
      } else if (!better && is_inside) {
        const double nearer = std::abs(best.foot.gap) - std::abs(seen.foot.gap);
        better = nearer > equal || (nearer > -equal && precedes(c, t, best));
      } else if (!better) {
        better = least > least_part(best.foot);
      }
      if (!better) continue;
      best = seen;
      best_inside = is_inside;
    }
  if (best.candidate >= 0 && !search_.counts(best.candidate)) best.candidate = -1;
  return best;
}

FacePointForm::Seen FacePointForm::face(int facet, int point, const FaceCorners& s,
                                        const std::vector<double>& x, const Hold& hold) const {
  const std::array<double, 4>& shape = shape_[index(facet, point)];
  if (hold.candidate >= 0) {
    const Seen seen = look(facet, shape, s, hold.candidate, hold.triangle, x);
    if (least_part(seen.foot) > -hold_limit && may_touch(seen, facet, shape)) return seen;
  }
  return nearest(facet, shape, s, x);
}

void FacePointForm::hold_triangles(const std::vector<double>& x, const Presses& presses) {
  switched_ = false;
  const Candidates& list = search_.candidates();
  for (int f = 0; f < secondary_.count(); ++f) {
    const FaceCorners s = secondary_face(f, x);
    for (int q = 0; q < per_facet_; ++q) {
      const std::size_t number = index(f, q);
      if (weight_[number] == 0) continue;
      Hold& hold = holds_[number];
      const Seen before = face(f, q, s, x, hold);
      Hold next;
      next.switches = hold.switches;
      if (hold.switches < switch_limit) {
        Seen held = nearest(f, shape_[number], s, x);
        const bool near =
            held.candidate >= 0 && std::abs(held.foot.gap) <= hold_range * secondary_.length[at(f)];
        if (near && hold.candidate >= 0) {
          const Seen still = look(f, shape_[number], s, hold.candidate, hold.triangle, x);
          if (least_part(still.foot) >= -hold_overlap && may_touch(still, f, shape_[number]) &&
              std::abs(still.foot.gap - held.foot.gap) <= hold_gap_)
            held = still;
        }
        if (near) {
          next.candidate = held.candidate;
          next.triangle = held.triangle;
          next.face = list.primary[at(list.facet[at(held.candidate)])].node;
        }
      }
      const Seen after = face(f, q, s, x, next);
      const auto pressing = [&](const Seen& seen) {
        return seen.candidate >= 0 && presses(static_cast<int>(number), seen.foot.gap);
      };
      if (pressing(before) || pressing(after)) {
        double turn = 0;
        for (std::size_t k = 0; k < 3; ++k) turn += std::abs(after.foot.normal[k] - before.foot.normal[k]);
        if ((before.candidate >= 0) != (after.candidate >= 0) || turn > 1e-10 ||
            std::abs(after.foot.gap - before.foot.gap) > 1e-9 * hold_gap_) {
          switched_ = true;
          ++next.switches;
        }
      }
      hold = next;
    }
  }
}

std::size_t FacePointForm::Workspace::place(int slot) {
  const auto found = static_cast<std::size_t>(std::find(node.begin(), node.end(), slot) - node.begin());
  if (found == node.size()) node.push_back(slot);
  return found;
}

template <class Visitor>
void FacePointForm::visit_points(const std::vector<double>& u, Visitor&& visitor) const {
  const std::vector<double> x = nodes().current(u);
  const RigidObstacle obstacle = obstacle_at(u);
  for (int f = 0; f < secondary_.count(); ++f) {
    const FaceCorners s = secondary_face(f, x);
    const Point3 normal = face_normal(s);
    const FaceCorners near = secondary_from_corner(f, u);
    const double stretch = area_at(corners_[at(f)], near) / area_[at(f)];
    for (int q = 0; q < per_facet_; ++q) {
      const std::size_t number = index(f, q);
      if (weight_[number] == 0) continue;
      Seen seen;
      if (settings_.rigid()) {
        const ObstacleGap gap = gap_to(obstacle, point_at(shape_[number], f, u));
        if (!(dot(gap.normal, normal) < 0)) continue;
        seen.foot.gap = gap.gap;
        seen.foot.normal = gap.normal;
      } else {
        seen = face(f, q, s, x, holds_[number]);
        if (seen.candidate < 0) continue;
        // Once more with all its digits: a penalty makes a pressure of what is lost.
        seen.foot = cast_ray(corners_[at(f)], near, shape_[number], primary_from_corner(f, seen.candidate, u),
                             triangle_weights(primary_corners(seen.candidate), seen.triangle));
      }
      Constraint c;
      c.index = static_cast<int>(number);
      c.weight = weight_[number];
      c.stretch = stretch;
      c.gap = seen.foot.gap;
      c.share = {shape_[number].data(), at(corners_[at(f)])};
      visitor(c, f, q, seen);
    }
  }
}

void FacePointForm::visit(const std::vector<double>& u, Derivatives derivatives,
                          const ConstraintVisitor& visitor) const {
  Workspace w;
  visit_points(u, [&](Constraint& c, int f, int q, const Seen& seen) {
    w.node.clear();
    for (int a = 0; a < corners_[at(f)]; ++a) w.place(secondary_slots(f)[a]);
    if (seen.candidate >= 0)
      for (int b = 0; b < 4; ++b) w.place(primary_slots(seen.candidate)[b]);
    for (int slot : carrier_.slots()) w.node.push_back(slot);
    const bool with_gradient = derivatives != Derivatives::none;
    SlipFaces faces;
    const bool rubs = slip_faces(f, q, u, faces);
    if (rubs && !settings_.rigid())
      for (std::size_t b = 4; b < 8; ++b) w.place(faces.slot[b]);
    if (with_gradient) add_gap_gradient(f, seen, u, w, c);
    c.slides = rubs;
    if (rubs) add_slip(f, q, faces, u, with_gradient, w, c);
    c.node = w.node;
    visitor(c);
  });
}

void FacePointForm::add_gap_gradient(int facet, const Seen& seen, const std::vector<double>& u, Workspace& w,
                                     Constraint& c) const {
  const std::array<double, 4>& shape = shape_[at(c.index)];
  const int* slot = secondary_slots(facet);
  w.gradient.assign(3 * w.node.size(), 0.0);
  if (carried()) {
    carrier_.add_gradient(carried_gap_of(facet, c.index - facet * per_facet_, u), c.share, carrier_.shares(),
                          1, w.gradient.data());
  } else if (settings_.rigid()) {
    for (std::size_t a = 0; a < at(corners_[at(facet)]); ++a)
      for (std::size_t k = 0; k < 3; ++k) w.gradient[3 * a + k] = shape[a] * seen.foot.normal[k];
  } else {
    const std::array<double, 24> row =
        ray_gradient(corners_[at(facet)], secondary_from_corner(facet, u), shape,
                     primary_from_corner(facet, seen.candidate, u),
                     triangle_weights(primary_corners(seen.candidate), seen.triangle));
    for (std::size_t a = 0; a < 8; ++a) {
      const std::size_t place = w.place(a < 4 ? slot[a] : primary_slots(seen.candidate)[a - 4]);
      for (std::size_t k = 0; k < 3; ++k) w.gradient[3 * place + k] += row[3 * a + k];
    }
  }
  c.gradient = w.gradient;
}

CarriedFunction FacePointForm::carried_gap_of(int facet, int point, const std::vector<double>& u) const {
  return carried_gap(carrier_.obstacle(u), point_at(shape_[index(facet, point)], facet, u));
}

// The faces of a point's anchor at u, seen from the secondary's first corner; false without friction or where
// nothing lay opposite. A plane has directions of its own and needs no faces.
bool FacePointForm::slip_faces(int facet, int point, const std::vector<double>& u, SlipFaces& faces) const {
  if (anchors_.empty() || nodes().start.empty()) return false;
  if (on_plane()) return true;
  const Anchor& anchor = anchors_[index(facet, point)];
  if (!anchor.valid) return false;
  const int* slot = secondary_slots(facet);
  auto& [s, p, slots] = faces;
  s = secondary_from_corner(facet, u);
  for (std::size_t a = 0; a < 4; ++a) {
    slots[a] = slot[a];
    slots[4 + a] = anchor.slot[a];
    if (carried()) {
      slots[4 + a] = carrier_.slots()[a];
      p[a] = carrier_.place<3>(nodes(), facet, static_cast<int>(a), slot[0], u);
      continue;
    }
    if (!settings_.rigid()) {
      if (anchor.slot[a] < 0) return false;
      p[a] = nodes().place<3>(anchor.slot[a], slot[0], u);
      continue;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i = at(3 * slot[0]) + k;
      p[a][k] = anchor.place[a][k] + pose_.moved[k] - nodes().X[i] - u[i];
    }
  }
  return true;
}

void FacePointForm::add_slip(int facet, int point, const SlipFaces& faces, const std::vector<double>& u,
                             bool with_gradient, Workspace& w, Constraint& c) const {
  const std::size_t n = 3 * w.node.size();
  w.slip_gradient.assign(2 * n, 0.0);
  if (on_plane() && carried()) {
    const std::array<Point3, 2> t = tangents_of(pose_.obstacle.direction);
    for (std::size_t e = 0; e < 2; ++e) {
      const ObstacleCarrier::PlaneSlip slip = carrier_.slip(nodes(), facet, c.share, t[e], u);
      c.slip[e] = slip.function.value;
      carrier_.add_gradient(slip.function, c.share, slip.shares, 1, &w.slip_gradient[n * e]);
    }
  } else if (on_plane()) {
    const std::array<Point3, 2> t = tangents_of(pose_.obstacle.direction);
    const std::array<double, 4>& shape = shape_[index(facet, point)];
    for (std::size_t b = 0; b < at(corners_[at(facet)]); ++b)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t dof = at(3 * secondary_slots(facet)[b]) + k;
        const double moved = nodes().X[dof] + u[dof] - nodes().start[dof] - pose_.moved[k];
        for (std::size_t e = 0; e < 2; ++e) {
          c.slip[e] += shape[b] * t[e][k] * moved;
          w.slip_gradient[n * e + 3 * b + k] += shape[b] * t[e][k];
        }
      }
  } else {
    FaceSlips slips =
        face_slips(faces.s, faces.p, map_[at(facet)], anchors_[index(facet, point)].pair, with_gradient);
    c.slip = {slips.value[0][0], slips.value[0][1]};
    for (std::size_t e = 0; with_gradient && carried() && e < 2; ++e) {
      const std::array<double, 24> row = slips.gradient[0][e];
      carrier_.chain(facet, &row[12], &slips.gradient[0][e][12]);
    }
    for (std::size_t e = 0; with_gradient && e < 2; ++e)
      for (std::size_t a = 0; a < (settings_.rigid() && !carried() ? 4 : 8); ++a) {
        const std::size_t place = n * e + 3 * w.place(faces.slot[a]);
        for (std::size_t k = 0; k < 3; ++k) w.slip_gradient[place + k] += slips.gradient[0][e][3 * a + k];
      }
  }
  c.slip_gradient = w.slip_gradient;
}

void FacePointForm::visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                    const BlockVisitor& visitor) const {
  visit_points(u, [&](const Constraint& c, int f, int q, const Seen& seen) {
    const double of_gap = factors.of_gap(c.index);
    const std::array<double, 4>& shape = shape_[at(c.index)];
    std::array<int, 8> slots;
    std::copy_n(secondary_slots(f), 4, slots.begin());
    const Tangential of_slip = factors.of_slip(c.index);
    const std::size_t corners = c.share.size();
    if (carried()) {
      std::array<double, 576> block{};
      const std::size_t n = 3 * (corners + 4);
      if (of_gap != 0)
        carrier_.add_hessian(carried_gap_of(f, q, u), c.share, carrier_.shares(), of_gap, block.data());
      if (on_plane() && of_slip != Tangential{}) {
        const std::array<Point3, 2> t = tangents_of(pose_.obstacle.direction);
        for (std::size_t e = 0; e < 2; ++e)
          if (of_slip[e] != 0) {
            const ObstacleCarrier::PlaneSlip slip = carrier_.slip(nodes(), f, c.share, t[e], u);
            carrier_.add_hessian(slip.function, c.share, slip.shares, of_slip[e], block.data());
          }
      }
      std::copy(carrier_.slots().begin(), carrier_.slots().end(),
                slots.begin() + static_cast<std::ptrdiff_t>(corners));
      visitor({slots.data(), corners + 4}, {block.data(), n * n});
    } else if (of_gap != 0 && settings_.rigid()) {
      const std::array<double, 9> H = gap_to(pose_.obstacle, point_at(shape, f, u)).curvature;
      std::array<double, 144> block;
      for (std::size_t i = 0; i < 12; ++i)
        for (std::size_t j = 0; j < 12; ++j)
          block[12 * i + j] = of_gap * shape[i / 3] * shape[j / 3] * H[3 * (i % 3) + j % 3];
      visitor({slots.data(), 4}, block);
    } else if (of_gap != 0) {
      std::copy_n(primary_slots(seen.candidate), 4, slots.begin() + 4);
      std::array<double, 576> block{};
      add_ray_hessian(corners_[at(f)], secondary_from_corner(f, u), shape,
                      primary_from_corner(f, seen.candidate, u),
                      triangle_weights(primary_corners(seen.candidate), seen.triangle), of_gap, block);
      visitor(slots, block);
    }
    if (of_slip == Tangential{} || on_plane()) return;
    SlipFaces faces;
    if (!slip_faces(f, q, u, faces)) return;
    std::array<double, 576> block{};
    add_face_slip_hessian(faces.s, faces.p, map_[at(f)], anchors_[at(c.index)].pair,
                          {{{of_slip[0], of_slip[1]}}}, block);
    if (carried()) {
      std::vector<double> chained;
      carrier_.chain_block(f, block, chained);
      return visitor(faces.slot, chained);
    }
    if (!settings_.rigid()) return visitor(faces.slot, block);
    std::array<double, 144> part;
    for (std::size_t i = 0; i < 12; ++i) std::copy_n(&block[24 * i], 12, &part[12 * i]);
    visitor({slots.data(), 4}, part);
  });
}

void FacePointForm::visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const {
  visit_points(u, [&](const Constraint& c, int f, int, const Seen& seen) {
    std::array<int, 8> node;
    std::array<double, 8> share;
    const std::size_t secondary = c.share.size(), opposite = seen.candidate < 0 ? 0 : 4;
    std::copy_n(secondary_slots(f), secondary, node.begin());
    std::copy(c.share.begin(), c.share.end(), share.begin());
    if (opposite > 0) {
      const auto end = static_cast<std::ptrdiff_t>(secondary);
      std::copy_n(primary_slots(seen.candidate), opposite, node.begin() + end);
      std::copy_n(seen.foot.weights.begin(), opposite, share.begin() + end);
    }
    Meeting meeting;
    meeting.index = c.index;
    meeting.area = c.weight;
    meeting.secondary = secondary;
    meeting.node = {node.data(), secondary + opposite};
    meeting.share = {share.data(), secondary + opposite};
    visitor(meeting);
  });
}

void FacePointForm::visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const {
  for (int f = 0; f < secondary_.count(); ++f) {
    const FaceCorners s = secondary_face(f, x);
    const Point3 n = face_normal(s);
    for (std::size_t a = 0; a < at(corners_[at(f)]); ++a) {
      const int slot = secondary_slots(f)[a];
      // Coordinates that were meant to touch differ by rounding of their own size.
      const double rounding =
          1e-9 * (secondary_.length[at(f)] + std::abs(s[a][0]) + std::abs(s[a][1]) + std::abs(s[a][2]));
      if (settings_.rigid()) {
        const ObstacleGap seen = gap_to(pose_.obstacle, s[a]);
        if (-seen.gap > rounding) visitor(slot, -seen.gap, seen.normal);
        continue;
      }
      std::array<double, 4> shape{};
      shape[a] = 1;
      const Seen seen = nearest(f, shape, s, x);
      if (seen.candidate >= 0 && -seen.foot.gap > rounding)
        visitor(slot, -seen.foot.gap, {-n[0], -n[1], -n[2]});
    }
  }
}

} // namespace impact
