#pragma once
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/node_graph.hpp>
#include <memory>

/// A matrix over one nodal field and the precomputed positions at which cell matrices are added: own
/// rows straight into PETSc's value arrays, foreign rows packed and sent once per assembly to each neighbour
/// (no stash). One assembly: zero, add for every batch, finish. After finish others may
/// MatSetValues(ADD_VALUES) at the pairs of the pattern, foreign rows too (PETSc's stash), closed by
/// MatAssemblyBegin/End; a place outside the pattern is an error.
namespace impact {

/// How PETSc stores a matrix of nodal blocks: all entries, or the blocks on and above the diagonal. With
/// those alone the matrix must be symmetric: of all that is added, what stands below the diagonal is passed
/// over.
enum class MatrixFormat { aij, sbaij };

/// One format, in a class of its own.
class SparseAssembly {
public:
  virtual ~SparseAssembly() = default;
  SparseAssembly(const SparseAssembly&) = delete;
  SparseAssembly& operator=(const SparseAssembly&) = delete;

  /// Block size set, all values zero and assembled after construction.
  Mat matrix() const { return matrix_; }

  /// Sets all values to zero. Not collective.
  void zero();
  /// Adds K[node][comp][node][comp] of one batch; padding lanes are skipped. Not collective, no allocation.
  virtual void add(int group, int batch, const Batch* K) = 0;
  /// Sends foreign rows to their owners and closes the assembly. The order of additions is fixed, so that
  /// equal input gives equal bits. Collective.
  void finish();
  /// Own rows' diagonal entries of the given owned local dofs (node * components + k) are set to `value`.
  /// After finish().
  void set_diagonal(const std::vector<int>& dofs, double value);

protected:
  /// `groups` must outlive this.
  SparseAssembly(int components, NodeGraph graph, const std::vector<CellGroup>& groups);
  /// The matrix of a type, before its pattern is known; and afterwards, when no place may be added any more.
  void create(MatType type);
  void keep_pattern(const FieldLayout& layout);
  bool is_parallel() const;
  /// The value arrays of the matrix are borrowed while it is open.
  virtual void borrow() = 0;
  virtual void give_back() = 0;
  void open();
  void close();
  /// Adds the rows that came from other ranks, in the order of the graph's received rows.
  virtual void add_received(const double* values) = 0;
  virtual double& diagonal(int row, int component) = 0;

  const NodeGraph graph_;
  const std::vector<CellGroup>& groups_;
  const int components_;
  Handle<Mat> matrix_;
  Mat own_block_ = nullptr;       // borrowed: the rank's own columns
  double* own_ = nullptr;         // its values between open and close
  std::vector<double> elsewhere_; // what has no place in PETSc's arrays here: with the ghost rows, to be sent
  std::vector<std::size_t> ghost_start_, received_start_; // [row] its first block there and in the messages

private:
  void exchange();

  bool is_open_ = false;
  PetscMPIInt tag_ = 0;
};

/// Pattern: node pairs of every cell plus `extra` (pairs of GLOBAL nodes, any rank may give any pair; both
/// (i,j) and (j,i) are inserted; always the diagonal). `groups` must outlive the assembly. Collective.
std::unique_ptr<SparseAssembly> make_assembly(const FieldLayout& layout, const Mesh& mesh,
                                              const std::vector<CellGroup>& groups,
                                              const std::vector<std::pair<PetscInt, PetscInt>>& extra = {},
                                              MatrixFormat format = MatrixFormat::aij);

} // namespace impact
