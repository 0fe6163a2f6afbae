#pragma once
#include <algorithm>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/problem/discretisation.hpp>
#include <span>

/// The loop over batches of cells: gather, kernel, scatter. The kernels of a group come from its shape and
/// the frame of the run; no loop names a shape.
namespace impact {

/// What a batch holds, in place: the first `size` of an array that is large enough for any cell.
template <int capacity> struct BatchArray {
  int size = 0;
  Batch value[static_cast<std::size_t>(capacity)];

  explicit BatchArray(int count) : size(count) {}
  const Batch* data() const { return value; }
  Batch* data() { return value; }
  std::span<Batch> all() { return {value, static_cast<std::size_t>(size)}; }
  std::span<const Batch> all() const { return {value, static_cast<std::size_t>(size)}; }
};

/// One nodal field of a batch, [node][components], gathered from a local array; or all 0.
struct Gathered : BatchArray<3 * max_nodes> {
  Gathered(const CellGroup& group, int batch, const std::vector<double>& local, int components)
      : BatchArray(group.shape->nodes * components) {
    gather(group, batch, components, local.data(), value);
  }
};
struct NodalSum : BatchArray<3 * max_nodes> {
  NodalSum(const CellGroup& group, int components) : BatchArray(group.shape->nodes * components) {
    std::fill_n(value, size, Batch(0.0));
  }
};

/// Point data of one batch, [point][components], copied from and to a row
/// [group][batch][point][component][lane] (rows are ordinary arrays of double without the alignment of a
/// Batch).
template <int most_components> struct PointValues : BatchArray<max_points * most_components> {
  explicit PointValues(const CellGroup& group, int components = most_components)
      : BatchArray<max_points * most_components>(group.shape->points * components) {}
  void load(std::span<const double> row, std::size_t offset, int batch) {
    const double* from = row.data() + place(offset, batch);
    std::copy_n(from, this->size * lanes, reinterpret_cast<double*>(this->value));
  }
  void store(std::vector<double>& row, std::size_t offset, int batch) const {
    std::copy_n(reinterpret_cast<const double*>(this->value), this->size * lanes,
                row.data() + place(offset, batch));
  }

private:
  std::size_t place(std::size_t offset, int batch) const {
    return offset + static_cast<std::size_t>(batch) * static_cast<std::size_t>(this->size) * lanes;
  }
};

/// A matrix over the dofs of a cell, [row][column] with equally many of both; all 0 at first.
struct CellMatrix {
  int rows;
  std::vector<Batch> value;

  explicit CellMatrix(int n) : rows(n), value(static_cast<std::size_t>(n * n), Batch(0.0)) {}
  Batch* data() { return value.data(); }
  void clear() { std::fill(value.begin(), value.end(), Batch(0.0)); }
  /// Rows and columns of what is not free (0) vanish. free: [row].
  void mask(const Batch* free) {
    Batch* entry = value.data();
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < rows; ++j) *entry++ *= free[i] * free[j];
  }
};

/// Where each group starts in a row of `components` per point.
inline std::vector<std::size_t> point_offsets(const std::vector<CellGroup>& groups, int components) {
  std::vector<std::size_t> offset(groups.size() + 1, 0);
  for (std::size_t g = 0; g < groups.size(); ++g)
    offset[g + 1] = offset[g] + point_values(groups[g], components);
  return offset;
}

/// Sum of a batch's lanes that hold cells of their own.
inline double lane_sum(const Batch& value, int lanes_in_use) {
  double sum = 0;
  for (int l = 0; l < lanes_in_use; ++l) sum += value[l];
  return sum;
}

/// Whether no lane that holds a cell of its own is marked in a kernel's bit mask.
inline bool is_sound(int bad, int lanes_in_use) { return (bad & ((1 << lanes_in_use) - 1)) == 0; }

} // namespace impact
