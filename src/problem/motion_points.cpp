#include "motion_batch.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/motion.hpp>
#include <utility>

/// The law at the solution: trial history, what drives damage, and what heat takes from the motion.
namespace impact {

namespace {

constexpr double negligible_growth = 1e-6; // of damage in a step, as far as its forces go

// Plastic and viscous dissipation and plastic work, then both dissipations of each material.
void add_losses(const CellBatch& batch, const StepSums& step, std::vector<double>& lost) {
  const double plastic = batch.live_sum(step.plastic_dissipation),
               viscous = batch.live_sum(step.viscous_dissipation);
  lost[0] += plastic;
  lost[1] += viscous;
  lost[2] += batch.live_sum(step.plastic_work);
  lost[3 + batch.material()] += plastic;
  lost[3 + batch.d.materials.size() + batch.material()] += viscous;
}

// The stress with twice its unilateral part.
void store_stress_twice(const CellBatch& batch, MotionInput in, const PatchState& twice, Batch* trial,
                        std::vector<double>& row) {
  BatchArray<2> pressure(2);
  auto stress = batch.stresses();
  StepSums unused;
  in.unilateral = 2;
  in.patch_pressure = batch.read_shared(twice.pressure, pressure);
  batch.kernels.motion_advance(batch.law, in, trial, nullptr, unused, {nullptr, stress.data()});
  batch.store(stress, row);
}

} // namespace

bool MotionProblem::advance(Vec u, Increments& sums, const HeatRows& heat, Vec internal) {
  const Timed timed(Event::motion_points);
  d_.displacement.to_local(u, u_);
  const std::size_t materials = d_.materials.size();
  std::vector<double>& lost = lost_;
  lost.assign(4 + 2 * materials, 0.0);
  // The unilateral stress acts over the step as a whole: not in that of its end, twice in what does work.
  const bool apart = heat.stress && step_.unilateral_carried != nullptr;
  double least = 0;
  bool sound = true;
  if (internal) {
    std::fill(r_.begin(), r_.end(), 0.0);
    forget_broken();
  }
  share(u_, apart ? 0 : 1, patches_);
  PatchState twice;
  if (apart && heat.step_stress) share(u_, 2, twice);
  MotionFields fields;
  const PointLaw* of = nullptr; // the law of the fields
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    if (std::exchange(of, &law) != &law) {
      fields = step_fields(u_, nullptr, law);
      fields.unilateral = apart ? 0 : 1;
      if (internal) fields.bulk = step_.bulk;
      if (law.softens()) fields.drive = &drive_->committed;
    }
    const MotionBatch cells(batch, fields);
    auto next = batch.histories();
    auto driving = batch.points<drive_size>();
    auto dissipation = batch.points<1>();
    auto stress = batch.stresses();
    StepSums step;
    const HeatFeed feed{heat.dissipation ? dissipation.data() : nullptr,
                        heat.stress ? stress.data() : nullptr};
    Batch *const trial = keeps_history(law) ? next.data() : nullptr, *const drive = drive_ && (damages(law) ||
                                                                                               law.softens())
                                                                                        ? driving.data()
                                                                                        : nullptr;
    if (apart && heat.step_stress) store_stress_twice(batch, cells.in, twice, trial, *heat.step_stress);
    if (internal)
      sound = step_cells(batch, cells.in, trial, drive, step, feed) && sound;
    else
      sound = batch.broken(batch.kernels.motion_advance(law, cells.in, trial, drive, step, feed).bad) == 0 &&
              sound;
    if (keeps_history(law)) batch.store(next, history_.trial);
    if (drive) batch.store(driving, drive_->trial);
    if (heat.dissipation) batch.store(dissipation, *heat.dissipation);
    if (heat.stress) batch.store(stress, *heat.stress);
    if (heat.step_stress && !apart) batch.store(stress, *heat.step_stress);
    add_losses(batch, step, lost);
    for (int l = 0; l < batch.used(); ++l)
      if (batch.live(l)) least = std::min(least, step.least_dissipation[l]);
  });
  const bool all_sound = sum_up(sound, least, sums);
  if (internal) put(r_, internal);
  return all_sound;
}

// One reduction: sums of the cells, how many ranks found a broken one, the least dissipation, and what waits.
bool MotionProblem::sum_up(bool sound, double least, Increments& sums) {
  const std::size_t materials = d_.materials.size(), broken = 3 + 2 * materials;
  lost_[broken] = sound ? 0 : 1;
  std::array<double, 2> worst = {-least, data_errors_.worst()};
  tally_.sum(lost_);
  tally_.largest(worst);
  tally_.reduce();
  data_errors_.agree(d_.mesh.comm(), worst[1]);
  const auto part = lost_.begin() + 3, half = part + static_cast<std::ptrdiff_t>(materials);
  sums.plastic_dissipation = lost_[0];
  sums.viscous_dissipation = lost_[1];
  sums.plastic_work = lost_[2];
  sums.least_dissipation = -worst[0];
  sums.plastic_part.assign(part, half);
  sums.viscous_part.assign(half, half + static_cast<std::ptrdiff_t>(materials));
  return lost_[broken] == 0;
}

// A step whose force is found with it, and added up.
bool MotionProblem::step_cells(const CellBatch& batch, const MotionInput& in, Batch* history, Batch* drive,
                               StepSums& sums, const HeatFeed& heat) {
  auto force = batch.zero(d_.dim());
  const CellStatus status =
      batch.kernels.motion_step(batch.law, in, history, drive, sums, heat, force.data());
  batch.scatter_live(force, r_);
  return check_cells(batch.group, batch.number, note_inverted(batch, status), status.min_J);
}

void MotionProblem::damage_force(Vec u, const std::vector<double>& phi, Vec change) {
  const Timed timed(Event::motion_residual);
  d_.displacement.to_local(u, u_);
  std::fill(r_.begin(), r_.end(), 0.0);
  PatchState changed;
  share(u_, step_.unilateral_scale, patches_);
  share_volumes(d_, {&u_, &phi, step_.theta, &history_.committed, step_.unilateral_scale, step_.warming},
                changed);
  for_each_batch(d_, damages, [&](const CellBatch& batch) {
    const NodalValues before = batch.scalars(*step_.phi), now = batch.scalars(phi);
    Batch most = Batch(0.0);
    for (int a = 0; a < batch.nodes(); ++a) most = max(most, abs(now.value[a] - before.value[a]));
    double grown = 0;
    for (int l = 0; l < lanes; ++l) grown = std::max(grown, most[l]);
    if (!(grown > negligible_growth) && !batch.patched()) return;
    MotionFields fields = step_fields(u_, nullptr, batch.law);
    const MotionBatch cells(batch, fields);
    MotionInput after = cells.in;
    BatchArray<2> pressure(2);
    after.phi = now.value;
    after.patch_pressure = batch.read_shared(changed.pressure, pressure);
    auto force = batch.zero(d_.dim()), old_force = batch.zero(d_.dim());
    batch.kernels.motion_residual(batch.law, after, force.data());
    batch.kernels.motion_residual(batch.law, cells.in, old_force.data());
    for (int i = 0; i < force.size; ++i) force.value[i] -= old_force.value[i];
    batch.scatter_live(force, r_);
  });
  put(r_, change);
}

} // namespace impact
