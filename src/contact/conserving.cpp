#include <algorithm>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/kernel/contact_pair.hpp>

/// The energy-conserving update of contact: a penalty whose force over the step, F = -sum w p dg at the
/// middle of the step, does exactly the work -(psi(g1) - psi(g0)) (T. A. Laursen, V. Chawla, Int. J. Numer.
/// Meth. Engng. 40 (1997)), and likewise its friction. The gaps of closed constraints are accumulated,
/// g1 = g0 + dg.du, because the change of a curved gap is its middle gradient times du only to third order.
/// The trapezoidal rule balances forces at the ends of the step and moves the bodies by the mean of two ends:
/// 2 F - f_n takes the place of the force of the end, so that the mean is F.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

} // namespace

// Between steps: the state at the end of the last one.
void ContactInterface::visit_followed(const std::vector<double>& u, Derivatives derivatives,
                                      const ConstraintVisitor& visitor) const {
  const double eps = penalty();
  form_->visit(u, derivatives, law(), [&](Constraint c) {
    const double followed = gap_->trial[at(c.index)];
    if (followed != unknown_gap) c.gap = followed < 0 ? followed : std::max(0.0, c.gap);
    c.pressure = contact_pressure(0, eps, c.gap);
    c.active = c.pressure > 0;
    visitor(c);
  });
}

StepTraction ContactInterface::step_traction(const Constraint& c) const {
  if (traction_ == nullptr) return {};
  const Tangential before = held(c);
  const double eps = penalty(), mu = settings_.friction;
  if (rubs(c))
    return impact::step_traction(before, c.slip, eps, mu * c.pressure, mu * contact_pressure(0, eps, c.gap));
  // What nothing lies opposite any more lets its spring go.
  StepTraction released;
  released.loss = inner(before, before) / (2 * eps);
  return released;
}

double ContactInterface::contact_stiffness(const Constraint& c) const {
  if (!exact_work()) return law().stiffness(c.cover);
  const double start = step_.start_gap[at(c.index)];
  return -2 * secant_pressure(penalty(), start == unknown_gap ? 0 : start, c.gap).slope;
}

double ContactInterface::spring_energy(double gap, const Tangential& traction) const {
  const double eps = penalty();
  return contact_potential(0, eps, gap) + inner(traction, traction) / (2 * eps);
}

double ContactInterface::spring_energy(Vec u) const {
  double energy = 0;
  visit(form_->nodes().displacement(u), Derivatives::none,
        [&](const Constraint& c) { energy += c.weight * spring_energy(c.gap, traction_to_keep(c)); });
  MPI_Allreduce(MPI_IN_PLACE, &energy, 1, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return energy;
}

double ContactInterface::released_energy(Vec u) const {
  if (!exact_work()) return 0;
  double energy = 0;
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    const double start = step_.start_gap[at(c.index)];
    energy +=
        c.weight * spring_energy(start == unknown_gap ? 0 : start, frictional() ? held(c) : Tangential{});
  });
  MPI_Allreduce(MPI_IN_PLACE, &energy, 1, MPI_DOUBLE, MPI_SUM, mesh_->comm());
  return reported_thickness() * (totals_->committed[at(2 * dim_ + 4)] - energy);
}

void ContactInterface::keep_gaps(Vec u) {
  std::vector<double> gap(gap_->trial.size(), unknown_gap);
  visit(form_->nodes().displacement(u), Derivatives::first,
        [&](const Constraint& c) { gap[at(c.index)] = c.gap; });
  share(gap, 1);
  gap_->trial = std::move(gap);
  step_.rule = StepRule::none;
}

} // namespace impact
