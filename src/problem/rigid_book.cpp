#include <impact/petsc/error.hpp>
#include <impact/problem/rigid_bodies.hpp>

/// Reactions of the prescribed motion of rigid bodies, their work, and the row of the state table.
namespace impact {

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
  const Handle<Vec> copy = [&] {
    Handle<Vec> other;
    check(VecDuplicate(f, other.out()));
    check(VecCopy(f, other));
    return other;
  }();
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
