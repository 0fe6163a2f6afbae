#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/petsc/error.hpp>
#include <limits>

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

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); });
}

double largest_move(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); i += 2) {
    const double dx = a[i] - b[i], dy = a[i + 1] - b[i + 1];
    largest = std::max(largest, dx * dx + dy * dy);
  }
  return std::sqrt(largest);
}

// Of the nodes [slot].
double largest_move(const std::vector<double>& a, const std::vector<double>& b,
                    const std::vector<int>& slots) {
  double largest = 0;
  for (int slot : slots)
    largest = std::max(
        largest, std::hypot(a[at(2 * slot)] - b[at(2 * slot)], a[at(2 * slot + 1)] - b[at(2 * slot + 1)]));
  return largest;
}

void sort_unique(std::vector<PetscInt>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

// Order of two edges by their reference coordinates: of two equal distances every number of ranks takes the
// same edge, which global node numbers would not give.
bool precedes(const std::vector<double>& X, const int* a, const int* b) {
  for (int i = 0; i < 2; ++i)
    if (const Point2<double> x = point_at(X, a[i]), y = point_at(X, b[i]); x != y) return x < y;
  return false;
}

// The rigid plane is flat and stands still under a variation: only the square of the first variation remains.
std::array<double, 64> tangent_block(const ContactPoint& point, double scale, double eps) {
  const std::array<double, 64> d2g =
      point.node_count == 4 ? gap_hessian(point.shape, point.edge, point.foot) : std::array<double, 64>{};
  return contact_tangent(scale * point.weight, eps, point.pressure, gap_gradient(point.shape, point.foot),
                         d2g);
}

int position(const std::vector<PetscInt>& sorted, PetscInt value) {
  return static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
}

// The point faces this edge, whose nodes are p[0] and p[1] in the interface's list.
void stand_on(const PrimaryEdge<double>& edge, const Foot<double>& foot, const int* p, ContactPoint& point) {
  point.foot = foot;
  point.edge = edge;
  point.node[2] = p[0];
  point.node[3] = p[1];
}

} // namespace

void ContactInterface::set_time(double t, double mass_shift) {
  time_ = t;
  penalty_->trial[2] = inertia_penalty_ * mass_shift;
  std::fill(holds_.begin(), holds_.end(), Hold());
  switched_ = false;
  fetch_start();
}

void ContactInterface::fetch_start() {
  const StateRow* row = state_->find("u");
  if (row == nullptr || against_plane()) return;
  const Handle<Vec> u_n = layout_->make_global();
  layout_->to_global(row->committed, u_n);
  search_.start = search_.own.gather(u_n);
  for (std::size_t i = 0; i < search_.start.size(); ++i) search_.start[i] += search_.own_X[i];
  active_.start = current(u_n);
}

