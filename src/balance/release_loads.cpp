#include <impact/balance/release.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/surface_load.hpp>
#include <numeric>

namespace impact {

namespace {

// Work of the loads on sides along u, with the nodes at the reference places X. What follows the deformation
// is a polynomial of second degree in the displacement: Simpson's rule is exact.
double work_of(const Discretisation& d, const BoundaryData& boundary, double t, const std::vector<double>& X,
               const std::vector<double>& u) {
  const PetscInt first = d.mesh.cell_start();
  std::vector<double> force(u.size(), 0.0), part(u.size());
  for (const LoadedFacets& load : boundary.tractions())
    add_dead_traction(
        d.eroded.live(load.facets, first), d.frame, X,
        [&](const double* x, double* value) { boundary.traction(load, x, t, value); }, force);
  for (const auto& [along, weight] : {std::pair{0.0, 1.0 / 6}, {0.5, 4.0 / 6}, {1.0, 1.0 / 6}}) {
    for (std::size_t i = 0; i < u.size(); ++i) part[i] = along * u[i];
    for (const LoadedFacets& load : boundary.pressures())
      add_follower_pressure(
          d.eroded.live(load.facets, first), d.frame, X, part,
          [&, w = weight](const double* x) { return w * boundary.scalar_value(load.condition, x, t); },
          force);
  }
  return std::inner_product(force.begin(), force.end(), u.begin(), 0.0);
}

} // namespace

double find_load_release(const Discretisation& d, const BoundaryData& boundary, double t, Vec u,
                         const std::vector<double>& moved) {
  if (boundary.tractions().empty() && boundary.pressures().empty()) return 0;
  const double step = 1e-3 * d.mesh.smallest_edge();
  const std::vector<double> local = d.local_of(u);
  const auto at_rest = d.mesh.coordinates();
  double change = 0;
  for (const double sign : {1.0, -1.0}) {
    std::vector<double> X(at_rest.begin(), at_rest.end());
    for (std::size_t i = 0; i < X.size(); ++i) X[i] += sign * step * moved[i];
    change += sign * work_of(d, boundary, t, X, local);
  }
  return sum_over_ranks(d.mesh.comm(), change) / (2 * step);
}

} // namespace impact
