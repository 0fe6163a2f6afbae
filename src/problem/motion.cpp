#include "motion_batch.hpp"
#include <algorithm>
#include <cmath>
#include <impact/material/equation_of_state.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/erosion.hpp>
#include <impact/problem/motion.hpp>
#include <impact/problem/surface_load.hpp>

/// Forces of the balance of momentum. Its tangent: motion_tangent.cpp; the law at the solution:
/// motion_points.cpp.
namespace impact {

MotionProblem::MotionProblem(const Discretisation& discretisation, StateTable& state,
                             const BoundaryData& boundary, ContactSet& contacts, bool symmetric_tangent,
                             ContactOperator contact_operator, MatrixFormat format, RigidBodies* rigid,
                             bool solved)
    : d_(discretisation), state_(state), boundary_(boundary), contacts_(contacts),
      rigid_(rigid != nullptr ? rigid : &no_bodies_), symmetric_(symmetric_tangent), solved_(solved),
      operator_(contact_operator), format_(format), rows_(d_, boundary_, *rigid_), mass_(d_, rows_),
      tally_(d_.mesh.comm()), history_(state.row("history")),
      drive_(d_.has_drive() ? &state.row("drive") : nullptr),
      X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()), u_(d_.node_values(d_.dim())),
      a_(d_.node_values(d_.dim())), r_(d_.node_values(d_.dim())), dead_load_(d_.node_values(d_.dim())),
      body_load_(d_, boundary_), foundations_(d_, boundary_), soft_volume_(d_), balance_(d_),
      cells_diagonal_(d_.displacement.make_global()), diagonal_(d_.displacement.make_global()) {
  if (!rigid_->empty() && operator_ == ContactOperator::shell)
    throw UserError(ExitCode::usage, "-contact_operator shell: not with a rigid body (-material_" +
                                         rigid_->bodies().front().name +
                                         "_model rigid); take assembled, the default");
  rigid_->use_symmetric_tangent(symmetric_);
  if (const double softest = d_.softest_modulus(); std::isfinite(softest))
    reference_force_ = 1e-12 * std::min(softest * d_.small_facet(), foundations_.softest() * d_.small_cell());
  for (ContactInterface& contact : contacts_) {
    contact.constraints().set_fixed_dofs(boundary_.fixed_mask());
    if (!rigid_->empty()) contact.set_rigid_nodes(rigid_->reduction(), rigid_->body_of_node());
    contact.constraints().keep_symmetric(symmetric_ || format_ == MatrixFormat::sbaij);
  }
  rebuild_matrix();
  if (operator_ == ContactOperator::shell && !contacts_.empty()) make_shell();
}

void MotionProblem::expose_contacts(Vec u) {
  std::vector<char> eroded = d_.eroded.cell;
  eroded.resize(at(d_.mesh.cell_count()), 0);
  for (ContactInterface& contact : contacts_) contact.expose(eroded, u);
  if (solved_ && operator_ != ContactOperator::shell && !contacts_.empty()) rebuild_matrix();
}

void MotionProblem::begin(const MotionStep& step) {
  step_ = step;
  tally_.forget();
  if (solved_) rigid_->begin(step.t_n, step.t, *step.u_n, step.mass_shift > 0);
  for (ContactInterface& contact : contacts_)
    contact.set_time(step.t, step.mass_shift, step.stabilised, step.contact);
  carried_ = {};
  if (step_.contact.scale != 1 || step_.unilateral_scale != 1) carried_ = d_.displacement.make_global();
  if (step_.contact.scale != 1) contacts_.add_carried(1 - step_.contact.scale, carried_);
  if (step_.unilateral_scale != 1)
    check(VecAXPY(carried_, 1 - step_.unilateral_scale, d_.global_of(*step_.unilateral_carried)));
  std::fill(dead_load_.begin(), dead_load_.end(), 0.0);
  if (!boundary_.has_data()) return;
  evaluate([&] {
    for (const LoadedFacets& load : boundary_.tractions())
      add_dead_traction(
          live_facets(load), d_.frame, X_,
          [&](const double* x, double* value) { boundary_.traction(load, x, step_.t, value); }, dead_load_);
    boundary_.add_nodal_forces(step_.t, dead_load_);
    body_load_.add(step_.t, dead_load_);
    // Follower pressures are evaluated with every residual, where a rank must not fail alone: tried out here.
    std::vector<double> unused(dead_load_.size());
    add_pressures(X_, 1, unused);
  });
}

// What acted on a cell that has left acts on nothing.
const FacetTable& MotionProblem::live_facets(const LoadedFacets& load) {
  if (d_.eroded.cell.empty()) return load.facets;
  return live_load_ = d_.eroded.live(load.facets, d_.mesh.cell_start());
}

void MotionProblem::impose(Vec u) const {
  std::vector<double> local = d_.local_of(u);
  agree_on_errors(d_.mesh.comm(), [&] {
    boundary_.set_displacement(step_.t_n, step_.t, *step_.u_n, state_.row("prescribed_velocity").committed,
                               local);
  });
  d_.displacement.to_global(local, u);
  rigid_->retract(u);
}

