#include <algorithm>
#include <cmath>
#include <impact/contact/constraints.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/ranks.hpp>
#include <numeric>

/// Contact in a step (theory.md, motion in time): forces along the gradients at its middle, where a turn of
/// both bodies, however far, is an infinitesimal one of the mean configuration: du = spin x (x_n +
/// x_{n+1})/2. Gaps and slips do not feel it, and the moment of the forces about the mean places vanishes.
/// Their work over the step is that of the change of the gaps to third order. A stabilised step takes the
/// gaps of its end as they are, an energy-conserving one the change along the gradients itself.
namespace impact {

namespace {

// An overlap at the start of a step that the step closes, in mean secondary facets.
constexpr double small_overlap = 2e-3;
// By which what is left is pushed out in a step of 0.8 of the stable one, likewise: impacts are over before
// that is much, what slides into higher ground does so more slowly.
constexpr double push = 5e-4;

} // namespace

void Constraints::begin(StepRule rule, Handle<Vec> u_n, const std::array<double, 3>& moved) {
  step_ = {rule, std::move(u_n), moved, {}, {}, static_cast<bool>(left_), std::move(step_.given)};
  if (left_) {
    remember_springs();
    step_.given.assign(count_, 0.0);
  }
  if (rule != StepRule::none) find_start_gaps();
}

void Constraints::end() {
  step_.rule = StepRule::none;
  step_.finds_jumps = false;
  if (left_) left_.tell_table();
}

std::vector<double> Constraints::place_of_gradients(const ContactValues& u) const {
  if (step_.rule == StepRule::none) return u;
  if (step_.rule == StepRule::start) return step_.start;
  std::vector<double> m(u.size());
  std::transform(u.begin(), u.end(), step_.start.begin(), m.begin(),
                 [](double x, double y) { return (x + y) / 2; });
  return m;
}

std::vector<double> Constraints::relative_start() const {
  std::vector<double> start = nodes().displacement(step_.u_n);
  for (std::size_t i = 0; i < start.size(); ++i) start[i] += step_.moved[i % dim_];
  return start;
}

double Constraints::closed_within_step(Vec u, double least) const {
  if (!step_.u_n) return 0;
  std::vector<double> depth(count_, 0.0);
  const auto deepest = [&] {
    double largest = 0;
    for (double d : depth) largest = std::max(largest, d / mean_length_);
    largest = max_over_ranks(comm(), largest);
    return largest > least ? largest : 0;
  };
  form_->visit(nodes().displacement(u), Derivatives::none,
               [&](const Constraint& c) { depth[at(c.index)] = -c.gap; }, {});
  if (deepest() == 0) return 0;
  form_->visit(relative_start(), Derivatives::none,
               [&](const Constraint& c) { depth[at(c.index)] += std::min(0.0, c.gap); }, {});
  return deepest();
}

void Constraints::find_start_gaps() {
  step_.start = relative_start();
  if (works_exactly())
    step_.start_gap = gap_->committed;
  else
    step_.start_gap.assign(count_, unknown_gap);
  const auto keep = [&](const Constraint& c) {
    // What was open stays free of force at the start; what was not followed yet starts from what it is.
    double& start = step_.start_gap[at(c.index)];
    if (start == unknown_gap)
      start = c.gap;
    else if (start >= 0)
      start = std::max(0.0, c.gap);
  };
  form_->visit(step_.start, Derivatives::none, keep, {});
}

// The gap that a stabilised step may leave. Where the present pairs see an overlap at the start of the step,
// because a constraint came to face other facets or surfaces crumpled, closing it would do the work w p times
// its depth on the bodies, whatever the step (78'). It stays until the bodies part; small ones are closed.
void Constraints::keep_overlap(Constraint& c) const {
  if (step_.start_gap.size() != count_ || !law_->has_multipliers()) return;
  const double start = step_.start_gap[at(c.index)];
  if (start == unknown_gap || start >= -small_overlap * mean_length_) return;
  c.kept = start;
  c.gap -= start;
}

double Constraints::way_within_step(const ContactValues& u, const Constraint& c) const {
  const std::vector<double>&X = nodes().X, &start = nodes().start;
  double way = 0;
  for (std::size_t i = 0; i < c.gradient.size(); ++i) {
    const std::size_t k = dof(c.node[i / dim_], i % dim_);
    way += c.gradient[i] * (X[k] + u[k] - start[k]);
  }
  return way;
}

namespace {

// Of the row of a constraint: what is left, unknown_gap where it does not press; the energy of its spring,
// negative while it faces nothing, unknown_gap where that has gone for good, or was not followed.
enum Left : std::size_t { of_gap, of_spring, parts_of_left };

} // namespace

void Constraints::begin_jumps() {
  if (!left_) return;
  std::vector<double>& left = left_->committed;
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i % parts_of_left == of_gap ? 0 : unknown_gap;
}

// A constraint that presses and is not seen in this step may be seen in a later one: it went deeper than
// facets see, and comes back.
void Constraints::remember_springs() {
  const std::vector<double>& before = left_->committed;
  std::vector<double>& now = left_->trial;
  now = before;
  for (std::size_t row = 0; row < now.size(); row += parts_of_left)
    if (now[row + of_gap] == unknown_gap || now[row + of_spring] == unknown_gap)
      now[row + of_gap] = now[row + of_spring] = unknown_gap;
    else
      now[row + of_spring] = -std::abs(before[row + of_spring]);
}

// By which a constraint is deeper than the ways of both sides in the step explain: of one that did not press
// by its own, of others, which slide over kinks, by the longest of all.
double Constraints::jump(const ContactValues& u, const Constraint& c) const {
  const double* before = &left_->committed[parts_of_left * at(c.index)];
  if (before[of_gap] == unknown_gap) return c.gap - std::min(0.0, way_within_step(u, c));
  if (before[of_spring] == unknown_gap) return before[of_gap];
  const double depth = law_->depth(std::abs(before[of_spring]) / c.weight);
  if (before[of_spring] < 0) return std::min(before[of_gap], c.gap + depth); // it takes back what it lost
  return before[of_gap] + std::min(0.0, c.gap - before[of_gap] + depth + form_->search().motion());
}

// A jump is left for the time being; a spring is lost where what pressed is open, but not by its way (78'').
void Constraints::leave_jump(const ContactValues& u, Derivatives derivatives, Constraint& c) const {
  if (!left_ || left_.lacks(c.index) || law_->is_given()) return;
  double* const now = &left_->trial[parts_of_left * at(c.index)];
  if (step_.finds_jumps && derivatives != Derivatives::none) {
    if (c.gap < 0) {
      const auto spring = [&](double left) {
        Constraint pressed = c;
        pressed.gap -= left;
        return c.weight * law_->potential(pressed);
      };
      const double whole = std::min(0.0, std::max(c.gap, jump(u, c)));
      // What opens by itself is not pushed.
      const double pushed = c.gap < whole ? push * mean_length_ / form_->longest_step() : 0;
      now[of_gap] = std::min(0.0, whole + pushed);
      now[of_spring] = spring(now[of_gap]);
      const bool comes_back = left_->committed[parts_of_left * at(c.index) + of_spring] < 0;
      step_.given[at(c.index)] = now[of_spring] - (comes_back ? 0 : spring(whole));
    } else {
      now[of_gap] = unknown_gap;
      now[of_spring] = pressed(c.index) && c.gap > std::max(0.0, way_within_step(u, c)) ? unknown_gap : 0;
    }
  }
  // Between steps surfaces may change: what did not press has no spring, however deep it lies now.
  c.kept = now[of_gap] == unknown_gap ? std::min(0.0, c.gap) : now[of_gap];
  c.gap -= c.kept;
}

bool Constraints::pressed(int index) const {
  return left_ && !left_.lacks(index) && left_->committed[parts_of_left * at(index)] != unknown_gap;
}

double Constraints::taken_by_jumps() const {
  double sum = -std::accumulate(step_.given.begin(), step_.given.end(), 0.0);
  for (std::size_t row = 0; left_ && row < left_->trial.size(); row += parts_of_left)
    if (const double before = left_->committed[row + of_spring], now = left_->trial[row + of_spring];
        before > 0 && before != unknown_gap && (now == unknown_gap || now < 0))
      sum += before;
  return sum;
}

namespace {

// A gradient over the nodes of a constraint.
struct Gradient {
  std::vector<int> node;
  std::vector<double> value;

