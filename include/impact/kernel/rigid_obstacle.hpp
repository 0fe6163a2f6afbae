#pragma once
#include <array>

/// Rigid bodies of simple shape: signed distance of a point and its variations (theory.md, contact).
namespace impact {

struct RigidObstacle {
  enum class Shape { plane, sphere, cylinder };

  Shape shape = Shape::plane;
  std::array<double, 3> point{};     ///< of the plane or of the axis, or the centre
  std::array<double, 3> direction{}; ///< unit vector: normal of the plane away from its body, axis
  double radius = 0;
  /// Of a round one: a point of its surface near the bodies and the normal there, or zero vectors. Distances
  /// from it keep the digits that those from a centre far away lose.
  std::array<double, 3> pole{}, outward{};
};

/// Gap of a point, negative inside the obstacle.
struct ObstacleGap {
  double gap = 0;
  std::array<double, 3> normal{};    ///< dg / dx, a unit vector
  std::array<double, 9> curvature{}; ///< d2g / dx dx, row by row
};
/// On the axis or in the centre, where there is no normal, the first direction that a cylinder or sphere has.
ObstacleGap gap_to(const RigidObstacle& obstacle, const std::array<double, 3>& x);

} // namespace impact
