#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <span>

/// Motion of rigid bodies: what a solve and a step need, and the reactions of what is prescribed. Set-up:
/// rigid_bodies_setup.cpp; what conditions prescribe: rigid_data.cpp.
namespace impact {

namespace {

Vector3 plus(const Vector3& a, const Vector3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

// int rho (r.q 1 - r q^T) for arms r = A Y, q = B Y.
Matrix3 inertia_of(const Matrix3& A, const Matrix3& E, const Matrix3& B) {
  Matrix3 J = A * E * transposed(B);
  const double t = trace(J);
  for (std::size_t i = 0; i < 9; ++i) J[i] = (i % 4 == 0 ? t : 0) - J[i];
  return J;
}

// Angular velocity by the angular momentum L; of plane bodies about the axis alone.
Vector3 spin_by(int dim, const RigidBody& body, const Matrix3& R, const Vector3& L) {
  if (dim == 2) return {0, 0, L[2] / (body.second[0] + body.second[4])};
  return inverse(inertia_of(R, body.second, R)) * L;
}

} // namespace

template <class Value> std::vector<RigidBodies::Sums> RigidBodies::sums(Weight weight, Value&& value) const {
  std::vector<Sums> total(bodies_.size());
  const auto d = at(dim_);
  for (std::size_t i = 0; i < owned_; ++i) {
    Sums& mine = total[at(body_[i])];
    const Vector3& centre = bodies_[at(body_[i])].centre;
    for (std::size_t k = 0; k < d; ++k) {
      const double f = value(i, static_cast<int>(k));
      mine.sum[k] += weight == Weight::mass ? mass_[i] * f : f;
      for (std::size_t j = 0; j < d; ++j)
        mine.moment[3 * k + j] +=
            f * (weight == Weight::mass ? first_[d * i + j] : X_[d * i + j] - centre[j]);
    }
  }
  static_assert(sizeof(Sums) == 12 * sizeof(double));
  const std::span<double> all(reinterpret_cast<double*>(total.data()), 12 * total.size());
  sum_over_ranks(comm_, all);
  return total;
}

std::vector<RigidBodies::Sums> RigidBodies::sums_of(Weight weight, Vec f) const {
  const Entries values(f);
  return sums(weight, [&](std::size_t i, int k) { return values[row_[i] + k]; });
}

std::vector<RigidBodies::Sums> RigidBodies::mass_sums(const std::vector<double>& field) const {
  return sums(Weight::mass, [&](std::size_t i, int k) { return field[at(dim_ * node_[i] + k)]; });
}

std::vector<RigidPose> RigidBodies::poses(const std::vector<Sums>& of_u) const {
  std::vector<RigidPose> result(bodies_.size());
  for (std::size_t b = 0; b < result.size(); ++b) {
    const RigidBody& body = bodies_[b];
    for (std::size_t k = 0; k < 3; ++k) result[b].moved[k] = of_u[b].sum[k] / body.mass;
    Matrix3 H = body.second;
    for (std::size_t i = 0; i < 9; ++i) H[i] += of_u[b].moment[i];
    result[b].turned =
        dim_ == 3 ? nearest_rotation(H) : rotation_of({0, 0, std::atan2(H[3] - H[1], H[0] + H[4])});
  }
  return result;
}

template <class Field> void RigidBodies::set_nodes(Vec u, Field&& field) const {
  double* values = nullptr;
  check(VecGetArray(u, &values));
  for (std::size_t i = 0; i < owned_; ++i) {
    const Vector3 value = field(at(body_[i]), arm(i));
    std::copy_n(value.begin(), dim_, values + row_[i]);
  }
  check(VecRestoreArray(u, &values));
}

Vector3 RigidBodies::arm(std::size_t place) const {
  Vector3 Y{};
  const auto d = at(dim_);
  for (std::size_t k = 0; k < d; ++k) Y[k] = X_[d * place + k] - bodies_[at(body_[place])].centre[k];
  return Y;
}

void RigidBodies::begin(double t_n, double t, const std::vector<double>& u_n, bool dynamic) {
  if (empty()) return;
  t_n_ = t_n;
  t_ = t;
  dynamic_ = dynamic;
  start_ = poses(mass_sums(u_n));
  now_ = start_;
}

void RigidBodies::retract(Vec u) const {
  if (empty()) return;
  std::vector<RigidPose> pose = poses(sums_of(Weight::mass, u));
  for (std::size_t b = 0; b < pose.size(); ++b) pose[b] = admissible(b, pose[b]);
  for (RigidPose& p : pose)
    for (std::size_t k = 0; k < 9; k += 4) p.turned[k] -= 1;
  set_nodes(u, [&](std::size_t b, const Vector3& Y) { return plus(pose[b].moved, pose[b].turned * Y); });
}

void RigidBodies::put_change(Vec u, Vec from, Vec to) const {
  const Entries before(from), goal(to);
  double* values = nullptr;
  check(VecGetArray(u, &values));
  for (std::size_t i = 0; i < owned_; ++i)
    for (int k = row_[i]; k < row_[i] + dim_; ++k) values[k] += goal[k] - before[k];
  check(VecRestoreArray(u, &values));
}

void RigidBodies::keep_bodies_only(Vec f) const {
  Handle<Vec> all;
  check(VecDuplicate(f, all.out()));
  check(VecSet(all, 0));
  put_change(all, all, f);
  check(VecCopy(all, f));
}

void RigidBodies::place(Vec u) {
  if (empty()) return;
  now_ = poses(sums_of(Weight::mass, u));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    RigidPlace& place = reduction_.bodies()[b];
    place.trial = place.test = now_[b].turned;
    if (dynamic_)
      for (std::size_t i = 0; i < 9; ++i) place.test[i] = (now_[b].turned[i] + start_[b].turned[i]) / 2;
    if (symmetric_) place.trial = place.test;
  }
}

void RigidBodies::reduce(Vec u, Vec f, const std::vector<double>* acceleration) {
  if (empty()) return;
  place(u);
  std::vector<Sums> total = sums_of(Weight::one, f);
  if (acceleration != nullptr) {
    const std::vector<Sums> inertia = mass_sums(*acceleration);
    for (std::size_t b = 0; b < total.size(); ++b) total[b].add(inertia[b]);
  }
  set_nodes(f, [](std::size_t, const Vector3&) { return Vector3{}; });
  double* values = nullptr;
  check(VecGetArray(f, &values));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidPlace& place = reduction_.bodies()[b];
    const Vector3 moment = axial(total[b].moment * transposed(place.test));
    visit_unknowns(b, [&](int row, int, std::size_t c) {
      if (!place.held[c]) values[row] = c < 3 ? total[b].sum[c] : moment[c - 3] / place.length;
    });
  }
  check(VecRestoreArray(f, &values));
  if (acceleration != nullptr || !dynamic_) forces_ = std::move(total);
}

