#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/entries.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

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

void ContactInterface::end_step(Vec u_n, Vec u, Vec f, StiffnessBound* bound, Tally& tally) {
  end_.emplace();
  friction_.begin_end();
  std::vector<double> stiff(bound ? constraints_->dim() * nodes().global.size() : 0, 0.0);
  check(VecSet(f, 0));
  end_->force = add_residual(u, 1, f, ending(), [&](const Constraint& c) {
    add_step(c, *end_);
    friction_.note_end(c);
    if (!bound || !c.active) return;
    add_stiffness_bound(c, stiff, bound->of_bodies);
    bound->deepest = std::max(bound->deepest, (-c.gap - c.kept) / constraints_->form().sight(c.index));
  });
  if (bound) nodes().exchange.add(stiff, bound->of_nodes);
  layout_->owned_to_local(f, force_->trial);
  const ScratchVec mean = layout_->scratch(), du = layout_->scratch();
  check(VecWAXPY(du, -1, u_n, u));
  layout_->to_global(force_->committed, mean);
  check(stabilised() ? VecAXPBY(mean, 2, 0, f) : VecAXPY(mean, 1, f));
  const Entries forces(mean), ways(du);
  PetscInt count = 0;
  check(VecGetLocalSize(du, &count));
  for (PetscInt i = 0; i < count; ++i) end_->force_times_way += forces[i] * ways[i];
  tally.sum(end_->numbers());
}

void ContactInterface::advance(Vec u_n, Vec u, double dt) {
  if (eased_) rows_.penalty->trial[EnforcementRows::value] = settings_.penalty; // nothing was touched
  if (!end_) {
    Tally tally(mesh_->comm());
    end_step(u_n, u, layout_->scratch(), nullptr, tally);
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
  for (std::size_t i = 0; !at_rest_ && i < carried_->trial.size(); ++i)
    carried_->trial[i] = share_.carried(force_->trial[i], carried_->committed[i]);
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
