#include "rigid_inertia.hpp"
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/rigid_bodies.hpp>

/// Velocities and accelerations of rigid bodies.
namespace impact {

namespace {

// Angular velocity by the angular momentum L; of plane bodies about the axis alone.
Vector3 spin_by(int dim, const RigidBody& body, const Matrix3& R, const Vector3& L) {
  if (dim == 2) return {0, 0, L[2] / (body.second[0] + body.second[4])};
  return inverse(inertia_of(R, body.second, R)) * L;
}

} // namespace

Vector3 RigidBodies::free_spin(const RigidBody& body, Matrix3 J, Vector3 moment) const {
  for (std::size_t k = 0; k < 3; ++k) {
    if (body.held[3 + k] == RigidBody::free_motion && (dim_ == 3 || k == 2)) continue;
    moment[k] = 0;
    for (std::size_t j = 0; j < 3; ++j) J[3 * k + j] = J[3 * j + k] = j == k ? 1 : 0;
  }
  return inverse(J) * moment;
}

template <class Arms>
void RigidBodies::set_free_rates(const std::vector<Sums>& total, Arms&& arms, Vec rate) const {
  std::vector<Vector3> speed(bodies_.size()), spin(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    const Matrix3& F = arms(b);
    for (std::size_t k = 0; k < at(dim_); ++k)
      if (body.held[k] == RigidBody::free_motion) speed[b][k] = total[b].sum[k] / body.mass;
    spin[b] = free_spin(body, inertia_of(F, body.second, F), axial(total[b].moment * transposed(F)));
  }
  set_nodes(rate,
            [&](std::size_t b, const Vector3& Y) { return plus(speed[b], cross(spin[b], arms(b) * Y)); });
}

void RigidBodies::accelerate(Vec f, Vec a) const {
  if (empty()) return;
  std::vector<Sums> total = sums_of(Weight::one, f);
  for (std::size_t b = 0; b < total.size(); ++b) {
    for (double& component : total[b].sum) component /= bodies_[b].mass;
    total[b].moment = total[b].moment * inverse(bodies_[b].second);
  }
  set_nodes(a, [&](std::size_t b, const Vector3& Y) { return plus(total[b].sum, total[b].moment * Y); });
}

void RigidBodies::strike(Vec f, Vec gain, ArmsAt at) const {
  if (empty()) return;
  set_free_rates(
      sums_of(Weight::one, f),
      [&](std::size_t b) -> const Matrix3& {
        return at == ArmsAt::start ? start_[b].turned : reduction_.bodies()[b].trial;
      },
      gain);
}

void RigidBodies::keep_free_rates(Vec v) const {
  if (empty()) return;
  set_free_rates(
      sums_of(Weight::mass, v), [&](std::size_t b) -> const Matrix3& { return reduction_.bodies()[b].test; },
      v);
}

void RigidBodies::move_as_told(Vec v, Vec change) const {
  check(VecSet(change, 0));
  if (empty()) return;
  const std::vector<Sums> speed = sums_of(Weight::mass, v);
  std::vector<Vector3> gain(bodies_.size()), spin(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    const Matrix3& R = now_[b].turned;
    const RigidVector told = told_rates(body);
    const Vector3 turns = spin_by(dim_, body, R, axial(speed[b].moment * transposed(R)));
    Vector3 more{};
    for (std::size_t k = 0; k < 3; ++k) {
      if (body.held[k] != RigidBody::free_motion) gain[b][k] = told[k] - speed[b].sum[k] / body.mass;
      if (body.held[3 + k] != RigidBody::free_motion) more[k] = told[3 + k] - turns[k];
    }
    const Matrix3 J = inertia_of(R, body.second, R);
    const Vector3 taken = free_spin(body, J, J * more);
    for (std::size_t k = 0; k < 3; ++k) spin[b][k] = more[k] - taken[k];
  }
  set_nodes(change, [&](std::size_t b, const Vector3& Y) {
    return plus(gain[b], cross(spin[b], now_[b].turned * Y));
  });
  check(VecAXPY(v, 1, change));
}

std::vector<RigidMotionState> RigidBodies::motion(Vec u, Vec v) const {
  std::vector<RigidMotionState> result(bodies_.size());
  if (empty()) return result;
  const std::vector<RigidPose> pose = poses(sums_of(Weight::mass, u));
  const std::vector<Sums> speed = sums_of(Weight::mass, v);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Matrix3& R = pose[b].turned;
    result[b].pose = pose[b];
    result[b].spin = axial(speed[b].moment * transposed(R));
    const Vector3 w = spin_by(dim_, bodies_[b], R, result[b].spin);
    for (std::size_t k = 0; k < 3; ++k) {
      result[b].velocity[k] = speed[b].sum[k] / bodies_[b].mass;
      result[b].velocity[3 + k] = w[k];
    }
  }
  return result;
}

