#pragma once
#include <cstdint>
#include <deque>
#include <functional>
#include <impact/mesh/cell_batches.hpp>
#include <impact/mesh/node_graph.hpp>
#include <vector>

/// Patches of linear triangles and tetrahedra that share one volume ratio, as the loops over cells see them:
/// mean dilatation over the cells of a patch (theory.md, volumetric locking).
namespace impact {

struct Batch;
struct CellBatch;
struct Discretisation;
struct MaterialAssignment;
class SoftVolume;

/// The patches of this rank. All their cells are here.
struct VolumePatches {
  VolumePatches() = default;
  /// Of those groups whose law takes the mean of J and whose cells the mesh has in patches.
  VolumePatches(const Mesh& mesh, const std::vector<CellGroup>& groups,
                const std::vector<MaterialAssignment>& materials);

  int count() const { return nodes.count(); }
  bool empty() const { return count() == 0; }
  std::vector<char> in_group;        ///< [group] its cells are in patches
  std::vector<int> of_lane;          ///< [group][batch][lane] patch; -1: none, as padding
  Lists<int> nodes;                  ///< [patch] its local nodes
  std::vector<std::uint16_t> corner; ///< [group][batch][node][lane], of those groups: place in that list
  std::deque<CellShape> shapes;      ///< a patch as a cell of all its nodes, for the assembly of matrices
  std::vector<CellGroup> stencils;   ///< patches as such cells
  std::vector<std::vector<int>> of_stencil; ///< [stencil][patch in packed order] its number

private:
  void find_corners(const std::vector<CellGroup>& groups);
};

/// What the cells of patches share in a state. Rows are [group][batch][component][lane], for the kernels.
struct PatchState {
  std::vector<double> J_minus_1; ///< a row; empty where there are no patches
  std::vector<double> pressure;  ///< a row, p and dp/dJ; empty where all points of a patch have the same
  std::vector<double> volume;    ///< [patch] reference volume of the cells that are there
  std::vector<double> ratio;     ///< [patch] J - 1
  std::vector<double> p, slope;  ///< [patch] p, dp/dJ, where pressures were asked for
};

/// What the shared volumes and pressures hang on, as local arrays and rows; damage, temperature and history
/// may be null.
struct PatchFields {
  const std::vector<double>*u, *phi = nullptr, *theta = nullptr, *history = nullptr;
  double unilateral = 1;                        ///< factor of the unilateral stress
  const std::vector<double>* warming = nullptr; ///< with the temperature
  const SoftVolume* soft = nullptr;             ///< whose laws count, or null
};

/// The state of the patches: pressures where damage, temperature or place make them differ within one, and
/// everywhere where `pressures`. No communication.
void share_volumes(const Discretisation& d, const PatchFields& fields, PatchState& state,
                   bool pressures = false);

/// Integrals over the cells of patches.
class PatchSum {
public:
  explicit PatchSum(const Discretisation& d);
  void add(const CellBatch& batch, const Batch& of_cells);
  /// A row of the integrals over the volume of the patches.
  void put_mean(const PatchState& state, std::vector<double>& row) const;

private:
  const Discretisation& d_;
  std::vector<double> sum_; // [patch]
};

/// body(stencil, batch, K) for packed patches: what the sharing of the volume adds to the tangent, (dp/dJ/V)
/// v v^T with v = int dJ/du dV_0, K [node][dim][node][dim]. `state`: with all pressures. `free` [local dof]:
/// 0 where nothing is added. Returns the sum of the diagonals. No communication.
double add_patch_tangents(const Discretisation& d, const std::vector<double>& u, const PatchState& state,
                          const std::vector<double>& free,
                          const std::function<void(int stencil, int batch, const Batch* K)>& body);

} // namespace impact
