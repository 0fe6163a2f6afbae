#pragma once
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <vector>

namespace impact {

/// Which dofs of the displacement have an equation of their own: not the prescribed ones, and of rigid bodies
/// only those that stand for their unknowns. Local dofs are node * dim + component.
struct MotionRows {
  MotionRows(const Discretisation& discretisation, const BoundaryData& boundary, const RigidBodies& rigid);

  std::vector<double> free;    ///< [local dof] 1 on dofs of deformable bodies that are not prescribed, else 0
  std::vector<char> none;      ///< [local dof] 1 where `free` is 0
  std::vector<int> prescribed; ///< owned prescribed dofs
  std::vector<int> of_identity;                ///< owned dofs whose row in the tangent is one of the identity
  std::vector<int> massless;                   ///< owned dofs where `free` is 0
  std::vector<std::vector<char>> held_batches; ///< [group][batch] 1: has dofs where `free` is 0
};

/// The consistent mass of all bodies, assembled when it is first asked for.
class MassMatrix {
public:
  /// Both must outlive the matrix.
  MassMatrix(const Discretisation& discretisation, const MotionRows& rows)
      : d_(discretisation), rows_(rows) {}

  /// y = M x, prescribed rows included. Collective.
  void multiply(Vec x, Vec y);
  /// Solves M x = b on free dofs; other entries of x keep their values, their columns lifted. Throws
  /// UserError. Collective.
  void solve(Vec b, Vec x);
  /// Adds factor M to an assembly of the displacement's matrix, `masked`: without the rows and columns of
  /// dofs that are not free. Returns this rank's sum of the diagonal that was added.
  double add_to(SparseAssembly& assembly, double factor, bool masked) const;

private:
  void build();

  const Discretisation& d_;
  const MotionRows& rows_;
  Handle<Mat> all_, free_; // free_: rows and columns of dofs that are not free as identity
  Handle<KSP> solver_;
};

} // namespace impact
