#include <cmath>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/obstacle_body.hpp>
#include <numbers>

namespace impact {

namespace {

// How large a cell is whose inertia does not matter: beside the mesh, or beside a ball, which hides it.
constexpr double part_of_the_box = 0.1, part_of_the_radius = 0.5;

double diagonal(const std::array<double, 6>& box) {
  return std::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
}

bool is_plane(const ContactSettings& contact) { return contact.primary == "plane"; }

// Moments of inertia about the axis of the obstacle and across it. Not of planes without inertia.
std::array<double, 2> inertia_of(const ContactScenario& c, int dim) {
  if (!std::isnan(c.rigid_inertia)) return {c.rigid_inertia, c.rigid_inertia};
  const double of_disc = c.rigid_mass * c.radius * c.radius / 2;
  if (dim == 2) return {of_disc, of_disc};
  if (c.primary == "rigid_sphere") return {0.8 * of_disc, 0.8 * of_disc};
  const std::string prefix = "-contact_" + c.id + "_";
  if (!(c.rigid_length > 0))
    throw UserError(ExitCode::usage, prefix +
                                         "rigid_length: missing; allowed: a length > 0; the inertia of a "
                                         "rigid cylinder in space needs it, or give " +
                                         prefix + "rigid_inertia");
  return {of_disc, of_disc / 2 + c.rigid_mass * c.rigid_length * c.rigid_length / 12};
}

// A triangle has int rho Y Y^T = m/12 sum Y_a Y_a^T over its corners, a tetrahedron m/20: equilateral ones
// with the circumradius 1 have m/8 and m/15 times the unit matrix.
std::vector<Vector3> triangle(const Vector3& centre, double radius) {
  const double half = std::sqrt(0.75) * radius;
  return {{centre[0] - half, centre[1] - radius / 2, 0},
          {centre[0] + half, centre[1] - radius / 2, 0},
          {centre[0], centre[1] + radius, 0}};
}

Vector3 normalised(Vector3 a) {
  const double size = std::hypot(a[0], a[1], a[2]);
  for (double& component : a) component /= size;
  return a;
}

// With the circumradii `along` and `across` a direction.
std::vector<Vector3> tetrahedron(const Vector3& centre, const Vector3& direction, double along,
                                 double across) {
  const Vector3 a = normalised(direction);
  std::size_t least = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (std::abs(a[k]) < std::abs(a[least])) least = k;
  Vector3 b{};
  b[least] = 1;
  b = normalised(cross(a, b));
  const Vector3 c = cross(a, b);
  std::vector<Vector3> corners;
  for (const auto& [x, y, z] :
       std::array<std::array<double, 3>, 4>{{{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}}}) {
    Vector3 X = centre;
    for (std::size_t k = 0; k < 3; ++k)
      X[k] += (along * x * a[k] + across * (y * b[k] + z * c[k])) / std::numbers::sqrt3;
    corners.push_back(X);
  }
  return corners;
}

double volume(const std::vector<Vector3>& corner, PlaneMode plane) {
  const auto side = [&](std::size_t i) { return minus(corner[i], corner[0]); };
  const Vector3 normal = cross(side(1), side(2));
  if (corner.size() == 4) return dot(normal, side(3)) / 6;
  const double around = plane == PlaneMode::axisymmetric
                            ? 2 * std::numbers::pi * (corner[0][0] + corner[1][0] + corner[2][0]) / 3
                            : 1;
  return around * normal[2] / 2;
}

Expression nothing(const ContactScenario& contact) {
  return {"-contact_" + contact.id + "_rigid_mass", [](const double*, int, double) { return 0.0; }};
}

} // namespace

ObstacleBody obstacle_body(const ContactScenario& contact, int dim, PlaneMode plane, double thickness,
                           const std::array<double, 6>& box) {
  const double *place = is_plane(contact) ? contact.plane_point : contact.centre,
               *axis = is_plane(contact) ? contact.plane_normal : contact.axis;
  const Vector3 centre = {place[0], place[1], dim == 3 ? place[2] : 0},
                direction = {axis[0], axis[1], axis[2]};
  const double mass = contact.rigid_mass;
  ObstacleBody body;
  body.cell.region = contact.carrier;
  std::vector<Vector3>& corner = body.cell.corner;
  const bool rotates =
      plane != PlaneMode::axisymmetric && !(is_plane(contact) && std::isnan(contact.rigid_inertia));
  if (!rotates) {
    const double size =
        is_plane(contact) ? part_of_the_box * diagonal(box) : part_of_the_radius * contact.radius;
    if (plane == PlaneMode::axisymmetric)
      corner = {{0, centre[1] - size, 0}, {size, centre[1], 0}, {0, centre[1] + size, 0}};
    else if (dim == 2)
      corner = triangle(centre, size);
    else
      corner = tetrahedron(centre, direction, size, size);
  } else {
    const auto [about, across] = inertia_of(contact, dim);
    if (dim == 2)
      corner = triangle(centre, std::sqrt(4 * about / mass));
    else
      corner = tetrahedron(centre, direction, std::sqrt(15 * (across - about / 2) / mass),
                           std::sqrt(7.5 * about / mass));
  }
  const double around = dim == 2 && plane != PlaneMode::axisymmetric ? thickness : 1;
  body.density = mass / (around * volume(corner, plane));
  return body;
}

std::vector<BoundaryCondition> obstacle_conditions(const Scenario& scenario, int dim) {
  std::vector<BoundaryCondition> conditions;
  for (const ContactScenario& contact : scenario.contacts) {
    if (contact.carrier.empty()) continue;
    BoundaryCondition bc;
    bc.id = contact.carrier;
    bc.on = {contact.carrier};
    bool prescribes = false;
    const bool held =
        is_plane(contact) && std::isnan(contact.rigid_inertia) && scenario.plane != PlaneMode::axisymmetric;
    for (std::size_t k = 0; k < 3; ++k) {
      bc.component[k] = contact.rigid_u[k];
      bc.rotation[k] = contact.rigid_r[k];
      if (held && !bc.rotation[k] && (dim == 3 || k == 2)) bc.rotation[k] = nothing(contact);
      prescribes = prescribes || bc.component[k] || bc.rotation[k];
    }
    if (prescribes) conditions.push_back(std::move(bc));
  }
  return conditions;
}

} // namespace impact
