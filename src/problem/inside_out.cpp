#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/inside_out.hpp>

namespace impact {

namespace {

// Determinant of the map from the reference cell at one of its corners, by the bits of `corner`; x
// [node][dim].
double corner_volume(const Shape& shape, const NodalValues& x, int lane, unsigned corner) {
  double xi[3], N[8], dN[24], map[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (unsigned k = 0; k < 3; ++k) xi[k] = (corner >> k & 1U) != 0 ? 1 : -1;
  shape->basis(xi, N, dN);
  const int dim = shape->dim;
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) {
      double& entry = map[3 * i + j] = 0;
      for (int a = 0; a < shape->nodes; ++a) entry += x.value[a * dim + i][lane] * dN[a * dim + j];
    }
  return map[0] * (map[4] * map[8] - map[5] * map[7]) - map[1] * (map[3] * map[8] - map[5] * map[6]) +
         map[2] * (map[3] * map[7] - map[4] * map[6]);
}

bool is_inside_out(const CellBatch& batch, const NodalValues& X, const NodalValues& x, int lane) {
  const Shape& shape = batch.group.shape;
  for (unsigned corner = 0; corner < 1U << shape->dim; ++corner)
    if (corner_volume(shape, x, lane, corner) * corner_volume(shape, X, lane, corner) < 0) return true;
  return false;
}

} // namespace

std::string tell_of_inside_out(const Discretisation& d, Vec u) {
  const std::vector<double> local = d.local_of(u);
  std::vector<long> cells(d.materials.size(), 0);
  for_each_batch(
      d, [](const PointLaw& law) { return !law.rigid() && law.parameters.locking == Locking::mean; },
      [&](const CellBatch& batch) {
        if (batch.group.shape->order() != 1 || batch.group.shape->simplex()) return;
        const NodalValues X = batch.vectors(d.mesh.coordinates()), moved = batch.displaced(local);
        NodalValues x = X;
        for (int i = 0; i < x.size; ++i) x.value[i] += moved.value[i];
        for (int l = 0; l < batch.used(); ++l)
          if (batch.live(l)) cells[at(batch.material())] += is_inside_out(batch, X, x, l) ? 1 : 0;
      });
  sum_over_ranks(d.mesh.comm(), cells);
  std::string text;
  for (std::size_t m = 0; m < cells.size(); ++m)
    if (cells[m] > 0)
      text += "impact: WARNING: " + std::to_string(cells[m]) + " cells of material " + d.materials[m].id +
              " are turned inside out at a corner, which their mean volume does not feel: take -material_" +
              d.materials[m].id + "_locking fbar" +
              (d.materials[m].law.parameters.equation_of_state == EquationOfState::none
                   ? ""
                   : ", or none where the shear modulus is small beside the pressure") +
              ", or cells of better shape there\n";
  return text;
}

} // namespace impact
