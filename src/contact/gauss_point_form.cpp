#include <algorithm>
#include <cmath>
#include <impact/contact/gauss_point_form.hpp>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double infinity = std::numeric_limits<double>::infinity();

// A point is held to its edge as long as it stands at most this part of half an edge beyond its ends,
constexpr double hold_overlap = 0.05;
// and is nearer than this part of its length; while Newton's method works it may stray to this place,
constexpr double hold_range = 0.1, hold_limit = 1.5;
// and a point that changes its edge more often within an attempt is held no longer.
constexpr int switch_limit = 4;

Point2<double> point_at(const std::vector<double>& x, int node) {
  return {x[at(2 * node)], x[at(2 * node + 1)]};
}

// Order of two edges by their reference coordinates: of two equal distances every number of ranks takes the
// same edge, which global node numbers would not give.
bool precedes(const std::vector<double>& X, const int* a, const int* b) {
  for (int i = 0; i < 2; ++i)
    if (const Point2<double> x = point_at(X, a[i]), y = point_at(X, b[i]); x != y) return x < y;
  return false;
}

} // namespace

GaussPointForm::GaussPointForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings,
                               Frame frame, ContactSurface secondary, const ContactSurface& primary,
                               double hold_gap, PlaneMotion motion)
    : settings_(settings), frame_(frame), plane_motion_(std::move(motion)), secondary_(std::move(secondary)),
      points_(make_points(secondary_, settings.id, settings.points, frame)),
      search_(mesh, layout, secondary_.node, secondary_.X, primary, settings.search_radius,
              settings.primary != "plane"),
      holds_(points_.weight.size()), hold_gap_(hold_gap) {
  std::vector<double> area = layout.make_local();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int q = 0; q < points_.per_facet; ++q)
      for (int a = 0; a < 2; ++a) {
        const int index = f * points_.per_facet + q;
        area[at(2 * secondary_.local[at(2 * f + a)])] +=
            points_.weight[at(index)] * points_.shape[at(2 * index + a)];
      }
  const Handle<Vec> sum = layout.make_global();
  layout.add_to_global(area, sum);
  layout.to_local(sum, area);
  for (int node = 0; node < mesh.node_count(); ++node) nodal_area_.push_back(area[at(2 * node)]);
}

std::pair<StateRow, std::size_t> GaussPointForm::multiplier_row(const std::string& name) const {
  StateRow row{name, Support::facet_point, 1};
  row.surface = settings_.secondary;
  return {row, points_.weight.size()};
}

void GaussPointForm::begin_attempt(double t, Vec u_n) {
  time_ = t;
  std::fill(holds_.begin(), holds_.end(), Hold());
  switched_ = false;
  if (u_n) search_.set_start(u_n);
}

PairSearch::Outcome GaussPointForm::update(Vec u, const PressureLaw& law) {
  const PairSearch::Outcome outcome = search_.update(u);
  if (!against_plane()) hold_edges(nodes().current(u), law);
  return outcome;
}

