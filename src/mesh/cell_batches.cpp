#include <algorithm>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/cell_batches.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

std::string place_without_material(const Mesh& mesh, const CellTable& table, std::size_t cell) {
  const int first = table.connectivity[cell * static_cast<std::size_t>(node_count(table.shape))];
  return "mesh: cell near " + mesh.place(first) + " of " + mesh.regions_of(table.point[cell]) +
         " has no material; give its region one";
}

void pack(const CellTable& table, const std::vector<std::size_t>& cells, CellGroup& group) {
  const int nodes = node_count(group.shape);
  group.cell_count = static_cast<int>(cells.size());
  group.batch_count = (group.cell_count + lanes - 1) / lanes;
  group.node.reserve(static_cast<std::size_t>(group.batch_count * nodes * lanes));
  for (int b = 0; b < group.batch_count; ++b) {
    const auto cell = [&](int lane) {
      return cells[static_cast<std::size_t>(std::min(b * lanes + lane, group.cell_count - 1))];
    };
    for (int a = 0; a < nodes; ++a)
      for (int l = 0; l < lanes; ++l)
        group.node.push_back(
            table.connectivity[cell(l) * static_cast<std::size_t>(nodes) + static_cast<std::size_t>(a)]);
    for (int l = 0; l < lanes; ++l) group.cell_point.push_back(table.point[cell(l)]);
  }
}

} // namespace

int CellGroup::lanes_in_use(int batch) const { return std::min(lanes, cell_count - batch * lanes); }

std::vector<CellGroup> pack_cells(const Mesh& mesh, const std::vector<int>& law_of_cell) {
  int laws = 0;
  for (const int law : law_of_cell) laws = std::max(laws, law + 1);
  laws = max_over_ranks(mesh.comm(), laws);
  const auto shapes = static_cast<int>(known_shapes().size());
  // [law][shape][cell of the table of that shape]
  std::vector<std::vector<std::size_t>> members(static_cast<std::size_t>(laws * shapes));
  std::vector<const CellTable*> table_of_shape(known_shapes().size());
  std::string trouble;
  for (const CellTable& table : mesh.cells()) {
    const int shape = index_of(table.shape);
    table_of_shape[static_cast<std::size_t>(shape)] = &table;
    for (std::size_t c = 0; c < table.point.size() && trouble.empty(); ++c) {
      const int law = law_of_cell[static_cast<std::size_t>(table.point[c] - mesh.cell_start())];
      if (law < 0)
        trouble = place_without_material(mesh, table, c);
      else
        members[static_cast<std::size_t>(law * shapes + shape)].push_back(c);
    }
  }
  throw_first(mesh.comm(), ExitCode::data, trouble);

  std::vector<int> used;
  for (const auto& cells : members) used.push_back(!cells.empty());
  max_over_ranks(mesh.comm(), used);
  std::vector<CellGroup> groups;
  for (std::size_t k = 0; k < members.size(); ++k) {
    if (used[k] == 0) continue;
    CellGroup& group = groups.emplace_back();
    group.shape = known_shapes()[k % known_shapes().size()];
    group.law = group.material = static_cast<int>(k) / shapes;
    if (!members[k].empty()) pack(*table_of_shape[k % known_shapes().size()], members[k], group);
  }
  return groups;
}

} // namespace impact
