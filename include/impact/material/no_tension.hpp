#pragma once
#include <impact/material/spectral_split.hpp>
#include <impact/math/scalar_root.hpp>

/// A body without tensile strength (F. Freddi, G. Royer-Carfagni, J. Mech. Phys. Solids 58 (2010) 1154), at
/// finite strains: what a broken point stores is the least energy that it can have when its cracks open as
/// they like, which takes from each principal elastic stretch what it has too much,
///   E-(x_1, x_2, x_3) = min over y_i <= x_i of (W + U)(y_1, y_2, y_3),   x_i = ln of a stretch   (50'')
/// with the stresses tau_i <= 0, and 0 where y_i < x_i. E+ = W + U - E- >= 0. With x_1 >= x_2 >= x_3 either
/// all are pressed, or tau_1 = 0 (pressed in a plane), or tau_1 = tau_2 = 0 (in a line), or E- = 0. By the
/// envelope theorem tau- is the derivative of E-, its slope that of a body with the free stretches condensed.
namespace impact {

/// tau- = sum tau_i n_i (x) n_i, E- and E+.
template <class V, int d> class ClosedMap {
public:
  ClosedMap(const MaterialParameters& m, const Symmetric<V, d>& e) : frame_(e), at_(no_parts<V, d>()) {
    sort();
    for (int i = 0; i < 3; ++i) kept_[i] = trial_[i] = frame_.eigen.value[i];
    relax(m);
    const Hessian H = hessian(m, kept_);
    for (int i = 0; i < 3; ++i) {
      tau_[i] = select(gone_[i], V(0.0), stress(m, kept_, i));
      frame_.add_dyad(i, i, tau_[i], at_.tensor);
    }
    condense(H);
    at_.first = energy(m, kept_);
    at_.second = max(V(energy(m, trial_) - at_.first), V(0.0)); // negative of rounding alone
    for (int i = 0; i < 3; ++i) lost_[i] = stress(m, trial_, i) - tau_[i];
  }
  const PrincipalParts<V, d>& at() const { return at_; }

  PrincipalParts<V, d> derivative(const Symmetric<V, d>& de) const {
    PrincipalParts<V, d> r = no_parts<V, d>();
    V dx[3];
    for (int i = 0; i < 3; ++i) {
      dx[i] = frame_.component(i, i, de) / (2.0 * (V(1.0) + trial_[i]));
      r.first += tau_[i] * dx[i];
      r.second += lost_[i] * dx[i];
    }
    for (int i = 0; i < 3; ++i) {
      frame_.add_dyad(i, i, sum<3>([&](int j) { return slope_[i][j] * dx[j]; }), r.tensor);
      for (int j = i + 1; j < 3; ++j) {
        const V gap = trial_[i] - trial_[j], size = abs(trial_[i]) + abs(trial_[j]);
        const auto apart = gap > V(1e-7) * size;
        const V limit = (slope_[i][i] - slope_[i][j] + slope_[j][j] - slope_[j][i]) /
                        (2.0 * (V(2.0) + trial_[i] + trial_[j]));
        const V ratio = select(apart, (tau_[i] - tau_[j]) / select(apart, gap, V(1.0)), limit);
        frame_.add_dyad(i, j, V(2.0) * (ratio * frame_.component(i, j, de)), r.tensor);
      }
    }
    return r;
  }

private:
  using Flag = decltype(V() > V());
  struct Hessian {
    V at[3][3];
  };

  void sort() {
    const auto order = [&](int i, int j) {
      const auto swap = frame_.eigen.value[i] < frame_.eigen.value[j];
      const auto exchange = [&](V& a, V& b) {
        const V first = select(swap, b, a);
        b = select(swap, a, b);
        a = first;
      };
      exchange(frame_.eigen.value[i], frame_.eigen.value[j]);
      for (int k = 0; k < 3; ++k) exchange(frame_.eigen.vector[i][k], frame_.eigen.vector[j][k]);
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
  }
  /// J_e^2 - 1.
  static V volume(const V (&e)[3]) {
    const V plane = e[0] + e[1] + e[0] * e[1];
    return plane + e[2] + plane * e[2];
  }
  static V stress(const MaterialParameters& m, const V (&e)[3], int i) {
    const V dJ2 = volume(e), w = inverse_cbrt(V(V(1.0) + dJ2));
    return m.G * (w * (e[i] - (1.0 / 3) * (e[0] + e[1] + e[2]))) + (0.5 * m.K) * dJ2;
  }
  /// W + U.
  static V energy(const MaterialParameters& m, const V (&e)[3]) {
    const V dJ2 = volume(e);
    const LameVolume<V> of = lame_volume(m, V(dJ2 / (V(1.0) + sqrt(V(1.0) + dJ2))));
    return of.V + 0.5 * (m.G * (of.w * (log1p_excess(e[0]) + log1p_excess(e[1]) + log1p_excess(e[2]))));
  }
  /// d tau_i / dx_j
  static Hessian hessian(const MaterialParameters& m, const V (&e)[3]) {
    const V J2 = V(1.0) + volume(e), Gw = m.G * inverse_cbrt(J2), mean = (1.0 / 3) * (e[0] + e[1] + e[2]);
    Hessian H;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        H.at[i][j] = m.K * J2 - (2.0 / 3) * (Gw * (V(1.0) + e[j] + e[i] - mean));
        if (i == j) H.at[i][j] += 2.0 * (Gw * (V(1.0) + e[i]));
      }
    return H;
  }
  /// Opens what would be in tension: the largest stretch, then the two largest together, then all.
  void relax(const MaterialParameters& m) {
    const double lame = m.K - 2.0 / 3 * m.G;
    const auto open = [&](int count, const Flag& active, double first_guess) {
      V e[3] = {kept_[0], kept_[1], kept_[2]};
      const auto minus_stress = [&](const V& t, V& slope) {
        for (int i = 0; i < count; ++i) e[i] = t;
        const Hessian H = hessian(m, e);
        slope = -(count == 1 ? H.at[0][0] : H.at[0][0] + H.at[0][1]) / (2.0 * (V(1.0) + t));
        return V(-stress(m, e, 0));
      };
      V pressed = trial_[2];
      if (count == 1) pressed += trial_[1];
      const V low = V(-0.999), high = trial_[0];
      const V start = min(max(V(first_guess * pressed), low), high);
      const V t = scalar_root(select(active, start, V(0.0)), low, high, active, 1e-9, minus_stress).x;
      for (int i = 0; i < count; ++i) kept_[i] = select(active, t, kept_[i]);
    };
    gone_[0] = stress(m, trial_, 0) > V(0.0);
    gone_[1] = gone_[2] = V(0.0) > V(0.0);
    if (!any(gone_[0])) return;
    open(1, gone_[0], -lame / (lame + 2 * m.G));
    gone_[1] = gone_[0] & (stress(m, kept_, 1) > V(0.0));
    gone_[2] = gone_[1] & (trial_[2] >= V(0.0));
    if (any(gone_[1])) open(2, gone_[1], -lame / (2 * (lame + m.G)));
    for (int i = 0; i < 3; ++i) kept_[i] = select(gone_[2], V(0.0), kept_[i]);
  }
  /// The slope of what is pressed where the other stresses stay zero.
  void condense(const Hessian& H) {
    const auto& h = H.at;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const V plane = h[i][j] - h[i][0] * h[0][j] / h[0][0];
        const V line = h[i][j] - 2.0 * (h[i][0] * h[0][j]) / (h[0][0] + h[0][1]);
        const V free = select(gone_[1], line, select(gone_[0], plane, h[i][j]));
        slope_[i][j] = select(gone_[i] | gone_[j], V(0.0), free);
      }
  }

  PrincipalFrame<V, d> frame_;
  V trial_[3], kept_[3], tau_[3], lost_[3], slope_[3][3];
  Flag gone_[3]; ///< whose stress is zero
  PrincipalParts<V, d> at_;
};

/// Of e = b_e - 1 and dJ = J_e - 1.
template <class T, int d>
SplitEnergies<T, d> no_tension_energies(const MaterialParameters& m, const Symmetric<T, d>& e, const T& dJ) {
  const PrincipalParts<T, d> part = Mapped<ClosedMap, T, d>::at(m, e);
  const T Je = T(1.0) + dJ, c = inverse_cbrt(Je);
  Symmetric<T, d> tau = (m.G * (c * c)) * dev(e);
  for (int i = 0; i < 3; ++i) tau[i] = tau[i] + (0.5 * m.K) * (dJ * (Je + T(1.0)));
  return {part.second, part.first, tau - part.tensor, part.tensor};
}

} // namespace impact