  // The same over the nodes of c, to which those that it lacks are added at the end where `may_add`; empty
  // where they may not.
  Gradient over_nodes_of(const Constraint& c, bool may_add) const {
    Gradient over{{c.node.begin(), c.node.end()}, std::vector<double>(c.gradient.size(), 0.0)};
    for (std::size_t i = 0, m = value.size() / std::max<std::size_t>(1, node.size()); i < node.size(); ++i) {
      const auto place = static_cast<std::size_t>(std::find(over.node.begin(), over.node.end(), node[i]) -
                                                  over.node.begin());
      if (place == over.node.size()) {
        if (!may_add) return {};
        over.node.push_back(node[i]);
        over.value.resize(m * over.node.size(), 0.0);
      }
      for (std::size_t k = 0; k < m; ++k) over.value[m * place + k] += value[m * i + k];
    }
    return over;
  }
};

} // namespace

// Between the steps of an energy-conserving run: the state at the end of the last one.
void Constraints::visit_followed(const ContactValues& u, Derivatives derivatives,
                                 const ConstraintVisitor& visitor) const {
  const auto follow = [&](Constraint& c) {
    const double followed = gap_->trial[at(c.index)];
    if (followed != unknown_gap) c.gap = followed < 0 ? followed : std::max(0.0, c.gap);
    visitor(c);
  };
  form_->visit(u, derivatives, follow, {});
}

void Constraints::keep_gaps(Vec u) {
  std::vector<double> gap(count_, unknown_gap);
  visit(u, Derivatives::first, [&](const Constraint& c) { gap[at(c.index)] = c.gap; });
  share(gap, 1);
  gap_->trial = std::move(gap);
}

void Constraints::visit_curvature(const ContactValues& u, std::vector<double>& of_gap,
                                  std::vector<Tangential>& of_slip, const BlockVisitor& visitor) const {
  if (step_.rule == StepRule::start) return;
  if (step_.rule == StepRule::middle) { // which moves by half of what u does; exact work has twice the force
    for (double& factor : of_gap) factor /= 2;
    for (Tangential& factor : of_slip) factor = {factor[0] / 2, factor[1] / 2};
  }
  form_->visit_curvature(place_of_gradients(u), {of_gap, of_slip}, visitor);
}

void Constraints::visit_step(const ContactValues& u, Derivatives derivatives,
                             const ConstraintVisitor& visitor) const {
  const bool of_end = step_.rule == StepRule::middle, strikes = step_.rule == StepRule::start;
  const bool to_end = of_end && derivatives == Derivatives::tangent && !symmetric_;
  std::vector<double> end_gap(of_end || strikes ? count_ : 0, unknown_gap);
  std::vector<double> gradient, slip_gradient;
  Gradient end_here;
  std::vector<Gradient> end(to_end ? end_gap.size() : 0);
  const auto keep_end = [&](const Constraint& c) {
    end_gap[at(c.index)] = c.gap;
    if (to_end) end[at(c.index)] = {{c.node.begin(), c.node.end()}, {c.gradient.begin(), c.gradient.end()}};
  };
  if (of_end || strikes) form_->visit(u, to_end ? Derivatives::first : Derivatives::none, keep_end, {});
  const auto complete = [&](Constraint& c) {
    const std::size_t n = c.gradient.size();
    const auto moved = [&](std::size_t i) {
      const std::size_t k = dof(c.node[i % n / dim_], i % dim_);
      return u[k] - step_.start[k];
    };
    // It faces nothing any more. The gradients of the start know no edge: a body that flies past it is not
    // struck either.
    if ((of_end || strikes) && end_gap[at(c.index)] == unknown_gap) return;
    c.slip = {};
    for (std::size_t i = 0; i < c.slip_gradient.size(); ++i) c.slip[i / n] += c.slip_gradient[i] * moved(i);
    if (of_end) {
      c.gap = end_gap[at(c.index)];
      keep_overlap(c);
      // The matrix holds all nodes that may lie opposite a node, not those opposite a point.
      if (!to_end || end[at(c.index)].node.empty()) return visitor(c);
      end_here = end[at(c.index)].over_nodes_of(c, nodal_);
      c.end_gradient = end_here.value;
      if (const std::size_t more = end_here.value.size(); more > n) {
        gradient.assign(c.gradient.begin(), c.gradient.end());
        gradient.resize(more, 0.0);
        slip_gradient.assign(c.slip_gradient.size() / n * more, 0.0);
        for (std::size_t i = 0; i < c.slip_gradient.size(); ++i)
          slip_gradient[i / n * more + i % n] = c.slip_gradient[i];
        c.node = end_here.node;
        c.gradient = gradient;
        c.slip_gradient = slip_gradient;
      }
    } else {
      double change = 0, start = step_.start_gap[at(c.index)];
      for (std::size_t i = 0; i < n; ++i) change += c.gradient[i] * moved(i);
      // It faces something now and did not at the start.
      if (start == unknown_gap) start = std::max(0.0, c.gap - change / 2);
      if (strikes) start = std::max(0.0, start);
      c.gap = start + change;
      if (works_exactly()) c.start_gap = start;
    }
    visitor(c);
  };
  form_->visit(place_of_gradients(u), Derivatives::first, complete, {});
}

} // namespace impact
