#pragma once
#include <impact/mesh/state_table.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/solve/step_record.hpp>
#include <span>
#include <vector>

/// Energies that the cells of bodies store and lose, E_m = sum over the cells of material m of int e dV_0,
/// with the densities of kernel/cell_kernels.hpp (theory.md, 11). They are per unit thickness in plane
/// problems where nothing else is said.
namespace impact {

/// The rows that these integrals read; null where the run has no such physics.
struct BodyRows {
  StateRow& history;
  StateRow* drive;
  const StateRow *phi, *theta, *fatigue, *toughness, *failure;
  explicit BodyRows(StateTable& state);
};

/// The energies of one material, times the thickness. Ranks add them up in the order of the members.
struct MaterialEnergies {
  double kinetic = 0, elastic = 0, plastic = 0, fracture = 0, fatigue = 0, thermal = 0, entropy = 0;
  double momentum[3] = {0, 0, 0}, spin[3] = {0, 0, 0};
};

struct Energies {
  std::vector<MaterialEnergies> of; ///< [material]
  MaterialEnergies total;           ///< without the momenta
  double phi_max = 0, alpha_max = 0, theta_max = 0, theta_min = 0, fatigue_max = 0, failure_max = 0;
};

/// Integrates over the state at t_n, or that at t_{n+1} in the trial halves. `v` null: nothing moves.
/// Collective.
Energies find_energies(const Discretisation& d, const BodyRows& rows, Vec u, Vec v, bool trial);

/// Lost in a step by damage, on this rank until a tally is reduced.
struct DamageLosses {
  std::vector<double> by_rate, by_exchange; ///< [material]; of damage and flow
  double most_gained = 0;                   ///< at a point, per volume
  void add_to(Tally& tally) {
    tally.sum(by_rate);
    tally.sum(by_exchange);
    tally.largest({&most_gained, 1});
  }
};
/// Needs phi.
DamageLosses find_damage_losses(const Discretisation& d, const BodyRows& rows, const StepRecord& step);

/// The unilateral stress stores this in a step, at the damage `phi` that its force saw, [node]. `drive_n`:
/// the driving energies of t_n. Collective.
double find_unilateral_energy(const Discretisation& d, const BodyRows& rows, std::span<const double> phi,
                              const std::vector<double>& drive_n);

} // namespace impact
