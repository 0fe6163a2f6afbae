#pragma once
#include <impact/material/cohesive.hpp>
#include <impact/math/dual.hpp>

/// Degradations of the energies at one point. A degradation law is a function object g(phi, alpha) of any
/// scalar with g(0) = 1, g(1) = 0 that says whether it is `convex` (its curvature is never
/// negative) and `ductile` (it looks at alpha); its derivatives with respect to phi are taken here, by dual
/// numbers. alpha is the plastic strain at the start of the step: a g that followed it within the step would
/// lower the yield stress by d_alpha g E+ (theory.md, E17). Every law keeps the residual stiffness k: g ->
/// (1-k) g + k.
namespace impact {

/// (1 - phi)^2: brittle fracture; damage begins with the load.
struct QuadraticDegradation {
  static constexpr bool convex = true, ductile = false;

  template <class T> T operator()(const T& phi, const T&) const {
    const T x = T(1.0) - phi;
    return x * x;
  }
};

/// (3 - s)(1 - phi)^2 - (2 - s)(1 - phi)^3, slope -s at phi = 0 (Borden et al. 2016): elastic until the
/// energy outweighs the crack's, then a sudden fall. Concave for phi below 1/2.
struct CubicDegradation {
  static constexpr bool convex = false, ductile = false;
  double s;

