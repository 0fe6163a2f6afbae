#include <array>
#include <gtest/gtest.h>
#include <impact/petsc/tally.hpp>
#include <petscsys.h>
#include <vector>

namespace impact {
namespace {

TEST(Tally, AddsAndComparesOverTheRanksInOneReduction) {
  int rank = 0, size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  std::vector<double> sums = {1, static_cast<double>(rank)}, none;
  std::array<double, 2> largest = {-1.0 - rank, static_cast<double>(rank)};
  double more = 0.5;
  Tally tally(PETSC_COMM_WORLD);
  tally.sum(sums);
  tally.largest(largest);
  tally.sum(none);
  tally.sum({&more, 1});
  const PetscLogDouble before = petsc_allreduce_ct, one = size > 1 ? 1 : 0; // on one rank nothing is counted
  tally.reduce();
  EXPECT_EQ(petsc_allreduce_ct - before, one);
  EXPECT_EQ(sums, (std::vector<double>{1.0 * size, size * (size - 1) / 2.0}));
  EXPECT_EQ(largest, (std::array<double, 2>{-1, size - 1.0}));
  EXPECT_EQ(more, 0.5 * size);
  tally.sum(sums);
  tally.forget();
  tally.reduce(); // nothing waits
  EXPECT_EQ(petsc_allreduce_ct - before, one);
  EXPECT_EQ(sums[0], size);
}

} // namespace
} // namespace impact
