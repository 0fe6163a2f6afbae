#pragma once
#include <impact/kernel/point_data.hpp>

/// What is asked of whole rows of histories, [group][batch][point][component][lane].
namespace impact {

/// Largest growth of alpha from one row to the other, at least 0.
inline double largest_growth(Frame frame, std::span<const double> from, std::span<const double> to) {
  const std::size_t alpha = static_cast<std::size_t>(symmetric_size(dimension(frame))) * lanes;
  double largest = 0;
  for (std::size_t i = alpha; i < to.size(); i += static_cast<std::size_t>(history_size(frame)) * lanes)
    for (std::size_t l = 0; l < lanes; ++l) largest = std::max(largest, to[i + l] - from[i + l]);
  return largest;
}

} // namespace impact