std::vector<std::pair<PetscInt, PetscInt>> GaussPointForm::couplings() const {
  std::vector<std::pair<PetscInt, PetscInt>> pairs;
  const Candidates& list = search_.candidates();
  for (int f = 0; f + 1 < static_cast<int>(list.offset.size()); ++f)
    for (int c = list.offset[at(f)]; c < list.offset[at(f + 1)]; ++c)
      for (PetscInt p : list.primary[at(list.facet[at(c)])].node)
        for (std::size_t a = 0; a < 2; ++a) pairs.emplace_back(secondary_.node[at(2 * f) + a], p);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

Foot<double> GaussPointForm::plane_foot(const Point2<double>& x) const {
  Point2<double> d = {x[0] - settings_.plane_point[0], x[1] - settings_.plane_point[1]};
  if (plane_motion_) d = detail::minus(d, plane_motion_(time_));
  Foot<double> foot;
  foot.part = FootPart::edge;
  foot.normal = {settings_.plane_normal[0], settings_.plane_normal[1]};
  foot.gap = detail::dot(d, foot.normal);
  return foot;
}

PrimaryEdge<double> GaussPointForm::primary_edge(int candidate,
                                                 const std::vector<double>& coordinates) const {
  const int* p = &nodes().primary[at(4 * search_.candidates().facet[at(candidate)])];
  PrimaryEdge<double> edge{point_at(coordinates, p[0]), point_at(coordinates, p[1])};
  edge.has_previous = p[2] >= 0;
  edge.has_next = p[3] >= 0;
  if (edge.has_previous) edge.previous = point_at(coordinates, p[2]);
  if (edge.has_next) edge.next = point_at(coordinates, p[3]);
  return edge;
}

bool GaussPointForm::face(const Point2<double>& x, const Point2<double>& normal,
                          const std::vector<double>& coordinates, const Hold& hold, Point& point) const {
  if (against_plane()) {
    point.node_count = 2;
    point.foot = plane_foot(x);
    return retraction(point.foot, normal, infinity) < infinity;
  }
  return face_held(x, normal, coordinates, hold, point) || face_nearest(x, normal, coordinates, point) ||
         face_passed(x, normal, coordinates, point);
}

bool GaussPointForm::face_nearest(const Point2<double>& x, const Point2<double>& normal,
                                  const std::vector<double>& coordinates, Point& point) const {
  double nearest = infinity;
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &nodes().primary[at(4 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = closest_point(x, edge);
    const double distance = retraction(foot, normal, search_.radius());
    if (!(distance < nearest ||
          (distance == nearest && distance < infinity && precedes(nodes().X, p, &point.node[2]))))
      continue;
    nearest = distance;
    stand_on(edge, foot, p, point);
  }
  return nearest < infinity;
}

bool GaussPointForm::face_held(const Point2<double>& x, const Point2<double>& normal,
                               const std::vector<double>& coordinates, const Hold& hold, Point& point) const {
  if (hold.edge[0] < 0) return false;
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    if (list.primary[at(list.facet[at(c)])].node != hold.edge) continue;
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    // An iterate that flies off altogether, or over an open end, is judged as a point that nothing holds.
    const bool goes_on = foot.xi < 0 ? edge.has_previous : edge.has_next;
    if (std::abs(foot.xi) > (goes_on ? hold_limit : 1.0)) return false;
    if (!(retraction(foot, normal, search_.radius()) < infinity)) return false;
    stand_on(edge, foot, &nodes().primary[at(4 * list.facet[at(c)])], point);
    return true;
  }
  return false;
}

bool GaussPointForm::face_passed(const Point2<double>& x, const Point2<double>& normal,
                                 const std::vector<double>& coordinates, Point& point) const {
  if (nodes().start.empty()) return false;
  const Point2<double> a = point_at(nodes().start, point.node[0]), b = point_at(nodes().start, point.node[1]);
  const Point2<double> x_n = {point.shape[0] * a[0] + point.shape[1] * b[0],
                              point.shape[0] * a[1] + point.shape[1] * b[1]};
  double earliest = infinity;
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &nodes().primary[at(4 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    if (!(foot.gap < -search_.radius()) || !(retraction(foot, normal, infinity) < infinity)) continue;
    // Positions between the start and now are taken as straight in time.
    const PrimaryEdge<double> before = primary_edge(c, nodes().start);
    const double gap_n = foot_on_line(x_n, before).gap;
    if (gap_n < -search_.radius()) continue;
    const double part = gap_n > 0 ? gap_n / (gap_n - foot.gap) : 0;
    auto between = [part](const Point2<double>& from, const Point2<double>& to) {
      return Point2<double>{from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])};
    };
    const PrimaryEdge<double> then{between(before.x0, edge.x0), between(before.x1, edge.x1)};
    if (!(std::abs(foot_on_line(between(x_n, x), then).xi) <= 1 + 1e-6)) continue;
    if (!(part < earliest || (part == earliest && precedes(nodes().X, p, &point.node[2])))) continue;
    earliest = part;
    stand_on(edge, foot, p, point);
  }
  return earliest < infinity;
}

