#pragma once
#include <type_traits>
#include <utility>

namespace impact {

/// f(constant 0), ..., f(constant n-1), so that the counter can be used in constant expressions.
template <int n, class F> inline void unroll(F&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) { (f(std::integral_constant<int, i>{}), ...); }
  (std::make_integer_sequence<int, n>{});
}

} // namespace impact
