#pragma once
#include <impact/element/shape.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/kernel/motion.hpp>
#include <impact/material/point_law.hpp>
#include <impact/math/batch.hpp>

/// Integrals over a batch of cells that the ledger and the output read; nothing here enters an equation.
namespace impact {

struct EnergyInput {
  const Batch* X = nullptr;       ///< [node][dim] reference coordinates
  const Batch* u = nullptr;       ///< [node][dim]
  const Batch* v = nullptr;       ///< [node][dim] velocity, or nullptr (= 0)
  const Batch* phi = nullptr;     ///< [node], or nullptr (= 0)
  const Batch* theta = nullptr;   ///< [node], or nullptr (= theta0)
  const Batch* history = nullptr; ///< [point][history_size] of the same time as u; nullptr for Model::elastic
  const Batch* fatigue = nullptr; ///< [point] Fat, or nullptr (= 0); with phi
  const Batch* drive = nullptr;   ///< [point][drive_size] of that time; read where the law softens
};

/// Sums over the points, per lane; stored_energy adds to them.
struct EnergySums {
  Batch elastic = 0;             ///< int g_1 E+ + g_2 E-   (with the J of the chosen locking cure)
  Batch plastic = 0;             ///< int g_p H_s,  H_s = (1 - chi) H_0 (with softening: the sum in drive)
  Batch fracture = 0;            ///< int psi_phi
  Batch fatigue = 0;             ///< int Fat H_f(phi)/gamma
  Batch kinetic = 0;             ///< int rho/2 v.v
  Batch mass = 0;                ///< int rho
  Batch momentum[3] = {0, 0, 0}; ///< int rho v
};

template <class Cell, Frame frame> void stored_energy(const PointLaw&, const EnergyInput&, EnergySums&);

/// Sums over the points, per lane; stored_heat adds to them.
struct HeatSums {
  Batch energy = 0;  ///< int c_V (theta - theta_0) + theta s: the thermal part of the internal energy
  Batch entropy = 0; ///< int c_V ln(theta/theta_0) + s,   s = 3 alpha_t g_v K/2 (J_e^2 - 1)
};

/// Needs in.theta.
template <class Cell, Frame frame> void stored_heat(const PointLaw&, const EnergyInput& in, HeatSums&);

/// lambda(phi_n) (phi - phi_n)^2 / dt per volume is added to each of `points`. phi, phi_n [node].
template <class Cell>
void damage_dissipation(const PointLaw& law, const Batch* phi, const Batch* phi_n, double dt, Batch* points) {
  for (int q = 0; q < Cell::points; ++q) {
    Batch old = Batch(0.0), step = old;
    for (int a = 0; a < Cell::nodes; ++a) {
      old += shape_table<Cell>.N[q][a] * phi_n[a];
      step += shape_table<Cell>.N[q][a] * (phi[a] - phi_n[a]);
    }
    points[q] += (1 / dt) * (damage_viscosity(law.parameters, old) * (step * step));
  }
}

/// Integral over the reference volume of each cell of what is given at its points, and its mean. X
/// [node][dim], values [point].
template <class Cell, Frame frame> Batch cell_integral(const Batch* X, const Batch* values);
template <class Cell, Frame frame> Batch cell_mean(const Batch* X, const Batch* values);

/// What damage and flow of a step exchange with the plastic heat, per volume at each point
/// (PointLaw::plastic_exchange). For laws that exchange anything.
struct ExchangeInput {
  const Batch *phi = nullptr, *phi_n = nullptr;         ///< [node]
  const Batch *history = nullptr, *history_n = nullptr; ///< [point][history_size]
  const Batch* drive = nullptr;                         ///< [point][drive_size] at t_{n+1}
};
template <class Cell, Frame frame>
void plastic_exchange(const PointLaw&, const ExchangeInput&, Batch* points);

/// int m (E^- - E^-_n), per lane: what a step stores by the unilateral part of the stress; sum is added to.
/// X [node][dim]; phi [node]; history [point][history_size] of t_n, read where g knows alpha; drive, drive_n
/// [point][drive_size] at t_{n+1} and t_n.
template <class Cell, Frame frame>
void unilateral_energy(const PointLaw&, const Batch* X, const Batch* phi, const Batch* history_n,
                       const Batch* drive, const Batch* drive_n, Batch& sum);

/// Averages over the reference volume of each cell.
struct CellOutput {
  Batch stress[6]; ///< Cauchy stress 11 22 33 12 23 13 (all parts of the motion's stress)
  Batch von_mises; ///< of the average stress
  Batch pressure;  ///< -tr sigma / 3 of the average stress
  Batch alpha, phi;
};

/// in.history is the history of the same time as in.u, so that no flow happens here.
template <class Cell, Frame frame> void cell_output(const PointLaw&, const MotionInput& in, CellOutput& out);

/// M [node][node] += int rho N_a N_b (2 pi R in the axisymmetric frame).
template <class Cell, Frame frame> void mass_matrix(const PointLaw&, const Batch* X, Batch* M);

/// Smallest height of each cell, per lane: over the opposite side in simplices, between opposite sides at the
/// centroid in quads and hexes. X [node][dim].
template <class Cell> Batch cell_size(const Batch* X);

} // namespace impact
