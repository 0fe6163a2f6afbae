#include "entities.hpp"
#include <algorithm>
#include <bit>
#include <impact/io/checksum.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/exchange.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/error.hpp>

namespace impact {

namespace {

std::uint64_t combined(std::uint64_t seed, std::uint64_t value) {
  return mixed(seed + 0x9e3779b97f4a7c15ULL + mixed(value));
}

// 40 bits in each number: some thousand of them can be added in doubles without rounding.
void add_key(std::uint64_t identity, double* key) {
  key[0] += static_cast<double>(combined(identity, 0) >> 24);
  key[1] += static_cast<double>(combined(identity, 1) >> 24);
}

/// Gives each cell of the rank a number made of the coordinates of its nodes and the names of its regions.
std::vector<std::uint64_t> cell_identities(const Mesh& mesh) {
  std::vector<std::uint64_t> identity(at(mesh.cell_count()), 0);
  const auto of = [&](PetscInt point) -> std::uint64_t& { return identity[at(point - mesh.cell_start())]; };
  for (const Group& group : mesh.groups()) {
    if (group.dim != mesh.dim()) continue;
    const std::uint64_t name = mixed(checksum(group.name));
    for (const PetscInt point : mesh.region_cells(group.name)) of(point) += name;
  }
  const std::size_t dim = at(mesh.dim());
  for (const CellTable& table : mesh.cells()) {
    const std::size_t nodes = at(node_count(table.shape));
    for (std::size_t k = 0; k < table.connectivity.size(); ++k)
      for (std::size_t i = 0; i < dim; ++i) {
        const double x = mesh.coordinates()[at(table.connectivity[k]) * dim + i];
        std::uint64_t& cell = of(table.point[k / nodes]);
        cell = combined(cell, std::bit_cast<std::uint64_t>(x + 0.0)); // one zero, whatever its sign
      }
  }
  return identity;
}

/// [node][2], ghosts included. The cells around a node tell it from another body's at the same place.
std::vector<double> node_keys(const Mesh& mesh, const std::vector<std::uint64_t>& identity) {
  const FieldLayout layout(mesh, "keys", 2);
  std::vector<double> keys = layout.make_local();
  for (const CellTable& table : mesh.cells()) {
    const std::size_t nodes = at(node_count(table.shape));
    for (std::size_t k = 0; k < table.connectivity.size(); ++k)
      add_key(combined(identity[at(table.point[k / nodes] - mesh.cell_start())], k % nodes),
              &keys[2 * at(table.connectivity[k])]);
  }
  const Handle<Vec> sum = layout.make_global();
  layout.add_to_global(keys, sum);
  layout.to_local(sum, keys);
  return keys;
}

/// The place of each local node among the vertices of the rank: owned ones first, in the global order.
std::vector<std::size_t> vertex_order(const Mesh& mesh) {
  std::vector<std::size_t> place(at(mesh.node_count()));
  std::size_t owned = 0, ghost = at(mesh.owned_node_count());
  for (int n = 0; n < mesh.node_count(); ++n) place[at(n)] = mesh.owned(n) ? owned++ : ghost++;
  return place;
}

} // namespace

std::string entities_name(const StateRow& row) {
  switch (row.support) {
  case Support::vertex:
    return "vertex";
  case Support::cell_point:
    return "cell";
  case Support::facet_point:
    return "facet_" + row.surface;
  default:
    return "global";
  }
}

std::vector<Entities> entities_of(const Mesh& mesh, const StateTable& table) {
  const MPI_Comm comm = mesh.comm();
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const std::vector<std::uint64_t> cells = cell_identities(mesh);
  const std::vector<double> nodes = node_keys(mesh, cells);
  const std::vector<std::size_t> place = vertex_order(mesh);

  std::vector<double> vertex_keys(nodes.size()), cell_keys(2 * cells.size(), 0.0);
  for (std::size_t n = 0; n < place.size(); ++n) std::copy_n(&nodes[2 * n], 2, &vertex_keys[2 * place[n]]);
  for (std::size_t c = 0; c < cells.size(); ++c) add_key(cells[c], &cell_keys[2 * c]);
  std::vector<Entities> sets;
  const std::size_t owned = at(mesh.owned_node_count());
  sets.push_back({"vertex", {comm, owned}, std::move(vertex_keys)});
  sets.push_back({"cell", {comm, cells.size()}, std::move(cell_keys)});
  sets.push_back({"global", {comm, rank == 0 ? 1U : 0U}, {1, 1}});
  for (const auto& row : table.rows()) {
    const std::string name = entities_name(*row);
    if (!row->checkpointed || row->support != Support::facet_point ||
        std::ranges::any_of(sets, [&](const Entities& set) { return set.name == name; }))
      continue;
    const FacetTable facets = mesh.facets(row->surface);
    const std::size_t corners = at(facets.nodes_per_facet);
    std::vector<double> keys(2 * facets.point.size(), 0.0);
    for (std::size_t k = 0; k < facets.connectivity.size(); ++k) {
      const double* node = &nodes[2 * at(facets.connectivity[k])];
      add_key(combined(static_cast<std::uint64_t>(node[0]), static_cast<std::uint64_t>(node[1])),
              &keys[2 * (k / corners)]);
    }
    sets.push_back({name, {comm, facets.point.size()}, std::move(keys)});
  }
  return sets;
}

std::size_t for_each_place(const Mesh& mesh, const std::vector<CellGroup>& groups, const StateRow& row,
                           bool all, const std::function<void(const RowPlace&)>& use) {
  const std::size_t components = at(row.components);
  std::size_t begin = 0;
  if (row.support == Support::vertex) {
    const std::vector<std::size_t> place = vertex_order(mesh);
    for (std::size_t n = 0; n < place.size(); ++n, begin += components)
      if (all || mesh.owned(static_cast<int>(n))) use({place[n], begin, components, 1});
  } else if (row.support == Support::cell_point) {
    for (const CellGroup& group : groups) {
      const std::size_t count = at(point_count(group.shape)) * components;
      for (int b = 0; b < group.batch_count; ++b, begin += count * lanes)
        for (int l = 0; l < (all ? lanes : group.lanes_in_use(b)); ++l) {
          const PetscInt point = group.cell_point[at(b * lanes + l)];
          use({at(point - mesh.cell_start()), begin + at(l), count, lanes});
        }
    }
  } else if (row.support == Support::facet_point) {
    const std::size_t facets = at(mesh.facets(row.surface).count());
    const std::size_t width = facets > 0 ? row.committed.size() / facets : 0;
    for (std::size_t f = 0; f < facets; ++f, begin += width) use({f, begin, width, 1});
  } else {
    int rank = 0;
    MPI_Comm_rank(mesh.comm(), &rank);
    if (all || rank == 0) use({0, 0, components, 1});
    begin = components;
  }
  return begin;
}

std::size_t row_width(const Mesh& mesh, const std::vector<CellGroup>& groups, const StateRow& row) {
  std::uint64_t width = 0;
  const std::size_t size = for_each_place(mesh, groups, row, true, [&](const RowPlace& place) {
    width = std::max<std::uint64_t>(width, place.count);
  });
  MPI_Allreduce(MPI_IN_PLACE, &width, 1, MPI_UINT64_T, MPI_MAX, mesh.comm());
  if (!all_ranks_agree(mesh.comm(), size == row.committed.size()))
    throw std::logic_error("state row " + row.name + " does not have the size of its mesh");
  return width;
}

std::vector<PetscInt> find_keys(MPI_Comm comm, const std::vector<double>& known, PetscInt first,
                                const std::vector<double>& wanted) {
  struct Key {
    double key[2];
    PetscInt place;
    auto operator<=>(const Key&) const = default;
  };
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  using Messages = std::vector<std::vector<Key>>;
  const auto home = [&](double key) {
    return static_cast<std::uint64_t>(key) % static_cast<unsigned>(ranks);
  };
  const auto sent = [&](const std::vector<double>& keys, PetscInt begin) {
    Messages out(at(ranks));
    for (std::size_t k = 0; 2 * k < keys.size(); ++k)
      out[home(keys[2 * k])].push_back({{keys[2 * k], keys[2 * k + 1]}, begin + static_cast<PetscInt>(k)});
    return all_to_all(comm, out);
  };
  std::vector<Key> met;
  for (const auto& message : sent(known, first)) met.insert(met.end(), message.begin(), message.end());
  std::ranges::sort(met);
  Messages asked = sent(wanted, 0);
  std::vector<std::vector<PetscInt>> answers(at(ranks));
  const auto before = [](const Key& a, const Key& b) {
    return std::pair(a.key[0], a.key[1]) < std::pair(b.key[0], b.key[1]);
  };
  for (std::size_t r = 0; r < asked.size(); ++r)
    for (const Key& key : asked[r]) {
      const auto same = std::ranges::equal_range(met, key, before);
      answers[r].insert(answers[r].end(), {key.place, same.size() == 1 ? same.front().place : -1});
    }
  std::vector<PetscInt> places(wanted.size() / 2, -1);
  for (const auto& answer : all_to_all(comm, answers))
    for (std::size_t k = 0; k < answer.size(); k += 2) places[at(answer[k])] = answer[k + 1];
  return places;
}

} // namespace impact
