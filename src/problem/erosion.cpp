#include <algorithm>
#include <bit>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/erosion.hpp>

namespace impact {

namespace {

// A patch that would differ more from the volumes of its cells takes these.
constexpr double most_scale = 2;

// Padding repeats the last cell of its own.
int with_padding(int lanes_of, int used) {
  for (int l = used; l < lanes; ++l)
    if (lanes_of & (1 << (used - 1))) lanes_of |= 1 << l;
  return lanes_of;
}

} // namespace

Erosion::Erosion(Discretisation& discretisation, StateTable& state) : d_(discretisation), state_(state) {
  if (!d_.erodes()) return;
  eroded_ = &state.row("eroded");
  totals_ = &state.row("erosion_totals");
  if (!d_.patches.empty()) scale_ = &state.row("patch_scale");
}

void Erosion::follow_rows() {
  if (left_ == totals_->trial[ErosionTotals::cells]) return;
  left_ = totals_->trial[ErosionTotals::cells];
  ErodedCells eroded;
  if (left_ > 0) {
    eroded.cell.assign(at(d_.mesh.cell_count()), 0);
    for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
      const Batch gone = batch.load<1>(eroded_->trial).value[0];
      int lanes_of = 0;
      for (int l = 0; l < lanes; ++l) {
        if (gone[l] == 0) continue;
        lanes_of |= 1 << l;
        eroded.cell[at(batch.group.cell_point[at(batch.number * lanes + l)] - d_.mesh.cell_start())] = 1;
      }
      eroded.lanes_of.push_back(lanes_of);
    });
  }
  d_.eroded = std::move(eroded);
  d_.patch_scale.clear();
  news_ = true;
  if (scale_ == nullptr || left_ == 0) return;
  d_.patch_scale.assign(at(d_.patches.count()), 1.0);
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (!batch.patched()) return;
    const Batch scale = batch.load<1>(scale_->trial).value[0];
    for (int l = 0; l < batch.used(); ++l)
      if (batch.live(l)) d_.patch_scale[at(batch.patch(l))] = 1 + scale[l];
  });
}

// What is left of a patch goes on from the ratio that it had with the cells that leave.
void Erosion::keep_ratios(const PatchState& before, const std::vector<double>& u) {
  if (scale_ == nullptr) return;
  PatchState now;
  share_volumes(d_, {&u}, now);
  for (std::size_t p = 0; p < now.volume.size(); ++p) {
    if (now.volume[p] == before.volume[p] || now.volume[p] <= 0) continue;
    const double scale = d_.patch_scale[p] * (1 + before.ratio[p]) / (1 + now.ratio[p]);
    if (scale > 1 / most_scale && scale < most_scale) d_.patch_scale[p] = scale;
  }
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (!batch.patched()) return;
    auto row = batch.load<1>(scale_->trial);
    for (Batch& value : row.all())
      for (int l = 0; l < batch.used(); ++l)
        if (batch.live(l)) value.set(l, d_.patch_scale[at(batch.patch(l))] - 1);
    batch.store(row, scale_->trial);
  });
}

void Erosion::shed_mass() {
  d_.weightless = d_.eroded.lanes_of;
  if (d_.weightless.empty()) return;
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (d_.materials[batch.material()].erosion.keeps_mass) d_.weightless[batch.place()] = 0;
  });
}

bool Erosion::may_invert(const CellBatch& batch, int lane, const std::vector<double>* phi) {
  const ErosionRule& rule = batch.d.materials[batch.material()].erosion;
  if (!rule.on) return false;
  if (batch.law.parameters.damage == Damage::none || phi == nullptr) return true;
  const NodalValues values = batch.scalars(*phi);
  return std::ranges::all_of(values.all(), [&](const Batch& at_node) { return at_node[lane] >= rule.phi; });
}

// Energy of some lanes: all that is stored in a cell, or what stays with the nodes of one that is gone.
double Erosion::energy_of(const CellBatch& batch, int lanes_of, const std::vector<double>& u, bool trial,
                          bool gone, const PatchState& patches, double& mass) const {
  const auto half = [&](const char* name) -> const std::vector<double>* {
    const StateRow* const row = state_.find(name);
    return row == nullptr ? nullptr : trial ? &row->trial : &row->committed;
  };
  const auto X = batch.vectors(d_.mesh.coordinates());
  const auto moved = gone ? batch.zero(d_.dim()) : batch.vectors(u);
  NodalValues phi = batch.nodal(1), theta = batch.nodal(1);
  auto points = batch.histories();
  auto fatigue = batch.points<1>();
  auto driven = batch.points<drive_size>();
  BatchArray<1> patch(1);
  EnergyInput in;
  in.X = X.data();
  in.u = moved.data();
  in.patch = gone ? nullptr : batch.read_shared(patches.J_minus_1, patch);
  in.lumped = d_.lumped_mass;
  in.lumped_capacity = d_.lumped_capacity;
  in.phi = batch.read(half("phi"), phi);
  in.theta = batch.read(half("theta"), theta);
  in.history = gone ? nullptr : batch.read(half("history"), points);
  in.fatigue = batch.read(batch.law.fatigues() ? half("fatigue") : nullptr, fatigue);
  in.drive = gone ? nullptr : batch.read(batch.law.softens() ? half("drive") : nullptr, driven);
  auto virgin = batch.histories();
  if (gone) {
    set_virgin(d_.frame, {reinterpret_cast<double*>(virgin.value), at(virgin.size * lanes)});
    in.history = virgin.data();
  }
  EnergySums sums;
  batch.kernels.stored_energy(batch.law, in, sums);
  batch.add_toughness(half("fatigue"), half("toughness"), sums);
  Batch energy = sums.fracture + sums.fatigue;
  if (!gone) energy += sums.elastic + sums.plastic;
  if (in.theta) {
    HeatSums heat;
    batch.kernels.stored_heat(batch.law, in, heat);
    energy += heat.energy;
  }
  double sum = 0;
  for (int l = 0; l < batch.used(); ++l)
    if (lanes_of & (1 << l)) {
      sum += energy[l];
      mass += sums.mass[l];
    }
  return sum;
}

