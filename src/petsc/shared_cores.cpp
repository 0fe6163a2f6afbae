#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <impact/petsc/shared_cores.hpp>
#include <initializer_list>

namespace impact {

namespace {

// The libraries come with PETSc or not at all: they are found by name where they are loaded.
template <class Function> Function* loaded(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

bool any_set(std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  });
}

} // namespace

void yield_while_waiting() {
  // A rank that is alone waits for no one, and would lose its core at every call of MPI.
  const char* const ranks = std::getenv("OMPI_COMM_WORLD_SIZE");
  if (ranks != nullptr && std::atoi(ranks) > 1) setenv("OMPI_MCA_mpi_yield_when_idle", "1", 0);
}

void hold_to_one_thread() {
  if (any_set({"OMP_NUM_THREADS"})) return; // OpenBLAS reads it too
  if (auto* set = loaded<void(int)>("omp_set_num_threads")) set(1);
  if (any_set({"OPENBLAS_NUM_THREADS", "GOTO_NUM_THREADS"})) return;
  if (auto* set = loaded<void(int)>("openblas_set_num_threads")) set(1);
}

int threads_per_rank() {
  int threads = 1;
  for (const char* name : {"omp_get_max_threads", "openblas_get_num_threads"})
    if (auto* get = loaded<int()>(name)) threads = std::max(threads, get());
  return threads;
}

} // namespace impact
