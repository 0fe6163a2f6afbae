#include <algorithm>
#include <impact/kernel/fatigue.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/fatigue.hpp>

namespace impact {

FatigueGrowth grow_fatigue(const Discretisation& d, StateTable& state, const FatigueStep& step) {
  StateRow &fatigue = state.row("fatigue"), &history = state.row("history");
  FatigueGrowth growth{.dissipated = std::vector<double>(d.materials.size(), 0.0)};
  for_each_batch(d, fatigues, [&]<class Cell, Frame frame>(const CellBatch<Cell, frame>& batch) {
    const PointLaw& law = batch.law;
    const auto X = batch.template gather<Cell::dim>(d.mesh.coordinates()),
               u = batch.template gather<Cell::dim>(*step.u),
               u_n = batch.template gather<Cell::dim>(*step.u_n);
    const auto phi = batch.template gather<1>(*step.phi);
    const bool expands = law.parameters.alpha_t != 0, flows = law.flows() || frame == Frame::plane_stress;
    Gathered<Cell, 1> theta, theta_n;
    PointValues<Cell, history_size(frame)> now, before;
    PointValues<Cell, 1> grown, old = batch.template load<1>(fatigue.committed);
    FatigueInput in;
    in.X = X.data();
    in.u = u.data();
    in.u_n = u_n.data();
    in.phi = phi.data();
    in.theta = batch.read(expands ? step.theta : nullptr, theta);
    in.theta_n = batch.read(expands ? step.theta_n : nullptr, theta_n);
    in.history = batch.read(flows ? &history.trial : nullptr, now);
    in.history_n = batch.read(flows ? &history.committed : nullptr, before);
    in.fatigue_n = old.data();
    in.dt = step.dt;
    FatigueSums sums;
    if (batch.broken(fatigue_advance<Cell, frame>(law, in, grown.data(), sums)) != 0) growth.sound = false;
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
