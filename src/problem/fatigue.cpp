#include <algorithm>
#include <impact/kernel/fatigue.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/fatigue.hpp>

namespace impact {

FatigueUpdate::FatigueUpdate(const Discretisation& discretisation, StateTable& state)
    : d_(discretisation), fatigue_(state.row("fatigue")), history_(state.row("history")),
      dissipated_(d_.materials.size(), 0.0) {}

bool FatigueUpdate::advance(const FatigueStep& step) {
  std::fill(dissipated_.begin(), dissipated_.end(), 0.0);
  least_ = 0;
  bool sound = true;
  const auto fatigues = [](const PointLaw& law) { return law.fatigues(); };
  for_each_batch(d_, fatigues, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    const auto X = batch.vectors(d_.mesh.coordinates()), u = batch.vectors(*step.u),
               u_n = batch.vectors(*step.u_n);
    const auto phi = batch.scalars(*step.phi);
    std::optional<NodalValues> theta, theta_n;
    auto now = batch.histories(), before = batch.histories();
    auto grown = batch.points<1>(), old = batch.load<1>(fatigue_.committed);
    FatigueInput in;
    in.X = X.data();
    in.u = u.data();
    in.u_n = u_n.data();
    in.phi = phi.data();
    if (step.theta != nullptr && law.parameters.alpha_t != 0) {
      theta = batch.scalars(*step.theta);
      theta_n = batch.scalars(*step.theta_n);
      in.theta = theta->data();
      in.theta_n = theta_n->data();
    }
    if (law.flows() || d_.frame == Frame::plane_stress) {
      batch.load(history_.trial, now);
      batch.load(history_.committed, before);
      in.history = now.data();
      in.history_n = before.data();
    }
    in.fatigue_n = old.data();
    in.dt = step.dt;
    FatigueSums sums;
    sound = batch.broken(batch.kernels.fatigue_advance(law, in, grown.data(), sums)) == 0 && sound;
    batch.store(grown, fatigue_.trial);
    dissipated_[batch.material()] += batch.sum(sums.dissipation);
    for (int l = 0; l < batch.used(); ++l) least_ = std::min(least_, sums.least[l]);
  });
  sum_over_ranks(d_.mesh.comm(), dissipated_);
  least_ = min_over_ranks(d_.mesh.comm(), least_);
  return all_ranks_agree(d_.mesh.comm(), sound);
}

} // namespace impact
