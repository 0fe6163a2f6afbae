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

/// The law that the parameters name. A new one is a line in each function.
struct MaterialHardening {
  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    switch (m.hardening) {
    case HardeningKind::power:
      return hardening<PowerHardening>(m, alpha);
    case HardeningKind::table:
      return hardening<TableHardening>(m, alpha);
    default:
      return hardening<VoceHardening>(m, alpha);
    }
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    switch (m.hardening) {
    case HardeningKind::power:
      return PowerHardening::potential(m, alpha);
    case HardeningKind::table:
      return TableHardening::potential(m, alpha);
    default:
      return VoceHardening::potential(m, alpha);
    }
  }
  static bool steep(const MaterialParameters& m) { return m.hardening == HardeningKind::power; }
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
