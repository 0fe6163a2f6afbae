#pragma once
#include <impact/mesh/mesh.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/force_balance.hpp>
#include <impact/problem/settings.hpp>
#include <string>
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

  /// Both must outlive the object.
  PhiPasses(const Mesh& mesh, const CouplingScenario& settings) : mesh_(mesh), settings_(settings) {}

  /// Forgets the passes of the attempt before.
  void begin();
  /// Takes in what the damage solve of a pass made of `start`, the phi that its motion solve saw. Local
  /// arrays [node] with ghosts. Collective.
  Change note(const std::vector<double>& start, const StateRow& phi);
  /// Turns `start` into the phi that the next pass, number `pass`, starts from. Collective.
  void relax(PetscInt pass, const StateRow& phi, std::vector<double>& start);

  /// How far the next motion solve goes: all the way, unless it will change phi so much that another
  /// pass follows.
  Aim aim() const;
  /// Says at times how far a crack ran that is followed: a step of many passes must not look like one that
  /// hangs. Collective.
  void report(PetscInt pass, const StateRow& phi);
  /// How far it ran in the whole attempt; empty where none did. Collective.
  std::string text(PetscInt passes, const StateTable& state) const;

private:
  double owned_sum(const std::vector<double>& a) const; // of this rank
  double owned_dot(const std::vector<double>& a, const std::vector<double>& b) const;
  double next_factor();
  double leap(double cosine);
  double extent(const std::vector<double>& phi) const;
  std::string crack_length(double extent) const;

  const Mesh& mesh_;
  const CouplingScenario& settings_;
  std::vector<double> change_, change_before_; // of the last two passes, by the damage solve
  PetscReal largest_ = 0, next_ = 0;           // of the last one, and what two of them let expect
  double factor_ = 1;                          // of the last extrapolation
  double record_ = 0;                          // largest sum of phi so far
  int gains_ = 0;                              // passes in a row with a new one
  bool runs_ = false;                          // phi grew in one pass after the other, and is followed
  struct Leap {
    std::vector<double> change; // that the last one enlarged
    double reach = 0;           // by how much the next one may change phi
    int passes = 0;             // since the last one
  } leap_;
  double said_ = 0; // wall time of the last report
};

} // namespace impact
