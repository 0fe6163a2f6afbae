#include "motion_batch.hpp"
#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/motion.hpp>

/// The law at the solution: trial history, what drives damage, and what heat takes from the motion.
namespace impact {

bool MotionProblem::advance(Vec u, Increments& sums, const HeatRows& heat, Vec internal) {
  const Timed timed(Event::motion_points);
  d_.displacement.to_local(u, u_);
  const std::size_t materials = d_.materials.size();
  std::vector<double>& lost = lost_;
  lost.assign(5 + 2 * materials, 0.0);
  // The unilateral stress acts over the step as a whole: not in that of its end, twice in what does work.
  const bool apart = heat.stress && step_.unilateral_scale != 1;
  double least = 0;
  bool sound = true;
  if (internal) {
    std::fill(r_.begin(), r_.end(), 0.0);
    broken_ = {};
  }
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const PointLaw& law = batch.law;
    MotionFields fields = step_fields(u_, nullptr, law);
    fields.unilateral = apart ? 0 : 1;
    if (internal) fields.bulk = step_.bulk;
    if (law.softens()) fields.drive = &drive_.committed;
    const MotionBatch cells(batch, fields);
    auto next = batch.histories();
    auto driving = batch.points<drive_size>();
    auto dissipation = batch.points<1>();
    auto stress = batch.stresses();
    StepSums step;
    const HeatFeed feed{heat.dissipation ? dissipation.data() : nullptr,
                        heat.stress ? stress.data() : nullptr};
    Batch* const trial = keeps_history(law) ? next.data() : nullptr;
    if (apart && heat.step_stress) {
      MotionInput in = cells.in;
      in.unilateral = 2;
      StepSums unused;
      batch.kernels.motion_advance(law, in, trial, nullptr, unused, {nullptr, stress.data()});
      batch.store(stress, *heat.step_stress);
    }
    if (internal)
      sound = step_cells(batch, cells.in, trial, driving.data(), step, feed) && sound;
    else
      sound = batch.broken(
                  batch.kernels.motion_advance(law, cells.in, trial, driving.data(), step, feed).bad) == 0 &&
              sound;
    if (keeps_history(law)) batch.store(next, history_.trial);
    batch.store(driving, drive_.trial);
    if (heat.dissipation) batch.store(dissipation, *heat.dissipation);
    if (heat.stress) batch.store(stress, *heat.stress);
    if (heat.step_stress && !apart) batch.store(stress, *heat.step_stress);
    const double plastic = batch.sum(step.plastic_dissipation), viscous = batch.sum(step.viscous_dissipation);
    lost[0] += plastic;
    lost[1] += viscous;
    lost[2] += batch.sum(step.plastic_work);
    lost[3 + batch.material()] += plastic;
    lost[3 + materials + batch.material()] += viscous;
    for (int l = 0; l < batch.used(); ++l) least = std::min(least, step.least_dissipation[l]);
  });
  const bool all_sound = sum_up(sound, least, sums);
  if (internal) put(r_, internal);
  return all_sound;
}

// One reduction: sums of the cells, how many ranks found a broken one, and the least dissipation.
bool MotionProblem::sum_up(bool sound, double least, Increments& sums) {
  const std::size_t materials = d_.materials.size(), broken = 3 + 2 * materials, least_of_all = broken + 1;
  lost_[broken] = sound ? 0 : 1;
  lost_[least_of_all] = least;
  sum_and_min_over_ranks(d_.mesh.comm(), lost_);
  const auto part = lost_.begin() + 3, half = part + static_cast<std::ptrdiff_t>(materials);
  sums.plastic_dissipation = lost_[0];
  sums.viscous_dissipation = lost_[1];
  sums.plastic_work = lost_[2];
  sums.least_dissipation = lost_[least_of_all];
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
  batch.scatter(force, r_);
  return check_cells(batch.group, batch.number, batch.broken(status.bad), status.min_J);
}

double MotionProblem::stable_step(Vec u, const std::vector<double>& u_n, double dt,
                                  const BulkViscosity& bulk) {
  const Timed timed(Event::motion_points);
  d_.displacement.to_local(u, u_);
  double shortest = HUGE_VAL;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    MotionFields fields = step_fields(u_, nullptr, batch.law);
    fields.u_n = &u_n;
    fields.dt = dt;
    fields.bulk = bulk;
    MotionBatch cells(batch, fields);
    if (d_.mass_factor != nullptr) cells.in.mass_factor = batch.load<1>(*d_.mass_factor).value[0];
    const Batch step = batch.kernels.stable_step(batch.law, cells.in);
    for (int l = 0; l < batch.used(); ++l) shortest = std::min(shortest, step[l]);
  });
  return min_over_ranks(d_.mesh.comm(), shortest);
}

} // namespace impact
