#include <algorithm>
#include <impact/petsc/preconditioner_reuse.hpp>

namespace impact {

PetscInt PreconditionerReuse::most(double decades) const {
  return static_cast<PetscInt>(std::max(1.0, rate_ * decades) + cost_ - spent_ + 1);
}

void PreconditionerReuse::note(PetscInt iterations, double decades) {
  if (!valid_) {
    rate_ = iterations / decades;
    spent_ = 0;
  } else {
    spent_ += iterations - std::max(1.0, rate_ * decades);
  }
  valid_ = spent_ < cost_;
}

} // namespace impact
