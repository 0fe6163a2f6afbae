#include "damage_batches.hpp"
#include "nodal_rate.hpp"
#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <petscts.h>

/// The rate law of damage by explicit sub-steps (theory.md, 8): C_a dphi_a/dt = <-f_a> at each node, with the
/// force f of the energy and the lumped capacity C_a = lambda(phi_a) V_a.
namespace impact {

namespace {

constexpr double safety = 0.8; // of the longest stable sub-step, 2 C_a / sum_b |K_ab| at every node

} // namespace

DamageProblem::~DamageProblem() = default;

void DamageProblem::set_explicit(TS ts) {
  check(TSSetType(ts, TSEULER));
  check(TSSetRHSFunction(ts, nullptr, Callback<&DamageProblem::substep_rate>::call, this));
  check(TSSetFromOptions(ts));
  if (!has_type(ts, TSEULER, TSSSP))
    throw UserError(ExitCode::usage, "-damage_ts_type: explicit sub-steps (-damage_substeps) are by euler or "
                                     "ssp; take one of these, or -damage_ts_dt in place of -damage_substeps");
  rate_ = std::make_unique<NodalRate>();
  find_volumes();
  for (std::vector<double>* values :
       {&rate_->force, &rate_->end_force, &rate_->stiffness, &rate_->capacity, &rate_->added})
    *values = d_.scalar.make_local();
}

void DamageProblem::find_volumes() {
  NodalRate& rate = *rate_;
  rate.volume.resize(d_.materials.size());
  rate.volumes = d_.scalar.make_local();
  CellMatrix m;
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    std::vector<double>& volume = rate.volume[batch.material()];
    if (volume.empty()) volume = d_.scalar.make_local();
    PointLaw of_unit_density = batch.law;
    of_unit_density.parameters.rho = 1;
    const auto X = batch.vectors(d_.mesh.coordinates());
    batch.kernels.mass_matrix(of_unit_density, X.data(), m.zeroed(batch.nodes()));
    auto rows = batch.zero(1);
    for (int i = 0; i < rows.size; ++i)
      for (int j = 0; j < rows.size; ++j) rows.value[i] += m(i, j);
    batch.scatter(rows, volume);
  });
  for (std::size_t i = 0; i < rate.volume.size(); ++i) {
    // A rank may have no cell of a material that another one has at a node of both.
    const bool none = rate.volume[i].empty();
    if (all_ranks_agree(d_.mesh.comm(), none)) continue;
    if (none) rate.volume[i] = d_.scalar.make_local();
    add_up(d_.scalar, rate.volume[i]);
    for (std::size_t a = 0; a < rate.volumes.size(); ++a) rate.volumes[a] += rate.volume[i][a];
  }
}

// Into `force`, and `stiffness` with it, or into `end_force`.
void DamageProblem::find_driving_force(const std::vector<double>& phi, bool with_stiffness) {
  const Timed timed(with_stiffness ? Event::damage_tangent : Event::damage_residual);
  std::vector<double>& force = with_stiffness ? rate_->force : rate_->end_force;
  std::vector<double>& stiffness = rate_->stiffness;
  std::fill(force.begin(), force.end(), 0.0);
  if (with_stiffness) std::fill(stiffness.begin(), stiffness.end(), 0.0);
  CellMatrix K;
  const Handle<Vec> x = d_.scalar.make_global();
  d_.scalar.to_global(phi, x);
  const Equation of_energy{DamageForm::multiplied, 1, HUGE_VAL, &phi};
  visit_batches(of_energy, x, [&](const CellBatch& batch, const DamageInput& in) {
    auto f = batch.zero(1);
    if (!with_stiffness) {
      const int bad = batch.kernels.damage_residual(batch.law, in, f.data());
      batch.scatter(f, force);
      return bad;
    }
    auto rows = batch.zero(1);
    const int bad = batch.kernels.damage_tangent(batch.law, in, f.data(), K.zeroed(batch.nodes()));
    for (int i = 0; i < rows.size; ++i)
      for (int j = 0; j < rows.size; ++j) rows.value[i] += abs(K(i, j));
    batch.scatter(f, force);
    batch.scatter(rows, stiffness);
    return bad;
  });
  add_up(d_.scalar, force);
  if (with_stiffness) add_up(d_.scalar, stiffness);
}

