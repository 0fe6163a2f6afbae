#include <algorithm>
#include <cmath>
#include <impact/mesh/bodies.hpp>
#include <map>
#include <numeric>
#include <utility>

namespace impact {

namespace {

class UnionFind {
public:
  explicit UnionFind(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  // The lower number becomes the root.
  void join(std::size_t i, std::size_t j) {
    i = root(i);
    j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

private:
  std::vector<std::size_t> parent_;
};

std::vector<double> gather_all(MPI_Comm comm, const std::vector<double>& mine) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  std::vector<int> counts(static_cast<std::size_t>(ranks)), starts(static_cast<std::size_t>(ranks) + 1, 0);
  const int count = static_cast<int>(mine.size());
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  std::vector<double> all(static_cast<std::size_t>(starts.back()));
  MPI_Allgatherv(mine.data(), count, MPI_DOUBLE, all.data(), counts.data(), starts.data(), MPI_DOUBLE, comm);
  return all;
}

} // namespace

// Each rank joins the nodes of its cells and calls a piece by its lowest global node. A node on a border lies
// in a piece of its owner and in one of each rank that sees it: these pairs of names, known to all ranks,
// join the pieces.
Bodies find_bodies(const Mesh& mesh, const FieldLayout& layout, const std::vector<char>& counts) {
  const auto counting = [&](std::size_t node) { return counts.empty() || counts[node] != 0; };
  const auto components = static_cast<std::size_t>(layout.components());
  const auto nodes = static_cast<std::size_t>(mesh.node_count());
  UnionFind piece(nodes);
  for (const CellTable& table : mesh.cells()) {
    const auto n = static_cast<std::size_t>(node_count(table.shape));
    for (std::size_t cell = 0; cell < table.connectivity.size(); cell += n) {
      std::size_t first = nodes;
      for (std::size_t i = cell; i < cell + n; ++i) {
        const auto node = static_cast<std::size_t>(table.connectivity[i]);
        if (!counting(node)) continue;
        if (first == nodes) first = node;
        piece.join(first, node);
      }
    }
  }
  std::vector<double> lowest(nodes, HUGE_VAL), name(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    double& low = lowest[piece.root(i)];
    low = std::min(low, static_cast<double>(mesh.global_node()[i]));
  }
  for (std::size_t i = 0; i < nodes; ++i) name[i] = lowest[piece.root(i)];
  std::vector<double> owners_name = layout.make_local();
  for (std::size_t i = 0; i < nodes; ++i) owners_name[components * i] = name[i];
  const Handle<Vec> owned = layout.make_global();
  layout.to_global(owners_name, owned);
  layout.to_local(owned, owners_name);
  std::vector<std::pair<double, double>> pairs;
  for (std::size_t i = 0; i < nodes; ++i)
    if (counting(i)) pairs.emplace_back(name[i], owners_name[components * i]);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<double> flat;
  for (const auto& [a, b] : pairs) flat.insert(flat.end(), {a, b});
  flat = gather_all(mesh.comm(), flat);

  std::map<double, std::size_t> number; // of a piece, by rising name
  for (double a : flat) number.emplace(a, 0);
  std::size_t next = 0;
  for (auto& [piece_name, index] : number) index = next++;
  UnionFind joined(number.size());
  for (std::size_t i = 0; i < flat.size(); i += 2) joined.join(number.at(flat[i]), number.at(flat[i + 1]));
  std::map<std::size_t, int> body; // of a root, by rising root
  for (std::size_t i = 0; i < number.size(); ++i)
    if (joined.root(i) == i) body.emplace(i, static_cast<int>(body.size()));
  Bodies bodies{std::vector<int>(nodes, -1), static_cast<int>(body.size())};
  for (std::size_t i = 0; i < nodes; ++i)
    if (counting(i)) bodies.of_node[i] = body.at(joined.root(number.at(name[i])));
  return bodies;
}

} // namespace impact
