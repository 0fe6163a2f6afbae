#include <impact/contact/edge_points.hpp>
#include <impact/contact/point_form_impl.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <numbers>

namespace impact {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

Point2<double> point_at(const ContactValues& x, int node) { return {x[at(2 * node)], x[at(2 * node + 1)]}; }

// Order of two edges by their reference coordinates: of two equal distances every number of ranks takes the
// same edge, which global node numbers would not give.
bool precedes(const std::vector<double>& X, const int* a, const int* b) {
  for (int i = 0; i < 2; ++i)
    if (const Point2<double> x = point_at(X, a[i]), y = point_at(X, b[i]); x != y) return x < y;
  return false;
}

PrimaryEdge<double> edge_of(const ContactNodes& nodes, int primary, const ContactValues& x) {
  const int *p = &nodes.primary[at(2 * primary)], *neighbour = &nodes.neighbour[at(2 * primary)];
  PrimaryEdge<double> edge{point_at(x, p[0]), point_at(x, p[1])};
  edge.has_previous = neighbour[0] >= 0;
  edge.has_next = neighbour[1] >= 0;
  if (edge.has_previous) edge.previous = point_at(x, neighbour[0]);
  if (edge.has_next) edge.next = point_at(x, neighbour[1]);
  return edge;
}

// Whether a surface that has parts behind others could touch here, by the normals and the depth; true for
// others.
bool may_meet(bool folded, const Foot<double>& foot, const Point2<double>& normal, double depth) {
  return !folded || (foot.gap > -depth && detail::dot(foot.normal, normal) < -least_opposition);
}

std::array<double, 2> shape_of(const ShapeValues& shape) { return {shape[0], shape[1]}; }

} // namespace

FormPoints<ShapeValues> EdgePoints::make_points(ContactSurface& surface, const ContactSettings& settings,
                                                Frame frame) {
  const int n = settings.points;
  if (n < 1 || n > 16)
    throw UserError(ExitCode::usage, "-contact_" + settings.id + "_points " + std::to_string(n) +
                                         ": allowed are 1 to 16 points per facet");
  const GaussRule rule = gauss_rule(n);
  FormPoints<Point> points{n, {}, {}, std::vector<int>(surface.length.size(), 2), surface.length};
  for (int f = 0; f < surface.count(); ++f)
    for (int q = 0; q < n; ++q) {
      const double xi = surface.reversed[at(f)] ? -rule.xi[at(q)] : rule.xi[at(q)];
      const double N0 = (1 - xi) / 2, N1 = (1 + xi) / 2;
      const double* X = &surface.X[at(4 * f)];
      const double ring = frame == Frame::axisymmetric ? 2 * std::numbers::pi * (N0 * X[0] + N1 * X[2]) : 1;
      points.shape.push_back({N0, N1, 0, 0});
      points.weight.push_back(rule.weight[at(q)] * surface.length[at(f)] / 2 * ring);
    }
  return points;
}

bool EdgePoints::faces(const CarriedFunction& gap, const Point2<double>& normal) {
  Foot<double> foot;
  foot.part = FootPart::edge;
  foot.normal = {gap.by_place[0], gap.by_place[1]};
  foot.gap = gap.value;
  return retraction(foot, normal, infinity) < infinity;
}

template <>
EdgePoints::Seen EdgePointForm::look(const Facet& facet, const ShapeValues& shape, int candidate,
                                     const ContactValues& x) const {
  Seen seen;
  seen.candidate = candidate;
  seen.edge = edge_of(nodes(), search_.candidates().facet[at(candidate)], x);
  seen.foot = foot_on_line(place_on(facet.node, shape), seen.edge);
  return seen;
}

template <>
EdgePoints::Seen EdgePointForm::nearest(const Facet& facet, const ShapeValues& shape,
                                        const ContactValues& x) const {
  const Point2<double> here = place_on(facet.node, shape);
  double nearest = infinity;
  Seen best;
  const Candidates& list = search_.candidates();
  for (int c : list.of(at(facet.number))) {
    const PrimaryEdge<double> edge = edge_of(nodes(), list.facet[at(c)], x);
    const Foot<double> foot = closest_point(here, edge);
    const double distance = retraction(foot, facet.normal, search_.radius());
    if (!may_meet(folded(), foot, facet.normal, depth(facet.number))) continue;
    if (!(distance < nearest || (distance == nearest && distance < infinity &&
                                 precedes(nodes().X, primary_slots(c), primary_slots(best.candidate)))))
      continue;
    nearest = distance;
    best = {c, 0, foot, edge};
  }
  if (best.candidate >= 0 && !search_.counts(best.candidate)) best.candidate = -1;
  return best;
}

