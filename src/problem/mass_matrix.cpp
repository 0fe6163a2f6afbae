#include <cmath>
#include <impact/petsc/field_solver.hpp>
#include <impact/problem/mass_matrix.hpp>

namespace impact {

namespace {

void require_finite(Vec x) {
  const PetscReal size = Get(VecNorm)(x, NORM_INFINITY);
  if (!std::isfinite(size))
    throw UserError(ExitCode::data,
                    "the forces of which an acceleration is asked are not finite: a cell is inverted, or an "
                    "expression of a condition has no value there (1/(t-0.5), say, has none in its "
                    "derivatives); mend the initial state or the condition");
}

// [node][node] into m, then for each component of the displacement into K.
void cell_mass(const CellBatch& batch, double factor, CellMatrix& m, CellMatrix& K) {
  const int dim = batch.d.dim(), nodes = batch.nodes();
  const auto X = batch.vectors(batch.d.mesh.coordinates());
  batch.kernels.mass_matrix(batch.law, X.data(), m.zeroed(nodes));
  K.zeroed(nodes * dim);
  for (int i = 0; i < nodes; ++i)
    for (int j = 0; j < nodes; ++j)
      for (int k = 0; k < dim; ++k) K(i * dim + k, j * dim + k) = Batch(factor) * m(i, j);
}

} // namespace

void lump(int n, CellMatrix& m) {
  Batch all = 0, diagonal = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) all += m(i, j);
    diagonal += m(i, i);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) m(i, j) = i == j ? m(i, i) * all / diagonal : Batch(0.0);
}

void add_eroded_inertia(const CellBatch& batch, const NodalValues& acceleration, NodalValues& force) {
  CellMatrix m, M;
  cell_mass(batch, 1, m, M);
  for (int i = 0; i < force.size; ++i) {
    Batch sum = 0;
    for (int j = 0; j < force.size; ++j) sum += M(i, j) * acceleration.value[j];
    for (int l = 0; l < lanes; ++l)
      if (!batch.live(l)) force.value[i].set(l, force.value[i][l] + sum[l]);
  }
}

void keep_eroded_mass(const CellBatch& batch, double factor, CellMatrix& K) {
  CellMatrix m, M;
  cell_mass(batch, factor, m, M);
  const int dofs = batch.nodes() * batch.d.dim();
  for (int i = 0; i < dofs; ++i)
    for (int j = 0; j < dofs; ++j)
      for (int l = 0; l < lanes; ++l)
        if (!batch.live(l)) K(i, j).set(l, M(i, j)[l]);
}

double MassMatrix::add_to(SparseAssembly& assembly, double factor, bool masked) const {
  double diagonal = 0;
  CellMatrix m, K;
  // Masked, rigid bodies have none, and the tangent's pattern does not know their cells.
  const auto has_a_part = [&](const PointLaw& law) { return !masked || !law.rigid(); };
  for_each_batch(d_, has_a_part, [&](const CellBatch& batch) {
    cell_mass(batch, factor, m, K);
    if (masked && rows_.held_batches[at(batch.number_of_group)][at(batch.number)])
      K.mask(batch.vectors(rows_.free));
    diagonal += batch.sum(K.trace());
    assembly.add(batch.number_of_group, batch.number, K.data());
  });
  return diagonal;
}

void MassMatrix::build() {
  if (all_) return;
  for (const bool masked : {false, true}) {
    const auto assembly = make_assembly(d_.displacement, d_.mesh, d_.groups);
    add_to(*assembly, 1, masked);
    assembly->finish();
    if (masked) assembly->set_diagonal(rows_.massless, 1.0);
    Mat shared = assembly->matrix();
    check(PetscObjectReference(reinterpret_cast<PetscObject>(shared)));
    (masked ? free_ : all_) = Handle<Mat>(shared);
  }
  check(KSPCreate(d_.mesh.comm(), solver_.out()));
  check(KSPSetOptionsPrefix(solver_, "motion_mass_"));
  check(KSPSetType(solver_, KSPCG));
  const PC pc = Get(KSPGetPC)(solver_);
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(solver_, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  check(KSPSetOperators(solver_, free_, free_));
}

// Row sums of the consistent mass, int rho N_a, or of what `lump` makes of it: positive.
Handle<Vec> MassMatrix::make_lumped(const std::vector<double>* factors) const {
  std::vector<double> mass = d_.displacement.make_local();
  CellMatrix m;
  for_each_batch(d_, all_laws, [&](const CellBatch& batch) {
    const int dim = d_.dim(), nodes = batch.nodes();
    const auto X = batch.vectors(d_.mesh.coordinates());
    const Batch factor = factors != nullptr ? batch.load<1>(*factors).value[0] : Batch(1.0);
    batch.kernels.mass_matrix(batch.law, X.data(), m.zeroed(nodes));
    if (batch.group.shape->order() == 2) lump(nodes, m);
    auto at_nodes = batch.zero(dim);
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j < nodes; ++j)
        for (int k = 0; k < dim; ++k) at_nodes.value[i * dim + k] += factor * m(i, j);
    batch.forget_weightless(at_nodes);
    batch.scatter(at_nodes, mass);
  });
  Handle<Vec> lumped = d_.displacement.make_global();
  d_.displacement.add_to_global(mass, lumped);
  return lumped;
}

void MassMatrix::scale(const std::vector<double>* factors) {
  factors_ = factors;
  lumped_ = {};
}

Vec MassMatrix::lumped() {
  if (!lumped_) lumped_ = make_lumped(factors_);
  return lumped_;
}

Vec MassMatrix::true_lumped() {
  if (factors_ == nullptr) return lumped();
  if (!unscaled_) unscaled_ = make_lumped(nullptr);
  return unscaled_;
}

void MassMatrix::multiply(Vec x, Vec y) {
  if (d_.lumped_mass) return check(VecPointwiseMult(y, lumped(), x));
  build();
  check(MatMult(all_, x, y));
}

// x = x_c + x_f: the columns of prescribed entries go to the right-hand side. Rigid bodies share no node with
// others.
void MassMatrix::solve(Vec b, Vec x) {
  const int dim = d_.dim();
  const Handle<Vec> held = d_.displacement.make_global(), rhs = d_.displacement.make_global();
  std::vector<PetscInt> rows;
  std::vector<double> values(rows_.massless.size());
  for (int dof : rows_.massless) rows.push_back(d_.mesh.global_node()[at(dof / dim)] * dim + dof % dim);
  const auto count = static_cast<PetscInt>(rows.size());
  check(VecGetValues(x, count, rows.data(), values.data()));
  const auto set = [&](Vec target) {
    check(VecSetValues(target, count, rows.data(), values.data(), INSERT_VALUES));
    check(VecAssemblyBegin(target));
    check(VecAssemblyEnd(target));
  };
  if (d_.lumped_mass) {
    check(VecPointwiseDivide(x, b, lumped()));
    set(x);
    return require_finite(x);
  }
  build();
  set(held);
  check(MatMult(all_, held, rhs));
  check(VecAYPX(rhs, -1, b));
  set(rhs);
  require_finite(rhs);
  check(KSPSolve(solver_, rhs, x));
  const KSPConvergedReason reason = Get(KSPGetConvergedReason)(solver_);
  if (reason < 0)
    throw UserError(ExitCode::data,
                    "the mass matrix cannot be inverted: give every material a positive -material_<id>_rho");
}

} // namespace impact
