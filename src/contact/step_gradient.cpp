#include <algorithm>
#include <impact/contact/interface.hpp>
#include <impact/kernel/contact_pair.hpp>

/// Contact in a step: forces along the gradients at its middle, where a turn of both bodies, however far, is
/// an infinitesimal one of the mean configuration: du = spin x (x_n + x_{n+1})/2. Gaps and slips do not feel
/// it, and the moment of the forces about the mean places vanishes. Their work over the step is that of the
/// change of the gaps to third order. A stabilised step takes the gaps of its end as they are, an
/// energy-conserving one the change along the gradients itself.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// An overlap at the start of a step that the step closes, in mean secondary facets.
constexpr double small_overlap = 2e-3;

} // namespace

std::vector<double> ContactInterface::place_of_gradients(const std::vector<double>& u) const {
  if (step_.rule == StepRule::start) return step_.start;
  std::vector<double> m(u.size());
  std::transform(u.begin(), u.end(), step_.start.begin(), m.begin(),
                 [](double x, double y) { return (x + y) / 2; });
  return m;
}

// Forms bring gradients of what presses: with these multipliers that is all within a facet.
PressureLaw ContactInterface::reaching_law() const { return {step_.reach, penalty()}; }

std::vector<double> ContactInterface::relative_start() const {
  std::vector<double> start = form_->nodes().displacement(step_.u_n);
  const std::array<double, 3> moved = pose_at(time_).moved;
  for (std::size_t i = 0; i < start.size(); ++i) start[i] += moved[i % at(dim_)];
  return start;
}

double ContactInterface::closed_within_step(Vec u, double least) const {
  if (!step_.u_n) return 0;
  std::vector<double> depth(multiplier_->trial.size(), 0.0);
  const auto deepest = [&] {
    double largest = 0;
    for (double d : depth) largest = std::max(largest, d / mean_length_);
    MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, mesh_->comm());
    return largest > least ? largest : 0;
  };
  form_->visit(form_->nodes().displacement(u), Derivatives::none, law(),
               [&](const Constraint& c) { depth[at(c.index)] = -c.gap; });
  if (deepest() == 0) return 0;
  form_->visit(relative_start(), Derivatives::none, law(),
               [&](const Constraint& c) { depth[at(c.index)] += std::min(0.0, c.gap); });
  return deepest();
}

void ContactInterface::find_start_gaps() {
  step_.start = relative_start();
  const std::size_t count = multiplier_->trial.size();
  if (exact_work())
    step_.start_gap = gap_->committed;
  else
    step_.start_gap.assign(count, unknown_gap);
  step_.reach.assign(count, penalty() * mean_length_);
  form_->visit(step_.start, Derivatives::none, reaching_law(), [&](const Constraint& c) {
    // What was open stays free of force at the start; what was not followed yet starts from what it is.
    double& start = step_.start_gap[at(c.index)];
    if (start == unknown_gap)
      start = c.gap;
    else if (start >= 0)
      start = std::max(0.0, c.gap);
  });
}

// The gap that a stabilised step may leave. Where the present pairs see an overlap at the start of the step,
// because a constraint came to face other facets or surfaces crumpled, closing it would do the work w p times
// its depth on the bodies, whatever the step (78'). It stays until the bodies part; small ones are closed.
double ContactInterface::kept_overlap(int index) const {
  const double start = step_.start_gap[at(index)];
  if (start == unknown_gap || settings_.enforce == Enforcement::penalty) return 0;
  return start < -small_overlap * mean_length_ ? start : 0;
}

void ContactInterface::begin_projection() {
  before_projection_ = {multiplier_->trial, penalty_->trial};
  std::fill(multiplier_->trial.begin(), multiplier_->trial.end(), 0.0);
  friction_suspended_ = true;
  if (step_.rule == StepRule::middle) step_.rule = StepRule::start;
}

void ContactInterface::end_projection() {
  multiplier_->trial = std::move(before_projection_[0]);
  penalty_->trial = std::move(before_projection_[1]);
  friction_suspended_ = false;
  if (step_.rule == StepRule::start) step_.rule = StepRule::middle;
}

