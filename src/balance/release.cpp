#include "stored_input.hpp"

#include <impact/balance/release.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

bool moves_alike(const NodalValues& moved, const Discretisation& d) {
  const bool about_axis = d.frame == Frame::axisymmetric; // where that changes the length of rings
  const int dim = d.dim();
  for (int i = about_axis ? 0 : dim; i < moved.size; ++i)
    for (int l = 0; l < lanes; ++l)
      if (moved.value[i][l] != (about_axis ? 0 : moved.value[i % dim][l])) return false;
  return true;
}

} // namespace

// By a difference of the energies of each cell over a small part of it. Cells in patches count with their own
// volume ratio.
double find_release(const Discretisation& d, const BodyRows& rows, Vec u, const std::vector<double>& moved) {
  const std::vector<double> u_local = d.local_of(u);
  const double part = 1e-4 * d.mesh.smallest_edge();
  std::vector<double> places[2];
  for (const int side : {0, 1}) {
    const auto X = d.mesh.coordinates();
    places[side].assign(X.begin(), X.end());
    for (std::size_t i = 0; i < X.size(); ++i) places[side][i] += (side == 0 ? -part : part) * moved[i];
  }
  double released = 0;
  for_each_batch(d, deformable, [&](const CellBatch& batch) {
    if (moves_alike(batch.vectors(moved), d)) return;
    EnergySums sums[2];
    for (const int side : {0, 1}) {
      const StoredInput stored(batch, rows, places[side], u_local, {}, false);
      batch.kernels.stored_energy(batch.law, stored.in, sums[side]);
    }
    released += batch.live_sum(sums[0].elastic - sums[1].elastic);
  });
  return sum_over_ranks(d.mesh.comm(), released) / (2 * part);
}

double find_inertial_release(const Discretisation& d, Vec u, const std::vector<double>& a,
                             const std::vector<double>& moved) {
  const std::vector<double> u_local = d.local_of(u);
  double released = 0;
  for_each_batch(d, deformable, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), at_nodes = batch.vectors(u_local),
               rate = batch.vectors(a), along = batch.vectors(moved);
    released += batch.live_sum(
        batch.kernels.inertial_release(batch.law, X.data(), at_nodes.data(), rate.data(), along.data()));
  });
  return sum_over_ranks(d.mesh.comm(), released);
}

} // namespace impact
