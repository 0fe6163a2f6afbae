#include "example_meshes.hpp"
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <impact/mesh/sparse_assembly.hpp>

namespace impact {

namespace {

// Any unsymmetric function of the two global dofs will do as a cell's entry.
double entry(PetscInt row, PetscInt column) {
  return std::sin(0.37 * static_cast<double>(row) + 1.1) * std::cos(0.23 * static_cast<double>(column)) +
         (row == column ? 4 : 0);
}

double symmetric_entry(PetscInt row, PetscInt column) { return entry(row, column) + entry(column, row); }

struct Problem {
  using Entry = double (*)(PetscInt, PetscInt);
  Mesh mesh;
  FieldLayout layout;
  std::vector<CellGroup> groups;

  Problem(Mesh m, int components)
      : mesh(std::move(m)), layout(mesh, "field", components),
        groups(pack_cells(mesh, std::vector<int>(static_cast<std::size_t>(mesh.cell_count()), 0))) {}

  PetscInt dof(int node, int k) const {
    return mesh.global_node()[static_cast<std::size_t>(node)] * layout.components() + k;
  }

  void assemble(SparseAssembly& assembly, Entry value = entry) const {
    const int c = layout.components();
    assembly.zero();
    for (int g = 0; g < static_cast<int>(groups.size()); ++g) {
      const CellGroup& group = groups[static_cast<std::size_t>(g)];
      const int nodes = node_count(group.shape), width = nodes * c;
      std::vector<Batch> K(static_cast<std::size_t>(width * width));
      for (int b = 0; b < group.batch_count; ++b) {
        const int* node = &group.node[static_cast<std::size_t>(b * nodes * lanes)];
        for (int i = 0; i < width; ++i)
          for (int j = 0; j < width; ++j)
            for (int l = 0; l < lanes; ++l)
              K[static_cast<std::size_t>(i * width + j)].set(
                  l, value(dof(node[i / c * lanes + l], i % c), dof(node[j / c * lanes + l], j % c)));
        assembly.add(g, b, K.data());
      }
    }
    assembly.finish();
  }

  /// The same matrix through PETSc's own insertion.
  Handle<Mat> reference(Entry value = entry) const {
    const int c = layout.components();
    Handle<Mat> A;
    MatCreate(PETSC_COMM_WORLD, A.out());
    MatSetSizes(A, mesh.owned_node_count() * c, mesh.owned_node_count() * c, PETSC_DETERMINE,
                PETSC_DETERMINE);
    MatSetType(A, MATAIJ);
    MatSeqAIJSetPreallocation(A, 150, nullptr);
    MatMPIAIJSetPreallocation(A, 150, nullptr, 100, nullptr);
    MatSetOption(A, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE);
    for (const CellTable& table : mesh.cells()) {
      const std::size_t nodes = static_cast<std::size_t>(node_count(table.shape));
      for (std::size_t cell = 0; cell < table.point.size(); ++cell)
        for (std::size_t i = 0; i < nodes * static_cast<std::size_t>(c); ++i)
          for (std::size_t j = 0; j < nodes * static_cast<std::size_t>(c); ++j) {
            const std::size_t w = static_cast<std::size_t>(c);
            const PetscInt row = dof(table.connectivity[cell * nodes + i / w], static_cast<int>(i % w));
            const PetscInt column = dof(table.connectivity[cell * nodes + j / w], static_cast<int>(j % w));
            MatSetValue(A, row, column, value(row, column), ADD_VALUES);
          }
    }
    MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY);
    return A;
  }
};

/// Largest norm of A - B over the norm of B.
double difference(Mat A, Mat B) {
  Handle<Mat> D;
  PetscReal norm = 0, scale = 0;
  MatDuplicate(A, MAT_COPY_VALUES, D.out());
  MatSetOption(D, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_FALSE);
  MatAXPY(D, -1, B, DIFFERENT_NONZERO_PATTERN);
  MatNorm(D, NORM_FROBENIUS, &norm);
  MatNorm(B, NORM_FROBENIUS, &scale);
  return norm / scale;
}

/// The same for a matrix of any format, from its products with the unit vectors.
double difference_by_products(Mat A, Mat B) {
  Handle<Mat> full;
  MatComputeOperator(A, MATAIJ, full.out());
  return difference(full, B);
}

TEST(SparseAssembly, SymmetricBlocksEqualMatSetValues) {
  for (const Shape shape : all_shapes)
    for (const int components : {1, 2, 3}) {
      const Problem p(make_block(shape, 3), components);
      const auto owner = make_assembly(p.layout, p.mesh, p.groups, {}, MatrixFormat::sbaij);
      SparseAssembly& assembly = *owner;
      const Handle<Mat> expected = p.reference(symmetric_entry);
      for (int pass = 0; pass < 2; ++pass) {
        p.assemble(assembly, symmetric_entry);
        EXPECT_LT(difference_by_products(assembly.matrix(), expected), 1e-14);
      }
      PetscInt block = 0;
      MatGetBlockSize(assembly.matrix(), &block);
      EXPECT_EQ(block, components);
    }
}

TEST(SparseAssembly, SymmetricBlocksTakeExtraPairsLaterValuesAndDiagonals) {
  const Problem p(make_block(Shape::quad4, 4), 2);
  const PetscInt last = p.mesh.global_node_count() - 1;
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  std::vector<std::pair<PetscInt, PetscInt>> extra;
  if (rank == 0) extra = {{0, last}, {last / 2, 0}, {last, last / 2}};
  const auto owner = make_assembly(p.layout, p.mesh, p.groups, extra, MatrixFormat::sbaij);
  SparseAssembly& assembly = *owner;
  // A symmetric block as contact adds it, below and above the diagonal, from one rank; negative dofs are out.
  const auto add_contact = [&](Mat A) {
    const PetscInt dof[6] = {2 * last, 2 * last + 1, 0, -1, last / 2 * 2, last / 2 * 2 + 1};
    double block[36];
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) block[6 * i + j] = 1.5 + std::cos(i + j);
    if (rank == 0) MatSetValues(A, 6, dof, 6, dof, block, ADD_VALUES);
    MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY);
  };
  std::vector<int> dofs;
  for (const int n : p.mesh.nodes("left"))
    if (p.mesh.owned(n)) dofs.push_back(2 * n + 1);
  const Handle<Mat> expected = p.reference(symmetric_entry);
  add_contact(expected);
  for (const int d : dofs) {
    const PetscInt row = p.dof(d / 2, d % 2);
    MatSetValue(expected, row, row, 77, INSERT_VALUES);
  }
  MatAssemblyBegin(expected, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(expected, MAT_FINAL_ASSEMBLY);
  for (int pass = 0; pass < 3; ++pass) {
    p.assemble(assembly, symmetric_entry);
    add_contact(assembly.matrix());
    assembly.set_diagonal(dofs, 77);
    EXPECT_LT(difference_by_products(assembly.matrix(), expected), 1e-14);
  }
}

