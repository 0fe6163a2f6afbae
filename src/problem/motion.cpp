#include "motion_batch.hpp"
#include "owned_dofs.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/kernel/measure.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/motion.hpp>
#include <impact/problem/surface_load.hpp>

namespace impact {

namespace {

double youngs_modulus(const MaterialParameters& p) { return 9 * p.K * p.G / (3 * p.K + p.G); }

template <int n> double trace(const Batch* K, int lanes_in_use) {
  Batch sum = K[0];
  for (int i = 1; i < n; ++i) sum += K[i * n + i];
  return lane_sum(sum, lanes_in_use);
}

} // namespace

MotionProblem::MotionProblem(const Discretisation& discretisation, StateTable& state,
                             const BoundaryData& boundary, ContactSet& contacts, bool symmetric_tangent,
                             ContactOperator contact_operator, MatrixFormat format, RigidBodies* rigid,
                             bool solved)
    : d_(discretisation), state_(state), boundary_(boundary), contacts_(contacts),
      rigid_(rigid != nullptr ? rigid : &no_bodies_), symmetric_(symmetric_tangent),
      operator_(contact_operator), format_(format), solved_(solved),
      X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()), u_(d_.node_values(d_.dim())),
      a_(d_.node_values(d_.dim())), r_(d_.node_values(d_.dim())), dead_load_(d_.node_values(d_.dim())),
      free_(d_.node_values(d_.dim()), 1.0), history_offset_(point_offsets(d_.groups, history_size(d_.frame))),
      drive_offset_(point_offsets(d_.groups, drive_size)), dissipation_offset_(point_offsets(d_.groups, 1)),
      stress_offset_(point_offsets(d_.groups, gradient_size(d_.frame))), balance_(d_) {
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (boundary_.fixed_mask()[i]) {
      free_[i] = 0;
      if (d_.mesh.owned(static_cast<int>(i) / d_.dim())) owned_fixed_.push_back(static_cast<int>(i));
    }
  no_row_ = boundary_.fixed_mask();
  identity_ = massless_ = owned_fixed_;
  if (!rigid_->empty()) {
    if (operator_ == ContactOperator::shell)
      throw UserError(ExitCode::usage, "-contact_operator shell: not with a rigid body (-material_" +
                                           rigid_->bodies().front().name +
                                           "_model rigid); take assembled, the default");
    identity_.insert(identity_.end(), rigid_->idle_dofs().begin(), rigid_->idle_dofs().end());
    for (std::size_t i = 0; i < free_.size(); ++i)
      if (const int node = static_cast<int>(i) / d_.dim(); rigid_->body_of_node()[at(node)] >= 0) {
        free_[i] = 0;
        no_row_[i] = 1;
        if (d_.mesh.owned(node)) massless_.push_back(static_cast<int>(i));
      }
    rigid_->use_symmetric_tangent(symmetric_);
  }
  for (const CellGroup& group : d_.groups) {
    std::vector<char>& held = held_batches_.emplace_back(at(group.batch_count), 0);
    const std::size_t size = group.node.size() / std::max<std::size_t>(held.size(), 1);
    for (std::size_t i = 0; i < group.node.size(); ++i)
      for (int k = 0; k < d_.dim(); ++k)
        if (free_[at(group.node[i] * d_.dim() + k)] == 0) held[i / size] = 1;
  }
  double softest = HUGE_VAL;
  for (const MaterialAssignment& m : d_.materials)
    if (!m.law.rigid()) softest = std::min(softest, youngs_modulus(m.law.parameters));
  if (softest < HUGE_VAL)
    reference_force_ = 1e-12 * softest * std::pow(d_.mesh.smallest_edge(), d_.dim() - 1);
  for (Handle<Vec>* vec : {&work_, &cells_diagonal_, &diagonal_}) *vec = d_.displacement.make_global();
  for (ContactInterface& contact : contacts_) {
    contact.set_fixed_dofs(boundary_.fixed_mask());
    if (!rigid_->empty()) contact.set_rigid_nodes(rigid_->reduction(), rigid_->body_of_node());
    contact.keep_symmetric(symmetric_ || format_ == MatrixFormat::sbaij);
  }
  rebuild_matrix();
  if (operator_ == ContactOperator::shell && !contacts_.empty()) make_shell();
}

