#pragma once

/// How the ranks of a run share the cores of a machine. Work is divided among ranks alone, and whoever starts
/// a run need not know which libraries start threads of their own.
namespace impact {

/// Asks Open MPI to give the core away while a rank waits for another one, unless the user has chosen
/// (OMPI_MCA_mpi_yield_when_idle): a rank that spins takes the core from the one that it waits for as soon as
/// anything else runs on the machine. Before MPI starts; without effect on other MPI libraries.
void yield_while_waiting();

/// Holds OpenMP (SuperLU_DIST, CHOLMOD) and OpenBLAS to one thread in this process, unless the user has
/// chosen (OMP_NUM_THREADS, OPENBLAS_NUM_THREADS): two spinning threads for each rank on as many cores as
/// ranks wait at their barriers most of the time. To be called by the thread that will call the libraries.
void hold_to_one_thread();

/// Threads that the libraries of this rank may use.
int threads_per_rank();

} // namespace impact