void GaussPointForm::hold_edges(const std::vector<double>& x, const PressureLaw& law) {
  switched_ = false;
  for (int f = 0; f < secondary_.count(); ++f) {
    Point point;
    point.facet = f;
    point.node = {nodes().secondary[at(2 * f)], nodes().secondary[at(2 * f + 1)], -1, -1};
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    const Point2<double> normal = detail::right_normal(x0, x1);
    for (int q = 0; q < points_.per_facet; ++q) {
      const int index = f * points_.per_facet + q;
      const double* N = &points_.shape[at(2 * index)];
      point.shape = {N[0], N[1]};
      const Point2<double> x_s = {N[0] * x0[0] + N[1] * x1[0], N[0] * x0[1] + N[1] * x1[1]};
      Hold& hold = holds_[at(index)];
      Point nearest = point, before = point, after = point;
      const bool had = face(x_s, normal, x, hold, before);
      Hold next{{-1, -1}, hold.switches};
      if (hold.switches < switch_limit && face_nearest(x_s, normal, x, nearest)) {
        auto stays_on = [&](const Foot<double>& line) {
          return std::abs(line.xi) <= 1 + hold_overlap && std::abs(line.gap - nearest.foot.gap) <= hold_gap_;
        };
        const Point2<double> t = detail::minus(nearest.edge.x1, nearest.edge.x0);
        if (std::abs(nearest.foot.gap) > hold_range * std::sqrt(detail::dot(t, t)))
          next.edge = {-1, -1};
        else if (Point held = point; face_held(x_s, normal, x, hold, held) && stays_on(held.foot))
          next.edge = hold.edge;
        else if (stays_on(foot_on_line(x_s, nearest.edge)))
          next.edge = {nodes().global[at(nearest.node[2])], nodes().global[at(nearest.node[3])]};
      }
      const bool has = face(x_s, normal, x, next, after);
      auto presses = [&](bool faces, const Point& p) { return faces && law.active(index, p.foot.gap); };
      if (presses(had, before) || presses(has, after)) {
        const Point2<double> turn = detail::minus(after.foot.normal, before.foot.normal);
        if (had != has || std::abs(after.foot.gap - before.foot.gap) > 1e-9 * hold_gap_ ||
            std::abs(turn[0]) + std::abs(turn[1]) > 1e-10) {
          switched_ = true;
          ++next.switches;
        }
      }
      hold = next;
    }
  }
}

void GaussPointForm::stand_on(const PrimaryEdge<double>& edge, const Foot<double>& foot, const int* p,
                              Point& point) {
  point.foot = foot;
  point.edge = edge;
  point.node[2] = p[0];
  point.node[3] = p[1];
}

void GaussPointForm::visit(const std::vector<double>& x, Derivatives derivatives, const PressureLaw& law,
                           const ConstraintVisitor& visitor) const {
  for (int f = 0; f < secondary_.count(); ++f) {
    Point point;
    point.facet = f;
    point.node = {nodes().secondary[at(2 * f)], nodes().secondary[at(2 * f + 1)], -1, -1};
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    const Point2<double> normal = detail::right_normal(x0, x1);
    const double stretch = std::hypot(x1[0] - x0[0], x1[1] - x0[1]) / secondary_.length[at(f)];
    for (int q = 0; q < points_.per_facet; ++q) {
      point.index = f * points_.per_facet + q;
      point.shape = {points_.shape[at(2 * point.index)], points_.shape[at(2 * point.index + 1)]};
      const Point2<double> x_s = {point.shape[0] * x0[0] + point.shape[1] * x1[0],
                                  point.shape[0] * x0[1] + point.shape[1] * x1[1]};
      if (!face(x_s, normal, x, holds_[at(point.index)], point)) continue;
      const std::span<const int> node(point.node.data(), at(point.node_count));
      Constraint c;
      c.index = point.index;
      c.weight = points_.weight[at(point.index)];
      c.stretch = stretch;
      if (frame_ == Frame::axisymmetric)
        c.stretch *= x_s[0] / (point.shape[0] * nodes().X[at(2 * point.node[0])] +
                               point.shape[1] * nodes().X[at(2 * point.node[1])]);
      c.gap = point.foot.gap;
      c.lambda = law.multiplier(c.index);
      c.active = law.active(c.index, c.gap);
      c.pressure = law.pressure(c.index, c.gap);
      c.node = node;
      c.share = point.shape;
      std::array<double, 8> dg{};
      std::array<double, 64> d2g{};
      if (derivatives != Derivatives::none) {
        dg = gap_gradient(point.shape, point.foot);
        c.gradient = {dg.data(), 2 * node.size()};
      }
      if (derivatives == Derivatives::second && c.active) {
        // The rigid plane is flat and stands still under a variation: no second variation.
        if (point.node_count == 4) d2g = gap_hessian(point.shape, point.edge, point.foot);
        c.hessian = {d2g.data(), 4 * node.size() * node.size()};
      }
      visitor(c);
    }
  }
}

void GaussPointForm::visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const {
  for (int f = 0; f < secondary_.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const int* ends = &nodes().secondary[at(2 * f)];
      const Point2<double> place = point_at(x, ends[a]);
      Point point;
      point.facet = f;
      if (!face(place, detail::right_normal(point_at(x, ends[0]), point_at(x, ends[1])), x, Hold(), point))
        continue;
      // Coordinates that were meant to touch differ by rounding of their own size.
      const double depth = -point.foot.gap;
      if (depth > 1e-9 * (secondary_.length[at(f)] + std::hypot(place[0], place[1])))
        visitor(ends[a], depth, point.foot.normal);
    }
}

} // namespace impact
