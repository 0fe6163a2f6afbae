#include <algorithm>
#include <cmath>
#include <impact/problem/phi_passes.hpp>

namespace impact {

PhiPasses::Change PhiPasses::note(const std::vector<double>& start, const StateRow& phi) {
  PetscReal change_and_growth[2] = {0, 0};
  std::swap(change_before_, change_);
  change_.resize(phi.trial.size());
  for (std::size_t i = 0; i < phi.trial.size(); ++i) {
    change_[i] = phi.trial[i] - start[i];
    change_and_growth[0] = std::max(change_and_growth[0], std::abs(change_[i]));
    change_and_growth[1] = std::max(change_and_growth[1], phi.trial[i] - phi.committed[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, change_and_growth, 2, MPIU_REAL, MPIU_MAX, mesh_.comm());
  return {change_and_growth[0], change_and_growth[1]};
}

double PhiPasses::owned_dot(const std::vector<double>& a, const std::vector<double>& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (mesh_.owned(static_cast<int>(i))) sum += a[i] * b[i];
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPIU_REAL, MPIU_SUM, mesh_.comm());
  return sum;
}

void PhiPasses::relax(PetscInt pass, const StateRow& phi, std::vector<double>& start) {
  // The error of the passes falls by a nearly constant factor, 0.8 and more beside an open crack. Aitken's
  // extrapolation takes that factor from two changes; while the changes grow the crack runs, and is not
  // hurried.
  if (choice_ == PassRelaxation::none || pass < 3) {
    start = phi.trial;
    factor_ = 1;
    return;
  }
  const double before = owned_dot(change_before_, change_before_);
  const double mixed = owned_dot(change_before_, change_);
  const double now = owned_dot(change_, change_);
  const double curvature = before - 2 * mixed + now;
  constexpr double longest = 10;
  const double factor = curvature > 0 ? factor_ * (before - mixed) / curvature : 0;
  factor_ = now < before && factor > 1 ? std::min(factor, longest) : 1;
  for (std::size_t i = 0; i < start.size(); ++i)
    start[i] = std::clamp(start[i] + factor_ * change_[i], phi.committed[i], 1.0);
}

} // namespace impact
