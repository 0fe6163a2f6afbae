#pragma once
#include <impact/contact/settings.hpp>
#include <impact/contact/surface.hpp>
#include <impact/kernel/rigid_obstacle.hpp>

/// The rigid plane, sphere or cylinder of a contact where it stands at a time.
namespace impact {

/// Where a rigid obstacle stands in an attempt; one with mass: in the reference configuration, not moved.
struct ObstaclePose {
  RigidObstacle obstacle;        ///< at the end of the step
  std::array<double, 3> moved{}; ///< its displacement since the start of the step
};

/// From the centre of a round one to its pole, on the side of the secondary surface; zero of a plane.
/// Collective.
std::array<double, 3> pole_of(const ContactSettings& settings, const Mesh& mesh,
                              const ContactSurface& secondary);
/// Its displacement, as the settings tell; zero where they tell nothing.
std::array<double, 3> rigid_displacement(const ContactSettings& settings, int dim, double t);
/// `outward`: pole_of; `before`: its displacement at the start of the step.
ObstaclePose rigid_pose(const ContactSettings& settings, int dim, double t,
                        const std::array<double, 3>& outward, const double* before);

} // namespace impact
