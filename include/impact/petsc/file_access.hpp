#pragma once

/// How MPI opens the files that PETSc reads and writes through HDF5.
namespace impact {

/// Asks Open MPI for ROMIO in place of its own OMPIO, unless the user has chosen (OMPI_MCA_io). OMPIO guards
/// every file that it opens by a semaphore of the whole machine that is named after the file without its
/// folder: a process killed or aborted while it holds it blocks every later run of anybody that opens a file
/// of that name, such as checkpoint_000001.h5, for ever. Before MPI starts; without effect on other MPI
/// libraries.
void choose_file_access();

} // namespace impact
