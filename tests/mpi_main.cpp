#include <gtest/gtest.h>
#include <impact/petsc/shared_cores.hpp>
#include <iostream>
#include <petscsys.h>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

namespace {

// The other ranks speak only when something failed there.
class FailurePrinter : public testing::EmptyTestEventListener {
public:
  explicit FailurePrinter(int rank) : rank_(rank) {}

private:
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (!result.failed()) return;
    std::cerr << "rank " << rank_ << ": " << (result.file_name() ? result.file_name() : "") << ":"
              << result.line_number() << ": " << result.summary() << std::endl;
  }

  int rank_;
};

} // namespace

/// Test program for several ranks: prints on rank 0, fails when a test failed on any rank.
int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  impact::yield_while_waiting();
  impact::hold_to_one_thread();
#ifdef __SANITIZE_ADDRESS__
  __lsan_disable(); // what MPI takes at its start and never gives back
#endif
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 1;
#ifdef __SANITIZE_ADDRESS__
  __lsan_enable();
#endif
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank != 0) {
    testing::TestEventListeners& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    delete listeners.Release(listeners.default_xml_generator());
    listeners.Append(new FailurePrinter(rank)); // gtest takes it over
  }
  int failed = RUN_ALL_TESTS();
  MPI_Allreduce(MPI_IN_PLACE, &failed, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
#ifdef __SANITIZE_ADDRESS__
  // Now, and not again at the end: MPI's libraries are still in place, and what they keep bears their names.
  __lsan_do_leak_check();
#endif
  return PetscFinalize() != 0 ? 1 : failed;
}
