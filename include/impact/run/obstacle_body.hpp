#pragma once
#include <impact/mesh/mesh.hpp>
#include <impact/scenario/scenario.hpp>

/// The body of a rigid obstacle with mass (`-contact_<id>_rigid_mass`): one cell that stands by itself in the
/// mesh, of a rigid material, with the obstacle's mass, centre of mass and inertia. What moves it is what
/// moves every rigid body.
namespace impact {

struct ObstacleBody {
  AddedCell cell; ///< its region is ContactSettings::carrier
  double density = 0;
};

/// Of one contact whose obstacle has a mass; `box`: smallest and largest x, y, z of the mesh. Throws
/// UserError(usage): a cylinder in space without inertia or length.
ObstacleBody obstacle_body(const ContactScenario& contact, int dim, PlaneMode plane, double thickness,
                           const std::array<double, 6>& box);

/// What `_rigid_u*`, `_rigid_r*` and a missing inertia prescribe of these bodies.
std::vector<BoundaryCondition> obstacle_conditions(const Scenario& scenario, int dim);

} // namespace impact
