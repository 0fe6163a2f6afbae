#include "simulation_case.hpp"
#include "wedge6.hpp"
#include <impact/petsc/ranks.hpp>
#include <random>

// A cell that the program does not have (wedge6.hpp) is met in a mesh, is checked there, and carries a step.

namespace impact {
namespace {

using problem_test::condition;
using problem_test::MotionCase;

/// The unit cube in n^3 cubes, each cut into two wedges; nodes inside are moved. Made on rank 0 and
/// distributed.
Mesh wedges(int n) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> shift(-0.15 / n, 0.15 / n);
  const auto at = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  std::vector<PetscInt> cells;
  std::vector<double> x;
  for (int k = 0; rank == 0 && k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const bool inside = i % n != 0 && j % n != 0 && k % n != 0;
        for (const int index : {i, j, k}) x.push_back(double(index) / n + (inside ? shift(random) : 0));
        if (i == n || j == n || k == n) continue;
        const int corner[4][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
        for (const auto& triangle : {std::array{0, 1, 2}, {0, 2, 3}}) {
          PetscInt cone[6];
          for (int a = 0; a < 6; ++a) {
            const int* c = corner[triangle[unsigned(a % 3)]];
            cone[a] = at(c[0], c[1], a < 3 ? k : k + 1);
          }
          cells.insert(cells.end(), cone, cone + 6);
        }
      }
  Handle<DM> dm;
  check(DMPlexCreateFromCellListPetsc(PETSC_COMM_WORLD, 3, PetscInt(cells.size() / 6), PetscInt(x.size() / 3),
                                      6, PETSC_TRUE, cells.data(), 3, x.data(), dm.out()));
  check(DMCreateLabel(dm, "solid"));
  check(DMCreateLabel(dm, "boundary"));
  DMLabel solid = nullptr, boundary = nullptr;
  check(DMGetLabel(dm, "solid", &solid));
  check(DMGetLabel(dm, "boundary", &boundary));
  PetscInt start = 0, end = 0;
  check(DMPlexGetHeightStratum(dm, 0, &start, &end));
  for (PetscInt cell = start; cell < end; ++cell) check(DMLabelSetValue(solid, cell, 3));
  check(DMPlexMarkBoundaryFaces(dm, 2, boundary));
  std::vector<PetscInt> no_patches;
  distribute(dm, {}, no_patches);
  return {std::move(dm), {{"solid", 3}, {"boundary", 2}}};
}

TEST(OwnCell, FacetsOfBothKindsCloseTheBody) {
  const KnownShape known(wedge6);
  const Mesh mesh = wedges(2);
  const FacetTable facets = mesh.facets("boundary");
  EXPECT_EQ(facets.nodes_per_facet, 4);
  double area[4] = {0, 0, 0, 0}; // their sum as vectors, and as numbers
  for (int f = 0; f < facets.count(); ++f) {
    const auto X = [&](int a, int i) {
      const int node = facets.connectivity[unsigned(4 * f + a)];
      return mesh.coordinates()[unsigned(3 * node + i)];
    };
    double n[3];
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      n[i] = ((X(2, j) - X(0, j)) * (X(3, k) - X(1, k)) - (X(2, k) - X(0, k)) * (X(3, j) - X(1, j))) / 2;
      area[i] += n[i];
    }
    area[3] += std::hypot(n[0], n[1], n[2]);
  }
  sum_over_ranks(PETSC_COMM_WORLD, area);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(area[i], 0, 1e-14);
  EXPECT_NEAR(area[3], 6, 1e-13);
}

TEST(OwnCell, TangentIsTheDerivativeOfTheResidual) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-1, 1);
  MaterialParameters law;
  law.K = 2.5;
  law.G = 1;
  constexpr int n = 18;
  Batch X[n], u[n];
  const double corner[6][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  for (int i = 0; i < n; ++i)
    for (int l = 0; l < lanes; ++l) {
      X[i].set(l, corner[i / 3][i % 3] + 0.1 * noise(random));
      u[i].set(l, 0.05 * noise(random));
    }
  MotionInput in;
  in.X = X;
  in.u = u;
  for (const Locking locking : {Locking::none, Locking::mean, Locking::fbar}) {
    law.locking = locking;
    const CellKernels& kernels = Shape(wedge6).kernels(Frame::solid);
    std::vector<Batch> K(n * n);
    kernels.motion_tangent(PointLaw{law}, in, nullptr, K.data());
    constexpr double h = 1e-6;
    for (int j = 0; j < n; ++j) {
      std::vector<Batch> up(n, Batch(0.0)), down = up;
      const Batch at = u[j];
      u[j] = at + Batch(h);
      kernels.motion_residual(PointLaw{law}, in, up.data());
      u[j] = at - Batch(h);
      kernels.motion_residual(PointLaw{law}, in, down.data());
      u[j] = at;
      for (int i = 0; i < n; ++i)
        for (int l = 0; l < lanes; ++l)
          EXPECT_NEAR(K[unsigned(i * n + j)][l], (up[unsigned(i)][l] - down[unsigned(i)][l]) / (2 * h), 1e-8);
    }
  }
}

TEST(OwnCell, DistortedWedgesReproduceAnAffineMotion) {
  const KnownShape known(wedge6);
  constexpr double H[3][3] = {{0.083, -0.061, 0.042}, {0.037, -0.074, 0.055}, {-0.049, 0.066, 0.091}};
  MaterialParameters law;
  law.K = 2.5;
  law.G = 1;
  std::vector<problem_test::Field> affine;
  for (int i = 0; i < 3; ++i)
    affine.emplace_back([i, &H](const double* x, double t) {
      double u = 0;
      for (int j = 0; j < 3; ++j) u += t * H[i][j] * (x[j] - 0.5);
      return u;
    });
  MotionCase run(wedges(3), law, {condition("held", "boundary", BcType::displacement, affine)}, {});
  run.run();
  double error = 0;
  for (std::size_t i = 0; i < run.u().size(); ++i)
    error = std::max(error, std::abs(run.u()[i] - affine[i % 3](run.node(i / 3), 1)));
  EXPECT_LT(error, 1e-13);
  ASSERT_EQ(run.iterations.size(), 1u);
  EXPECT_LE(run.iterations[0], 6);
}

} // namespace
} // namespace impact
