#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/gmsh.hpp>
#include <impact/petsc/ranks.hpp>
#include <numeric>
#include <sstream>

// A mesh file in parts on all ranks: rows that a file holds, and the way there from rank 0.
namespace impact {

namespace {

template <class Body> void for_each_element(const GmshFile& file, bool of_cells, Body&& body) {
  for (const GmshBlock& block : file.blocks)
    for (std::size_t k = 0; (block.dim == file.dim) == of_cells && k < block.node.size();
         k += at(block.nodes))
      body(block, &block.node[k]);
}

/// Finds the cell behind an element of a boundary: of a part, among the cells around the element's first
/// node.
class CellsBehind {
public:
  explicit CellsBehind(const GmshFile& file) {
    std::vector<int> anchors;
    for_each_element(file, false, [&](const GmshBlock& block, const int* node) {
      if (!file.sets[at(block.set)].empty()) anchors.push_back(*node);
    });
    std::sort(anchors.begin(), anchors.end());
    std::int64_t cell = 0;
    for_each_element(file, true, [&](const GmshBlock& block, const int* node) {
      for (int a = 0; a < block.nodes; ++a)
        if (std::binary_search(anchors.begin(), anchors.end(), node[a]))
          around_.push_back({node[a], cell, {node, at(block.nodes)}});
      ++cell;
    });
    std::ranges::stable_sort(around_, {}, &Around::node);
  }
  /// The first cell that has all nodes of the element; -1: none.
  std::int64_t find(std::span<const int> element) const {
    for (const Around& around : std::ranges::equal_range(around_, element[0], {}, &Around::node))
      if (std::ranges::all_of(element, [&](int n) { return std::ranges::count(around.nodes, n) > 0; }))
        return around.cell;
    return -1;
  }

private:
  struct Around {
    int node;
    std::int64_t cell;
    std::span<const int> nodes;
  };
  std::vector<Around> around_;
};

void append_row(std::vector<std::int64_t>& rows, std::size_t width, const GmshBlock& block, const int* node) {
  rows.push_back(block.set);
  rows.insert(rows.end(), node, node + block.nodes);
  rows.insert(rows.end(), width - 1 - at(block.nodes), -1);
}

// Consecutive rows of one kind become a block.
void append_element(GmshFile& file, int dim, const std::int64_t* row, std::size_t width,
                    std::int64_t node_count) {
  const std::int64_t* const begin = row + 1;
  const std::int64_t* const end = std::find(begin, row + width, std::int64_t{-1});
  const auto wrong = [&](std::int64_t n) { return n < 0 || n >= node_count; };
  if (begin == end || *row < 0 || *row >= static_cast<std::int64_t>(file.sets.size()) ||
      std::any_of(begin, end, wrong))
    throw UserError(ExitCode::data, "an element has nodes or groups that are not there");
  const int nodes = static_cast<int>(end - begin), set = static_cast<int>(*row);
  if (dim < 0) dim = nodes < 3 ? nodes - 1 : 2; // of a boundary
  GmshBlock* last = file.blocks.empty() ? nullptr : &file.blocks.back();
  if (!last || last->nodes != nodes || last->dim != dim || last->set != set)
    last = &file.blocks.emplace_back(GmshBlock{dim, nodes, set, {}});
  if (dim == file.dim) last->shape(); // throws where there is none
  for (const std::int64_t* n = begin; n < end; ++n) last->node.push_back(static_cast<int>(*n));
}

// From rank 0 to each rank what stands between two of `cut`, in units of `width` numbers.
template <class Value>
std::vector<Value> scatter(MPI_Comm comm, const std::vector<Value>& all, std::vector<std::int64_t> cut,
                           std::size_t width, MPI_Datatype number) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  MPI_Bcast(cut.data(), static_cast<int>(cut.size()), MPI_INT64_T, 0, comm);
  std::vector<int> count(cut.size() - 1), begin(cut.begin(), cut.end() - 1);
  for (std::size_t r = 0; r < count.size(); ++r) count[r] = static_cast<int>(cut[r + 1] - cut[r]);
  std::vector<Value> mine(width * at(count[at(rank)]));
  MPI_Datatype row = MPI_DATATYPE_NULL; // its counts fit into an int where those of numbers do not
  MPI_Type_contiguous(static_cast<int>(width), number, &row);
  MPI_Type_commit(&row);
  MPI_Scatterv(all.data(), count.data(), begin.data(), row, mine.data(), count[at(rank)], row, 0, comm);
  MPI_Type_free(&row);
  return mine;
}

std::vector<std::int64_t> equal_cuts(std::size_t all, int ranks) {
  std::vector<std::int64_t> cut;
  for (int r = 0; r <= ranks; ++r) cut.push_back(part_begin(static_cast<std::int64_t>(all), r, ranks));
  return cut;
}

} // namespace

