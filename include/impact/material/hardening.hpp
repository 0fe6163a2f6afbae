#pragma once
#include <algorithm>
#include <cstddef>
#include <impact/material/parameters.hpp>
#include <impact/math/dual.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// The flow stress k_0(alpha) of a material at rest and at its reference temperature. A law is a struct
///   template <class T> static T stress(const MaterialParameters&, const T& alpha);    k_0
///   template <class T> static T potential(const MaterialParameters&, const T& alpha); H_0, H_0' = k_0
/// and nothing else: its slope comes by forward differentiation. Two things may be added: `curve` in the
/// place of `stress`, which gives the slope too, and `steep = false`, which says that k_0'(0) is not infinite
/// and saves some steps of the return.
namespace impact {

/// A flow stress and its slope along alpha. Where T carries derivatives, those of dk are not kept.
template <class T> struct Hardening { T k, dk; };

/// k_0 = sigma_y + r (1 - exp(-s alpha)) + H alpha and its potential, shifted so that H_0(0) = 0 (55').
struct VoceHardening {
  static constexpr bool steep = false;

  /// With the slope: the two share the exponential, and most runs spend their time here.
  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    if (m.voce_r == 0) return {T(m.sigma_y) + m.linear_h * alpha, T(m.linear_h)};
    const T e = exp((-m.voce_s) * alpha);
    return {T(m.sigma_y) + m.voce_r * (T(1.0) - e) + m.linear_h * alpha,
            (m.voce_r * m.voce_s) * e + T(m.linear_h)};
  }

  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    T h = m.sigma_y * alpha + (0.5 * m.linear_h) * (alpha * alpha);
    if (m.voce_r != 0) {
      const T x = m.voce_s * alpha;
      h = h + (m.voce_r / m.voce_s) * (x + exp((-m.voce_s) * alpha) - T(1.0));
    }
    return h;
  }
};

/// k_0 = sigma_y + b alpha^n, the strain factor of Johnson and Cook (Ludwik's law).
struct PowerHardening {
  template <class T> static T stress(const MaterialParameters& m, const T& alpha) {
    return T(m.sigma_y) + m.power_b * pow(alpha + T(tiny), m.power_n);
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    return m.sigma_y * alpha +
           (m.power_b / (1 + m.power_n)) * ((alpha + T(tiny)) * pow(alpha + T(tiny), m.power_n));
  }

  /// Lost in any alpha that matters; keeps the slope at alpha = 0 a number.
  static constexpr double tiny = 1e-300;
};

/// k_0 through given points (alpha, k), straight between them and constant after the last; the potential is
/// the exact integral.
struct HardeningTable {
  struct Piece {
    double alpha, k, slope, potential; ///< at its start
  };
  std::vector<Piece> pieces;

  /// Throws std::invalid_argument with the row that is wrong.
  explicit HardeningTable(const std::vector<std::pair<double, double>>& points) {
    const auto refuse = [](std::size_t row, const std::string& why) {
      throw std::invalid_argument("row " + std::to_string(row + 1) + ": " + why);
    };
    if (points.empty()) throw std::invalid_argument("no rows");
    if (points[0].first != 0) refuse(0, "the first alpha must be 0");
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto [alpha, k] = points[i];
      if (!(k > 0)) refuse(i, "the flow stress must be positive");
      if (i == 0) {
        pieces.push_back({alpha, k, 0, 0});
        continue;
      }
      Piece& last = pieces.back();
      const double length = alpha - last.alpha;
      if (!(length > 0)) refuse(i, "alpha must grow from row to row");
      last.slope = (k - last.k) / length;
      pieces.push_back({alpha, k, 0, last.potential + 0.5 * (last.k + k) * length});
    }
  }

  const Piece& at(double alpha) const {
    const auto after = std::upper_bound(pieces.begin(), pieces.end(), alpha,
                                        [](double x, const Piece& piece) { return x < piece.alpha; });
    return after == pieces.begin() ? *after : *(after - 1);
  }
};

struct TableHardening {
  static constexpr bool steep = false;

  template <class T> static Hardening<T> curve(const MaterialParameters& m, const T& alpha) {
    const Piece<Value<T>> p = piece(*m.table, value(alpha));
    return {T(p.k) + T(p.slope) * (alpha - T(p.alpha)), T(p.slope)};
  }
  template <class T> static T potential(const MaterialParameters& m, const T& alpha) {
    const Piece<Value<T>> p = piece(*m.table, value(alpha));
    const T x = alpha - T(p.alpha);
    return T(p.potential) + (T(p.k) + 0.5 * (T(p.slope) * x)) * x;
  }

private:
  template <class V> struct Piece { V alpha, k, slope, potential; };
  static Piece<double> piece(const HardeningTable& table, double alpha) {
    const HardeningTable::Piece& p = table.at(alpha);
    return {p.alpha, p.k, p.slope, p.potential};
  }
  static Piece<Batch> piece(const HardeningTable& table, const Batch& alpha) {
    Piece<Batch> all;
    for (int l = 0; l < lanes; ++l) {
      const HardeningTable::Piece& p = table.at(alpha[l]);
      all.alpha.set(l, p.alpha);
      all.k.set(l, p.k);
      all.slope.set(l, p.slope);
      all.potential.set(l, p.potential);
    }
    return all;
  }
};

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

/// k_0 and its slope.
template <class T> Hardening<T> hardening(const MaterialParameters& m, const T& alpha) {
  return with_hardening(m, [&]<class Law>(Law) { return hardening<Law>(m, alpha); });
}

/// H_0(alpha) = int_0^alpha k_0.
template <class T> T plastic_potential(const MaterialParameters& m, const T& alpha) {
  return with_hardening(m, [&]<class Law>(Law) { return Law::potential(m, alpha); });
}

inline bool is_steep(const MaterialParameters& m) {
  return with_hardening(m, [&]<class Law>(Law) { return is_steep<Law>(m); });
}

} // namespace impact
