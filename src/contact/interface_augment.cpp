#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/entries.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <utility>

/// Augmentation of a ContactInterface, and its totals after an accepted step.
namespace impact {

namespace {

// Largest component of sums at the nodes, [node][dim] of the contact's nodes. Collective.
double largest_of(const std::vector<double>& nodal, const ContactNodes& nodes, const FieldLayout& layout) {
  const Handle<Vec> sum = layout.make_global();
  check(VecSet(sum, 0));
  nodes.exchange.add(nodal, sum);
  double largest = 0;
  check(VecNorm(sum, NORM_INFINITY, &largest));
  return largest;
}

// What an augmentation sees at its worst.
struct Largest {
  double penetration = 0, unsettled = 0, multiplier = 0, weight = 0, gap = 0, change = 0;

  void see(const Constraint& c, double eps, double deepest) {
    penetration = std::max(penetration, -c.gap);
    weight = std::max(weight, c.weight);
    multiplier = std::max(multiplier, c.cover * c.pressure);
    if (!c.active) return;
    // An opening point fades out with its pressure: its gap would count or not by the last digit of p.
    gap = std::max(gap, std::min(std::abs(c.gap), c.pressure / eps));
    if (c.gap < deepest) unsettled = 1;
  }
  // What presses on a constraint acts on the part of its weight that faces something, `cover`; values of
  // constraints [constraint][component].
  void note(const std::vector<double>& now, const std::vector<double>& before,
            const std::vector<double>& cover) {
    for (std::size_t i = 0; i < now.size(); ++i)
      change = std::max(change, cover[i * cover.size() / now.size()] * std::abs(now[i] - before[i]));
  }
  AugmentReport over_ranks(int active, MPI_Comm comm) {
    MPI_Allreduce(MPI_IN_PLACE, this, sizeof *this / sizeof(double), MPI_DOUBLE, MPI_MAX, comm);
    active = sum_over_ranks(comm, active);
    return {.penetration = penetration,
            .largest_gap = gap,
            .multiplier = multiplier,
            .active = active,
            .settled = unsettled == 0};
  }
};

} // namespace

void ContactInterface::start_augmentation() {
  rows_.penalty->trial[EnforcementRows::last_gap] = 0;
  last_change_ = HUGE_VAL;
}

AugmentReport ContactInterface::propose(Vec u, std::vector<double>& lambda,
                                        std::vector<double>& traction) const {
  std::vector<double> multiplier = rows_.multiplier->trial;
  multiplier.resize(constraints_->count()); // facets that came free inside a body have none
  const std::size_t m = constraints_->dim(), tangents = friction_.acts() ? constraints_->tangents() : 0;
  const double penalty = method().eps(), deepest = search().deepest();
  // A constraint that faces nothing carries nothing.
  lambda.assign(multiplier.size(), 0.0);
  traction.assign(tangents * lambda.size(), 0.0);
  const std::vector<double> values = nodes().displacement(u);
  // What the pressures do to the bodies, and what their change does.
  std::vector<double> force(values.size(), 0.0), change(force), cover = constraints_->owned();
  Largest largest;
  int active = 0;
  const bool by_force = at_rest_ && method().augments();
  const auto visitor = [&](const Constraint& c) {
    if (c.active) ++active;
    largest.see(c, penalty, deepest);
    const double p = std::max(0.0, c.pressure), before = multiplier[at(c.index)];
    lambda[at(c.index)] = p;
    cover[at(c.index)] = c.cover;
    const std::size_t n = c.gradient.size();
    const auto act = [&](double now, double then, std::span<const double> gradient) {
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t row = constraints_->dof(c.node[i / m], i % m);
        if (constraints_->fixed(row)) continue;
        force[row] += c.weight * now * gradient[i];
        change[row] += c.weight * (now - then) * gradient[i];
      }
    };
    if (p != 0 || before != 0) act(p, before, c.gradient);
    const Tangential t = friction_.traction_to_keep(c);
    for (std::size_t a = 0; a < tangents; ++a) {
      const std::size_t i = tangents * at(c.index) + a;
      traction[i] = t[a];
      if (c.slides) act(-t[a], -friction_.tractions()[i], c.slip_gradient.subspan(n * a, n));
    }
  };
  constraints_->visit(values, by_force ? Derivatives::first : Derivatives::none, visitor);
  constraints_->share(lambda, 1);
  if (friction_.acts()) constraints_->share(traction, tangents);
  if (constraints_->form().switched()) largest.unsettled = 1;
  largest.note(lambda, multiplier, cover);
  if (friction_.acts()) largest.note(traction, friction_.tractions(), cover);
  AugmentReport report = largest.over_ranks(active, mesh_->comm());
  // Multipliers of rounding size (touch exactly at a step) never settle relative to each other.
  const double negligible = 1e-9 * penalty * settings_.search_radius;
  const auto relative = [](double part, double of) { return part > 0 ? part / of : 0; };
  report.change = report.force_change = relative(largest.change, std::max(report.multiplier, negligible));
  // Constraints that are more than the surfaces can meet share a force in many ways, and go on changing. With
  // inertia every change left is energy.
  if (by_force && report.change > last_change_ / 2 && report.penetration < settings_.gap_tol / 10)
    report.force_change =
        relative(largest_of(change, nodes(), *layout_),
                 std::max(largest_of(force, nodes(), *layout_), negligible * largest.weight));
  report.penalty = penalty;
  report.converged = method().converged(report, *constraints_, friction_, u);
  return report;
}

