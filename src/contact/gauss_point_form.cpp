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
                               double hold_gap)
    : settings_(settings), frame_(frame), secondary_(std::move(secondary)),
      points_(make_points(secondary_, settings.id, settings.points, frame)), holds_(points_.weight.size()),
      anchors_(settings.friction > 0 ? points_.weight.size() : 0), hold_gap_(hold_gap) {
  search_ = PairSearch(mesh, layout, secondary_.node, secondary_.X, primary,
                       {settings.search_radius, settings.local_search}, what_it_meets(settings));
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

std::pair<StateRow, std::size_t> GaussPointForm::constraint_row(const std::string& name,
                                                                int components) const {
  StateRow row{name, Support::facet_point, components};
  row.surface = settings_.secondary;
  return {row, at(components) * points_.weight.size()};
}

void GaussPointForm::release() { std::fill(holds_.begin(), holds_.end(), Hold()); }

void GaussPointForm::anchor(Vec u) {
  pose_.moved = {};
  search_.set_start(u);
  if (!(settings_.friction > 0)) return;
  const std::vector<double>& x = nodes().start;
  if (carried()) carrier_.anchor(nodes(), x);
  const std::vector<double> moved = nodes().displacement(u);
  for (int f = 0; f < secondary_.count(); ++f) {
    Point point = on_facet(f);
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    for (int q = 0; q < points_.per_facet; ++q) {
      const int index = f * points_.per_facet + q;
      const double* N = &points_.shape[at(2 * index)];
      Anchor& anchor = anchors_[at(index)];
      anchor = {};
      anchor.place = {N[0] * x0[0] + N[1] * x1[0], N[0] * x0[1] + N[1] * x1[1]};
      anchor.valid = settings_.rigid() || face_nearest(anchor.place, detail::right_normal(x0, x1), x, point);
      if (!anchor.valid || settings_.rigid()) continue;
      const double xi = point.foot.xi;
      anchor.node = {nodes().global[at(point.node[2])], nodes().global[at(point.node[3])]};
      anchor.pair = {{N[0], N[1]}, {(1 - xi) / 2, (1 + xi) / 2}};
      const auto place_of = [&](int node) { return nodes().place(node, point.node[0], moved); };
      anchor.start = slip_of({place_of(point.node[0]), place_of(point.node[1])},
                             {place_of(point.node[2]), place_of(point.node[3])}, anchor.pair)
                         .value;
    }
  }
  locate_anchors();
}

void GaussPointForm::locate_anchors() {
  for (Anchor& anchor : anchors_)
    for (std::size_t b = 0; b < 2; ++b) anchor.slot[b] = nodes().slot(anchor.node[b]);
}

GaussPointForm::Point GaussPointForm::on_facet(int facet) const {
  Point point;
  point.facet = facet;
  point.node = {nodes().secondary[at(2 * facet)], nodes().secondary[at(2 * facet + 1)], -1, -1};
  return point;
}

PairSearch::Outcome GaussPointForm::update(Vec u, const Presses& presses) {
  const PairSearch::Outcome outcome = update_pairs(u);
  if (outcome != PairSearch::Outcome::kept) locate_anchors();
  if (!settings_.rigid()) hold_edges(nodes().current(u), presses);
  return outcome;
}

NodePairs GaussPointForm::couplings() const {
  NodePairs pairs;
  for (int f = 0; f < secondary_.count(); ++f) {
    const std::vector<PetscInt> primary = search_.primary_nodes(f);
    for (PetscInt p : primary)
      for (std::size_t a = 0; a < 2; ++a) pairs.emplace_back(secondary_.node[at(2 * f) + a], p);
    // Friction couples the edge that a point lay on at the start of the step with the one that it is on now.
    if (!anchors_.empty()) add_pairs_among(primary, pairs);
  }
  sort_unique(pairs);
  return pairs;
}

bool GaussPointForm::face_obstacle(const RigidObstacle& obstacle, const Point2<double>& x,
                                   const Point2<double>& normal, Point& point) {
  const ObstacleGap at_x = gap_to(obstacle, {x[0], x[1], 0});
  point.node_count = 2;
  point.foot = {};
  point.foot.part = FootPart::edge;
  point.foot.normal = {at_x.normal[0], at_x.normal[1]};
  point.foot.gap = at_x.gap;
  return retraction(point.foot, normal, infinity) < infinity;
}

void GaussPointForm::add_carrier(Workspace& w, Constraint& c) const {
  std::copy(carrier_.slots().begin(), carrier_.slots().end(), w.node.begin() + 2);
  c.node = {w.node.data(), at(2 + carrier_.count())};
}

CarriedFunction GaussPointForm::carried_gap_of(const Point& point, const std::vector<double>& u) const {
  std::array<double, 3> x{};
  for (std::size_t a = 0; a < 2; ++a)
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t i = 2 * at(point.node[a]) + k;
      x[k] += point.shape[a] * (nodes().X[i] + u[i]);
    }
  return carried_gap(carrier_.obstacle(u), x);
}

