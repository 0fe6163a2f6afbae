# What impact::core links; read by our own build and by every project that finds the installed package.
# PETSc's pkg-config file names neither MPI nor HDF5. The C language target of FindMPI is found too, because
# HDF5 and PETSc are C libraries; only the C++ one is linked.
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C CXX)
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser)
find_package(LAPACK REQUIRED)
find_library(METIS_LIBRARY metis REQUIRED)
