#include "damage_batches.hpp"
#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/fatigue.hpp>

namespace impact {

namespace {

// Mean over each cell of the energy that drives damage, as degraded as it is stored.
Batch driving_energy(const CellBatch& batch, const NodalValues& X, const NodalValues& phi,
                     const std::vector<double>& drive) {
  const MaterialParameters& m = batch.law.parameters;
  const auto driving = batch.load<drive_size>(drive);
  auto energy = batch.points<1>();
  for (int q = 0; q < energy.size; ++q) {
    Batch damage = 0;
    for (int a = 0; a < phi.size; ++a) damage += batch.group.shape->N[q * phi.size + a] * phi.value[a];
    const Degradations<Batch> g = degradations(m, damage, Batch(0.0));
    const Drive& of_point = drive_at(driving.data(), q);
    energy.value[q] = g.e1.g * of_point.plus;
    if (const double share = compressed_share(m); share != 0)
      energy.value[q] = max(Batch(energy.value[q] + share * (g.e1.g * of_point.minus)), Batch(0.0));
  }
  return batch.mean(X, energy);
}

// The toughness of the cells of one batch (F2), and what its fall at the phi of the end dissipates (F3).
void lower_toughness(const CellBatch& batch, StateTable& state, const FatigueStep& step,
                     FatigueGrowth& growth) {
  StateRow &fatigue = state.row("fatigue"), &drive = state.row("drive");
  const auto X = batch.vectors(batch.d.mesh.coordinates());
  const auto phi = batch.scalars(*step.phi), phi_n = batch.scalars(*step.phi_n);
  auto values = batch.load<1>(fatigue.committed);
  Batch grown = batch.tiring().growth(driving_energy(batch, X, phi_n, drive.committed),
                                      driving_energy(batch, X, phi, drive.trial));
  for (int l = 0; l < lanes; ++l)
    if (!batch.live(l)) grown.set(l, 0);
  if (batch.broken(bits(~is_finite(grown))) != 0) growth.sound = false;
  for (Batch& value : values.all()) value += grown;
  batch.store(values, fatigue.trial);
  const Batch lost =
      (batch.toughness(&fatigue.committed, nullptr) - batch.toughness(&fatigue.trial, nullptr)) *
      crack_energy_of(batch, *step.u, *step.phi, state.row("history"));
  growth.dissipated[batch.material()] += batch.sum(lost);
  if (step.dissipation == nullptr) return;
  auto ones = batch.points<1>(), heating = batch.load<1>(*step.dissipation);
  std::ranges::fill(ones.all(), Batch(1.0));
  const Batch volume = batch.kernels.cell_integral(X.data(), ones.data());
  for (Batch& value : heating.all()) value += lost / volume;
  batch.store(heating, *step.dissipation);
}

} // namespace

FatigueGrowth grow_fatigue(const Discretisation& d, StateTable& state, const FatigueStep& step) {
  StateRow &fatigue = state.row("fatigue"), &history = state.row("history");
  FatigueGrowth growth{.dissipated = std::vector<double>(d.materials.size(), 0.0)};
  PatchState patches, patches_n;
  share_volumes(d, {step.u}, patches);
  share_volumes(d, {step.u_n}, patches_n);
  for_each_batch(d, fatigues, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    const auto X = batch.vectors(d.mesh.coordinates()), u = batch.displaced(*step.u),
               u_n = batch.displaced(*step.u_n), phi = batch.scalars(*step.phi);
    const bool expands = law.parameters.alpha_t != 0, flows = law.flows() || d.frame == Frame::plane_stress;
    NodalValues theta = batch.nodal(1), theta_n = batch.nodal(1);
    auto now = batch.histories(), before = batch.histories();
    auto grown = batch.points<1>(), old = batch.load<1>(fatigue.committed);
    FatigueInput in;
    in.X = X.data();
    in.u = u.data();
    in.u_n = u_n.data();
    in.phi = phi.data();
    in.theta = batch.read(expands ? step.theta : nullptr, theta);
    in.theta_n = batch.read(expands ? step.theta_n : nullptr, theta_n);
    in.history = batch.read(flows ? &history.trial : nullptr, now);
    in.history_n = batch.read(flows ? &history.committed : nullptr, before);
    BatchArray<1> patch(1), patch_n(1);
    in.patch = batch.read_shared(patches.J_minus_1, patch);
    in.patch_n = batch.read_shared(patches_n.J_minus_1, patch_n);
    in.fatigue_n = old.data();
    in.dt = step.dt;
    FatigueSums sums;
    if (batch.broken(batch.kernels.fatigue_advance(law, in, grown.data(), sums)) != 0) growth.sound = false;
    batch.store(grown, fatigue.trial);
    growth.dissipated[batch.material()] += batch.sum(sums.dissipation);
    for (int l = 0; l < batch.used(); ++l) growth.least = std::min(growth.least, sums.least[l]);
  });
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    if (batch.tiring().works()) lower_toughness(batch, state, step, growth);
  });
  sum_over_ranks(d.mesh.comm(), growth.dissipated);
  growth.least = min_over_ranks(d.mesh.comm(), growth.least);
  growth.sound = all_ranks_agree(d.mesh.comm(), growth.sound);
  return growth;
}

} // namespace impact