PrimaryEdge<double> GaussPointForm::primary_edge(int candidate,
                                                 const std::vector<double>& coordinates) const {
  const int facet = search_.candidates().facet[at(candidate)];
  const int *p = &nodes().primary[at(2 * facet)], *neighbour = &nodes().neighbour[at(2 * facet)];
  PrimaryEdge<double> edge{point_at(coordinates, p[0]), point_at(coordinates, p[1])};
  edge.has_previous = neighbour[0] >= 0;
  edge.has_next = neighbour[1] >= 0;
  if (edge.has_previous) edge.previous = point_at(coordinates, neighbour[0]);
  if (edge.has_next) edge.next = point_at(coordinates, neighbour[1]);
  return edge;
}

bool GaussPointForm::face(const Point2<double>& x, const Point2<double>& normal,
                          const std::vector<double>& coordinates, const Hold& hold, Point& point) const {
  return face_held(x, normal, coordinates, hold, point) || face_nearest(x, normal, coordinates, point) ||
         face_passed(x, normal, coordinates, point);
}

bool GaussPointForm::may_touch(const Foot<double>& foot, const Point2<double>& normal, double depth) const {
  return !search_.meets_itself() ||
         (foot.gap > -depth && detail::dot(foot.normal, normal) < -least_opposition);
}

bool GaussPointForm::face_nearest(const Point2<double>& x, const Point2<double>& normal,
                                  const std::vector<double>& coordinates, Point& point) const {
  double nearest = infinity;
  bool counts = true;
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &nodes().primary[at(2 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = closest_point(x, edge);
    const double distance = retraction(foot, normal, search_.radius());
    if (!may_touch(foot, normal, search_.depth(point.facet))) continue;
    if (!(distance < nearest ||
          (distance == nearest && distance < infinity && precedes(nodes().X, p, &point.node[2]))))
      continue;
    nearest = distance;
    counts = search_.counts(c);
    stand_on(edge, foot, p, point);
  }
  return nearest < infinity && counts;
}

bool GaussPointForm::face_held(const Point2<double>& x, const Point2<double>& normal,
                               const std::vector<double>& coordinates, const Hold& hold, Point& point) const {
  if (hold.edge[0] < 0) return false;
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const SearchFacet& primary = list.primary[at(list.facet[at(c)])];
    if (primary.node[0] != hold.edge[0] || primary.node[1] != hold.edge[1]) continue;
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    // An iterate that flies off altogether, or over an open end, is judged as a point that nothing holds.
    const bool goes_on = foot.xi < 0 ? edge.has_previous : edge.has_next;
    if (std::abs(foot.xi) > (goes_on ? hold_limit : 1.0)) return false;
    if (!(retraction(foot, normal, search_.radius()) < infinity)) return false;
    if (!may_touch(foot, normal, search_.depth(point.facet))) return false;
    stand_on(edge, foot, &nodes().primary[at(2 * list.facet[at(c)])], point);
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
  bool counts = true;
  const double depth = search_.depth(point.facet);
  const Candidates& list = search_.candidates();
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &nodes().primary[at(2 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    if (!(foot.gap < -depth) || !(retraction(foot, normal, infinity) < infinity)) continue;
    // Positions between the start and now are taken as straight in time.
    if (!may_touch(foot, normal, infinity)) continue;
    const PrimaryEdge<double> before = primary_edge(c, nodes().start);
    const double gap_n = foot_on_line(x_n, before).gap;
    if (gap_n < -depth) continue;
    const double part = gap_n > 0 ? gap_n / (gap_n - foot.gap) : 0;
    auto between = [part](const Point2<double>& from, const Point2<double>& to) {
      return Point2<double>{from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])};
    };
    const PrimaryEdge<double> then{between(before.x0, edge.x0), between(before.x1, edge.x1)};
    if (!(std::abs(foot_on_line(between(x_n, x), then).xi) <= 1 + 1e-6)) continue;
    if (!(part < earliest || (part == earliest && precedes(nodes().X, p, &point.node[2])))) continue;
    earliest = part;
    counts = search_.counts(c);
    stand_on(edge, foot, p, point);
  }
  return earliest < infinity && counts;
}

