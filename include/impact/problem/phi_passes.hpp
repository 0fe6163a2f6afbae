#pragma once
#include <impact/mesh/mesh.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/settings.hpp>
#include <vector>

/// phi over the staggered passes of one step: how much a pass changed it, and what the next one starts from.
namespace impact {

class PhiPasses {
public:
  struct Change {
    PetscReal of_pass = 0; ///< largest at a node against what the motion solve of the pass saw
    PetscReal growth = 0;  ///< largest at a node since the start of the step
  };

  PhiPasses(const Mesh& mesh, PassRelaxation choice) : mesh_(mesh), choice_(choice) {}

  /// Takes in what the damage solve of a pass made of `start`, the phi that its motion solve saw. Local
  /// arrays [node] with ghosts. Collective.
  Change note(const std::vector<double>& start, const StateRow& phi);
  /// Turns `start` into the phi that the next pass, number `pass`, starts from. Collective.
  void relax(PetscInt pass, const StateRow& phi, std::vector<double>& start);

private:
  double owned_dot(const std::vector<double>& a, const std::vector<double>& b) const;

  const Mesh& mesh_;
  PassRelaxation choice_;
  std::vector<double> change_, change_before_; // of the last two passes, by the damage solve
  double factor_ = 1;                          // of the last extrapolation
};

} // namespace impact
