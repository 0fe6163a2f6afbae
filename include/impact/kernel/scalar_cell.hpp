#pragma once
#include <impact/math/batch.hpp>

/// What the equations of a scalar field (damage, heat) share at the end of a batch of cells.
namespace impact {

/// r_out [node] += r, and with a tangent K_out [node][node] += K, of which r's caller filled the upper half.
/// Returns the lanes in which r is not finite.
template <int n, bool tangent>
int add_scalar_cell(const Batch* r, const Batch* K, Batch* r_out, Batch* K_out) {
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

} // namespace impact
