#pragma once
#include <type_traits>
#include <utility>

namespace impact {

/// f(constant 0), ..., f(constant n-1), so that the counter can be used in constant expressions.
template <int n, class F> inline void unroll(F&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) { (f(std::integral_constant<int, i>{}), ...); }
  (std::make_integer_sequence<int, n>{});
}

/// f(0) + ... + f(n-1), in this order. Always inlined: a kernel that is not rid of the closure early keeps
/// its tensors in memory.
template <int n, class F> [[gnu::always_inline]] inline auto sum(F&& f) {
  auto s = f(0);
  for (int i = 1; i < n; ++i) s += f(i);
  return s;
}

} // namespace impact
