#include <algorithm>
#include <impact/mesh/node_graph.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

namespace impact {

namespace {

std::size_t at(int k) { return static_cast<std::size_t>(k); }

// One message of integers to each rank, one from each; a set-up step, so that the dense exchange does not
// matter.
std::vector<std::vector<PetscInt>> all_to_all(MPI_Comm comm, const std::vector<std::vector<PetscInt>>& out) {
  const std::size_t ranks = out.size();
  std::vector<int> send_count(ranks), receive_count(ranks), send_at(ranks + 1), receive_at(ranks + 1);
  for (std::size_t r = 0; r < ranks; ++r) send_count[r] = static_cast<int>(out[r].size());
  MPI_Alltoall(send_count.data(), 1, MPI_INT, receive_count.data(), 1, MPI_INT, comm);
  std::partial_sum(send_count.begin(), send_count.end(), send_at.begin() + 1);
  std::partial_sum(receive_count.begin(), receive_count.end(), receive_at.begin() + 1);
  std::vector<PetscInt> packed, received(at(receive_at.back()));
  packed.reserve(at(send_at.back()));
  for (const auto& message : out) packed.insert(packed.end(), message.begin(), message.end());
  MPI_Alltoallv(packed.data(), send_count.data(), send_at.data(), MPIU_INT, received.data(),
                receive_count.data(), receive_at.data(), MPIU_INT, comm);
  std::vector<std::vector<PetscInt>> in(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    in[r].assign(received.begin() + receive_at[r], received.begin() + receive_at[r + 1]);
  return in;
}

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
  Start cell_start, node_start;
  std::vector<Place> cell;
  std::vector<int> node;

  Adjacency(const Mesh& mesh, const std::vector<CellGroup>& groups) : cell_start(at(mesh.node_count() + 1)) {
    for_each_corner(groups, [&](Place, int n) { ++cell_start[at(n) + 1]; });
    std::partial_sum(cell_start.begin(), cell_start.end(), cell_start.begin());
    cell.resize(cell_start.back());
    Start next = cell_start;
    for_each_corner(groups, [&](Place place, int n) { cell[next[at(n)]++] = place; });

    std::vector<int> seen(at(mesh.node_count()), -1);
    node_start.push_back(0);
    for (int n = 0; n < mesh.node_count(); ++n) {
      for (std::size_t k = cell_start[at(n)]; k < cell_start[at(n) + 1]; ++k) {
        const CellGroup& group = groups[at(cell[k].group)];
        for (int a = 0; a < node_count(group.shape); ++a) {
          const int other = nodes_of(group, cell[k].cell)[a * lanes];
          if (std::exchange(seen[at(other)], n) != n) node.push_back(other);
        }
      }
      std::sort(node.begin() + static_cast<std::ptrdiff_t>(node_start.back()), node.end(),
                [&](int i, int j) { return mesh.global_node()[at(i)] < mesh.global_node()[at(j)]; });
      node_start.push_back(node.size());
    }
  }

  std::span<const int> nodes(int n) const {
    return {node.data() + node_start[at(n)], node.data() + node_start[at(n) + 1]};
  }
  std::span<const Place> cells(int n) const {
    return {cell.data() + cell_start[at(n)], cell.data() + cell_start[at(n) + 1]};
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
    : comm_(mesh.comm()) {
  int ranks = 1, rank = 0;
  MPI_Comm_size(comm_, &ranks);
  MPI_Comm_rank(comm_, &rank);
  const PetscInt mine = mesh.owned_node_count();
  rank_end_.resize(at(ranks));
  MPI_Allgather(&mine, 1, MPIU_INT, rank_end_.data(), 1, MPIU_INT, comm_);
  std::partial_sum(rank_end_.begin(), rank_end_.end(), rank_end_.begin());
  first_node_ = rank_end_[at(rank)] - mine;

  const Adjacency near(mesh, groups);
  lay_ghost_rows(mesh, near);

  // Rows of ours that other ranks' cells reach: [row, column count, columns...].
  std::vector<std::vector<PetscInt>> out(at(ranks)), out_extra(at(ranks));
  for (const Neighbour& to : send_)
    for (int g = to.first_row; g < to.end_row; ++g) {
      auto& message = out[at(to.rank)];
      message.push_back(ghost_node_[at(g)]);
      message.push_back(static_cast<PetscInt>(ghost_columns(g).size()));
      message.insert(message.end(), ghost_columns(g).begin(), ghost_columns(g).end());
    }
  for (const auto& [i, j] : extra) {
    out_extra[at(owner(i))].insert(out_extra[at(owner(i))].end(), {i, j});
    out_extra[at(owner(j))].insert(out_extra[at(owner(j))].end(), {j, i});
  }
  const auto in = all_to_all(comm_, out), in_extra = all_to_all(comm_, out_extra);

  std::vector<std::pair<int, PetscInt>> more;
  for (const auto& message : in)
    for (std::size_t k = 0; k < message.size(); k += 2 + static_cast<std::size_t>(message[k + 1]))
      for (std::size_t c = 0; c < static_cast<std::size_t>(message[k + 1]); ++c)
        more.emplace_back(static_cast<int>(message[k] - first_node_), message[k + 2 + c]);
  for (const auto& message : in_extra)
    for (std::size_t k = 0; k < message.size(); k += 2)
      more.emplace_back(static_cast<int>(message[k] - first_node_), message[k + 1]);
  lay_own_rows(mesh, near, more);
  find_slots(mesh, groups, near);

  received_start_.push_back(0);
  for (int r = 0; r < ranks; ++r) {
    const auto& message = in[at(r)];
    const int first = static_cast<int>(received_row_.size());
    for (std::size_t k = 0; k < message.size(); k += 2 + static_cast<std::size_t>(message[k + 1])) {
      const int row = received_row_.emplace_back(static_cast<int>(message[k] - first_node_));
      for (std::size_t c = 0; c < static_cast<std::size_t>(message[k + 1]); ++c)
        received_slot_.push_back(slot(row, message[k + 2 + c]));
      received_start_.push_back(received_slot_.size());
    }
    if (!message.empty()) receive_.push_back({r, first, static_cast<int>(received_row_.size())});
  }
}

int NodeGraph::owner(PetscInt global_node) const {
  if (global_node < 0 || global_node >= rank_end_.back())
    throw std::out_of_range("extra pair with global node " + std::to_string(global_node));
  return static_cast<int>(std::upper_bound(rank_end_.begin(), rank_end_.end(), global_node) -
                          rank_end_.begin());
}

// Owners follow each other in global numbers, so sorting ghosts by global number also sorts them by owner.
void NodeGraph::lay_ghost_rows(const Mesh& mesh, const Adjacency& near) {
  const auto global = mesh.global_node();
  row_of_node_.resize(at(mesh.node_count()));
  std::vector<int> ghosts;
  for (int n = 0; n < mesh.node_count(); ++n) {
    row_of_node_[at(n)] = static_cast<int>(global[at(n)] - first_node_);
    if (!mesh.owned(n)) ghosts.push_back(n);
  }
  std::sort(ghosts.begin(), ghosts.end(), [&](int i, int j) { return global[at(i)] < global[at(j)]; });
  ghost_start_.push_back(0);
  for (int g = 0; g < static_cast<int>(ghosts.size()); ++g) {
    const int n = ghosts[at(g)], to = owner(global[at(n)]);
    row_of_node_[at(n)] = -1 - g;
    ghost_node_.push_back(global[at(n)]);
    for (const int other : near.nodes(n)) ghost_column_.push_back(global[at(other)]);
    ghost_start_.push_back(ghost_column_.size());
    if (send_.empty() || send_.back().rank != to) send_.push_back({to, g, g});
    send_.back().end_row = g + 1;
  }
}

void NodeGraph::lay_own_rows(const Mesh& mesh, const Adjacency& near,
                             std::vector<std::pair<int, PetscInt>>& more) {
  const PetscInt end_node = first_node_ + mesh.owned_node_count();
  std::sort(more.begin(), more.end());
  auto next = more.begin();
  row_start_.push_back(0);
  std::vector<PetscInt> row;
  for (int n = 0; n < mesh.node_count(); ++n) { // owned nodes come in the order of their rows
    if (!mesh.owned(n)) continue;
    const int r = row_of_node_[at(n)];
    row.assign(1, mesh.global_node()[at(n)]);
    for (const int other : near.nodes(n)) row.push_back(mesh.global_node()[at(other)]);
    for (; next != more.end() && next->first == r; ++next) row.push_back(next->second);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    if (row.size() > std::numeric_limits<std::uint16_t>::max())
      throw std::length_error("a matrix row is too long");
    const auto own = std::stable_partition(row.begin(), row.end(),
                                           [&](PetscInt c) { return c >= first_node_ && c < end_node; });
    own_in_row_.push_back(static_cast<int>(own - row.begin()));
    column_.insert(column_.end(), row.begin(), row.end());
    row_start_.push_back(column_.size());
  }
}

std::uint16_t NodeGraph::slot(int row, PetscInt global_node) const {
  const auto all = columns(row);
  const auto middle = all.begin() + own_columns(row);
  const bool own = global_node >= first_node_ && global_node < first_node_ + row_count();
  const auto found = own ? std::lower_bound(all.begin(), middle, global_node)
                         : std::lower_bound(middle, all.end(), global_node);
  return static_cast<std::uint16_t>(found - all.begin());
}

void NodeGraph::find_slots(const Mesh& mesh, const std::vector<CellGroup>& groups, const Adjacency& near) {
  for (const CellGroup& g : groups)
    slots_.emplace_back(at(g.cell_count) * at(node_count(g.shape)) * at(node_count(g.shape)));
  std::vector<std::uint16_t> slot_of_node(at(mesh.node_count()));
  for (int n = 0; n < mesh.node_count(); ++n) {
    const auto others = near.nodes(n);
    const int row = row_of_node_[at(n)];
    for (std::size_t k = 0; k < others.size(); ++k)
      slot_of_node[at(others[k])] =
          row >= 0 ? slot(row, mesh.global_node()[at(others[k])]) : static_cast<std::uint16_t>(k);
    for (const auto& place : near.cells(n)) {
      const CellGroup& group = groups[at(place.group)];
      const int nodes = node_count(group.shape);
      std::uint16_t* out = &slots_[at(place.group)][at(place.cell * nodes + place.corner) * at(nodes)];
      for (int b = 0; b < nodes; ++b) out[b] = slot_of_node[at(nodes_of(group, place.cell)[b * lanes])];
    }
  }
}

} // namespace impact