  template <class T> T operator()(const T& phi, const T&) const {
    const T x = T(1.0) - phi;
    return x * x * (T(3 - s) - (2 - s) * x);
  }
};

/// (1 - phi)^{2p}, p = alpha/alpha_c (Ambati, Gerasimov and De Lorenzis 2015): damage waits for plastic flow
/// and has the quadratic form where alpha reaches alpha_c.
///
/// With p < 1/2 it is concave and its slope grows without bound towards phi = 1, with p < 1 its curvature.
/// For x = 1 - phi below x_0 = 1e-3 it goes on as x_0^{2p} [(2 - 2p) x/x_0 + (2p - 1) (x/x_0)^2], which has
/// the same value and slope at x_0, still ends at 0, and is finite there and beyond. Nothing changes for
/// smaller phi: a floor p >= 1/2 would let elastic material damage.
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

template <class T> struct Degraded {
  T g, dg, d2g; ///< value, first and second derivative with respect to phi
};

/// Value and derivatives of a law.
template <class Law, class T>
Degraded<T> differentiated(const Law& law, const T& phi, const T& alpha, double residual_stiffness = 0) {
  using Slope = Dual<T, 1>;
  Dual<Slope, 1> x(seed<T, 1>(phi, 0));
  x.d[0] = Slope(T(1.0));
  const Dual<Slope, 1> g = law(x, Dual<Slope, 1>(Slope(alpha)));
  const double scale = 1 - residual_stiffness;
  return {scale * g.v.v + T(residual_stiffness), scale * g.v.d[0], scale * g.d[0].d[0]};
}

/// A law from outside, compiled where its struct is known: MaterialParameters::own_degradation points to
/// degradation_functions<Law>, whose Law is made without arguments.
struct DegradationFunctions {
  Degraded<Batch> (*at)(const Batch& phi, const Batch& alpha, double residual_stiffness);
  bool convex, ductile;
};
template <class Law>
inline const DegradationFunctions degradation_functions = {
    [](const Batch& phi, const Batch& alpha, double k) { return differentiated(Law{}, phi, alpha, k); },
    Law::convex, Law::ductile};

struct GivenDegradation {
  const DegradationFunctions& functions;
  bool convex = functions.convex, ductile = functions.ductile;
};
template <class T>
Degraded<T> differentiated(const GivenDegradation& law, const T& phi, const T& alpha,
                           double residual_stiffness) {
  const auto at = law.functions.at(broadcast(value(phi)), broadcast(value(alpha)), residual_stiffness);
  const auto g = lanes_of<Value<T>>(at.g), dg = lanes_of<Value<T>>(at.dg), d2g = lanes_of<Value<T>>(at.d2g);
  return {with_slope(phi, g, dg), with_slope(phi, dg, d2g), T(d2g)};
}

/// The list of laws: calls f with the one that the parameters name.
template <class F> decltype(auto) with_degradation(const DegradationParameters& m, F&& f) {
  switch (m.ge) {
  case Degradation::cubic:
    return f(CubicDegradation{m.cubic_s});
  case Degradation::ductile:
    return f(DuctileDegradation{m.alpha_c});
  case Degradation::linear:
  case Degradation::exponential:
  case Degradation::cornelissen:
  case Degradation::lorentz:
    return f(CohesiveDegradation{m.cohesive});
  case Degradation::own:
    return f(GivenDegradation{*m.own_degradation});
  default:
    return f(QuadraticDegradation{});
  }
}

/// Laws beside the quadratic one, kept out of line: the kernels pay no registers for what they seldom use.
/// Their parameters come by value, because a law from outside could reach all others of a material by
/// reference (hardening.hpp).
template <class T>
[[gnu::noinline]] Degraded<T> other_degradation(DegradationParameters m, const T& phi, const T& alpha) {
  return with_degradation(
      m, [&](const auto& law) { return differentiated(law, phi, alpha, m.residual_stiffness); });
}

/// g_e1: deviatoric part and tensile volume, or what the split calls E+.
template <class T> Degraded<T> degradation(const MaterialParameters& m, const T& phi, const T& alpha) {
  if (m.ge != Degradation::quadratic) return other_degradation(m, phi, alpha);
  return differentiated(QuadraticDegradation{}, phi, alpha, m.residual_stiffness);
}

/// Whether g depends on alpha, and whether its curvature is never negative.
inline bool is_ductile(const MaterialParameters& m) {
  return m.damage != Damage::none && with_degradation(m, [](const auto& law) { return law.ductile; });
}
inline bool is_convex(const MaterialParameters& m) {
  return with_degradation(m, [](const auto& law) { return law.convex; });
}

/// g_e1, g_e2 (of E-) and g_p (plastic potential) at one point.
template <class T> struct Degradations { Degraded<T> e1, e2, p; };

/// g_2' over g_1': how much of E- drives damage beside E+.
inline double compressed_share(const MaterialParameters& m) {
  return m.split == Split::none ? 1 : m.split == Split::star_convex ? -m.star_gamma : 0;
}

/// g_2 of g_1: 1, g_1, or of the star-convex split 1 + gamma* (1 - g_1).
template <class T> Degraded<T> compressed(const MaterialParameters& m, const Degraded<T>& e1) {
  if (m.split == Split::none) return e1;
  if (m.split != Split::star_convex) return {T(1.0), T(0.0), T(0.0)};
  const double gamma = m.star_gamma;
  return {T(1.0) + gamma * (T(1.0) - e1.g), -gamma * e1.dg, -gamma * e1.d2g};
}

template <class T> Degradations<T> degradations(const MaterialParameters& m, const T& phi, const T& alpha_n) {
  const Degraded<T> one{T(1.0), T(0.0), T(0.0)};
  if (m.damage == Damage::none) return {one, one, one};
  const Degraded<T> e1 = degradation(m, phi, alpha_n);
  return {e1, compressed(m, e1), m.gp == PlasticDegradation::ge ? e1 : one};
}

/// m = (g_2 - g_1)(1 - g_1), the part of g_2 that the integrator treats like a contact of crack faces
/// (49'''): none of it in sound material, nearly all of it in broken one. Without it compression is at most
/// twice as stiff as tension, g_2 - m <= 2 g_1, whatever phi.
template <class T> T unilateral_part(const Degradations<T>& g) {
  return (g.e2.g - g.e1.g) * (T(1.0) - g.e1.g);
}

} // namespace impact
