#pragma once
#include <impact/element/cells.hpp>
#include <impact/math/batch.hpp>
#include <impact/math/index.hpp>
#include <iterator>

/// Fields of a cell in which the volume ratio and the pressure of `mean` vary (theory.md, volumetric
/// locking): uniform, or in cells of second order that are no simplices linear in the reference position,
/// discontinuous between cells. Linear in the coordinates of the reference cell they would lose an order
/// where cells are distorted (D. Boffi, L. Gastaldi, Calcolo 39 (2002) 1).
namespace impact {

template <class Cell> consteval int count_volume_modes() {
  if constexpr (is_second_order<Cell>)
    return std::size(Cell::edges) > Cell::dim * (Cell::dim + 1) / 2 ? Cell::dim + 1 : 1;
  return 1;
}
template <class Cell> inline constexpr int volume_modes = count_volume_modes<Cell>();

/// Factors of the modes of a field, or integrals with them.
template <class Cell> struct VolumeField {
  Batch of[volume_modes<Cell>];

  void clear() {
    for (Batch& f : of) f = Batch(0.0);
  }
};
/// Integrals of products of two modes; symmetric.
template <class Cell> struct VolumeProducts {
  Batch of[volume_modes<Cell>][volume_modes<Cell>];

  void clear() {
    for (auto& row : of)
      for (Batch& x : row) x = Batch(0.0);
  }
};

/// The modes at the points, 1 and the position from the centroid, and the projection on them. What is done
/// once for a cell is not inlined: unrolled in each variant of a kernel it was a tenth of its compile time.
template <class Cell> struct VolumeModes {
  static constexpr int count = volume_modes<Cell>;
  Batch volume;                                         ///< of the reference cell
  Batch place[count > 1 ? Cell::points : 1][Cell::dim]; ///< modes from the second one; not set of one mode,
  Batch inverse[count][count];                          ///< nor this, of the integrals of their products

  /// X [node][dim].
  [[gnu::noinline]] void set_places(const Batch* X) {
    const auto& t = shape_table<Cell>;
    for (int i = 0; count > 1 && i < Cell::dim; ++i) {
      const auto position = [&](const double* N) {
        return sum<Cell::nodes>([&](int a) { return N[a] * X[a * Cell::dim + i]; });
      };
      const Batch centre = position(t.N0);
      for (int q = 0; q < Cell::points; ++q) place[q][i] = position(t.N[q]) - centre;
    }
  }
  Batch value(const VolumeField<Cell>& field, int q) const {
    Batch x = field.of[0];
    for (int k = 1; k < count; ++k) x += place[q][k - 1] * field.of[k];
    return x;
  }
  /// Integrals grow by those of a value at a point.
  void add(VolumeField<Cell>& integrals, int q, const Batch& x) const {
    integrals.of[0] += x;
    for (int k = 1; k < count; ++k) integrals.of[k] += place[q][k - 1] * x;
  }
  void add(VolumeProducts<Cell>& integrals, int q, const Batch& x) const {
    integrals.of[0][0] += x;
    for (int k = 1; k < count; ++k) {
      const Batch y = place[q][k - 1] * x;
      integrals.of[k][0] += y;
      for (int l = 1; l <= k; ++l) integrals.of[k][l] += place[q][l - 1] * y;
      for (int l = 0; l < k; ++l) integrals.of[l][k] = integrals.of[k][l];
    }
  }
  /// By Gauss and Jordan, without pivots: the integrals of the products are positive definite.
  [[gnu::noinline]] void invert(const VolumeProducts<Cell>& mass) {
    if constexpr (count == 1) return;
    Batch a[count][count];
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < count; ++j) {
        a[i][j] = mass.of[i][j];
        inverse[i][j] = Batch(i == j ? 1.0 : 0.0);
      }
    for (int k = 0; k < count; ++k) {
      const Batch pivot = Batch(1.0) / a[k][k];
      for (int j = 0; j < count; ++j) a[k][j] = pivot * a[k][j], inverse[k][j] = pivot * inverse[k][j];
      for (int i = 0; i < count; ++i) {
        if (i == k) continue;
        const Batch f = a[i][k];
        for (int j = 0; j < count; ++j) {
          a[i][j] -= f * a[k][j];
          inverse[i][j] -= f * inverse[k][j];
        }
      }
    }
  }
  /// Component k of M^-1 x, M the integrals of the products of modes.
  Batch factor(int k, const Batch (&x)[count]) const {
    if constexpr (count == 1) return x[0] / volume;
    return sum<count>([&](int l) { return inverse[k][l] * x[l]; });
  }
  /// The same of x [mode][i].
  template <int n> Batch factor(int k, const Batch (&x)[count][n], int i) const {
    if constexpr (count == 1) return x[0][i] / volume;
    return sum<count>([&](int l) { return inverse[k][l] * x[l][i]; });
  }
  /// The field with these integrals.
  VolumeField<Cell> project(const VolumeField<Cell>& integrals) const {
    VolumeField<Cell> field;
    for (int k = 0; k < count; ++k) field.of[k] = factor(k, integrals.of);
    return field;
  }
  /// M^-1 P M^-1.
  [[gnu::noinline]] void between(const VolumeProducts<Cell>& P, Batch (&D)[count][count]) const {
    Batch half[count][count];
    for (int k = 0; k < count; ++k)
      for (int l = 0; l < count; ++l) half[k][l] = factor(k, P.of, l);
    for (int k = 0; k < count; ++k)
      for (int l = 0; l < count; ++l) D[k][l] = factor(l, half[k]);
  }
};

} // namespace impact
