#pragma once
#include <impact/mesh/mesh.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/settings.hpp>
#include <vector>

/// phi over the staggered passes of one step: how much a pass changed it, whether a crack runs, and what the
/// next pass starts from (theory.md, section 10).
namespace impact {

class PhiPasses {
public:
  struct Change {
    PetscReal of_pass = 0; ///< largest at a node against what the motion solve of the pass saw
    PetscReal growth = 0;  ///< largest at a node since the start of the step
    bool gained = false;   ///< the sum over the nodes is larger than after any pass before
  };

  /// `follow_cracks`: passes have no limit while phi grows, and hurry.
  PhiPasses(const Mesh& mesh, PassRelaxation choice, double tolerance, bool follow_cracks)
      : mesh_(mesh), choice_(choice), tolerance_(tolerance), follow_cracks_(follow_cracks) {}

  /// Forgets the passes of the attempt before. Collective.
  void begin(const StateRow& phi);
  /// Takes in what the damage solve of a pass made of `start`, the phi that its motion solve saw. Local
  /// arrays [node] with ghosts. Collective.
  Change note(const std::vector<double>& start, const StateRow& phi);
  /// Turns `start` into the phi that the next pass, number `pass`, starts from. Collective.
  void relax(PetscInt pass, const StateRow& phi, std::vector<double>& start);

  /// phi has grown in one pass after the other of this attempt, and its cracks are followed.
  bool crack_runs() const { return runs_; }
  /// A crack runs and the last pass moved it on so far that the next motion solve may be rough.
  bool far_from_rest() const;
  /// Diagonal of the box around the nodes with a phi above `level`: the length of a straight crack.
  /// Collective.
  double extent(const std::vector<double>& phi, double level) const;

private:
  double owned_sum(const std::vector<double>& a) const;
  double owned_dot(const std::vector<double>& a, const std::vector<double>& b) const;
  double next_factor();
  double leap(double cosine);

  const Mesh& mesh_;
  PassRelaxation choice_;
  double tolerance_; // of phi between passes
  bool follow_cracks_;
  std::vector<double> change_, change_before_; // of the last two passes, by the damage solve
  PetscReal largest_ = 0;                      // of the last one
  double factor_ = 1;                          // of the last extrapolation
  double record_ = 0;                          // largest sum of phi so far
  int gains_ = 0;                              // passes in a row with a new one
  bool runs_ = false;
  std::vector<double> leap_; // the change that the last leap enlarged
  double reach_ = 0;         // by how much the next one may change phi
  int since_leap_ = 0;       // passes
};

} // namespace impact