namespace {

// Gradients of constraints, by their index, over their nodes.
class Gradients {
public:
  explicit Gradients(std::size_t count) : place_(count) {}
  void keep(const Constraint& c) {
    place_[at(c.index)] = {node_.size(), value_.size(), c.node.size()};
    node_.insert(node_.end(), c.node.begin(), c.node.end());
    value_.insert(value_.end(), c.gradient.begin(), c.gradient.end());
  }
  // Over the nodes of c, to which those that it lacks are added at the end where `may_add`; false where they
  // may not, or nothing was kept.
  bool over_nodes_of(const Constraint& c, bool may_add, std::vector<int>& node,
                     std::vector<double>& gradient) const {
    const Place& kept = place_[at(c.index)];
    if (kept.count == 0) return false;
    const std::size_t m = c.gradient.size() / c.node.size();
    node.assign(c.node.begin(), c.node.end());
    gradient.assign(c.gradient.size(), 0.0);
    for (std::size_t i = 0; i < kept.count; ++i) {
      const auto place =
          static_cast<std::size_t>(std::find(node.begin(), node.end(), node_[kept.node + i]) - node.begin());
      if (place == node.size()) {
        if (!may_add) return false;
        node.push_back(node_[kept.node + i]);
        gradient.resize(m * node.size(), 0.0);
      }
      for (std::size_t k = 0; k < m; ++k) gradient[m * place + k] += value_[kept.value + m * i + k];
    }
    return true;
  }

private:
  struct Place {
    std::size_t node = 0, value = 0, count = 0;
  };
  std::vector<Place> place_;
  std::vector<int> node_;
  std::vector<double> value_;
};

} // namespace

void ContactInterface::visit_step(const std::vector<double>& u, Derivatives derivatives,
                                  const ConstraintVisitor& visitor) const {
  const PressureLaw law = this->law();
  const auto m = at(dim_);
  const bool of_end = step_.rule == StepRule::middle, strikes = step_.rule == StepRule::start;
  const bool to_end = of_end && derivatives == Derivatives::tangent && !symmetric_;
  std::vector<double> end_gap(of_end || strikes ? multiplier_->trial.size() : 0, unknown_gap);
  std::vector<double> end_gradient, gradient, slip_gradient;
  std::vector<int> node;
  // The matrix holds all nodes that may lie opposite a node, not those opposite a point.
  const bool adds_nodes = multiplier_->support == Support::vertex;
  Gradients end(to_end ? end_gap.size() : 0);
  if (of_end || strikes)
    form_->visit(u, to_end ? Derivatives::first : Derivatives::none, reaching_law(),
                 [&](const Constraint& c) {
                   end_gap[at(c.index)] = c.gap;
                   if (to_end) end.keep(c);
                 });
  form_->visit(place_of_gradients(u), Derivatives::first, reaching_law(), [&](Constraint c) {
    const std::size_t n = c.gradient.size();
    const auto moved = [&](std::size_t i) {
      const std::size_t k = dof(c.node[i % n / m], i % m);
      return u[k] - step_.start[k];
    };
    // It faces nothing any more. The gradients of the start know no edge: a body that flies past it is not
    // struck either.
    if ((of_end || strikes) && end_gap[at(c.index)] == unknown_gap) return;
    c.slip = {};
    for (std::size_t i = 0; i < c.slip_gradient.size(); ++i) c.slip[i / n] += c.slip_gradient[i] * moved(i);
    if (of_end) {
      c.gap = end_gap[at(c.index)];
      c.gap -= kept_overlap(c.index);
      if (to_end && end.over_nodes_of(c, adds_nodes, node, end_gradient)) {
        c.end_gradient = end_gradient;
        if (const std::size_t more = end_gradient.size(); more > n) {
          gradient.assign(c.gradient.begin(), c.gradient.end());
          gradient.resize(more, 0.0);
          slip_gradient.assign(c.slip_gradient.size() / n * more, 0.0);
          for (std::size_t i = 0; i < c.slip_gradient.size(); ++i)
            slip_gradient[i / n * more + i % n] = c.slip_gradient[i];
          c.node = node;
          c.gradient = gradient;
          c.slip_gradient = slip_gradient;
        }
      }
    } else {
      double change = 0, start = step_.start_gap[at(c.index)];
      for (std::size_t i = 0; i < n; ++i) change += c.gradient[i] * moved(i);
      // It faces something now and did not at the start.
      if (start == unknown_gap) start = std::max(0.0, c.gap - change / 2);
      if (strikes) start = std::max(0.0, start);
      c.gap = start + change;
      if (exact_work()) {
        c.lambda = 0;
        c.pressure = secant_pressure(penalty(), start, c.gap).p;
        c.active = c.pressure > 0;
        return visitor(c);
      }
    }
    c.lambda = law.multiplier(c.index);
    c.pressure = law.pressure(c.index, c.gap);
    c.active = law.active(c.index, c.gap);
    visitor(c);
  });
}

} // namespace impact
