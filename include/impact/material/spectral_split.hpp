#pragma once
#include <impact/material/elasticity.hpp>
#include <impact/material/principal_map.hpp>

/// The elastic energy split by principal stretches. With the elastic left strain e = b_e - 1 (not isochoric),
/// l(x) = x - ln(1 + x) >= 0 and w = J_e^(-2/3) the neo-Hookean energy is, exactly (49''),
///   W + U = V(J_e) + G/2 w sum_i l(e_i),   V = U - 3/2 G w l(1/w - 1),   V(1) = V'(1) = 0,
/// because sum_i ln(1 + e_i) = 2 ln J_e. Hence
///   E+ = [J_e >= 1] V + G/2 w sum_i l(<e_i>),   E- = [J_e < 1] V + G/2 w sum_i l(-<-e_i>),
/// with continuous stresses, since V' and l' vanish where the signs change. At small strains this is the
/// split of Miehe, Welschinger and Hofacker (2010), lambda/2 <+-tr eps>^2 + G sum <+-eps_i>^2. E+ vanishes
/// where no principal stretch exceeds 1. It is never negative if lambda = K - 2G/3 is not.
///
/// In a sheet, whose cracks run through it, the stretch across belongs to E- whatever its sign: else nothing
/// holds the thickness of what is broken and pressed, -(G/3) w l(e) of the pressed stretches stands against
/// stresses of E+ alone, and tau_33 = 0 has no root.
///
/// l'(e) (1 + e) = e: the stresses need no function of the eigenvalues, only the positive part of e itself,
/// whose derivative has divided differences of a piecewise linear function. Equal or nearly equal eigenvalues
/// lose nothing.
namespace impact {

/// <e>_+ = sum <e_i> n_i (x) n_i, and sum l over the positive and over the negative eigenvalues.
template <class V, int d> class TensileMap {
public:
  TensileMap(const MaterialParameters& m, const Symmetric<V, d>& e)
      : frame_(e), at_(no_parts<V, d>()), sheet_(m.sheet) {
    for (int i = 0; i < 3; ++i) {
      const V x = frame_.eigen.value[i], stretched = select((x > V(0.0)) & opens(i), x, V(0.0));
      at_.first += log1p_excess(stretched);
      at_.second += log1p_excess(V(x - stretched));
      frame_.add_dyad(i, i, stretched, at_.tensor);
    }
  }
  const PrincipalParts<V, d>& at() const { return at_; }

  PrincipalParts<V, d> derivative(const Symmetric<V, d>& de) const {
    PrincipalParts<V, d> r = no_parts<V, d>();
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        const V a = frame_.eigen.value[i], b = frame_.eigen.value[j];
        const V part = frame_.component(i, j, de);
        const auto a_opens = (a > V(0.0)) & opens(i);
        const V up = select(a_opens, a, V(0.0)) + select((b > V(0.0)) & opens(j), b, V(0.0)),
                all = abs(a) + abs(b);
        // (<a> - <b>)/(a - b): 1 or 0 for equal signs, else the positive one's share of |a| + |b|
        const V share = select(all > V(0.0), up / all, V(0.0));
        frame_.add_dyad(i, j, i == j ? share * part : V(2.0) * (share * part), r.tensor);
        if (i != j) continue;
        const V slope = part * (a / (V(1.0) + a));
        r.first += select(a_opens, slope, V(0.0));
        r.second += select(a_opens, V(0.0), slope);
      }
    return r;
  }

private:
  /// Whether a stretch along the axis is that of a crack: in a sheet not the third, which is that across it.
  auto opens(int axis) const { return V(axis == 2 && sheet_ ? 0.0 : 1.0) > V(0.0); }

  PrincipalFrame<V, d> frame_;
  PrincipalParts<V, d> at_;
  bool sheet_;
};

/// E+, E- and their Kirchhoff stresses, undegraded.
template <class T, int d> struct SplitEnergies {
  T plus, minus;
  Symmetric<T, d> tau_plus, tau_minus;
};

/// V(J_e) and dV/dln J_e.
template <class T> struct LameVolume { T w, V, slope; };
template <class T> LameVolume<T> lame_volume(const MaterialParameters& m, const T& dJ) {
  const T Je = T(1.0) + dJ, c = inverse_cbrt(Je), w = c * c;
  const T k = T(1.0) / c, x = dJ / (k * k + k + T(1.0)) * (k + T(1.0)); // J_e^(2/3) - 1
  return {w, volumetric_energy(m, dJ) - (1.5 * m.G) * (w * log1p_excess(x)),
          (0.5 * m.K) * (dJ * (Je + T(1.0))) - (2.0 / 3 * m.G) * ((dJ - log1p_excess(dJ)) * w)};
}

/// Of e = b_e - 1 and dJ = J_e - 1.
template <class T, int d>
SplitEnergies<T, d> spectral_energies(const MaterialParameters& m, const Symmetric<T, d>& e, const T& dJ) {
  const LameVolume<T> volume = lame_volume(m, dJ);
  const auto dilated = value(dJ) >= Value<T>(0.0);
  const PrincipalParts<T, d> part = Mapped<TensileMap, T, d>::at(m, e);
  const T zero = T(0.0), Gw = m.G * volume.w;
  SplitEnergies<T, d> s;
  s.plus = select(dilated, volume.V, zero) + 0.5 * (Gw * part.first);
  s.minus = select(dilated, zero, volume.V) + 0.5 * (Gw * part.second);
  s.tau_plus = Gw * part.tensor;
  s.tau_minus = Gw * (e - part.tensor);
  const T up = select(dilated, volume.slope, zero) - (1.0 / 3) * (Gw * part.first),
          down = select(dilated, zero, volume.slope) - (1.0 / 3) * (Gw * part.second);
  for (int i = 0; i < 3; ++i) {
    s.tau_plus[i] = s.tau_plus[i] + up;
    s.tau_minus[i] = s.tau_minus[i] + down;
  }
  return s;
}

/// g_1 tau_33+ + g_2 tau_33- of a sheet, against e_33 and J_e - 1: the stretches in its plane stay. `flat`:
/// of e without e_33.
template <class T, class V, int d>
T sheet_stress(const MaterialParameters& m, const PrincipalParts<V, d>& flat, const T& e_33, const T& dJ,
               const V& g_1, const V& g_2) {
  const LameVolume<T> volume = lame_volume(m, dJ);
  const T Gw = m.G * volume.w, across = e_33 - (1.0 / 3) * (T(flat.second) + log1p_excess(e_33));
  return T(select(value(dJ) >= V(0.0), g_1, g_2)) * volume.slope +
         Gw * (T(g_2) * across - T((1.0 / 3) * (g_1 * flat.first)));
}

} // namespace impact
