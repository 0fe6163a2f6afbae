#pragma once
#include <array>
#include <impact/kernel/boundary_load.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <petscmat.h>
#include <span>
#include <vector>

/// The points of boundary facets one after the other, and where what they sum up goes.
namespace impact {

// A mixed 3D table repeats the last node of its triangles.
inline int count_nodes(const FacetTable& facets, int f) {
  int n = facets.nodes_per_facet;
  const int* node = &facets.connectivity[at(f * n)];
  while (node[n - 1] == node[n - 2]) --n;
  return n;
}

using FacetVector = std::array<double, 3 * max_facet_nodes>; // [node][dim]

struct FacetPlaces {
  int count;
  std::array<int, max_facet_nodes> node;
  FacetVector X, x;
};

inline FacetPlaces facet_nodes(const FacetTable& facets, int f, int dim, const std::vector<double>& X,
                               const std::vector<double>* u) {
  FacetPlaces n{count_nodes(facets, f), {}, {}, {}};
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

// point(nodes, point, its index, its reference position) at all points of each facet, then done(nodes).
template <class Point, class Done>
void visit_facets(const FacetTable& facets, int dim, const std::vector<double>& X,
                  const std::vector<double>* u, Point&& point, Done&& done) {
  for (int f = 0; f < facets.count(); ++f) {
    const FacetPlaces n = facet_nodes(facets, f, dim, X, u);
    for (int q = 0; q < facet_points(dim, n.count); ++q) {
      const FacetPoint p = facet_point(dim, n.count, q);
      double x[3] = {0, 0, 0};
      facet_position(p, n.count, dim, n.X.data(), x);
      point(n, p, at(f) * max_facet_nodes + at(q), x);
    }
    done(n);
  }
}

// force += load, which then is zero.
inline void scatter(const FacetPlaces& n, int dim, FacetVector& load, std::vector<double>& force) {
  for (int a = 0; a < n.count; ++a)
    for (int k = 0; k < dim; ++k) force[at(n.node[at(a)] * dim + k)] += load[at(a * dim + k)];
  load.fill(0);
}

// matrix += K, over `components` of each node without the held ones; K then is zero.
template <std::size_t size>
void add_block(const FacetPlaces& n, int components, const std::vector<char>& held,
               std::span<const PetscInt> global_node, std::array<double, size>& K, Mat matrix) {
  std::array<PetscInt, 3 * max_facet_nodes> row{};
  const int count = n.count * components;
  for (int i = 0; i < count; ++i) {
    const int node = n.node[at(i / components)], k = i % components;
    row[at(i)] =
        held[at(node * components + k)] ? -1 : global_node[at(node)] * components + k; // -1: left out
  }
  check(MatSetValues(matrix, count, row.data(), count, row.data(), K.data(), ADD_VALUES));
  K.fill(0);
}

} // namespace impact
