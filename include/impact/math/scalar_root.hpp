#pragma once
#include <impact/math/dual.hpp>

/// Root of r(x) = 0 in [low, high] with r(low) >= 0 >= r(high), r decreasing: Newton on values, safeguarded
/// by bisection. r_and_slope(x, slope) returns r and sets its derivative. Lanes outside `active` keep
/// `start`. Where the slope of r varies by decades (low > 0 then) `noise` says how large its rounding errors
/// are: bisection is then of the exponent, and the smallest step worth taking that of the slope at hand.
namespace impact {

template <class V> struct ScalarRoot {
  V x;
  int failed; ///< bit mask of active lanes that did not converge
};

template <class V, class M, class F>
ScalarRoot<V> scalar_root(V start, V low, V high, M active, double tolerance, F&& r_and_slope,
                          const V* noise = nullptr) {
  // Near the start of flow r is round-off of its terms: x is then as good as it can be.
  const V floor = V(4e-15) * high;
  V x = start;
  M open = active;
  for (int it = 0; it < 60 && any(open); ++it) {
    V slope;
    const V r = r_and_slope(x, slope);
    low = select(r > V(0.0), x, low);
    high = select(r > V(0.0), high, x);
    V next = x - r / slope;
    next = select((next >= low) & (next <= high), next, noise ? sqrt(low * high) : V(V(0.5) * (low + high)));
    const V step = abs(next - x);
    x = select(open, next, x);
    open = open & (step > V(tolerance) * abs(next) + (noise ? V(*noise / abs(slope)) : floor));
  }
  return {x, bits(open)};
}

/// One more Newton step in the differentiable type T from the converged value x: changes no value and carries
/// the derivative of the root with respect to everything that r_T depends on (implicit function theorem).
template <class T, class V> T differentiated_root(const V& x, const T& r_T, const V& slope) {
  return T(x) - r_T * T(V(1.0) / slope);
}

} // namespace impact
