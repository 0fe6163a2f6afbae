#include "damage_batches.hpp"
#include <algorithm>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>

/// What a solved step of damage dissipated, and the work of the microforces that prescribe phi.
namespace impact {

constexpr double no_rate = std::numeric_limits<double>::infinity(); // as dt

// Nodal forces of the weak form at phi, held nodes included: those of the energy, and with a finite dt those
// of the rate too.
void DamageProblem::microforces(const std::vector<double>& phi, const std::vector<double>& phi_n, double dt,
                                std::vector<double>& force) {
  const Handle<Vec> x = d_.scalar.make_global(), f = d_.scalar.make_global();
  d_.scalar.to_global(phi, x);
  assemble_forces({DamageForm::multiplied, 1, dt, &phi_n}, x, f);
  d_.scalar.to_local(f, force);
}

double DamageProblem::held_work(const std::vector<double>& force, const std::vector<double>& from,
                                const std::vector<double>& to) const {
  double work = 0;
  for (std::size_t i = 0; i < force.size(); ++i)
    if (d_.mesh.owned(static_cast<int>(i))) work += force[i] * (to[i] - from[i]);
  return sum_over_ranks(d_.mesh.comm(), work);
}

void DamageProblem::keep_held(std::vector<double>& force) const {
  for (std::size_t i = 0; i < force.size(); ++i)
    if (boundary_.damage_condition()[i] < 0) force[i] = 0;
}

// The rate's part of a step or sub-step.
void DamageProblem::book_rate(const std::vector<double>& from, const std::vector<double>& to, double dt) {
  const Timed timed(Event::damage_points);
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    const auto now = batch.scalars(to), before = batch.scalars(from);
    auto points = batch.load<1>(dissipated_);
    batch.kernels.damage_dissipation(batch.law, now.data(), before.data(), dt, points.data());
    batch.store(points, dissipated_);
  });
  if (!prescribes_) return;
  std::vector<double> with = d_.scalar.make_local(), without = with;
  microforces(to, from, dt, with);
  microforces(to, from, no_rate, without);
  for (std::size_t i = 0; i < with.size(); ++i) with[i] -= without[i];
  keep_held(with);
  work_ += held_work(with, from, to);
}

// The energy's part of the whole step: the mean of both ends.
void DamageProblem::book_energy(const std::vector<double>& from, const std::vector<double>& to) {
  std::fill(microforce_->trial.begin(), microforce_->trial.end(), 0.0);
  if (prescribes_) {
    microforces(to, *equation_.phi_n, no_rate, microforce_->trial);
    keep_held(microforce_->trial);
  }
  work_ += (held_work(microforce_->committed, from, to) + held_work(microforce_->trial, from, to)) / 2;
}

double DamageProblem::crack_energy(const DamageStep& step, const std::vector<double>& phi) const {
  double energy = 0;
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    energy += batch.sum(crack_energy_of(batch, *step.u, phi, flow_));
  });
  return d_.thickness * sum_over_ranks(d_.mesh.comm(), energy);
}

void DamageProblem::start(const std::vector<double>& u) {
  const std::vector<double>& phi = phi_.committed;
  step_ = {.u = &u, .u_n = &u};
  raise_history();
  std::vector<double>& force = microforce_->trial;
  microforces(phi, phi, no_rate, force);
  // What would grow at once without a rate is let go within the first step; with one it dissipates.
  const bool at_once = std::none_of(d_.materials.begin(), d_.materials.end(), [](const auto& m) {
    return m.law.parameters.damage != Damage::none && std::isfinite(m.law.parameters.c);
  });
  for (std::size_t i = 0; i < force.size(); ++i)
    if (boundary_.damage_condition()[i] < 0)
      force[i] = at_once && !field_.held()[i] ? std::min(force[i], 0.0) : 0;
}

} // namespace impact
