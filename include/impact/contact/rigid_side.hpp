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

class RigidSide {
public:
  RigidSide() = default;
  /// Finds the pole of a round one, on the side of the secondary surface. Collective.
  RigidSide(const ContactSettings& settings, const Mesh& mesh, const ContactSurface& secondary);

  /// As the settings tell; zero where they tell nothing.
  std::array<double, 3> displacement(const ContactSettings& settings, double t) const;
  /// `before`: its displacement at the start of the step.
  ObstaclePose pose(const ContactSettings& settings, double t, const double* before) const;

private:
  int dim_ = 0;
  std::array<double, 3> outward_{}; // from the centre of a round one to its pole
};

} // namespace impact
