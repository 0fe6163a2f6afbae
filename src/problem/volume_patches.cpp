#include "pressure_batch.hpp"
#include <algorithm>
#include <impact/problem/soft_volume.hpp>
#include <impact/problem/volume_patches.hpp>
#include <map>

namespace impact {

namespace {

bool takes_mean(const CellGroup& group, const MaterialAssignment& material) {
  return group.shape->simplex() && group.shape->order() == 1 &&
         material.law.parameters.locking == Locking::mean;
}

// Patches of as many nodes side by side, for the assembly.
void pack(const VolumePatches& patches, const std::vector<int>& members, std::size_t size,
          CellGroup& stencil) {
  stencil.cell_count = static_cast<int>(members.size());
  stencil.batch_count = (stencil.cell_count + lanes - 1) / lanes;
  for (int b = 0; b < stencil.batch_count; ++b)
    for (std::size_t a = 0; a < size; ++a)
      for (int l = 0; l < lanes; ++l)
        stencil.node.push_back(
            patches.nodes[members[at(std::min(b * lanes + l, stencil.cell_count - 1))]][a]);
}

} // namespace

VolumePatches::VolumePatches(const Mesh& mesh, const std::vector<CellGroup>& groups,
                             const std::vector<MaterialAssignment>& materials) {
  if (mesh.patches().empty()) return;
  std::map<PetscInt, int> number; // here, by that over all ranks
  std::vector<std::vector<int>> nodes_of;
  for (const CellGroup& group : groups) {
    const bool takes = takes_mean(group, materials[at(group.material)]);
    in_group.push_back(0);
    for (int b = 0; b < group.batch_count; ++b)
      for (int l = 0; l < lanes; ++l) {
        const PetscInt cell = group.cell_point[at(b * lanes + l)] - mesh.cell_start();
        const PetscInt patch = takes && l < group.lanes_in_use(b) ? mesh.patches()[at(cell)] : -1;
        of_lane.push_back(-1);
        if (patch < 0) continue;
        in_group.back() = 1;
        of_lane.back() = number.try_emplace(patch, static_cast<int>(number.size())).first->second;
        nodes_of.resize(number.size());
        for (int a = 0; a < group.shape->nodes; ++a)
          nodes_of[at(of_lane.back())].push_back(batch_nodes(group, b)[a * lanes + l]);
      }
  }
  std::map<std::size_t, std::vector<int>> by_size;
  for (std::vector<int>& list : nodes_of) {
    std::ranges::sort(list);
    list.erase(std::ranges::unique(list).begin(), list.end());
    by_size[list.size()].push_back(nodes.count());
    nodes.values.insert(nodes.values.end(), list.begin(), list.end());
    nodes.end_list();
  }
  find_corners(groups);
  for (auto& [size, members] : by_size) {
    shapes.emplace_back().nodes = static_cast<int>(size);
    stencils.emplace_back().shape = Shape(shapes.back());
    pack(*this, members, size, stencils.back());
    of_stencil.push_back(std::move(members));
  }
}

void VolumePatches::find_corners(const std::vector<CellGroup>& groups) {
  std::size_t first = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const CellGroup& group = groups[g];
    for (int b = 0; b < group.batch_count && in_group[g] != 0; ++b)
      for (int a = 0; a < group.shape->nodes; ++a)
        for (int l = 0; l < lanes; ++l) {
          const int patch = of_lane[first + at(b * lanes + l)];
          const auto list = nodes[std::max(patch, 0)];
          corner.push_back(
              patch < 0
                  ? 0
                  : static_cast<std::uint16_t>(
                        std::ranges::lower_bound(list, batch_nodes(group, b)[a * lanes + l]) - list.begin()));
        }
    first += at(group.batch_count) * lanes;
  }
}

namespace {

// body(batch) for the batches whose cells are in patches.
template <class Body> void for_each_patched(const Discretisation& d, Body&& body) {
  if (!d.patches.empty())
    for_each_batch(d, deformable, [&](const CellBatch& batch) {
      if (batch.patched()) body(batch);
    });
}

// Adds the cells' values, one component after the other, to those of their patches.
void add_up(const CellBatch& batch, std::initializer_list<std::pair<Batch, std::vector<double>*>> sums) {
  for (int l = 0; l < batch.used(); ++l)
    for (const auto& [value, sum] : sums)
      if (batch.live(l)) (*sum)[at(batch.patch(l))] += value[l];
}

// A mean from the integral over a patch; of some patches nothing is left.
void divide(std::vector<double>& integral, const std::vector<double>& volume) {
  for (std::size_t p = 0; p < volume.size(); ++p) integral[p] = volume[p] > 0 ? integral[p] / volume[p] : 0;
}

// A row [group][batch][component][lane] of the values of the patches.
void spread(const VolumePatches& patches, std::initializer_list<const std::vector<double>*> values,
            std::vector<double>& row) {
  row.assign(patches.of_lane.size() * values.size(), 0.0);
  std::size_t to = 0;
  for (std::size_t first = 0; first < patches.of_lane.size(); first += lanes)
    for (const auto* value : values)
      for (std::size_t l = 0; l < lanes; ++l, ++to)
        if (const int p = patches.of_lane[first + l]; p >= 0) row[to] = (*value)[at(p)];
}

void find_volumes(const Discretisation& d, const std::vector<double>& u, PatchState& state) {
  for (auto* sum : {&state.volume, &state.ratio}) sum->assign(at(d.patches.count()), 0.0);
  for_each_patched(d, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), moved = batch.displaced(u);
    Batch volume, grown;
    batch.kernels.cell_volume(X.data(), moved.data(), volume, grown);
    add_up(batch, {{volume, &state.volume}, {grown, &state.ratio}});
  });
  divide(state.ratio, state.volume);
  for (std::size_t p = 0; p < d.patch_scale.size(); ++p)
    state.ratio[p] = d.patch_scale[p] * (1 + state.ratio[p]) - 1;
  spread(d.patches, {&state.ratio}, state.J_minus_1);
}

