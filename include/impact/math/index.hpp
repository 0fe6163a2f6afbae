#pragma once
#include <concepts>
#include <cstddef>

namespace impact {

/// A number that counts as an index into a container.
template <std::integral Integer> constexpr std::size_t at(Integer i) { return static_cast<std::size_t>(i); }

} // namespace impact
