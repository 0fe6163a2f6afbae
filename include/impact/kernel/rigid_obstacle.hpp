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

/// A function of a place x and of two vectors that an obstacle with mass carries along: its point c and a
/// direction d. All depend on q = x - c and d alone, so that no rigid motion of all of them changes the
/// value, and d2f has three blocks.
struct CarriedFunction {
  double value = 0;
  std::array<double, 3> by_place{}, by_direction{};       ///< df / dq, df / dd
  std::array<double, 9> place_place{}, place_direction{}, ///< d2f, row by row; rows of the second
      direction_direction{};                              ///< one belong to q
};
/// The gap, where the direction of the obstacle need not be a unit vector: between two rigid states a mean
/// one is shorter. Of a plane g = q.d, whose change over a step is its gradient at the middle times the
/// motion; a cylinder is one about the line along d.
CarriedFunction carried_gap(const RigidObstacle& obstacle, const std::array<double, 3>& x);
/// f = q.d.
CarriedFunction carried_product(const std::array<double, 3>& q, const std::array<double, 3>& d);

/// How one node takes part in q and d: q = .. + place x_node, d = .. + direction u_node.
struct CarriedShare {
  double place = 0, direction = 0;
};
/// df by the node's coordinates, and d2f by those of two nodes, 3 x 3 row by row.
std::array<double, 3> gradient_by(const CarriedFunction& f, const CarriedShare& node);
std::array<double, 9> hessian_by(const CarriedFunction& f, const CarriedShare& row,
                                 const CarriedShare& column);

} // namespace impact