void MotionProblem::forget_broken() {
  broken_ = {};
  inverted_.clear();
}

// The lanes that lost their meaning and may not leave for it.
int MotionProblem::note_inverted(const CellBatch& batch, const CellStatus& status) {
  int bad = batch.broken(status.bad);
  for (int l = 0; bad != 0 && l < batch.used(); ++l) {
    if ((bad & (1 << l)) == 0 || status.min_J[l] > 0 || !Erosion::may_invert(batch, l, step_.phi)) continue;
    inverted_.push_back(batch.first_cell + at(batch.number * lanes + l));
    bad &= ~(1 << l);
  }
  return bad;
}

MarkedCell MotionProblem::mark(const CellGroup& group, int batch, int lane, double value) const {
  MarkedCell cell{value, {}, group.material};
  const int nodes = node_count(group.shape), dim = d_.dim();
  for (int k = 0; k < dim; ++k) {
    for (int a = 0; a < nodes; ++a)
      cell.x[k] += X_[at(group.node[at((batch * nodes + a) * lanes + lane)] * dim + k)];
    cell.x[k] /= nodes;
  }
  return cell;
}

std::string MotionProblem::place_of(const MarkedCell& cell) const {
  return text_of("x=%s in material %s", place_text(cell.x, d_.dim(), "%.6g", ",").c_str(),
                 d_.materials[at(cell.material)].id.c_str());
}

// Notes the cell that lost its meaning most; false where one of the lanes `bad` did.
bool MotionProblem::check_cells(const CellGroup& group, int batch, int bad, const Batch& min_J) {
  for (int l = 0; l < lanes; ++l)
    if ((bad & (1 << l)) != 0 && (broken_.material < 0 || min_J[l] < broken_.value))
      broken_ = mark(group, batch, l, min_J[l]);
  return bad == 0;
}

MotionFields MotionProblem::step_fields(const std::vector<double>& u, const std::vector<double>* accel,
                                        const PointLaw& law) const {
  return {.X = &X_,
          .u = &u,
          .u_n = law.viscous() || step_.bulk.acts() ? step_.u_n : nullptr,
          .accel = accel,
          .phi = step_.phi,
          .theta = law.parameters.alpha_t != 0 || law.softens() ? step_.theta : nullptr,
          .warming = law.parameters.alpha_t != 0 ? step_.warming : nullptr,
          .history = keeps_history(law) ? &history_.committed : nullptr,
          .dt = step_.dt,
          .unilateral = step_.unilateral_scale,
          .failure = law.parameters.failure_softening > 0 ? &state_.row("jc_failure").committed : nullptr,
          .patches = &patches_};
}

PatchFields MotionProblem::patch_fields(const std::vector<double>& u, double unilateral) const {
  return {&u, step_.phi, step_.theta, &history_.committed, unilateral, step_.warming, &soft_volume_};
}

void MotionProblem::share(const std::vector<double>& u, double unilateral, PatchState& patches,
                          bool pressures) const {
  share_volumes(d_, patch_fields(u, unilateral), patches, pressures);
}

void MotionProblem::stiffen(Vec u, double part) {
  soft_volume_.stiffen(patch_fields(d_.local_of(u), step_.unilateral_scale), part);
}

void MotionProblem::foretell(Vec u, Vec end) {
  if (!soft_volume_.keeps_pressures()) return; // in every iteration of any solve
  soft_volume_.foretell(patch_fields(d_.local_of(u), step_.unilateral_scale), d_.local_of(end));
}

bool MotionProblem::add_cells(const std::vector<double>& u, const std::vector<double>* accel,
                              double unilateral, std::vector<double>& r) {
  forget_broken();
  share(u, unilateral, patches_);
  bool sound = true;
  for_each_batch(d_, deformable, [&](const CellBatch& batch) {
    const PointLaw& law = soft_volume_.law(batch);
    MotionFields fields = step_fields(u, accel, law);
    fields.unilateral = unilateral;
    const MotionBatch cells(batch, fields);
    auto force = batch.zero(d_.dim());
    const CellStatus status = batch.kernels.motion_residual(law, cells.in, force.data());
    note_inverted(batch, status);
    sound = check_cells(batch.group, batch.number, batch.broken(status.bad), status.min_J) && sound;
    batch.forget_eroded(force);
    if (batch.eroded != 0 && accel != nullptr) add_eroded_inertia(batch, cells.accel, force);
    batch.scatter(force, r);
  });
  return sound;
}

void MotionProblem::add_pressures(const std::vector<double>& u, double sign, std::vector<double>& r) {
  for (const LoadedFacets& load : boundary_.pressures())
    add_follower_pressure(
        live_facets(load), d_.frame, X_, u,
        [&](const double* x) { return sign * boundary_.scalar_value(load.condition, x, step_.t); }, r);
}

void MotionProblem::add_dashpots(const std::vector<double>& u, double sign, std::vector<double>& r) {
  if (!foundations_.damps() || step_.velocity_offset == nullptr) return;
  v_ = *step_.velocity_offset;
  for (std::size_t i = 0; i < v_.size(); ++i) v_[i] += step_.velocity_slope * u[i];
  foundations_.add_dashpots(v_, sign, r);
}

