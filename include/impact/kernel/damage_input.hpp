#pragma once
#include <impact/kernel/cell_fields.hpp>

namespace impact {

// Damage balance of one batch of cells, with Y = g_1' E+ + g_2' E- + g_p' D_p + G_c w'(phi)/gamma -
// Fat/gamma and h = a G_c gamma C^-1 Grad phi (or a G_c gamma Grad phi for DamageGradient::material); w, a:
// crack.hpp.
//   multiplied: int w lambda_n (phi - phi_n)/dt + [ w Y + Grad w . h ]_theta
//   divided:    int w (phi - phi_n) + dt [ (w Y + Grad w . h)/lambda_n ]_theta
//                 + dt w G_c gamma Grad(1/lambda_n) . [C^-1]_theta Grad phi_n (111)-(112)
// []_theta weighs t_{n+1} with theta_d and t_n with 1 - theta_d; lambda_n = (1 + delta - phi_n)^zeta / c.
// Both forms have the same root where phi_n is uniform. The history-field variant hands max(H_n, E+) in as
// E_plus of the drive.

enum class DamageForm { multiplied, divided };

/// u is the accepted displacement; u_n and drive_n are read only when theta_d < 1. The history is that at
/// t_n, for the alpha of a ductile degradation, and fatigue is Fat_n.
struct DamageInput : CellFields {
  DamageForm form = DamageForm::multiplied;
  double theta_d = 1;  ///< 1 backward Euler, 1/2 trapezoid (the paper)
  bool convex = false; ///< tangent of a concave degradation bent up to positive curvature
};

// Growth of the fatigue variable of one batch of cells over a step (F1'), after the damage solve:
//   Fat = Fat_n + (a/gamma) (1 - phi) phi |W|,   W = 1/2 [ 1/2 (S_c + S_c,n) + S_d ] : (C - C_n)
// S_c is the elastic stress of the undamaged body with the plastic state and the locking cure of the motion,
// S_d = 2 b_d (C - C_n)/dt. In an elastic body 1/2 (S_c + S_c,n) : (C - C_n)/2 is the change of its energy
// to third order, so that a few steps resolve a cycle; no rotation counts.

/// The temperatures are those that the motion solves saw; Fat_n is read, Fat comes out.
using FatigueInput = CellFields;

/// Sums over the points, per lane; fatigue_advance adds to them.
struct FatigueSums {
  Batch dissipation = 0; ///< int phi (Fat - Fat_n)/gamma
  Batch least = 0;       ///< smallest dissipation per volume at a point, at most 0
};

} // namespace impact
