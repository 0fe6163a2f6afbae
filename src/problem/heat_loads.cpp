#include <algorithm>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/heat_loads.hpp>

namespace impact {

namespace {

// Where the lanes of a batch begin in an array [group][batch][lane].
std::size_t first_lane(const CellBatch& batch) { return batch.first_cell + at(batch.number) * lanes; }

} // namespace

HeatLoads::HeatLoads(const Discretisation& d, const BoundaryData& boundary)
    : d_(d), boundary_(boundary), X_(d.mesh.coordinates().begin(), d.mesh.coordinates().end()) {
  for (int c : boundary_.heat_sources()) {
    Source& source = sources_.emplace_back();
    source.condition = c;
    source.inside = d_.lanes_in(boundary_.conditions()[at(c)].on);
    for (std::vector<double>& value : source.value) value.assign(d_.point_values(1), 0.0);
  }
  for (const LoadedFacets& load : boundary_.heat_fluxes()) {
    Surface& surface = surfaces_.emplace_back(Surface{&load, {}});
    for (SurfaceHeat& heat : surface.heat) {
      heat.inflow.resize(at(load.facets.count()) * points_per_facet);
      heat.coefficient.resize(heat.inflow.size());
    }
  }
}

void HeatLoads::evaluate(double t_n, double t, double theta) {
  if (theta < 1) evaluate(t_n, 0);
  evaluate(t, 1);
}

void HeatLoads::evaluate(double t, int end) {
  for (Source& source : sources_)
    for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
      const auto X = batch.vectors(X_);
      const int nodes = batch.nodes(), dim = d_.dim();
      auto value = batch.points<1>();
      for (int q = 0; q < value.size; ++q)
        for (std::size_t l = 0; l < lanes; ++l) {
          value.value[q].set(static_cast<int>(l), 0);
          if (!source.inside[first_lane(batch) + l]) continue;
          double x[3] = {0, 0, 0};
          for (int a = 0; a < nodes; ++a)
            for (int k = 0; k < dim; ++k)
              x[k] += batch.group.shape->N[q * nodes + a] * X.value[a * dim + k][static_cast<int>(l)];
          value.value[q].set(static_cast<int>(l), boundary_.scalar_value(source.condition, x, t));
        }
      batch.store(value, source.value[end]);
    });
  for (Surface& surface : surfaces_) {
    const int c = surface.load->condition;
    const bool convects = boundary_.conditions()[at(c)].type == BcType::convection;
    SurfaceHeat& heat = surface.heat[end];
    for_each_facet_point(surface.load->facets, d_.frame, X_, [&](std::size_t i, const double* x) {
      heat.coefficient[i] = convects ? boundary_.heat_coefficient(c, x, t) : 0.0;
      heat.inflow[i] = convects ? heat.coefficient[i] * boundary_.ambient_temperature(c, x, t)
                                : boundary_.scalar_value(c, x, t);
    });
  }
}

void HeatLoads::add_start(double theta, double dt, const std::vector<double>& theta_n,
                          std::vector<double>& load, std::vector<double>& supplied) const {
  const double weight[2] = {(1 - theta) * dt, theta * dt};
  for (const Source& source : sources_)
    for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
      const auto inside = source.inside.begin() + static_cast<std::ptrdiff_t>(first_lane(batch));
      if (std::none_of(inside, inside + lanes, [](char in) { return in != 0; })) return;
      const auto X = batch.vectors(X_);
      const auto before = batch.load<1>(source.value[0]), now = batch.load<1>(source.value[1]);
      auto heat = batch.points<1>();
      for (int q = 0; q < heat.size; ++q)
        for (int l = 0; l < lanes; ++l)
          heat.value[q].set(l, weight[0] * before.value[q][l] + weight[1] * now.value[q][l]);
      auto r = batch.zero(1);
      Batch sum = 0;
      batch.kernels.heat_source(X.data(), heat.data(), r.data(), sum);
      batch.scatter(r, load);
      supplied[at(source.condition)] += batch.sum(sum);
    });
  if (theta == 1) return;
  for (const Surface& surface : surfaces_)
    supplied[at(surface.load->condition)] +=
        add_surface_heat(surface.load->facets, d_.frame, X_, surface.heat[0], theta_n, weight[0], load);
}

void HeatLoads::add_end(double weight, const std::vector<double>& temperature, std::vector<double>& load,
                        std::vector<double>& supplied) const {
  for (const Surface& surface : surfaces_)
    supplied[at(surface.load->condition)] +=
        add_surface_heat(surface.load->facets, d_.frame, X_, surface.heat[1], temperature, weight, load);
}

void HeatLoads::add_tangent(double weight, const std::vector<char>& held, const MiddleValues* middles,
                            Mat matrix) const {
  for (const Surface& surface : surfaces_)
    add_surface_heat_tangent(surface.load->facets, d_.frame, X_, surface.heat[1], weight, held, middles,
                             d_.mesh.global_node(), matrix);
}

} // namespace impact
