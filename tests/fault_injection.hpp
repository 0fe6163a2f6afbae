#pragma once
#include <impact/run/simulation.hpp>

/// Faults on demand, for the tests: part of the program impact_faulty (CMake option IMPACT_FAULT_INJECTION)
/// and of no other. The environment variable IMPACT_FAULT asks for one of
///   nan:<step>[:<rank>[:<tries>]]  one quadrature point of that rank becomes NaN in the first <tries> tries
///   (1)
///   domain:<step>:<k>  in the first try of that step the motion's residual has no value from its k-th
///   evaluation on
///   kill:<k>[:<part of a path>]    SIGKILL to itself at the k-th call that changes a file of that name
///   full:<k>[:<part of a path>]    such calls fail with "no space left on device" from the k-th on
/// The part of a path is "checkpoint_" unless given. Calls that change files are write, pwrite, ftruncate,
/// fsync and rename.
namespace impact {

/// The probe that injects what IMPACT_FAULT asks for; empty without it. After MPI is up.
StepProbe fault_probe();

} // namespace impact