void DamageProblem::find_capacity(const std::vector<double>& phi) {
  NodalRate& rate = *rate_;
  std::fill(rate.capacity.begin(), rate.capacity.end(), 0.0);
  for (std::size_t i = 0; i < rate.volume.size(); ++i)
    for (std::size_t a = 0; a < rate.volume[i].size(); ++a)
      rate.capacity[a] += damage_viscosity(d_.materials[i].law.parameters, phi[a]) * rate.volume[i][a];
}

// Capacities at the start of a sub-step: what damage has, and what its length wants in addition.
void DamageProblem::weigh_nodes(double dt) {
  NodalRate& rate = *rate_;
  if (!rate.at_start) find_driving_force(substep_start_, true); // else by substep_that_fits
  rate.at_start = true;
  find_capacity(substep_start_);
  for (std::size_t a = 0; a < rate.capacity.size(); ++a)
    rate.added[a] = std::max(0.0, dt * rate.stiffness[a] / (2 * safety) - rate.capacity[a]);
}

// A time in as many equal parts as the nodes want that move from phi, if these are not more than `most`.
double DamageProblem::substep_that_fits(double dt, PetscInt most, const std::vector<double>& phi) {
  NodalRate& rate = *rate_;
  rate.at_start = false;
  if (most <= 1) return dt;
  substep_start_ = phi;
  weigh_nodes(dt);
  double parts = 1;
  for (std::size_t a = 0; a < rate.capacity.size(); ++a)
    if (rate.added[a] > 0 && rate.force[a] < 0 && !field_.held()[a])
      parts = std::max(parts, 1 + rate.added[a] / std::max(rate.capacity[a], 1e-300));
  return dt / std::min(static_cast<double>(most), std::ceil(max_over_ranks(d_.mesh.comm(), parts)));
}

void DamageProblem::substep_rate(TS, PetscReal, Vec x, Vec rate_of_phi) {
  NodalRate& rate = *rate_;
  if (!rate.at_start) {
    d_.scalar.to_local(x, substep_end_);
    find_driving_force(substep_end_, false);
    find_capacity(substep_end_);
  }
  const std::vector<double>& force = rate.at_start ? rate.force : rate.end_force;
  rate.at_start = false;
  std::vector<double>& values = r_;
  for (std::size_t a = 0; a < values.size(); ++a) {
    const double capacity = rate.capacity[a] + rate.added[a];
    values[a] = force[a] < 0 && capacity > 0 ? -force[a] / capacity : 0;
  }
  d_.scalar.to_global(values, rate_of_phi);
  field_.zero_held(rate_of_phi);
}

// What the energy gave, by the mean force of both ends: at the nodes, per volume, and from there at the
// points.
void DamageProblem::book_substep(double dt) {
  NodalRate& rate = *rate_;
  find_driving_force(substep_end_, false);
  std::vector<double>& lost = r_;
  for (std::size_t a = 0; a < lost.size(); ++a) {
    const double change = field_.held()[a] ? 0 : substep_end_[a] - substep_start_[a];
    const double energy = -(rate.force[a] + rate.end_force[a]) / 2 * change;
    lost[a] = rate.volumes[a] > 0 ? energy / rate.volumes[a] : 0;
    if (!d_.mesh.owned(static_cast<int>(a))) continue;
    rate.power += -rate.force[a] * change;
    rate.held_back += rate.added[a] * change * change / dt;
  }
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    const auto at_nodes = batch.scalars(lost);
    auto points = batch.load<1>(dissipated_);
    for (int q = 0; q < points.size; ++q)
      for (int a = 0; a < at_nodes.size; ++a)
        points.value[q] += batch.group.shape->N[q * at_nodes.size + a] * at_nodes.value[a];
    batch.store(points, dissipated_);
  });
}

double DamageProblem::held_back() const {
  if (!rate_) return -1;
  double sums[2] = {rate_->held_back, rate_->power};
  sum_over_ranks(d_.mesh.comm(), sums);
  return sums[1] > 0 ? sums[0] / sums[1] : 0;
}

} // namespace impact
