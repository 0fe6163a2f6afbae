#pragma once
#include <impact/element/cells.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/material/point_law.hpp>
#include <type_traits>

/// Which terms of the law a kernel is compiled for.
namespace impact {

/// Which terms a law can have. The kernels are compiled for each, because a term that may be there costs
/// registers and chains of selections even where it is not.
/// `plain`: all, but for a flow stress that hangs on alpha alone, by the Voce law, and no equation of state.
/// `principal`: a split by principal stretches, and all but an equation of state.
enum class Terms { elastic, undamaged, plain, all, principal };

inline Terms terms_of(const PointLaw& law, const MotionInput& in) {
  const MaterialParameters& m = law.parameters;
  if (law.principal()) return Terms::principal;
  if (has_state(m) || m.hardening != HardeningKind::voce || !is_plain(m)) return Terms::all;
  const bool undamaged =
      m.damage == Damage::none && !law.viscous() && !in.has_bulk_viscosity() && (!in.theta || m.alpha_t == 0);
  if (!undamaged) return Terms::plain;
  return law.flows() || m.locking != Locking::none ? Terms::undamaged : Terms::elastic;
}

/// The same law and input with what is outside `terms` at its default: constants, by which the compiler finds
/// the branches that are never taken. The groups of parameters that the terms read are copied whole.
template <Terms terms> inline PointLaw restricted(const PointLaw& law) {
  PointLaw r;
  MaterialParameters& m = r.parameters;
  if constexpr (terms == Terms::elastic)
    static_cast<ElasticParameters&>(m) = law.parameters;
  else if constexpr (terms == Terms::undamaged) {
    static_cast<ElasticParameters&>(m) = law.parameters;
    static_cast<FlowParameters&>(m) = law.parameters;
  } else
    m = law.parameters;
  if constexpr (terms == Terms::undamaged || terms == Terms::plain) {
    m.hardening = HardeningKind::voce;
    m.softening = Softening::none;
    m.rate_c = m.failure_softening = 0;
  }
  if constexpr (terms != Terms::all) m.equation_of_state = EquationOfState::none;
  return r;
}
inline MotionInput restricted(MotionInput in, Terms terms) {
  if (terms == Terms::elastic || terms == Terms::undamaged || terms == Terms::plain) in.drive = nullptr;
  if (terms == Terms::elastic || terms == Terms::undamaged) in.phi = in.theta = in.u_n = in.warming = nullptr;
  return in;
}

/// Keeps results to the last digit: without it those of most runs differ by some 1e-15, and pressures in a
/// contact by 1e-10. Products and sums are contracted within one basic block, and what has to be cleaned up
/// in a scope makes the collection of bad lanes (note) end a block: the stress behind it rounds products that
/// the block before it uses too.
struct LastDigits {
  ~LastDigits() { asm volatile(""); }
};

/// Laws of which a call costs little beside what they compute: one body of code does for several kernels.
constexpr bool is_long(Terms terms) { return terms == Terms::all || terms == Terms::principal; }

/// The terms that are compiled for a cell: sheets, which find their thickness by the law, and cells of second
/// order, whose law is the smaller part of the work, have fewer.
template <class Cell, Frame frame> constexpr Terms compiled(Terms terms) {
  if (terms == Terms::principal) return terms;
  if (frame == Frame::plane_stress) return Terms::all;
  return is_second_order<Cell> && terms < Terms::plain ? Terms::plain : terms;
}

/// Calls f(constant) for the terms that are compiled for this law.
template <class Cell, Frame frame, class F> decltype(auto) with_terms(Terms terms, F&& f) {
  const auto call = [&]<Terms t>(std::integral_constant<Terms, t>) {
    return f(std::integral_constant<Terms, compiled<Cell, frame>(t)>{});
  };
  switch (terms) {
  case Terms::elastic:
    return call(std::integral_constant<Terms, Terms::elastic>{});
  case Terms::undamaged:
    return call(std::integral_constant<Terms, Terms::undamaged>{});
  case Terms::plain:
    return call(std::integral_constant<Terms, Terms::plain>{});
  case Terms::principal:
    return call(std::integral_constant<Terms, Terms::principal>{});
  case Terms::all:
    break;
  }
  return call(std::integral_constant<Terms, Terms::all>{});
}

} // namespace impact