bool MotionProblem::residual(Vec u, Vec a, Vec f) {
  const Timed timed(Event::motion_residual);
  d_.displacement.to_local(u, u_);
  if (a)
    d_.displacement.to_local(a, a_);
  else
    std::fill(a_.begin(), a_.end(), 0.0);
  const std::vector<double>* accel = a ? &a_ : nullptr;
  for (std::size_t i = 0; i < r_.size(); ++i) r_[i] = -dead_load_[i];
  const bool sound = add_cells(u_, accel, step_.unilateral_scale, r_);
  add_pressures(u_, -1, r_);
  foundations_.add_springs(u_, -1, r_);
  add_dashpots(u_, -1, r_);
  check(VecSet(f, 0));
  d_.displacement.add_to_global(r_, f);
  contacts_.add_forces(u, step_.contact.scale, f);
  if (carried_) check(VecAXPY(f, 1, carried_));
  rigid_->reduce(u, f, accel);
  zero_dofs(f, d_.mesh, d_.dim(), rows_.prescribed);
  return all_ranks_agree(d_.mesh.comm(), sound);
}

void MotionProblem::projection_residual(Vec w, Vec u_tilde, double shift, Vec f) {
  const Timed timed(Event::motion_residual);
  const Handle<Vec> change = d_.displacement.make_global();
  check(VecWAXPY(change, -1, u_tilde, w));
  mass_.multiply(change, f);
  check(VecScale(f, shift));
  contacts_.add_forces(w, step_.contact.scale, f);
  rigid_->reduce(w, f);
  zero_dofs(f, d_.mesh, d_.dim(), rows_.prescribed);
}

void MotionProblem::parts(Vec u, ForceParts& parts) {
  const Timed timed(Event::motion_forces);
  const auto set = [&](Handle<Vec>& part) {
    if (!part) part = d_.displacement.make_global();
    put(r_, part);
  };
  d_.displacement.to_local(u, u_);
  const bool apart = step_.unilateral_carried != nullptr;
  std::fill(r_.begin(), r_.end(), 0.0);
  add_cells(u_, nullptr, apart ? 0 : 1, r_);
  set(parts.internal);
  if (apart) {
    std::fill(r_.begin(), r_.end(), 0.0);
    add_cells(u_, nullptr, 1, r_);
    set(parts.unilateral);
    check(VecAXPY(parts.unilateral, -1, parts.internal));
  }
  loads(u, parts.external);
  add_foundations(parts, true);
  if (!parts.contact) parts.contact = d_.displacement.make_global();
  check(VecSet(parts.contact, 0));
  contacts_.add_forces(u, -1, parts.contact);
}

// The sum of all ranks' parts.
void MotionProblem::put(const std::vector<double>& local, Vec force) const {
  check(VecSet(force, 0));
  d_.displacement.add_to_global(local, force);
}

void MotionProblem::loads(Vec u, Handle<Vec>& external) {
  if (!external) external = d_.displacement.make_global();
  if (!boundary_.has_data()) return check(VecSet(external, 0));
  if (boundary_.has(BcType::pressure)) d_.displacement.to_local(u, u_);
  r_ = dead_load_;
  add_pressures(u_, 1, r_);
  put(r_, external);
}

void MotionProblem::add_foundations(ForceParts& parts, bool dashpots) {
  if (foundations_.springs()) {
    std::fill(r_.begin(), r_.end(), 0.0);
    parts.sprung = foundations_.add_springs(u_, 1, r_);
    d_.displacement.add_to_global(r_, parts.external);
  }
  if (!foundations_.damps()) return;
  if (!parts.damping) parts.damping = d_.displacement.make_global();
  if (!dashpots) return check(VecSet(parts.damping, 0));
  std::fill(r_.begin(), r_.end(), 0.0);
  add_dashpots(u_, 1, r_);
  put(r_, parts.damping);
  check(VecAXPY(parts.external, 1, parts.damping));
}

std::string MotionProblem::broken_text() const {
  const double J = broken_.material < 0 ? HUGE_VAL : std::isfinite(broken_.value) ? broken_.value : -HUGE_VAL;
  const MarkedCell worst = of_least(d_.mesh.comm(), J, broken_);
  if (worst.material < 0) return "";
  const MaterialAssignment& material = d_.materials[at(worst.material)];
  const MaterialParameters& m = material.law.parameters;
  const bool beyond = has_state(m) && !within_state(m, worst.value - 1);
  const std::string text = text_of("%s (J=%.3g) at %s",
                                   worst.value <= 0 ? "cell inverted"
                                   : beyond ? "cell compressed beyond the end of its equation of state"
                                            : "law failed in a cell",
                                   worst.value, place_of(worst).c_str());
  // Compression in the plane goes into the thickness, which nothing holds there.
  const bool gives_way =
      d_.frame == Frame::plane_stress && m.damage != Damage::none && m.split == Split::volumetric;
  return gives_way ? text + "; broken sheets bear no pressure in their plane, but with -material_" +
                         material.id + "_split spectral"
                   : text;
}

} // namespace impact
