#pragma once
#include <array>
#include <cstring>
#include <impact/problem/discretisation.hpp>
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

/// One nodal field of a batch, [node][components], gathered from a local array.
template <class Cell, int components> struct Gathered {
  std::array<Batch, static_cast<std::size_t>(Cell::nodes* components)> value;
  Gathered(const CellGroup& group, int batch, const std::vector<double>& local) {
    gather<Cell, components>(group, batch, local.data(), value.data());
  }
  const Batch* data() const { return value.data(); }
};

/// Point data of one batch, [point][components], copied from and to a row
/// [group][batch][point][component][lane] (rows are ordinary arrays of double without the alignment of a
/// Batch).
template <class Cell, int components> struct PointValues {
  static constexpr std::size_t size = static_cast<std::size_t>(Cell::points * components);
  std::array<Batch, size> value;
  void load(std::span<const double> row, std::size_t offset, int batch) {
    std::memcpy(value.data(), row.data() + offset + static_cast<std::size_t>(batch) * size * lanes,
                sizeof(value));
  }
  void store(std::vector<double>& row, std::size_t offset, int batch) const {
    std::memcpy(row.data() + offset + static_cast<std::size_t>(batch) * size * lanes, value.data(),
                sizeof(value));
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

} // namespace impact
