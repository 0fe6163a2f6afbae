#pragma once
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/scratch_vec.hpp>
#include <vector>

/// The dofs of one nodal field: `components` per mesh node, node-blocked. In a local vector (ghosts included)
/// node i, component k stands at i * components + k; in a global vector at global_node[i] * components + k.
namespace impact {

class FieldLayout {
public:
  /// Clones the mesh's DM and lays `components` dofs on every node. Collective.
  FieldLayout(const Mesh& mesh, std::string name, int components);

  DM dm() const { return dm_; }
  int components() const { return components_; }
  const std::string& name() const { return name_; }
  Handle<Vec> make_global() const; ///< zeroed, block size set, named after the field. Collective.
  ScratchVec scratch() const { return ScratchVec(dm_); } ///< Collective.
  std::vector<double> make_local() const;                ///< zeroed [node][component], ghosts included

  /// Copies a global vector into a local array, ghosts included. Collective.
  void to_local(Vec global, std::vector<double>& local) const;
  /// Owned entries alone, without a message: ghosts keep what they have.
  void owned_to_local(Vec global, std::vector<double>& local) const;
  /// call(place in this rank's part of a global vector, place in a local array) for each entry owned.
  template <class Call> void for_each_owned(Call&& call) const {
    for (const Row& row : owned_)
      for (PetscInt i = 0; i < row.count * components_; ++i)
        call(row.place * components_ + i, static_cast<std::size_t>(row.node * components_ + i));
  }
  /// Adds a local array (contributions on ghosts included) into a global vector: one reverse message per
  /// neighbour. Collective.
  void add_to_global(const std::vector<double>& local, Vec global) const;
  /// Sets owned entries of a global vector from a local array; ghosts are ignored.
  void to_global(const std::vector<double>& local, Vec global) const;

private:
  std::string name_;
  int components_;
  Handle<DM> dm_;
  Handle<Vec> work_; ///< local vector reused by the transfers
  int node_count_;
  /// Nodes of this rank that follow one another both among its local nodes and among those that it owns.
  struct Row {
    PetscInt node, place, count;
  };
  std::vector<Row> owned_;
};

/// Whether factorising matrices over all displacements is what a run does unless its options say otherwise:
/// up to 1.5e6 unknowns in the plane and 2e4 in space, where fill grows faster.
inline bool is_factorised(const Mesh& mesh) {
  return mesh.global_node_count() * mesh.dim() <= (mesh.dim() == 2 ? 1500000 : 20000);
}

/// Whether they may be where need is: up to 3e5 unknowns in space, where factors take 6 GB.
inline bool can_be_factorised(const Mesh& mesh) {
  return is_factorised(mesh) || mesh.global_node_count() * mesh.dim() <= 300000;
}

/// Translations and infinitesimal rotations on the coordinates of the mesh, for algebraic multigrid
/// (MatSetNearNullSpace). Needs components() == mesh.dim(). Collective.
Handle<MatNullSpace> near_null_space(const FieldLayout& layout, const Mesh& mesh);

} // namespace impact
