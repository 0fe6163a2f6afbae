#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/mesh/cell_patches.hpp>
#include <impact/mesh/exchange.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/error.hpp>
#include <numeric>
#include <set>
#include <span>
#include <tuple>

namespace impact {

namespace {

// Cells of a patch: few enough that flow does not localise early, as many as it takes not to lock (theory.md,
// volumetric locking).
int cells_of_patch(int dim) { return dim == 2 ? 2 : 8; }

constexpr int absent = -1;

/// Grows one patch after the other.
class Patching {
public:
  Patching(int dim, const std::vector<PatchCell>& cells) : corners_(dim + 1), cells_(cells) {
    find_neighbours();
    patch_.assign(cells.size(), absent);
    age_.assign(cells.size(), static_cast<int>(cells.size()));
    free_.assign(cells.size(), 0);
    for (int c = 0; c < count(); ++c)
      for (const int other : neighbours(c)) free_[at(c)] += other != absent ? 1 : 0;
    for (int c = 0; c < count(); ++c) queue_.insert(key(c));
  }

  std::vector<PetscInt> make(int size) {
    while (!queue_.empty()) grow(std::get<2>(*queue_.begin()), size);
    join_small(size);
    return {patch_.begin(), patch_.end()};
  }

private:
  using Key = std::tuple<int, int, int>;
  int count() const { return static_cast<int>(cells_.size()); }
  Key key(int cell) const { return {free_[at(cell)], age_[at(cell)], cell}; }
  std::span<const int> neighbours(int cell) const { return {&neighbour_[at(cell * corners_)], at(corners_)}; }
  std::span<const PetscInt> nodes(int cell) const { return {cells_[at(cell)].corner.data(), at(corners_)}; }

  void find_neighbours() {
    struct Side {
      std::array<PetscInt, 3> node;
      int cell, side;
      auto key() const { return std::tie(node, cell); }
    };
    std::vector<Side> sides;
    sides.reserve(cells_.size() * at(corners_));
    for (int c = 0; c < count(); ++c)
      for (int k = 0; k < corners_; ++k) {
        Side side{{-1, -1, -1}, c, k};
        auto next = side.node.begin();
        for (int a = 0; a < corners_; ++a)
          if (a != k) *next++ = cells_[at(c)].corner[at(a)];
        std::ranges::sort(side.node);
        sides.push_back(side);
      }
    std::ranges::sort(sides, {}, &Side::key);
    neighbour_.assign(sides.size(), absent);
    for (std::size_t i = 1; i < sides.size(); ++i) {
      const Side &a = sides[i - 1], &b = sides[i];
      if (a.node != b.node || cells_[at(a.cell)].material != cells_[at(b.cell)].material) continue;
      neighbour_[at(a.cell * corners_ + a.side)] = b.cell;
      neighbour_[at(b.cell * corners_ + b.side)] = a.cell;
    }
  }

  void take(int cell) {
    queue_.erase(key(cell));
    patch_[at(cell)] = static_cast<int>(members_.size()) - 1;
    members_.back().push_back(cell);
    for (const int other : neighbours(cell)) {
      if (other == absent || patch_[at(other)] != absent) continue;
      queue_.erase(key(other));
      --free_[at(other)];
      age_[at(other)] = std::min(age_[at(other)], patch_[at(cell)]);
      queue_.insert(key(other));
    }
  }

  // New nodes, free cells beside it, minus shared facets, cell: what is least is taken first.
  std::array<int, 4> cost(int cell, const std::set<PetscInt>& of_patch) const {
    int fresh = 0, shared = 0;
    for (const PetscInt node : nodes(cell)) fresh += of_patch.contains(node) ? 0 : 1;
    for (const int other : neighbours(cell))
      shared += other != absent && patch_[at(other)] + 1 == static_cast<int>(members_.size()) ? 1 : 0;
    return {fresh, -shared, free_[at(cell)], cell};
  }

  void grow(int seed, int size) {
    members_.emplace_back();
    std::set<PetscInt> of_patch(nodes(seed).begin(), nodes(seed).end());
    take(seed);
    for (int k = 1; k < size; ++k) {
      std::array<int, 4> best{corners_, 0, 0, absent};
      for (const int cell : members_.back())
        for (const int other : neighbours(cell))
          if (other != absent && patch_[at(other)] == absent) best = std::min(best, cost(other, of_patch));
      if (best[3] == absent) return;
      of_patch.insert(nodes(best[3]).begin(), nodes(best[3]).end());
      take(best[3]);
    }
  }

  // A patch of less than half the size joins the smallest one beside it.
  void join_small(int size) {
    for (std::size_t p = 0; p < members_.size(); ++p) {
      if (members_[p].empty() || 2 * members_[p].size() > at(size)) continue;
      std::pair<std::size_t, int> best{members_.size() * at(size) + cells_.size(), absent};
      for (const int cell : members_[p])
        for (const int other : neighbours(cell)) {
          const int q = other == absent ? absent : patch_[at(other)];
          if (q != absent && at(q) != p) best = std::min(best, {members_[at(q)].size(), q});
        }
      if (best.second == absent) continue;
      for (const int cell : std::exchange(members_[p], {})) {
        members_[at(best.second)].push_back(cell);
        patch_[at(cell)] = best.second;
      }
    }
  }

