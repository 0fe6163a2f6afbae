#include "example_meshes.hpp"
#include <gtest/gtest.h>
#include <impact/mesh/field_layout.hpp>

namespace impact {

namespace {

double value_at(const Mesh& mesh, int node, int k) {
  return 1000 * k + static_cast<double>(mesh.global_node()[static_cast<std::size_t>(node)]);
}

TEST(FieldLayout, GlobalEntriesStandAtTheGlobalNodeTimesComponents) {
  const Mesh mesh = make_block(Shape::tri3, 4);
  for (const int components : {1, 2, 3}) {
    const FieldLayout layout(mesh, "field", components);
    const Handle<Vec> x = layout.make_global();
    PetscInt size = 0, block = 0, low = 0, high = 0;
    VecGetSize(x, &size);
    VecGetBlockSize(x, &block);
    VecGetOwnershipRange(x, &low, &high);
    EXPECT_EQ(size, 25 * components);
    EXPECT_EQ(block, components);
    std::vector<double> local = layout.make_local();
    for (int n = 0; n < mesh.node_count(); ++n)
      for (int k = 0; k < components; ++k)
        local[static_cast<std::size_t>(n * components + k)] =
            mesh.owned(n) ? value_at(mesh, n, k) : -1e9; // ghosts ignored
    layout.to_global(local, x);
    const PetscScalar* value = nullptr;
    VecGetArrayRead(x, &value);
    for (PetscInt i = low; i < high; ++i) EXPECT_EQ(value[i - low], 1000 * (i % components) + i / components);
    VecRestoreArrayRead(x, &value);
    layout.to_local(x, local);
    for (int n = 0; n < mesh.node_count(); ++n)
      for (int k = 0; k < components; ++k)
        EXPECT_EQ(local[static_cast<std::size_t>(n * components + k)], value_at(mesh, n, k));
  }
}

TEST(FieldLayout, AddToGlobalSumsTheContributionsOfAllRanks) {
  const Mesh mesh = make_block(Shape::hex8, 3);
  const FieldLayout layout(mesh, "field", 3);
  const Handle<Vec> x = layout.make_global();
  // Each cell gives 1 to each of its nodes, so that a node gets its number of cells: 1, 2, 4 or 8.
  std::vector<double> local = layout.make_local();
  for (const CellTable& table : mesh.cells())
    for (const int n : table.connectivity)
      for (int k = 0; k < 3; ++k) local[static_cast<std::size_t>(3 * n + k)] += k + 1;
  VecSet(x, 0.5);
  layout.add_to_global(local, x);
  layout.to_local(x, local);
  for (int n = 0; n < mesh.node_count(); ++n) {
    int cells = 1;
    for (int i = 0; i < 3; ++i) {
      const double c = mesh.coordinates()[static_cast<std::size_t>(3 * n + i)];
      cells *= c > 1e-9 && c < 1 - 1e-9 ? 2 : 1;
    }
    for (int k = 0; k < 3; ++k)
      EXPECT_DOUBLE_EQ(local[static_cast<std::size_t>(3 * n + k)], 0.5 + (k + 1) * cells);
  }
}

TEST(FieldLayout, NearNullSpaceHasAllRigidMotions) {
  for (const Shape shape : {Shape::tri3, Shape::hex8}) {
    const Mesh mesh = make_block(shape, 3);
    const int dim = mesh.dim();
    const FieldLayout layout(mesh, "displacement", dim);
    const Handle<MatNullSpace> modes = near_null_space(layout, mesh);
    PetscInt count = 0;
    const Vec* mode = nullptr;
    MatNullSpaceGetVecs(modes, nullptr, &count, &mode);
    EXPECT_EQ(count, dim == 2 ? 3 : 6);
    // A rigid motion keeps distances to first order: (u_a - u_b).(x_a - x_b) = 0 for all nodes of a rank.
    for (PetscInt m = 0; m < count; ++m) {
      std::vector<double> u = layout.make_local();
      layout.to_local(mode[m], u);
      for (int n = 1; n < mesh.node_count(); ++n) {
        double product = 0;
        for (int i = 0; i < dim; ++i)
          product += (u[static_cast<std::size_t>(n * dim + i)] - u[static_cast<std::size_t>(i)]) *
                     (mesh.coordinates()[static_cast<std::size_t>(n * dim + i)] -
                      mesh.coordinates()[static_cast<std::size_t>(i)]);
        EXPECT_NEAR(product, 0, 1e-13);
      }
    }
  }
}

TEST(FieldLayout, WorksOnRanksWithoutCells) {
  const Mesh mesh = make_block(Shape::quad4, 1);
  const FieldLayout layout(mesh, "field", 2);
  const Handle<Vec> x = layout.make_global();
  std::vector<double> local = layout.make_local();
  for (double& v : local) v = 1;
  layout.add_to_global(local, x);
  PetscScalar sum = 0;
  VecSum(x, &sum);
  EXPECT_EQ(sum, 8);
}

} // namespace

} // namespace impact