void RigidBodies::expand(Vec u, Vec du) {
  if (empty()) return;
  place(u);
  const int width = dim_ + reduction_.rotations();
  std::vector<double> change(6 * bodies_.size(), 0.0);
  double* values = nullptr;
  check(VecGetArray(du, &values));
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    visit_unknowns(b, [&](int row, int r, std::size_t) { change[6 * b + at(r)] = values[row]; });
  sum_over_ranks(comm_, change);
  for (std::size_t i = 0; i < owned_; ++i) {
    const RigidPlace& place = reduction_.bodies()[at(body_[i])];
    const double* of_body = &change[6 * at(body_[i])];
    double mode[6];
    for (int k = 0; k < dim_; ++k) {
      reduction_.modes(place, place.trial, &X_[at(dim_) * i], k, mode);
      double& mine = values[row_[i] + k];
      mine = of_body[k];
      for (int r = dim_; r < width; ++r) mine += mode[r] * of_body[r];
    }
  }
  check(VecRestoreArray(du, &values));
}

// A mass on the translations of a body, and a matrix over its rotations.
void RigidBodies::add_block(std::size_t body, double mass, const Matrix3& turn, Mat K) const {
  const int width = dim_ + reduction_.rotations();
  const RigidPlace& place = reduction_.bodies()[body];
  PetscInt rows[6];
  double block[36] = {};
  reduction_.rows(place, rows);
  for (int k = 0; k < dim_; ++k) block[k * width + k] = mass;
  for (int i = dim_; i < width; ++i)
    for (int j = dim_; j < width; ++j) {
      const std::size_t p = component_of(i) - 3, q = component_of(j) - 3;
      block[i * width + j] = turn[3 * p + q] / (place.length * place.length);
    }
  check(MatSetValues(K, width, rows, width, rows, block, ADD_VALUES));
}

void RigidBodies::add_mass(std::size_t body, double factor, Mat K) const {
  if (slot_row_[body][0] < 0) return;
  const RigidPlace& place = reduction_.bodies()[body];
  Matrix3 turn = inertia_of(place.trial, bodies_[body].second, place.test);
  for (double& entry : turn) entry *= factor;
  add_block(body, factor * bodies_[body].mass, turn, K);
}