bool ContactInterface::update_search(Vec u) {
  if (against_plane() && !search_.outdated) return false;
  std::vector<double> x = search_.own.gather(u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += search_.own_X[i];
  const bool finite = all_finite(x);
  // Not a number; moved since the list was built; moved since the start of the step, by side.
  std::array<double, 4> mine = {finite ? 0.0 : 1.0, 0, 0, 0}, all{};
  if (finite && !search_.outdated) mine[1] = largest_move(x, search_.built_at);
  if (finite && !search_.start.empty()) {
    mine[2] = largest_move(x, search_.start, secondary_.slot);
    mine[3] = largest_move(x, search_.start, primary_.slot);
  }
  MPI_Allreduce(mine.data(), all.data(), 4, MPI_DOUBLE, MPI_MAX, mesh_->comm());
  // A displacement that is not finite ends the attempt elsewhere; the list in hand stays.
  if (all[0] > 0) return false;
  const double motion = all[2] + all[3];
  bool changed = false;
  if (search_.outdated || all[1] > search_.skin / 2 || motion > search_.reach) {
    search_.reach = std::max(search_.radius, motion);
    Candidates found = search(x);
    changed = !all_ranks_agree(mesh_->comm(), found.same_pairs(search_.candidates));
    search_.candidates = std::move(found);
    search_.built_at = std::move(x);
    search_.outdated = false;
    build_active(u);
  }
  if (!against_plane()) hold_edges(current(u));
  return changed;
}

Candidates ContactInterface::search(const std::vector<double>& x) const {
  if (against_plane()) return {};
  SearchSecondary secondary;
  secondary.node = secondary_.surface.node;
  for (int slot : secondary_.slot) {
    secondary.x.push_back(x[at(2 * slot)]);
    secondary.x.push_back(x[at(2 * slot + 1)]);
  }
  std::vector<SearchFacet> primary;
  for (int f = 0; f < primary_.surface.count(); ++f) {
    const std::size_t a = at(2 * f), b = a + 1;
    const Point2<double> x0 = point_at(x, primary_.slot[a]), x1 = point_at(x, primary_.slot[b]);
    primary.push_back({{primary_.surface.node[a], primary_.surface.node[b]},
                       {primary_.neighbour[a], primary_.neighbour[b]},
                       {x0[0], x0[1], x1[0], x1[1]}});
  }
  return find_candidates(mesh_->comm(), secondary, primary, search_.reach + search_.skin);
}

void ContactInterface::build_active(Vec u) {
  Active next;
  next.nodes = secondary_.surface.node;
  for (const SearchFacet& facet : search_.candidates.primary)
    for (PetscInt node : {facet.node[0], facet.node[1], facet.neighbour[0], facet.neighbour[1]})
      if (node >= 0) next.nodes.push_back(node);
  sort_unique(next.nodes);
  for (PetscInt node : secondary_.surface.node) next.secondary.push_back(position(next.nodes, node));
  for (const SearchFacet& facet : search_.candidates.primary)
    for (PetscInt node : {facet.node[0], facet.node[1], facet.neighbour[0], facet.neighbour[1]})
      next.primary.push_back(node >= 0 ? position(next.nodes, node) : -1);
  next.exchange = NodeExchange(mesh_->comm(), mesh_->owned_node_count(), 2, next.nodes);
  active_ = std::move(next);
  const Handle<Vec> X = layout_->make_global();
  layout_->to_global(std::vector<double>(mesh_->coordinates().begin(), mesh_->coordinates().end()), X);
  active_.X = active_.exchange.gather(X);
  active_.built_at = current(u);
  fetch_fixed();
  if (!search_.start.empty()) fetch_start();
}

void ContactInterface::fetch_fixed() {
  active_.fixed.assign(2 * active_.nodes.size(), 0);
  if (!fixed_) return;
  const std::vector<double> flags = active_.exchange.gather(fixed_);
  std::transform(flags.begin(), flags.end(), active_.fixed.begin(), [](double f) { return f > 0.5 ? 1 : 0; });
}

void ContactInterface::set_fixed_dofs(const std::vector<char>& fixed) {
  if (!fixed_) fixed_ = layout_->make_global();
  layout_->to_global(std::vector<double>(fixed.begin(), fixed.end()), fixed_);
  fetch_fixed();
}

std::vector<std::pair<PetscInt, PetscInt>> ContactInterface::couplings() const {
  std::vector<std::pair<PetscInt, PetscInt>> pairs;
  const Candidates& list = search_.candidates;
  for (int f = 0; f + 1 < static_cast<int>(list.offset.size()); ++f)
    for (int c = list.offset[at(f)]; c < list.offset[at(f + 1)]; ++c)
      for (PetscInt p : list.primary[at(list.facet[at(c)])].node)
        for (std::size_t a = 0; a < 2; ++a) pairs.emplace_back(secondary_.surface.node[at(2 * f) + a], p);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

std::vector<double> ContactInterface::current(Vec u) const {
  std::vector<double> x = active_.exchange.gather(u);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += active_.X[i];
  return x;
}

Foot<double> ContactInterface::plane_foot(const Point2<double>& x) const {
  Point2<double> d = {x[0] - settings_.plane_point[0], x[1] - settings_.plane_point[1]};
  if (environment_.plane_motion) d = detail::minus(d, environment_.plane_motion(time_));
  Foot<double> foot;
  foot.part = FootPart::edge;
  foot.normal = {settings_.plane_normal[0], settings_.plane_normal[1]};
  foot.gap = detail::dot(d, foot.normal);
  return foot;
}

PrimaryEdge<double> ContactInterface::primary_edge(int candidate,
                                                   const std::vector<double>& coordinates) const {
  const int* p = &active_.primary[at(4 * search_.candidates.facet[at(candidate)])];
  PrimaryEdge<double> edge{point_at(coordinates, p[0]), point_at(coordinates, p[1])};
  edge.has_previous = p[2] >= 0;
  edge.has_next = p[3] >= 0;
  if (edge.has_previous) edge.previous = point_at(coordinates, p[2]);
  if (edge.has_next) edge.next = point_at(coordinates, p[3]);
  return edge;
}

bool ContactInterface::face(const Point2<double>& x, const Point2<double>& normal,
                            const std::vector<double>& coordinates, const Hold& hold,
                            ContactPoint& point) const {
  if (against_plane()) {
    point.node_count = 2;
    point.foot = plane_foot(x);
    return retraction(point.foot, normal, infinity) < infinity;
  }
  return face_held(x, normal, coordinates, hold, point) || face_nearest(x, normal, coordinates, point) ||
         face_passed(x, normal, coordinates, point);
}

bool ContactInterface::face_nearest(const Point2<double>& x, const Point2<double>& normal,
                                    const std::vector<double>& coordinates, ContactPoint& point) const {
  double nearest = infinity;
  const Candidates& list = search_.candidates;
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &active_.primary[at(4 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = closest_point(x, edge);
    const double distance = retraction(foot, normal, search_.radius);
    if (!(distance < nearest ||
          (distance == nearest && distance < infinity && precedes(active_.X, p, &point.node[2]))))
      continue;
    nearest = distance;
    stand_on(edge, foot, p, point);
  }
  return nearest < infinity;
}

bool ContactInterface::face_held(const Point2<double>& x, const Point2<double>& normal,
                                 const std::vector<double>& coordinates, const Hold& hold,
                                 ContactPoint& point) const {
  if (hold.edge[0] < 0) return false;
  const Candidates& list = search_.candidates;
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    if (list.primary[at(list.facet[at(c)])].node != hold.edge) continue;
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    // An iterate that flies off altogether, or over an open end, is judged as a point that nothing holds.
    const bool goes_on = foot.xi < 0 ? edge.has_previous : edge.has_next;
    if (std::abs(foot.xi) > (goes_on ? hold_limit : 1.0)) return false;
    if (!(retraction(foot, normal, search_.radius) < infinity)) return false;
    stand_on(edge, foot, &active_.primary[at(4 * list.facet[at(c)])], point);
    return true;
  }
  return false;
}

bool ContactInterface::face_passed(const Point2<double>& x, const Point2<double>& normal,
                                   const std::vector<double>& coordinates, ContactPoint& point) const {
  if (active_.start.empty()) return false;
  const Point2<double> a = point_at(active_.start, point.node[0]), b = point_at(active_.start, point.node[1]);
  const Point2<double> x_n = {point.shape[0] * a[0] + point.shape[1] * b[0],
                              point.shape[0] * a[1] + point.shape[1] * b[1]};
  double earliest = infinity;
  const Candidates& list = search_.candidates;
  for (int c = list.offset[at(point.facet)]; c < list.offset[at(point.facet + 1)]; ++c) {
    const int* p = &active_.primary[at(4 * list.facet[at(c)])];
    const PrimaryEdge<double> edge = primary_edge(c, coordinates);
    const Foot<double> foot = foot_on_line(x, edge);
    if (!(foot.gap < -search_.radius) || !(retraction(foot, normal, infinity) < infinity)) continue;
    // Positions between the start and now are taken as straight in time.
    const PrimaryEdge<double> before = primary_edge(c, active_.start);
    const double gap_n = foot_on_line(x_n, before).gap;
    if (gap_n < -search_.radius) continue;
    const double part = gap_n > 0 ? gap_n / (gap_n - foot.gap) : 0;
    auto between = [part](const Point2<double>& from, const Point2<double>& to) {
      return Point2<double>{from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])};
    };
    const PrimaryEdge<double> then{between(before.x0, edge.x0), between(before.x1, edge.x1)};
    if (!(std::abs(foot_on_line(between(x_n, x), then).xi) <= 1 + 1e-6)) continue;
    if (!(part < earliest || (part == earliest && precedes(active_.X, p, &point.node[2])))) continue;
    earliest = part;
    stand_on(edge, foot, p, point);
  }
  return earliest < infinity;
}

