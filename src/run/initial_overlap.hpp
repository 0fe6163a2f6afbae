#pragma once
#include <impact/run/obstacle_body.hpp>
#include <impact/run/setup.hpp>
#include <memory>
#include <vector>

namespace impact {

/// Moves the secondary nodes of contacts that overlap at the start out of their primaries, contact by
/// contact, and builds everything on the mesh that this makes. What is moved may overlap something else, a
/// little, or a curved surface by the square of the way: more than one round. Collective. Throws
/// UserError(data) when that does not end, or when cells have no room for it.
void adjust_initial_overlaps(const Scenario& scenario, const std::vector<ObstacleBody>& obstacles,
                             std::unique_ptr<Setup>& setup);

} // namespace impact
