#include <algorithm>
#include <array>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/solve/phi_passes.hpp>
#include <utility>

namespace impact {

namespace {

constexpr int gains_of_a_run = 20;  // a step that converges seldom takes as many passes
constexpr double first_reach = 0.1; // of phi, by the first leap

} // namespace

void PhiPasses::begin() {
  largest_ = next_ = 0;
  record_ = -1; // the sum at the start of the step is not known yet
  gains_ = 0;
  runs_ = false;
  leap_ = {.change = {}, .reach = first_reach};
  said_ = MPI_Wtime();
}

PhiPasses::Change PhiPasses::note(const std::vector<double>& start, const StateRow& phi) {
  double change_and_growth[2] = {0, 0};
  std::swap(change_before_, change_);
  change_.resize(phi.trial.size());
  for (std::size_t i = 0; i < phi.trial.size(); ++i) {
    change_[i] = phi.trial[i] - start[i];
    change_and_growth[0] = std::max(change_and_growth[0], std::abs(change_[i]));
    change_and_growth[1] = std::max(change_and_growth[1], phi.trial[i] - phi.committed[i]);
  }
  max_over_ranks(mesh_.comm(), change_and_growth);
  const PetscReal before = std::exchange(largest_, change_and_growth[0]);
  next_ = before > 0 ? largest_ * std::min<PetscReal>(1, largest_ / before) : 0;
  // Each gain is one of a tolerance at least, and phi at most 1: their number has a limit.
  std::array<double, 2> sums = {owned_sum(phi.trial), owned_sum(phi.committed)};
  sum_over_ranks(mesh_.comm(), sums);
  const double sum = sums[0];
  record_ = std::max(record_, sums[1]);
  const bool gained = sum > record_ + settings_.atol;
  record_ = std::max(record_, sum);
  gains_ = gained ? gains_ + 1 : 0;
  runs_ = runs_ || (settings_.follow_cracks && gains_ >= gains_of_a_run);
  return {change_and_growth[0], change_and_growth[1], gained};
}

double PhiPasses::owned_sum(const std::vector<double>& a) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (mesh_.owned(static_cast<int>(i))) sum += a[i];
  return sum;
}

double PhiPasses::owned_dot(const std::vector<double>& a, const std::vector<double>& b) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (mesh_.owned(static_cast<int>(i))) sum += a[i] * b[i];
  return sum_over_ranks(mesh_.comm(), sum);
}

double PhiPasses::next_factor() {
  const double before = owned_dot(change_before_, change_before_);
  const double mixed = owned_dot(change_before_, change_);
  const double now = owned_dot(change_, change_);
  if (runs_) return leap(mixed / std::sqrt(before * now));
  // The error of the passes falls by a nearly constant factor, 0.8 and more beside an open crack. Aitken's
  // extrapolation takes that factor from two changes; while the changes grow it does not hurry.
  const double curvature = before - 2 * mixed + now;
  constexpr double longest = 10;
  const double factor = curvature > 0 ? factor_ * (before - mixed) / curvature : 0;
  return now < before && factor > 1 ? std::min(factor, longest) : 1;
}

// The front of a crack that runs is carried on by nearly the same change in pass after pass: a leap takes
// many of them at once. It enlarges what a plain pass would have brought to rest, so that the next one waits
// until two plain passes agree again; whether phi still wants to go its way there tells how long that may be.
double PhiPasses::leap(double cosine) {
  constexpr double alike = 0.9, longest = 30, farthest = 0.5;
  ++leap_.passes;
  if (leap_.passes == 2 && !leap_.change.empty())
    leap_.reach =
        owned_dot(leap_.change, change_) > 0 ? std::min(farthest, 2 * leap_.reach) : leap_.reach / 2;
  if (leap_.passes < 3 || !(cosine >= alike) || leap_.reach <= largest_) return 1;
  leap_.change = change_;
  leap_.passes = 0;
  return std::min(longest, leap_.reach / largest_);
}

void PhiPasses::relax(PetscInt pass, const StateRow& phi, std::vector<double>& start) {
  if (settings_.relaxation == PassRelaxation::none || pass < 3) {
    start = phi.trial;
    factor_ = 1;
    return;
  }
  factor_ = next_factor();
  for (std::size_t i = 0; i < start.size(); ++i) // without bounds the trial itself may lie beyond them
    start[i] = std::clamp(start[i] + factor_ * change_[i], std::min(phi.committed[i], phi.trial[i]),
                          std::max(1.0, phi.trial[i]));
}

// A thousandth leaves what linear solvers and ranks do differently far below the tolerance of phi at the end.
Aim PhiPasses::aim() const {
  if (next_ < settings_.atol) return Aim::balance;
  return runs_ && largest_ > 10 * settings_.atol ? Aim::tenth : Aim::thousandth;
}

// Diagonal of the box around the nodes that count as cracked: the length of a straight crack.
double PhiPasses::extent(const std::vector<double>& phi) const {
  const auto X = mesh_.coordinates();
  const auto dim = at(mesh_.dim());
  double ends[6]; // largest x, y, z and -x, -y, -z
  std::fill(ends, ends + 6, -HUGE_VAL);
  for (std::size_t i = 0; i < phi.size(); ++i)
    for (std::size_t k = 0; k < dim && phi[i] > settings_.crack_level; ++k) {
      ends[k] = std::max(ends[k], X[i * dim + k]);
      ends[3 + k] = std::max(ends[3 + k], -X[i * dim + k]);
    }
  max_over_ranks(mesh_.comm(), ends);
  double square = 0;
  for (std::size_t k = 0; k < dim; ++k)
    if (std::isfinite(ends[k])) square += (ends[k] + ends[3 + k]) * (ends[k] + ends[3 + k]);
  return std::sqrt(square);
}

std::string PhiPasses::crack_length(double extent) const {
  return text_of("phi > %.3g on %.4g %s", settings_.crack_level, extent, settings_.length_unit.c_str());
}

void PhiPasses::report(PetscInt pass, const StateRow& phi) {
  constexpr double pause = 10; // seconds
  if (!runs_) return;
  int due = MPI_Wtime() - said_ > pause;
  MPI_Bcast(&due, 1, MPI_INT, 0, mesh_.comm());
  if (!due) return;
  said_ = MPI_Wtime();
  check(PetscPrintf(mesh_.comm(), "impact: crack runs, pass %d, %s\n", static_cast<int>(pass),
                    crack_length(extent(phi.trial)).c_str()));
}

std::string PhiPasses::text(PetscInt passes, const StateTable& state) const {
  if (!runs_) return "";
  const StateRow& phi = state.row("phi");
  const double before = extent(phi.committed), now = extent(phi.trial);
  if (!(now > before)) return "";
  return "crack ran: " + crack_length(now) +
         text_of(", %.4g before; %d passes", before, static_cast<int>(passes));
}

} // namespace impact