template <>
bool EdgePointForm::held(const Facet& facet, const ShapeValues& shape, const ContactValues& x,
                         const Hold& hold, Seen& seen) const {
  seen = look(facet, shape, hold.candidate, x);
  const Foot<double>& foot = seen.foot;
  // An iterate that flies off altogether, or over an open end, is judged as a point that nothing holds.
  const bool goes_on = foot.xi < 0 ? seen.edge.has_previous : seen.edge.has_next;
  return !(std::abs(foot.xi) > (goes_on ? 1 + EdgePoints::hold.limit : 1.0)) &&
         retraction(foot, facet.normal, search_.radius()) < infinity &&
         may_meet(folded(), foot, facet.normal, depth(facet.number));
}

template <>
EdgePoints::Seen EdgePointForm::passed(const Facet& facet, const ShapeValues& shape,
                                       const ContactValues& x) const {
  Seen first;
  if (nodes().start.empty()) return first;
  const Point2<double> here = place_on(facet.node, shape),
                       before = place_on(
                           corners_at<EdgeCorners>(secondary_slots(facet.number), nodes().start), shape);
  double earliest = infinity;
  const double deep = depth(facet.number);
  const Candidates& list = search_.candidates();
  for (int c : list.of(at(facet.number))) {
    const Seen seen = look(facet, shape, c, x);
    const Foot<double>& foot = seen.foot;
    if (!(foot.gap < -deep) || !(retraction(foot, facet.normal, infinity) < infinity)) continue;
    if (!may_meet(folded(), foot, facet.normal, infinity)) continue;
    // Positions between the start and now are taken as straight in time.
    const PrimaryEdge<double> edge_n = edge_of(nodes(), list.facet[at(c)], nodes().start);
    const double gap_n = foot_on_line(before, edge_n).gap;
    if (gap_n < -deep) continue;
    const double part = gap_n > 0 ? gap_n / (gap_n - foot.gap) : 0;
    auto between = [part](const Point2<double>& from, const Point2<double>& to) {
      return Point2<double>{from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])};
    };
    const PrimaryEdge<double> then{between(edge_n.x0, seen.edge.x0), between(edge_n.x1, seen.edge.x1)};
    if (!(std::abs(foot_on_line(between(before, here), then).xi) <= 1 + 1e-6)) continue;
    if (!(part < earliest ||
          (part == earliest && precedes(nodes().X, primary_slots(c), primary_slots(first.candidate)))))
      continue;
    earliest = part;
    first = seen;
  }
  if (first.candidate >= 0 && !search_.counts(first.candidate)) first.candidate = -1;
  return first;
}

template <>
void EdgePointForm::sharpen(int facet, std::size_t number, const ContactValues& u, Seen& seen) const {
  if (seen.foot.part != FootPart::edge) return;
  const int* primary = primary_slots(seen.candidate);
  const auto p = corners_from<EdgeCorners>(primary[0], primary, u);
  seen.foot = foot_on_line(
      place_on(corners_from<EdgeCorners>(primary[0], secondary_slots(facet), u), points_.shape[number]),
      PrimaryEdge<double>{p[0], p[1]});
}

template <>
EdgePointForm::Row EdgePointForm::gap_gradient(const Facet&, std::size_t number, const Seen& seen) const {
  return impact::gap_gradient(shape_of(points_.shape[number]), seen.foot);
}

template <>
void EdgePointForm::add_gap_hessian(const Facet&, std::size_t number, const Seen& seen, double factor,
                                    Matrix& hessian) const {
  const std::array<double, 64> H = gap_hessian(shape_of(points_.shape[number]), seen.edge, seen.foot);
  for (std::size_t i = 0; i < H.size(); ++i) hessian[i] += factor * H[i];
}

template class PointForm<EdgePoints>;

std::unique_ptr<ContactForm> make_edge_point_form(const FormRequest& request) {
  return std::make_unique<EdgePointForm>(request);
}

} // namespace impact
