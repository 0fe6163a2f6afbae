#pragma once
#include <array>
#include <impact/mesh/mesh.hpp>
#include <vector>

/// Cracks and their tips: a crack is a set of nodes with phi above a level that cells join, on any ranks.
namespace impact {

struct Crack {
  bool there = false;             ///< it has begun
  std::array<double, 3> origin{}; ///< where, in the reference configuration
  bool joined = false;            ///< an older one has met it: it has no tip of its own any more
  std::array<double, 3> tip{};    ///< its node that is farthest from the origin
  std::array<double, 3> from{};   ///< where the tip was at the time `since`, from which its speed is found
  double since = -1, speed = 0;   ///< -1: not yet told
};

/// The speed of the tip at time t, over the last stretch of at least `length` that it went, because a tip
/// goes from node to node; 0 on the first. While it is on the next stretch the speed is at most that of a tip
/// that ends it now: of a crack that stands still it falls.
void follow_speed(Crack& crack, double t, double length);

/// Looks for cracks among the nodes `cracked` ([local node], alike on the ranks that share one). `known`:
/// those of before by age, whose origins stay; places that are not taken are given to new cracks, the one
/// with the most nodes first. A new crack began at that of its nodes where `before`, phi a step ago, was
/// largest. Where that was within 0.01 of the largest at several, they were there at once and lie between the
/// two that are farthest apart: it began at the one that is nearer to the sides of the box around the mesh,
/// else the one with the smaller coordinate along the axis on which they differ most. Returns the number of
/// cracks. Alike on all ranks, for any partition. Collective.
int follow_cracks(const Mesh& mesh, const std::vector<char>& cracked, const std::vector<double>& before,
                  std::vector<Crack>& known);

} // namespace impact
