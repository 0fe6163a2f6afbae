#include "rigid_inertia.hpp"
#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <span>

/// Motion of rigid bodies: what a solve and a step need, and the reactions of what is prescribed. Set-up:
/// rigid_bodies_setup.cpp; rates: rigid_rates.cpp; what conditions prescribe: rigid_data.cpp.
namespace impact {

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

double RigidBodies::book_reactions(Vec u, Vec f, Vec beside) {
  if (empty()) return 0;
  place(u);
  const std::vector<Sums> total = sums_of(Weight::one, f), more = sums_of(Weight::one, beside);
  double work = 0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidBody& body = bodies_[b];
    const Matrix3& arms = reduction_.bodies()[b].test;
    const Vector3 turn = cayley_vector(now_[b].turned * transposed(start_[b].turned));
    Vector3 moment = axial(total[b].moment * transposed(arms));
    const Vector3 beside_moment = axial(more[b].moment * transposed(now_[b].turned));
    if (dynamic_) { // of it the free components take their part
      const Matrix3 J = inertia_of(arms, body.second, arms);
      const Vector3 taken = J * free_spin(body, J, moment);
      for (std::size_t k = 0; k < 3; ++k) moment[k] -= taken[k];
    }
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t entry = 7 * b + 1 + k;
      const double before = row_state_->committed[entry];
      double& now = row_state_->trial[entry];
      now = 0;
      if (body.held[k] == RigidBody::free_motion || (k < 3 && k >= at(dim_))) continue;
      now = k < 3 ? total[b].sum[k] : moment[k - 3];
      const double way = k < 3 ? now_[b].moved[k] - start_[b].moved[k] : turn[k - 3];
      work += (dynamic_ ? now : (now + before) / 2) * way;
      now += k < 3 ? more[b].sum[k] : beside_moment[k - 3];
    }
  }
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