  const int corners_;
  const std::vector<PatchCell>& cells_;
  std::vector<int> neighbour_;            // [cell][side opposite to a corner]
  std::vector<int> patch_, free_, age_;   // [cell]; free neighbours; the first patch beside it
  std::set<Key> queue_;                   // cells without a patch
  std::vector<std::vector<int>> members_; // [patch]
};

/// A cell as ranks send it: sorted by place.
struct PlacedCell {
  std::array<double, 3> centre;
  PatchCell cell;
  PetscInt number; // on its rank
  int rank;
  auto key() const { return std::tie(centre, cell.material); }
};

// Corners by rising place, so that their sum is the same whatever their order.
std::array<double, 3> centre_of(int dim, std::vector<std::array<double, 3>> corner) {
  std::array<double, 3> sum{};
  std::ranges::sort(corner);
  for (const auto& x : corner)
    for (std::size_t i = 0; i < at(dim); ++i) sum[i] += x[i];
  return sum;
}

// Those cells of this rank whose material is not -1.
std::vector<PlacedCell> placed_cells(DM dm, int dim, const std::vector<int>& material, PetscInt first) {
  Vec values = nullptr;
  IS numbers = nullptr;
  PetscSection section = nullptr;
  const PetscScalar* x = nullptr;
  const PetscInt* number = nullptr;
  PetscInt vertex = 0, end_vertex = 0;
  check(DMGetCoordinatesLocal(dm, &values));
  check(DMGetCoordinateSection(dm, &section));
  check(DMPlexGetVertexNumbering(dm, &numbers)); // the DM keeps it
  check(DMPlexGetDepthStratum(dm, 0, &vertex, &end_vertex));
  check(VecGetArrayRead(values, &x));
  check(ISGetIndices(numbers, &number));
  int rank = 0;
  MPI_Comm_rank(PetscObjectComm(reinterpret_cast<PetscObject>(dm)), &rank);
  std::vector<PlacedCell> placed;
  for (std::size_t c = 0; c < material.size(); ++c) {
    if (material[c] < 0) continue;
    PlacedCell& mine = placed.emplace_back();
    mine.number = static_cast<PetscInt>(c);
    mine.rank = rank;
    mine.cell = {material[c], {-1, -1, -1, -1}};
    PetscInt size = 0, *closure = nullptr;
    check(DMPlexGetTransitiveClosure(dm, first + static_cast<PetscInt>(c), PETSC_TRUE, &size, &closure));
    std::vector<std::array<double, 3>> corners;
    for (PetscInt k = 0; k < 2 * size; k += 2) {
      if (closure[k] < vertex || closure[k] >= end_vertex) continue;
      PetscInt offset = 0;
      const PetscInt global = number[closure[k] - vertex];
      check(PetscSectionGetOffset(section, closure[k], &offset));
      mine.cell.corner[corners.size()] = global < 0 ? -1 - global : global;
      corners.emplace_back();
      std::copy_n(x + offset, dim, corners.back().begin());
    }
    check(DMPlexRestoreTransitiveClosure(dm, first + static_cast<PetscInt>(c), PETSC_TRUE, &size, &closure));
    mine.centre = centre_of(dim, std::move(corners));
  }
  check(ISRestoreIndices(numbers, &number));
  check(VecRestoreArrayRead(values, &x));
  return placed;
}

} // namespace

std::vector<PetscInt> make_patches(int dim, const std::vector<PatchCell>& cells) {
  return Patching(dim, cells).make(cells_of_patch(dim));
}

std::vector<PetscInt> find_patches(DM dm, const std::vector<std::vector<std::string>>& materials) {
  const MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(dm));
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  PetscInt dim = 0, first = 0, end = 0;
  check(DMGetDimension(dm, &dim));
  check(DMPlexGetHeightStratum(dm, 0, &first, &end));
  std::vector<int> material(at(end - first), absent);
  for (std::size_t m = 0; m < materials.size(); ++m)
    for (const std::string& region : materials[m])
      for (const PetscInt cell : labelled_points(dm, region, dim)) {
        if (cell < first || cell >= end) continue; // refinement labels what lies inside of a cell, too
        DMPolytopeType type = DM_POLYTOPE_UNKNOWN;
        check(DMPlexGetCellType(dm, cell, &type));
        if (type == DM_POLYTOPE_TRIANGLE || type == DM_POLYTOPE_TETRAHEDRON)
          material[at(cell - first)] = static_cast<int>(m);
      }
  std::vector<std::vector<PlacedCell>> out(at(ranks));
  out[0] = placed_cells(dm, static_cast<int>(dim), material, first);
  std::vector<PlacedCell> all;
  for (const auto& cells : all_to_all(comm, out)) all.insert(all.end(), cells.begin(), cells.end());
  std::ranges::stable_sort(all, {}, &PlacedCell::key);
  std::vector<PatchCell> cells;
  for (const PlacedCell& placed : all) cells.push_back(placed.cell);
  const std::vector<PetscInt> patch = make_patches(static_cast<int>(dim), cells);
  std::vector<std::vector<std::array<PetscInt, 2>>> back(at(ranks));
  for (std::size_t i = 0; i < all.size(); ++i) back[at(all[i].rank)].push_back({all[i].number, patch[i]});
  std::vector<PetscInt> mine(material.size(), absent);
  for (const auto& pairs : all_to_all(comm, back))
    for (const auto& [cell, number] : pairs) mine[at(cell)] = number;
  return mine;
}

} // namespace impact
