#pragma once
#include <impact/kernel/motion.hpp>
#include <type_traits>
#include <utility>

/// Which terms of the law a kernel is compiled for.
namespace impact {

/// Which terms a law can have. The kernels are compiled for each, because a term that may be there costs
/// registers and chains of selections even where it is not.
/// `plain`: all, but for a flow stress that hangs on alpha alone, by the Voce law.
enum class Terms { elastic, undamaged, plain, all, spectral };

inline Terms terms_of(const PointLaw& law, const MotionInput& in) {
  const MaterialParameters& m = law.parameters;
  if (m.hardening != HardeningKind::voce || !is_plain(m)) return Terms::all;
  const bool undamaged = m.damage == Damage::none && !law.viscous() && (!in.theta || m.alpha_t == 0);
  if (!undamaged) return law.spectral() ? Terms::spectral : Terms::plain;
  return law.flows() || m.locking != Locking::none ? Terms::undamaged : Terms::elastic;
}

/// The same law and input with everything outside `terms` left at its default: constants, by which the
/// compiler finds the branches that are never taken. Text and tables are left out with them: what holds a
/// pointer to memory of its own is read anew after every store.
inline PointLaw restricted(const PointLaw& law, Terms terms) {
  if (terms == Terms::all || terms == Terms::spectral) return law;
  const MaterialParameters& m = law.parameters;
  PointLaw r;
  if (terms == Terms::plain) {
    static_cast<MaterialNumbers&>(r.parameters) = m;
    r.parameters.hardening = HardeningKind::voce;
    r.parameters.softening = Softening::none;
    r.parameters.rate_c = 0;
    return r;
  }
  r.parameters.K = m.K;
  r.parameters.G = m.G;
  r.parameters.rho = m.rho;
  if (terms == Terms::elastic) return r;
  r.parameters.model = m.model;
  r.parameters.sigma_y = m.sigma_y;
  r.parameters.voce_r = m.voce_r;
  r.parameters.voce_s = m.voce_s;
  r.parameters.linear_h = m.linear_h;
  r.parameters.taylor_quinney = m.taylor_quinney;
  r.parameters.locking = m.locking;
  return r;
}
inline MotionInput restricted(MotionInput in, Terms terms) {
  if (terms != Terms::all) in.drive = nullptr;
  if (terms == Terms::elastic || terms == Terms::undamaged) in.phi = in.theta = in.u_n = nullptr;
  return in;
}

/// Calls f(constant) for the terms of this law.
template <class F> decltype(auto) with_terms(Terms terms, F&& f) {
  switch (terms) {
  case Terms::elastic:
    return f(std::integral_constant<Terms, Terms::elastic>{});
  case Terms::undamaged:
    return f(std::integral_constant<Terms, Terms::undamaged>{});
  case Terms::spectral:
    return f(std::integral_constant<Terms, Terms::spectral>{});
  case Terms::plain:
    return f(std::integral_constant<Terms, Terms::plain>{});
  default:
    return f(std::integral_constant<Terms, Terms::all>{});
  }
}

/// The same; sheets have one kernel for all laws.
template <Frame frame, class F> decltype(auto) with_terms(Terms terms, F&& f) {
  if constexpr (frame == Frame::plane_stress)
    return f(std::integral_constant<Terms, Terms::all>{});
  else
    return with_terms(terms, std::forward<F>(f));
}

} // namespace impact
