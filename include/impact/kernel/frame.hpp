#pragma once

/// How the plane of the mesh stands in space. Tensors are three-dimensional in every frame.
namespace impact {

enum class Frame {
  plane_strain, ///< x, y; F_33 = 1; unit thickness
  plane_stress, ///< x, y; F_33 of every point such that tau_33 = 0; unit thickness in the reference
  axisymmetric, ///< x = R, y = Z; F_33 = 1 + u_R / R; weight 2 pi R
  solid         ///< x, y, z
};

inline constexpr int dimension(Frame f) { return f == Frame::solid ? 3 : 2; }

/// A sheet of the thickness that the user gives.
inline constexpr bool is_flat(Frame f) { return f == Frame::plane_strain || f == Frame::plane_stress; }

/// Number of components of Grad u that the nodes decide on: 11 12 21 22 (plane strain and stress), + 33
/// (axisymmetric), row-major 3x3 (solid).
inline constexpr int gradient_size(Frame f) { return is_flat(f) ? 4 : f == Frame::axisymmetric ? 5 : 9; }

/// Point history: components of A = Cp^-1, then alpha. Plane frames: A11 A22 A33 A12 alpha, in plane stress
/// also F_33 - 1; solid: A11 A22 A33 A12 A23 A13 alpha. The start is A = 1, the rest 0.
inline constexpr int history_size(Frame f) {
  return f == Frame::solid ? 7 : f == Frame::plane_stress ? 6 : 5;
}
inline constexpr int max_history_size = 7; ///< in any frame
inline constexpr int max_gradient_size = 9;
inline constexpr int history_size(int dim) { return dim == 3 ? 7 : 5; }
/// Where alpha stands in it.
inline constexpr int history_alpha(Frame f) { return f == Frame::solid ? 6 : 4; }
inline constexpr double history_start(int component) { return component < 3 ? 1 : 0; }

/// Drive of the damage equation per point: E_plus, E_minus, and H_0(alpha) or what of it is above the
/// threshold.
inline constexpr int drive_size = 3;

} // namespace impact
