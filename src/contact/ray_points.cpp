#include <impact/contact/point_form_impl.hpp>
#include <impact/contact/ray_points.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>
#include <numbers>

namespace impact {

namespace {

// A foot belongs to a facet if no part of it is below minus this; beyond the sides of the whole surface
// contact goes on by this part of one.
constexpr double inside = 1e-9, beyond = 0.01;
constexpr int largest_rule = 16;

Point3 point3(const ContactValues& x, int node) {
  return {x[at(3 * node)], x[at(3 * node + 1)], x[at(3 * node + 2)]};
}

template <class Foot> double least_part(const Foot& foot) {
  return *std::min_element(foot.part.begin(), foot.part.end());
}

FaceCorners reference(const ContactSurface& surface, int f) {
  return {point3(surface.X, 4 * f), point3(surface.X, 4 * f + 1), point3(surface.X, 4 * f + 2),
          point3(surface.X, 4 * f + 3)};
}

double area_at(const FaceCorners& x) {
  const std::array<double, 4> parts = nodal_areas(x);
  return parts[0] + parts[1] + parts[2] + parts[3];
}

// The corner with the smallest coordinates first: points are then numbered in the same way by every
// partition, so that what is kept per point can move to other ranks.
void start_at_smallest_corner(ContactSurface& surface) {
  const std::size_t width = at(surface.per_facet);
  const bool curved = width > 4;
  for (int f = 0; f < surface.count(); ++f) {
    const std::size_t first = width * at(f);
    const std::ptrdiff_t corners = curved ? stored_corners(surface.per_facet)
                                   : surface.node[first + 3] == surface.node[first + 2] ? 3
                                                                                        : 4;
    std::array<Point3, std::tuple_size_v<GlobalFacet>> X;
    for (std::size_t a = 0; a < width; ++a) std::copy_n(&surface.X[3 * (first + a)], 3, X[a].begin());
    const std::ptrdiff_t smallest = std::min_element(X.begin(), X.begin() + corners) - X.begin();
    const auto turn = [&](auto* values) {
      std::rotate(values, values + smallest, values + corners);
      if (curved)
        std::rotate(values + corners, values + corners + smallest, values + 2 * corners);
      else if (corners == 3)
        values[3] = values[2];
    };
    turn(X.data());
    turn(&surface.node[first]);
    turn(&surface.local[first]);
    for (std::size_t a = 0; a < width; ++a) std::copy_n(X[a].begin(), 3, &surface.X[3 * (first + a)]);
  }
}

int checked_points(const ContactSettings& settings) {
  if (settings.points < 1 || settings.points > largest_rule)
    throw UserError(ExitCode::usage, "-contact_" + settings.id + "_points " +
                                         std::to_string(settings.points) + ": allowed on faces are 1 to " +
                                         std::to_string(largest_rule) + " points in each direction");
  return settings.points;
}

template <class Shape> typename CurvedRay<Shape>::Nodes reference(const ContactSurface& surface, int f) {
  typename CurvedRay<Shape>::Nodes X;
  const double* from = &surface.X[X.size() * X[0].size() * at(f)];
  for (auto& node : X) {
    std::copy_n(from, node.size(), node.begin());
    from += node.size();
  }
  return X;
}

template <std::size_t dim> double density_of(const std::array<double, dim>& area) {
  double square = 0;
  for (double component : area) square += component * component;
  return std::sqrt(square);
}

FaceRay ray_between(const FaceCorners& x, const ShapeValues& point, const FaceCorners& p) {
  return {x, point, p};
}
template <class Nodes, class Shape>
CurvedRay<Shape> ray_between(const Nodes& x, const FacetPlace<Shape>& point, const Nodes& p) {
  return {x, point, p};
}

} // namespace

FormPoints<ShapeValues> FacePoints::make_points(ContactSurface& surface, const ContactSettings& settings,
                                                Frame) {
  const int n = checked_points(settings);
  start_at_smallest_corner(surface);
  FormPoints<Point> points;
  points.per_facet = n * n;
  points.shape.assign(at(surface.count() * points.per_facet), {});
  points.weight.assign(points.shape.size(), 0.0);
  const TriangleRule triangle = triangle_rule(n);
  const GaussRule line = gauss_rule(n);
  for (int f = 0; f < surface.count(); ++f) {
    const int corners = corners_of(reference(surface, f));
    const double area = area_at(reference(surface, f));
    points.nodes.push_back(corners);
    points.size.push_back(area);
    std::size_t number = points.index(f, 0);
    const auto add = [&](const std::array<double, 4>& shape, double weight) {
      points.shape[number] = shape;
      points.weight[number++] = weight;
    };
    if (corners == 3) {
      for (std::size_t q = 0; q < triangle.part.size(); ++q)
        add({triangle.part[q][0], triangle.part[q][1], triangle.part[q][2], 0}, triangle.weight[q] * area);
      continue;
    }
    for (std::size_t i = 0; i < line.xi.size(); ++i)
      for (std::size_t j = 0; j < line.xi.size(); ++j) {
        const double r = line.xi[i], s = line.xi[j];
        const std::array<double, 4> of_r = {-(1 - s) / 4, (1 - s) / 4, (1 + s) / 4, -(1 + s) / 4},
                                    of_s = {-(1 - r) / 4, -(1 + r) / 4, (1 + r) / 4, (1 - r) / 4};
        Point3 along_r{}, along_s{};
        for (int a = 0; a < 4; ++a) {
          const Point3 X = point3(surface.X, 4 * f + a);
          for (std::size_t k = 0; k < 3; ++k) {
            along_r[k] += of_r[at(a)] * X[k];
            along_s[k] += of_s[at(a)] * X[k];
          }
        }
        const double across = dot(along_r, along_s);
        const double density = std::sqrt(dot(along_r, along_r) * dot(along_s, along_s) - across * across);
        add({(1 - r) * (1 - s) / 4, (1 + r) * (1 - s) / 4, (1 + r) * (1 + s) / 4, (1 - r) * (1 + s) / 4},
            line.weight[i] * line.weight[j] * density);
      }
  }
  return points;
}

TangentRows<3, 4> FacePoints::tangents(const ContactSurface& surface, int f, const Point&) {
  return make_face_map(reference(surface, f)).row;
}

double FacePoints::size(const FaceCorners&, const FaceCorners& from_first, const Point&) {
  return area_at(from_first);
}

template <class Shape>
FormPoints<FacetPlace<Shape>> CurvedPoints<Shape>::make_points(ContactSurface& surface,
                                                               const ContactSettings& settings, Frame frame) {
  const int n = checked_points(settings);
  std::vector<typename Shape::Point> place; // of the reference facet, and areas
  std::vector<double> weight;
  if constexpr (dim == 2) {
    const GaussRule rule = gauss_rule(n);
    for (double xi : rule.xi) place.push_back({xi});
    weight = rule.weight;
  } else {
    start_at_smallest_corner(surface);
    if (Shape::Corners::nodes == 3) {
      const TriangleRule rule = triangle_rule(n);
      for (const std::array<double, 3>& part : rule.part) place.push_back({part[1], part[2]});
      for (double part : rule.weight) weight.push_back(part / 2);
    } else {
      const GaussRule line = gauss_rule(n);
      for (std::size_t i = 0; i < line.xi.size(); ++i)
        for (std::size_t j = 0; j < line.xi.size(); ++j) {
          place.push_back({line.xi[i], line.xi[j]});
          weight.push_back(line.weight[i] * line.weight[j]);
        }
    }
  }
  FormPoints<Point> points{
      static_cast<int>(place.size()), {}, {}, std::vector<int>(surface.length.size(), Shape::nodes), {}};
  for (int f = 0; f < surface.count(); ++f) {
    const Nodes X = impact::reference<Shape>(surface, f);
    for (std::size_t q = 0; q < place.size(); ++q) {
      typename Shape::Point xi = place[q];
      if (dim == 2 && surface.reversed[at(f)]) xi[0] = -xi[0];
      const Point point = Point::at(xi);
      double ring = 0; // radius
      for (std::size_t a = 0; a < nodes; ++a) ring += point.N[a] * X[a][0];
      ring = frame == Frame::axisymmetric ? 2 * std::numbers::pi * ring : 1;
      points.shape.push_back(point);
      points.size.push_back(density_of(facet_area<Shape>(X, point)));
      points.weight.push_back(weight[q] * points.size.back() * ring);
    }
  }
  return points;
}

template <class Shape>
auto CurvedPoints<Shape>::tangents(const ContactSurface& surface, int f, const Point& point)
    -> TangentRows<dim, nodes> {
  TangentRows<dim, nodes> natural;
  for (std::size_t i = 0; i < natural.size(); ++i)
    for (std::size_t a = 0; a < nodes; ++a) natural[i][a] = point.dN[a][i];
  return tangent_rows<dim, nodes>(impact::reference<Shape>(surface, f), natural);
}

template <class Shape>
double CurvedPoints<Shape>::size(const Nodes&, const Nodes& from_first, const Point& point) {
  return density_of(facet_area<Shape>(from_first, point));
}

template <class G>
auto PointForm<G>::look(const Facet& facet, const Point& point, int candidate, const ContactValues& x) const
    -> Seen {
  const int* slot = primary_slots(candidate);
  if (facet.u == nullptr)
    return {candidate, cast_ray(ray_between(facet.node, point, corners_at<Nodes>(slot, x)))};
  const int origin = secondary_slots(facet.number)[0];
  return {candidate, cast_ray(ray_between(facet.from, point, corners_from<Nodes>(origin, slot, *facet.u)))};
}

// By normals and depth.
template <class G>
bool PointForm<G>::may_touch(const Facet& facet, const Point& point, const Seen& seen) const {
  if (!(seen.foot.opposition < -least_opposition) || !(seen.foot.gap < search_.radius())) return false;
  const double deep = depth(facet.number);
  if (seen.foot.gap > -deep) return true;
  // So deep only what came through the surface within this step.
  if (nodes().start.empty()) return false;
  const Seen before = look(facet_at(facet.number, nodes().start), point, seen.candidate, nodes().start);
  return -least_opposition > before.foot.opposition && before.foot.gap > -deep;
}

template <class G> void PointForm<G>::look_around(const Facet& facet, const ContactValues& x) const {
  Surroundings& around = *facet.around;
  if (around.balls.empty())
    for (std::size_t slot = 0; slot < vertices().primary.size(); slot += width)
      around.balls.emplace_back(corners_at<Nodes>(&vertices().primary[slot], x));
  around.near.clear();
  around.view.emplace(facet.node, facet.normal, SightLimits{search_.radius(), beyond, G::weight_sum});
  for (int c : search_.candidates().of(at(facet.number)))
    if (const FacetBall<Place>& ball = around.balls[at(primary_part(c))]; around.view->sees(ball))
      around.near.push_back({c, &ball, {}});
}

// What lies before the point, or behind it: the nearest; beside the surface, what is next to it.
template <class G>
auto PointForm<G>::nearest(const Facet& facet, const Point& point, const ContactValues& x) const -> Seen {
  // By reference coordinates: of two equal distances every number of ranks takes the same facet.
  const auto key = [&](int c) {
    Nodes face = corners_at<Nodes>(primary_slots(c), nodes().X);
    std::sort(face.begin(), face.end());
    return face;
  };
  Seen best;
  bool best_inside = false;
  const double equal = 1e-9 * secondary_.length[at(facet.number)];
  if (!facet.around->view) look_around(facet, x);
  const auto& view = *facet.around->view;
  const auto line = view.line(place_on(facet.node, point), normal_at(facet, point));
  for (auto& [c, ball, outline] : facet.around->near) {
    if (view.misses(line, *ball)) continue;
    if (!outline) outline.emplace(corners_at<Nodes>(primary_slots(c), x), primary_corners(c), view);
    if (outline->misses(line)) continue;
    const Seen seen = look(facet, point, c, x);
    const double least = least_part(seen.foot);
    if (!(least >= -beyond) || !may_touch(facet, point, seen)) continue;
    const bool is_inside = least >= -inside;
    bool better = best.candidate < 0;
    if (!better && is_inside != best_inside) {
      better = is_inside;
    } else if (!better && is_inside) {
      const double nearer = std::abs(best.foot.gap) - std::abs(seen.foot.gap);
      better = nearer > equal || (nearer > -equal && key(c) < key(best.candidate));
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

template <class G>
bool PointForm<G>::held(const Facet& facet, const Point& point, const ContactValues& x, const Hold& hold,
                        Seen& seen) const {
  seen = look(facet, point, hold.candidate, x);
  return least_part(seen.foot) > -G::hold.limit && may_touch(facet, point, seen);
}

template <class G> auto PointForm<G>::passed(const Facet&, const Point&, const ContactValues&) const -> Seen {
  return {}; // may_touch says which
}

template <class G> auto PointForm<G>::ray_of(const Facet& facet, std::size_t number, const Seen& seen) const {
  const int origin = secondary_slots(facet.number)[0];
  return ray_between(facet.from, points_.shape[number],
                     corners_from<Nodes>(origin, primary_slots(seen.candidate), *facet.u));
}

template <class G> void PointForm<G>::sharpen(int, std::size_t, const ContactValues&, Seen&) const {
  // Its ray was cast with all digits.
}

template <class G>
auto PointForm<G>::gap_gradient(const Facet& facet, std::size_t number, const Seen& seen) const -> Row {
  return ray_gradient(ray_of(facet, number, seen), seen.foot);
}

template <class G>
void PointForm<G>::add_gap_hessian(const Facet& facet, std::size_t number, const Seen& seen, double factor,
                                   Matrix& hessian) const {
  add_ray_hessian(ray_of(facet, number, seen), seen.foot, factor, hessian);
}

template class PointForm<FacePoints>;
template class PointForm<CurvedPoints<Line3>>;
template class PointForm<CurvedPoints<Tri6>>;
template class PointForm<CurvedPoints<Quad8>>;
template class PointForm<CurvedPoints<Quad9>>;

std::unique_ptr<ContactForm> make_ray_point_form(const FormRequest& request) {
  if (request.mesh.order() == 1) return std::make_unique<FacePointForm>(request);
  if (request.mesh.dim() == 2) return std::make_unique<PointForm<CurvedPoints<Line3>>>(request);
  switch (stored_nodes(request.mesh)) {
  case 6:
    return std::make_unique<PointForm<CurvedPoints<Tri6>>>(request);
  case 8:
    return std::make_unique<PointForm<CurvedPoints<Quad8>>>(request);
  default:
    return std::make_unique<PointForm<CurvedPoints<Quad9>>>(request);
  }
}

} // namespace impact
