#include <algorithm>
#include <impact/balance/energies.hpp>
#include <impact/kernel/measure.hpp>
#include <impact/problem/cell_loop.hpp>
#include <optional>

namespace impact {

namespace {

std::vector<double> reference_places(const Discretisation& d) {
  return {d.mesh.coordinates().begin(), d.mesh.coordinates().end()};
}

// The order of the sums is part of their values: cell by cell, then over ranks.
void add(const EnergySums& sums, int used, MaterialEnergies& to) {
  to.kinetic += lane_sum(sums.kinetic, used);
  to.elastic += lane_sum(sums.elastic, used);
  to.plastic += lane_sum(sums.plastic, used);
  to.fracture += lane_sum(sums.fracture, used);
  to.fatigue += lane_sum(sums.fatigue, used);
  for (int k = 0; k < 3; ++k) to.momentum[k] += lane_sum(sums.momentum[k], used);
}

bool damages(const PointLaw& law) { return law.parameters.damage != Damage::none; }

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
  most[1] = largest_alpha(d.frame, history);
  MPI_Allreduce(MPI_IN_PLACE, most, 4, MPI_DOUBLE, MPI_MAX, d.mesh.comm());
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
  const auto half = [trial](const StateRow& row) -> const std::vector<double>& {
    return trial ? row.trial : row.committed;
  };
  const std::vector<double> places = reference_places(d);
  Energies energies;
  energies.of.resize(d.materials.size());
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    MaterialEnergies& mine = energies.of[batch.material()];
    const auto X = batch.vectors(places), at = batch.vectors(u_local), speed = batch.vectors(v_local);
    std::optional<NodalValues> phi, theta;
    if (rows.phi) phi = batch.scalars(half(*rows.phi));
    if (rows.theta) theta = batch.scalars(half(*rows.theta));
    auto points = batch.histories();
    batch.load(half(rows.history), points);
    EnergyInput in;
    in.X = X.data();
    in.u = at.data();
    in.v = v ? speed.data() : nullptr;
    in.phi = rows.phi ? phi->data() : nullptr;
    in.theta = rows.theta ? theta->data() : nullptr;
    in.history = points.data();
    auto fatigue = batch.points<1>();
    if (rows.fatigue) {
      batch.load(half(*rows.fatigue), fatigue);
      in.fatigue = fatigue.data();
    }
    auto driven = batch.points<drive_size>();
    if (batch.law.softens()) {
      batch.load(half(rows.drive), driven);
      in.drive = driven.data();
    }
    EnergySums sums;
    batch.kernels.stored_energy(batch.law, in, sums);
    add(sums, batch.used(), mine);
    if (!rows.theta) return;
    HeatSums heat;
    batch.kernels.stored_heat(batch.law, in, heat);
    mine.thermal += batch.sum(heat.energy);
    mine.entropy += batch.sum(heat.entropy);
  });
  static_assert(sizeof(MaterialEnergies) == 10 * sizeof(double));
  MPI_Allreduce(MPI_IN_PLACE, energies.of.data(), static_cast<int>(10 * energies.of.size()), MPI_DOUBLE,
                MPI_SUM, d.mesh.comm());
  MaterialEnergies& total = energies.total;
  for (MaterialEnergies& part : energies.of) {
    for (double* number = &part.kinetic; number != &part.kinetic + 10; ++number) *number *= d.thickness;
    total.kinetic += part.kinetic;
    total.elastic += part.elastic;
    total.plastic += part.plastic;
    total.fracture += part.fracture;
    total.fatigue += part.fatigue;
    total.thermal += part.thermal;
    total.entropy += part.entropy;
  }
  find_peaks(d, rows, trial, energies);
  return energies;
}

DamageLosses find_damage_losses(const Discretisation& d, const BodyRows& rows, const StepRecord& step) {
  const std::vector<double> places = reference_places(d);
  const std::size_t materials = d.materials.size();
  DamageLosses losses;
  losses.by_damage.resize(materials);
  losses.by_exchange.resize(materials);
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    const auto X = batch.vectors(places);
    const auto by_damage = batch.load<1>(step.damage_dissipation);
    auto all = by_damage;
    losses.by_damage[batch.material()] += batch.sum(batch.kernels.cell_integral(X.data(), by_damage.data()));
    if (batch.law.exchanges()) {
      batch.load(step.dissipation, all);
      const auto now = batch.scalars(rows.phi->trial), before = batch.scalars(rows.phi->committed);
      const auto driving = batch.load<drive_size>(rows.drive.trial);
      auto flowed = batch.histories(), flowed_n = batch.histories();
      auto exchanged = batch.points<1>();
      batch.load(rows.history.trial, flowed);
      batch.load(rows.history.committed, flowed_n);
      batch.kernels.plastic_exchange(
          batch.law, {now.data(), before.data(), flowed.data(), flowed_n.data(), driving.data()},
          exchanged.data());
      losses.by_exchange[batch.material()] +=
          batch.sum(batch.kernels.cell_integral(X.data(), exchanged.data()));
      for (int q = 0; q < all.size; ++q) all.value[q] += exchanged.value[q];
    }
    for (const Batch& at_point : all.all())
      for (int l = 0; l < batch.used(); ++l) losses.least = std::min(losses.least, at_point[l]);
  });
  for (std::vector<double>* sums : {&losses.by_damage, &losses.by_exchange})
    MPI_Allreduce(MPI_IN_PLACE, sums->data(), static_cast<int>(materials), MPI_DOUBLE, MPI_SUM,
                  d.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &losses.least, 1, MPI_DOUBLE, MPI_MIN, d.mesh.comm());
  return losses;
}

double find_unilateral_energy(const Discretisation& d, const BodyRows& rows, std::span<const double> phi,
                              const std::vector<double>& drive_n) {
  const std::vector<double> places = reference_places(d);
  double sum = 0;
  for_each_batch(d, damages, [&](const CellBatch& batch) {
    const auto X = batch.vectors(places), seen = batch.scalars(phi);
    const auto after = batch.load<drive_size>(rows.drive.trial), before = batch.load<drive_size>(drive_n);
    auto flowed = batch.histories();
    batch.load(rows.history.committed, flowed);
    Batch part = 0;
    batch.kernels.unilateral_energy(batch.law, X.data(), seen.data(), flowed.data(), after.data(),
                                    before.data(), part);
    sum += batch.sum(part);
  });
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  return sum;
}

} // namespace impact
