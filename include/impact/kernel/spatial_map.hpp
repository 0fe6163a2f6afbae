#pragma once
#include <concepts>
#include <impact/kernel/motion_point.hpp>
#include <impact/material/modulus.hpp>

/// From a point to the dofs of its cell in the current configuration: the force of a Kirchhoff stress and the
/// stiffness of a spatial modulus, r_ai = int tau_ij g_a,j dV_0 and K_ai,bk = int g_a,j a_ij,kl g_b,l dV_0
/// with g_a,j = dN_a/dx_j.
namespace impact {

template <class Cell> inline constexpr int dofs = Cell::nodes* Cell::dim;

/// Loops over the nodes of larger cells stay loops: unrolled they take minutes to compile and are no faster.
inline constexpr int few_nodes = 10;

/// The map of the current configuration at one point: inverse[k * dim + j] = dxi_k/dx_j and, axisymmetric,
/// 1/r.
template <class Cell, Frame frame> struct CurrentMap {
  Batch inverse[Cell::dim * Cell::dim];
  Batch inverse_r;
};

template <class Cell, Frame frame>
inline void current_map(const PointMap<Cell, frame>& map, const Tensor<Batch, Cell::dim>& inverse_F,
                        CurrentMap<Cell, frame>& out) {
  constexpr int d = Cell::dim;
  for (int k = 0; k < d; ++k)
    for (int i = 0; i < d; ++i)
      out.inverse[k * d + i] = sum<d>([&](int j) { return map.inverse[k * d + j] * inverse_F[d * j + i]; });
  if constexpr (frame == Frame::axisymmetric) out.inverse_r = map.inverse_R * inverse_F[4];
}

/// Spatial gradients g_a of the shape functions, with N_a/r in the axisymmetric frame.
template <class Cell, Frame frame> struct SpatialGradients {
  Batch g[Cell::nodes][Cell::dim];
  Batch ring[frame == Frame::axisymmetric ? Cell::nodes : 1];
};

template <class Cell, Frame frame>
inline void spatial_gradients(const CurrentMap<Cell, frame>& map, const double (&N)[Cell::nodes],
                              const double (&dN)[Cell::nodes][Cell::dim],
                              SpatialGradients<Cell, frame>& out) {
  constexpr int d = Cell::dim;
  for (int a = 0; a < Cell::nodes; ++a)
    for (int i = 0; i < d; ++i)
      out.g[a][i] = sum<d>([&](int k) { return dN[a][k] * map.inverse[k * d + i]; });
  if constexpr (frame == Frame::axisymmetric)
    for (int a = 0; a < Cell::nodes; ++a) out.ring[a] = N[a] * map.inverse_r;
}

/// Fluxes of the internal force at the points, r_ai = int tau_ij g_a,j dV_0: w tau_ij dxi_k/dx_j, which
/// multiply dN_a/dxi_k, and w tau_33/r, which multiplies N_a in the radial force of the axisymmetric frame.
template <class Cell, Frame frame> struct Fluxes {
  Batch flux[Cell::points][Cell::dim * Cell::dim];
  Batch hoop[frame == Frame::axisymmetric ? Cell::points : 1];

  void set(int q, const CurrentMap<Cell, frame>& map, const Batch& weight,
           const Symmetric<Batch, Cell::dim>& tau) {
    constexpr int d = Cell::dim;
    const Symmetric<Batch, d> w = weight * tau;
    for (int i = 0; i < d; ++i)
      for (int k = 0; k < d; ++k)
        flux[q][i * d + k] =
            sum<d>([&](int j) { return w[symmetric_index(d, i, j)] * map.inverse[k * d + j]; });
    if constexpr (frame == Frame::axisymmetric) hoop[q] = w[2] * map.inverse_r;
  }

  void add_forces(Batch* r) const {
    constexpr int d = Cell::dim;
    add_nodal_forces<Cell, d>(flux, r);
    if constexpr (frame == Frame::axisymmetric)
      for (int q = 0; q < Cell::points; ++q)
        for (int a = 0; a < Cell::nodes; ++a) r[a * d] += shape_table<Cell>.N[q][a] * hoop[q];
  }
};

/// K_ai,bk += w g_a,j a_ij,kl g_b,l; only blocks a <= b where `upper`. One column bk after the other, so that
/// its w a_ij,kl g_b,l stay in registers while the rows pass; of few nodes unrolled, because branches at the
/// end of loops of one to eight rounds are mispredicted.
template <class Cell, Frame frame, bool upper>
inline void add_stiffness(const SpatialGradients<Cell, frame>& G,
                          const Modulus<Batch, gradient_size(frame)>& a, const Batch& weight, Batch* K) {
  constexpr int d = Cell::dim, n = gradient_size(frame), m = dofs<Cell>;
  const auto add_column = [&](auto b) {
    Batch g[d];
    for (int l = 0; l < d; ++l) g[l] = weight * G.g[b][l];
    for (int k = 0; k < d; ++k) {
      Batch D[n];
      for (int I = 0; I < n; ++I) {
        D[I] = sum<d>([&](int l) { return a.c[I][d * k + l] * g[l]; });
        if constexpr (frame == Frame::axisymmetric)
          if (k == 0) D[I] += a.c[I][4] * (weight * G.ring[b]);
      }
      const auto add_block = [&](auto c) {
        Batch* column = K + c * d * m + b * d + k;
        for (int i = 0; i < d; ++i) {
          Batch s = column[i * m];
          for (int j = 0; j < d; ++j) s += G.g[c][j] * D[d * i + j];
          if constexpr (frame == Frame::axisymmetric)
            if (i == 0) s += G.ring[c] * D[4];
          column[i * m] = s;
        }
      };
      if constexpr (std::same_as<decltype(b), int>)
        for (int c = 0; c < (upper ? b + 1 : Cell::nodes); ++c) add_block(c);
      else
        unroll<(upper ? b + 1 : Cell::nodes)>(add_block);
    }
  };
  if constexpr (Cell::nodes > few_nodes)
    for (int b = 0; b < Cell::nodes; ++b) add_column(b);
  else
    unroll<Cell::nodes>(add_column);
}

/// v_ai: derivative of the volume ratio J with respect to u_ai, J g_a.
template <class Cell, Frame frame>
inline Batch volume_gradient(const SpatialGradients<Cell, frame>& G, int a, int i) {
  if constexpr (frame == Frame::axisymmetric)
    if (i == 0) return G.g[a][0] + G.ring[a];
  return G.g[a][i];
}

} // namespace impact
