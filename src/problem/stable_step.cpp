#include "motion_batch.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/motion.hpp>

/// How long a step of central differences may be, and mass that lengthens it (theory.md, 7). In each cell
/// x.K_e x <= w_e^2 x.M_e x; summed up, x.K x <= sum_a |x_a|^2 sum_e w_e^2 m_ea, so that no body swings
/// faster than the mean of its cells around some node, by their masses there.
namespace impact {

namespace {

int local_node(const CellBatch& batch, int a, int lane) {
  return batch.group.node[at((batch.number * batch.nodes() + a) * lanes + lane)];
}

} // namespace

// Of each cell, undeformed: the largest mean of squares of frequencies around one of its nodes, over its own.
std::vector<Batch> MotionProblem::find_shares() const {
  const std::size_t dim = at(d_.dim());
  std::vector<double> sums = d_.displacement.make_local(); // at each node, of masses times squares, of masses
  std::vector<Batch> squares;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d_.mesh.coordinates()), still = batch.zero(d_.dim());
    MotionInput in;
    in.X = X.data();
    in.u = still.data();
    if (d_.mass_factor != nullptr) in.mass_factor = batch.load<1>(*d_.mass_factor).value[0];
    auto mass = batch.zero(1), parts = batch.zero(d_.dim());
    squares.push_back(batch.kernels.highest_frequency(batch.law, in, mass.data()).square);
    for (std::size_t a = 0; a < at(mass.size); ++a) {
      parts.value[dim * a] = squares.back() * mass.value[a];
      parts.value[dim * a + 1] = mass.value[a];
    }
    batch.forget_weightless(parts); // others have left their mass at their nodes
    batch.scatter(parts, sums);
  });
  add_up(d_.displacement, sums);
  std::vector<Batch> shares;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const Batch& square = squares[shares.size()];
    Batch around = square;
    for (int l = 0; l < batch.used(); ++l) {
      double largest = 0;
      for (int a = 0; a < batch.nodes(); ++a) {
        const double* sum = &sums[dim * at(local_node(batch, a, l))];
        if (sum[1] > 0) largest = std::max(largest, sum[0] / sum[1]);
      }
      // Between equal cells the mean is that of each but for rounding.
      if (std::abs(largest - square[l]) > 1e-12 * square[l] && largest > 0) around.set(l, largest);
    }
    shares.push_back(around / square);
  });
  return shares;
}

// Batches with the highest frequencies of their cells alone, and by what these go in with their neighbours.
template <class Visitor>
void MotionProblem::visit_frequencies(Vec u, const StepBefore& before, CellsOfStep by, Visitor&& visitor) {
  const bool together = by == CellsOfStep::together;
  if (together && !shares_) shares_ = find_shares();
  d_.displacement.to_local(u, u_);
  std::size_t i = 0;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    MotionFields fields = step_fields(u_, nullptr, batch.law);
    fields.u_n = &before.u_n;
    fields.dt = before.dt;
    fields.bulk = before.bulk;
    MotionBatch cells(batch, fields);
    if (d_.mass_factor != nullptr) cells.in.mass_factor = batch.load<1>(*d_.mass_factor).value[0];
    CellFrequency alone = batch.kernels.highest_frequency(batch.law, cells.in, nullptr);
    if (!together) alone.square = alone.stiffest;
    visitor(batch, alone, together ? (*shares_)[i++] : Batch(1.0));
  });
}

// A cell may swing as much faster than a step allows it alone as it does, undeformed, than the mean around
// it: where each one keeps to that, so does the mean. Where a large cell is squeezed the fastest cell alone
// tells more.
double MotionProblem::stable_step(Vec u, const StepBefore& before, CellsOfStep by) {
  const Timed timed(Event::motion_points);
  std::array<MarkedCell, 2> slowest; // alone, together
  slowest.fill({HUGE_VAL, {}, -1});
  visit_frequencies(
      u, before, by, [&](const CellBatch& batch, const CellFrequency& alone, const Batch& share) {
        const std::array<Batch, 2> steps = {
            alone.longest_step(), CellFrequency{share * alone.square, share * alone.damping}.longest_step()};
        for (std::size_t k = 0; k < steps.size(); ++k)
          for (int l = 0; l < batch.used(); ++l)
            if (batch.live(l) && steps[k][l] < slowest[k].value)
              slowest[k] = mark(batch.group, batch.number, l, steps[k][l]);
      });
  std::array<double, 2> longest = {slowest[0].value, slowest[1].value};
  min_over_ranks(d_.mesh.comm(), longest);
  slowest_ = slowest[longest[1] >= longest[0] ? 1 : 0];
  return std::max(longest[0], longest[1]);
}

std::string MotionProblem::slowest_cell() const {
  const MarkedCell slowest = of_least(d_.mesh.comm(), slowest_.value, slowest_);
  return slowest.material < 0 ? "" : place_of(slowest);
}

// With s times its mass a cell alone is stable for square dt^2 + 2 damping dt <= 4 s. Where that holds in all
// cells around a node it holds there; those around nodes that need none get none.
const MassScaling& MotionProblem::scale_mass(Vec u, const StepBefore& before, CellsOfStep by, double wanted,
                                             StateRow& factors) {
  std::fill(factors.committed.begin(), factors.committed.end(), 1.0);
  visit_frequencies(u, before, by,
                    [&](const CellBatch& batch, const CellFrequency& alone, const Batch& share) {
                      auto factor = batch.load<1>(factors.committed);
                      for (int l = 0; l < batch.used(); ++l) {
                        const double needed = wanted * (alone.square[l] * wanted + 2 * alone.damping[l]) / 4;
                        if (needed > 1 && needed * share[l] > 1)
                          for (Batch& at_point : factor.all()) at_point.set(l, needed);
                      }
                      batch.store(factor, factors.committed);
                    });
  return use_mass(factors);
}

const MassScaling& MotionProblem::use_mass(const StateRow& factors) {
  scaling_ = {};
  shares_.reset();
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