void MotionProblem::rebuild_matrix() {
  const Timed timed(Event::motion_matrix);
  std::vector<std::pair<PetscInt, PetscInt>> extra;
  if (operator_ != ContactOperator::shell) extra = contacts_.couplings(); // else none is in the matrix
  const auto own = rigid_->couplings();
  extra.insert(extra.end(), own.begin(), own.end());
  assembly_.reset();
  assembly_.emplace(d_.displacement, d_.mesh, solved_ ? d_.groups : no_groups_, extra, format_);
  const Handle<MatNullSpace> modes = near_null_space(d_.displacement, d_.mesh);
  check(MatSetNearNullSpace(matrix(), modes));
}

void MotionProblem::make_shell() {
  PetscInt rows = 0;
  linearised_at_ = d_.displacement.make_global();
  check(VecGetLocalSize(linearised_at_, &rows));
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
  contacts_.apply_jacobian(linearised_at_, step_.contact_scale, x, y);
}

bool MotionProblem::update_contact(Vec u) {
  const bool changed = contacts_.update_search(u);
  if (operator_ == ContactOperator::shell) return false;
  if (changed) rebuild_matrix();
  return changed;
}

void MotionProblem::begin(const MotionStep& step) {
  step_ = step;
  rigid_->begin(step.t_n, step.t, *step.u_n, step.mass_shift > 0);
  contacts_.begin_attempt(step.t, step.mass_shift, step.stabilised);
  std::fill(dead_load_.begin(), dead_load_.end(), 0.0);
  agree_on_errors(d_.mesh.comm(), [&] {
    for (const LoadedFacets& load : boundary_.tractions())
      add_dead_traction(
          load.facets, d_.frame, X_,
          [&](const double* x, double* value) { boundary_.traction(load, x, step_.t, value); }, dead_load_);
    boundary_.add_nodal_forces(step_.t, dead_load_);
    has_body_force_ = boundary_.body_force(step_.t, body_);
    // Follower pressures are evaluated with every residual, where a rank must not fail alone: tried out here.
    std::vector<double> unused(dead_load_.size());
    add_pressures(X_, 1, unused);
  });
}

void MotionProblem::impose(Vec u) const {
  std::vector<double> local = d_.displacement.make_local();
  d_.displacement.to_local(u, local);
  boundary_.set_displacement(step_.t_n, step_.t, *step_.u_n, state_.row("prescribed_velocity").committed,
                             local);
  d_.displacement.to_global(local, u);
  rigid_->retract(u);
}

void MotionProblem::note_broken(const CellGroup& group, int batch, int bad, const Batch& min_J) {
  for (int l = 0; l < group.lanes_in_use(batch); ++l) {
    if (!(bad & (1 << l))) continue;
    if (broken_.material >= 0 && !(min_J[l] < broken_.min_J)) continue;
    broken_.min_J = min_J[l];
    broken_.material = group.material;
    const int nodes = node_count(group.shape), dim = d_.dim();
    for (int k = 0; k < dim; ++k) {
      double sum = 0;
      for (int a = 0; a < nodes; ++a) {
        const int node = group.node[at((batch * nodes + a) * lanes + l)];
        sum += X_[at(node * dim + k)];
      }
      broken_.x[k] = sum / nodes;
    }
  }
}

MotionFields MotionProblem::step_fields(const std::vector<double>& u, const std::vector<double>* accel,
                                        const PointLaw& law) const {
  return {&X_,
          &u,
          law.viscous() ? step_.u_n : nullptr,
          accel,
          step_.phi,
          law.parameters.alpha_t != 0 || law.softens() ? step_.theta : nullptr,
          keeps_history(law) ? &state_.row("history").committed : nullptr,
          step_.dt};
}

bool MotionProblem::add_cells(const std::vector<double>& u, const std::vector<double>* accel,
                              double unilateral, std::vector<double>& r) {
  broken_ = {};
  bool sound = true;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    if (rigid_cells(group)) continue;
    const PointLaw& law = d_.law(group);
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim;
      MotionFields fields = step_fields(u, accel, law);
      fields.unilateral = unilateral;
      for (int b = 0; b < group.batch_count; ++b) {
        const MotionBatch<Cell, frame> batch(group, b, fields, history_offset_[g]);
        std::array<Batch, at(Cell::nodes * dim)> force{};
        const CellStatus status = motion_residual<Cell, frame>(law, batch.in, force.data());
        const int used = (1 << group.lanes_in_use(b)) - 1;
        if (status.bad & used) {
          sound = false;
          note_broken(group, b, status.bad & used, status.min_J);
        }
        scatter_add<Cell, dim>(group, b, force.data(), r.data());
      }
    });
  }
  return sound;
}

