#include "rigid_inertia.hpp"
#include <algorithm>
#include <cmath>
#include <impact/input/units.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/rigid_bodies.hpp>

/// What the conditions prescribe of rigid bodies.
namespace impact {

RigidBodies::Hold RigidBodies::hold_by(int condition, std::size_t k) const {
  const BoundaryCondition& bc = conditions_[at(condition)];
  const std::optional<Expression>& data = k < 3 ? bc.component[k] : bc.rotation[k - 3];
  return {true, bc.type == BcType::velocity, data ? &*data : nullptr};
}

RigidBodies::Hold RigidBodies::hold(const RigidBody& body, std::size_t k) const {
  return body.held[k] < 0 ? Hold{body.held[k] != RigidBody::free_motion} : hold_by(body.held[k], k);
}

// Rotation components as the conditions say them at time t: angles, or what velocities add since t_n.
Vector3 RigidBodies::rotation_data(const RigidBody& body, double t) const {
  const double* x = body.centre.data();
  Vector3 value{};
  for (std::size_t k = 0; k < 3; ++k)
    if (const auto [held, rate, data] = hold(body, 3 + k); data)
      value[k] = rate ? integral(*data, x, dim_, t_n_, t) : (*data)(x, dim_, t);
  return value;
}

// Rates of prescribed components at the end of the attempt, of places one-sided differences; 0 of others.
RigidVector RigidBodies::told_rates(const RigidBody& body) const {
  const double h = 1e-4 * (t_ - t_n_), *x = body.centre.data();
  RigidVector rate{};
  for (std::size_t k = 0; k < 6; ++k)
    if (const auto [held, is_rate, data] = hold(body, k); data)
      rate[k] = is_rate ? (*data)(x, dim_, t_) : slope(*data, x, dim_, t_, -h);
  if (dim_ == 2 || !turns_as_told(body)) return rate;
  // Rates of rotation vectors in space are not their derivatives.
  const Matrix3 end = rotation_of(rotation_data(body, t_));
  const auto turned = [&](double t) {
    return cayley_vector(end * transposed(rotation_of(rotation_data(body, t))));
  };
  const Vector3 one = turned(t_ - h), two = turned(t_ - 2 * h);
  for (std::size_t k = 0; k < 3; ++k) rate[3 + k] = (4 * one[k] - two[k]) / (2 * h);
  return rate;
}

// All components of the rotation are prescribed, as rotations from the reference configuration.
bool RigidBodies::turns_as_told(const RigidBody& body) const {
  for (std::size_t k = dim_ == 3 ? 3 : 5; k < 6; ++k)
    if (const Hold on = hold(body, k); !on.held || on.rate) return false;
  return true;
}

RigidPose RigidBodies::admissible(std::size_t b, RigidPose pose) const {
  const RigidBody& body = bodies_[b];
  const double* x = body.centre.data();
  for (std::size_t k = 0; k < at(dim_); ++k)
    if (const auto [held, rate, data] = hold(body, k); held)
      pose.moved[k] = !data  ? 0
                      : rate ? start_[b].moved[k] + integral(*data, x, dim_, t_n_, t_)
                             : (*data)(x, dim_, t_);
  if (turns_as_told(body)) {
    pose.turned = rotation_of(rotation_data(body, t_));
    return pose;
  }
  // Rotation of the step by components: 2 tan(angle/2), which is what moments at the middle of the step do
  // work on.
  bool any = false;
  Vector3 c = cayley_vector(pose.turned * transposed(start_[b].turned));
  const Vector3 end = rotation_data(body, t_), begin = rotation_data(body, t_n_);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!hold(body, 3 + k).held) continue;
    any = true;
    c[k] = 2 * std::tan((end[k] - begin[k]) / 2);
  }
  if (any) pose.turned = cayley(c) * start_[b].turned;
  return pose;
}

void RigidBodies::require_agreement(double t_n, double t) const {
  static constexpr const char* names[6] = {"ux", "uy", "uz", "rx", "ry", "rz"};
  for (const auto& [b, k, one, two] : shared_) {
    const RigidBody& body = bodies_[b];
    const Hold first = hold_by(one, k), other = hold_by(two, k);
    // Of two velocities the values, of a velocity and a place what they change in the step.
    const bool changes = first.rate != other.rate;
    const auto value = [&](const Hold& on) {
      const double* x = body.centre.data();
      if (!on.data) return 0.0;
      if (changes && on.rate) return integral(*on.data, x, dim_, t_n, t);
      return (*on.data)(x, dim_, t) - (changes ? (*on.data)(x, dim_, t_n) : 0.0);
    };
    const double here = value(first), there = value(other);
    const double rounding = changes ? 1e-12 * body.length : 0;
    if (std::abs(here - there) > 1e-9 * std::max(std::abs(here), std::abs(there)) + rounding)
      throw UserError(ExitCode::data, "-bc_" + conditions_[at(one)].id + " and -bc_" +
                                          conditions_[at(two)].id + " prescribe different " + names[k] +
                                          " (" + number_text(here) + ", " + number_text(there) +
                                          " at t=" + number_text(t) + ") of the rigid body " + body.name +
                                          "; leave the component out of one of them");
  }
}

} // namespace impact
