#pragma once
#include <impact/kernel/point_data.hpp>

/// Damage balance of one batch of cells, with Y = g_1' E+ + g_2' E- + g_p' D_p + G_c w'(phi)/gamma -
/// Fat/gamma and h = a G_c gamma C^-1 Grad phi (or a G_c gamma Grad phi for DamageGradient::material); w, a:
/// crack.hpp.
///   multiplied: int w lambda_n (phi - phi_n)/dt + [ w Y + Grad w . h ]_theta
///   divided:    int w (phi - phi_n) + dt [ (w Y + Grad w . h)/lambda_n ]_theta
///                 + dt w G_c gamma Grad(1/lambda_n) . [C^-1]_theta Grad phi_n (111)-(112)
/// []_theta weighs t_{n+1} with theta_d and t_n with 1 - theta_d; lambda_n = (1 + delta - phi_n)^zeta / c.
/// Both forms have the same root where phi_n is uniform. The history-field variant hands max(H_n, E+) in as
/// E_plus of the drive.
namespace impact {

enum class DamageForm { multiplied, divided };

struct DamageInput {
  const Batch* X = nullptr;       ///< [node][dim] reference coordinates
  const Batch* u = nullptr;       ///< [node][dim] accepted displacement at t_{n+1}
  const Batch* u_n = nullptr;     ///< [node][dim] at t_n; read only when theta_d < 1
  const Batch* phi = nullptr;     ///< [node] the iterate
  const Batch* phi_n = nullptr;   ///< [node] at t_n
  const Batch* drive = nullptr;   ///< [point][drive_size] at t_{n+1}
  const Batch* drive_n = nullptr; ///< [point][drive_size] at t_n; read only when theta_d < 1
  const Batch* fatigue = nullptr; ///< [point] Fat_n, or nullptr (= 0)
  const Batch* history =
      nullptr; ///< [point][history_size] at t_n, for the alpha of a ductile degradation; nullptr: alpha = 0
  double dt = 1;
  DamageForm form = DamageForm::multiplied;
  double theta_d = 1;  ///< 1 backward Euler, 1/2 trapezoid (the paper)
  bool convex = false; ///< tangent of a concave degradation bent up to positive curvature
};

} // namespace impact
