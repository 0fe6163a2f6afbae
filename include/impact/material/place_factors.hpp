#pragma once
#include <bit>
#include <cmath>
#include <compare>
#include <cstdint>
#include <impact/material/point_law.hpp>

/// Numbers of a material that differ from place to place, as factors on those of its law. The factors of
/// chance are functions of a seed and a place, and of nothing else.
namespace impact {

struct PlaceFactors {
  double E = 1; ///< on the moduli, at the same Poisson's ratio
  double Gc = 1;
  double strength = 1; ///< f_t of a cohesive degradation

  auto operator<=>(const PlaceFactors&) const = default;
};

/// The law at a place. The slope a_1 of a cohesive degradation is w'(0) G_c/(gamma psi_c) with psi_c, the
/// energy at the strength, in proportion to f_t^2/E (56'').
inline PointLaw law_at(const PointLaw& law, const PlaceFactors& factors) {
  PointLaw local = law;
  MaterialParameters& m = local.parameters;
  m.K *= factors.E;
  m.G *= factors.E;
  m.Gc *= factors.Gc;
  m.cohesive.a1 *= factors.Gc * factors.E / (factors.strength * factors.strength);
  return local;
}

/// To three digits: cells of equal factors have one law, and share batches.
inline double to_three_digits(double factor) {
  const double scale = std::pow(10.0, 2 - std::floor(std::log10(factor)));
  return std::round(factor * scale) / scale;
}

/// splitmix64 (G. L. Steele, D. Lea, C. H. Flood, OOPSLA 2014).
inline std::uint64_t scrambled(std::uint64_t bits) {
  bits += 0x9e3779b97f4a7c15;
  bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9;
  bits = (bits ^ (bits >> 27)) * 0x94d049bb133111eb;
  return bits ^ (bits >> 31);
}

/// A number of the Weibull distribution 1 - exp(-x^modulus), whose scale is 1, for a place [3]: for each cube
/// of the edge `length` one, or, where that is 0, for each place. Other `stream`s of a seed are independent.
inline double weibull_at(std::uint64_t seed, std::uint64_t stream, const double* place, double length,
                         double modulus) {
  std::uint64_t bits = scrambled(scrambled(seed) + stream);
  for (int k = 0; k < 3; ++k) {
    const double x = length > 0 ? std::floor(place[k] / length) : place[k];
    bits = scrambled(bits ^ std::bit_cast<std::uint64_t>(x + 0.0)); // no -0
  }
  const double uniform = (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
  return std::pow(-std::log(uniform), 1 / modulus);
}

} // namespace impact
