#include "stored_input.hpp"

#include <algorithm>
#include <impact/balance/release.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/math/rotation.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

// `at_rest`: not at all.
bool moves_alike(const NodalValues& moved, int dim, bool at_rest) {
  for (int i = at_rest ? 0 : dim; i < moved.size; ++i)
    for (int l = 0; l < lanes; ++l)
      if (moved.value[i][l] != (at_rest ? 0 : moved.value[i % dim][l])) return false;
  return true;
}

Vector<Batch, 3> mean_of(const NodalValues& values, int components) {
  const int nodes = values.size / components;
  Vector<Batch, 3> mean{Batch(0.0), Batch(0.0), Batch(0.0)};
  for (int i = 0; i < values.size; ++i) mean[i % components] += values.value[i] * Batch(1.0 / nodes);
  return mean;
}

// Of the linear function that fits nodal values over a cell best.
Vector<Batch, 3> slope_of(const NodalValues& values, const NodalValues& X, int dim) {
  const Vector<Batch, 3> centre = mean_of(X, dim), mean = mean_of(values, 1);
  Symmetric<Batch, 3> M;
  for (int i = 0; i < 6; ++i) M[i] = Batch(dim == 2 && i == 2 ? 1.0 : 0.0);
  Vector<Batch, 3> r{Batch(0.0), Batch(0.0), Batch(0.0)};
  for (int a = 0; a < values.size; ++a)
    for (int i = 0; i < dim; ++i) {
      const Batch x = X.value[a * dim + i] - centre[i];
      r[i] += x * (values.value[a] - mean[0]);
      for (int j = i; j < dim; ++j) M[symmetric_index(3, i, j)] += x * (X.value[a * dim + j] - centre[j]);
    }
  Tensor<Batch, 3> full;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) full[3 * i + j] = M[symmetric_index(3, i, j)];
  const Tensor<Batch, 3> inverted = inverse(full, det(M));
  Vector<Batch, 3> slope;
  for (int i = 0; i < 3; ++i)
    slope[i] = inverted[3 * i] * r[0] + inverted[3 * i + 1] * r[1] + inverted[3 * i + 2] * r[2];
  return slope;
}

// The temperature stays in its place while nodes move.
void leave_temperature(NodalValues& theta, const Vector<Batch, 3>& slope, const NodalValues& moved,
                       double part) {
  const int dim = moved.size / theta.size;
  for (int i = 0; i < moved.size; ++i) theta.value[i / dim] += part * slope[i % dim] * moved.value[i];
}

// The stiffness does too: what it becomes in a cell, over what it is.
Batch stiffness(const CellBatch& batch, const NodalValues& X, const NodalValues& moved, double part) {
  const auto& E = batch.d.materials[batch.material()].E_of_place;
  const int dim = batch.d.dim();
  const Vector<Batch, 3> centre = mean_of(X, dim), way = mean_of(moved, dim);
  Batch factor = Batch(1.0);
  for (int l = 0; l < batch.used(); ++l) {
    double here[3] = {0, 0, 0}, there[3] = {0, 0, 0};
    for (int k = 0; k < dim; ++k) {
      here[k] = centre[k][l];
      there[k] = here[k] + part * way[k][l];
    }
    factor.set(l, E(there) / E(here));
  }
  return factor;
}

// Of a facet by its corners, of length one.
Vector3 normal_of(const Mesh& mesh, const int* node) {
  const auto X = mesh.coordinates();
  const int dim = mesh.dim();
  const auto edge = [&](int a) {
    Vector3 way{};
    for (int k = 0; k < dim; ++k) way[at(k)] = X[at(dim * node[a] + k)] - X[at(dim * node[0] + k)];
    return way;
  };
  Vector3 normal = dim == 2 ? Vector3{edge(1)[1], -edge(1)[0], 0} : cross(edge(1), edge(2));
  const double size = std::sqrt(dot(normal, normal));
  for (double& component : normal) component /= size;
  return normal;
}

} // namespace

void keep_sides(const Discretisation& d, const std::vector<double>& part, std::span<const double> phi,
                double broken, std::vector<double>& moved) {
  // At edges and where sides are curved several directions lie across: the sum of their squares tells all.
  const auto dim = at(d.dim());
  const FieldLayout layout(d.mesh, "sides", d.dim() * d.dim());
  std::vector<double> across = layout.make_local();
  const FacetTable facets = d.mesh.outer_facets();
  const auto width = at(facets.nodes_per_facet);
  for (std::size_t f = 0; f < facets.point.size(); ++f) {
    const int* node = &facets.connectivity[width * f];
    if (!phi.empty() && std::all_of(node, node + width, [&](int n) { return phi[at(n)] > broken; })) continue;
    const Vector3 normal = normal_of(d.mesh, node);
    for (std::size_t a = 0; a < width; ++a)
      for (std::size_t i = 0; i < dim; ++i)
        for (std::size_t j = 0; j < dim; ++j)
          across[dim * (dim * at(node[a]) + i) + j] += normal[i] * normal[j];
  }
  add_up(layout, across);
  constexpr double much = 1e9; // what is left across the sides is this part
  for (std::size_t node = 0; node < part.size(); ++node) {
    const double* sides = &across[dim * dim * node];
    if (!(part[node] > 0 && part[node] < 1) || sides[0] + sides[dim + 1] + (dim == 3 ? sides[8] : 0) == 0)
      continue;
    Matrix3 weight = unit_matrix;
    Vector3 way{};
    for (std::size_t i = 0; i < dim; ++i) {
      way[i] = moved[dim * node + i];
      for (std::size_t j = 0; j < dim; ++j) weight[3 * i + j] += much * sides[dim * i + j];
    }
    const Vector3 along = inverse(weight) * way;
    std::copy_n(along.begin(), dim, &moved[dim * node]);
  }
}

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
    const NodalValues along = batch.vectors(moved), X = batch.vectors(d.mesh.coordinates());
    const bool expands = rows.theta && batch.law.parameters.alpha_t != 0,
               graded = static_cast<bool>(d.materials[batch.material()].E_of_place);
    // Rings about an axis change their length.
    if (moves_alike(along, d.dim(), expands || graded || d.frame == Frame::axisymmetric)) return;
    const Vector<Batch, 3> slope =
        expands ? slope_of(batch.gather(rows.theta->committed, 1), X, d.dim()) : Vector<Batch, 3>{};
    EnergySums sums[2];
    for (const int side : {0, 1}) {
      const double way = side == 0 ? -part : part;
      StoredInput stored(batch, rows, places[side], u_local, {}, false);
      if (expands) leave_temperature(stored.theta, slope, along, way);
      batch.kernels.stored_energy(batch.law, stored.in, sums[side]);
      if (graded) sums[side].elastic *= stiffness(batch, X, along, way);
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
