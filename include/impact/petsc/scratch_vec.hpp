#pragma once
#include <impact/petsc/error.hpp>
#include <petscdm.h>

/// Global vectors of a DM that a step needs for a while: it finds those of the last step.
namespace impact {

/// With whatever is in it; the DM must outlive it. Collective.
class ScratchVec {
public:
  explicit ScratchVec(DM dm) : dm_(dm) { check(DMGetGlobalVector(dm, &vec_)); }
  ~ScratchVec() { static_cast<void>(DMRestoreGlobalVector(dm_, &vec_)); }
  ScratchVec(const ScratchVec&) = delete;
  ScratchVec& operator=(const ScratchVec&) = delete;
  operator Vec() const { return vec_; }

private:
  DM dm_;
  Vec vec_ = nullptr;
};

} // namespace impact
