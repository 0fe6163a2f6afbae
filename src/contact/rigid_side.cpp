#include <cmath>
#include <impact/contact/rigid_side.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>

namespace impact {

std::array<double, 3> pole_of(const ContactSettings& settings, const Mesh& mesh,
                              const ContactSurface& secondary) {
  Vector3 outward{};
  if (!settings.rigid() || settings.primary == "plane") return outward;
  // Towards the middle of the secondary side, in few digits: the same on any number of ranks.
  std::array<double, 4> sum{};
  const auto d = at(mesh.dim());
  for (std::size_t i = 0; i < secondary.X.size(); ++i) sum[i % d] += secondary.X[i];
  sum[3] = static_cast<double>(secondary.X.size() / d);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 4, MPI_DOUBLE, MPI_SUM, mesh.comm());
  const Vector3 axis = {settings.axis[0], settings.axis[1], settings.axis[2]};
  const auto drop_axis = [&](Vector3& way) {
    const double along = dot(way, axis);
    for (std::size_t k = 0; k < 3; ++k) way[k] -= along * axis[k];
  };
  const bool cylinder = settings.primary == "rigid_cylinder";
  Vector3 way{};
  for (std::size_t k = 0; k < 3; ++k) way[k] = sum[k] / sum[3] - settings.centre[k];
  if (cylinder) drop_axis(way);
  if (d == 2) way[2] = 0;
  const double length = std::hypot(way[0], way[1], way[2]);
  if (!(length > 1e-3 * settings.radius)) return outward;
  for (double& component : way) component = std::round(1024 * component / length);
  const double rounded = std::hypot(way[0], way[1], way[2]);
  for (std::size_t k = 0; k < 3; ++k) outward[k] = way[k] / rounded;
  if (!cylinder) return outward;
  // Across the axis to rounding.
  drop_axis(outward);
  const double across = std::hypot(outward[0], outward[1], outward[2]);
  for (double& component : outward) component /= across;
  return outward;
}

std::array<double, 3> rigid_displacement(const ContactSettings& settings, int dim, double t) {
  std::array<double, 3> displacement{};
  for (std::size_t k = 0; settings.rigid() && k < at(dim); ++k)
    if (settings.rigid_motion[k]) displacement[k] = settings.rigid_motion[k](t);
  return displacement;
}

ObstaclePose rigid_pose(const ContactSettings& settings, int dim, double t,
                        const std::array<double, 3>& outward, const double* before) {
  using Body = RigidObstacle::Shape;
  const bool plane = settings.primary == "plane", sphere = settings.primary == "rigid_sphere";
  const std::array<double, 3> now = rigid_displacement(settings, dim, t);
  ObstaclePose pose;
  RigidObstacle& obstacle = pose.obstacle;
  obstacle.shape = plane ? Body::plane : sphere ? Body::sphere : Body::cylinder;
  obstacle.radius = settings.radius;
  obstacle.outward = outward;
  for (std::size_t k = 0; k < 3; ++k) {
    obstacle.point[k] = (plane ? settings.plane_point : settings.centre)[k] + now[k];
    obstacle.direction[k] = (plane ? settings.plane_normal : settings.axis)[k];
    obstacle.pole[k] = obstacle.point[k] + settings.radius * outward[k];
    pose.moved[k] = now[k] - before[k];
  }
  return pose;
}

} // namespace impact
