#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <impact/math/batch.hpp>
#include <impact/math/dual.hpp>

/// Fatigue by a toughness that falls: f(alpha) G_c in the place of G_c, alpha the energy that a cell has been
/// given in tension again and again (P. Carrara, M. Ambati, R. Alessi, L. De Lorenzis, Comput. Methods Appl.
/// Mech. Engrg. 361 (2020) 112731; src/theory.md, (F2)). With x = alpha/alpha_T
///   asymptotic   f = (2/(1 + x))^2             for x > 1, else 1
///   logarithmic  f = (1 - kappa log10(x))^2    for 1 < x < 10^(1/kappa), else 1 and 0
/// In a step alpha grows by <W - W_n>, W the degraded energy that drives damage, or, where the mean load
/// counts, by <W^2 - W_n^2>/(2 alpha_N). What is kept is gamma alpha, an energy per area like G_c.
namespace impact {

/// What fatigue lowers: the drive by a variable (crack.hpp), or the toughness by one of two functions.
enum class FatigueLaw { power, asymptotic, logarithmic };

struct ToughnessFatigue {
  FatigueLaw law = FatigueLaw::power;
  double threshold = 0; ///< alpha_T (energy per volume); 0: not yet known
  double kappa = 0;     ///< of the logarithmic function
  double mean_load = 0; ///< alpha_N (energy per volume); 0: the mean load does not count
  double width = 1;     ///< gamma (length)

  bool works() const { return law != FatigueLaw::power; }

  /// f of gamma alpha, not below 1e-6: something must keep the damage of what bears nothing.
  template <class T> T left(const T& fatigue) const {
    if (!works()) return T(1.0);
    const T x = (1 / (width * threshold)) * fatigue, above = select(x > T(1.0), x, T(1.0));
    const T root = law == FatigueLaw::asymptotic ? T(2.0) / (T(1.0) + above)
                                                 : T(1.0) - (kappa / std::log(10.0)) * log(above);
    return select(root > T(1e-3), root * root, T(1e-6));
  }

  /// What gamma alpha grows by as the energy goes from W_n to W.
  template <class T> T growth(const T& W_n, const T& W) const {
    const T change = mean_load > 0 ? (0.5 / mean_load) * ((W - W_n) * (W + W_n)) : W - W_n;
    return width * select(change > T(0.0), change, T(0.0));
  }
};

/// Factors on G_c by the rate of strain and by the temperature (src/theory.md, (T1)); empty: none.
struct ToughnessByState {
  std::function<double(double)> rate, temperature;

  bool works() const { return rate || temperature; }
  double factor(double strain_rate, double theta) const {
    return (rate ? rate(strain_rate) : 1) * (temperature ? temperature(theta) : 1);
  }
};

} // namespace impact
