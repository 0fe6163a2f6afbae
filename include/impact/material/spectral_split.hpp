#pragma once
#include <complex>
#include <impact/material/elasticity.hpp>
#include <impact/math/eigen.hpp>

/// The elastic energy split by principal stretches. With the elastic left strain e = b_e - 1 (not isochoric),
/// l(x) = x - ln(1 + x) >= 0 and w = J_e^(-2/3) the neo-Hookean energy is, exactly (49''),
///   W + U = V(J_e) + G/2 w sum_i l(e_i),   V = U - 3/2 G w l(1/w - 1),   V(1) = V'(1) = 0,
/// because sum_i ln(1 + e_i) = 2 ln J_e. Hence
///   E+ = [J_e >= 1] V + G/2 w sum_i l(<e_i>),   E- = [J_e < 1] V + G/2 w sum_i l(-<-e_i>),
/// with continuous stresses, since V' and l' vanish where the signs change. At small strains this is the
/// split of Miehe, Welschinger and Hofacker (2010), lambda/2 <+-tr eps>^2 + G sum <+-eps_i>^2. E+ vanishes
/// where no principal stretch exceeds 1. It is never negative if lambda = K - 2G/3 is not.
///
/// l'(e) (1 + e) = e: the stresses need no function of the eigenvalues, only the positive part of e itself,
/// whose derivative has divided differences of a piecewise linear function. Equal or nearly equal eigenvalues
/// lose nothing.
namespace impact {

/// <e>_+ = sum <e_i> n_i (x) n_i, and sum l over the positive and over the negative eigenvalues.
template <class T, int d> struct TensilePart {
  Symmetric<T, d> positive;
  T excess, deficit;
};

/// The tensile part of a tensor of values and its derivative along any other.
template <class V, int d> class TensileMap {
public:
  explicit TensileMap(const Symmetric<V, d>& e) : eigen_(eigen_system(e)) {
    V stretched[3];
    at_.excess = at_.deficit = V(0.0);
    for (int i = 0; i < 3; ++i) {
      const V x = eigen_.value[i];
      stretched[i] = select(x > V(0.0), x, V(0.0));
      at_.excess += log1p_excess(stretched[i]);
      at_.deficit += log1p_excess(V(x - stretched[i]));
    }
    for (int k = 0; k < symmetric_size(d); ++k) at_.positive[k] = V(0.0);
    for (int i = 0; i < 3; ++i) add_dyad(i, i, stretched[i], at_.positive);
  }
  const TensilePart<V, d>& at() const { return at_; }

  TensilePart<V, d> derivative(const Symmetric<V, d>& de) const {
    TensilePart<V, d> r;
    r.excess = r.deficit = V(0.0);
    for (int k = 0; k < symmetric_size(d); ++k) r.positive[k] = V(0.0);
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        const V a = eigen_.value[i], b = eigen_.value[j];
        const V part = component(i, j, de);
        const V up = select(a > V(0.0), a, V(0.0)) + select(b > V(0.0), b, V(0.0)), all = abs(a) + abs(b);
        // (<a> - <b>)/(a - b): 1 or 0 for equal signs, else the positive one's share of |a| + |b|
        const V share = select(all > V(0.0), up / all, V(0.0));
        add_dyad(i, j, i == j ? share * part : V(2.0) * (share * part), r.positive);
        if (i != j) continue;
        const V slope = part * (a / (V(1.0) + a));
        r.excess += select(a > V(0.0), slope, V(0.0));
        r.deficit += select(a > V(0.0), V(0.0), slope);
      }
    return r;
  }

private:
  V component(int i, int j, const Symmetric<V, d>& a) const {
    V s = V(0.0);
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        if (const int kl = symmetric_index(d, k, l); kl >= 0)
          s += eigen_.vector[i][k] * (a[kl] * eigen_.vector[j][l]);
    return s;
  }
  /// a += s sym(n_i (x) n_j)
  void add_dyad(int i, int j, const V& s, Symmetric<V, d>& a) const {
    for (int k = 0; k < 3; ++k)
      for (int l = k; l < 3; ++l)
        if (const int kl = symmetric_index(d, k, l); kl >= 0)
          a[kl] += (0.5 * s) *
                   (eigen_.vector[i][k] * eigen_.vector[j][l] + eigen_.vector[j][k] * eigen_.vector[i][l]);
  }
  EigenSystem<V> eigen_;
  TensilePart<V, d> at_;
};

