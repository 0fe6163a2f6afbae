#pragma once
#include <algorithm>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/problem/discretisation.hpp>
#include <optional>
#include <span>

/// The loop over batches of cells: gather, kernel, scatter. The kernels of a batch come from its shape and
/// the frame of the run; no loop names a shape.
namespace impact {

/// What a batch holds, in place: the first `size` of an array that is large enough for any cell.
template <int capacity> struct BatchArray {
  int size;
  Batch value[at(capacity)];

  explicit BatchArray(int count) : size(count) {}
  BatchArray(const BatchArray& other) : size(other.size) { std::copy_n(other.value, size, value); }
  BatchArray& operator=(const BatchArray& other) {
    size = other.size;
    std::copy_n(other.value, size, value);
    return *this;
  }
  const Batch* data() const { return value; }
  Batch* data() { return value; }
  std::span<Batch> all() { return {value, at(size)}; }
  std::span<const Batch> all() const { return {value, at(size)}; }
};

/// One nodal field of a batch, [node][components].
using NodalValues = BatchArray<3 * max_nodes>;

/// Point data of one batch, [point][components].
template <int most_components> struct PointValues : BatchArray<max_points * most_components> {
  int components;

  explicit PointValues(const CellGroup& group, int count = most_components)
      : BatchArray<max_points * most_components>(group.shape->points * count), components(count) {}
};

/// A matrix over the dofs of a cell, [row][column], whose space serves one batch after the other.
class CellMatrix {
public:
  /// For n dofs, with the entries as they are; with all entries 0.
  Batch* sized(int n) {
    rows_ = n;
    value_.resize(at(n * n));
    return value_.data();
  }
  Batch* zeroed(int n) {
    std::fill_n(sized(n), n * n, Batch(0.0));
    return value_.data();
  }
  Batch& operator()(int i, int j) { return value_[at(i * rows_ + j)]; }
  const Batch* data() const { return value_.data(); }
  /// Rows and columns of held dofs, whose `free` is 0, vanish.
  void mask(const NodalValues& free) {
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < rows_; ++j) (*this)(i, j) *= free.value[i] * free.value[j];
  }
  void scale(const Batch& factor) {
    for (Batch& entry : value_) entry *= factor;
  }
  Batch trace() const {
    Batch sum = value_[0];
    for (int i = 1; i < rows_; ++i) sum += value_[at(i * rows_ + i)];
    return sum;
  }

private:
  int rows_ = 0;
  std::vector<Batch> value_;
};

/// Sum of a batch's lanes that hold cells of their own.
inline double lane_sum(const Batch& value, int lanes_in_use) {
  double sum = 0;
  for (int l = 0; l < lanes_in_use; ++l) sum += value[l];
  return sum;
}

/// One batch of the loop below. Fields are local arrays [node][components], rows
/// [group][batch][point][component][lane], ordinary doubles without the alignment of a Batch. More functions
/// than usual: what is read of cells and added to is told here which of them are there, and nowhere else.
struct CellBatch {
  const Discretisation& d;
  const CellGroup& group;
  const PointLaw& law;
  const CellKernels& kernels;
  int number_of_group, number;
  std::size_t first_point,
      first_cell; ///< of the group, in rows [group][batch][point][lane], [group][batch][lane]
  int eroded;     ///< bit l: the cell in lane l has left the body
  int weightless; ///< and its mass is gone

  int nodes() const { return group.shape->nodes; }
  int used() const { return group.lanes_in_use(number); }
  /// Those bits of `bad` that belong to cells of their own which are still there.
  int broken(int bad) const { return bad & ((1 << used()) - 1) & ~eroded; }
  std::size_t place() const { return first_cell / lanes + at(number); } ///< among the batches of all groups
  std::size_t material() const { return at(group.material); }
  /// Whether the cells share their volume in patches, and the patch of one; -1 for padding.
  bool patched() const { return !d.patches.empty() && d.patches.in_group[at(number_of_group)] != 0; }
  int patch(int lane) const { return d.patches.of_lane[place() * lanes + at(lane)]; }
  double sum(const Batch& value) const { return lane_sum(value, used()); }
  /// Of the cells but for those lanes.
  double sum_without(int gone, const Batch& value) const {
    if (gone == 0) return sum(value);
    double sum = 0;
    for (int l = 0; l < used(); ++l)
      if ((gone & (1 << l)) == 0) sum += value[l];
    return sum;
  }
  /// Of the cells that are still there; whose mass is.
  double live_sum(const Batch& value) const { return sum_without(eroded, value); }
  double massive_sum(const Batch& value) const { return sum_without(weightless, value); }
  bool live(int lane) const { return (eroded & (1 << lane)) == 0; }
  /// Reference volume of each cell (area in the plane).
  Batch volume(const NodalValues& X) const {
    auto ones = points<1>();
    std::fill_n(ones.value, ones.size, Batch(1.0));
    return kernels.cell_integral(X.data(), ones.data());
  }
  /// Mean over each cell of values at its points.
  Batch mean(const NodalValues& X, const PointValues<1>& values) const {
    return kernels.cell_integral(X.data(), values.data()) / volume(X);
  }

