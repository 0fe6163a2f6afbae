#include "owned_dofs.hpp"
#include <impact/problem/scalar_field.hpp>

namespace impact {

ScalarField::ScalarField(const Discretisation& d, const char* prefix, std::vector<char> held)
    : d_(d), prefix_(prefix), held_(std::move(held)), solution_(d.scalar.make_global()),
      residual_(d.scalar.make_global()), diagonal_(d.scalar.make_global()) {
  for (int node = 0; node < static_cast<int>(held_.size()); ++node) {
    free_.push_back(held_[at(node)] ? 0 : 1);
    if (held_[at(node)] && d_.mesh.owned(node)) owned_held_.push_back(node);
  }
}

void ScalarField::build_matrix(const std::vector<std::pair<PetscInt, PetscInt>>& extra) {
  assembly_ = make_assembly(d_.scalar, d_.mesh, d_.groups, extra);
}

void ScalarField::prepare(SNES snes, SNESType type, double atol, double rtol, int most_iterations) const {
  KSP ksp = nullptr;
  check(SNESSetType(snes, type));
  check(SNESSetTolerances(snes, atol, rtol, 0, most_iterations, PETSC_DEFAULT));
  check(SNESGetKSP(snes, &ksp));
  set_scalar_solver_defaults(ksp, prefix_);
}

void ScalarField::assemble(const std::vector<double>& r, Vec f) const {
  check(VecSet(f, 0));
  d_.scalar.add_to_global(r, f);
}

void ScalarField::zero_held(Vec f) const { zero_owned(f, d_.mesh, 1, owned_held_); }

void ScalarField::close_matrix(std::span<const SNES> solvers, Vec sizes) {
  double sum = 0;
  check(MatGetDiagonal(matrix(), diagonal_));
  check(VecSum(diagonal_, &sum));
  if (sizes) check(VecPointwiseMult(diagonal_, diagonal_, sizes));
  for (SNES snes : solvers) allow_rounding(snes, diagonal_);
  assembly_->set_diagonal(owned_held_,
                          sum > 0 ? sum / static_cast<double>(d_.mesh.global_node_count()) : 1.0);
}

} // namespace impact
