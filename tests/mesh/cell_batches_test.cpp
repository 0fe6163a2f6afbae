#include "example_meshes.hpp"
#include <gtest/gtest.h>
#include <impact/mesh/cell_batches.hpp>

namespace impact {

namespace {

std::vector<int> one_material(const Mesh& mesh) {
  return std::vector<int>(static_cast<std::size_t>(mesh.cell_count()), 0);
}

TEST(CellBatches, GatherThenScatterCountsTheCellsOfEachNode) {
  for (const Shape shape : all_shapes) {
    const Mesh mesh = make_block(shape, 3);
    const auto groups = pack_cells(mesh, one_material(mesh));
    ASSERT_EQ(groups.size(), 1U);
    EXPECT_EQ(sum_over_ranks(groups[0].cell_count), mesh.global_cell_count());
    constexpr int components = 2;
    const int nodes = node_count(shape);
    std::vector<double> in(static_cast<std::size_t>(mesh.node_count() * components)), out(in.size()),
        expected(in.size());
    for (std::size_t k = 0; k < in.size(); ++k) in[k] = 1.0 + 0.25 * static_cast<double>(k);
    for (const CellTable& table : mesh.cells())
      for (const int n : table.connectivity)
        for (int k = 0; k < components; ++k) {
          const auto dof = static_cast<std::size_t>(n * components + k);
          expected[dof] += in[dof];
        }
    std::vector<Batch> values(static_cast<std::size_t>(nodes * components));
    for (int b = 0; b < groups[0].batch_count; ++b) {
      gather<components>(groups[0], b, in.data(), values.data());
      scatter_add<components>(groups[0], b, values.data(), out.data());
    }
    EXPECT_EQ(out, expected); // multiples of 1/4: exact
  }
}

TEST(CellBatches, PaddingRepeatsTheLastCell) {
  const Mesh mesh = make_block(Shape::quad4, 3);
  for (const CellGroup& group : pack_cells(mesh, one_material(mesh))) {
    int lanes_used = 0;
    for (int b = 0; b < group.batch_count; ++b) {
      const int used = group.lanes_in_use(b);
      lanes_used += used;
      for (int l = used; l < lanes; ++l) {
        EXPECT_EQ(group.cell_point[static_cast<std::size_t>(b * lanes + l)],
                  group.cell_point[static_cast<std::size_t>(b * lanes + used - 1)]);
        for (int a = 0; a < 4; ++a)
          EXPECT_EQ(group.node[static_cast<std::size_t>((b * 4 + a) * lanes + l)],
                    group.node[static_cast<std::size_t>((b * 4 + a) * lanes + used - 1)]);
      }
    }
    EXPECT_EQ(lanes_used, group.cell_count);
  }
}

TEST(CellBatches, GroupsAreTheSameOnAllRanks) {
  const Mesh mesh = read_mesh(PETSC_COMM_WORLD, example_mesh("two_blocks"));
  std::vector<int> material = one_material(mesh);
  for (const PetscInt p : mesh.region_cells("upper"))
    material[static_cast<std::size_t>(p - mesh.cell_start())] = 1;
  const auto groups = pack_cells(mesh, material);
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[1].material, 1);
  EXPECT_EQ(sum_over_ranks(groups[0].cell_count), 16);
  EXPECT_EQ(sum_over_ranks(groups[1].cell_count), 9);
}

TEST(CellBatches, RefusesCellsWithoutMaterialOnAllRanks) {
  const Mesh mesh = read_mesh(PETSC_COMM_WORLD, example_mesh("two_blocks"));
  std::vector<int> material = one_material(mesh);
  for (const PetscInt p : mesh.region_cells("upper"))
    material[static_cast<std::size_t>(p - mesh.cell_start())] = -1;
  ExitCode code{};
  EXPECT_NE(user_error(code, [&] { pack_cells(mesh, material); }).find("of upper has no material"),
            std::string::npos);
  EXPECT_EQ(code, ExitCode::data);
}

} // namespace

} // namespace impact
