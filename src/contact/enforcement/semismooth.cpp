#include <algorithm>
#include <array>
#include <cmath>
#include <impact/contact/constraints.hpp>
#include <impact/contact/friction.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <tuple>

namespace impact {

namespace {

// The linear solves weigh g = 0 by this multiple of the penalty: what they leave of a gap falls by about a
// thousandth per iteration.
constexpr double newton_weight = 1000;
// Active constraints are those with lambda > c g, c this multiple of the penalty. Without curvature any c
// does; a small one keeps a pressed constraint whose gap is not zero yet for curvature alone.
constexpr double activity_weight = 1e-3;
// The method has converged when its active gaps are less than this part of a facet.
constexpr double newton_gap = 1e-11;
// Steps of a solve that may change the set at will.
constexpr int most_free = 8;

// Semismooth Newton method, or primal-dual active set (S. Hueber, G. Stadler, B. Wohlmuth, SIAM J. Sci.
// Comput. 30 (2008)): p = lambda where lambda - c g > 0 (active), else 0. The linear solves make the active
// gaps vanish, with the weight gamma, and multipliers follow every iterate,
//   lambda <- lambda - gamma (g + dg.du)   (77'')
// The converged state does not know c and gamma. Of bodies that bend, whose stiffness is no M-matrix, sets
// may follow each other for ever, or without order for a hundred steps. In a solve that has changed them for
// some steps none therefore joins while any leaves: what pulls is let go at once until all that is left
// presses, then all that overlaps joins, as in blocks of the non-negative least squares of C. L. Lawson and
// R. J. Hanson (Solving Least Squares Problems (1974), ch. 23).
class Semismooth : public EnforcementMethod {
public:
  using EnforcementMethod::EnforcementMethod;

  double slip_weight() const override { return activity_weight * eps(); }

  bool presses(int index, double gap) const override {
    return (!waits_ || member_[at(index)] > 0) && rows_.lambda(index) - slip_weight() * gap > 0;
  }

  void press(Constraint& c) const override {
    c.lambda = rows_.lambda(c.index);
    c.active = presses(c.index, c.gap);
    c.pressure = c.active ? c.lambda : 0;
  }

  double stiffness(const Constraint& c) const override {
    return newton_weight * eps() * (1 / (c.cover * c.cover));
  }

  double potential(const Constraint&) const override { return 0; } // g = 0 stores nothing

  // Newton's method on |q| t = mu p q, q = t + c s, with t = mu p q/|q| in its matrix (Hueber, Stadler and
  // Wohlmuth 2008): the new t = mu p m + k (1 - m m)(s + ds), m = q/|q|, k = c mu p/(|q| - mu p), which at
  // the solution is mu p/|s| (82''). Where sliding sets in it acts as if it stuck.
  double turn_stiffness(const Constraint& c, const Traction& t) const override {
    const double limit = std::hypot(t.value[0], t.value[1]), weight = slip_weight(), stick = stiffness(c);
    return t.excess * stick > weight * limit ? weight * limit / t.excess : stick;
  }

  bool has_multipliers() const override { return true; }
  bool closes_gaps() const override { return true; }

  std::unique_ptr<EnforcementMethod> fallback() const override { return make_augmented(*settings_, rows_); }

  void begin_attempt(const Constraints&, const Friction&) override { waits_ = false; }

  // Surfaces that touch without a pressure so far: the first iterate must not pass through them, or has no
  // solution where nothing else holds a body.
  void start_newton(const Constraints& constraints, Vec u) override {
    waits_ = false;
    changes_ = 0;
    const double touch = 1e-8 * constraints.mean_length(), token = touch * eps();
    std::vector<double> lambda = rows_.multiplier->trial;
    constraints.visit(u, Derivatives::none, [&](const Constraint& c) {
      if (!(c.lambda > 0)) lambda[at(c.index)] = std::abs(c.gap) < touch ? token : 0.0;
    });
    constraints.share(lambda, 1);
    rows_.multiplier->trial = std::move(lambda);
  }

