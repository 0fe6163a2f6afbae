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
  const auto components = static_cast<std::size_t>(history_size(d.frame));
  const auto of_alpha = static_cast<std::size_t>(history_alpha(d.frame));
  for (std::size_t i = of_alpha * lanes; i < history.size(); i += components * lanes)
    for (std::size_t l = 0; l < lanes; ++l) most[1] = std::max(most[1], history[i + l]);
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
  const std::vector<double>& history = half(rows.history);
  const std::vector<double>& drive = half(rows.drive);
  const auto offset = point_offsets(d.groups, history_size(d.frame)), one = point_offsets(d.groups, 1),
             drive_offset = point_offsets(d.groups, drive_size);
  const std::vector<double> places = reference_places(d);
  Energies energies;
  energies.of.resize(d.materials.size());
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    MaterialEnergies& mine = energies.of[static_cast<std::size_t>(group.material)];
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, dim> X(group, b, places), at(group, b, u_local), speed(group, b, v_local);
        std::optional<Gathered<Cell, 1>> phi, theta;
        if (rows.phi) phi.emplace(group, b, half(*rows.phi));
        if (rows.theta) theta.emplace(group, b, half(*rows.theta));
        PointValues<Cell, history_size(frame)> points;
        points.load(history, offset[g], b);
        EnergyInput in;
        in.X = X.data();
        in.u = at.data();
        in.v = v ? speed.data() : nullptr;
        in.phi = rows.phi ? phi->data() : nullptr;
        in.theta = rows.theta ? theta->data() : nullptr;
        in.history = points.data();
        PointValues<Cell, 1> fatigue;
        if (rows.fatigue) {
          fatigue.load(half(*rows.fatigue), one[g], b);
          in.fatigue = fatigue.data();
        }
        PointValues<Cell, drive_size> driven;
        if (law.softens()) {
          driven.load(drive, drive_offset[g], b);
          in.drive = driven.data();
        }
        EnergySums sums;
        stored_energy<Cell, frame>(law, in, sums);
        const int used = group.lanes_in_use(b);
        add(sums, used, mine);
        if (!rows.theta) continue;
        HeatSums heat;
        stored_heat<Cell, frame>(law, in, heat);
        mine.thermal += lane_sum(heat.energy, used);
        mine.entropy += lane_sum(heat.entropy, used);
      }
    });
  }
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
  const auto flow_at = point_offsets(d.groups, history_size(d.frame)),
             drive_at = point_offsets(d.groups, drive_size), at = point_offsets(d.groups, 1);
  const std::vector<double> places = reference_places(d);
  const std::size_t materials = d.materials.size();
  DamageLosses losses;
  losses.by_damage.resize(materials);
  losses.by_exchange.resize(materials);
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    if (law.parameters.damage == Damage::none) continue;
    const auto material = static_cast<std::size_t>(group.material);
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, Cell::dim> X(group, b, places);
        PointValues<Cell, 1> by_damage, all, exchanged;
        by_damage.load(step.damage_dissipation, at[g], b);
        all = by_damage;
        const int used = group.lanes_in_use(b);
        losses.by_damage[material] += lane_sum(cell_integral<Cell, frame>(X.data(), by_damage.data()), used);
        if (law.exchanges()) {
          all.load(step.dissipation, at[g], b);
          const Gathered<Cell, 1> now(group, b, rows.phi->trial), before(group, b, rows.phi->committed);
          PointValues<Cell, history_size(frame)> flowed, flowed_n;
          PointValues<Cell, drive_size> driving;
          flowed.load(rows.history.trial, flow_at[g], b);
          flowed_n.load(rows.history.committed, flow_at[g], b);
          driving.load(rows.drive.trial, drive_at[g], b);
          plastic_exchange<Cell, frame>(
              law, {now.data(), before.data(), flowed.data(), flowed_n.data(), driving.data()},
              exchanged.data());
          losses.by_exchange[material] +=
              lane_sum(cell_integral<Cell, frame>(X.data(), exchanged.data()), used);
          for (std::size_t q = 0; q < all.value.size(); ++q) all.value[q] += exchanged.value[q];
        }
        for (const Batch& at_point : all.value)
          for (int l = 0; l < used; ++l) losses.least = std::min(losses.least, at_point[l]);
      }
    });
  }
  for (std::vector<double>* sums : {&losses.by_damage, &losses.by_exchange})
    MPI_Allreduce(MPI_IN_PLACE, sums->data(), static_cast<int>(materials), MPI_DOUBLE, MPI_SUM,
                  d.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &losses.least, 1, MPI_DOUBLE, MPI_MIN, d.mesh.comm());
  return losses;
}

double find_unilateral_energy(const Discretisation& d, const BodyRows& rows, std::span<const double> phi,
                              const std::vector<double>& drive_n) {
  const auto flow_at = point_offsets(d.groups, history_size(d.frame)),
             drive_at = point_offsets(d.groups, drive_size);
  const std::vector<double> places = reference_places(d), damage(phi.begin(), phi.end());
  double sum = 0;
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const PointLaw& law = d.law(group);
    if (law.parameters.damage == Damage::none) continue;
    with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, Cell::dim> X(group, b, places);
        const Gathered<Cell, 1> seen(group, b, damage);
        PointValues<Cell, history_size(frame)> flowed;
        PointValues<Cell, drive_size> after, before;
        flowed.load(rows.history.committed, flow_at[g], b);
        after.load(rows.drive.trial, drive_at[g], b);
        before.load(drive_n, drive_at[g], b);
        Batch part = 0;
        impact::unilateral_energy<Cell, frame>(law, X.data(), seen.data(), flowed.data(), after.data(),
                                               before.data(), part);
        sum += lane_sum(part, group.lanes_in_use(b));
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, d.mesh.comm());
  return sum;
}

} // namespace impact