ElementRows rows_of(MPI_Comm comm, const GmshFile& file) {
  long width = 0, cells = 0, first = 0;
  for_each_element(file, true, [&](const GmshBlock& block, const int*) {
    width = std::max<long>(width, 1 + block.nodes);
    ++cells;
  });
  MPI_Scan(&cells, &first, 1, MPI_LONG, MPI_SUM, comm);
  first -= cells;
  ElementRows rows{at(max_over_ranks(comm, width)), {}, {}};
  rows.cells.reserve(rows.width * at(cells));
  for_each_element(file, true, [&](const GmshBlock& block, const int* node) {
    append_row(rows.cells, rows.width, block, node);
  });
  std::string trouble;
  const CellsBehind behind(file);
  std::vector<std::pair<std::int64_t, std::vector<std::int64_t>>> sorted;
  for_each_element(file, false, [&](const GmshBlock& block, const int* node) {
    const std::vector<int>& groups = file.sets[at(block.set)];
    if (groups.empty()) return;
    const std::int64_t cell = behind.find({node, at(block.nodes)});
    if (cell < 0)
      trouble = "mesh: an element of group \"" + file.groups[at(groups[0])].name +
                "\" is no facet or edge of a cell; all cells must have the same dimension";
    sorted.push_back({first + cell, {}});
    append_row(sorted.back().second, rows.width, block, node);
  });
  throw_first(comm, ExitCode::data, trouble);
  std::ranges::stable_sort(sorted, {}, [](const auto& element) { return element.first; });
  for (const auto& [cell, row] : sorted) {
    rows.boundary.push_back(cell);
    rows.boundary.insert(rows.boundary.end(), row.begin(), row.end());
  }
  return rows;
}

void set_rows(GmshFile& file, const ElementRows& rows, std::int64_t node_count) {
  file.blocks.clear();
  for (std::size_t k = 0; k < rows.cells.size(); k += rows.width)
    append_element(file, file.dim, &rows.cells[k], rows.width, node_count);
  for (std::size_t k = 0; k < rows.boundary.size(); k += 1 + rows.width)
    append_element(file, -1, &rows.boundary[k + 1], rows.width, node_count);
}

std::string head_of(const GmshFile& file) {
  std::ostringstream text;
  text << file.dim << '\n' << file.groups.size() << '\n';
  for (const GmshGroup& group : file.groups)
    text << group.dim << ' ' << group.tag << ' ' << group.name << '\n';
  for (const std::vector<int>& set : file.sets) {
    text << set.size();
    for (const int group : set) text << ' ' << group;
    text << '\n';
  }
  return text.str();
}

void set_head(GmshFile& file, const std::string& head) {
  std::istringstream text(head);
  std::size_t groups = 0, size = 0;
  text >> file.dim >> groups;
  if (file.dim != 2 && file.dim != 3) throw UserError(ExitCode::data, "no dimension of the cells");
  file.groups.clear();
  file.sets.clear();
  for (GmshGroup group; file.groups.size() < groups && text >> group.dim >> group.tag;) {
    text.get(); // the blank before the name
    std::getline(text, group.name);
    file.groups.push_back(group);
  }
  if (groups == 0 || file.groups.size() != groups) throw UserError(ExitCode::data, "no list of groups");
  while (text >> size) {
    std::vector<int>& set = file.sets.emplace_back();
    for (int group = 0; set.size() < size && text >> group;) set.push_back(group);
    const auto wrong = [&](int g) { return g < 0 || at(g) >= groups; };
    if (set.size() != size || std::ranges::any_of(set, wrong))
      throw UserError(ExitCode::data, "no list of the sets of groups");
  }
}

void spread(MPI_Comm comm, GmshFile& file) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return;
  set_head(file, broadcast(comm, head_of(file)));
  ElementRows rows = rows_of(comm, file);
  file.blocks.clear();
  const std::size_t width = rows.width, wide = width + 1;
  const std::vector<std::int64_t> cells = equal_cuts(rows.cells.size() / width, ranks),
                                  nodes = equal_cuts(file.x.size() / 3, ranks);
  std::vector<std::int64_t> boundary; // with their cells
  for (std::size_t r = 0, k = 0; r < cells.size(); ++r) {
    while (k < rows.boundary.size() && rows.boundary[k] < cells[r]) k += wide;
    boundary.push_back(static_cast<std::int64_t>(k / wide));
  }
  std::int64_t node_count = nodes.back();
  MPI_Bcast(&node_count, 1, MPI_INT64_T, 0, comm);
  file.x = scatter(comm, file.x, nodes, 3, MPI_DOUBLE);
  rows.cells = scatter(comm, rows.cells, cells, width, MPI_INT64_T);
  rows.boundary = scatter(comm, rows.boundary, boundary, wide, MPI_INT64_T);
  set_rows(file, rows, node_count);
}

} // namespace impact