  const ToughnessFatigue& tiring() const { return d.materials[material()].fatigue; }
  const ToughnessByState& toughness_by_state() const { return d.materials[material()].toughness; }
  /// Whether their toughness changes.
  bool changes_toughness() const { return tiring().works() || toughness_by_state().works(); }
  /// f of the cells, what of the toughness there is: (F2) from the row "fatigue", (T1) from the row
  /// "toughness"; 1 where it stays.
  Batch toughness(const std::vector<double>* fatigue, const std::vector<double>* toughness) const {
    if (toughness != nullptr && toughness_by_state().works()) return load<2>(*toughness).value[0];
    return fatigue != nullptr && tiring().works() ? tiring().left(load<1>(*fatigue).value[0]) : Batch(1.0);
  }
  /// Adds to the integrals of the cells: what their cracks have cost beyond psi_phi (T2), or psi_F =
  /// -(1 - f) psi_phi.
  void add_toughness(const std::vector<double>* fatigue, const std::vector<double>* toughness,
                     EnergySums& sums) const {
    if (toughness != nullptr && toughness_by_state().works())
      sums.fracture += load<2>(*toughness).value[1];
    else if (fatigue != nullptr && tiring().works())
      sums.fatigue += (this->toughness(fatigue, nullptr) - Batch(1.0)) * sums.fracture;
  }

  NodalValues gather(std::span<const double> field, int components) const {
    NodalValues values = nodal(components);
    impact::gather(group, number, components, field.data(), values.data());
    return values;
  }
  /// Where the values of a nodal field or of a row stand, for a kernel; null without one.
  template <int most> const Batch* read(const std::vector<double>* field, BatchArray<most>& values) const {
    if (field == nullptr) return nullptr;
    impact::gather(group, number, values.size / nodes(), field->data(), values.data());
    return values.data();
  }
  template <int most> const Batch* read(const std::vector<double>* row, PointValues<most>& values) const {
    if (row == nullptr) return nullptr;
    load(*row, values);
    return values.data();
  }
  /// What the patches of the cells share; null where the cells are in none, or the row is empty.
  template <int most>
  const Batch* read_shared(const std::vector<double>& row, BatchArray<most>& values) const {
    if (row.empty() || !patched()) return nullptr;
    const std::size_t size = at(values.size) * lanes;
    std::copy_n(row.data() + place() * size, size, reinterpret_cast<double*>(values.value));
    forget_eroded(values);
    return values.data();
  }
  NodalValues vectors(std::span<const double> field) const { return gather(field, d.dim()); }
  /// A displacement, zero where the cell has left: what its nodes do is no deformation any more.
  NodalValues displaced(std::span<const double> field) const {
    NodalValues values = vectors(field);
    forget_eroded(values);
    return values;
  }
  template <int most> void forget_eroded(BatchArray<most>& values) const { forget(eroded, values); }
  void forget_weightless(NodalValues& values) const { forget(weightless, values); }
  NodalValues scalars(std::span<const double> field) const { return gather(field, 1); }
  /// Nodal values to be filled; to be summed up, 0 at first; and their sum into a field.
  NodalValues nodal(int components) const { return NodalValues(nodes() * components); }
  NodalValues zero(int components) const {
    NodalValues values = nodal(components);
    std::fill_n(values.value, values.size, Batch(0.0));
    return values;
  }
  void scatter(const NodalValues& values, std::vector<double>& field) const {
    scatter_add(group, number, values.size / nodes(), values.data(), field.data());
  }
  /// Without the cells that have left.
  void scatter_live(NodalValues& values, std::vector<double>& field) const {
    forget_eroded(values);
    scatter(values, field);
  }

  /// Point values as they come: of a constant number of components, of histories, of stresses.
  template <int components> PointValues<components> points() const { return PointValues<components>(group); }
  PointValues<max_history_size> histories() const {
    return PointValues<max_history_size>(group, history_size(d.frame));
  }
  PointValues<max_stress_size> stresses() const {
    return PointValues<max_stress_size>(group, stress_size(d.frame));
  }
  template <int most> void load(std::span<const double> row, PointValues<most>& values) const {
    std::copy_n(row.data() + place(values), values.size * lanes, reinterpret_cast<double*>(values.value));
  }
  template <int components> PointValues<components> load(std::span<const double> row) const {
    PointValues<components> values(group);
    load(row, values);
    return values;
  }
  template <int most> void store(const PointValues<most>& values, std::vector<double>& row) const {
    std::copy_n(reinterpret_cast<const double*>(values.value), values.size * lanes,
                row.data() + place(values));
  }

private:
  template <int most> static void forget(int gone, BatchArray<most>& values) {
    for (int l = 0; gone != 0 && l < lanes; ++l)
      for (int i = 0; (gone & (1 << l)) != 0 && i < values.size; ++i) values.value[i].set(l, 0);
  }
  template <int most> std::size_t place(const PointValues<most>& values) const {
    return first_point * at(values.components) + at(number) * at(values.size) * lanes;
  }
};

/// body(const CellBatch&) for all cells whose law `takes` says yes to, group by group.
template <class Takes, class Body> void for_each_batch(const Discretisation& d, Takes&& takes, Body&& body) {
  std::size_t point = 0, cell = 0;
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    const CellKernels& kernels = group.shape.kernels(d.frame);
    if (takes(d.law(group)))
      for (int b = 0; b < group.batch_count; ++b)
        body(CellBatch{d, group, d.law(group), kernels, static_cast<int>(g), b, point, cell,
                       d.eroded.in_batch(cell / lanes + at(b)),
                       d.weightless.empty() ? 0 : d.weightless[cell / lanes + at(b)]});
    point += point_values(group, 1);
    cell += at(group.batch_count) * lanes;
  }
}
inline constexpr auto all_laws = [](const PointLaw&) { return true; };
inline constexpr auto deformable = [](const PointLaw& law) { return !law.rigid(); };
inline constexpr auto damages = [](const PointLaw& law) { return law.parameters.damage != Damage::none; };
inline constexpr auto fails = [](const PointLaw& law) { return law.fails(); };
inline constexpr auto fatigues = [](const PointLaw& law) { return law.fatigues(); };

} // namespace impact