void GaussPointForm::hold_edges(const std::vector<double>& x, const Presses& presses) {
  switched_ = false;
  for (int f = 0; f < secondary_.count(); ++f) {
    Point point = on_facet(f);
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
      auto pressing = [&](bool faces, const Point& p) { return faces && presses(index, p.foot.gap); };
      if (pressing(had, before) || pressing(has, after)) {
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

// The foot on the edge's line once more, with all its digits: a penalty makes a pressure of what is lost.
void GaussPointForm::sharpen(const std::vector<double>& u, Point& point) const {
  if (point.node_count != 4 || point.foot.part != FootPart::edge) return;
  std::array<Point2<double>, 4> y{};
  for (std::size_t a = 0; a < 4; ++a) y[a] = nodes().place(point.node[a], point.node[2], u);
  const Point2<double> x = {point.shape[0] * y[0][0] + point.shape[1] * y[1][0],
                            point.shape[0] * y[0][1] + point.shape[1] * y[1][1]};
  point.foot = foot_on_line(x, PrimaryEdge<double>{y[2], y[3]});
}

template <class Visitor>
void GaussPointForm::visit_points(const std::vector<double>& u, bool second, Visitor&& visitor) const {
  Workspace w;
  const std::vector<double> x = nodes().current(u);
  const bool rigid = settings_.rigid();
  const RigidObstacle obstacle = obstacle_at(u);
  for (int f = 0; f < secondary_.count(); ++f) {
    Point point = on_facet(f);
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    const Point2<double> normal = detail::right_normal(x0, x1);
    const double stretch = std::hypot(x1[0] - x0[0], x1[1] - x0[1]) / secondary_.length[at(f)];
    for (int q = 0; q < points_.per_facet; ++q) {
      point.index = f * points_.per_facet + q;
      point.shape = {points_.shape[at(2 * point.index)], points_.shape[at(2 * point.index + 1)]};
      const Point2<double> x_s = {point.shape[0] * x0[0] + point.shape[1] * x1[0],
                                  point.shape[0] * x0[1] + point.shape[1] * x1[1]};
      if (!(rigid ? face_obstacle(obstacle, x_s, normal, point)
                  : face(x_s, normal, x, holds_[at(point.index)], point)))
        continue;
      sharpen(u, point);
      Constraint c;
      c.index = point.index;
      c.weight = points_.weight[at(point.index)];
      c.stretch = stretch;
      if (frame_ == Frame::axisymmetric)
        c.stretch *= x_s[0] / (point.shape[0] * nodes().X[at(2 * point.node[0])] +
                               point.shape[1] * nodes().X[at(2 * point.node[1])]);
      c.gap = point.foot.gap;
      std::copy(point.node.begin(), point.node.end(), w.node.begin());
      c.node = {w.node.data(), at(point.node_count)};
      c.share = point.shape;
      if (carried()) add_carrier(w, c);
      add_slip(point, u, x_s, second, w, c);
      visitor(c, point, w);
    }
  }
}

void GaussPointForm::visit(const std::vector<double>& u, Derivatives derivatives,
                           const ConstraintVisitor& visitor) const {
  visit_points(u, false, [&](Constraint& c, const Point& point, Workspace& w) {
    if (derivatives != Derivatives::none) {
      w.gradient.fill(0);
      if (carried()) {
        carrier_.add_gradient(carried_gap_of(point, u), point.shape, carrier_.shares(), 1, w.gradient.data());
      } else {
        const std::array<double, 8> dg = gap_gradient(point.shape, point.foot);
        std::copy_n(dg.begin(), 2 * point.node_count, w.gradient.begin());
      }
      c.gradient = {w.gradient.data(), 2 * c.node.size()};
    }
    visitor(c);
  });
}

void GaussPointForm::visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const {
  visit_points(u, false, [&](const Constraint& c, const Point& point, const Workspace&) {
    const double xi = point.foot.xi;
    const std::array<double, 4> share = {point.shape[0], point.shape[1], (1 - xi) / 2, (1 + xi) / 2};
    Meeting meeting;
    meeting.index = c.index;
    meeting.area = c.weight;
    meeting.secondary = 2;
    const auto count = at(point.node_count);
    meeting.node = {point.node.data(), count};
    meeting.share = {share.data(), count};
    visitor(meeting);
  });
}

void GaussPointForm::visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                     const BlockVisitor& visitor) const {
  const std::vector<double> X = nodes().current(u);
  visit_points(u, true, [&](const Constraint& c, const Point& point, Workspace& w) {
    const double of_gap = factors.of_gap(c.index), of_slip = c.slides ? factors.of_slip(c.index)[0] : 0;
    if (of_gap == 0 && of_slip == 0) return;
    const std::size_t n = 2 * c.node.size();
    for (std::size_t i = 0; i < n * n; ++i) w.hessian[i] = of_slip != 0 ? of_slip * w.slip_hessian[i] : 0;
    if (carried()) {
      carrier_.add_hessian(carried_gap_of(point, u), point.shape, carrier_.shares(), of_gap,
                           w.hessian.data());
    } else if (settings_.rigid()) {
      const Point2<double> x = {point.shape[0] * X[2 * at(c.node[0])] + point.shape[1] * X[2 * at(c.node[1])],
                                point.shape[0] * X[2 * at(c.node[0]) + 1] +
                                    point.shape[1] * X[2 * at(c.node[1]) + 1]};
      const std::array<double, 9> H = gap_to(pose_.obstacle, {x[0], x[1], 0}).curvature;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = 0; j < 4; ++j)
          w.hessian[n * i + j] += of_gap * point.shape[i / 2] * point.shape[j / 2] * H[3 * (i % 2) + j % 2];
    } else {
      const std::array<double, 64> d2g = gap_hessian(point.shape, point.edge, point.foot);
      for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t j = 0; j < 8; ++j) w.hessian[n * i + j] += of_gap * d2g[8 * i + j];
    }
    visitor(c.node, {w.hessian.data(), n * n});
  });
}

