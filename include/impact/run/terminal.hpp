#pragma once
#include <impact/run/snapshot.hpp>
#include <impact/run/stage.hpp>

/// What a run prints of itself: the head of the log before its first step, and a line for each step.
namespace impact {

/// Mesh, groups, materials. Collective.
void report_setup(const Scenario& scenario, const Discretisation& discretisation);

/// Where contact begins, which solvers work, and the memory, with an estimate of the factors of the motion.
/// Collective.
void report_solvers(RunStage& stage);
/// An overlap at the start that a run with inertia leaves as it is, by the smallest `gap`.
void tell_of_overlap(RunStage& stage, const ContactInterface& contact, double gap);

/// A line for each accepted step, with the estimated finish.
class Progress {
public:
  Progress(MPI_Comm comm, double t_end) : comm_(comm), t_end_(t_end), start_(MPI_Wtime()) {}
  void header() const;
  void line(const Snapshot& at, const StepCounts& counts, const Ledger& ledger, int active_points);
  double wall() const { return MPI_Wtime() - start_; } ///< seconds since construction
  static std::string clock(double seconds);            ///< h:mm:ss or m:ss

private:
  MPI_Comm comm_;
  double t_end_;
  double start_, first_time_ = -1;
};

} // namespace impact
