#pragma once
#include <impact/material/hardening_curve.hpp>
#include <impact/material/hardening_power.hpp>
#include <impact/material/hardening_table.hpp>
#include <impact/material/hardening_voce.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>

/// The flow stress k_0(alpha) of a material at rest and at its reference temperature. A law is a struct
///   template <class T> static T stress(const MaterialParameters&, const T& alpha);    k_0
///   template <class T> static T potential(const MaterialParameters&, const T& alpha); H_0, H_0' = k_0
/// and nothing else: its slope comes by forward differentiation. Two things may be added: `curve` in the
/// place of `stress`, which gives the slope too, and `steep = false`, which says that k_0'(0) is not infinite
/// and saves some steps of the return.
namespace impact {

template <class Law, class T> Hardening<T> hardening(const MaterialParameters& m, const T& alpha) {
  if constexpr (requires { Law::curve(m, alpha); }) {
    return Law::curve(m, alpha);
  } else {
    using V = Value<T>;
    const V slope = Law::stress(m, seed<V, 1>(value(alpha), 0)).d[0];
    return {Law::stress(m, alpha), T(slope)};
  }
}

template <class Law> bool is_steep(const MaterialParameters& m) {
  if constexpr (requires { Law::steep(m); })
    return Law::steep(m);
  else if constexpr (requires { Law::steep; })
    return Law::steep;
  else
    return true;
}

/// A law from outside, compiled where its struct is known: MaterialParameters::own_hardening points to
/// hardening_functions<Law>. One call per point and step of the return, which the laws of the list do
/// without. The parameters are handed over by value: a kernel whose parameters an unknown function can reach
/// has to read all of them anew after the call, and is half as fast even where no such law is in use.
struct HardeningFunctions {
  Hardening<Batch> (*curve)(MaterialParameters, Batch alpha);
  Batch (*potential)(MaterialParameters, Batch alpha);
  bool steep;
};
template <class Law>
inline const HardeningFunctions hardening_functions = {
    [](MaterialParameters m, Batch alpha) { return hardening<Law>(m, alpha); },
    [](MaterialParameters m, Batch alpha) { return Law::potential(m, alpha); }, is_steep<Law>({})};

struct GivenHardening {
  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    const auto at = m.own_hardening->curve(m, broadcast(value(alpha)));
    const auto k = lanes_of<Value<T>>(at.k), dk = lanes_of<Value<T>>(at.dk);
    return {with_slope(alpha, k, dk), T(dk)};
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    const Batch x = broadcast(value(alpha));
    return with_slope(alpha, lanes_of<Value<T>>(m.own_hardening->potential(m, x)),
                      lanes_of<Value<T>>(m.own_hardening->curve(m, x).k));
  }
  static bool steep(const MaterialParameters& m) { return m.own_hardening->steep; }
};

/// The list of laws: calls f with the one that the parameters name.
template <class F> decltype(auto) with_hardening(const MaterialParameters& m, F&& f) {
  switch (m.hardening) {
  case HardeningKind::power:
    return f(PowerHardening{});
  case HardeningKind::table:
    return f(TableHardening{});
  case HardeningKind::own:
    return f(GivenHardening{});
  default:
    return f(VoceHardening{});
  }
}

struct MaterialHardening {
  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    return with_hardening(m, [&]<class Law>(Law) { return hardening<Law>(m, alpha); });
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    return with_hardening(m, [&]<class Law>(Law) { return Law::potential(m, alpha); });
  }
  static bool steep(const MaterialParameters& m) {
    return with_hardening(m, [&]<class Law>(Law) { return is_steep<Law>(m); });
  }
};

/// k_0 and its slope.
template <class T> Hardening<T> hardening(const MaterialParameters& m, const T& alpha) {
  return MaterialHardening::curve(m, alpha);
}

/// H_0(alpha) = int_0^alpha k_0.
template <class T> T plastic_potential(const MaterialParameters& m, const T& alpha) {
  return MaterialHardening::potential(m, alpha);
}

} // namespace impact
