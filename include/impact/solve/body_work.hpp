#pragma once

namespace impact {

/// What a step does to the energy of rigid bodies, per unit thickness of plane problems.
struct BodyWork {
  double supports = 0; ///< by the reactions of prescribed motion
  double loss = 0;     ///< work of all forces less the change of the kinetic energy, from the kicks
  double kept = 0;     ///< what of it the integrator holds: -dt^2/8 (m a.a + T . J^-1 T)
  double exchange = 0; ///< what of it is neither held nor given back, of any sign
};

} // namespace impact
