#pragma once
#include <algorithm>
#include <cstddef>
#include <impact/material/hardening_curve.hpp>
#include <impact/material/parameters.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/dual.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

/// k_0 through given points (alpha, k), straight between them and constant after the last; the potential is
/// the exact integral.
namespace impact {

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

} // namespace impact
