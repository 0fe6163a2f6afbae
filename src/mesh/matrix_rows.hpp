#pragma once
#include "row_messages.hpp"
#include <impact/math/index.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/petsc/handle.hpp>
#include <memory>
#include <optional>

/// How cell matrices get into a matrix of one storage format: what SparseAssembly hands its calls on to.
namespace impact {

class MatrixRows {
public:
  virtual ~MatrixRows() = default;
  MatrixRows(const MatrixRows&) = delete;
  MatrixRows& operator=(const MatrixRows&) = delete;

  Mat matrix() const { return matrix_; }
  void zero();
  virtual void add(int group, int batch, const Batch* K) = 0;
  void finish();
  virtual void set_diagonal(const std::vector<int>& dofs, double value) = 0;

protected:
  /// `graph` and `groups` must outlive this.
  MatrixRows(const FieldLayout& layout, const NodeGraph& graph, const std::vector<CellGroup>& groups);
  /// The matrix of a type, before its pattern is known; and afterwards, when no place may be added any more.
  void create(MatType type);
  void keep_pattern(const FieldLayout& layout);
  bool is_parallel() const;
  /// Borrows the value arrays of the matrix, and gives them back.
  virtual void borrow() = 0;
  virtual void give_back() = 0;
  void open();
  void close();
  /// Adds the rows that came from other ranks, in the order of the graph's received rows.
  virtual void add_received(const double* values) = 0;

  const NodeGraph& graph_;
  const std::vector<CellGroup>& groups_;
  const int components_;
  Handle<Mat> matrix_;
  Mat own_block_ = nullptr; // borrowed: the rank's own columns
  double* own_ = nullptr;   // its values between open and close
  bool is_open_ = false;
  std::vector<double> elsewhere_; // what has no place in PETSc's arrays here: with the ghost rows, to be sent
  std::optional<RowMessages> messages_;
};

std::unique_ptr<MatrixRows> make_aij_rows(const FieldLayout& layout, const NodeGraph& graph,
                                          const std::vector<CellGroup>& groups);
std::unique_ptr<MatrixRows> make_symmetric_blocks(const FieldLayout& layout, const NodeGraph& graph,
                                                  const std::vector<CellGroup>& groups);

} // namespace impact