void GaussPointForm::add_slip(const Point& point, const std::vector<double>& u, const Point2<double>& x_s,
                              bool second, Workspace& w, Constraint& c) const {
  if (anchors_.empty()) return;
  const Anchor& anchor = anchors_[at(point.index)];
  if (!anchor.valid) return;
  w.slip_gradient.fill(0);
  if (second) w.slip_hessian.fill(0);
  if (carried()) {
    const std::array<double, 3>& n = pose_.obstacle.direction;
    const ObstacleCarrier::PlaneSlip slip =
        carrier_.slip(nodes(), point.facet, point.shape, {-n[1], n[0], 0}, u);
    c.slip[0] = slip.function.value;
    carrier_.add_gradient(slip.function, point.shape, slip.shares, 1, w.slip_gradient.data());
    if (second) carrier_.add_hessian(slip.function, point.shape, slip.shares, 1, w.slip_hessian.data());
  } else if (settings_.rigid()) {
    const Point2<double> t = {-point.foot.normal[1], point.foot.normal[0]};
    const Point2<double> opposite = {anchor.place[0] + pose_.moved[0], anchor.place[1] + pose_.moved[1]};
    c.slip[0] = detail::dot(t, detail::minus(x_s, opposite));
    for (std::size_t a = 0; a < 2; ++a)
      for (std::size_t k = 0; k < 2; ++k) w.slip_gradient[2 * a + k] = point.shape[a] * t[k];
  } else {
    if (anchor.slot[0] < 0 || anchor.slot[1] < 0) return;
    std::size_t count = c.node.size();
    std::array<std::size_t, 4> place = {0, 1, 0, 0};
    for (std::size_t b = 0; b < 2; ++b) {
      const auto end = w.node.begin() + static_cast<std::ptrdiff_t>(count);
      const auto found = std::find(w.node.begin(), end, anchor.slot[b]);
      place[2 + b] = static_cast<std::size_t>(found - w.node.begin());
      if (found == end) w.node[count++] = anchor.slot[b];
    }
    c.node = {w.node.data(), count};
    const auto place_of = [&](int node) { return nodes().place(node, point.node[0], u); };
    const std::array<Point2<double>, 2> s = {place_of(point.node[0]), place_of(point.node[1])},
                                        p = {place_of(anchor.slot[0]), place_of(anchor.slot[1])};
    const Slip slip = slip_of(s, p, anchor.pair);
    c.slip[0] = slip.value - anchor.start;
    const std::size_t n = 2 * count;
    for (std::size_t i = 0; i < 8; ++i) w.slip_gradient[2 * place[i / 2] + i % 2] += slip.gradient[i];
    if (second) {
      const std::array<double, 64> H = slip_hessian(s, p, anchor.pair);
      for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t j = 0; j < 8; ++j)
          w.slip_hessian[n * (2 * place[i / 2] + i % 2) + 2 * place[j / 2] + j % 2] += H[8 * i + j];
    }
  }
  c.slides = true;
  c.slip_gradient = {w.slip_gradient.data(), 2 * c.node.size()};
}

void GaussPointForm::visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const {
  const bool rigid = settings_.rigid();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const int* ends = &nodes().secondary[at(2 * f)];
      const Point2<double> place = point_at(x, ends[a]);
      Point point;
      point.facet = f;
      const Point2<double> normal = detail::right_normal(point_at(x, ends[0]), point_at(x, ends[1]));
      if (!(rigid ? face_obstacle(pose_.obstacle, place, normal, point)
                  : face(place, normal, x, Hold(), point)))
        continue;
      // Coordinates that were meant to touch differ by rounding of their own size.
      const double depth = -point.foot.gap;
      if (depth > 1e-9 * (secondary_.length[at(f)] + std::hypot(place[0], place[1])))
        visitor(ends[a], depth, {point.foot.normal[0], point.foot.normal[1], 0});
    }
}

} // namespace impact
