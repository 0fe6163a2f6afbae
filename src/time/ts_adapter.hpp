#pragma once

// The only door to PETSc's private TS header: a TS type or TSAdapt type cannot be written without it. What
// changed between versions is met here, so that the files that include this one read the same for all of
// them.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <petsc/private/tsimpl.h>
#pragma GCC diagnostic pop

#if PETSC_VERSION_LT(3, 18, 0)
#error "impact needs PETSc 3.18 or later"
#endif

namespace impact::detail {

// PetscOptionItems became a pointer in a later version; the slot of the operation knows which it is.
template <class Operation> struct LastArgument;
template <class First, class Last> struct LastArgument<PetscErrorCode (*)(First, Last)> {
  using type = Last;
};
using OptionItems = LastArgument<decltype(_TSOps::setfromoptions)>::type;

#if PETSC_VERSION_GE(3, 22, 0)
inline constexpr PetscInt unlimited = PETSC_UNLIMITED;
#else
inline constexpr PetscInt unlimited = -1;
#endif

} // namespace impact::detail
