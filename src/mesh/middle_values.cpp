#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/middle_values.hpp>

namespace impact {

MiddleValues::MiddleValues(const Mesh& mesh) : corners_(at(mesh.node_count())) {
  for (const CellTable& table : mesh.cells())
    for (int a = 0; a < table.shape->nodes; ++a) {
      const std::vector<int> around = corners_around(table.shape, a);
      for (std::size_t c = 0; c < table.point.size(); ++c) {
        const int* node = &table.connectivity[c * at(table.shape->nodes)];
        std::vector<int>& mine = corners_[at(node[a])];
        if (!mine.empty()) continue;
        for (const int corner : around) mine.push_back(node[corner]);
        std::ranges::sort(mine, {}, [&](int n) { return mesh.global_node()[at(n)]; });
      }
    }
}

void MiddleValues::fill(std::vector<double>& values) const {
  for (std::size_t node = 0; node < corners_.size(); ++node) {
    if (corners_[node].size() < 2) continue;
    double sum = 0;
    for (const int corner : corners_[node]) sum += values[at(corner)];
    values[node] = sum / static_cast<double>(corners_[node].size());
  }
}

void MiddleValues::fold(std::vector<double>& forces) const {
  for (std::size_t node = 0; node < corners_.size(); ++node) {
    if (corners_[node].size() < 2) continue;
    const double share = forces[node] / static_cast<double>(corners_[node].size());
    for (const int corner : corners_[node]) forces[at(corner)] += share;
    forces[node] = 0;
  }
}

} // namespace impact
