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
/// P in the same components, and the pressure p of the locking cure.
inline constexpr int stress_size(Frame f) { return gradient_size(f) + 1; }
inline constexpr int max_stress_size = 10;

} // namespace impact
