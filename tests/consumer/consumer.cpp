// A project of its own that uses the installed package: a header from the dry half, an object from the
// library's archive, and PETSc, MPI, HDF5, METIS and muParser through the usage requirements of impact::core
// alone.
#include <cstdio>
#include <impact/math/batch.hpp>
#include <impact/petsc/error.hpp>
#include <metis.h>
#include <muParser.h>
#include <petscviewerhdf5.h>

int main(int argc, char** argv) {
  static_assert(sizeof(impact::Batch) == IMPACT_LANES * sizeof(double));
  impact::check(PetscInitialize(&argc, &argv, nullptr, nullptr));
  const bool agreed = impact::all_ranks_agree(PETSC_COMM_WORLD, true);
  PetscViewer file = nullptr;
  impact::check(PetscViewerHDF5Open(PETSC_COMM_WORLD, "consumer.h5", FILE_MODE_WRITE, &file));
  impact::check(PetscViewerDestroy(&file));
  mu::Parser parser;
  parser.SetExpr("6 * 7");
  const bool parsed = parser.Eval() == 42.0;
  idx_t metis_options[METIS_NOPTIONS];
  const bool partitioner = METIS_SetDefaultOptions(metis_options) == METIS_OK;
  impact::check(PetscFinalize());
  std::printf("impact::core with %d lanes: %s\n", IMPACT_LANES,
              agreed && parsed && partitioner ? "works" : "fails");
  return agreed && parsed && partitioner ? 0 : 1;
}
