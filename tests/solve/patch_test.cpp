#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"
#include <cstdlib>
#include <random>

// An affine displacement of the boundary of a distorted mesh is the solution inside, whatever the cells and
// the cure of locking: Newton's method finds it to round-off, at its quadratic rate.

namespace impact {
namespace {

using problem_test::condition;
using problem_test::MotionCase;
using run_test::box_mesh;

/// Inner nodes moved by up to 20 % of the cell in each direction, 5 % where edges bend; the same on all
/// ranks.
std::string distorted(Shape shape, int n) {
  std::mt19937 random(7);
  return box_mesh(shape, n, [&, n](std::array<double, 3> x, bool inside) {
    const double most = (shape->order() == 2 ? 0.05 : 0.2) / n;
    std::uniform_real_distribution<double> shift(-most, most);
    for (int k = 0; k < dimension(shape); ++k) {
      const double by = shift(random);
      if (inside) x[unsigned(k)] += by;
    }
    return x;
  });
}

void patch(Mesh mesh, const std::vector<std::string>& boundary, Locking locking, const char* what) {
  constexpr double H[3][3] = {{0.083, -0.061, 0.042}, {0.037, -0.074, 0.055}, {-0.049, 0.066, 0.091}};
  MaterialParameters law;
  law.K = 2.5;
  law.G = 1;
  law.locking = locking;
  const int dim = mesh.dim();
  std::vector<problem_test::Field> affine;
  for (int i = 0; i < dim; ++i)
    affine.emplace_back([i, dim, &H](const double* x, double t) {
      double u = 0;
      for (int j = 0; j < dim; ++j) u += t * H[i][j] * (x[j] - 0.5);
      return u;
    });
  BoundaryCondition held = condition("held", "", BcType::displacement, affine);
  held.on = boundary;
  MotionCase run(std::move(mesh), law, {held}, {});
  run.run();
  double error[2] = {0, 0};
  for (std::size_t i = 0; i < run.u().size(); ++i) {
    const double is = affine[i % run.dim()](run.node(i / run.dim()), 1);
    error[0] = std::max(error[0], std::abs(run.u()[i] - is));
    error[1] = std::max(error[1], std::abs(is));
  }
  MPI_Allreduce(MPI_IN_PLACE, error, 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  ASSERT_EQ(run.iterations.size(), 1u) << what << ": no step may be cut";
  // Exponent of the last drop that is well above round-off.
  double order = 0;
  const std::vector<double>& r = run.residuals;
  for (std::size_t k = 2; k < r.size(); ++k)
    if (r[k] > 1e-13 * r[0]) order = std::log(r[k] / r[k - 1]) / std::log(r[k - 1] / r[k - 2]);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0) {
    std::printf("  %s: relative error %.2e, %d iterations, order %.2f, residuals", what, error[0] / error[1],
                run.iterations[0], order);
    for (const double norm : r) std::printf(" %.1e", norm);
    std::printf("\n");
  }
  EXPECT_LT(error[0], 1e-12 * error[1]) << what;
  EXPECT_LE(run.iterations[0], 6) << what;
  EXPECT_GT(order, 1.7) << what;
}

void patch_of(Shape shape, int n, Locking locking, const char* what) {
  const std::string dir = run_test::fresh_dir("patch");
  patch(run_test::mesh_of(PETSC_COMM_WORLD, dir, distorted(shape, n), 0, {{"solid"}}), {"boundary"}, locking,
        what);
}

TEST(Patch, DistortedQuadrilateralsReproduceAnAffineMotion) {
  patch_of(Shape::quad4, 4, Locking::none, "quad4");
  patch_of(Shape::quad4, 4, Locking::mean, "quad4, mean dilatation");
  patch_of(Shape::quad4, 4, Locking::fbar, "quad4, F-bar");
}

TEST(Patch, DistortedTrianglesReproduceAnAffineMotion) {
  patch_of(Shape::tri3, 4, Locking::none, "tri3");
  patch_of(Shape::tri3, 4, Locking::mean, "tri3, mean volume of patches");
}

TEST(Patch, DistortedTetrahedraReproduceAnAffineMotion) {
  patch_of(Shape::tet4, 3, Locking::mean, "tet4, mean volume of patches");
}

TEST(Patch, DistortedHexahedraReproduceAnAffineMotion) {
  patch_of(Shape::hex8, 3, Locking::none, "hex8");
  patch_of(Shape::hex8, 3, Locking::mean, "hex8, mean dilatation");
  patch_of(Shape::hex8, 3, Locking::fbar, "hex8, F-bar");
}

// All nodes moved on their own: edges bend.
TEST(Patch, DistortedSecondOrderCellsReproduceAnAffineMotion) {
  for (const Locking cure : {Locking::none, Locking::mean, Locking::fbar}) {
    patch_of(Shape::tri6, 3, cure, "tri6");
    patch_of(Shape::tet10, 2, cure, "tet10");
    patch_of(Shape::quad9, 3, cure, "quad9");
    patch_of(Shape::quad8, 3, cure, "quad8");
    patch_of(Shape::hex27, 2, cure, "hex27");
    patch_of(Shape::hex20, 2, cure, "hex20");
  }
}

TEST(Patch, UnstructuredTetrahedraReproduceAnAffineMotion) {
  const char* source = std::getenv("IMPACT_SOURCE_DIR");
  if (source == nullptr) GTEST_SKIP() << "IMPACT_SOURCE_DIR is not set";
  MeshRequest request;
  request.file = std::string(source) + "/meshes/block.geo";
  request.parameters = {{"dim", "3"}, {"simplex", "1"}, {"n", "3"}};
  request.work_dir = run_test::fresh_dir("patch_tet");
  patch(read_mesh(PETSC_COMM_WORLD, request), {"left", "right", "bottom", "top", "back", "front"},
        Locking::none, "tet4");
}

} // namespace
} // namespace impact
