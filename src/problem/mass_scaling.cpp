#include "motion_batch.hpp"
#include <algorithm>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/motion.hpp>

/// Mass that lengthens the stable step of central differences.
namespace impact {

// With s times its mass a cell is stable for mu (C dt^2 + 2 D dt) <= 4 s: two evaluations give mu C and mu D.
const MassScaling& MotionProblem::scale_mass(Vec u, const std::vector<double>& u_n, double dt,
                                             const BulkViscosity& bulk, double wanted, StateRow& factors) {
  d_.displacement.to_local(u, u_);
  std::fill(factors.committed.begin(), factors.committed.end(), 1.0);
  const double large = 4;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    MotionFields fields = step_fields(u_, nullptr, batch.law);
    fields.u_n = &u_n;
    fields.dt = dt;
    fields.bulk = bulk;
    MotionBatch cells(batch, fields);
    cells.in.mass_factor = Batch(1.0);
    const Batch one = batch.kernels.stable_step(batch.law, cells.in);
    cells.in.mass_factor = Batch(large);
    const Batch more = batch.kernels.stable_step(batch.law, cells.in);
    auto factor = batch.load<1>(factors.committed);
    for (int l = 0; l < batch.used(); ++l) {
      const double x = one[l], y = more[l]; // a x^2 + b x = 1, a y^2 + b y = large
      const double a = (large / y - 1 / x) / (y - x), b = 1 / x - a * x;
      const double needed = std::max(1.0, wanted * (a * wanted + b));
      for (Batch& at_point : factor.all()) at_point.set(l, needed);
    }
    batch.store(factor, factors.committed);
  });
  return use_mass(factors);
}

const MassScaling& MotionProblem::use_mass(const StateRow& factors) {
  scaling_ = {};
  mass_.scale(&factors.committed);
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const auto factor = batch.load<1>(factors.committed);
    for (int l = 0; l < batch.used(); ++l) scaling_.cells += factor.value[0][l] > 1 ? 1 : 0;
  });
  const PetscReal all = Get(VecSum)(mass_.lumped()), before = Get(VecSum)(mass_.true_lumped());
  scaling_.cells = sum_over_ranks(d_.mesh.comm(), scaling_.cells);
  scaling_.added = d_.thickness * (all - before) / d_.dim();
  scaling_.share = (all - before) / before;
  return scaling_;
}

} // namespace impact
