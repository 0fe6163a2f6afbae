#include <algorithm>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/scalar_field.hpp>

namespace impact {

namespace {

void set_default(const std::string& option, const char* value) {
  PetscBool set = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, ("-" + option).c_str(), &set));
  if (!set) check(PetscOptionsSetValue(nullptr, ("-" + option).c_str(), value));
}

CellGroup by_corners(const CellGroup& group) {
  CellGroup linear = group;
  linear.shape = impact::linear(group.shape);
  linear.node.clear();
  for (int b = 0; b < group.batch_count; ++b) {
    const int* nodes = batch_nodes(group, b);
    linear.node.insert(linear.node.end(), nodes, nodes + linear.shape->nodes * lanes);
  }
  return linear;
}

} // namespace

bool bounds_fail(const DamageScenario& settings, const Mesh& mesh) {
  const auto negative = [&](Shape shape) {
    double integral = 0; // of the first corner's function
    for (int q = 0; q < shape->points; ++q) integral += shape->weight[q] * shape->N[q * shape->nodes];
    return integral < -1e-8 && mesh.has_shape(shape);
  };
  return settings.bounds == DamageBounds::vi && std::ranges::any_of(known_shapes(), negative);
}

bool has_linear_damage(const DamageScenario& settings, const Mesh& mesh) {
  return settings.order == 1 || (settings.order == 0 && bounds_fail(settings, mesh));
}

ScalarField::ScalarField(const Discretisation& d, std::vector<char> held, bool linear)
    : d_(d), held_(std::move(held)), solution_(d.scalar.make_global()), residual_(d.scalar.make_global()),
      diagonal_(d.scalar.make_global()) {
  if (linear && d.mesh.order() == 2) {
    middles_.emplace(d.mesh);
    for (const CellGroup& group : d.groups) {
      corner_groups_.push_back(by_corners(group));
      auto& around = around_.emplace_back();
      for (int a = 0; a < group.shape->nodes; ++a) around.push_back(corners_around(group.shape, a));
    }
    for (int node = 0; node < static_cast<int>(held_.size()); ++node)
      if (middles_->is_middle(node)) held_[at(node)] = 1;
  }
  for (int node = 0; node < static_cast<int>(held_.size()); ++node) {
    free_.push_back(held_[at(node)] ? 0 : 1);
    if (held_[at(node)] && d_.mesh.owned(node)) owned_held_.push_back(node);
  }
}

void ScalarField::build_matrix(const std::vector<std::pair<PetscInt, PetscInt>>& extra) {
  assembly_ = make_assembly(d_.scalar, d_.mesh, middles_ ? corner_groups_ : d_.groups, extra);
}

void ScalarField::add(const CellBatch& batch, CellMatrix& K) {
  CellMatrix* sum = &K;
  if (middles_) {
    const auto& around = around_[at(batch.number_of_group)];
    of_corners_.zeroed(batch.group.shape->corners());
    for (int a = 0; a < batch.nodes(); ++a)
      for (int b = 0; b < batch.nodes(); ++b) {
        const auto &rows = around[at(a)], &columns = around[at(b)];
        const Batch share = (1.0 / static_cast<double>(rows.size() * columns.size())) * K(a, b);
        for (const int i : rows)
          for (const int j : columns) of_corners_(i, j) += share;
      }
    sum = &of_corners_;
  }
  sum->mask(batch.scalars(free_)); // the corners of a cell are its first nodes
  assembly_->add(batch.number_of_group, batch.number, sum->data());
}

void ScalarField::prepare(SNES snes, SNESType type, double atol, double rtol, int most_iterations,
                          double width) const {
  check(SNESSetType(snes, type));
  check(SNESSetTolerances(snes, atol, rtol, 0, most_iterations, PETSC_DEFAULT));
  const KSP ksp = Get(SNESGetKSP)(snes);
  check(KSPSetType(ksp, KSPCG));
  check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  const PC pc = Get(KSPGetPC)(ksp);
  int ranks = 1;
  MPI_Comm_size(d_.mesh.comm(), &ranks);
  check(KSPCGUseSingleReduction(ksp, ranks > 1 ? PETSC_TRUE : PETSC_FALSE));
  // What a step by central differences changes reaches no farther than a few cells.
  if (d_.lumped_mass) return check(PCSetType(pc, PCSOR));
  const std::string prefix = Get(SNESGetOptionsPrefix)(snes);
  if (width > 10 * d_.mesh.smallest_edge()) {
    check(PCSetType(pc, PCHYPRE));
    const std::string amg = prefix + "pc_hypre_boomeramg_";
    set_default(amg + "strong_threshold", "0.5");
    set_default(amg + "agg_nl", "1");
    return;
  }
  if (ranks == 1) return check(PCSetType(pc, PCICC));
  // Conjugate gradients want symmetric blocks; bjacobi would factorise them by ILU, and those of the bounded
  // solve are parts of the matrix that nothing but an option reaches.
  check(PCSetType(pc, PCBJACOBI));
  set_default(prefix + "sub_pc_type", "icc");
}

void ScalarField::to_local(Vec x, std::vector<double>& values) const {
  d_.scalar.to_local(x, values);
  fill_middles(values);
}

void ScalarField::assemble(std::vector<double>& r, Vec f) const {
  fold_middles(r);
  check(VecSet(f, 0));
  d_.scalar.add_to_global(r, f);
}

void ScalarField::zero_held(Vec f) const { zero_dofs(f, d_.mesh, 1, owned_held_); }

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