void MotionProblem::add_pressures(const std::vector<double>& u, double sign, std::vector<double>& r) {
  for (const LoadedFacets& load : boundary_.pressures())
    add_follower_pressure(
        load.facets, d_.frame, X_, u,
        [&](const double* x) { return sign * boundary_.pressure(load, x, step_.t); }, r);
}

void MotionProblem::add_pressure_tangent(const std::vector<double>& u) {
  for (const LoadedFacets& load : boundary_.pressures())
    add_follower_pressure_tangent(
        load.facets, d_.frame, X_, u, [&](const double* x) { return -boundary_.pressure(load, x, step_.t); },
        no_row_, d_.mesh.global_node(), matrix());
}

bool MotionProblem::residual(Vec u, Vec a, Vec f) {
  const Timed timed(Event::motion_residual);
  d_.displacement.to_local(u, u_);
  const std::vector<double>* accel = nullptr;
  if (a) d_.displacement.to_local(a, a_);
  if (a || has_body_force_) {
    if (!a) std::fill(a_.begin(), a_.end(), 0.0);
    if (has_body_force_)
      for (std::size_t i = 0; i < a_.size(); ++i) a_[i] -= body_[i];
    accel = &a_;
  }
  for (std::size_t i = 0; i < r_.size(); ++i) r_[i] = -dead_load_[i];
  const bool sound = add_cells(u_, accel, step_.unilateral_scale, r_);
  add_pressures(u_, -1, r_);
  check(VecSet(f, 0));
  d_.displacement.add_to_global(r_, f);
  contacts_.add_forces(u, step_.contact_scale, f);
  rigid_->place(u);
  rigid_->reduce(f, accel);
  zero_fixed(f);
  return all_ranks_agree(d_.mesh.comm(), sound);
}

bool MotionProblem::tangent(Vec u, double mass_shift) {
  const Timed timed(Event::motion_tangent);
  broken_ = {};
  d_.displacement.to_local(u, u_);
  bool sound = true;
  double diagonal = 0;
  assembly_->zero();
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    if (rigid_cells(group)) continue;
    const PointLaw& law = d_.law(group);
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim, n = Cell::nodes * dim;
      MotionFields fields = step_fields(u_, nullptr, law);
      fields.unilateral = step_.unilateral_scale;
      for (int b = 0; b < group.batch_count; ++b) {
        MotionBatch<Cell, frame> batch(group, b, fields, history_offset_[g]);
        batch.in.mass_shift = mass_shift;
        batch.in.symmetric = symmetric_;
        std::array<Batch, at(n * n)> K;
        const CellStatus status = motion_tangent<Cell, frame>(law, batch.in, nullptr, K.data());
        const int used = (1 << group.lanes_in_use(b)) - 1;
        if (status.bad & used) {
          sound = false;
          note_broken(group, b, status.bad & used, status.min_J);
        }
        if (held_batches_[g][at(b)]) mask<n>(Gathered<Cell, dim>(group, b, free_).data(), K.data());
        diagonal += trace<n>(K.data(), group.lanes_in_use(b));
        assembly_->add(static_cast<int>(g), b, K.data());
      }
    });
  }
  rigid_->place(u);
  close_tangent(u, true, diagonal, mass_shift);
  return all_ranks_agree(d_.mesh.comm(), sound);
}

