#include "motion_batch.hpp"
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/motion.hpp>
#include <impact/problem/surface_load.hpp>

/// Tangent of the balance of momentum (106): cells, follower pressures, foundations, contact and rigid
/// bodies.
namespace impact {

void MotionProblem::rebuild_matrix() {
  const Timed timed(Event::motion_matrix);
  std::vector<std::pair<PetscInt, PetscInt>> extra;
  if (solved_ && operator_ != ContactOperator::shell)
    extra = contacts_.couplings(); // else none is in the matrix
  const auto own = rigid_->couplings();
  extra.insert(extra.end(), own.begin(), own.end());
  assembly_.reset();
  if ((!d_.patches.empty() || !rigid_->empty()) && matrix_groups_.empty()) {
    matrix_groups_ = d_.groups;
    // The cells of rigid bodies, which have no node in common with others, couple nothing.
    for (CellGroup& group : matrix_groups_)
      if (d_.materials[at(group.material)].law.rigid())
        group = {group.shape, group.material, group.law, 0, 0, {}, {}};
    matrix_groups_.insert(matrix_groups_.end(), d_.patches.stencils.begin(), d_.patches.stencils.end());
  }
  const std::vector<CellGroup>& groups = !solved_                 ? no_groups_
                                         : matrix_groups_.empty() ? d_.groups
                                                                  : matrix_groups_;
  assembly_ = make_assembly(d_.displacement, d_.mesh, groups, extra, format_);
  const Handle<MatNullSpace> modes = near_null_space(d_.displacement, d_.mesh);
  check(MatSetNearNullSpace(matrix(), modes));
}

void MotionProblem::make_shell() {
  linearised_at_ = d_.displacement.make_global();
  const PetscInt rows = Get(VecGetLocalSize)(linearised_at_);
  check(MatCreateShell(d_.mesh.comm(), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, this, shell_.out()));
  PetscErrorCode (*apply)(Mat, Vec, Vec) = [](Mat shell, Vec x, Vec y) -> PetscErrorCode {
    MotionProblem* self = nullptr;
    if (const PetscErrorCode code = MatShellGetContext(shell, &self); code != 0) return code;
    Mailbox mailbox; // what is thrown here ends the linear solve and, with it, the step's callback
    return mailbox.guarded([&] { self->multiply(x, y); });
  };
  check(MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)()>(apply)));
}

void MotionProblem::multiply(Vec x, Vec y) {
  check(MatMult(matrix(), x, y));
  for (const ContactInterface& contact : contacts_)
    contact.multiply(linearised_at_, step_.contact.scale, x, y);
}

bool MotionProblem::update_contact(Vec u) {
  const bool changed = contacts_.update_search(u);
  if (!solved_ || operator_ == ContactOperator::shell) return false;
  if (changed) rebuild_matrix();
  return changed;
}

void MotionProblem::add_pressure_tangent(const std::vector<double>& u) {
  for (const LoadedFacets& load : boundary_.pressures())
    add_follower_pressure_tangent(
        load.facets, d_.frame, X_, u,
        [&](const double* x) { return -boundary_.scalar_value(load.condition, x, step_.t); }, rows_.none,
        d_.mesh.global_node(), matrix());
}

bool MotionProblem::tangent(Vec u, double mass_shift) {
  const Timed timed(Event::motion_tangent);
  forget_broken();
  d_.displacement.to_local(u, u_);
  bool sound = true;
  double diagonal = 0;
  CellMatrix K;
  share(u_, step_.unilateral_scale, patches_, true);
  soft_volume_.put_slopes(patches_);
  assembly_->zero();
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const PointLaw& law = soft_volume_.law(batch);
    MotionBatch cells(batch, step_fields(u_, nullptr, law));
    if (const Batch* told = soft_volume_.pressure(batch, cells.patch_pressure))
      cells.in.patch_pressure = told;
    cells.in.mass_shift = mass_shift;
    cells.in.symmetric = symmetric_;
    const CellStatus status =
        batch.kernels.motion_tangent(law, cells.in, nullptr, K.sized(batch.nodes() * d_.dim()));
    note_inverted(batch, status);
    sound = check_cells(batch.group, batch.number, batch.broken(status.bad), status.min_J) && sound;
    if (batch.eroded != 0) keep_eroded_mass(batch, mass_shift, K);
    if (rows_.held_batches[at(batch.number_of_group)][at(batch.number)]) K.mask(batch.vectors(rows_.free));
    diagonal += batch.sum(K.trace());
    assembly_->add(batch.number_of_group, batch.number, K.data());
  });
  diagonal +=
      add_patch_tangents(d_, u_, patches_, rows_.free, [&](int stencil, int batch, const Batch* part) {
        assembly_->add(static_cast<int>(d_.groups.size()) + stencil, batch, part);
      });
  close_tangent(u, true, diagonal, mass_shift);
  return all_ranks_agree(d_.mesh.comm(), sound);
}

void MotionProblem::projection_tangent(Vec w, double shift) {
  const Timed timed(Event::motion_tangent);
  assembly_->zero();
  close_tangent(w, false, mass_.add_to(*assembly_, shift, true), shift);
}

Handle<IS> MotionProblem::stiffened_rows() const {
  const Entries cells(cells_diagonal_), all(diagonal_);
  const PetscInt dim = d_.dim(), count = Get(VecGetLocalSize)(diagonal_) / dim;
  PetscInt first = 0;
  check(VecGetOwnershipRange(diagonal_, &first, nullptr));
  std::vector<PetscInt> nodes;
  for (PetscInt n = 0; n < count; ++n)
    for (PetscInt r = n * dim; r < (n + 1) * dim; ++r)
      if (std::abs(all[r] - cells[r]) > 1e-3 * cells[r]) {
        nodes.push_back(first / dim + n);
        break;
      }
  Handle<IS> rows;
  check(ISCreateBlock(d_.mesh.comm(), dim, static_cast<PetscInt>(nodes.size()), nodes.data(),
                      PETSC_COPY_VALUES, rows.out()));
  return rows;
}

// The cells' part, whose diagonal sums up to `diagonal` on this rank, is added.
void MotionProblem::close_tangent(Vec u, bool loads, double diagonal, double mass_shift) {
  assembly_->finish();
  check(MatGetDiagonal(matrix(), cells_diagonal_));
  if (!contacts_.empty() || !boundary_.pressures().empty() || !foundations_.empty() || !rigid_->empty()) {
    rigid_->add_tangent(u, mass_shift, matrix());
    if (loads) {
      add_pressure_tangent(u_);
      foundations_.add_tangent(step_.velocity_slope, rows_.none, matrix());
    }
    if (shell_)
      check(VecCopy(u, linearised_at_));
    else
      for (const ContactInterface& contact : contacts_) contact.add_tangent(u, step_.contact.scale, matrix());
    check(MatAssemblyBegin(matrix(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix(), MAT_FINAL_ASSEMBLY));
  }
  check(MatGetDiagonal(matrix(), diagonal_));
  balance_.note_tangent(u, cells_diagonal_, diagonal_, contacts_.demands().closes_gaps);
  // Prescribed rows were masked out; the mean of the cells' other diagonals keeps the condition of the
  // matrix.
  double sums[2] = {diagonal, -static_cast<double>(rows_.massless.size())};
  sum_over_ranks(d_.mesh.comm(), sums);
  const double free_dofs = sums[1] + static_cast<double>(d_.mesh.global_node_count() * d_.dim());
  assembly_->set_diagonal(rows_.of_identity, free_dofs > 0 && sums[0] > 0 ? sums[0] / free_dofs : 1.0);
}

} // namespace impact
