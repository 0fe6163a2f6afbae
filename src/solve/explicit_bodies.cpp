#include <algorithm>
#include <cmath>
#include <impact/math/free_turn.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/solve/explicit_bodies.hpp>

namespace impact {

namespace {

constexpr std::size_t of_force = 0, of_moment = 3, of_stiffness = 12, sums_of_body = 13;
constexpr double longest_turn = 0.5; // in a step: its iterations shrink by half of it
constexpr int most_iterations = 100;

Vector3 plus(const Vector3& a, const Vector3& b, double factor = 1) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}

Vector3 times(double factor, const Vector3& a) { return {factor * a[0], factor * a[1], factor * a[2]}; }

double inner(const Matrix3& a, const Matrix3& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 9; ++i) sum += a[i] * b[i];
  return sum;
}

} // namespace

ExplicitBodies::ExplicitBodies(MotionProblem& motion, StateTable& state)
    : rigid_(motion.rigid()), comm_(motion.discretisation().mesh.comm()), dim_(motion.discretisation().dim()),
      nodes_(rigid_.owned_nodes()), turn_(rigid_.bodies().size()) {
  if (empty()) return;
  const std::size_t bodies = rigid_.bodies().size();
  row_ = &state.add({"rigid_motion", Support::global, static_cast<int>(size * bodies)}, size * bodies);
  sums_.resize(sums_of_body * bodies);
  for (const RigidBody& body : rigid_.bodies()) {
    Matrix3 J = body.second;
    const double t = trace(J);
    for (std::size_t i = 0; i < 9; ++i) J[i] = (i % 4 == 0 ? t : 0) - J[i];
    if (dim_ == 2) J = {1, 0, 0, 0, 1, 0, 0, 0, body.second[0] + body.second[4]};
    inertia_.push_back(J);
    inverse_.push_back(inverse(J));
  }
}

ExplicitBodies::Motion ExplicitBodies::body(const std::vector<double>& half, std::size_t b) const {
  static_assert(sizeof(Motion) == 36 * sizeof(double));
  Motion motion;
  std::copy_n(&half[size * b], size, reinterpret_cast<double*>(&motion));
  return motion;
}

void ExplicitBodies::keep(std::vector<double>& half, std::size_t b, const Motion& motion) const {
  std::copy_n(reinterpret_cast<const double*>(&motion), size, &half[size * b]);
}

Vector3 ExplicitBodies::velocity_of(std::size_t b, const Matrix3& R, const Vector3& spin) const {
  return R * (inverse_[b] * (transposed(R) * spin));
}

template <class Field> void ExplicitBodies::set_nodes(Vec x, Field&& field) const {
  double* values = nullptr;
  check(VecGetArray(x, &values));
  for (const RigidBodies::OwnedNode& node : nodes_) {
    const Vector3 value = field(node.body, node.arm);
    std::copy_n(value.begin(), dim_, values + node.row);
  }
  check(VecRestoreArray(x, &values));
}

void ExplicitBodies::start(Vec u, Vec v) {
  if (empty()) return;
  const std::vector<RigidMotionState> state = rigid_.motion(u, v);
  for (std::size_t b = 0; b < state.size(); ++b) {
    Motion m;
    m.moved = state[b].pose.moved;
    m.turned = state[b].pose.turned;
    std::copy_n(state[b].velocity.begin(), 3, m.velocity.begin());
    m.spin = state[b].spin;
    keep(row_->committed, b, m);
    keep(row_->trial, b, m);
  }
}

void ExplicitBodies::resume() {
  for (std::size_t b = 0; b < inertia_.size(); ++b) rigid_.turn_arms(b, body(row_->committed, b).turned);
}

double ExplicitBodies::longest() const {
  double fastest = 0;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    const Motion m = body(row_->committed, b);
    fastest = std::max(fastest, length(velocity_of(b, m.turned, m.spin)));
  }
  return longest_turn / fastest; // infinite at rest
}

