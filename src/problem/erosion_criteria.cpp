#include <impact/problem/erosion.hpp>

/// Which cells fail by the criteria of their materials.
namespace impact {

namespace {

/// Lanes at enough points of which a number has reached its limit.
struct PointCount {
  const ErosionRule& rule;
  int points, of_lane[lanes] = {};

  void add(const Batch& value, double limit) {
    for (int l = 0; l < lanes; ++l) of_lane[l] += value[l] >= limit ? 1 : 0;
  }
  bool reached(int lane) const { return of_lane[lane] > 0 && of_lane[lane] >= rule.points * points; }
};

} // namespace

int Erosion::failed_lanes(const CellBatch& batch, const std::vector<double>& u) const {
  const ErosionRule& rule = d_.materials[batch.material()].erosion;
  const auto X = batch.vectors(d_.mesh.coordinates()), moved = batch.vectors(u), still = batch.zero(d_.dim());
  const bool has_damage = batch.law.parameters.damage != Damage::none;
  auto history = batch.histories();
  batch.load(state_.row("history").trial, history);
  MotionInput in;
  in.X = X.data();
  in.u = moved.data();
  in.history = history.data();
  CellDistortion now;
  batch.kernels.cell_distortion(batch.law, in, now);
  Batch step = 1, first = 1;
  if (rule.step > 0) {
    step = batch.kernels.highest_frequency(batch.law, in, nullptr).longest_step();
    in.u = still.data();
    if (d_.frame == Frame::plane_stress) in.history = nullptr;
    first = batch.kernels.highest_frequency(batch.law, in, nullptr).longest_step();
  }
  const int points = batch.group.shape->points, alpha = symmetric_size(dimension(d_.frame));
  PointCount broken{rule, points}, flown{rule, points}, worn{rule, points};
  if (has_damage) {
    const NodalValues phi = batch.scalars(state_.row("phi").trial);
    for (int q = 0; q < points; ++q) {
      Batch value = 0;
      for (int a = 0; a < phi.size; ++a) value += batch.group.shape->N[q * phi.size + a] * phi.value[a];
      broken.add(value, rule.phi);
    }
  }
  for (int q = 0; q < points; ++q) flown.add(history.value[q * history.components + alpha], rule.strain);
  if (rule.failure) {
    const auto measure = batch.load<1>(state_.row("jc_failure").trial);
    for (const Batch& value : measure.all()) worn.add(value, 1);
  }
  int failed = 0;
  for (int l = 0; l < batch.used(); ++l) {
    if (!batch.live(l)) continue;
    const bool shape = now.least_J[l] <= rule.J || now.largest_stretch[l] >= rule.stretch ||
                       !(step[l] >= rule.step * first[l]);
    const bool by_shape =
        has_damage ? broken.reached(l) && (shape || !rule.by_shape()) : shape && rule.by_shape();
    if (by_shape || flown.reached(l) || worn.reached(l)) failed |= 1 << l;
  }
  return failed;
}

void Erosion::find_failed(Vec u) {
  const std::vector<double> place_of = d_.local_of(u);
  std::vector<int> lanes_of(d_.batch_count(), 0);
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (d_.materials[batch.material()].erosion.on) lanes_of[batch.place()] = failed_lanes(batch, place_of);
  });
  take_out(lanes_of, place_of, true);
}

} // namespace impact
