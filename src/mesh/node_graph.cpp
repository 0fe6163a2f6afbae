#include <algorithm>
#include <impact/mesh/exchange.hpp>
#include <impact/mesh/node_graph.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace impact {

namespace {

// A cell in the packed order of its group.
const int* nodes_of(const CellGroup& group, int cell) {
  return group.node.data() + static_cast<std::ptrdiff_t>(cell / lanes) * node_count(group.shape) * lanes +
         cell % lanes;
}

} // namespace

// Local nodes that share a cell with a node, sorted by global number, and the cells around it.
struct NodeGraph::Adjacency {
  struct Place {
    int group, cell, corner;
  };
  Lists<Place> cells;
  Lists<int> nodes;

  Adjacency(const Mesh& mesh, const std::vector<CellGroup>& groups) {
    cells.start.resize(at(mesh.node_count() + 1));
    for_each_corner(groups, [&](Place, int n) { ++cells.start[at(n + 1)]; });
    std::partial_sum(cells.start.begin(), cells.start.end(), cells.start.begin());
    cells.values.resize(cells.start.back());
    std::vector<std::size_t> next = cells.start;
    for_each_corner(groups, [&](Place place, int n) { cells.values[next[at(n)]++] = place; });

    std::vector<int> seen(at(mesh.node_count()), -1);
    for (int n = 0; n < mesh.node_count(); ++n) {
      for (const Place& place : cells[n]) {
        const CellGroup& group = groups[at(place.group)];
        for (int a = 0; a < node_count(group.shape); ++a) {
          const int other = nodes_of(group, place.cell)[a * lanes];
          if (std::exchange(seen[at(other)], n) != n) nodes.values.push_back(other);
        }
      }
      std::sort(nodes.values.begin() + static_cast<std::ptrdiff_t>(nodes.start.back()), nodes.values.end(),
                [&](int i, int j) { return mesh.global_node()[at(i)] < mesh.global_node()[at(j)]; });
      nodes.end_list();
    }
  }

private:
  template <class Body> static void for_each_corner(const std::vector<CellGroup>& groups, Body&& body) {
    for (int g = 0; g < static_cast<int>(groups.size()); ++g)
      for (int c = 0; c < groups[at(g)].cell_count; ++c)
        for (int a = 0; a < node_count(groups[at(g)].shape); ++a)
          body(Place{g, c, a}, nodes_of(groups[at(g)], c)[a * lanes]);
  }
};

NodeGraph::NodeGraph(const Mesh& mesh, const std::vector<CellGroup>& groups,
                     const std::vector<std::pair<PetscInt, PetscInt>>& extra)
    : comm(mesh.comm()) {
  int ranks = 1, rank = 0;
  MPI_Comm_size(comm, &ranks);
  MPI_Comm_rank(comm, &rank);
  const PetscInt mine = mesh.owned_node_count();
  std::vector<PetscInt> rank_end(at(ranks)); // one past the last node of each rank
  MPI_Allgather(&mine, 1, MPIU_INT, rank_end.data(), 1, MPIU_INT, comm);
  std::partial_sum(rank_end.begin(), rank_end.end(), rank_end.begin());
  first_node = rank_end[at(rank)] - mine;

  const Owner owner = [&](PetscInt global_node) {
    if (global_node < 0 || global_node >= rank_end.back())
      throw std::out_of_range("extra pair with global node " + std::to_string(global_node));
    return static_cast<int>(std::upper_bound(rank_end.begin(), rank_end.end(), global_node) -
                            rank_end.begin());
  };

  const Adjacency near(mesh, groups);
  lay_ghost_rows(mesh, near, owner);

  // Rows of ours that other ranks' cells reach: [row, column count, columns...].
  std::vector<std::vector<PetscInt>> out(at(ranks)), out_extra(at(ranks));
  for (const Neighbour& to : send)
    for (int g = to.first_row; g < to.end_row; ++g) {
      auto& message = out[at(to.rank)];
      message.push_back(ghost_node[at(g)]);
      message.push_back(static_cast<PetscInt>(ghost_columns[g].size()));
      message.insert(message.end(), ghost_columns[g].begin(), ghost_columns[g].end());
    }
  for (const auto& [i, j] : extra) {
    out_extra[at(owner(i))].insert(out_extra[at(owner(i))].end(), {i, j});
    out_extra[at(owner(j))].insert(out_extra[at(owner(j))].end(), {j, i});
  }
  const auto in = all_to_all(comm, out), in_extra = all_to_all(comm, out_extra);

  std::vector<std::pair<int, PetscInt>> more;
  for (const auto& message : in)
    for (std::size_t k = 0; k < message.size(); k += 2 + static_cast<std::size_t>(message[k + 1]))
      for (std::size_t c = 0; c < static_cast<std::size_t>(message[k + 1]); ++c)
        more.emplace_back(static_cast<int>(message[k] - first_node), message[k + 2 + c]);
  for (const auto& message : in_extra)
    for (std::size_t k = 0; k < message.size(); k += 2)
      more.emplace_back(static_cast<int>(message[k] - first_node), message[k + 1]);
  lay_own_rows(mesh, near, more);
  find_slots(mesh, groups, near);

  for (int r = 0; r < ranks; ++r) {
    const auto& message = in[at(r)];
    const int first = static_cast<int>(received_row.size());
    for (std::size_t k = 0; k < message.size(); k += 2 + static_cast<std::size_t>(message[k + 1])) {
      const int row = received_row.emplace_back(static_cast<int>(message[k] - first_node));
      for (std::size_t c = 0; c < static_cast<std::size_t>(message[k + 1]); ++c)
        received_slots.values.push_back(slot(row, message[k + 2 + c]));
      received_slots.end_list();
    }
    if (!message.empty()) receive.push_back({r, first, static_cast<int>(received_row.size())});
  }
}

