#include "pressure_batch.hpp"
#include <algorithm>
#include <cmath>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/soft_volume.hpp>

namespace impact {

namespace {

bool takes(const PointLaw& law) {
  return law.parameters.locking == Locking::mean && !law.principal() && !has_state(law.parameters);
}

// Whether there are such cells whose pressure is none of the cell as a whole.
bool vary_in_cells(const Discretisation& d) {
  return max_over_ranks(d.mesh.comm(), static_cast<int>(std::ranges::any_of(d.groups, [&](const auto& group) {
                          return takes(d.laws[at(group.law)]) && group.shape->volume_modes > 1;
                        }))) > 0;
}

// K of the first stage is at most so many G. What flows is as soft in shear as its stress over the strain of
// the step, a thirtieth of G in one of 4 %.
double growth_of(const PointLaw& law) {
  constexpr double most_elastic = 100, most_flowing = 0.1;
  return std::max(law.parameters.K / ((law.flows() ? most_flowing : most_elastic) * law.parameters.G), 1.0);
}

// body(batch) for cells of such laws.
template <class Body> void for_each_taken(const Discretisation& d, Body&& body) {
  for_each_batch(d, deformable, [&](const CellBatch& batch) {
    if (takes(batch.law)) body(batch);
  });
}

// What the cells of a batch have for themselves, or sum up with those of their patches.
struct Sum {
  std::vector<double> of_lane, of_patch;

  explicit Sum(const Discretisation& d, std::size_t lane_count)
      : of_lane(lane_count, 0.0), of_patch(at(d.patches.count()), 0.0) {}
  void add(const CellBatch& batch, const Batch& value) {
    for (int l = 0; l < lanes; ++l)
      if (!batch.patched())
        of_lane[batch.place() * lanes + at(l)] = value[l];
      else if (l < batch.used())
        of_patch[at(batch.patch(l))] += value[l];
  }
  double of(const CellBatch& batch, int l) const {
    return batch.patched() ? of_patch[at(std::max(batch.patch(l), 0))]
                           : of_lane[batch.place() * lanes + at(l)];
  }
};

} // namespace

SoftVolume::SoftVolume(const Discretisation& d) : d_(d) {
  if (vary_in_cells(d)) return;
  const bool erodes = std::ranges::any_of(d.materials, [](const auto& m) { return m.erosion.on; });
  for (const PointLaw& law : d.laws) {
    if (!takes(law) || law.rigid() || erodes) continue;
    if (!law.flows())
      growth_.elastic = std::max(growth_.elastic, growth_of(law));
    else if (law.parameters.damage == Damage::none)
      growth_.flowing = std::max(growth_.flowing, growth_of(law));
  }
}

const PointLaw& SoftVolume::law(const CellBatch& batch) const {
  return laws_.empty() ? batch.law : laws_[at(batch.group.law)];
}

std::vector<PointLaw> SoftVolume::laws_at(double part) const {
  std::vector<PointLaw> laws = d_.laws;
  if (part < 1)
    for (PointLaw& law : laws)
      if (takes(law)) law.parameters.K *= std::pow(growth_of(law), part - 1);
  return laws;
}

void SoftVolume::soften() {
  reset();
  laws_ = laws_at(0);
}

void SoftVolume::stiffen(const PatchFields& fields, double part) {
  const std::vector<PointLaw> stiffer = laws_at(part);
  std::vector<double> growth;
  for (std::size_t i = 0; i < laws_.size(); ++i)
    growth.push_back(stiffer[i].parameters.K / laws_[i].parameters.K);
  find(fields, nullptr, laws_, growth);
  laws_ = stiffer;
}

void SoftVolume::foretell(const PatchFields& fields, const std::vector<double>& to) {
  if (keeps_pressures()) find(fields, &to, laws_, std::vector<double>(laws_.size(), 1));
}

void SoftVolume::reset() {
  laws_.clear();
  kept_ = false;
}

// p at J(u) + dJ/du (to - u), of laws whose K grows afterwards.
void SoftVolume::find(const PatchFields& fields, const std::vector<double>* to,
                      const std::vector<PointLaw>& of, const std::vector<double>& growth) {
  std::size_t batches = 0;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) { batches = batch.place() + 1; });
  Sum volume(d_, batches * lanes), grown(volume), p(volume), slope(volume);
  for_each_taken(d_, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d_.mesh.coordinates()), u = batch.vectors(*fields.u);
    Batch V, change;
    batch.kernels.cell_volume(X.data(), u.data(), V, change);
    if (to != nullptr) {
      const auto end = batch.vectors(*to);
      auto v = batch.nodal(d_.dim());
      batch.kernels.volume_slope(X.data(), u.data(), v.data());
      for (int i = 0; i < v.size; ++i) change += v.value[i] * (end.value[i] - u.value[i]);
    }
    volume.add(batch, V);
    grown.add(batch, change);
  });
  for_each_taken(d_, [&](const CellBatch& batch) {
    Batch J_minus_1, all, rise;
    for (int l = 0; l < lanes; ++l) J_minus_1.set(l, grown.of(batch, l) / volume.of(batch, l));
    const PressureBatch cells(batch, fields, &J_minus_1);
    batch.kernels.cell_pressure(of[at(batch.group.law)], cells.in, all, rise);
    p.add(batch, all);
    slope.add(batch, growth[at(batch.group.law)] * rise);
  });
  kept_ = true;
  pressure_.assign(batches * 2 * lanes, 0.0);
  for_each_taken(d_, [&](const CellBatch& batch) {
    for (int l = 0; l < lanes; ++l) {
      const std::size_t first = batch.place() * 2 * lanes + at(l);
      pressure_[first] = p.of(batch, l) / volume.of(batch, l);
      pressure_[first + lanes] = slope.of(batch, l) / volume.of(batch, l);
    }
  });
  patch_slope_ = slope.of_patch;
  for (std::size_t i = 0; i < patch_slope_.size(); ++i)
    patch_slope_[i] = volume.of_patch[i] > 0 ? patch_slope_[i] / volume.of_patch[i] : 0;
}

const Batch* SoftVolume::pressure(const CellBatch& batch, BatchArray<2>& values) const {
  if (!keeps_pressures() || !takes(batch.law)) return nullptr;
  std::copy_n(pressure_.data() + batch.place() * 2 * lanes, 2 * lanes,
              reinterpret_cast<double*>(values.value));
  return values.data();
}

void SoftVolume::put_slopes(PatchState& patches) const {
  if (keeps_pressures() && !d_.patches.empty()) patches.slope = patch_slope_;
}

} // namespace impact
