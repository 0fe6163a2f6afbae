#pragma once
#include <impact/petsc/error.hpp>
#include <petscvec.h>

namespace impact {

/// Owned entries of a vector, opened for reading in a scope.
class Entries {
public:
  explicit Entries(Vec vec) : vec_(vec) { check(VecGetArrayRead(vec_, &values_)); }
  Entries(const Entries&) = delete;
  Entries& operator=(const Entries&) = delete;
  ~Entries() { VecRestoreArrayRead(vec_, &values_); }
  template <class Index> double operator[](Index i) const { return values_[i]; }

private:
  Vec vec_;
  const double* values_ = nullptr;
};

/// The same for writing.
class WritableEntries {
public:
  explicit WritableEntries(Vec vec) : vec_(vec) { check(VecGetArray(vec_, &values_)); }
  WritableEntries(const WritableEntries&) = delete;
  WritableEntries& operator=(const WritableEntries&) = delete;
  ~WritableEntries() { VecRestoreArray(vec_, &values_); }
  template <class Index> double& operator[](Index i) { return values_[i]; }

private:
  Vec vec_;
  double* values_ = nullptr;
};

} // namespace impact
