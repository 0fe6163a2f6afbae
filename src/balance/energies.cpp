#include <algorithm>
#include <impact/balance/energies.hpp>
#include <impact/kernel/measure.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>

namespace impact {

namespace {

// The order of the sums is part of their values: cell by cell, then over ranks.
void add(const EnergySums& sums, int used, MaterialEnergies& to) {
  to.kinetic += lane_sum(sums.kinetic, used);
  to.elastic += lane_sum(sums.elastic, used);
  to.plastic += lane_sum(sums.plastic, used);
  to.fracture += lane_sum(sums.fracture, used);
  to.fatigue += lane_sum(sums.fatigue, used);
  for (int k = 0; k < 3; ++k) to.momentum[k] += lane_sum(sums.momentum[k], used);
}

void find_peaks(const Discretisation& d, const BodyRows& rows, bool trial, Energies& energies) {
  double most[4] = {0, 0, 0, 0};
  const auto largest = [&](const StateRow* row, double& peak) {
    if (row == nullptr) return;
    for (const double value : trial ? row->trial : row->committed) peak = std::max(peak, value);
  };
  largest(rows.phi, most[0]);
  largest(rows.theta, most[2]);
  largest(rows.fatigue, most[3]);
  const std::vector<double>& history = trial ? rows.history.trial : rows.history.committed;
  const std::size_t step = at(history_size(d.frame)) * lanes;
  for (std::size_t i = at(history_alpha(d.frame)) * lanes; i < history.size(); i += step)
    for (std::size_t l = 0; l < lanes; ++l) most[1] = std::max(most[1], history[i + l]);
  max_over_ranks(d.mesh.comm(), most);
  energies.phi_max = most[0];
  energies.alpha_max = most[1];
  energies.theta_max = most[2];
  energies.fatigue_max = most[3];
}

} // namespace

BodyRows::BodyRows(StateTable& state)
    : history(state.row("history")), drive(state.row("drive")), phi(state.find("phi")),
      theta(state.find("theta")), fatigue(state.find("fatigue")) {}

Energies find_energies(const Discretisation& d, const BodyRows& rows, Vec u, Vec v, bool trial) {
  std::vector<double> u_local = d.displacement.make_local(), v_local = u_local;
  d.displacement.to_local(u, u_local);
  if (v) d.displacement.to_local(v, v_local);
  const auto half = [trial](const StateRow* row) {
    return row == nullptr ? nullptr : trial ? &row->trial : &row->committed;
  };
  Energies energies;
  energies.of.resize(d.materials.size());
  for_each_batch(d, all_laws, [&]<class Cell, Frame frame>(const CellBatch<Cell, frame>& batch) {
    MaterialEnergies& mine = energies.of[batch.material()];
    const auto X = batch.template gather<Cell::dim>(d.mesh.coordinates()),
               moved = batch.template gather<Cell::dim>(u_local),
               speed = batch.template gather<Cell::dim>(v_local);
    Gathered<Cell, 1> phi, theta;
    PointValues<Cell, history_size(frame)> points;
    PointValues<Cell, 1> fatigue;
    PointValues<Cell, drive_size> driven;
    EnergyInput in;
    in.X = X.data();
    in.u = moved.data();
    in.v = v ? speed.data() : nullptr;
    in.phi = batch.read(half(rows.phi), phi);
    in.theta = batch.read(half(rows.theta), theta);
    in.history = batch.read(half(&rows.history), points);
    in.fatigue = batch.read(half(rows.fatigue), fatigue);
    in.drive = batch.read(batch.law.softens() ? half(&rows.drive) : nullptr, driven);
    EnergySums sums;
    stored_energy<Cell, frame>(batch.law, in, sums);
    add(sums, batch.used(), mine);
    if (!rows.theta) return;
    HeatSums heat;
    stored_heat<Cell, frame>(batch.law, in, heat);
    mine.thermal += batch.sum(heat.energy);
    mine.entropy += batch.sum(heat.entropy);
  });
  constexpr std::size_t numbers = sizeof(MaterialEnergies) / sizeof(double), without_momentum = numbers - 3;
  const std::span<double> all(&energies.of.data()->kinetic, numbers * energies.of.size());
  sum_over_ranks(d.mesh.comm(), all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] *= d.thickness;
    if (i % numbers < without_momentum) (&energies.total.kinetic)[i % numbers] += all[i];
  }
  find_peaks(d, rows, trial, energies);
  return energies;
}

DamageLosses find_damage_losses(const Discretisation& d, const BodyRows& rows, const StepRecord& step) {
  DamageLosses losses;
  losses.by_damage.resize(d.materials.size());
  losses.by_exchange.resize(d.materials.size());
  for_each_batch(d, damages, [&]<class Cell, Frame frame>(const CellBatch<Cell, frame>& batch) {
    const auto X = batch.template gather<Cell::dim>(d.mesh.coordinates());
    const auto integral = [&](auto& points) {
      return batch.sum(cell_integral<Cell, frame>(X.data(), points.data()));
    };
    auto all = batch.template load<1>(step.damage_dissipation);
    losses.by_damage[batch.material()] += integral(all);
    if (batch.law.exchanges()) {
      const auto now = batch.template gather<1>(rows.phi->trial),
                 before = batch.template gather<1>(rows.phi->committed);
      auto flowed = batch.template load<history_size(frame)>(rows.history.trial),
           flowed_n = batch.template load<history_size(frame)>(rows.history.committed);
      auto driving = batch.template load<drive_size>(rows.drive.trial);
      PointValues<Cell, 1> exchanged;
      plastic_exchange<Cell, frame>(
          batch.law, {now.data(), before.data(), flowed.data(), flowed_n.data(), driving.data()},
          exchanged.data());
      losses.by_exchange[batch.material()] += integral(exchanged);
      batch.load(step.dissipation, all);
      for (std::size_t q = 0; q < all.value.size(); ++q) all.value[q] += exchanged.value[q];
    }
    for (const Batch& at_point : all.value)
      for (int l = 0; l < batch.used(); ++l) losses.least = std::min(losses.least, at_point[l]);
  });
  sum_over_ranks(d.mesh.comm(), losses.by_damage);
  sum_over_ranks(d.mesh.comm(), losses.by_exchange);
  losses.least = min_over_ranks(d.mesh.comm(), losses.least);
  return losses;
}

double find_unilateral_energy(const Discretisation& d, const BodyRows& rows, std::span<const double> phi,
                              const std::vector<double>& drive_n) {
  double sum = 0;
  for_each_batch(d, damages, [&]<class Cell, Frame frame>(const CellBatch<Cell, frame>& batch) {
    const auto X = batch.template gather<Cell::dim>(d.mesh.coordinates());
    const auto seen = batch.template gather<1>(phi);
    auto flowed = batch.template load<history_size(frame)>(rows.history.committed);
    auto after = batch.template load<drive_size>(rows.drive.trial),
         before = batch.template load<drive_size>(drive_n);
    Batch part = 0;
    unilateral_energy<Cell, frame>(batch.law, X.data(), seen.data(), flowed.data(), after.data(),
                                   before.data(), part);
    sum += batch.sum(part);
  });
  return sum_over_ranks(d.mesh.comm(), sum);
}

} // namespace impact
