#include <algorithm>
#include <cmath>
#include <impact/contact/self_contact.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>

namespace impact {

namespace {

// Neighbours along a surface, in units of both sizes: an edge and the next but one are nearer.
constexpr double neighbourhood = 1.1;
// What lies less deep behind a facet, in units of the smaller size, lies on it.
constexpr double on_the_facet = 0.01;
// Normals that differ by less do not tell two sides apart.
constexpr double nearly_equal = 0.5;
// Of a unit vector one component of three is larger than 0.57.
constexpr double decisive = 0.5;

double depth_behind(const FacetShape& facet, const FacetShape& other) {
  return -dot(minus(other.centre, facet.centre), facet.normal);
}

// Their body lies between them: so do the sides of a plate, of a wedge, of a corner.
bool behind_each_other(const FacetShape& a, const FacetShape& b) {
  const double least = on_the_facet * std::min(a.size, b.size);
  return depth_behind(a, b) > least && depth_behind(b, a) > least;
}

// Of the places that are as far from `centre`, across `axis`, as any, the first by coordinates: a choice that
// rounding does not make.
Vector3 farthest(MPI_Comm comm, const std::vector<FacetShape>& shapes, const Vector3& centre,
                 const Vector3& axis) {
  const auto offset = [&](const FacetShape& shape) {
    Vector3 d = minus(shape.centre, centre);
    const double part = dot(d, axis);
    for (std::size_t k = 0; k < 3; ++k) d[k] -= part * axis[k];
    return d;
  };
  double most = 0;
  for (const FacetShape& shape : shapes) most = std::max(most, length(offset(shape)));
  most = max_over_ranks(comm, most);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Coordinate by coordinate, so that a reduction finds it.
  Vector3 first = {infinity, infinity, infinity}, result{};
  for (std::size_t k = 0; k < 3; ++k) {
    for (const FacetShape& shape : shapes) {
      bool tied = length(offset(shape)) >= (1 - 1e-6) * most;
      for (std::size_t j = 0; j < k; ++j) tied = tied && shape.centre[j] == first[j];
      if (tied && shape.centre[k] < first[k]) first[k] = shape.centre[k];
    }
    first[k] = min_over_ranks(comm, first[k]);
  }
  FacetShape found;
  found.centre = first;
  if (most > 0) result = offset(found);
  return result;
}

void turn(Vector3& a, Vector3& b, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (std::size_t k = 0; k < 3; ++k) {
    const double x = a[k], y = b[k];
    a[k] = c * x + s * y;
    b[k] = -s * x + c * y;
  }
}

} // namespace

FacetShape facet_shape(int dim, const std::array<double, 12>& x, int body) {
  std::array<Vector3, 4> corner;
  for (std::size_t a = 0; a < 4; ++a) std::copy_n(&x[3 * a], 3, corner[a].begin());
  const std::size_t corners = dim == 2 ? 2 : corner[3] == corner[2] ? 3 : 4;
  FacetShape shape;
  shape.body = body;
  for (std::size_t a = 0; a < corners; ++a) {
    for (std::size_t k = 0; k < 3; ++k) shape.centre[k] += corner[a][k] / static_cast<double>(corners);
    shape.size = std::max(shape.size, length(minus(corner[(a + 1) % corners], corner[a])));
  }
  const Vector3 t = minus(corner[1], corner[0]);
  shape.normal = unit(dim == 2 ? Vector3{t[1], -t[0], 0}
                               : cross(minus(corner[2], corner[0]), minus(corner[3], corner[1])));
  if (corners == 3) shape.normal = unit(cross(t, minus(corner[2], corner[0])));
  return shape;
}

SelfContact::SelfContact(MPI_Comm comm, int dim, const std::vector<FacetShape>& shapes)
    : dim_(static_cast<std::size_t>(dim)) {
  std::array<double, 4> sum{};
  for (const FacetShape& shape : shapes) {
    for (std::size_t k = 0; k < 3; ++k) sum[k] += shape.centre[k];
    sum[3] += 1;
  }
  sum_over_ranks(comm, sum);
  const Vector3 centre = {sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]};
  auto& [d, e, f] = direction_;
  const Vector3 far = farthest(comm, shapes, centre, {});
  d = length(far) > 0 ? unit(far) : Vector3{1, 0, 0};
  if (dim == 2) {
    e = {-d[1], d[0], 0};
  } else {
    const Vector3 aside = farthest(comm, shapes, centre, d);
    const Vector3 any = std::abs(d[0]) < 0.8 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
    e = unit(length(aside) > 1e-6 * length(far) ? aside : cross(d, any));
  }
  f = cross(d, e);
  turn(d, e, 0.55);
  if (dim == 2) return;
  turn(e, f, 0.7);
  turn(d, f, 0.4);
}

bool SelfContact::may_touch(const FacetShape& a, const FacetShape& b, double range) {
  if (a.body != b.body) return true;
  const double distance = length(minus(a.centre, b.centre));
  if (behind_each_other(a, b)) return distance > range;
  return dot(a.normal, b.normal) < -least_opposition || distance > neighbourhood * (a.size + b.size);
}

double SelfContact::thickness(const FacetShape& facet, const FacetShape& other) {
  constexpr double none = std::numeric_limits<double>::infinity();
  if (facet.body != other.body || !behind_each_other(facet, other)) return none;
  if (!(dot(facet.normal, other.normal) < -least_opposition)) return none;
  const double depth = depth_behind(facet, other);
  const Vector3 d = minus(other.centre, facet.centre);
  const double aside = std::sqrt(std::max(0.0, dot(d, d) - depth * depth));
  return aside <= (facet.size + other.size) / 2 ? depth : none;
}

bool SelfContact::is_secondary(const FacetShape& a, const FacetShape& b) const {
  Vector3 w = minus(a.normal, b.normal);
  if (length(w) < nearly_equal) w = minus(a.centre, b.centre);
  const double size = length(w);
  for (std::size_t k = 0; k < dim_; ++k)
    if (const double part = dot(w, direction_[k]); std::abs(part) > decisive * size) return part > 0;
  return false;
}

} // namespace impact
