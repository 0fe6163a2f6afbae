#pragma once
#include <algorithm>
#include <impact/kernel/frame.hpp>
#include <impact/material/point_law.hpp>
#include <impact/math/batch.hpp>
#include <span>

/// What is kept at each quadrature point from step to step, component by component. The structs are the
/// layout: kernels read the rows "history" and "drive" of a batch, [point][component], through the two
/// functions at the end, and what looks at whole rows, [group][batch][point][component][lane], stands here
/// too.
namespace impact {

/// At the start A = Cp^-1 = 1 and the rest 0.
template <Frame frame> struct HistoryOf : PointHistory<Batch, dimension(frame)> {};
template <> struct HistoryOf<Frame::plane_stress> : PointHistory<Batch, 2> {
  Batch stretch; ///< F_33 - 1
};

/// Energies that drive damage.
struct Drive {
  Batch plus, minus; ///< E+, E-
  Batch plastic; ///< H_0(alpha) or what of it is above the threshold; its sum over the steps where the law
                 ///< softens
};

template <Frame frame> inline constexpr int history_size_of = sizeof(HistoryOf<frame>) / sizeof(Batch);
constexpr int history_size(Frame f) {
  return f == Frame::solid          ? history_size_of<Frame::solid>
         : f == Frame::plane_stress ? history_size_of<Frame::plane_stress>
                                    : history_size_of<Frame::plane_strain>;
}
inline constexpr int max_history_size = history_size(Frame::solid);
inline constexpr int drive_size = sizeof(Drive) / sizeof(Batch);

/// Sets a row of histories to that of a virgin body.
inline void set_virgin(Frame frame, std::span<double> row) {
  const auto size = static_cast<std::size_t>(history_size(frame));
  for (std::size_t i = 0; i < row.size(); ++i) row[i] = i / lanes % size < 3 ? 1 : 0; // A11 A22 A33
}

/// Largest alpha in a row of histories, at least 0.
inline double largest_alpha(Frame frame, std::span<const double> row) {
  const auto size = static_cast<std::size_t>(history_size(frame)) * lanes;
  double largest = 0;
  for (std::size_t i = static_cast<std::size_t>(symmetric_size(dimension(frame))) * lanes; i < row.size();
       i += size)
    for (std::size_t l = 0; l < lanes; ++l) largest = std::max(largest, row[i + l]);
  return largest;
}

template <Frame frame> const HistoryOf<frame>& history_at(const Batch* history, int q) {
  return reinterpret_cast<const HistoryOf<frame>*>(history)[q];
}
template <Frame frame> HistoryOf<frame>& history_at(Batch* history, int q) {
  return reinterpret_cast<HistoryOf<frame>*>(history)[q];
}
inline const Drive& drive_at(const Batch* drive, int q) { return reinterpret_cast<const Drive*>(drive)[q]; }
inline Drive& drive_at(Batch* drive, int q) { return reinterpret_cast<Drive*>(drive)[q]; }

} // namespace impact
