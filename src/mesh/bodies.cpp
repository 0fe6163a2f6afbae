#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <limits>
#include <numeric>

namespace impact {

namespace {

constexpr int none = std::numeric_limits<int>::max();

class UnionFind {
public:
  explicit UnionFind(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[at(i)] != i) i = parent_[at(i)] = parent_[at(parent_[at(i)])];
    return i;
  }
  void join(int i, int j) { parent_[at(root(i))] = root(j); }

private:
  std::vector<int> parent_;
};

// The nodes of this rank that cells join.
UnionFind pieces_of(const Mesh& mesh, const std::vector<char>& counts) {
  UnionFind pieces(at(mesh.node_count()));
  for (const CellTable& table : mesh.cells()) {
    const auto n = at(node_count(table.shape));
    for (std::size_t cell = 0; cell < table.connectivity.size(); cell += n) {
      int first = -1;
      for (std::size_t i = cell; i < cell + n; ++i) {
        const int node = table.connectivity[i];
        if (!counts.empty() && !counts[at(node)]) continue;
        pieces.join(first < 0 ? node : first, node);
        first = node;
      }
    }
  }
  return pieces;
}

// Gives all nodes of a body the smallest of their values, which goes from rank to rank until none changes.
void share_smallest(const Mesh& mesh, UnionFind& pieces, std::vector<int>& value) {
  PetscInt chart_end = 0;
  check(DMPlexGetChart(mesh.dm(), nullptr, &chart_end));
  std::vector<int> of_point(at(chart_end), none);
  const auto shared = [&](int node) -> int& { return of_point[at(mesh.point(node))]; };
  for (int changed = 1; changed != 0; changed = max_over_ranks(mesh.comm(), changed)) {
    std::vector<int> smallest(value.size(), none);
    for (int i = 0; i < mesh.node_count(); ++i) {
      int& of_piece = smallest[at(pieces.root(i))];
      of_piece = std::min(of_piece, value[at(i)]);
    }
    for (int i = 0; i < mesh.node_count(); ++i) shared(i) = smallest[at(pieces.root(i))];
    share_points(mesh.dm(), MPI_MIN, of_point);
    changed = 0;
    for (int i = 0; i < mesh.node_count(); ++i)
      changed |= static_cast<int>(std::exchange(value[at(i)], shared(i)) != shared(i));
  }
}

} // namespace

Bodies find_bodies(const Mesh& mesh, const std::vector<char>& counts) {
  UnionFind pieces = pieces_of(mesh, counts);
  const auto global = mesh.global_node();
  std::vector<int> lowest(global.begin(), global.end());
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (!counts[i]) lowest[i] = none;
  share_smallest(mesh, pieces, lowest);
  std::vector<char> first(lowest.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    first[i] = lowest[i] == global[i] && mesh.owned(static_cast<int>(i));
  const auto mine = static_cast<int>(std::count(first.begin(), first.end(), 1));
  int end = 0;
  MPI_Scan(&mine, &end, 1, MPI_INT, MPI_SUM, mesh.comm());
  Bodies bodies{std::vector<int>(lowest.size(), none), sum_over_ranks(mesh.comm(), mine)};
  for (std::size_t i = 0, number = at(end - mine); i < first.size(); ++i)
    if (first[i]) bodies.of_node[i] = static_cast<int>(number++);
  share_smallest(mesh, pieces, bodies.of_node);
  std::replace(bodies.of_node.begin(), bodies.of_node.end(), none, -1);
  return bodies;
}

std::vector<char> nodes_of_bodies(const Mesh& mesh, const std::vector<int>& nodes) {
  const Bodies bodies = find_bodies(mesh);
  std::vector<int> held(at(bodies.count), 0);
  for (const int node : nodes) held[at(bodies.of_node[at(node)])] = 1;
  max_over_ranks(mesh.comm(), held);
  std::vector<char> in_body;
  for (const int body : bodies.of_node) in_body.push_back(static_cast<char>(held[at(body)]));
  return in_body;
}

} // namespace impact
