#include <cmath>
#include <impact/problem/heat.hpp>
#include <numbers>

/// What a nodal temperature belongs to, and the heat of points that it does not show (theory.md, 11).
namespace impact {

// After the last residual, which stands at the solution. Not for ever where nothing conducts: heat that
// entered through the surface is no point's own. Sub-steps would tell of the last one alone.
void HeatProblem::keep_warming() {
  constexpr double pi = std::numbers::pi, forgotten = 1e-4;
  const double h = d_.mesh.smallest_edge();
  const auto expands = [](const PointLaw& law) { return law.parameters.alpha_t != 0; };
  for_each_batch(d_, expands, [&](const CellBatch& batch) {
    const double rate = pi * pi * batch.law.parameters.conductivity / (batch.law.parameters.c_v * h * h);
    const bool keeps = step_.points_keep_heat && window_.whole();
    const double kept = keeps ? (1 - forgotten) * std::exp(-rate * (t_ - t_n_)) : 0;
    const auto points = batch.load<heat_point_size>(points_);
    const auto before = batch.load<warming_size>(warming_->committed);
    auto warming = batch.points<warming_size>();
    for (int q = 0; q < points.size / heat_point_size; ++q) {
      const HeatPoint& point = heat_point_at(points.data(), q);
      const Batch heat = kept * (warming_at(before.data(), q).heat - point.excess);
      warming_at(warming.data(), q) = {point.volume, point.warming, -(point.per_heat * heat), heat};
    }
    batch.store(warming, warming_->trial);
  });
}

} // namespace impact