template <class V, int d> TensilePart<V, d> tensile_part(const Symmetric<V, d>& e) {
  return TensileMap<V, d>(e).at();
}
template <class V, int n, int d> TensilePart<Dual<V, n>, d> tensile_part(const Symmetric<Dual<V, n>, d>& e) {
  Symmetric<V, d> values;
  for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].v;
  const TensileMap<V, d> map(values);
  TensilePart<Dual<V, n>, d> r;
  for (int k = 0; k < symmetric_size(d); ++k) r.positive[k].v = map.at().positive[k];
  r.excess.v = map.at().excess;
  r.deficit.v = map.at().deficit;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].d[i];
    const TensilePart<V, d> slope = map.derivative(values);
    for (int k = 0; k < symmetric_size(d); ++k) r.positive[k].d[i] = slope.positive[k];
    r.excess.d[i] = slope.excess;
    r.deficit.d[i] = slope.deficit;
  }
  return r;
}
template <int d>
TensilePart<std::complex<double>, d> tensile_part(const Symmetric<std::complex<double>, d>& e) {
  Symmetric<double, d> values, step;
  for (int k = 0; k < symmetric_size(d); ++k) values[k] = e[k].real(), step[k] = e[k].imag();
  const TensileMap<double, d> map(values);
  const TensilePart<double, d> slope = map.derivative(step);
  TensilePart<std::complex<double>, d> r;
  for (int k = 0; k < symmetric_size(d); ++k) r.positive[k] = {map.at().positive[k], slope.positive[k]};
  r.excess = {map.at().excess, slope.excess};
  r.deficit = {map.at().deficit, slope.deficit};
  return r;
}

/// E+, E- and their Kirchhoff stresses, undegraded.
template <class T, int d> struct SpectralSplit {
  T plus, minus;
  Symmetric<T, d> tau_plus, tau_minus;
};

/// left = F F^T - 1 of a body that has not flowed.
template <class T, int d>
SpectralSplit<T, d> spectral_split(const MaterialParameters& m, const Symmetric<T, d>& left,
                                   const T& J_minus_1, const T& J_th) {
  const T r = inverse_cbrt(J_th), inverse_th = r * r;
  Symmetric<T, d> e = inverse_th * left;
  for (int i = 0; i < 3; ++i) e[i] = e[i] + (inverse_th - T(1.0));
  const T dJ = (J_minus_1 - (J_th - T(1.0))) / J_th, Je = T(1.0) + dJ, c = inverse_cbrt(Je), w = c * c;
  const T k = T(1.0) / c, x = dJ / (k * k + k + T(1.0)) * (k + T(1.0)); // J_e^(2/3) - 1
  const T V = volumetric_energy(m, dJ) - (1.5 * m.G) * (w * log1p_excess(x));
  const T slope =
      (0.5 * m.K) * (dJ * (Je + T(1.0))) - (2.0 / 3 * m.G) * ((dJ - log1p_excess(dJ)) * w); // dV/dln J
  const auto dilated = value(dJ) >= Value<T>(0.0);
  const TensilePart<T, d> part = tensile_part(e);
  const T zero = T(0.0), Gw = m.G * w;
  SpectralSplit<T, d> s;
  s.plus = select(dilated, V, zero) + 0.5 * (Gw * part.excess);
  s.minus = select(dilated, zero, V) + 0.5 * (Gw * part.deficit);
  s.tau_plus = Gw * part.positive;
  s.tau_minus = Gw * (e - part.positive);
  const T up = select(dilated, slope, zero) - (1.0 / 3) * (Gw * part.excess),
          down = select(dilated, zero, slope) - (1.0 / 3) * (Gw * part.deficit);
  for (int i = 0; i < 3; ++i) {
    s.tau_plus[i] = s.tau_plus[i] + up;
    s.tau_minus[i] = s.tau_minus[i] + down;
  }
  return s;
}

} // namespace impact