void RigidBodies::set_initial(double dt, std::vector<double>& u, std::vector<double>& v) const {
  if (empty()) return;
  std::vector<RigidPose> pose = poses(mass_sums(u));
  const std::vector<Sums> speed = mass_sums(v);
  std::vector<RigidVector> rate(bodies_.size());
  const double h = 1e-3 * dt;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    for (std::size_t k = 0; k < at(dim_); ++k) {
      const int c = body.held[k];
      rate[b][k] = speed[b].sum[k] / body.mass;
      if (c == RigidBody::free_motion) continue;
      const BoundaryCondition* bc = c < 0 ? nullptr : &conditions_[at(c)];
      const bool moves = bc != nullptr && bc->component[k].has_value(),
                 fast = moves && bc->type == BcType::velocity;
      if (!fast) pose[b].moved[k] = moves ? (*bc->component[k])(body.centre.data(), dim_, 0) : 0;
      rate[b][k] = fast    ? (*bc->component[k])(body.centre.data(), dim_, 0)
                   : moves ? slope(*bc->component[k], body.centre.data(), dim_, 0, h)
                           : 0;
    }
    Vector3 angle{}, spin{};
    bool held[3] = {}, all_told = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const int c = body.held[3 + k];
      held[k] = c != RigidBody::free_motion;
      if (dim_ == 3 || k == 2) all_told = all_told && held[k];
      if (c < 0) continue;
      const BoundaryCondition& bc = conditions_[at(c)];
      if (!bc.rotation[k]) continue;
      if (bc.type == BcType::velocity) {
        spin[k] = (*bc.rotation[k])(body.centre.data(), dim_, 0);
        all_told = false;
        continue;
      }
      angle[k] = (*bc.rotation[k])(body.centre.data(), dim_, 0);
      spin[k] = slope(*bc.rotation[k], body.centre.data(), dim_, 0, h);
    }
    if (all_told) pose[b].turned = rotation_of(angle);
    const Matrix3& R = pose[b].turned;
    const Vector3 free = spin_by(dim_, body, R, axial(speed[b].moment * transposed(R)));
    for (std::size_t k = 0; k < 3; ++k) rate[b][3 + k] = held[k] ? spin[k] : free[k];
  }
  for (std::size_t i = 0; i < node_.size(); ++i) {
    const auto b = at(body_[i]);
    const Vector3 Y = arm(i), r = pose[b].turned * Y,
                  turning = cross(Vector3{rate[b][3], rate[b][4], rate[b][5]}, r);
    for (std::size_t k = 0; k < at(dim_); ++k) {
      const std::size_t dof = at(dim_ * node_[i]) + k;
      u[dof] = pose[b].moved[k] + (r[k] - Y[k]);
      v[dof] = rate[b][k] + turning[k];
    }
  }
}

double RigidBodies::strike_power(Vec f, Vec u, Vec v) const {
  if (empty()) return 0;
  const std::vector<Sums> total = sums_of(Weight::one, f);
  const std::vector<RigidMotionState> moves = motion(u, v);
  double power = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Vector3 moment = axial(total[b].moment * transposed(start_[b].turned));
    for (std::size_t k = 0; k < 6; ++k)
      if (bodies_[b].held[k] >= 0) power -= moves[b].velocity[k] * (k < 3 ? total[b].sum[k] : moment[k - 3]);
  }
  return power;
}

} // namespace impact