void ContactInterface::hold_edges(const std::vector<double>& x) {
  switched_ = false;
  const double eps = penalty();
  for (int f = 0; f < secondary_.surface.count(); ++f) {
    ContactPoint point;
    point.facet = f;
    point.node = {active_.secondary[at(2 * f)], active_.secondary[at(2 * f + 1)], -1, -1};
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    const Point2<double> normal = detail::right_normal(x0, x1);
    for (int q = 0; q < points_.per_facet; ++q) {
      const int index = f * points_.per_facet + q;
      const double* N = &points_.shape[at(2 * index)];
      point.shape = {N[0], N[1]};
      const Point2<double> x_s = {N[0] * x0[0] + N[1] * x1[0], N[0] * x0[1] + N[1] * x1[1]};
      Hold& hold = holds_[at(index)];
      ContactPoint nearest = point, before = point, after = point;
      const bool had = face(x_s, normal, x, hold, before);
      Hold next{{-1, -1}, hold.switches};
      if (hold.switches < switch_limit && face_nearest(x_s, normal, x, nearest)) {
        auto stays_on = [&](const Foot<double>& line) {
          return std::abs(line.xi) <= 1 + hold_overlap && std::abs(line.gap - nearest.foot.gap) <= hold_gap_;
        };
        const Point2<double> t = detail::minus(nearest.edge.x1, nearest.edge.x0);
        if (std::abs(nearest.foot.gap) > hold_range * std::sqrt(detail::dot(t, t)))
          next.edge = {-1, -1};
        else if (ContactPoint held = point; face_held(x_s, normal, x, hold, held) && stays_on(held.foot))
          next.edge = hold.edge;
        else if (stays_on(foot_on_line(x_s, nearest.edge)))
          next.edge = {active_.nodes[at(nearest.node[2])], active_.nodes[at(nearest.node[3])]};
      }
      const bool has = face(x_s, normal, x, next, after);
      const double lambda = multiplier_->trial[at(index)];
      auto presses = [&](bool faces, const ContactPoint& p) {
        return faces && contact_pressure(lambda, eps, p.foot.gap) > 0;
      };
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

void ContactInterface::sharpen(const std::vector<double>& u, ContactPoint& point) const {
  if (point.node_count != 4 || point.foot.part != FootPart::edge) return;
  std::array<Point2<double>, 4> y{};
  const std::size_t origin = at(2 * point.node[2]);
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t k = 0; k < 2; ++k) {
      const std::size_t i = at(2 * point.node[a]) + k;
      y[a][k] = (active_.X[i] - active_.X[origin + k]) + (u[i] - u[origin + k]);
    }
  const Point2<double> x = {point.shape[0] * y[0][0] + point.shape[1] * y[1][0],
                            point.shape[0] * y[0][1] + point.shape[1] * y[1][1]};
  point.foot = foot_on_line(x, PrimaryEdge<double>{y[2], y[3]});
}

std::vector<ContactPoint> ContactInterface::points(Vec at_u, ContactStatus* status) const {
  const std::vector<double> u = active_.exchange.gather(at_u);
  std::vector<double> x = u;
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += active_.X[i];
  std::vector<ContactPoint> list;
  const double eps = penalty();
  ContactStatus seen;
  seen.finite = all_finite(x);
  seen.search_holds = against_plane() || largest_move(x, active_.built_at) <= search_.skin / 2;
  for (int f = 0; f < secondary_.surface.count(); ++f) {
    ContactPoint point;
    point.facet = f;
    point.node = {active_.secondary[at(2 * f)], active_.secondary[at(2 * f + 1)], -1, -1};
    const Point2<double> x0 = point_at(x, point.node[0]), x1 = point_at(x, point.node[1]);
    const Point2<double> normal = detail::right_normal(x0, x1);
    const double stretch = std::hypot(x1[0] - x0[0], x1[1] - x0[1]) / secondary_.surface.length[at(f)];
    for (int q = 0; q < points_.per_facet; ++q) {
      point.index = f * points_.per_facet + q;
      point.shape = {points_.shape[at(2 * point.index)], points_.shape[at(2 * point.index + 1)]};
      const Point2<double> x_s = {point.shape[0] * x0[0] + point.shape[1] * x1[0],
                                  point.shape[0] * x0[1] + point.shape[1] * x1[1]};
      if (!face(x_s, normal, x, holds_[at(point.index)], point)) continue;
      sharpen(u, point);
      point.weight = points_.weight[at(point.index)];
      point.stretch = stretch;
      if (environment_.frame == Frame::axisymmetric)
        point.stretch *= x_s[0] / (point.shape[0] * active_.X[at(2 * point.node[0])] +
                                   point.shape[1] * active_.X[at(2 * point.node[1])]);
      point.lambda = multiplier_->trial[at(point.index)];
      point.pressure = contact_pressure(point.lambda, eps, point.foot.gap);
      if (point.pressure > 0) ++seen.active;
      seen.penetration = std::max(seen.penetration, -point.foot.gap);
      list.push_back(point);
    }
  }
  if (status != nullptr) *status = seen;
  return list;
}

ContactStatus ContactInterface::add_residual(Vec u, double scale, Vec r) const {
  ContactStatus status;
  std::vector<double> f(active_.X.size(), 0.0);
  for (const ContactPoint& point : points(u, &status)) {
    if (!(point.pressure > 0)) continue;
    const std::array<double, 8> dg = gap_gradient(point.shape, point.foot);
    for (int a = 0; a < point.node_count; ++a)
      for (int k = 0; k < 2; ++k)
        f[at(2 * point.node[at(a)] + k)] -= scale * point.weight * point.pressure * dg[at(2 * a + k)];
  }
  active_.exchange.add(f, r);
  return status;
}

ContactStatus ContactInterface::add_tangent(Vec u, double scale, Mat K) const {
  ContactStatus status;
  const double eps = penalty();
  for (const ContactPoint& point : points(u, &status)) {
    if (!(point.pressure > 0)) continue;
    const std::array<double, 64> block = tangent_block(point, scale, eps);
    std::array<PetscInt, 8> dof{};
    for (int a = 0; a < point.node_count; ++a)
      for (int k = 0; k < 2; ++k) {
        const std::size_t i = at(2 * point.node[at(a)] + k);
        // PETSc leaves out rows and columns with a negative index.
        dof[at(2 * a + k)] = active_.fixed[i] ? -1 : 2 * active_.nodes[at(point.node[at(a)])] + k;
      }
    const int n = 2 * point.node_count;
    std::array<double, 64> packed{};
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) packed[at(n * i + j)] = block[at(8 * i + j)];
    check(MatSetValues(K, n, dof.data(), n, dof.data(), packed.data(), ADD_VALUES));
  }
  return status;
}

void ContactInterface::multiply(Vec u, double scale, Vec du, Vec y) const {
  std::vector<double> d = active_.exchange.gather(du), f(active_.X.size(), 0.0);
  for (std::size_t i = 0; i < d.size(); ++i)
    if (active_.fixed[i]) d[i] = 0;
  const double eps = penalty();
  for (const ContactPoint& point : points(u, nullptr)) {
    if (!(point.pressure > 0)) continue;
    const std::array<double, 64> block = tangent_block(point, scale, eps);
    for (int i = 0; i < 2 * point.node_count; ++i)
      for (int j = 0; j < 2 * point.node_count; ++j)
        f[at(2 * point.node[at(i / 2)] + i % 2)] +=
            block[at(8 * i + j)] * d[at(2 * point.node[at(j / 2)] + j % 2)];
  }
  for (std::size_t i = 0; i < f.size(); ++i)
    if (active_.fixed[i]) f[i] = 0;
  active_.exchange.add(f, y);
}

} // namespace impact
