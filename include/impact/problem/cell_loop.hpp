#pragma once
#include <array>
#include <cstring>
#include <impact/problem/discretisation.hpp>
#include <optional>
#include <span>

/// The loop over batches of cells: gather, kernel, scatter, with the shape and the frame as compile-time
/// constants.
namespace impact {

/// Calls body.template operator()<Cell, frame>() for the shape of `group`.
template <class Body> void with_shape(const CellGroup& group, Frame frame, Body&& body) {
  switch (group.shape) {
  case Shape::tri3:
    if (frame == Frame::plane_stress) return body.template operator()<Tri3, Frame::plane_stress>();
    return frame == Frame::axisymmetric ? body.template operator()<Tri3, Frame::axisymmetric>()
                                        : body.template operator()<Tri3, Frame::plane_strain>();
  case Shape::quad4:
    if (frame == Frame::plane_stress) return body.template operator()<Quad4, Frame::plane_stress>();
    return frame == Frame::axisymmetric ? body.template operator()<Quad4, Frame::axisymmetric>()
                                        : body.template operator()<Quad4, Frame::plane_strain>();
  case Shape::tet4:
    return body.template operator()<Tet4, Frame::solid>();
  case Shape::hex8:
    return body.template operator()<Hex8, Frame::solid>();
  }
}

template <int size> using Batches = std::array<Batch, at(size)>;

/// One nodal field of a batch, [node][components], gathered from a local array.
template <class Cell, int components> struct Gathered {
  Batches<Cell::nodes * components> value;
  Gathered() = default;
  Gathered(const CellGroup& group, int batch, std::span<const double> local) {
    gather<Cell, components>(group, batch, local.data(), value.data());
  }
  const Batch* data() const { return value.data(); }
};

/// Point data of one batch, [point][components], copied from and to a row
/// [group][batch][point][component][lane] (rows are ordinary arrays of double without the alignment of a
/// Batch).
template <class Cell, int components> struct PointValues {
  static constexpr std::size_t size = at(Cell::points * components);
  Batches<Cell::points * components> value;
  void load(std::span<const double> row, std::size_t offset, int batch) {
    std::memcpy(value.data(), row.data() + offset + at(batch) * size * lanes, sizeof(value));
  }
  void store(std::vector<double>& row, std::size_t offset, int batch) const {
    std::memcpy(row.data() + offset + at(batch) * size * lanes, value.data(), sizeof(value));
  }
  Batch* data() { return value.data(); }
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

/// Rows and columns of held dofs, whose `free` is 0, vanish from a cell matrix [dof][dof].
template <int n> void mask(const Batch* free, Batch* K) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) K[i * n + j] *= free[i] * free[j];
}

template <int n> Batch trace(const Batch* K) {
  Batch sum = K[0];
  for (int i = 1; i < n; ++i) sum += K[i * n + i];
  return sum;
}

/// One batch of the loop below. Fields are local arrays [node][components], rows
/// [group][batch][point][component] [lane].
template <class Cell_, Frame frame_> struct CellBatch {
  using Cell = Cell_;
  static constexpr Frame frame = frame_;
  static constexpr int dim = Cell::dim, nodes = Cell::nodes;

  const CellGroup& group;
  const PointLaw& law;
  int number_of_group, number;
  std::size_t first_point; ///< of the group, in a row of one component

  int used() const { return group.lanes_in_use(number); }
  /// Those bits of `bad` that belong to cells of their own.
  int broken(int bad) const { return bad & ((1 << used()) - 1); }
  std::size_t material() const { return at(group.material); }
  double sum(const Batch& value) const { return lane_sum(value, used()); }

  template <int components> Gathered<Cell, components> gather(std::span<const double> field) const {
    return {group, number, field};
  }
  /// Where the values of a nodal field or of a row stand, for a kernel; null without one.
  template <int components>
  const Batch* read(const std::vector<double>* field, Gathered<Cell, components>& values) const {
    if (field == nullptr) return nullptr;
    impact::gather<Cell, components>(group, number, field->data(), values.value.data());
    return values.data();
  }
  template <int components>
  const Batch* read(const std::vector<double>* row, PointValues<Cell, components>& values) const {
    if (row == nullptr) return nullptr;
    load(*row, values);
    return values.data();
  }
  template <int components> void scatter(const Batch* values, std::vector<double>& field) const {
    scatter_add<Cell, components>(group, number, values, field.data());
  }
  template <int components>
  void load(std::span<const double> row, PointValues<Cell, components>& values) const {
    values.load(row, first_point * components, number);
  }
  template <int components> PointValues<Cell, components> load(std::span<const double> row) const {
    PointValues<Cell, components> values;
    load(row, values);
    return values;
  }
  template <int components>
  void store(const PointValues<Cell, components>& values, std::vector<double>& row) const {
    values.store(row, first_point * components, number);
  }
};

/// body(const CellBatch<Cell, frame>&) for all cells whose law `takes` says yes to, group by group, with the
/// shape and the frame as compile-time constants.
template <class Takes, class Body> void for_each_batch(const Discretisation& d, Takes&& takes, Body&& body) {
  std::size_t first = 0;
  for (std::size_t g = 0; g < d.groups.size(); ++g) {
    const CellGroup& group = d.groups[g];
    if (takes(d.law(group)))
      with_shape(group, d.frame, [&]<class Cell, Frame frame>() {
        for (int b = 0; b < group.batch_count; ++b)
          body(CellBatch<Cell, frame>{group, d.law(group), static_cast<int>(g), b, first});
      });
    first += point_values(group, 1);
  }
}
inline constexpr auto all_laws = [](const PointLaw&) { return true; };
inline constexpr auto deformable = [](const PointLaw& law) { return !law.rigid(); };
inline constexpr auto damages = [](const PointLaw& law) { return law.parameters.damage != Damage::none; };
inline constexpr auto fatigues = [](const PointLaw& law) { return law.fatigues(); };

} // namespace impact
