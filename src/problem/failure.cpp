#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/failure.hpp>

namespace impact {

bool grow_failure(const Discretisation& d, StateTable& state, const FailureStep& step) {
  StateRow &failure = state.row("jc_failure"), &history = state.row("history");
  bool sound = true;
  PatchState patches;
  share_volumes(d, {step.u, step.phi, step.theta, &history.trial}, patches);
  for_each_batch(d, fails, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), u = batch.displaced(*step.u);
    NodalValues phi = batch.nodal(1), theta = batch.nodal(1);
    auto now = batch.histories(), before = batch.histories();
    BatchArray<1> patch(1);
    BatchArray<2> pressure(2);
    auto grown = batch.points<1>(), old = batch.load<1>(failure.committed);
    MotionInput in;
    in.X = X.data();
    in.u = in.u_n = u.data();
    in.phi = batch.read(step.phi, phi);
    in.theta = batch.read(step.theta, theta);
    in.history = batch.read(&history.trial, now);
    in.patch = batch.read_shared(patches.J_minus_1, patch);
    in.patch_pressure = batch.read_shared(patches.pressure, pressure);
    in.dt = step.dt;
    batch.load(history.committed, before);
    if (batch.broken(batch.kernels.failure_advance(batch.law, in, before.data(), old.data(), grown.data())) !=
        0)
      sound = false;
    batch.store(grown, failure.trial);
  });
  return all_ranks_agree(d.mesh.comm(), sound);
}

} // namespace impact
