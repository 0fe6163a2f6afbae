#pragma once
#include <impact/kernel/cell_fields.hpp>

namespace impact {

// Integrals over a batch of cells that the ledger and the output read; nothing here enters an equation.

/// All of one time. The drive is read where the law softens.
struct EnergyInput : CellFields {
  const Batch* v = nullptr;     ///< [node][dim] velocity, or nullptr (= 0)
  const Batch* moved = nullptr; ///< [node][dim] where the mass is, in the place of u; nullptr: as u says
  bool lumped = false;          ///< the mass stands at the nodes
  bool lumped_capacity = false; ///< c_V does
};

/// Sums over the points, per lane; stored_energy adds to them.
struct EnergySums {
  Batch elastic = 0;             ///< int g_1 E+ + g_2 E-   (with the J of the chosen locking cure)
  Batch plastic = 0;             ///< int g_p H_s,  H_s = (1 - chi) H_0 (with softening: the sum in drive)
  Batch fracture = 0;            ///< int psi_phi
  Batch fatigue = 0;             ///< int Fat H_f(phi)/gamma
  Batch kinetic = 0;             ///< int rho/2 v.v, or the sum over the nodes where the mass is lumped
  Batch mass = 0;                ///< int rho
  Batch momentum[3] = {0, 0, 0}; ///< int rho v
  Batch spin[3] = {0, 0, 0};     ///< int rho x cross v about the origin; none of rings
};

/// Sums over the points, per lane; stored_heat adds to them.
struct HeatSums {
  Batch energy = 0;  ///< int c_V (theta - theta_0) + theta s: the thermal part of the internal energy
  Batch entropy = 0; ///< int c_V ln(theta/theta_0) + s,   s = 3 alpha_t g_v K/2 (J_e^2 - 1)
};

/// Of the points of each cell, per lane.
struct CellDistortion {
  Batch least_J = 1;         ///< det F
  Batch largest_stretch = 1; ///< principal
};

/// Averages over the reference volume of each cell.
struct CellOutput {
  Batch stress[6]; ///< Cauchy stress 11 22 33 12 23 13 (all parts of the motion's stress)
  Batch von_mises; ///< of the average stress
  Batch pressure;  ///< -tr sigma / 3 of the average stress
  Batch alpha, phi;
};

} // namespace impact
