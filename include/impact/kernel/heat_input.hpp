#pragma once
#include <impact/kernel/cell_fields.hpp>

namespace impact {

// Heat balance of one batch of cells over a step, as energies (all rates times dt), with the heat flux
// q = -kappa grad theta and []_h weighing t_{n+1} with theta_h and t_n with 1 - theta_h:
//   entropy: int w ([theta]_h (eta - eta_n) - D) + dt [grad w . kappa grad theta]_h           (45')
//            D = dissipation of the step by plasticity, viscosity and the rate of damage
//              + phi (Fat - Fat_n)/gamma + x (PointLaw::plastic_exchange)
//   energy:  int w (e - e_n - W) + grad w . h (phi - phi_n) + dt [grad w . kappa grad theta]_h (5')
//            e = internal energy, W = 1/2 (P + P_n) : (F - F_n), h = a G_c gamma C^-1 Grad phi
// eta = c_V ln(theta/theta_0) + 3 alpha_t g_v K/2 (J_e^2 - 1) with the J_e of the chosen locking cure. Loads
// are added by the caller. A lumped c_V takes the temperatures of the nodes in its terms. The summed energy
// form is the discrete first law with the work that the motion solves did.

enum class HeatForm { entropy, energy };

/// What heat_step leaves at each point for heat_residual and heat_tangent, but for the excess, which the
/// former finds.
struct HeatPoint {
  Batch volume;    ///< J - 1 of the locking cure
  Batch entropy_n; ///< 3 alpha_t g_v K/2 (J_e^2 - 1) at t_n
  Batch warming;   ///< what p would change per J if no heat flowed (45a)
  Batch per_heat;  ///< and per heat at fixed J, beta/c_eff
  Batch source;    ///< what heat_step counts of the balance, per volume
  Batch excess;    ///< what the balance without conduction leaves: heat that the temperature shows too much
};
inline constexpr int heat_point_size = sizeof(HeatPoint) / sizeof(Batch);
inline HeatPoint& heat_point_at(Batch* points, int q) { return reinterpret_cast<HeatPoint*>(points)[q]; }
inline const HeatPoint& heat_point_at(const Batch* points, int q) {
  return reinterpret_cast<const HeatPoint*>(points)[q];
}

/// theta is the iterate. The histories are read of moved laws that flow in the energy form, that exchange or
/// are ductile, and in plane stress; the drives of laws that soften in the energy form, of those that
/// exchange in the entropy form.
struct HeatInput : CellFields {
  const Batch* dissipation = nullptr; ///< [point] of the step per volume; nullptr = none
  const Batch* stress = nullptr;   ///< [point][stress_size] P, p of the motion at t_{n+1}; energy form with u
  const Batch* stress_n = nullptr; ///< at t_n
  const Batch* patch_work = nullptr; ///< work of p per volume of the patch; null: of the cell
  double theta_h = 1;
  HeatForm form = HeatForm::entropy;
  bool lumped = false; ///< c_V stands at the nodes, by the weights of LumpedMass
};

} // namespace impact