void MotionProblem::close_tangent(Vec u, bool pressures, double diagonal, double mass_shift) {
  assembly_->finish();
  check(MatGetDiagonal(matrix(), cells_diagonal_));
  if (!contacts_.empty() || !boundary_.pressures().empty() || !rigid_->empty()) {
    rigid_->add_tangent(mass_shift, matrix());
    if (pressures) add_pressure_tangent(u_);
    if (shell_)
      check(VecCopy(u, linearised_at_));
    else
      contacts_.add_jacobian(u, step_.contact_scale, matrix());
    check(MatAssemblyBegin(matrix(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix(), MAT_FINAL_ASSEMBLY));
  }
  check(MatGetDiagonal(matrix(), diagonal_));
  balance_.note_tangent(u, cells_diagonal_, diagonal_);
  // Prescribed rows were masked out; the mean of the cells' other diagonals keeps the condition of the
  // matrix.
  double sums[2] = {diagonal, -static_cast<double>(massless_.size())};
  MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, d_.mesh.comm());
  const double free_dofs = sums[1] + static_cast<double>(d_.mesh.global_node_count() * d_.dim());
  assembly_->set_diagonal(identity_, free_dofs > 0 && sums[0] > 0 ? sums[0] / free_dofs : 1.0);
}

void MotionProblem::zero_fixed(Vec f) const { zero_owned(f, d_.mesh, d_.dim(), owned_fixed_); }

void MotionProblem::projection_residual(Vec w, Vec u_tilde, double shift, Vec f) {
  const Timed timed(Event::motion_residual);
  check(VecWAXPY(work_, -1, u_tilde, w));
  mass_multiply(work_, f);
  check(VecScale(f, shift));
  contacts_.add_forces(w, step_.contact_scale, f);
  rigid_->place(w);
  rigid_->reduce(f);
  zero_fixed(f);
}

void MotionProblem::projection_tangent(Vec w, double shift) {
  const Timed timed(Event::motion_tangent);
  assembly_->zero();
  rigid_->place(w);
  close_tangent(w, false, add_mass(*assembly_, shift, true), shift);
}

bool MotionProblem::advance(Vec u, Increments& sums, const HeatRows& heat) {
  const Timed timed(Event::motion_points);
  d_.displacement.to_local(u, u_);
  StateRow& history = state_.row("history");
  StateRow& drive = state_.row("drive");
  bool sound = true;
  const std::size_t materials = d_.materials.size();
  std::vector<double> total(3 + 2 * materials, 0.0);
  const bool apart = heat.stress && step_.unilateral_scale != 1;
  double least = 0;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    if (rigid_cells(group)) continue;
    const PointLaw& law = d_.law(group);
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      MotionFields fields = step_fields(u_, nullptr, law);
      if (apart) fields.unilateral = 0;
      if (law.softens()) fields.drive = &drive.committed;
      for (int b = 0; b < group.batch_count; ++b) {
        const MotionBatch<Cell, frame> batch(group, b, fields, history_offset_[g], drive_offset_[g]);
        PointValues<Cell, history_size(frame)> next;
        PointValues<Cell, drive_size> driving;
        PointValues<Cell, 1> dissipation;
        PointValues<Cell, gradient_size(frame)> stress;
        StepSums step_sums;
        const HeatFeed feed{heat.dissipation ? dissipation.data() : nullptr,
                            heat.stress ? stress.data() : nullptr};
        Batch* const trial = keeps_history(law) ? next.data() : nullptr;
        if (apart && heat.step_stress) {
          MotionInput in = batch.in;
          in.unilateral = 2;
          StepSums unused;
          motion_advance<Cell, frame>(law, in, trial, nullptr, unused, {nullptr, stress.data()});
          stress.store(*heat.step_stress, stress_offset_[g], b);
        }
        const CellStatus status =
            motion_advance<Cell, frame>(law, batch.in, trial, driving.data(), step_sums, feed);
        const int used = group.lanes_in_use(b);
        sound = sound && (status.bad & ((1 << used) - 1)) == 0;
        if (keeps_history(law)) next.store(history.trial, history_offset_[g], b);
        driving.store(drive.trial, drive_offset_[g], b);
        if (heat.dissipation) dissipation.store(*heat.dissipation, dissipation_offset_[g], b);
        if (heat.stress) stress.store(*heat.stress, stress_offset_[g], b);
        if (heat.step_stress && !apart) stress.store(*heat.step_stress, stress_offset_[g], b);
        total[0] += lane_sum(step_sums.plastic_dissipation, used);
        total[1] += lane_sum(step_sums.viscous_dissipation, used);
        total[2] += lane_sum(step_sums.plastic_work, used);
        const auto m = at(group.material);
        total[3 + m] += lane_sum(step_sums.plastic_dissipation, used);
        total[3 + materials + m] += lane_sum(step_sums.viscous_dissipation, used);
        for (int l = 0; l < used; ++l) least = std::min(least, step_sums.least_dissipation[l]);
      }
    });
  }
  MPI_Allreduce(MPI_IN_PLACE, total.data(), static_cast<int>(total.size()), MPI_DOUBLE, MPI_SUM,
                d_.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE, MPI_MIN, d_.mesh.comm());
  const auto part = total.begin() + 3, half = part + static_cast<std::ptrdiff_t>(materials);
  sums = {total[0], total[1], total[2], least, {part, half}, {half, total.end()}};
  return all_ranks_agree(d_.mesh.comm(), sound);
}

