#include <algorithm>
#include <impact/problem/motion_rows.hpp>

namespace impact {

MotionRows::MotionRows(const Discretisation& d, const BoundaryData& boundary, const RigidBodies& rigid)
    : free(d.node_values(d.dim()), 1.0), none(boundary.fixed_mask()) {
  const int dim = d.dim();
  for (int dof = 0; dof < static_cast<int>(free.size()); ++dof)
    if (none[at(dof)] && d.mesh.owned(dof / dim)) prescribed.push_back(dof);
  of_identity = massless = prescribed;
  of_identity.insert(of_identity.end(), rigid.idle_dofs().begin(), rigid.idle_dofs().end());
  for (int dof = 0; dof < static_cast<int>(free.size()); ++dof) {
    if (!rigid.empty() && rigid.body_of_node()[at(dof / dim)] >= 0) {
      none[at(dof)] = 1;
      if (d.mesh.owned(dof / dim)) massless.push_back(dof);
    }
    if (none[at(dof)]) free[at(dof)] = 0;
  }
  for (const CellGroup& group : d.groups) {
    std::vector<char>& held = held_batches.emplace_back(at(group.batch_count), 0);
    const std::size_t size = group.node.size() / std::max<std::size_t>(held.size(), 1);
    for (std::size_t i = 0; i < group.node.size(); ++i)
      for (int k = 0; k < dim; ++k)
        if (none[at(group.node[i] * dim + k)]) held[i / size] = 1;
  }
}

} // namespace impact
