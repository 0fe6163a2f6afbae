#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/solve/path_control.hpp>

namespace impact {

namespace {

constexpr double exact = 1e-4; // part of the asked energy by which a step may miss it
constexpr int most_solves = 40;

} // namespace

void go_to_load(MotionProblem& motion, double load) {
  MotionStep step = motion.step();
  step.t = load;
  motion.begin(step);
}

PathControl::PathControl(StateTable& state, const CouplingScenario& settings)
    : settings_(settings), row_(state.add({load_parameter_row, Support::global, 2}, 2)) {
  row_.committed = row_.trial = {0, 1};
}

// As the step before went, at most by dt, and never back over half of the load.
double PathControl::guess(double dt) const {
  const double s = row_.committed[0], grown = dt * std::min(row_.committed[1], 1.0);
  return s + std::max(grown, -s / 2);
}

void PathControl::begin(double dt) {
  dt_ = dt;
  load_ = guess(dt);
  slope_ = 2;
  change_ = 0;
  row_.trial = {load_, (load_ - start()) / dt};
}

double PathControl::asked() const { return settings_.path_dissipation * dt_ / settings_.dt; }

/// Factors of the load between which the asked energy lies, and what they miss it by.
struct PathControl::Bracket {
  double low = 0, high = 0, miss_low = 0, miss_high = 0;
  int stays = 0; // side that the last points left alone: -1 low, 1 high

  bool closed() const { return low > 0 && high > 0; }
  void take(double factor, double miss) {
    const int side = miss > 0 ? -1 : 1;
    (miss > 0 ? high : low) = factor;
    (miss > 0 ? miss_high : miss_low) = miss;
    // Illinois: an end that stays counts half, so that both move in.
    if (closed() && side == stays) (miss > 0 ? miss_low : miss_high) /= 2;
    stays = side;
  }
  double inside() const { return low + (high - low) * miss_low / (miss_low - miss_high); }
  bool vanished() const { return closed() && high - low < 1e-12 * high; }
};

ScalarOutcome PathControl::solve(DamageProblem& damage, DamageStep step, std::vector<double>& phi) {
  const double target = asked(), largest = std::pow((start() + dt_) / load_, power_),
               before = damage.crack_energy(step, *step.phi_n);
  const std::vector<double> guess = phi;
  Bracket bracket;
  ScalarOutcome sum;
  double factor = std::min(1.0, largest), last_factor = 0, last_taken = 0;
  for (int solves = 1;; ++solves) {
    step.drive_factor = factor * factor;
    if (solves > 1 && !bracket.closed()) phi = guess;
    const ScalarOutcome outcome = damage.solve(step, phi);
    sum.reason = outcome.reason;
    sum.newton += outcome.newton;
    sum.linear += outcome.linear;
    if (outcome.reason < 0) return sum;
    const double taken = damage.crack_energy(step, phi) - before, miss = taken - target;
    if (last_factor > 0 && last_taken > 0 && taken > 0 && taken != last_taken)
      slope_ = std::clamp(std::log(taken / last_taken) / std::log(factor / last_factor), 1.0, 50.0);
    last_factor = factor;
    last_taken = taken;
    if (std::abs(miss) <= exact * target || (miss < 0 && factor >= largest)) break;
    bracket.take(factor, miss);
    if (bracket.vanished() || solves == most_solves) break;
    if (bracket.closed())
      factor = bracket.inside();
    else // outside of what is known: by the slope, at most twofold
      factor *= std::clamp(
          taken > 0 ? std::pow(target / taken, 1 / slope_) * (miss > 0 ? 0.999 : 1.001) : 2.0, 0.5, 2.0);
    factor = std::min(factor, largest);
  }
  row_.trial = {load_, (load_ - start()) / dt_};
  change_ = std::abs(factor - 1);
  load_ *= std::pow(factor, 1 / power_);
  return sum;
}

// Of what is prescribed or of the forces, whichever grows more.
void PathControl::find_power(MotionProblem& motion, Vec u) {
  constexpr double part = 1e-3;
  const FieldLayout& layout = motion.discretisation().displacement;
  Handle<Vec> values = layout.make_global();
  const double here = motion.step().t;
  double size[2][2]; // [at the load, beyond it][of displacements, of forces]
  for (int beyond = 0; beyond < 2; ++beyond) {
    go_to_load(motion, load_ * (1 + beyond * part));
    check(VecSet(values, 0));
    motion.impose(values);
    size[beyond][0] = Get(VecNorm)(values, NORM_2);
    motion.loads(u, values);
    size[beyond][1] = Get(VecNorm)(values, NORM_2);
  }
  go_to_load(motion, here);
  power_ = 0;
  for (int k = 0; k < 2; ++k)
    if (size[0][k] > 0) power_ = std::max(power_, std::log(size[1][k] / size[0][k]) / std::log(1 + part));
  power_ = std::abs(power_ - 1) < 1e-6 ? 1 : std::clamp(power_, 0.25, 4.0);
}

} // namespace impact