void MotionProblem::parts(Vec u, ForceParts& parts) {
  const Timed timed(Event::motion_forces);
  for (Handle<Vec>* part : {&parts.internal, &parts.external, &parts.contact})
    if (!*part) *part = d_.displacement.make_global();
  d_.displacement.to_local(u, u_);
  const bool apart = step_.unilateral_scale != 1;
  std::fill(r_.begin(), r_.end(), 0.0);
  add_cells(u_, nullptr, apart ? 0 : 1, r_);
  check(VecSet(parts.internal, 0));
  d_.displacement.add_to_global(r_, parts.internal);
  if (apart) {
    if (!parts.unilateral) parts.unilateral = d_.displacement.make_global();
    std::fill(r_.begin(), r_.end(), 0.0);
    add_cells(u_, nullptr, 1, r_);
    check(VecSet(parts.unilateral, 0));
    d_.displacement.add_to_global(r_, parts.unilateral);
    check(VecAXPY(parts.unilateral, -1, parts.internal));
  }

  r_ = dead_load_;
  add_pressures(u_, 1, r_);
  check(VecSet(parts.external, 0));
  d_.displacement.add_to_global(r_, parts.external);
  if (has_body_force_) {
    Handle<Vec> f = d_.displacement.make_global(), Mf = d_.displacement.make_global();
    d_.displacement.to_global(body_, f);
    mass_multiply(f, Mf);
    check(VecAXPY(parts.external, 1, Mf));
  }

  check(VecSet(parts.contact, 0));
  contacts_.add_forces(u, -1, parts.contact);
}

double MotionProblem::book_rigid_reactions(Vec u, Vec acceleration, double factor) {
  if (rigid_->empty()) return 0;
  ForceParts forces;
  parts(u, forces);
  check(VecScale(forces.external, -1));
  check(VecAXPY(forces.external, -step_.contact_scale, forces.contact));
  if (acceleration) d_.displacement.to_local(acceleration, a_);
  return rigid_->book_reactions(u, forces.external, acceleration ? &a_ : nullptr, factor);
}

double MotionProblem::add_mass(SparseAssembly& assembly, double factor, bool masked) const {
  double diagonal = 0;
  for (std::size_t g = 0; g < d_.groups.size(); ++g) {
    const CellGroup& group = d_.groups[g];
    const PointLaw& law = d_.law(group);
    with_shape(group, d_.frame, [&]<class Cell, Frame frame>() {
      constexpr int dim = Cell::dim, nodes = Cell::nodes, n = nodes * dim;
      for (int b = 0; b < group.batch_count; ++b) {
        const Gathered<Cell, dim> X(group, b, X_);
        std::array<Batch, at(nodes * nodes)> m{};
        mass_matrix<Cell, frame>(law, X.data(), m.data());
        std::array<Batch, at(n * n)> K{};
        for (int i = 0; i < nodes; ++i)
          for (int j = 0; j < nodes; ++j)
            for (int k = 0; k < dim; ++k)
              K[at((i * dim + k) * n + j * dim + k)] = Batch(factor) * m[at(i * nodes + j)];
        if (masked && held_batches_[g][at(b)]) mask<n>(Gathered<Cell, dim>(group, b, free_).data(), K.data());
        diagonal += trace<n>(K.data(), group.lanes_in_use(b));
        assembly.add(static_cast<int>(g), b, K.data());
      }
    });
  }
  return diagonal;
}

