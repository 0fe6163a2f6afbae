#pragma once
#include <impact/kernel/advance_cell.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/kernel/damage_cell.hpp>
#include <impact/kernel/distortion.hpp>
#include <impact/kernel/failure_cell.hpp>
#include <impact/kernel/heat_cell.hpp>
#include <impact/kernel/measure_cell.hpp>
#include <impact/kernel/motion_cell.hpp>
#include <impact/kernel/shape.hpp>
#include <impact/kernel/stable_step.hpp>
#include <impact/kernel/volume_cell.hpp>

/// Makes of the struct of a cell the record that a run uses: all kernels are compiled here, once per shape.
namespace impact {

template <class Cell, Frame frame>
inline constexpr CellKernels cell_kernels = {
    .motion_residual = motion_residual<Cell, frame>,
    .motion_tangent = motion_tangent<Cell, frame>,
    .motion_advance = motion_advance<Cell, frame>,
    .motion_step = motion_step<Cell, frame>,
    .highest_frequency = highest_frequency<Cell, frame>,
    .cell_volume = cell_volume<Cell, frame>,
    .volume_slope = volume_slope<Cell, frame>,
    .cell_pressure = cell_pressure<Cell, frame>,
    .damage_residual = damage_residual<Cell, frame>,
    .damage_tangent = damage_tangent<Cell, frame>,
    .damage_dissipation = damage_dissipation<Cell>,
    .fatigue_advance = fatigue_advance<Cell, frame>,
    .failure_advance = failure_advance<Cell, frame>,
    .heat_step = heat_step<Cell, frame>,
    .heat_residual = heat_residual<Cell, frame>,
    .heat_tangent = heat_tangent<Cell, frame>,
    .heat_source = heat_source<Cell, frame>,
    .pressure_work = pressure_work<Cell, frame>,
    .stored_energy = stored_energy<Cell, frame>,
    .stored_heat = stored_heat<Cell, frame>,
    .cell_integral = cell_integral<Cell, frame>,
    .inertial_release = inertial_release<Cell, frame>,
    .plastic_exchange = plastic_exchange<Cell, frame>,
    .unilateral_energy = unilateral_energy<Cell, frame>,
    .cell_output = cell_output<Cell, frame>,
    .cell_distortion = cell_distortion<Cell, frame>,
    .mass_matrix = mass_matrix<Cell, frame>,
};

template <class Cell> void cell_basis(const double* xi, double* N, double* dN) {
  typename Cell::Point x{};
  for (std::size_t k = 0; k < Cell::dim; ++k) x[k] = xi[k];
  const auto value = Cell::N(x);
  const auto slope = Cell::dN(x);
  for (std::size_t a = 0; a < Cell::nodes; ++a) {
    N[a] = value[a];
    for (std::size_t k = 0; k < Cell::dim; ++k) dN[a * Cell::dim + k] = slope[a][k];
  }
}

template <class Cell> constexpr CellShape cell_shape() {
  static_assert(Cell::nodes <= max_nodes && Cell::points <= max_points);
  constexpr auto& table = shape_table<Cell>;
  CellShape s = {.names = Cell::names,
                 .dim = Cell::dim,
                 .nodes = Cell::nodes,
                 .points = Cell::points,
                 .volume_modes = volume_modes<Cell>,
                 .facets = Cell::facets,
                 .from_plex = Cell::from_plex,
                 .edges = {},
                 .faces = {},
                 .middle = has_middle<Cell>,
                 .from_gmsh = {},
                 .N = table.N[0],
                 .dN = table.dN[0][0],
                 .weight = table.weight,
                 .centroid = {},
                 .kernels = {},
                 .basis = cell_basis<Cell>,
                 .size = cell_size<Cell>};
  if constexpr (is_second_order<Cell>) {
    s.edges = Cell::edges;
    s.from_gmsh = Cell::from_gmsh;
    if constexpr (has_faces<Cell>) s.faces = Cell::faces;
  }
  for (std::size_t k = 0; k < Cell::dim; ++k) s.centroid[k] = Cell::centroid()[k];
  const auto in = [&s](Frame frame, const CellKernels& kernels) {
    s.kernels[static_cast<std::size_t>(frame)] = &kernels;
  };
  if constexpr (Cell::dim == 3) {
    in(Frame::solid, cell_kernels<Cell, Frame::solid>);
  } else {
    in(Frame::plane_strain, cell_kernels<Cell, Frame::plane_strain>);
    in(Frame::plane_stress, cell_kernels<Cell, Frame::plane_stress>);
    in(Frame::axisymmetric, cell_kernels<Cell, Frame::axisymmetric>);
  }
  return s;
}

} // namespace impact
