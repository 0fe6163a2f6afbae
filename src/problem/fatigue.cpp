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
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim;
      const bool expands = step.theta != nullptr && law.parameters.alpha_t != 0;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, dim> X(group, b, X_), u(group, b, *step.u), u_n(group, b, *step.u_n);
        const Gathered<Cell, 1> phi(group, b, *step.phi);
        std::optional<Gathered<Cell, 1>> theta, theta_n;
        PointValues<Cell, history_size(frame)> now, before;
        PointValues<Cell, 1> grown, old;
        old.load(fatigue.committed, offset_[g], b);
        FatigueInput in;
        in.X = X.data();
        in.u = u.data();
        in.u_n = u_n.data();
        in.phi = phi.data();
        if (expands) {
          in.theta = theta.emplace(group, b, *step.theta).data();
          in.theta_n = theta_n.emplace(group, b, *step.theta_n).data();
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
        const int bad = fatigue_advance<Cell, frame>(law, in, grown.data(), sums);
        sound = sound && (bad & ((1 << used) - 1)) == 0;
        grown.store(fatigue.trial, offset_[g], b);
        dissipated_[at(group.material)] += lane_sum(sums.dissipation, used);
        for (int l = 0; l < used; ++l) least_ = std::min(least_, sums.least[l]);
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, dissipated_.data(), static_cast<int>(dissipated_.size()), MPI_DOUBLE, MPI_SUM,
                d_.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &least_, 1, MPI_DOUBLE, MPI_MIN, d_.mesh.comm());
  return all_ranks_agree(d_.mesh.comm(), sound);
}

} // namespace impact
