#pragma once
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/motion_rows.hpp>

namespace impact {

/// Of the cells of a batch that have left (erosion.hpp) the mass stays: its force on the nodes at these
/// accelerations, [node][dim], is added to theirs; their block of K becomes `factor` times it.
void add_eroded_inertia(const CellBatch& batch, const NodalValues& acceleration, NodalValues& force);
void keep_eroded_mass(const CellBatch& batch, double factor, CellMatrix& K);

/// The diagonal alone of a mass [node][node], with the mass of the cell: for cells of second order, as
/// LumpedMass has it.
void lump(int n, CellMatrix& m);

/// The mass of all bodies, consistent or lumped as the discretisation has it, assembled when it is first
/// asked for.
class MassMatrix {
public:
  /// Both must outlive the matrix.
  MassMatrix(const Discretisation& discretisation, const MotionRows& rows)
      : d_(discretisation), rows_(rows) {}

  /// y = M x, prescribed rows included. Collective.
  void multiply(Vec x, Vec y);
  /// The lumped mass is that of the cells times these factors, of a row with one for each point; they must
  /// outlive the matrix.
  void scale(const std::vector<double>* factors);
  /// Cells have left with their mass: the lumped mass is made anew.
  void forget() {
    lumped_ = {};
    unscaled_ = {};
  }
  /// Solves M x = b on free dofs; other entries of x keep their values, their columns lifted. Throws
  /// UserError. Collective.
  void solve(Vec b, Vec x);
  /// Adds factor M to an assembly of the displacement's matrix, `masked`: without the rows and columns of
  /// dofs that are not free. Returns this rank's sum of the diagonal that was added.
  double add_to(SparseAssembly& assembly, double factor, bool masked) const;

  /// The lumped mass of each dof. Collective.
  Vec lumped();
  /// Without what mass scaling added.
  Vec true_lumped();

private:
  void build();
  Handle<Vec> make_lumped(const std::vector<double>* factors) const;

  const Discretisation& d_;
  const MotionRows& rows_;
  Handle<Mat> all_, free_; // free_: rows and columns of dofs that are not free as identity
  Handle<KSP> solver_;
  Handle<Vec> lumped_, unscaled_;
  const std::vector<double>* factors_ = nullptr;
};

} // namespace impact
