#pragma once
#include <limits>

namespace impact {

/// Range of a number, in SI units; an open end excludes its bound.
struct Interval {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool open_low = false, open_high = false;
  bool contains(double value) const {
    return (open_low ? value > low : value >= low) && (open_high ? value < high : value <= high);
  }
};
inline constexpr double unbounded = std::numeric_limits<double>::infinity();
inline constexpr Interval any_number{};
inline constexpr Interval positive{0, unbounded, true, false};
inline constexpr Interval not_negative{0, unbounded, false, false};
inline constexpr Interval fraction{0, 1, false, false};

} // namespace impact