void MotionProblem::build_mass() {
  if (mass_) return;
  for (const bool masked : {false, true}) {
    SparseAssembly assembly(d_.displacement, d_.mesh, d_.groups);
    add_mass(assembly, 1, masked);
    assembly.finish();
    if (masked) assembly.set_diagonal(massless_, 1.0);
    Mat shared = assembly.matrix();
    check(PetscObjectReference(reinterpret_cast<PetscObject>(shared)));
    (masked ? mass_free_ : mass_) = Handle<Mat>(shared);
  }
  check(KSPCreate(d_.mesh.comm(), mass_solver_.out()));
  check(KSPSetOptionsPrefix(mass_solver_, "motion_mass_"));
  check(KSPSetType(mass_solver_, KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(mass_solver_, &pc));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(mass_solver_, 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  check(KSPSetOperators(mass_solver_, mass_free_, mass_free_));
}

void MotionProblem::mass_multiply(Vec x, Vec y) {
  build_mass();
  check(MatMult(mass_, x, y));
}

void MotionProblem::mass_solve(Vec b, Vec x) {
  build_mass();
  // x = x_c + x_f: the columns of prescribed entries go to the right-hand side. Rigid bodies share no node
  // with others.
  const int dim = d_.dim();
  Handle<Vec> held = d_.displacement.make_global(), rhs = d_.displacement.make_global();
  std::vector<PetscInt> rows;
  std::vector<double> values;
  PetscInt start = 0;
  check(VecGetOwnershipRange(x, &start, nullptr));
  const double* entries = nullptr;
  check(VecGetArrayRead(x, &entries));
  for (int dof : massless_) {
    const PetscInt row = d_.mesh.global_node()[at(dof / dim)] * dim + dof % dim;
    rows.push_back(row);
    values.push_back(entries[row - start]);
  }
  check(VecRestoreArrayRead(x, &entries));
  const auto set = [&](Vec target) {
    check(
        VecSetValues(target, static_cast<PetscInt>(rows.size()), rows.data(), values.data(), INSERT_VALUES));
    check(VecAssemblyBegin(target));
    check(VecAssemblyEnd(target));
  };
  set(held);
  check(MatMult(mass_, held, rhs));
  check(VecAYPX(rhs, -1, b));
  set(rhs);
  PetscReal size = 0;
  check(VecNorm(rhs, NORM_INFINITY, &size));
  if (!std::isfinite(size))
    throw UserError(ExitCode::data,
                    "the forces of which an acceleration is asked are not finite: a cell is inverted, or an "
                    "expression of a condition has no value there (1/(t-0.5), say, has none in its "
                    "derivatives); mend the initial state or the condition");
  check(KSPSolve(mass_solver_, rhs, x));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(mass_solver_, &reason));
  if (reason < 0)
    throw UserError(ExitCode::data,
                    "the mass matrix cannot be inverted: give every material a positive -material_<id>_rho");
}

std::string MotionProblem::broken_text() const {
  // The worst cell of all ranks speaks.
  struct {
    double J;
    int rank;
  } mine, worst;
  MPI_Comm_rank(d_.mesh.comm(), &mine.rank);
  mine.J = broken_.material < 0 ? HUGE_VAL : std::isfinite(broken_.min_J) ? broken_.min_J : -HUGE_VAL;
  MPI_Allreduce(&mine, &worst, 1, MPI_DOUBLE_INT, MPI_MINLOC, d_.mesh.comm());
  if (worst.J == HUGE_VAL) return "";
  double data[5] = {broken_.min_J, broken_.x[0], broken_.x[1], broken_.x[2],
                    static_cast<double>(broken_.material)};
  MPI_Bcast(data, 5, MPI_DOUBLE, worst.rank, d_.mesh.comm());
  char text[240];
  const char* what = data[0] <= 0 ? "cell inverted" : "law failed in a cell";
  const auto& id = d_.materials[static_cast<std::size_t>(data[4])].law.parameters.id;
  if (d_.dim() == 2)
    std::snprintf(text, sizeof(text), "%s (J=%.3g) at x=(%.6g,%.6g) in material %s", what, data[0], data[1],
                  data[2], id.c_str());
  else
    std::snprintf(text, sizeof(text), "%s (J=%.3g) at x=(%.6g,%.6g,%.6g) in material %s", what, data[0],
                  data[1], data[2], data[3], id.c_str());
  return text;
}

} // namespace impact
