#include <array>
#include <impact/kernel/boundary_load.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/surface_load.hpp>

namespace impact {

namespace {

// A mixed 3D table repeats the last node of its triangles.
int corners(const FacetTable& facets, int f) {
  const int n = facets.nodes_per_facet;
  const auto base = at(f * n);
  return n == 4 && facets.connectivity[base + 3] == facets.connectivity[base + 2] ? 3 : n;
}

struct FacetNodes {
  int count;
  std::array<int, 4> node;
  std::array<double, 12> X, x;
};

FacetNodes facet_nodes(const FacetTable& facets, int f, int dim, const std::vector<double>& X,
                       const std::vector<double>* u) {
  FacetNodes n{corners(facets, f), {}, {}, {}};
  for (int a = 0; a < n.count; ++a) {
    const int node = facets.connectivity[at(f * facets.nodes_per_facet + a)];
    n.node[at(a)] = node;
    for (int k = 0; k < dim; ++k) {
      const auto i = at(node * dim + k), j = at(a * dim + k);
      n.X[j] = X[i];
      n.x[j] = X[i] + (u ? (*u)[i] : 0.0);
    }
  }
  return n;
}

void scatter(const FacetNodes& n, int dim, const std::array<double, 12>& f, std::vector<double>& force) {
  for (int a = 0; a < n.count; ++a)
    for (int k = 0; k < dim; ++k) force[at(n.node[at(a)] * dim + k)] += f[at(a * dim + k)];
}

} // namespace

void add_dead_traction(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                       const std::function<void(const double* x, double* value)>& traction,
                       std::vector<double>& force) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, nullptr);
    std::array<double, 12> load{};
    for (int q = 0; q < n.count; ++q) {
      const FacetPoint p = facet_point(n.count, q);
      double x[3] = {0, 0, 0}, t[3] = {0, 0, 0};
      facet_position(p, n.count, dim, n.X.data(), x);
      traction(x, t);
      add_dead_traction(p, n.count, frame, n.X.data(), t, load.data());
    }
    scatter(n, dim, load, force);
  }
}

void add_follower_pressure(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                           const std::vector<double>& u,
                           const std::function<double(const double* x)>& pressure,
                           std::vector<double>& force) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, &u);
    std::array<double, 12> load{};
    for (int q = 0; q < n.count; ++q) {
      const FacetPoint p = facet_point(n.count, q);
      double x[3] = {0, 0, 0};
      facet_position(p, n.count, dim, n.X.data(), x);
      add_follower_pressure(p, n.count, frame, n.x.data(), pressure(x), load.data(), nullptr);
    }
    scatter(n, dim, load, force);
  }
}

void add_follower_pressure_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                                   const std::vector<double>& u,
                                   const std::function<double(const double* x)>& pressure,
                                   const std::vector<char>& fixed, std::span<const PetscInt> global_node,
                                   Mat matrix) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, &u);
    const int dofs = n.count * dim;
    std::array<double, 12> load{};
    std::array<double, 144> K{};
    for (int q = 0; q < n.count; ++q) {
      const FacetPoint p = facet_point(n.count, q);
      double x[3] = {0, 0, 0};
      facet_position(p, n.count, dim, n.X.data(), x);
      add_follower_pressure(p, n.count, frame, n.x.data(), pressure(x), load.data(), K.data());
    }
    std::array<PetscInt, 12> index{};
    for (int i = 0; i < dofs; ++i) {
      const int node = n.node[at(i / dim)];
      const bool held = fixed[at(node * dim + i % dim)] != 0;
      // A negative index leaves the row and the column out.
      index[at(i)] = held ? -1 : global_node[at(node)] * dim + i % dim;
    }
    check(MatSetValues(matrix, dofs, index.data(), dofs, index.data(), K.data(), ADD_VALUES));
  }
}

namespace {

std::size_t point_index(int f, int q) { return at(f) * points_per_facet + at(q); }

} // namespace

void for_each_facet_point(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                          const std::function<void(std::size_t index, const double* x)>& body) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, nullptr);
    for (int q = 0; q < n.count; ++q) {
      double x[3] = {0, 0, 0};
      facet_position(facet_point(n.count, q), n.count, dim, n.X.data(), x);
      body(point_index(f, q), x);
    }
  }
}

double add_surface_heat(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                        const SurfaceHeat& heat, const std::vector<double>& theta, double weight,
                        std::vector<double>& load) {
  double total = 0;
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dimension(frame), X, nullptr);
    for (int q = 0; q < n.count; ++q) {
      const FacetPoint p = facet_point(n.count, q);
      double temperature = 0;
      for (int a = 0; a < n.count; ++a) temperature += p.N[a] * theta[at(n.node[at(a)])];
      const std::size_t i = point_index(f, q);
      const double in = weight * reference_area(p, n.count, frame, n.X.data()) *
                        (heat.inflow[i] - heat.coefficient[i] * temperature);
      for (int a = 0; a < n.count; ++a) load[at(n.node[at(a)])] += p.N[a] * in;
      total += in;
    }
  }
  return total;
}

void add_surface_heat_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                              const SurfaceHeat& heat, double weight, const std::vector<char>& held,
                              std::span<const PetscInt> global_node, Mat matrix) {
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dimension(frame), X, nullptr);
    std::array<double, 16> K{};
    std::array<PetscInt, 4> index{};
    for (int q = 0; q < n.count; ++q) {
      const FacetPoint p = facet_point(n.count, q);
      const double h =
          weight * reference_area(p, n.count, frame, n.X.data()) * heat.coefficient[point_index(f, q)];
      for (int a = 0; a < n.count; ++a)
        for (int b = 0; b < n.count; ++b) K[at(a * n.count + b)] += h * p.N[a] * p.N[b];
    }
    for (int a = 0; a < n.count; ++a) {
      const auto node = at(n.node[at(a)]);
      index[at(a)] = held[node] ? -1 : global_node[node]; // negative: left out
    }
    check(MatSetValues(matrix, n.count, index.data(), n.count, index.data(), K.data(), ADD_VALUES));
  }
}

} // namespace impact
