#include <impact/contact/face_points.hpp>
#include <impact/contact/point_form_impl.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

// A foot belongs to a triangle if no part of it is below minus this; beyond the sides of the whole surface
// contact goes on by this part of a triangle.
constexpr double inside = 1e-9, beyond = 0.01;
constexpr int largest_rule = 16;

Point3 point3(const ContactValues& x, int node) {
  return {x[at(3 * node)], x[at(3 * node + 1)], x[at(3 * node + 2)]};
}

double least_part(const RayFoot& foot) { return *std::min_element(foot.part.begin(), foot.part.end()); }

int triangles_of(int corners) { return corners == 3 ? 1 : 4; }

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

FormPoints FacePoints::make_points(ContactSurface& surface, const ContactSettings& settings, Frame) {
  const int n = settings.points;
  if (n < 1 || n > largest_rule)
    throw UserError(ExitCode::usage, "-contact_" + settings.id + "_points " + std::to_string(n) +
                                         ": allowed on faces are 1 to " + std::to_string(largest_rule) +
                                         " points in each direction");
  start_at_smallest_corner(surface);
  FormPoints points;
  points.per_facet = n * n;
  points.shape.assign(at(surface.count() * points.per_facet), {});
  points.weight.assign(points.shape.size(), 0.0);
  const TriangleRule triangle = triangle_rule(n);
  const GaussRule line = gauss_rule(n);
  for (int f = 0; f < surface.count(); ++f) {
    const int corners = corners_of(reference(surface, f));
    const double area = area_at(reference(surface, f));
    points.corners.push_back(corners);
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

void FacePoints::make_map(const ContactSurface& surface, int f, FaceMap& map) {
  map = make_face_map(reference(surface, f));
}

double FacePoints::stretch(const Corners&, const Corners& from_corner, const ContactSurface& surface, int f) {
  return area_at(from_corner) / area_at(reference(surface, f));
}

template <>
FacePoints::Seen FacePointForm::look(const Facet& facet, const ShapeValues& shape, int candidate,
                                     int triangle, const ContactValues& x) const {
  return {candidate, triangle,
          cast_ray({facet.corner, shape, corners_at<FaceCorners>(primary_slots(candidate), x),
                    triangle_weights(primary_corners(candidate), triangle)})};
}

// By normals and depth.
template <>
bool FacePointForm::may_touch(const Facet& facet, const ShapeValues& shape, const Seen& seen) const {
  if (!(seen.foot.opposition < -least_opposition) || !(seen.foot.gap < search_.radius())) return false;
  const double deep = depth(facet.number);
  if (seen.foot.gap > -deep) return true;
  // So deep only what came through the surface within this step.
  if (nodes().start.empty()) return false;
  const RayFoot before =
      look(facet_at(facet.number, nodes().start), shape, seen.candidate, seen.part, nodes().start).foot;
  return before.opposition < -least_opposition && before.gap > -deep;
}

// The triangle before the point, or behind it: the nearest; beside the surface, the one next to it.
template <>
FacePoints::Seen FacePointForm::nearest(const Facet& facet, const ShapeValues& shape,
                                        const ContactValues& x) const {
  // By reference coordinates: of two equal distances every number of ranks takes the same triangle.
  const auto key = [&](int c, int t) {
    std::array<Point3, 4> face = corners_at<FaceCorners>(primary_slots(c), nodes().X);
    std::array<Point3, 2> side = {face[at(t)], face[(at(t) + 1) % at(primary_corners(c))]};
    std::sort(side.begin(), side.end());
    std::sort(face.begin(), face.end());
    return std::pair(side, face);
  };
  Seen best;
  bool best_inside = false;
  const double equal = 1e-9 * secondary_.length[at(facet.number)];
  const Candidates& list = search_.candidates();
  for (int c : list.of(at(facet.number)))
    for (int t = 0; t < triangles_of(primary_corners(c)); ++t) {
      const Seen seen = look(facet, shape, c, t, x);
      const double least = least_part(seen.foot);
      if (!(least >= -beyond) || !may_touch(facet, shape, seen)) continue;
      const bool is_inside = least >= -inside;
      bool better = best.candidate < 0;
      if (!better && is_inside != best_inside) {
        better = is_inside;
      } else if (!better && is_inside) {
        const double nearer = std::abs(best.foot.gap) - std::abs(seen.foot.gap);
        better = nearer > equal || (nearer > -equal && key(c, t) < key(best.candidate, best.part));
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

template <>
bool FacePointForm::held(const Facet& facet, const ShapeValues& shape, const ContactValues& x,
                         const Hold& hold, Seen& seen) const {
  seen = look(facet, shape, hold.candidate, hold.part, x);
  return least_part(seen.foot) > -FacePoints::hold.limit && may_touch(facet, shape, seen);
}

template <>
FacePoints::Seen FacePointForm::passed(const Facet&, const ShapeValues&, const std::vector<double>&) const {
  return {}; // may_touch says which
}

template <>
FaceRay FacePointForm::ray_of(int facet, std::size_t number, const ContactValues& u, const Seen& seen) const {
  const int* slot = secondary_slots(facet);
  return {corners_from<FaceCorners>(slot[0], slot, u), points_.shape[number],
          corners_from<FaceCorners>(slot[0], primary_slots(seen.candidate), u),
          triangle_weights(primary_corners(seen.candidate), seen.part)};
}

template <>
void FacePointForm::sharpen(int facet, std::size_t number, const ContactValues& u, Seen& seen) const {
  seen.foot = cast_ray(ray_of(facet, number, u, seen));
}

template <>
FacePointForm::Row FacePointForm::gap_gradient(int facet, std::size_t number, const ContactValues& u,
                                               const Seen& seen) const {
  return ray_gradient(ray_of(facet, number, u, seen));
}

template <>
void FacePointForm::add_gap_hessian(int facet, std::size_t number, const ContactValues& u, const Seen& seen,
                                    double factor, Matrix& hessian) const {
  add_ray_hessian(ray_of(facet, number, u, seen), factor, hessian);
}

template class PointForm<FacePoints>;

std::unique_ptr<ContactForm> make_face_point_form(const FormRequest& request) {
  return std::make_unique<FacePointForm>(request);
}

} // namespace impact
