#pragma once
#include <impact/kernel/cell_kernels.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/damage.hpp>

/// What the kernels of damage read of one batch of cells.
namespace impact {

// The history of that energy in place of its parts.
inline void put_history(const PointValues<1>& H, PointValues<drive_size>& drive) {
  for (int q = 0; q < H.size; ++q) drive_at(drive.data(), q) = {H.value[q], 0.0, 0.0};
}

// int psi_phi of each cell at u and phi, with the toughness G_c; `flow` holds what flowed by the end of the
// step.
inline Batch crack_energy_of(const CellBatch& batch, const std::vector<double>& u,
                             const std::vector<double>& phi, const StateRow& flow) {
  const auto X = batch.vectors(batch.d.mesh.coordinates()), displaced = batch.displaced(u);
  const auto damage = batch.scalars(phi);
  auto flowed = batch.histories();
  EnergyInput in;
  in.X = X.data();
  in.u = displaced.data();
  in.phi = damage.data();
  in.history = batch.read(&flow.trial, flowed);
  EnergySums sums;
  batch.kernels.stored_energy(batch.law, in, sums);
  return sums.fracture;
}

// body(batch, input of the kernels at x) answers with the lanes that lost their meaning; false where any did.
template <class Body> bool DamageProblem::visit_batches(const Equation& equation, Vec x, Body&& body) {
  field_.to_local(x, x_);
  bool sound = true;
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    const bool both_ends = equation.theta < 1; // count, in the equation
    const auto X = batch.vectors(d_.mesh.coordinates()), u = batch.displaced(*step_.u);
    const auto phi = batch.scalars(x_), phi_n = batch.scalars(*equation.phi_n);
    auto u_n = batch.nodal(d_.dim());
    auto now = batch.load<drive_size>(drive_.trial), before = batch.points<drive_size>();
    if (history_) put_history(batch.load<1>(history_->trial), now);
    if (both_ends) {
      u_n = batch.displaced(*step_.u_n);
      batch.load(drive_.committed, before);
      if (history_) put_history(batch.load<1>(history_->committed), before);
    }
    // Of a cell of the toughness f G_c the equation is f times that of one of the toughness G_c that 1/f of
    // the energies drives (F2), (T1).
    if (batch.changes_toughness()) {
      const Batch left = toughness(batch);
      for (Batch& energy : now.all()) energy = energy / left;
      if (both_ends)
        for (Batch& energy : before.all()) energy = energy / left;
    }
    if (step_.drive_factor != 1)
      for (Batch& energy : now.all()) energy *= step_.drive_factor;
    auto worn = batch.points<1>();
    auto flowed = batch.histories();
    DamageInput in;
    in.fatigue = batch.read(worn_ && law.fatigues() ? &worn_->committed : nullptr, worn);
    in.history = batch.read(is_ductile(law.parameters) ? &flow_.committed : nullptr, flowed);
    in.X = X.data();
    in.u = u.data();
    in.u_n = both_ends ? u_n.data() : nullptr;
    in.phi = phi.data();
    in.phi_n = phi_n.data();
    in.drive = now.data();
    in.drive_n = both_ends ? before.data() : nullptr;
    in.dt = equation.dt;
    in.form = equation.form;
    in.theta_d = equation.theta;
    in.convex = true;
    sound = batch.broken(body(batch, in)) == 0 && sound;
  });
  return all_ranks_agree(d_.mesh.comm(), sound);
}

} // namespace impact
