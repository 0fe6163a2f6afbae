#include <algorithm>
#include <impact/kernel/fatigue.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/fatigue.hpp>
#include <optional>

namespace impact {

FatigueUpdate::FatigueUpdate(const Discretisation& discretisation, StateTable& state)
    : d_(discretisation), state_(state), X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()),
      dissipated_(d_.materials.size(), 0.0), offset_(point_offsets(d_.groups, 1)),
      history_offset_(point_offsets(d_.groups, history_size(d_.frame))) {}

bool FatigueUpdate::advance(const FatigueStep& step) {
  StateRow& fatigue = state_.row("fatigue");
  const StateRow& history = state_.row("history");
  std::fill(dissipated_.begin(), dissipated_.end(), 0.0);
  least_ = 0;
  bool sound = true;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    const PointLaw& law = d_.law(group);
    if (!law.fatigues()) continue;
    const int dim = d_.dim();
    const bool expands = step.theta != nullptr && law.parameters.alpha_t != 0;
    for (int b = 0; b < group.batch_count; ++b) {
      const Gathered X(group, b, X_, dim), u(group, b, *step.u, dim), u_n(group, b, *step.u_n, dim);
      const Gathered phi(group, b, *step.phi, 1);
      std::optional<Gathered> theta, theta_n;
      PointValues<max_history_size> now(group, history_size(d_.frame)), before = now;
      PointValues<1> grown(group), old(group);
      old.load(fatigue.committed, offset_[g], b);
      FatigueInput in;
      in.X = X.data();
      in.u = u.data();
      in.u_n = u_n.data();
      in.phi = phi.data();
      if (expands) {
        in.theta = theta.emplace(group, b, *step.theta, 1).data();
        in.theta_n = theta_n.emplace(group, b, *step.theta_n, 1).data();
      }
      if (law.flows() || d_.frame == Frame::plane_stress) {
        now.load(history.trial, history_offset_[g], b);
        before.load(history.committed, history_offset_[g], b);
        in.history = now.data();
        in.history_n = before.data();
      }
      in.fatigue_n = old.data();
      in.dt = step.dt;
      FatigueSums sums;
      const int used = group.lanes_in_use(b);
      const int bad = group.shape.kernels(d_.frame).fatigue_advance(law, in, grown.data(), sums);
      sound = sound && is_sound(bad, used);
      grown.store(fatigue.trial, offset_[g], b);
      dissipated_[static_cast<std::size_t>(group.material)] += lane_sum(sums.dissipation, used);
      for (int l = 0; l < used; ++l) least_ = std::min(least_, sums.least[l]);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, dissipated_.data(), static_cast<int>(dissipated_.size()), MPI_DOUBLE, MPI_SUM,
                d_.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &least_, 1, MPI_DOUBLE, MPI_MIN, d_.mesh.comm());
  return all_ranks_agree(d_.mesh.comm(), sound);
}

} // namespace impact