void RigidBodies::add_tangent(Vec u, double mass_shift, Mat K) {
  place(u);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (slot_row_[b][0] < 0) continue;
    const RigidPlace& place = reduction_.bodies()[b];
    Matrix3 turn = inertia_of(place.trial, bodies_[b].second, place.test);
    for (double& entry : turn) entry *= mass_shift;
    if (b < forces_.size()) {
      // Arms of the test functions turn with the body, half as far at the middle of the step:
      // (w x r) x f = r (f.w) - w (r.f).
      const Matrix3 S = place.trial * transposed(forces_[b].moment);
      const double part = dynamic_ ? 0.5 : 1;
      for (std::size_t i = 0; i < 9; ++i) turn[i] += part * (S[i] - (i % 4 == 0 ? trace(S) : 0));
    }
    if (symmetric_) {
      const Matrix3 other = transposed(turn);
      for (std::size_t i = 0; i < 9; ++i) turn[i] = (turn[i] + other[i]) / 2;
    }
    add_block(b, mass_shift * bodies_[b].mass, turn, K);
  }
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

void RigidBodies::strike(Vec f, Vec gain) const {
  if (empty()) return;
  const std::vector<Sums> total = sums_of(Weight::one, f);
  std::vector<Vector3> speed(bodies_.size()), spin(bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    const Matrix3& R = start_[b].turned;
    for (std::size_t k = 0; k < at(dim_); ++k)
      if (body.held[k] == RigidBody::free_motion) speed[b][k] = total[b].sum[k] / body.mass;
    Vector3 moment = axial(total[b].moment * transposed(R));
    Matrix3 J = inertia_of(R, body.second, R);
    if (dim_ == 2) J = {1, 0, 0, 0, 1, 0, 0, 0, body.second[0] + body.second[4]};
    for (std::size_t k = 0; k < 3; ++k) {
      if (body.held[3 + k] == RigidBody::free_motion) continue;
      moment[k] = 0;
      for (std::size_t j = 0; j < 3; ++j) J[3 * k + j] = J[3 * j + k] = j == k ? 1 : 0;
    }
    spin[b] = inverse(J) * moment;
  }
  set_nodes(gain, [&](std::size_t b, const Vector3& Y) {
    return plus(speed[b], cross(spin[b], start_[b].turned * Y));
  });
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
  // Slope at t = 0 of data over t, one-sided.
  const auto slope = [&](const Expression& data, const double* x) {
    return (-3 * data(x, dim_, 0) + 4 * data(x, dim_, h) - data(x, dim_, 2 * h)) / (2 * h);
  };
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
                   : moves ? slope(*bc->component[k], body.centre.data())
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
      spin[k] = slope(*bc.rotation[k], body.centre.data());
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

double RigidBodies::book_reactions(Vec u, Vec f, const std::vector<double>* acceleration, double factor) {
  if (empty()) return 0;
  Handle<Vec> copy;
  check(VecDuplicate(f, copy.out()));
  check(VecCopy(f, copy));
  std::vector<Sums> kept = forces_;
  std::vector<double> still;
  if (acceleration == nullptr) still.assign(at(dim_) * body_of_node_.size(), 0.0);
  reduce(u, copy, acceleration != nullptr ? acceleration : &still);
  double work = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidPlace& place = reduction_.bodies()[b];
    const Vector3 moment = axial(forces_[b].moment * transposed(place.test));
    const Vector3 turn = cayley_vector(now_[b].turned * transposed(start_[b].turned));
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t entry = 7 * b + 1 + k;
      const double before = row_state_->committed[entry];
      double& now = row_state_->trial[entry];
      now = 0;
      if (bodies_[b].held[k] == RigidBody::free_motion || (k < 3 && k >= at(dim_))) continue;
      now = factor * (k < 3 ? forces_[b].sum[k] : moment[k - 3]);
      const double way = k < 3 ? now_[b].moved[k] - start_[b].moved[k] : turn[k - 3];
      work += (dynamic_ ? now : (now + before) / 2) * way;
    }
  }
  forces_ = std::move(kept);
  return work;
}

const double* RigidBodies::reactions(int body) const { return &row_state_->trial[7 * at(body) + 1]; }

double RigidBodies::angle(int body) const { return row_state_->trial[7 * at(body)]; }

void RigidBodies::advance(Vec u) {
  if (empty()) return;
  const std::vector<RigidPose> pose = poses(sums_of(Weight::mass, u));
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    row_state_->trial[7 * b] =
        row_state_->committed[7 * b] + rotation_vector(pose[b].turned * transposed(start_[b].turned))[2];
}

} // namespace impact
