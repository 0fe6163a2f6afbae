#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <span>

/// Resultants on rigid bodies, and what explicit steps ask of them beside their data: nodes, and how readily
/// a place gives way.
namespace impact {

std::vector<RigidVector> RigidBodies::resultants(Vec f) const {
  std::vector<RigidVector> result(bodies_.size(), RigidVector{});
  if (empty()) return result;
  const Entries values(f);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    visit_unknowns(b, [&](int row, int, std::size_t c) {
      result[b][c] = values[row] * (c < 3 ? 1 : reduction_.bodies()[b].length);
    });
  const std::span<double> all(result.front().data(), 6 * result.size());
  sum_over_ranks(comm_, all);
  return result;
}

std::pair<double, std::size_t> RigidBodies::most_turned(Vec from, Vec to) const {
  const std::vector<RigidPose> before = poses(sums_of(Weight::mass, from)),
                               after = poses(sums_of(Weight::mass, to));
  std::pair<double, std::size_t> most{0, 0};
  for (std::size_t b = 0; b < after.size(); ++b)
    most = std::max(most, {length(rotation_vector(after[b].turned * transposed(before[b].turned))), b});
  return most;
}

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
