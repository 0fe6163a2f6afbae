#pragma once
#include <cmath>
#include <cstdint>

/// Batch: IMPACT_LANES doubles that are computed together, one lane per cell. The only file with a compiler
/// extension (vector types of GCC and Clang). Comparisons give a Mask; select picks lane by lane, so that a
/// value computed in vain in the other branch (infinity, NaN) never spreads.
#ifndef IMPACT_LANES
#define IMPACT_LANES 4
#endif

#pragma GCC diagnostic ignored "-Wpsabi" // the note concerns objects linked across different -march flags

namespace impact {

inline constexpr int lanes = IMPACT_LANES;

struct Mask {
  typedef std::int64_t Vector __attribute__((vector_size(8 * IMPACT_LANES), may_alias));
  Vector v;
  friend Mask operator&(Mask a, Mask b) { return {a.v & b.v}; }
  friend Mask operator|(Mask a, Mask b) { return {a.v | b.v}; }
  friend Mask operator~(Mask a) { return {~a.v}; }
};

struct Batch {
  typedef double Vector __attribute__((vector_size(8 * IMPACT_LANES), may_alias));
  Vector v;

  Batch() = default;
  Batch(double x) : v(x - Vector{}) {}
  Batch(Vector x) : v(x) {}
  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double x) { v[lane] = x; }

  friend Batch operator+(Batch a, Batch b) { return a.v + b.v; }
  friend Batch operator-(Batch a, Batch b) { return a.v - b.v; }
  friend Batch operator*(Batch a, Batch b) { return a.v * b.v; }
  friend Batch operator/(Batch a, Batch b) { return a.v / b.v; }
  friend Batch operator-(Batch a) { return -a.v; }
  Batch& operator+=(Batch b) { return *this = *this + b; }
  Batch& operator-=(Batch b) { return *this = *this - b; }
  Batch& operator*=(Batch b) { return *this = *this * b; }
  friend Mask operator<(Batch a, Batch b) { return {a.v < b.v}; }
  friend Mask operator<=(Batch a, Batch b) { return {a.v <= b.v}; }
  friend Mask operator>(Batch a, Batch b) { return {a.v > b.v}; }
  friend Mask operator>=(Batch a, Batch b) { return {a.v >= b.v}; }
};

/// Bit l is set where lane l of the mask is true.
inline int bits(Mask m) {
  int b = 0;
#ifdef __AVX__
  if constexpr (lanes % 4 == 0) { // one instruction for the sign bits of four lanes
    typedef double Four __attribute__((vector_size(32)));
    Four part[lanes / 4];
    __builtin_memcpy(part, &m, sizeof m);
    for (int k = 0; k < lanes / 4; ++k) b |= __builtin_ia32_movmskpd256(part[k]) << (4 * k);
    return b;
  }
#endif
  for (int l = 0; l < lanes; ++l) b |= m.v[l] ? 1 << l : 0;
  return b;
}

inline bool any(Mask m) { return bits(m) != 0; }
inline bool all(Mask m) { return !any(~m); }
inline Batch select(Mask m, Batch a, Batch b) {
  return reinterpret_cast<Batch::Vector>((reinterpret_cast<Mask::Vector>(a.v) & m.v) |
                                         (reinterpret_cast<Mask::Vector>(b.v) & ~m.v));
}

/// Reads or writes `lanes` doubles at any address.
inline Batch load(const double* p) {
  Batch b;
  __builtin_memcpy(&b, p, sizeof b);
  return b;
}
inline void store(double* p, Batch b) { __builtin_memcpy(p, &b, sizeof b); }

inline Batch max(Batch a, Batch b) { return select(a < b, b, a); }
inline Batch min(Batch a, Batch b) { return select(b < a, b, a); }
inline Batch abs(Batch a) {
  return reinterpret_cast<Batch::Vector>(reinterpret_cast<Mask::Vector>(a.v) & 0x7fffffffffffffff);
}
inline Mask is_finite(Batch a) { return a - a <= Batch(0.0); }

inline Batch sqrt(Batch a) {
  Batch r;
  for (int l = 0; l < lanes; ++l) r.v[l] = __builtin_sqrt(a.v[l]);
  return r;
}

/// exp: argument reduction by ln 2 in two parts, Taylor polynomial of degree 13 on |r| <= ln 2 / 2, exponent
/// by bits. Relative error below 3e-16; the argument is clamped to [-708, 709]; NaN stays NaN.
inline Batch exp(Batch x) {
  x = select(x < Batch(-708.0), Batch(-708.0), select(x > Batch(709.0), Batch(709.0), x));
  const double shift = 0x1.8p52;
  const Batch t = x * Batch(1.4426950408889634) + Batch(shift);
  const Batch k = t - Batch(shift);
  const Batch r = (x - k * Batch(6.93147180369123816490e-01)) - k * Batch(1.90821492927058770002e-10);
  // sum of r^k/k!, k = 2..13, in pairs (Estrin), because the chain of a Horner scheme would cost more than
  // the work
  const Batch r2 = r * r, r4 = r2 * r2;
  const auto pair = [&](double even, double odd) { return Batch(1 / even) + r * Batch(1 / odd); };
  const Batch low = pair(2, 6) + r2 * pair(24, 120);
  const Batch middle = pair(720, 5040) + r2 * pair(40320, 362880);
  const Batch high = pair(3628800, 39916800) + r2 * pair(479001600, 6227020800);
  const Batch p = r + r2 * (low + r4 * (middle + r4 * high));
  const Mask::Vector n =
      (reinterpret_cast<Mask::Vector>(t.v) - reinterpret_cast<Mask::Vector>(Batch(shift).v)) << 52;
  const Mask::Vector one = reinterpret_cast<Mask::Vector>(Batch(1.0).v);
  const Batch scale = reinterpret_cast<Batch::Vector>(one + n);
  return p * scale + scale;
}

/// x^(-1/3) for x > 0 (NaN otherwise): a guess of 3.5 % from the bits, then two steps of fourth order.
/// Relative error below 4e-16.
inline Batch inverse_cbrt(Batch x) {
  const Mask::Vector high = (reinterpret_cast<Mask::Vector>(x.v) >> 32) & 0x7fffffff;
  const Mask::Vector third = (high * 0x55555556LL) >> 32;
  Batch y = reinterpret_cast<Batch::Vector>((0x553ef0ffLL - third) << 32);
  for (int i = 0; i < 2; ++i) {
    const Batch e = Batch(1.0) - (x * (y * y)) * y;
    y += (y * e) * (Batch(1.0 / 3) + e * (Batch(2.0 / 9) + e * Batch(14.0 / 81)));
  }
  return select(x > Batch(0.0), y, Batch(std::nan("")));
}

/// Natural logarithm, lane by lane in the C library.
inline Batch log(Batch x) {
  Batch r;
  for (int l = 0; l < lanes; ++l) r.v[l] = std::log(x.v[l]);
  return r;
}

/// x^p, lane by lane in the C library.
inline Batch pow(Batch x, double p) {
  Batch r;
  for (int l = 0; l < lanes; ++l) r.v[l] = std::pow(x.v[l], p);
  return r;
}

} // namespace impact
