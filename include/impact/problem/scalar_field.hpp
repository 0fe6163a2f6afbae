#pragma once
#include <impact/mesh/middle_values.hpp>
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/settings.hpp>
#include <optional>
#include <span>

/// What the balances of damage and heat share: one unknown per node, held at some nodes, the matrix of its
/// equation and the defaults of its solvers.
namespace impact {

/// Whether bounds of phi at the nodes are no bounds: shape functions of corners integrate to less than
/// nothing over Tet10, Quad8 and Hex20, so that what a variational inequality asks of a corner means the
/// opposite there.
bool bounds_fail(const DamageScenario&, const Mesh&);
/// Whether phi is of first order: where -damage_order says so or, unless it says 2, where the bounds fail.
bool has_linear_damage(const DamageScenario&, const Mesh&);

class ScalarField {
public:
  /// Nodes with `held` [local node] have no equation, nor have middles where the field is of first order on
  /// cells of second order (`linear`). Collective.
  ScalarField(const Discretisation& discretisation, std::vector<char> held, bool linear);
  ScalarField(const ScalarField&) = delete;
  ScalarField& operator=(const ScalarField&) = delete;

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

  /// Null but for a field of first order on cells of second order.
  const MiddleValues* middles() const { return middles_ ? &*middles_ : nullptr; }
  void fill_middles(std::vector<double>& values) const {
    if (middles_) middles_->fill(values);
  }
  void fold_middles(std::vector<double>& forces) const {
    if (middles_) middles_->fold(forces);
  }
  /// A global vector as local array, ghosts included, with its middles. Collective.
  void to_local(Vec x, std::vector<double>& values) const;
  /// f = sum over the ranks of the local r, whose middles are folded. Collective.
  void assemble(std::vector<double>& r, Vec f) const;
  /// f = 0 at held nodes.
  void zero_held(Vec f) const;

  void zero_matrix() { assembly_->zero(); }
  /// Adds a cell matrix without the rows and columns of held nodes, which it loses.
  void add(const CellBatch& batch, CellMatrix& K);
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
  std::optional<MiddleValues> middles_;
  // Where there are middles: the cells by their corners, and amid which of these each node stands.
  std::vector<CellGroup> corner_groups_;
  std::vector<std::vector<std::vector<int>>> around_; // [group][node]
  CellMatrix of_corners_;
  std::unique_ptr<SparseAssembly> assembly_;
  Handle<Vec> solution_, residual_, diagonal_;
};

} // namespace impact
