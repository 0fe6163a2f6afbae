#pragma once
#include <impact/math/batch.hpp>

#include <cmath>
#include <complex>
#include <type_traits>

/// Forward-mode differentiation: Dual<B, n> is a value and n derivatives. The functions below let one
/// template of a law run with double, std::complex<double> (complex-step oracle in tests), Batch and Dual of
/// double or Batch:
///   value(x)          what branches and iterations look at: the value without derivatives
///   select(mask,a,b)  lane-wise choice;  positive part of the interface: sqrt, exp, log, inverse_cbrt
namespace impact {

template <class B, int n> struct Dual {
  B v;    ///< value
  B d[n]; ///< derivatives

  Dual() = default;
  Dual(const B& x) : v(x) {
    for (int i = 0; i < n; ++i) d[i] = B(0.0);
  }
  Dual(double x) requires(!std::is_same_v<B, double>) : Dual(B(x)) {}

  friend Dual operator+(Dual a, const Dual& b) {
    a.v += b.v;
    for (int i = 0; i < n; ++i) a.d[i] += b.d[i];
    return a;
  }
  friend Dual operator-(Dual a, const Dual& b) {
    a.v -= b.v;
    for (int i = 0; i < n; ++i) a.d[i] -= b.d[i];
    return a;
  }
  friend Dual operator-(const Dual& a) { return chain(a, -a.v, B(-1.0)); }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual r;
    r.v = a.v * b.v;
    for (int i = 0; i < n; ++i) r.d[i] = a.d[i] * b.v + a.v * b.d[i];
    return r;
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    Dual r;
    const B inverse = B(1.0) / b.v;
    r.v = a.v * inverse;
    for (int i = 0; i < n; ++i) r.d[i] = (a.d[i] - r.v * b.d[i]) * inverse;
    return r;
  }
  friend Dual operator*(double a, const Dual& b) { return chain(b, B(a) * b.v, B(a)); }
  friend Dual operator*(const Dual& a, double b) { return chain(a, B(b) * a.v, B(b)); }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator-=(const Dual& b) { return *this = *this - b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }

  /// f(a), given f and f' at the value of a.
  static Dual chain(const Dual& a, const B& f, const B& df) {
    Dual r;
    r.v = f;
    for (int i = 0; i < n; ++i) r.d[i] = df * a.d[i];
    return r;
  }
};

inline double value(double x) { return x; }
inline double value(const std::complex<double>& x) { return x.real(); }
inline Batch value(const Batch& x) { return x; }
template <class B, int n> auto value(const Dual<B, n>& x) { return value(x.v); }
template <class T> using Value = decltype(value(T()));

/// Dual variable x with derivative 1 in direction i.
template <class B, int n> Dual<B, n> seed(const B& x, int i) {
  Dual<B, n> r(x);
  r.d[i] = B(1.0);
  return r;
}

/// f(x) as a function of x whose value f and slope df at the value of x are known.
inline double with_slope(double /*x*/, double f, double /*df*/) { return f; }
inline Batch with_slope(const Batch& /*x*/, const Batch& f, const Batch& /*df*/) { return f; }
inline std::complex<double> with_slope(const std::complex<double>& x, double f, double df) {
  return {f, df * x.imag()};
}
template <class B, int n> Dual<B, n> with_slope(const Dual<B, n>& x, const Value<B>& f, const Value<B>& df) {
  return Dual<B, n>::chain(x, with_slope(x.v, f, df), B(df));
}
/// Values as lanes, for functions of a Batch alone, and back.
inline Batch broadcast(double x) { return x; }
inline Batch broadcast(const Batch& x) { return x; }
template <class V> V lanes_of(const Batch& x) {
  if constexpr (std::is_same_v<V, double>)
    return x[0];
  else
    return x;
}

inline double select(bool m, double a, double b) { return m ? a : b; }
inline std::complex<double> select(bool m, const std::complex<double>& a, const std::complex<double>& b) {
  return m ? a : b;
}
template <class B, int n, class M> Dual<B, n> select(M m, const Dual<B, n>& a, const Dual<B, n>& b) {
  Dual<B, n> r;
  r.v = select(m, a.v, b.v);
  for (int i = 0; i < n; ++i) r.d[i] = select(m, a.d[i], b.d[i]);
  return r;
}
inline bool any(bool m) { return m; }
inline bool all(bool m) { return m; }
inline int bits(bool m) { return m ? 1 : 0; }
inline bool is_finite(double x) { return std::isfinite(x); }
inline double max(double a, double b) { return a < b ? b : a; }
inline double min(double a, double b) { return b < a ? b : a; }
inline double abs(double a) { return std::fabs(a); }

inline double sqrt(double x) { return std::sqrt(x); }
inline double exp(double x) { return std::exp(x); }
inline double log(double x) { return std::log(x); }
inline double pow(double x, double p) { return std::pow(x, p); }
inline double inverse_cbrt(double x) { return 1 / std::cbrt(x); }
inline std::complex<double> sqrt(const std::complex<double>& x) { return std::sqrt(x); }
inline std::complex<double> exp(const std::complex<double>& x) { return std::exp(x); }
inline std::complex<double> log(const std::complex<double>& x) { return std::log(x); }
inline std::complex<double> pow(const std::complex<double>& x, double p) { return std::pow(x, p); }
inline std::complex<double> inverse_cbrt(const std::complex<double>& x) {
  const std::complex<double> y = 1 / std::cbrt(x.real());
  return y * (4.0 - x * y * y * y) / 3.0; // one Newton step: exact value, first-order imaginary part
}

template <class B, int n> Dual<B, n> sqrt(const Dual<B, n>& x) {
  const B f = sqrt(x.v);
  return Dual<B, n>::chain(x, f, B(0.5) / f);
}
template <class B, int n> Dual<B, n> exp(const Dual<B, n>& x) {
  const B f = exp(x.v);
  return Dual<B, n>::chain(x, f, f);
}
template <class B, int n> Dual<B, n> log(const Dual<B, n>& x) {
  return Dual<B, n>::chain(x, log(x.v), B(1.0) / x.v);
}
template <class B, int n> Dual<B, n> pow(const Dual<B, n>& x, double p) {
  const B f = pow(x.v, p);
  return Dual<B, n>::chain(x, f, B(p) * f / x.v);
}
template <class B, int n> Dual<B, n> inverse_cbrt(const Dual<B, n>& x) {
  const B f = inverse_cbrt(x.v);
  return Dual<B, n>::chain(x, f, B(-1.0 / 3) * f / x.v);
}

} // namespace impact
