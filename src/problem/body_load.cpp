#include <algorithm>
#include <impact/problem/body_load.hpp>
#include <impact/problem/mass_matrix.hpp>

namespace impact {

BodyLoad::BodyLoad(const Discretisation& d, const BoundaryData& boundary) : d_(d), boundary_(boundary) {
  const std::vector<BoundaryCondition>& conditions = boundary.conditions();
  for (std::size_t c = 0; c < conditions.size(); ++c)
    if (conditions[c].type == BcType::body_force)
      regions_.push_back({static_cast<int>(c), d.lanes_in(conditions[c].on), {}});
}

void BodyLoad::assemble(const Region& region) {
  const int dim = d_.dim();
  CellMatrix m;
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    const char* const inside = &region.inside[batch.first_cell + at(batch.number * lanes)];
    if (std::none_of(inside, inside + lanes, [](char in) { return in != 0; })) return;
    const auto X = batch.vectors(d_.mesh.coordinates()), f = batch.vectors(region.acceleration);
    const int nodes = batch.nodes();
    batch.kernels.mass_matrix(batch.law, X.data(), m.zeroed(nodes));
    if (d_.lumped_mass && batch.group.shape->order() == 2) lump(nodes, m);
    auto force = batch.zero(dim);
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j < nodes; ++j)
        for (int k = 0; k < dim; ++k)
          force.value[i * dim + k] += m(i, j) * f.value[(d_.lumped_mass ? i : j) * dim + k];
    for (int l = 0; l < lanes; ++l)
      for (int i = 0; inside[l] == 0 && i < force.size; ++i) force.value[i].set(l, 0);
    batch.forget_weightless(force);
    batch.scatter(force, load_);
  });
}

void BodyLoad::add(double t, std::vector<double>& load) {
  if (regions_.empty()) return;
  bool changed = load_.empty() || weightless_ != d_.weightless;
  for (Region& region : regions_) {
    now_.assign(load.size(), 0.0);
    boundary_.add_body_force(region.condition, t, now_);
    changed = changed || now_ != region.acceleration;
    region.acceleration.swap(now_);
  }
  if (changed) {
    load_.assign(load.size(), 0.0);
    for (const Region& region : regions_) assemble(region);
    weightless_ = d_.weightless;
  }
  for (std::size_t i = 0; i < load.size(); ++i) load[i] += load_[i];
}

} // namespace impact