  SetChange after_newton_step(const Constraints& constraints, Friction& friction, Vec u, Vec du,
                              Vec next) override {
    const std::vector<double> d = constraints.nodes().exchange.gather(du);
    const std::size_t m = constraints.dim(), tangents = constraints.tangents();
    std::vector<double> lambda(constraints.count(), 0.0), held(tangents * lambda.size(), 0.0);
    std::vector<char> active(lambda.size(), 0); // 1: sticks or has no friction; 2: slides
    const auto kind = [&](const Constraint& c) {
      return static_cast<char>(friction.traction(c).slides ? 2 : 1);
    };
    constraints.visit(u, Derivatives::tangent, [&](const Constraint& c) {
      if (!c.active) return;
      const std::size_t n = c.gradient.size();
      const std::span<const double> gap_gradient = c.gap_gradient();
      double gap = c.gap;
      Tangential slip = c.slip;
      for (std::size_t i = 0; i < n; ++i) {
        const double change = d[constraints.dof(c.node[i / m], i % m)];
        gap += gap_gradient[i] * change;
        if (c.slides)
          for (std::size_t a = 0; a < tangents; ++a) slip[a] += c.slip_gradient[n * a + i] * change;
      }
      lambda[at(c.index)] = c.lambda - stiffness(c) * gap;
      active[at(c.index)] = kind(c);
      if (!friction.rubs(c)) return;
      const Tangential t = friction.after_linear_solve(c, lambda[at(c.index)], slip);
      std::copy_n(t.begin(), tangents, &held[tangents * at(c.index)]);
    });
    constraints.share(lambda, 1);
    rows_.multiplier->trial = std::move(lambda);
    if (friction.acts()) constraints.share(held, tangents);
    friction.keep_tractions(held);
    waits_ = false;
    std::vector<char> then(active.size(), 0);
    constraints.visit(next, Derivatives::none, [&](const Constraint& c) {
      if (c.active) then[at(c.index)] = kind(c);
    });
    return change_set(constraints, active, then);
  }

  GapsLeft gaps_left(const Constraints& constraints, const Friction& friction, Vec u,
                     double force) const override {
    if (waits_) return {false, 1};
    const std::vector<double> values = constraints.nodes().displacement(u);
    double gap = 0, force_of_gap = 0, coordinate = 0; // gap or slip that must vanish; what closing one takes
    constraints.visit(values, Derivatives::none, [&](const Constraint& c) {
      if (!c.active) return;
      double open = std::abs(c.gap), force_of_turn = 0;
      if (friction.rubs(c)) {
        const Traction t = friction.traction(c);
        const Tangential& s = c.slip;
        if (!t.slides) open = std::max(open, std::hypot(s[0], s[1]));
        // Slip across the traction: it must turn until there is none.
        if (t.slides && constraints.dim() == 3) {
          const double across = std::abs(t.direction[0] * s[1] - t.direction[1] * s[0]);
          force_of_turn = c.weight * turn_stiffness(c, t) * across;
          gap = std::max(gap, across);
        }
      }
      gap = std::max(gap, open);
      force_of_gap = std::max({force_of_gap, c.weight * eps() * open, force_of_turn});
    });
    for (double x : constraints.nodes().current(values)) coordinate = std::max(coordinate, std::abs(x));
    std::array<double, 3> largest = {gap, force_of_gap, coordinate};
    max_over_ranks(constraints.comm(), largest);
    const bool rounding = largest[0] <= 1e-14 * largest[2];
    return {rounding || (largest[0] <= newton_gap * constraints.mean_length() && largest[1] <= force),
            largest[0] / constraints.mean_length()};
  }

  bool converged(const AugmentReport& report, const Constraints& constraints, const Friction& friction,
                 Vec u) const override {
    return report.settled &&
           gaps_left(constraints, friction, u, std::numeric_limits<double>::infinity()).open <= most_open;
  }

  void augment(const AugmentReport&, std::vector<double>& lambda) override {
    rows_.multiplier->trial = std::move(lambda);
  }

private:
  SetChange change_set(const Constraints& constraints, const std::vector<char>& from,
                       const std::vector<char>& to) {
    int others = 0, active = 0, leave = 0, join = 0;
    for (std::size_t i = 0; i < to.size(); ++i) {
      const bool was = from[i] != 0, is = to[i] != 0;
      others += from[i] != to[i] ? 1 : 0;
      active += is ? 1 : 0;
      leave += was && !is ? 1 : 0;
      join += is && !was ? 1 : 0;
    }
    std::array<int, 4> sums = {others, active, leave, join};
    sum_over_ranks(constraints.comm(), sums);
    std::tie(others, active, leave, join) = std::tuple_cat(sums);
    if (others > 0) ++changes_;
    waits_ = changes_ > most_free && leave > 0 && join > 0;
    if (!waits_) return {others > 0, active};
    member_.assign(from.begin(), from.end());
    constraints.share(member_, 1);
    return {true, active - join};
  }

  bool waits_ = false;         // what has come to overlap, for what still pulls to leave
  std::vector<double> member_; // [constraint] > 0: of the set that does not wait
  int changes_ = 0;            // steps of the solve after which the set was another
};

} // namespace

std::unique_ptr<EnforcementMethod> make_semismooth(const ContactSettings& settings,
                                                   const EnforcementRows& rows) {
  return std::make_unique<Semismooth>(settings, rows);
}

} // namespace impact
