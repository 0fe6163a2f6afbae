#include "stored_input.hpp"

#include <algorithm>
#include <cmath>
#include <impact/balance/energies.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>

namespace impact {

namespace {

// The order of the sums is part of their values: cell by cell, then over ranks.
void add(const EnergySums& sums, const CellBatch& batch, MaterialEnergies& to) {
  const int used = batch.used();
  to.kinetic += batch.massive_sum(sums.kinetic);
  to.elastic += batch.live_sum(sums.elastic);
  to.plastic += batch.live_sum(sums.plastic);
  to.fracture += lane_sum(sums.fracture, used);
  to.fatigue += lane_sum(sums.fatigue, used);
  for (int k = 0; k < 3; ++k) to.momentum[k] += batch.massive_sum(sums.momentum[k]);
  for (int k = 0; k < 3; ++k) to.spin[k] += batch.massive_sum(sums.spin[k]);
}

void find_peaks(const Discretisation& d, const BodyRows& rows, bool trial, Energies& energies) {
  double most[6] = {0, 0, 0, 0, 0, -HUGE_VAL};
  const auto largest = [&](const StateRow* row, double& peak) {
    if (const std::vector<double>* values = half_of(row, trial))
      for (const double value : *values) peak = std::max(peak, value);
  };
  largest(rows.phi, most[0]);
  largest(rows.theta, most[2]);
  largest(rows.fatigue, most[3]);
  largest(rows.failure, most[4]);
  if (const std::vector<double>* theta = half_of(rows.theta, trial))
    for (const double value : *theta) most[5] = std::max(most[5], -value);
  const std::vector<double>& history = trial ? rows.history.trial : rows.history.committed;
  most[1] = largest_alpha(d.frame, history);
  max_over_ranks(d.mesh.comm(), most);
  energies.phi_max = most[0];
  energies.alpha_max = most[1];
  energies.theta_max = most[2];
  energies.fatigue_max = most[3];
  energies.failure_max = most[4];
  energies.theta_min = -most[5];
}

} // namespace

BodyRows::BodyRows(StateTable& state)
    : history(state.row("history")), drive(state.find("drive") ? &state.row("drive") : nullptr),
      phi(state.find("phi")), theta(state.find("theta")), fatigue(state.find("fatigue")),
      toughness(state.find("toughness")), failure(state.find("jc_failure")) {}

Energies find_energies(const Discretisation& d, const BodyRows& rows, Vec u, Vec v, bool trial) {
  std::vector<double> u_local = d.displacement.make_local(), v_local = u_local;
  d.displacement.to_local(u, u_local);
  if (v) d.displacement.to_local(v, v_local);
  Energies energies;
  energies.of.resize(d.materials.size());
  PatchState patches;
  share_volumes(d, {&u_local}, patches);
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    MaterialEnergies& mine = energies.of[batch.material()];
    StoredInput stored(batch, rows, d.mesh.coordinates(), u_local, patches.J_minus_1, trial);
    const auto speed = batch.vectors(v_local);
    EnergyInput& in = stored.in;
    in.v = v ? speed.data() : nullptr;
    NodalValues moved = batch.nodal(d.dim()); // of mass that cells left at their nodes
    if (batch.eroded != 0) in.moved = batch.read(&u_local, moved);
    in.lumped = d.lumped_mass && !batch.law.rigid();
    in.lumped_capacity = d.lumped_capacity;
    if (d.mass_factor != nullptr) in.mass_factor = batch.load<1>(*d.mass_factor).value[0];
    EnergySums sums;
    batch.kernels.stored_energy(batch.law, in, sums);
    batch.add_toughness(half_of(rows.fatigue, trial), half_of(rows.toughness, trial), sums);
    add(sums, batch, mine);
    if (!rows.theta) return;
    HeatSums heat;
    batch.kernels.stored_heat(batch.law, in, heat);
    mine.thermal += batch.sum(heat.energy);
    mine.entropy += batch.sum(heat.entropy);
  });
  constexpr std::size_t numbers = sizeof(MaterialEnergies) / sizeof(double), without_momenta = numbers - 6;
  const std::span<double> all(&energies.of.data()->kinetic, numbers * energies.of.size());
  sum_over_ranks(d.mesh.comm(), all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] *= d.thickness;
    if (i % numbers < without_momenta) (&energies.total.kinetic)[i % numbers] += all[i];
  }
  find_peaks(d, rows, trial, energies);
  return energies;
}

DamageLosses find_damage_losses(const Discretisation& d, const BodyRows& rows, const StepRecord& step) {
  DamageLosses losses;
  for (std::vector<double>* of : {&losses.by_rate, &losses.by_exchange}) of->resize(d.materials.size());
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates());
    const auto by_damage = batch.load<1>(step.damage_dissipation);
    auto all = by_damage;
    losses.by_rate[batch.material()] += batch.sum(batch.kernels.cell_integral(X.data(), by_damage.data()));
    if (batch.law.exchanges()) {
      batch.load(step.dissipation, all);
      const auto now = batch.scalars(rows.phi->trial), before = batch.scalars(rows.phi->committed);
      const auto driving = batch.load<drive_size>(rows.drive->trial);
      auto flowed = batch.histories(), flowed_n = batch.histories();
      auto exchanged = batch.points<1>();
      batch.load(rows.history.trial, flowed);
      batch.load(rows.history.committed, flowed_n);
      batch.kernels.plastic_exchange(batch.law,
                                     {.phi = now.data(),
                                      .phi_n = before.data(),
                                      .history = flowed.data(),
                                      .history_n = flowed_n.data(),
                                      .drive = driving.data()},
                                     exchanged.data());
      losses.by_exchange[batch.material()] +=
          batch.sum(batch.kernels.cell_integral(X.data(), exchanged.data()));
      for (int q = 0; q < all.size; ++q) all.value[q] += exchanged.value[q];
    }
    for (const Batch& at_point : all.all())
      for (int l = 0; l < batch.used(); ++l) losses.most_gained = std::max(losses.most_gained, -at_point[l]);
  });
  return losses;
}

double find_unilateral_energy(const Discretisation& d, const BodyRows& rows, std::span<const double> phi,
                              const std::vector<double>& drive_n) {
  double sum = 0;
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), seen = batch.scalars(phi);
    const auto after = batch.load<drive_size>(rows.drive->trial), before = batch.load<drive_size>(drive_n);
    auto flowed = batch.histories();
    batch.load(rows.history.committed, flowed);
    Batch part = 0;
    batch.kernels.unilateral_energy(batch.law, X.data(), seen.data(), flowed.data(), after.data(),
                                    before.data(), part);
    sum += batch.sum(part);
  });
  return sum_over_ranks(d.mesh.comm(), sum);
}

} // namespace impact
