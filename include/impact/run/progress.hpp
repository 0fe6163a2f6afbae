#pragma once
#include <chrono>
#include <impact/balance/ledger.hpp>
#include <impact/run/observers.hpp>
#include <string>

/// A line on the terminal for each accepted step, with the estimated finish.
namespace impact {

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