// Energy of the cells that share their volume in patches, without some lanes, which is another one when these
// leave.
double Erosion::patched_energy(const std::vector<int>& lanes_of, const std::vector<double>& u, bool trial,
                               const PatchState& patches) const {
  double sum = 0, unused = 0;
  if (d_.patches.empty()) return sum;
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (batch.patched())
      sum += energy_of(batch, batch.broken(~lanes_of[batch.place()]), u, trial, false, patches, unused);
  });
  return sum;
}

bool Erosion::take_out(const std::vector<int>& lanes_of, const std::vector<double>& u, bool trial) {
  std::array<double, ErosionTotals::components> sums{};
  for (const int lanes_gone : lanes_of) sums[ErosionTotals::cells] += lanes_gone != 0 ? 1 : 0;
  if (max_over_ranks(d_.mesh.comm(), sums[ErosionTotals::cells]) == 0) return false;
  sums = {};
  PatchState patches;
  share_volumes(d_, {&u}, patches);
  double rest = patched_energy(lanes_of, u, trial, patches);
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    const int gone = lanes_of[batch.place()];
    if (gone == 0) return;
    sums[ErosionTotals::cells] += std::popcount(static_cast<unsigned>(gone));
    double mass = 0, unused = 0;
    sums[ErosionTotals::energy] += energy_of(batch, gone, u, trial, false, patches, mass) -
                                   energy_of(batch, gone, u, trial, true, patches, unused);
    sums[ErosionTotals::mass] += mass;
    auto row = batch.load<1>(eroded_->trial);
    for (Batch& value : row.all())
      for (int l = 0; l < lanes; ++l)
        if (with_padding(gone, batch.used()) & (1 << l)) value.set(l, 1);
    batch.store(row, eroded_->trial);
  });
  sum_over_ranks(d_.mesh.comm(), sums);
  totals_->trial[ErosionTotals::cells] += sums[ErosionTotals::cells];
  totals_->trial[ErosionTotals::mass] += d_.thickness * sums[ErosionTotals::mass];
  totals_->trial[ErosionTotals::energy] += d_.thickness * sums[ErosionTotals::energy];
  follow_rows();
  keep_ratios(patches, u);
  share_volumes(d_, {&u}, patches);
  rest -= patched_energy(lanes_of, u, trial, patches);
  totals_->trial[ErosionTotals::energy] += d_.thickness * sum_over_ranks(d_.mesh.comm(), rest);
  return true;
}

bool Erosion::remove(const std::vector<std::size_t>& inverted) {
  std::vector<int> lanes_of(d_.batch_count(), 0);
  for (const std::size_t cell : inverted) lanes_of[cell / lanes] |= 1 << (cell % lanes);
  return take_out(lanes_of, state_.row("u").committed, false);
}

void Erosion::settle() {
  if (totals_->trial[ErosionTotals::cells] == totals_->committed[ErosionTotals::cells]) return;
  StateRow& history = state_.row("history");
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    if (batch.eroded == 0) return;
    auto rows = batch.histories(), virgin = rows;
    batch.load(history.trial, rows);
    set_virgin(d_.frame, {reinterpret_cast<double*>(virgin.value), at(virgin.size * lanes)});
    for (int i = 0; i < rows.size; ++i)
      for (int l = 0; l < lanes; ++l)
        if (!batch.live(l)) rows.value[i].set(l, virgin.value[i][l]);
    batch.store(rows, history.trial);
  });
}

bool Erosion::worth_telling() {
  if (left_ == 0 || left_ < 1.1 * told_ || left_ == told_) return false;
  told_ = left_;
  return true;
}

std::string Erosion::text() const {
  return text_of("cells that have left: %.0f, their mass %.4g, the energy that went with them %.4g",
                 totals_->trial[ErosionTotals::cells], totals_->trial[ErosionTotals::mass],
                 totals_->trial[ErosionTotals::energy]);
}

} // namespace impact
