#pragma once
#include <impact/math/batch.hpp>
#include <impact/mesh/mesh.hpp>
#include <type_traits>

/// Cells of equal shape and material packed lane by lane: the only place that knows lanes and padding. A
/// short last batch repeats its last cell; those lanes are never scattered or summed. Cells are in the mesh's
/// order (locality).
namespace impact {

struct CellGroup {
  Shape shape;
  int material = 0; ///< index into the run's list of materials
  int law = 0;      ///< index into its list of laws, several of one material where a number depends on place
  int cell_count = 0, batch_count = 0;
  std::vector<int> node;             ///< [batch][node][lane] local node
  std::vector<PetscInt> cell_point;  ///< [batch][lane] DMPlex point (padding repeats)
  int lanes_in_use(int batch) const; ///< lanes of `batch` that hold a cell of their own
};

/// Packs all cells. `law_of_cell[p - mesh.cell_start()]` is the law index of DMPlex cell point p, and the
/// material until the caller says otherwise. The list of groups (shape, law) is the same on all ranks, by
/// rising law, then shape; a rank without such cells has an empty group. Throws UserError(data) when a cell
/// has no law (-1), naming its coordinates. Collective.
std::vector<CellGroup> pack_cells(const Mesh& mesh, const std::vector<int>& law_of_cell);

/// The local nodes of one batch, [node][lane].
inline const int* batch_nodes(const CellGroup& group, int batch) {
  return group.node.data() + static_cast<std::ptrdiff_t>(batch) * group.shape->nodes * lanes;
}

/// Gathers `components` values per node of one batch from a local array [node][component].
/// out: [node][component] of Batch.
template <int components> void gather(const CellGroup& group, int batch, const double* local, Batch* out) {
  const int* node = batch_nodes(group, batch);
  for (int a = 0; a < group.shape->nodes; ++a, node += lanes, out += components) {
    const double* from[lanes];
    for (int l = 0; l < lanes; ++l) from[l] = local + static_cast<std::ptrdiff_t>(node[l]) * components;
    for (int k = 0; k < components; ++k)
      for (int l = 0; l < lanes; ++l) out[k].set(l, from[l][k]);
  }
}

/// Adds [node][component] of Batch to the local array; padding lanes are skipped.
template <int components>
void scatter_add(const CellGroup& group, int batch, const Batch* values, double* local) {
  const int* node = batch_nodes(group, batch);
  const int used = group.lanes_in_use(batch), nodes = group.shape->nodes;
  for (int l = 0; l < used; ++l)
    for (int a = 0; a < nodes; ++a) {
      double* to = local + static_cast<std::ptrdiff_t>(node[a * lanes + l]) * components;
      for (int k = 0; k < components; ++k) to[k] += values[a * components + k][l];
    }
}

/// Calls f with the number of components, 1, 2 or 3, as a constant.
template <class F> decltype(auto) with_components(int components, F&& f) {
  switch (components) {
  case 1:
    return f(std::integral_constant<int, 1>{});
  case 2:
    return f(std::integral_constant<int, 2>{});
  default:
    return f(std::integral_constant<int, 3>{});
  }
}

/// The same, for a number of components that is known at run time.
inline void gather(const CellGroup& group, int batch, int components, const double* local, Batch* out) {
  with_components(components, [&](auto c) { gather<c>(group, batch, local, out); });
}
inline void scatter_add(const CellGroup& group, int batch, int components, const Batch* values,
                        double* local) {
  with_components(components, [&](auto c) { scatter_add<c>(group, batch, values, local); });
}

} // namespace impact
