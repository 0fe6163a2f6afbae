#pragma once
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

} // namespace impact
