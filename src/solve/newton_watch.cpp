#include <algorithm>
#include <cmath>
#include <impact/solve/newton_watch.hpp>

namespace impact {

namespace {

bool alike(double a, double b, double part) { return std::abs(a - b) <= part * std::max(a, b); }

} // namespace

void NewtonWatch::start(bool full_steps) {
  full_steps_ = full_steps;
  unchanged_ = 0;
  norms_.clear();
}

void NewtonWatch::note(double norm) {
  // Far from the solution an active set that grows by a node at a time looks the same.
  const bool near = !norms_.empty() && norm < 1e-3 * norms_.front();
  const double last = norms_.empty() ? 0 : norms_.back();
  unchanged_ = norm < 1.1 * last && norm > last * (near ? 2. / 3 : 0.9) ? unchanged_ + 1 : 0;
  norms_.push_back(norm);
}

int NewtonWatch::cycle() const {
  constexpr std::size_t longest = 6, least_compared = 4;
  const std::size_t n = norms_.size();
  for (std::size_t period = 2; period <= longest; ++period) {
    const std::size_t compared = std::max(period, least_compared);
    if (n < period + compared) return 0;
    const auto last = norms_.end() - static_cast<std::ptrdiff_t>(compared);
    const bool repeats = std::equal(last, norms_.end(), last - static_cast<std::ptrdiff_t>(period),
                                    [](double a, double b) { return alike(a, b, 0.04); });
    const auto [low, high] =
        std::minmax_element(norms_.end() - static_cast<std::ptrdiff_t>(period), norms_.end());
    if (repeats && !alike(*low, *high, 0.1)) return static_cast<int>(period);
  }
  return 0;
}

} // namespace impact
