#pragma once
#include <chrono>
#include <impact/balance/ledger.hpp>
#include <impact/run/observers.hpp>
#include <string>

/// What a run says on the terminal: the set-up, one line per accepted step with the estimated finish, the
/// summary.
namespace impact {

/// Mesh, groups, materials. Collective.
void report_setup(const Scenario& scenario, const Discretisation& discretisation);

/// A line for each solver, and the memory; `factors`: the motion is solved by factors, whose size is
/// estimated. Collective.
void report_solvers(const Discretisation& discretisation, const std::vector<std::string>& solvers,
                    bool factors);

class Progress {
public:
  Progress(MPI_Comm comm, double t_end);
  void header() const;
  void line(const Snapshot& at, const StepCounts& counts, const Ledger& ledger, int active_points);
  double wall() const;                      ///< seconds since construction
  static std::string clock(double seconds); ///< h:mm:ss or m:ss

private:
  MPI_Comm comm_;
  double t_end_;
  std::chrono::steady_clock::time_point start_;
  double first_time_ = -1;
};

} // namespace impact