TEST(SparseAssembly, EqualsMatSetValues) {
  for (const Shape shape : all_shapes)
    for (const int components : {1, 2, 3}) {
      const Problem p(make_block(shape, 3), components);
      const auto owner = make_assembly(p.layout, p.mesh, p.groups);
      SparseAssembly& assembly = *owner;
      const Handle<Mat> expected = p.reference();
      for (int pass = 0; pass < 2; ++pass) { // a second assembly starts from nothing
        p.assemble(assembly);
        EXPECT_LT(difference(assembly.matrix(), expected), 1e-14);
      }
      PetscInt block = 0;
      MatGetBlockSize(assembly.matrix(), &block);
      EXPECT_EQ(block, components);
    }
}

TEST(SparseAssembly, EqualsMatSetValuesForRegionsOfDifferentMaterial) {
  Mesh mesh = read_mesh(PETSC_COMM_WORLD, example_mesh("two_blocks", {{"n_lower", "5"}}));
  Problem p(std::move(mesh), 2);
  std::vector<int> material(static_cast<std::size_t>(p.mesh.cell_count()), 0);
  for (const PetscInt c : p.mesh.region_cells("upper"))
    material[static_cast<std::size_t>(c - p.mesh.cell_start())] = 1;
  p.groups = pack_cells(p.mesh, material);
  const auto owner = make_assembly(p.layout, p.mesh, p.groups);
  SparseAssembly& assembly = *owner;
  p.assemble(assembly);
  EXPECT_LT(difference(assembly.matrix(), p.reference()), 1e-14);
}

TEST(SparseAssembly, TakesExtraPairsFromAnyRankAndLaterMatSetValues) {
  const Problem p(make_block(Shape::quad4, 4), 2);
  const PetscInt last = p.mesh.global_node_count() - 1;
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  std::vector<std::pair<PetscInt, PetscInt>> extra;
  if (rank == 0) extra = {{0, last}, {last / 2, 0}, {last, last}, {0, last}};
  const auto owner = make_assembly(p.layout, p.mesh, p.groups, extra);
  SparseAssembly& assembly = *owner;
  const auto add_contact = [&](Mat A, InsertMode mode) {
    for (const auto& [i, j] : extra)
      for (PetscInt k = 0; k < 2; ++k) {
        MatSetValue(A, 2 * i + k, 2 * j + 1 - k, 3.5, mode);
        MatSetValue(A, 2 * j + k, 2 * i, -1.5, mode);
      }
    MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY);
  };
  const Handle<Mat> expected = p.reference();
  add_contact(expected, ADD_VALUES);
  for (int pass = 0; pass < 3; ++pass) {
    p.assemble(assembly);
    add_contact(assembly.matrix(), ADD_VALUES);
    EXPECT_LT(difference(assembly.matrix(), expected), 1e-14);
  }
  // Outside of the pattern is an error, not a silent change of the structure under the positions.
  PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr);
  const NodeGraph graph(p.mesh, p.groups, extra);
  if (graph.columns.count() > 0) {
    PetscInt outside = 0;
    while (std::ranges::count(graph.columns[0], outside) > 0) ++outside;
    EXPECT_NE(MatSetValue(assembly.matrix(), 2 * graph.first_node, 2 * outside, 1, ADD_VALUES), 0);
  }
  PetscPopErrorHandler();
}