// Owners follow each other in global numbers, so sorting ghosts by global number also sorts them by owner.
void NodeGraph::lay_ghost_rows(const Mesh& mesh, const Adjacency& near, const Owner& owner) {
  const auto global = mesh.global_node();
  row_of_node.resize(at(mesh.node_count()));
  std::vector<int> ghosts;
  for (int n = 0; n < mesh.node_count(); ++n) {
    row_of_node[at(n)] = static_cast<int>(global[at(n)] - first_node);
    if (!mesh.owned(n)) ghosts.push_back(n);
  }
  std::sort(ghosts.begin(), ghosts.end(), [&](int i, int j) { return global[at(i)] < global[at(j)]; });
  for (int g = 0; g < static_cast<int>(ghosts.size()); ++g) {
    const int n = ghosts[at(g)], to = owner(global[at(n)]);
    row_of_node[at(n)] = -1 - g;
    ghost_node.push_back(global[at(n)]);
    for (const int other : near.nodes[n]) ghost_columns.values.push_back(global[at(other)]);
    ghost_columns.end_list();
    if (send.empty() || send.back().rank != to) send.push_back({to, g, g});
    send.back().end_row = g + 1;
  }
}

void NodeGraph::lay_own_rows(const Mesh& mesh, const Adjacency& near,
                             std::vector<std::pair<int, PetscInt>>& more) {
  const PetscInt end_node = first_node + mesh.owned_node_count();
  std::sort(more.begin(), more.end());
  auto next = more.begin();
  std::vector<PetscInt> row;
  for (int n = 0; n < mesh.node_count(); ++n) { // owned nodes come in the order of their rows
    if (!mesh.owned(n)) continue;
    const int r = row_of_node[at(n)];
    row.assign(1, mesh.global_node()[at(n)]);
    for (const int other : near.nodes[n]) row.push_back(mesh.global_node()[at(other)]);
    for (; next != more.end() && next->first == r; ++next) row.push_back(next->second);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    if (row.size() > std::numeric_limits<std::uint16_t>::max())
      throw std::length_error("a matrix row is too long");
    const auto own = std::stable_partition(row.begin(), row.end(),
                                           [&](PetscInt c) { return c >= first_node && c < end_node; });
    own_columns.push_back(static_cast<int>(own - row.begin()));
    columns.values.insert(columns.values.end(), row.begin(), row.end());
    columns.end_list();
  }
}

std::uint16_t NodeGraph::slot(int row, PetscInt global_node) const {
  const auto all = columns[row];
  const auto middle = all.begin() + own_columns[at(row)];
  const bool own = global_node >= first_node && global_node < first_node + columns.count();
  const auto found = own ? std::lower_bound(all.begin(), middle, global_node)
                         : std::lower_bound(middle, all.end(), global_node);
  return static_cast<std::uint16_t>(found - all.begin());
}

void NodeGraph::find_slots(const Mesh& mesh, const std::vector<CellGroup>& groups, const Adjacency& near) {
  for (const CellGroup& g : groups)
    slots.emplace_back(at(g.cell_count) * at(node_count(g.shape)) * at(node_count(g.shape)));
  std::vector<std::uint16_t> slot_of_node(at(mesh.node_count()));
  for (int n = 0; n < mesh.node_count(); ++n) {
    const auto others = near.nodes[n];
    const int row = row_of_node[at(n)];
    for (std::size_t k = 0; k < others.size(); ++k)
      slot_of_node[at(others[k])] =
          row >= 0 ? slot(row, mesh.global_node()[at(others[k])]) : static_cast<std::uint16_t>(k);
    for (const auto& place : near.cells[n]) {
      const CellGroup& group = groups[at(place.group)];
      const int nodes = node_count(group.shape);
      std::uint16_t* out = &slots[at(place.group)][at(place.cell * nodes + place.corner) * at(nodes)];
      for (int b = 0; b < nodes; ++b) out[b] = slot_of_node[at(nodes_of(group, place.cell)[b * lanes])];
    }
  }
}

} // namespace impact
