#pragma once
#include <vector>

namespace impact {

/// What explicit sub-steps of damage keep; all [local node], ghosts consistent.
struct NodalRate {
  std::vector<std::vector<double>> volume; ///< int N_a dV_0 over the cells of each material, empty: no damage
  std::vector<double> volumes;             ///< of all of them
  std::vector<double> force, end_force;    ///< of the energy, at the start and the end of a sub-step
  std::vector<double> stiffness;           ///< row sums of the magnitudes of its derivative, at the start
  std::vector<double> capacity;            ///< force per rate, by lambda
  std::vector<double> added;               ///< to that, for a sub-step that is too long
  bool at_start = false;                   ///< the next rate is asked for where `force` was found
  double power = 0, held_back = 0; ///< of the forces that damage grows by, on this rank; of it by `added`
};

} // namespace impact
