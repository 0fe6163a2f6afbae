#pragma once
#include <impact/math/batch.hpp>

namespace impact {

/// Residual and tangent of a scalar field (damage, heat) on one batch of cells while its points are passed.
template <class Cell, bool tangent> struct ScalarCell {
  static constexpr int n = Cell::nodes;
  Batch r[n];
  Batch K[tangent ? n * n : 1]; ///< the upper half, [node][node]

  ScalarCell() {
    for (Batch& x : r) x = Batch(0.0);
    for (Batch& x : K) x = Batch(0.0);
  }
  /// r_out [node] += r, and with a tangent K_out [node][node] += K. Returns the lanes in which r is not
  /// finite.
  int add_to(Batch* r_out, Batch* K_out) const {
    Batch finite = Batch(0.0);
    for (int a = 0; a < n; ++a) {
      finite += r[a] - r[a];
      r_out[a] += r[a];
    }
    if constexpr (tangent)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b) K_out[a * n + b] += K[a <= b ? a * n + b : b * n + a];
    return bits(~is_finite(finite));
  }
};

} // namespace impact