void ExplicitBodies::move(double dt, Vec u) {
  if (empty()) return;
  dt_ = dt;
  std::vector<Motion> now;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    Motion m = body(row_->committed, b);
    m.velocity = plus(m.velocity, m.acceleration, dt / 2);
    m.spin = plus(m.spin, m.torque, dt / 2);
    m.moved = plus(m.moved, m.velocity, dt);
    turn_[b] = m.turned * free_turn(inverse_[b], transposed(m.turned) * m.spin, dt);
    m.turned = nearest_rotation(rotation_of(turn_[b]) * m.turned);
    rigid_.turn_arms(b, m.turned);
    keep(row_->trial, b, m);
    now.push_back(m);
  }
  set_nodes(u,
            [&](std::size_t b, const Vector3& Y) { return plus(now[b].moved, minus(now[b].turned * Y, Y)); });
}

void ExplicitBodies::sum_up(std::span<const Force> forces, std::span<const double> stiffness) {
  std::fill(sums_.begin(), sums_.end(), 0.0);
  for (const Force& force : forces) {
    const Entries values(force.f);
    for (const RigidBodies::OwnedNode& node : nodes_) {
      double* const of_body = &sums_[sums_of_body * node.body];
      for (int k = 0; k < dim_; ++k) {
        const double f = force.factor * values[node.row + k];
        of_body[of_force + at(k)] += f;
        for (std::size_t j = 0; j < 3; ++j) of_body[of_moment + 3 * at(k) + j] += f * node.arm[j];
      }
    }
  }
  for (std::size_t b = 0; b < stiffness.size(); ++b) sums_[sums_of_body * b + of_stiffness] = stiffness[b];
  sum_over_ranks(comm_, sums_);
}

// What conditions turn a body by in the next step, about the axes that are held; zero about the others.
Vector3 ExplicitBodies::prescribed_turn(std::size_t b, double t, double dt, const Matrix3& R) const {
  const RigidBody& body = rigid_.bodies()[b];
  const double* x = body.centre.data();
  Vector3 turn{};
  if (rigid_.turns_as_told(body)) {
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto on = rigid_.hold(body, 3 + k); on.data) turn[k] = (*on.data)(x, dim_, t + dt);
    return rotation_vector(rotation_of(turn) * transposed(R));
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (const auto on = rigid_.hold(body, 3 + k); on.data)
      turn[k] = on.rate ? integral(*on.data, x, dim_, t, t + dt)
                        : (*on.data)(x, dim_, t + dt) - (*on.data)(x, dim_, t);
  return turn;
}

// The momentum whose free turn is `turn` about the axes that are held, and that is `spin` about the others.
Vector3 ExplicitBodies::spin_for(std::size_t b, double dt, const Matrix3& R, const Vector3& spin,
                                 const Vector3& turn) const {
  const RigidBody& body = rigid_.bodies()[b];
  const Matrix3 back = transposed(R);
  Vector3 way = turn; // about the free axes to be found
  Matrix3 B{};
  for (int i = 0; i < most_iterations; ++i) {
    B = R * momentum_by_turn(inertia_[b], back * way) * back;
    for (double& entry : B) entry /= dt;
    Matrix3 rows = B;
    Vector3 right = spin;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!rigid_.hold(body, 3 + k).held) continue;
      for (std::size_t j = 0; j < 3; ++j) rows[3 * k + j] = j == k ? 1 : 0;
      right[k] = turn[k];
    }
    const Vector3 next = inverse(rows) * right;
    const double change = length(minus(next, way));
    way = next;
    if (change <= 1e-15 * length(way)) break;
  }
  return B * way;
}

