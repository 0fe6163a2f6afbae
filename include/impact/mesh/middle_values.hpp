#pragma once
#include <impact/mesh/mesh.hpp>
#include <span>
#include <vector>

/// A nodal field of first order on cells of second order: what stands in the middle of an edge, a face or a
/// cell is the mean of the corners around it, which the quadratic functions take for the (multi)linear
/// function of those.
namespace impact {

class MiddleValues {
public:
  /// Local: every node of a rank belongs to one of its cells.
  explicit MiddleValues(const Mesh& mesh);

  bool is_middle(int node) const { return corners_[static_cast<std::size_t>(node)].size() > 1; }
  /// Whose mean the value of a node is; of a corner itself.
  std::span<const int> corners(int node) const { return corners_[static_cast<std::size_t>(node)]; }
  /// Middles of a local field [node] from its corners.
  void fill(std::vector<double>& values) const;
  /// The transpose: forces at middles act at the corners, and vanish.
  void fold(std::vector<double>& forces) const;

private:
  std::vector<std::vector<int>> corners_; ///< [node]
};

} // namespace impact
