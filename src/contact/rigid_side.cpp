#include <cmath>
#include <impact/contact/rigid_side.hpp>
#include <impact/math/vector3.hpp>

namespace impact {

RigidSide::RigidSide(const ContactSettings& settings, const Mesh& mesh, const ContactSurface& secondary)
    : dim_(mesh.dim()) {
  if (!settings.rigid() || settings.primary == "plane") return;
  // Towards the middle of the secondary side, in few digits: the same on any number of ranks.
  std::array<double, 4> sum{};
  const auto d = static_cast<std::size_t>(dim_);
  for (std::size_t i = 0; i < secondary.X.size(); ++i) sum[i % d] += secondary.X[i];
  sum[3] = static_cast<double>(secondary.X.size() / d);
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 4, MPI_DOUBLE, MPI_SUM, mesh.comm());
  const bool cylinder = settings.primary == "rigid_cylinder";
  std::array<double, 3> way{};
  double along = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    way[k] = sum[k] / sum[3] - settings.centre[k];
    along += way[k] * settings.axis[k];
  }
  if (cylinder)
    for (std::size_t k = 0; k < 3; ++k) way[k] -= along * settings.axis[k];
  if (dim_ == 2) way[2] = 0;
  const double length = std::hypot(way[0], way[1], way[2]);
  if (!(length > 1e-3 * settings.radius)) return;
  for (double& component : way) component = std::round(1024 * component / length);
  const double rounded = std::hypot(way[0], way[1], way[2]);
  for (std::size_t k = 0; k < 3; ++k) outward_[k] = way[k] / rounded;
  if (!cylinder) return;
  // Across the axis to rounding.
  along = outward_[0] * settings.axis[0] + outward_[1] * settings.axis[1] + outward_[2] * settings.axis[2];
  for (std::size_t k = 0; k < 3; ++k) outward_[k] -= along * settings.axis[k];
  const double across = std::hypot(outward_[0], outward_[1], outward_[2]);
  for (double& component : outward_) component /= across;
}

std::array<double, 3> RigidSide::displacement(const ContactSettings& settings, double t) const {
  std::array<double, 3> displacement{};
  if (!settings.rigid()) return displacement;
  for (std::size_t k = 0; k < static_cast<std::size_t>(dim_); ++k)
    if (settings.rigid_motion[k]) displacement[k] = settings.rigid_motion[k](t);
  return displacement;
}

ObstaclePose RigidSide::pose(const ContactSettings& settings, double t, const double* before) const {
  using Body = RigidObstacle::Shape;
  const bool plane = settings.primary == "plane", sphere = settings.primary == "rigid_sphere";
  const std::array<double, 3> now = displacement(settings, t);
  ObstaclePose pose;
  RigidObstacle& obstacle = pose.obstacle;
  obstacle.shape = plane ? Body::plane : sphere ? Body::sphere : Body::cylinder;
  obstacle.radius = settings.radius;
  obstacle.outward = outward_;
  for (std::size_t k = 0; k < 3; ++k) {
    obstacle.point[k] = (plane ? settings.plane_point : settings.centre)[k] + now[k];
    obstacle.direction[k] = (plane ? settings.plane_normal : settings.axis)[k];
    obstacle.pole[k] = obstacle.point[k] + settings.radius * outward_[k];
    pose.moved[k] = now[k] - before[k];
  }
  return pose;
}

} // namespace impact
