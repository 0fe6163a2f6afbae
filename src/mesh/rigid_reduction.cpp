#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/rigid_reduction.hpp>

namespace impact {

void RigidReduction::modes(const RigidPlace& body, const Matrix3& of, const double* X, int k,
                           double* mode) const {
  std::fill(mode, mode + dim_ + rotations(), 0.0);
  mode[k] = 1;
  Vector3 arm{};
  for (int i = 0; i < dim_; ++i) arm[at(i)] = X[i] - body.centre[at(i)];
  arm = of * arm;
  if (dim_ == 2) {
    mode[2] = (k == 0 ? -arm[1] : arm[0]) / body.length;
    return;
  }
  // e_j x arm in direction k.
  const int next = (k + 1) % 3, last = (k + 2) % 3;
  mode[3 + next] = arm[at(last)] / body.length;
  mode[3 + last] = -arm[at(next)] / body.length;
}

void RigidReduction::rows(const RigidPlace& body, PetscInt* row) const {
  for (int k = 0; k < dim_; ++k) row[k] = body.held[at(k)] ? -1 : dim_ * body.slot[0] + k;
  for (int k = 0; k < rotations(); ++k)
    row[dim_ + k] = body.held[at(dim_ == 3 ? 3 + k : 5)] ? -1 : dim_ * body.slot[1] + k;
}

void RigidReduction::Block::build(const RigidReduction& reduction, std::span<const Node> nodes,
                                  std::span<const double> K) {
  const int dim = reduction.dim(), width = dim + reduction.rotations();
  const auto d = at(dim), n = d * nodes.size();
  rows_.clear();
  start_.clear();
  placed_.clear();
  for (const Node& node : nodes) {
    if (node.body < 0) {
      start_.push_back(rows_.size());
      for (int k = 0; k < dim; ++k)
        rows_.push_back(node.fixed != nullptr && node.fixed[k] ? -1 : dim * node.node + k);
      continue;
    }
    const auto known = std::find_if(placed_.begin(), placed_.end(),
                                    [&](const auto& place) { return place.first == node.body; });
    if (known != placed_.end()) {
      start_.push_back(known->second);
      continue;
    }
    start_.push_back(rows_.size());
    placed_.emplace_back(node.body, rows_.size());
    rows_.resize(rows_.size() + at(width));
    reduction.rows(reduction.bodies()[at(node.body)], &rows_[start_.back()]);
  }
  const std::size_t m = rows_.size();
  // Dense factors, small as these blocks are: [dof][unknown].
  left_.assign(n * m, 0.0);
  right_.assign(n * m, 0.0);
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (int k = 0; k < dim; ++k) {
      const std::size_t at_dof = (d * a + at(k)) * m + start_[a];
      if (nodes[a].body < 0) {
        left_[at_dof + at(k)] = right_[at_dof + at(k)] = 1;
        continue;
      }
      const RigidPlace& body = reduction.bodies()[at(nodes[a].body)];
      reduction.modes(body, body.test, nodes[a].X, k, &left_[at_dof]);
      reduction.modes(body, body.trial, nodes[a].X, k, &right_[at_dof]);
    }
  half_.assign(n * m, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      if (const double value = K[i * n + j]; value != 0)
        for (std::size_t c = 0; c < m; ++c) half_[i * m + c] += value * right_[j * m + c];
  values_.assign(m * m, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t r = 0; r < m; ++r)
      if (const double weight = left_[i * m + r]; weight != 0)
        for (std::size_t c = 0; c < m; ++c) values_[r * m + c] += weight * half_[i * m + c];
}

} // namespace impact
