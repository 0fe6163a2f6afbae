#pragma once
#include <impact/math/dual.hpp>

/// (1 - phi)^{2p}, p = alpha/alpha_c (Ambati, Gerasimov and De Lorenzis 2015): damage waits for plastic flow
/// and has the quadratic form where alpha reaches alpha_c.
///
/// With p < 1/2 it is concave and its slope grows without bound towards phi = 1, with p < 1 its curvature.
/// For x = 1 - phi below x_0 = 1e-3 it goes on as x_0^{2p} [(2 - 2p) x/x_0 + (2p - 1) (x/x_0)^2], which has
/// the same value and slope at x_0, still ends at 0, and is finite there and beyond. Nothing changes for
/// smaller phi: a floor p >= 1/2 would let elastic material damage.
namespace impact {

struct DuctileDegradation {
  static constexpr bool convex = false, ductile = true;
  double alpha_c;

  template <class T> T operator()(const T& phi, const T& alpha) const {
    using V = Value<T>;
    const T x = T(1.0) - phi, p2 = (2 / alpha_c) * alpha;
    const auto singular = value(p2) < V(2.0);
    const T edge = select(singular, T(1e-3), T(1e-9)); // from p = 1 on only the logarithm needs one
    const auto inside = value(x) > value(edge);
    const T power = exp(p2 * log(select(inside, x, edge)));
    const T t = x / edge, q = select(singular, p2, T(2.0));
    return select(inside, power, power * (t * ((T(2.0) - q) + (q - T(1.0)) * t)));
  }
};

} // namespace impact
