#include <algorithm>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/fatigue.hpp>

namespace impact {

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
  sum_over_ranks(d.mesh.comm(), growth.dissipated);
  growth.least = min_over_ranks(d.mesh.comm(), growth.least);
  growth.sound = all_ranks_agree(d.mesh.comm(), growth.sound);
  return growth;
}

} // namespace impact