// Held components take the acceleration and the torque by which the next step, if it is as long as this one,
// ends on their data; `share`: how much of an acceleration acts before that step, in steps. Their reactions
// are what the forces lack.
void ExplicitBodies::prescribe(std::size_t b, double t, double dt, double share, Motion& m,
                               const Motion* before) const {
  const RigidBody& body = rigid_.bodies()[b];
  double* const reaction = rigid_.booked(b);
  std::fill_n(reaction, 6, 0.0);
  const double* x = body.centre.data();
  for (std::size_t k = 0; k < at(dim_); ++k) {
    const auto on = rigid_.hold(body, k);
    if (!on.held) continue;
    const double goal = !on.data  ? 0
                        : on.rate ? m.moved[k] + integral(*on.data, x, dim_, t, t + dt)
                                  : (*on.data)(x, dim_, t + dt);
    const double free = m.acceleration[k];
    const double speed = before ? before->velocity[k] + dt / 2 * before->acceleration[k] : m.velocity[k];
    m.acceleration[k] = (goal - m.moved[k] - dt * speed) / (share * dt * dt);
    reaction[k] = body.mass * (m.acceleration[k] - free);
  }
  const bool turns = rigid_.hold(body, 3).held || rigid_.hold(body, 4).held || rigid_.hold(body, 5).held;
  if (!turns) return;
  const Vector3 goal =
      spin_for(b, dt, m.turned, plus(m.spin, m.torque, share * dt), prescribed_turn(b, t, dt, m.turned));
  for (std::size_t k = 0; k < 3; ++k) {
    if (!rigid_.hold(body, 3 + k).held) continue;
    const double free = m.torque[k];
    m.torque[k] = (goal[k] - m.spin[k]) / (share * dt);
    reaction[3 + k] = m.torque[k] - free;
  }
}

void ExplicitBodies::start_forces(double t, double dt, std::span<const Force> forces, Vec a) {
  if (empty()) return;
  sum_up(forces, {});
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    Motion m = body(row_->committed, b);
    std::copy_n(&sums_[sums_of_body * b + of_force], 3, m.force.begin());
    std::copy_n(&sums_[sums_of_body * b + of_moment], 9, m.moment.begin());
    m.acceleration = times(1 / rigid_.bodies()[b].mass, m.force);
    m.torque = axial(m.moment * transposed(m.turned));
    prescribe(b, t, dt, 0.5, m, nullptr);
    keep(row_->committed, b, m);
    keep(row_->trial, b, m);
  }
  put_acceleration(row_->committed, a);
}

double ExplicitBodies::push(double t, std::span<const Force> forces, std::span<const double> stiffness,
                            Vec a) {
  if (empty()) return 0;
  sum_up(forces, stiffness);
  work_ = {};
  double largest = 0;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    const Motion before = body(row_->committed, b);
    Motion half = body(row_->trial, b);
    half.velocity = plus(before.velocity, before.acceleration, dt_ / 2);
    half.spin = plus(before.spin, before.torque, dt_ / 2);
    Motion m = half;
    std::copy_n(&sums_[sums_of_body * b + of_force], 3, m.force.begin());
    std::copy_n(&sums_[sums_of_body * b + of_moment], 9, m.moment.begin());
    m.acceleration = times(1 / rigid_.bodies()[b].mass, m.force);
    m.torque = axial(m.moment * transposed(m.turned));
    prescribe(b, t, dt_, 1, m, &before);
    m.velocity = plus(half.velocity, m.acceleration, dt_ / 2);
    m.spin = plus(half.spin, m.torque, dt_ / 2);
    keep(row_->trial, b, m);
    book(b, before, half, m);
    rigid_.book_angle(b, turn_[b][2]);
    largest = std::max(largest, sums_[sums_of_body * b + of_stiffness] / rigid_.bodies()[b].mass);
  }
  put_acceleration(row_->trial, a);
  return largest;
}

