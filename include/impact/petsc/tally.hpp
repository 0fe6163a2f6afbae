#pragma once
#include <mpi.h>
#include <span>
#include <vector>

namespace impact {

/// Numbers of several parts of a program that one reduction adds up and compares over the ranks.
class Tally {
public:
  explicit Tally(MPI_Comm comm) : comm_(comm) {}
  /// In the next `reduce` these become their sums, or their largest values, over the ranks; until then they
  /// stay where they are. All ranks have as many, in the same order.
  void sum(std::span<double> numbers) { sums_.push_back(numbers); }
  void largest(std::span<double> numbers) { largest_.push_back(numbers); }
  /// Collective: one reduction, none where nothing waits.
  void reduce();
  /// What waits is not wanted any more.
  void forget() {
    sums_.clear();
    largest_.clear();
  }

private:
  MPI_Comm comm_;
  std::vector<std::span<double>> sums_, largest_;
  std::vector<double> all_; // the number of sums, the sums, the largest values
};

} // namespace impact
