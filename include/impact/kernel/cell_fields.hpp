#pragma once
#include <impact/kernel/point_data.hpp>

namespace impact {

/// What a nodal temperature belongs to, at a point: J - 1 of the locking cure, and dp/dJ beyond it of a body
/// in which no heat flows, less that at the temperature (45a); and what of its heat it does not show.
struct Warming {
  Batch volume, slope;
  Batch pressure; ///< of that heat, -beta/c_eff times it
  Batch heat;     ///< per volume
};
inline constexpr int warming_size = sizeof(Warming) / sizeof(Batch);
inline Warming& warming_at(Batch* warming, int q) { return reinterpret_cast<Warming*>(warming)[q]; }
inline const Warming& warming_at(const Batch* warming, int q) {
  return reinterpret_cast<const Warming*>(warming)[q];
}

/// Fields of a batch at the end of a step and (_n) at its start: [node][component] of nodal ones,
/// [point][component] of those of points. Null pointers stand for zero, theta_0 and a virgin history. A
/// kernel reads what its equation asks for.
struct CellFields {
  const Batch* X = nullptr;                             ///< [dim] reference coordinates
  const Batch *u = nullptr, *u_n = nullptr;             ///< [dim] displacement
  const Batch *phi = nullptr, *phi_n = nullptr;         ///< damage
  const Batch *theta = nullptr, *theta_n = nullptr;     ///< temperature
  const Batch *history = nullptr, *history_n = nullptr; ///< [history_size]; null for Model::elastic
  const Batch *drive = nullptr, *drive_n = nullptr;     ///< [drive_size]
  const Batch *fatigue = nullptr, *fatigue_n = nullptr; ///< Fat
  const Batch *patch = nullptr,
              *patch_n = nullptr; ///< J - 1 that the patch of the cell shares; null: its own
  /// [2] mean p and dp/dJ of that patch, or for a tangent of SoftVolume; null: those of the cell
  const Batch* patch_pressure = nullptr;
  double dt = 1;
  Batch mass_factor = Batch(1.0); ///< mass in use over rho dV, in energies and stable steps
};

} // namespace impact