// The kicks change the kinetic energy by dt/2 T . (w before + w after)/2, the turn between them by nothing.
// Nodal forces work on the chords of the turn, reactions on its rotation vector.
void ExplicitBodies::book(std::size_t b, const Motion& before, const Motion& half, const Motion& after) {
  const auto reactions = [&](const Motion& m, Vector3& force, Vector3& moment) {
    force = plus(times(rigid_.bodies()[b].mass, m.acceleration), m.force, -1);
    moment = minus(m.torque, axial(m.moment * transposed(m.turned)));
  };
  Vector3 force, moment, force_n, moment_n;
  reactions(before, force_n, moment_n);
  reactions(after, force, moment);
  const Vector3 way = minus(after.moved, before.moved);
  const double turned = dot(plus(moment, moment_n), turn_[b]) / 2;
  work_.supports += dot(plus(force, force_n), way) / 2 + turned;
  Matrix3 chord = after.turned, mean = after.moment;
  for (std::size_t i = 0; i < 9; ++i) {
    chord[i] -= before.turned[i];
    mean[i] = (mean[i] + before.moment[i]) / 2;
  }
  const auto kick = [&](const Matrix3& R, const Vector3& torque, const Vector3& from, const Vector3& to) {
    return dt_ / 4 * dot(torque, velocity_of(b, R, plus(from, to)));
  };
  const double turning = inner(chord, mean) + turned -
                         kick(before.turned, before.torque, before.spin, half.spin) -
                         kick(after.turned, after.torque, half.spin, after.spin);
  const auto square = [&](const Motion& m) { return dot(m.torque, velocity_of(b, m.turned, m.torque)); };
  const auto moving = [&](const Motion& m) {
    return rigid_.bodies()[b].mass * dot(m.acceleration, m.acceleration);
  };
  const double factor = -dt_ * dt_ / 8, swing = square(after), swing_n = square(before);
  work_.loss += factor * (moving(after) - moving(before)) + turning;
  work_.kept += factor * (moving(after) + swing);
  work_.exchange += turning - factor * (swing - swing_n);
}

double ExplicitBodies::kept(double dt) const {
  double sum = 0;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    const Motion m = body(row_->committed, b);
    sum += rigid_.bodies()[b].mass * dot(m.acceleration, m.acceleration) +
           dot(m.torque, velocity_of(b, m.turned, m.torque));
  }
  return -dt * dt / 8 * sum;
}

void ExplicitBodies::put_velocity(Vec v, double later) const {
  if (empty()) return;
  std::vector<Motion> now;
  std::vector<Vector3> turning;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    now.push_back(body(row_->trial, b));
    Motion& m = now.back();
    m.velocity = plus(m.velocity, m.acceleration, later);
    turning.push_back(velocity_of(b, m.turned, plus(m.spin, m.torque, later)));
  }
  set_nodes(v, [&](std::size_t b, const Vector3& Y) {
    return plus(now[b].velocity, cross(turning[b], now[b].turned * Y));
  });
}

void ExplicitBodies::leave_out(Vec x) const {
  set_nodes(x, [](std::size_t, const Vector3&) { return Vector3{}; });
}

// (a.M^-1 b)^2 <= (a.M^-1 a)(b.M^-1 b), and an impulse at a node moves it by `give` times that at most.
void ExplicitBodies::bound(Vec sizes, Vec most) const {
  std::vector<double> sum(inertia_.size(), 0.0), root;
  root.reserve(nodes_.size());
  {
    const Entries impulse(sizes);
    for (const RigidBodies::OwnedNode& node : nodes_) {
      const Vector3 X = plus(rigid_.bodies()[node.body].centre, node.arm);
      root.push_back(std::sqrt(rigid_.give(node.body, X.data())));
      sum[node.body] += root.back() * impulse[node.row];
    }
  }
  sum_over_ranks(comm_, sum);
  std::size_t i = 0;
  set_nodes(most, [&](std::size_t b, const Vector3&) { return Vector3{root[i++] * sum[b], 0, 0}; });
}

void ExplicitBodies::put_acceleration(const std::vector<double>& half, Vec a) const {
  std::vector<Motion> now;
  std::vector<Vector3> w, rate;
  for (std::size_t b = 0; b < inertia_.size(); ++b) {
    now.push_back(body(half, b));
    const Motion& m = now.back();
    w.push_back(velocity_of(b, m.turned, m.spin));
    rate.push_back(velocity_of(b, m.turned, minus(m.torque, cross(w.back(), m.spin))));
  }
  set_nodes(a, [&](std::size_t b, const Vector3& Y) {
    const Vector3 r = now[b].turned * Y;
    return plus(now[b].acceleration, plus(cross(rate[b], r), cross(w[b], cross(w[b], r))));
  });
}

} // namespace impact
