#include "../mesh/box_mesh.hpp"
#include <gtest/gtest.h>
#include <impact/mesh/cell_patches.hpp>
#include <map>
#include <numeric>
#include <random>
#include <set>

// Patches of linear simplices: which cells they are of, and that neither ranks nor numbers decide it.

namespace impact {
namespace {

using Place = std::array<double, 3>;

std::string bent(Shape shape, int n) {
  return run_test::box_mesh(shape, n, [](Place x, bool) {
    return Place{x[0] + 0.07 * x[1] * x[0], x[1] + 0.05 * x[0] * x[2], x[2] * (1 + 0.03 * x[0])};
  });
}

Mesh patched_mesh(MPI_Comm comm, Shape shape, int n, int refine = 0) {
  const std::string dir = run_test::fresh_dir("patches"), file = dir + "/mesh.msh";
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(file) << bent(shape, n); });
  MPI_Barrier(PETSC_COMM_WORLD);
  MeshRequest request;
  request.file = file;
  request.work_dir = dir;
  request.refine = refine;
  request.patched = {{"solid"}};
  return read_mesh(comm, request);
}

// The mean place of the cells of each patch and their number, of this rank's patches.
std::vector<std::pair<Place, int>> patches_of(const Mesh& mesh) {
  std::map<PetscInt, std::pair<Place, int>> of;
  const CellTable& table = mesh.cells()[0];
  const auto nodes = static_cast<std::size_t>(table.shape->nodes), dim = static_cast<std::size_t>(mesh.dim());
  for (std::size_t c = 0; c < table.point.size(); ++c) {
    auto& [place, count] = of[mesh.patches()[static_cast<std::size_t>(table.point[c] - mesh.cell_start())]];
    ++count;
    for (std::size_t a = 0; a < nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i)
        place[i] += mesh.coordinates()[static_cast<std::size_t>(table.connectivity[c * nodes + a]) * dim + i];
  }
  std::vector<std::pair<Place, int>> list;
  for (const auto& [number, patch] : of) {
    EXPECT_GE(number, 0);
    list.push_back(patch);
  }
  return list;
}

// On any number of ranks each patch is one of those of a single rank, and they are all there.
TEST(CellPatches, AreTheSameOnAnyRanks) {
  for (const auto& [shape, n, refine] :
       {std::tuple{Shape::tri3, 6, 0}, {Shape::tet4, 4, 0}, {Shape::tri3, 3, 1}, {Shape::tet4, 2, 1}}) {
    const std::vector<std::pair<Place, int>> all =
                                                 patches_of(patched_mesh(PETSC_COMM_SELF, shape, n, refine)),
                                             mine =
                                                 patches_of(patched_mesh(PETSC_COMM_WORLD, shape, n, refine));
    int count = static_cast<int>(mine.size());
    MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_EQ(count, static_cast<int>(all.size()));
    for (const auto& [place, cells] : mine) {
      double nearest = 1;
      for (const auto& [other, as_many] : all)
        if (as_many == cells)
          nearest =
              std::min(nearest, std::hypot(place[0] - other[0], place[1] - other[1], place[2] - other[2]));
      EXPECT_LT(nearest, 1e-12);
    }
  }
}

/// The square of n x n pairs of triangles, the left half of another material than the right one.
std::vector<PatchCell> triangles(int n) {
  std::vector<PatchCell> cells;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const PetscInt a = j * (n + 1) + i, b = a + n + 1;
      cells.push_back({2 * i < n, {a, a + 1, b + 1, -1}});
      cells.push_back({2 * i < n, {a, b + 1, b, -1}});
    }
  return cells;
}

TEST(CellPatches, AreConnectedOfOneMaterialAndOfEvenSize) {
  const std::vector<PatchCell> cells = triangles(12);
  const std::vector<PetscInt> patch = make_patches(2, cells);
  std::map<PetscInt, std::vector<std::size_t>> members;
  for (std::size_t c = 0; c < cells.size(); ++c) members[patch[c]].push_back(c);
  double squares = 0;
  for (const auto& [number, list] : members) {
    squares += double(list.size() * list.size());
    EXPECT_GE(list.size(), 2u);
    EXPECT_LE(list.size(), 3u);
    std::set<std::size_t> reached = {list[0]};
    for (std::size_t k = 0; k < list.size(); ++k)
      for (const std::size_t c : list)
        for (const std::size_t from : std::set(reached)) {
          int shared = 0;
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              shared += cells[c].corner[unsigned(i)] == cells[from].corner[unsigned(j)] ? 1 : 0;
          if (shared == 2) reached.insert(c);
        }
    EXPECT_EQ(reached.size(), list.size());
    for (const std::size_t c : list) EXPECT_EQ(cells[c].material, cells[list[0]].material);
  }
  EXPECT_LT(squares / double(cells.size()), 2.1); // two each, but for a few
}

TEST(CellPatches, ACellWithoutNeighboursIsAPatch) {
  const std::vector<PetscInt> patch =
      make_patches(2, {{0, {0, 1, 2, -1}}, {0, {3, 4, 5, -1}}, {1, {1, 2, 6, -1}}});
  EXPECT_EQ(std::set<PetscInt>(patch.begin(), patch.end()).size(), 3u);
}

} // namespace
} // namespace impact
