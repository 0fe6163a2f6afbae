#include "damage_batches.hpp"
#include <cmath>
#include <impact/problem/toughness.hpp>

namespace impact {

namespace {

// Of each cell the largest principal stretch at its points, of the half of the history that u belongs to.
Batch largest_stretch(const CellBatch& batch, const std::vector<double>& u, const std::vector<double>& flow) {
  const auto X = batch.vectors(batch.d.mesh.coordinates()), displaced = batch.displaced(u);
  auto flowed = batch.histories();
  MotionInput in;
  in.X = X.data();
  in.u = displaced.data();
  in.history = batch.read(&flow, flowed);
  CellDistortion is;
  batch.kernels.cell_distortion(batch.law, in, is);
  return is.largest_stretch;
}

// Mean temperature of each cell.
Batch mean_temperature(const CellBatch& batch, const StateRow* theta) {
  if (theta == nullptr) return Batch(batch.law.parameters.theta0);
  const auto X = batch.vectors(batch.d.mesh.coordinates());
  const auto nodal = batch.scalars(theta->trial);
  auto at_points = batch.points<1>();
  for (int q = 0; q < at_points.size; ++q) {
    at_points.value[q] = Batch(0.0);
    for (int a = 0; a < nodal.size; ++a)
      at_points.value[q] += batch.group.shape->N[q * nodal.size + a] * nodal.value[a];
  }
  return batch.mean(X, at_points);
}

// What the next step works with: body(batch, committed values) answers with the rate of strain and the energy
// beyond psi_phi.
struct Followed {
  Batch rate = 0, surplus = 0;
};
template <class Body> void write_toughness(const Discretisation& d, StateTable& state, Body&& body) {
  StateRow& row = state.row("toughness");
  const StateRow* theta = state.find("theta");
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    const ToughnessByState& law = batch.toughness_by_state();
    if (!law.works()) return;
    auto values = batch.load<2>(row.committed);
    const Followed now = body(batch, values);
    const Batch temperature = mean_temperature(batch, theta);
    Batch factor = 1;
    for (int l = 0; l < lanes; ++l) factor.set(l, law.factor(now.rate[l], temperature[l]));
    for (int q = 0; q < values.size / 2; ++q) {
      values.value[2 * q] = factor;
      values.value[2 * q + 1] = now.surplus;
    }
    batch.store(values, row.trial);
  });
}

} // namespace

void start_toughness(const Discretisation& d, StateTable& state) {
  write_toughness(d, state, [](const CellBatch&, const PointValues<2>&) { return Followed(); });
}

void follow_toughness(const Discretisation& d, StateTable& state, double dt, const std::vector<double>& u,
                      const std::vector<double>& u_n) {
  const StateRow &history = state.row("history"), &phi = state.row("phi");
  write_toughness(d, state, [&](const CellBatch& batch, const PointValues<2>& before) {
    const Batch stretch = largest_stretch(batch, u, history.trial),
                stretch_n = largest_stretch(batch, u_n, history.committed);
    const Batch grown =
        crack_energy_of(batch, u, phi.trial, history) - crack_energy_of(batch, u, phi.committed, history);
    return Followed{(1 / dt) * abs(log(stretch / stretch_n)),
                    before.value[1] + (before.value[0] - Batch(1.0)) * grown};
  });
}

} // namespace impact