void find_pressures(const Discretisation& d, const PatchFields& fields, PatchState& state) {
  for (auto* sum : {&state.p, &state.slope}) sum->assign(at(d.patches.count()), 0.0);
  for_each_patched(d, [&](const CellBatch& batch) {
    BatchArray<1> J_minus_1(1);
    const PressureBatch cells(batch, fields, batch.read_shared(state.J_minus_1, J_minus_1));
    Batch p, dp;
    batch.kernels.cell_pressure(fields.soft ? fields.soft->law(batch) : batch.law, cells.in, p, dp);
    add_up(batch, {{p, &state.p}, {dp, &state.slope}});
  });
  divide(state.p, state.volume);
  divide(state.slope, state.volume);
  for (std::size_t p = 0; p < d.patch_scale.size(); ++p) { // per ratio of the volumes that are left
    state.p[p] *= d.patch_scale[p];
    state.slope[p] *= d.patch_scale[p] * d.patch_scale[p];
  }
  spread(d.patches, {&state.p, &state.slope}, state.pressure);
}

} // namespace

void share_volumes(const Discretisation& d, const PatchFields& fields, PatchState& state, bool pressures) {
  if (d.patches.empty()) return;
  find_volumes(d, *fields.u, state);
  state.pressure.clear();
  const bool vary = std::ranges::any_of(d.materials, [&](const MaterialAssignment& m) {
    const MaterialParameters& of = m.law.parameters;
    return (fields.phi && of.damage != Damage::none) || (fields.theta && of.alpha_t != 0) || m.factors;
  });
  if (vary || pressures || !d.patch_scale.empty()) find_pressures(d, fields, state);
}

PatchSum::PatchSum(const Discretisation& d) : d_(d), sum_(at(d.patches.count()), 0.0) {}

void PatchSum::add(const CellBatch& batch, const Batch& of_cells) { add_up(batch, {{of_cells, &sum_}}); }

void PatchSum::put_mean(const PatchState& state, std::vector<double>& row) const {
  std::vector<double> mean = sum_;
  divide(mean, state.volume);
  spread(d_.patches, {&mean}, row);
}

double add_patch_tangents(const Discretisation& d, const std::vector<double>& u, const PatchState& state,
                          const std::vector<double>& free,
                          const std::function<void(int stencil, int batch, const Batch* K)>& body) {
  const VolumePatches& patches = d.patches;
  const auto dim = at(d.dim());
  std::vector<double> v(patches.nodes.values.size() * dim, 0.0); // [patch][node][dim]
  const std::uint16_t* corner = patches.corner.data();
  for_each_patched(d, [&](const CellBatch& batch) {
    const auto X = batch.vectors(d.mesh.coordinates()), moved = batch.displaced(u);
    auto slope = batch.nodal(d.dim());
    batch.kernels.volume_slope(X.data(), moved.data(), slope.data());
    for (int a = 0; a < batch.nodes(); ++a)
      for (int l = 0; l < lanes; ++l, ++corner) {
        if (l >= batch.used() || !batch.live(l)) continue;
        const std::size_t place = patches.nodes.start[at(batch.patch(l))] + *corner;
        for (std::size_t i = 0; i < dim; ++i) v[place * dim + i] += slope.value[at(a) * dim + i][l];
      }
  });
  for (std::size_t k = 0; k < v.size(); ++k) v[k] *= free[at(patches.nodes.values[k / dim]) * dim + k % dim];
  double diagonal = 0;
  CellMatrix K;
  std::vector<Batch> row;
  for (std::size_t s = 0; s < patches.stencils.size(); ++s) {
    const CellGroup& stencil = patches.stencils[s];
    const int dofs = stencil.shape->nodes * d.dim();
    row.resize(at(dofs));
    for (int b = 0; b < stencil.batch_count; ++b) {
      Batch factor;
      for (int l = 0; l < lanes; ++l) {
        const auto p = at(patches.of_stencil[s][at(std::min(b * lanes + l, stencil.cell_count - 1))]);
        factor.set(l, state.volume[p] > 0 ? state.slope[p] / state.volume[p] : 0);
        for (std::size_t i = 0; i < row.size(); ++i) row[i].set(l, v[patches.nodes.start[p] * dim + i]);
      }
      Batch* const out = K.sized(dofs);
      for (int i = 0; i < dofs; ++i)
        for (int j = 0; j < dofs; ++j) out[i * dofs + j] = factor * row[at(i)] * row[at(j)];
      diagonal += lane_sum(K.trace(), stencil.lanes_in_use(b));
      body(static_cast<int>(s), b, out);
    }
  }
  return diagonal;
}

} // namespace impact
