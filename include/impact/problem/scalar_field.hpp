#pragma once
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/cell_loop.hpp>
#include <optional>
#include <span>

/// What the balances of damage and heat share: one unknown per node, held at some nodes, the matrix of its
/// equation and the defaults of its solvers.
namespace impact {

class ScalarField {
public:
  /// Nodes with `held` [local node] have no equation. Collective.
  ScalarField(const Discretisation& discretisation, std::vector<char> held);

  Mat matrix() const { return assembly_->matrix(); }
  const std::vector<char>& held() const { return held_; }
  const std::vector<int>& owned_held() const { return owned_held_; }
  Vec solution() const { return solution_; } ///< work vectors of who solves
  Vec residual() const { return residual_; }

  /// Makes the matrix, with places for `extra` pairs of nodes. Collective.
  void build_matrix(const std::vector<std::pair<PetscInt, PetscInt>>& extra = {});
  /// Gives a new solver its type, its tolerances and the defaults of its linear solver: before its options
  /// are read. cg + icc in blocks of the ranks, or multigrid where the equation spreads what happens at a
  /// point over a `width` of many cells. Collective.
  void prepare(SNES snes, SNESType type, double atol, double rtol, int most_iterations,
               double width = 0) const;

  /// f = sum over the ranks of the local r. Collective.
  void assemble(const std::vector<double>& r, Vec f) const;
  /// f = 0 at held nodes.
  void zero_held(Vec f) const;

  void zero_matrix() { assembly_->zero(); }
  /// Adds a cell matrix without the rows and columns of held nodes, which it loses.
  void add(const CellBatch& batch, CellMatrix& K) {
    K.mask(batch.scalars(free_));
    assembly_->add(batch.number_of_group, batch.number, K.data());
  }
  void finish_matrix() { assembly_->finish(); }
  /// Held rows get the mean of the diagonal; residuals of the solvers cannot fall below what the last digit
  /// of `sizes` makes of the others' rows, or of the diagonal itself without. Collective.
  void close_matrix(std::span<const SNES> solvers, Vec sizes = nullptr);
  /// Of the matrix closed last, times `sizes`.
  Vec diagonal() const { return diagonal_; }

private:
  const Discretisation& d_;
  std::vector<char> held_;
  std::vector<double> free_; // 1 where not held
  std::vector<int> owned_held_;
  std::unique_ptr<SparseAssembly> assembly_;
  Handle<Vec> solution_, residual_, diagonal_;
};

} // namespace impact