TEST(SparseAssembly, TellsSolversThatTheMatrixChanged) {
  const Problem p(make_block(Shape::tri3, 4), 1);
  const auto owner = make_assembly(p.layout, p.mesh, p.groups);
  SparseAssembly& assembly = *owner;
  Handle<Vec> x = p.layout.make_global(), y = p.layout.make_global();
  Handle<KSP> solver;
  KSPCreate(PETSC_COMM_WORLD, solver.out());
  KSPSetType(solver, KSPGMRES);
  PC pc = nullptr;
  KSPGetPC(solver, &pc);
  PCSetType(pc, PCSOR); // keeps the inverted diagonal
  KSPSetTolerances(solver, 1e-12, 1e-50, PETSC_DEFAULT, 500);
  PetscReal norm[2];
  for (int pass = 0; pass < 2; ++pass) {
    p.assemble(assembly);
    std::vector<int> dofs;
    for (int n = 0; n < p.mesh.node_count(); ++n)
      if (p.mesh.owned(n)) dofs.push_back(n);
    assembly.set_diagonal(dofs, pass == 0 ? 1000 : 4000);
    VecSet(x, 1);
    KSPSetOperators(solver, assembly.matrix(), assembly.matrix());
    EXPECT_EQ(KSPSolve(solver, x, y), 0);
    KSPConvergedReason reason{};
    PetscInt iterations = 0;
    KSPGetConvergedReason(solver, &reason);
    KSPGetIterationNumber(solver, &iterations);
    EXPECT_GT(reason, 0);
    EXPECT_LT(iterations, 15); // with the old diagonal the second solve would need far more
    VecNorm(y, NORM_INFINITY, &norm[pass]);
  }
  EXPECT_NEAR(norm[0] / norm[1], 4, 0.1);
}

TEST(SparseAssembly, SetDiagonalWritesTheWantedEntriesOnly) {
  const Problem p(make_block(Shape::quad4, 3), 2);
  const auto owner = make_assembly(p.layout, p.mesh, p.groups);
  SparseAssembly& assembly = *owner;
  p.assemble(assembly);
  std::vector<int> dofs;
  for (const int n : p.mesh.nodes("left"))
    if (p.mesh.owned(n)) dofs.push_back(2 * n + 1);
  assembly.set_diagonal(dofs, 77);
  Handle<Mat> expected = p.reference();
  for (const int d : dofs) {
    const PetscInt row = p.dof(d / 2, d % 2);
    MatSetValue(expected, row, row, 77, INSERT_VALUES);
  }
  MatAssemblyBegin(expected, MAT_FINAL_ASSEMBLY);
  MatAssemblyEnd(expected, MAT_FINAL_ASSEMBLY);
  EXPECT_LT(difference(assembly.matrix(), expected), 1e-14);
}

TEST(SparseAssembly, KeepsItsPatternAfterRowsWereZeroed) {
  const Problem p(make_block(Shape::quad4, 3), 2);
  const auto owner = make_assembly(p.layout, p.mesh, p.groups);
  SparseAssembly& assembly = *owner;
  p.assemble(assembly);
  std::vector<PetscInt> rows;
  for (const int n : p.mesh.nodes("left"))
    if (p.mesh.owned(n)) rows.push_back(p.dof(n, 0));
  MatZeroRowsColumns(assembly.matrix(), static_cast<PetscInt>(rows.size()), rows.data(), 1, nullptr, nullptr);
  p.assemble(assembly);
  EXPECT_LT(difference(assembly.matrix(), p.reference()), 1e-14);
}

TEST(SparseAssembly, WorksOnRanksWithoutCells) {
  const Problem p(make_block(Shape::quad4, 1), 2);
  const auto owner = make_assembly(p.layout, p.mesh, p.groups);
  SparseAssembly& assembly = *owner;
  p.assemble(assembly);
  EXPECT_LT(difference(assembly.matrix(), p.reference()), 1e-14);
}

} // namespace

} // namespace impact
