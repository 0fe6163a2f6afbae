#pragma once
#include <cmath>
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
    // Only a step of Newton's method tells how near the root is: a bisection of decades may be tiny.
    const V newton = x - r / slope, step = abs(newton - x), close = V(tolerance) * abs(newton);
    // Where the slope falls by much across a kink Newton's method may go to and fro about the root for ever.
    const bool to_and_fro = it >= 12 && it % 3 == 0 && !noise;
    const auto inside = to_and_fro ? newton < newton : (newton >= low) & (newton <= high);
    V middle = V(0.5) * (low + high);
    if (noise) { // Newton's method in ln x meets a logarithm at once
      const V other = x * exp(-r / (slope * x));
      middle = select((other > low) & (other < high), other, sqrt(low * high));
    }
    const V enough = select(inside, close + (noise ? V(*noise / abs(slope)) : floor), close);
    x = select(open, select(inside, newton, select(step <= enough, x, middle)), x);
    open = open & (step > enough);
  }
  return {x, bits(open)};
}

/// One more Newton step in the differentiable type T from the converged value x: changes no value and carries
/// the derivative of the root with respect to everything that r_T depends on (implicit function theorem).
template <class T, class V> T differentiated_root(const V& x, const T& r_T, const V& slope) {
  return T(x) - r_T * T(V(1.0) / slope);
}

} // namespace impact
