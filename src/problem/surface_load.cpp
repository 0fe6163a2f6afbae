#include "facet_loop.hpp"
#include <cmath>
#include <impact/problem/surface_load.hpp>

namespace impact {

namespace {

// matrix += K of a scalar field that is of first order, over the corners without the held ones; K then is
// zero.
template <std::size_t size>
void add_corner_block(const FacetPlaces& n, const std::vector<char>& held, const MiddleValues& middles,
                      std::span<const PetscInt> global_node, std::array<double, size>& K, Mat matrix) {
  for (int a = 0; a < n.count; ++a)
    for (int b = 0; b < n.count; ++b) {
      const std::span<const int> rows = middles.corners(n.node[at(a)]),
                                 columns = middles.corners(n.node[at(b)]);
      const double share = K[at(a * n.count + b)] / static_cast<double>(rows.size() * columns.size());
      for (const int i : rows)
        for (const int j : columns)
          if (!held[at(i)] && !held[at(j)])
            check(MatSetValue(matrix, global_node[at(i)], global_node[at(j)], share, ADD_VALUES));
    }
  K.fill(0);
}

} // namespace

void add_dead_traction(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                       const std::function<void(const double* x, double* value)>& traction,
                       std::vector<double>& force) {
  const int dim = dimension(frame);
  FacetVector load{};
  visit_facets(
      facets, dim, X, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t, const double* x) {
        double t[3] = {0, 0, 0};
        traction(x, t);
        add_dead_traction(p, n.count, frame, n.X.data(), t, load.data());
      },
      [&](const FacetPlaces& n) { scatter(n, dim, load, force); });
}

void add_felt_area(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                   std::vector<double>& area) {
  const int dim = dimension(frame);
  FacetVector felt{};
  visit_facets(
      facets, dim, X, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t, const double*) {
        const double area_here = reference_area(p, n.count, frame, n.X.data());
        double sum = 0;
        for (int b = 0; b < n.count; ++b) sum += std::abs(p.N[b]);
        for (int i = 0; i < n.count * dim; ++i) felt[at(i)] += area_here * std::abs(p.N[i / dim]) * sum;
      },
      [&](const FacetPlaces& n) { scatter(n, dim, felt, area); });
}

void add_follower_pressure(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                           const std::vector<double>& u,
                           const std::function<double(const double* x)>& pressure,
                           std::vector<double>& force) {
  const int dim = dimension(frame);
  FacetVector load{};
  visit_facets(
      facets, dim, X, &u,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t, const double* x) {
        add_follower_pressure(p, n.count, frame, n.x.data(), pressure(x), load.data(), nullptr);
      },
      [&](const FacetPlaces& n) { scatter(n, dim, load, force); });
}

void add_follower_pressure_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                                   const std::vector<double>& u,
                                   const std::function<double(const double* x)>& pressure,
                                   const std::vector<char>& fixed, std::span<const PetscInt> global_node,
                                   Mat matrix) {
  const int dim = dimension(frame);
  FacetVector load{};
  std::array<double, 9 * max_facet_nodes * max_facet_nodes> K{};
  visit_facets(
      facets, dim, X, &u,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t, const double* x) {
        add_follower_pressure(p, n.count, frame, n.x.data(), pressure(x), load.data(), K.data());
      },
      [&](const FacetPlaces& n) { add_block(n, dim, fixed, global_node, K, matrix); });
}

void for_each_facet_point(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                          const std::function<void(std::size_t index, const double* x)>& body) {
  visit_facets(
      facets, dimension(frame), X, nullptr,
      [&](const FacetPlaces&, const FacetPoint&, std::size_t i, const double* x) { body(i, x); },
      [](const FacetPlaces&) {});
}

double area_of(const FacetTable& facets, Frame frame, const std::vector<double>& X) {
  double area = 0;
  visit_facets(
      facets, dimension(frame), X, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t, const double*) {
        area += reference_area(p, n.count, frame, n.X.data());
      },
      [](const FacetPlaces&) {});
  return area;
}

double add_surface_heat(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                        const SurfaceHeat& heat, const std::vector<double>& theta, double weight,
                        std::vector<double>& load) {
  double total = 0;
  visit_facets(
      facets, dimension(frame), X, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t i, const double*) {
        double temperature = 0;
        for (int a = 0; a < n.count; ++a) temperature += p.N[a] * theta[at(n.node[at(a)])];
        const double in = weight * reference_area(p, n.count, frame, n.X.data()) *
                          (heat.inflow[i] - heat.coefficient[i] * temperature);
        for (int a = 0; a < n.count; ++a) load[at(n.node[at(a)])] += p.N[a] * in;
        total += in;
      },
      [](const FacetPlaces&) {});
  return total;
}

void add_surface_heat_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                              const SurfaceHeat& heat, double weight, const std::vector<char>& held,
                              const MiddleValues* middles, std::span<const PetscInt> global_node,
                              Mat matrix) {
  std::array<double, max_facet_nodes * max_facet_nodes> K{};
  visit_facets(
      facets, dimension(frame), X, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t i, const double*) {
        const double h = weight * reference_area(p, n.count, frame, n.X.data()) * heat.coefficient[i];
        for (int a = 0; a < n.count; ++a)
          for (int b = 0; b < n.count; ++b) K[at(a * n.count + b)] += h * p.N[a] * p.N[b];
      },
      [&](const FacetPlaces& n) {
        if (middles == nullptr)
          add_block(n, 1, held, global_node, K, matrix);
        else
          add_corner_block(n, held, *middles, global_node, K, matrix);
      });
}

} // namespace impact