AugmentReport ContactInterface::review(Vec u) const {
  std::vector<double> lambda, traction;
  return propose(u, lambda, traction);
}

AugmentReport ContactInterface::augment(Vec u) {
  std::vector<double> lambda, traction;
  const AugmentReport report = propose(u, lambda, traction);
  constraints_->form().clear_switched(); // another solve follows
  if (!method().has_multipliers()) return report;
  friction_.keep_tractions(traction);
  method().augment(report, lambda);
  if (method().augments()) last_change_ = report.change;
  if (eased_ && method().eps() >= settings_.penalty) {
    eased_ = false;
    use_method();
  }
  return report;
}

void ContactInterface::carry_force() {
  carried_->committed = carried_->trial = force_->committed;
  for (std::vector<double>* half : {&totals_->committed, &totals_->trial})
    std::copy_n(totals(*half).force, constraints_->dim(), totals(*half).carried);
}

// All of them where multipliers hold energy that press no more, or gaps are followed.
ConstraintFilter ContactInterface::ending() const {
  if ((method().has_multipliers() && !by_impulse()) || constraints_->conserving()) return {};
  return [presses = constraints_->pressing(), acts = friction_.acting()](int index, double gap) {
    return presses(index, gap) || acts(index, gap);
  };
}

// The dofs of its nodes, on whatever rank those stand, and those that hold forces of earlier steps.
void ContactInterface::find_reached() {
  if (reached_after_ == searches_) return;
  reached_after_ = searches_;
  reached_.clear();
  if (!pushed_) pushed_ = layout_->make_global();
  nodes().exchange.add(std::vector<double>(nodes().X.size(), 1.0), pushed_);
  WritableEntries of_nodes(pushed_);
  layout_->for_each_owned([&](PetscInt place, std::size_t local) {
    if (std::exchange(of_nodes[place], 0.0) != 0 || force_->committed[local] != 0 ||
        carried_->committed[local] != 0)
      reached_.push_back({place, local});
  });
  for (StateRow* row : {force_, carried_}) row->trial = row->committed; // 0 elsewhere
}

void ContactInterface::end_step(Vec u_n, Vec u, Vec force, StiffnessBound* bound, Tally& tally) {
  end_.emplace();
  friction_.begin_end();
  find_reached();
  std::vector<double> stiff(bound ? nodes().global.size() : 0, 0.0); // at all dofs of a node
  end_->force = add_residual(u, 1, pushed_, ending(), [&](const Constraint& c) {
    add_step(c, *end_);
    friction_.note_end(c);
    if (!bound || !c.active) return;
    add_stiffness_bound(c, stiff, *bound);
    bound->deepest = std::max(bound->deepest, (-c.gap - c.kept) / constraints_->form().sight(c.index));
  });
  if (bound) {
    std::vector<double> of_dofs(nodes().X.size());
    for (std::size_t i = 0; i < of_dofs.size(); ++i) of_dofs[i] = stiff[i / constraints_->dim()];
    nodes().exchange.add(of_dofs, bound->of_nodes);
  }
  const Entries before(u_n), now(u);
  WritableEntries f(pushed_);
  std::optional<WritableEntries> sum;
  if (force) sum.emplace(force);
  for (const auto& [place, local] : reached_) {
    const double at_end = std::exchange(f[place], 0.0), at_start = force_->committed[local];
    force_->trial[local] = at_end;
    end_->force_times_way += (at_end + (stabilised() ? at_end : at_start)) * (now[place] - before[place]);
    if (sum) (*sum)[place] -= at_end;
  }
  tally.sum(end_->numbers());
}

void ContactInterface::advance(Vec u_n, Vec u, double dt) {
  if (eased_) rows_.penalty->trial[EnforcementRows::value] = settings_.penalty; // nothing was touched
  if (!end_) {
    Tally tally(mesh_->comm());
    end_step(u_n, u, nullptr, nullptr, tally);
    tally.reduce();
  }
  const ContactSums sum = *end_;
  end_.reset();
  const Vector force = of_the_end(sum.force);
  const Totals before = totals(totals_->committed), now = totals(totals_->trial);
  for (std::size_t k = 0; k < constraints_->dim(); ++k) {
    const double Y_n = before.carried[k],
                 mean = stabilised() ? share_.impulse(force[k], Y_n) : (before.force[k] + force[k]) / 2;
    now.impulse[k] = before.impulse[k] + dt * (mean + shock_[k]);
    now.force[k] = force[k];
    if (!at_rest_) now.carried[k] = share_.carried(force[k], Y_n);
  }
  if (!at_rest_)
    for (const ReachedDof& dof : reached_)
      carried_->trial[dof.local] = share_.carried(force_->trial[dof.local], carried_->committed[dof.local]);
  *now.work = *before.work - sum.force_times_way / 2;
  const Vector obstacle = rigid_displacement(settings_, mesh_->dim(), time_);
  std::copy(obstacle.begin(), obstacle.end(), now.obstacle);
  if (constraints_->conserving()) *now.spring = sum.spring;
  if (friction_.acts()) *now.heat = *before.heat + sum.heat;
  friction_.advance(*constraints_);
  if (constraints_->conserving()) constraints_->keep_gaps(u);
  constraints_->end();
  if (friction_.acts()) constraints_->form().anchor(u);
}

} // namespace impact
