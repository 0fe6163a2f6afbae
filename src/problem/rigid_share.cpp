#include <algorithm>
#include <cmath>
#include <impact/problem/rigid_bodies.hpp>

/// What explicit steps ask of rigid bodies beside their data: nodes, and how readily a place gives way.
namespace impact {

std::vector<RigidBodies::OwnedNode> RigidBodies::owned_nodes() const {
  std::vector<OwnedNode> nodes;
  for (std::size_t i = 0; i < owned_; ++i) nodes.push_back({row_[i], at(body_[i]), arm(i)});
  return nodes;
}

double RigidBodies::give(std::size_t body, const double* X) const {
  const RigidBody& of = bodies_[body];
  const auto free = [&](std::size_t k) { return of.held[k] == RigidBody::free_motion; };
  const bool moves = free(0) || free(1) || (dim_ == 3 && free(2)),
             turns = free(5) || (dim_ == 3 && (free(3) || free(4)));
  double square = 0;
  for (std::size_t k = 0; k < at(dim_); ++k) square += (X[k] - of.centre[k]) * (X[k] - of.centre[k]);
  const Matrix3& readiness = reduction_.bodies()[body].readiness;
  double fastest = readiness[8]; // in the plane; in space a bound of the largest eigenvalue
  for (std::size_t i = 0; dim_ == 3 && i < 3; ++i)
    fastest = std::max(fastest, std::abs(readiness[3 * i]) + std::abs(readiness[3 * i + 1]) +
                                    std::abs(readiness[3 * i + 2]));
  return (moves ? 1 / of.mass : 0) + (turns ? square * fastest / of.mass : 0);
}

} // namespace impact
