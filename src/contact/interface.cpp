#include <algorithm>
#include <array>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>

/// Forces and tangents of a ContactInterface, and which method gives its pressures.
namespace impact {

ObstaclePose ContactInterface::pose() const {
  return rigid_pose(settings_, mesh_->dim(), time_, outward_, totals(totals_->committed).obstacle);
}

void ContactInterface::use_method() {
  constraints_->press_by(method());
  friction_.press_by(method(), settings_.iterated);
}

void ContactInterface::set_time(double t, double mass_shift, bool stabilised, const ForceShare& share) {
  share_ = share;
  end_.reset();
  rows_.penalty->trial[EnforcementRows::least] = inertia_penalty_ * mass_shift;
  fallen_back_ = eased_ = false;
  use_method();
  at_rest_ = !(mass_shift > 0);
  method().begin_attempt(*constraints_, friction_);
  const StateRow* row = state_->find("u");
  Handle<Vec> u_n;
  if (row != nullptr) {
    u_n = constraints_->release_start();
    if (!u_n) u_n = layout_->make_global();
    layout_->to_global(row->committed, u_n);
  }
  time_ = t;
  const ObstaclePose now = pose();
  ContactForm& form = constraints_->form();
  form.begin_attempt(now, u_n ? u_n.get() : nullptr);
  if (form.search().restored()) use_new_nodes();
  const StepRule rule = at_rest_ || !u_n             ? StepRule::none
                        : constraints_->conserving() ? StepRule::exact_work
                        : stabilised                 ? StepRule::middle
                                                     : StepRule::none;
  shock_ = {};
  if (rule == StepRule::exact_work) {
    if (!last_force_) last_force_ = layout_->make_global();
    layout_->to_global(force_->committed, last_force_);
  }
  constraints_->begin(rule, std::move(u_n), now.moved);
}

void ContactInterface::begin_projection() {
  before_projection_ = {rows_.multiplier->trial, rows_.penalty->trial};
  std::fill(rows_.multiplier->trial.begin(), rows_.multiplier->trial.end(), 0.0);
  friction_.suspend(true);
  if (constraints_->rule() == StepRule::middle) constraints_->set_rule(StepRule::start);
}

void ContactInterface::end_projection() {
  rows_.multiplier->trial = std::move(before_projection_[0]);
  rows_.penalty->trial = std::move(before_projection_[1]);
  friction_.suspend(false);
  if (constraints_->rule() == StepRule::start) constraints_->set_rule(StepRule::middle);
}

bool ContactInterface::update_search(Vec u) {
  const Timed timed(Event::contact_search);
  const PairSearch::Outcome outcome =
      constraints_->form().update(u, [this](int index, double gap) { return method().presses(index, gap); });
  if (outcome != PairSearch::Outcome::kept) use_new_nodes();
  // Whether pressures stagnate is seen on the same constraints only.
  if (outcome == PairSearch::Outcome::other_pairs) last_change_ = HUGE_VAL;
  if (constraints_->rule() != StepRule::none) constraints_->find_start_gaps();
  return outcome == PairSearch::Outcome::other_pairs;
}

void ContactInterface::use_new_nodes() {
  ++searches_;
  constraints_->fetch_fixed();
  rigid_nodes_.fetch(nodes());
}

void ContactInterface::set_rigid_nodes(const RigidReduction& reduction, const std::vector<int>& body) {
  rigid_nodes_.set(*layout_, reduction, body);
  rigid_nodes_.fetch(nodes());
}

NodePairs ContactInterface::couplings() const {
  return rigid_nodes_.reduced(constraints_->form().couplings(), nodes());
}

// `see` is shown what is visited, and what presses may be less. Returns the force on the secondary side by
// this rank's constraints.
ContactInterface::Vector ContactInterface::add_residual(Vec u, double scale, Vec r,
                                                        const ConstraintFilter& wanted,
                                                        const ConstraintVisitor& see) const {
  const std::vector<double> values = nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const std::size_t m = constraints_->dim();
  const bool exact = constraints_->works_exactly();
  const double factor = exact ? 2 * scale : scale;
  Vector force{};
  const auto visitor = [&](Constraint& c) {
    if (see) see(c);
    if (!c.active) return;
    const auto add = [&](double times, const double* gradient) {
      for (int node : c.node) {
        add_components(m, times, gradient, &f[constraints_->dof(node, 0)]);
        gradient += m;
      }
    };
    const bool rubs = friction_.rubs(c);
    const Tangential t = rubs ? friction_.traction(c).value : Tangential{};
    add_force(c, t, force);
    add(-(factor * c.weight * c.pressure), c.gradient.data());
    for (std::size_t a = 0; rubs && a < constraints_->tangents(); ++a)
      add(factor * c.weight * t[a], &c.slip_gradient[c.gradient.size() * a]);
  };
  constraints_->visit(values, Derivatives::first, visitor, wanted);
  nodes().exchange.add(f, r);
  if (exact) check(VecAXPY(r, -scale, last_force_));
  return force;
}

void ContactInterface::add_carried(double scale, Vec r) const {
  const Handle<Vec> carried = layout_->make_global();
  layout_->to_global(carried_->committed, carried);
  check(VecAXPY(r, scale, carried));
}

void ContactInterface::add_stiffness_bound(const Constraint& c, std::vector<double>& stiff,
                                           StiffnessBound& bound) const {
  std::vector<double>& size = bound.size;
  const std::size_t m = constraints_->dim(), nodes = c.gradient.size() / m;
  const auto body_at = [&](std::size_t i) {
    return rigid_nodes_.empty() ? -1 : rigid_nodes_.body(c.node[i]);
  };
  const auto is_first_of_body = [&](std::size_t i) {
    for (std::size_t j = 0; j < i; ++j)
      if (body_at(j) == body_at(i)) return false;
    return true;
  };
  Constraint next = c; // deeper by as much as in the last step
  next.gap -= constraints_->form().search().motion();
  double sum = 0;
  size.assign(nodes, 0.0);
  for (std::size_t i = 0; i < nodes; ++i) {
    if (const int body = body_at(i); body < 0) {
      size[i] = std::sqrt(square_of_components(m, &c.gradient[m * i]));
    } else if (is_first_of_body(i)) {
      size[i] = push_on_body(c, body);
    }
    sum += size[i];
  }
  const double stiffness = c.weight * method().stiffness(next) * sum;
  for (std::size_t i = 0; i < nodes; ++i)
    if (const int body = body_at(i); body >= 0)
      bound.of_bodies[at(body)] += stiffness * size[i];
    else
      stiff[at(c.node[i])] += stiffness * size[i];
}

// The largest of the gap's and the slips' gradients by the motion of a rigid body, F by its translation and T
// by its rotation, of the norm F.F + m T . J^-1 T. What is prescribed does not give way.
double ContactInterface::push_on_body(const Constraint& c, int body) const {
  const std::size_t m = constraints_->dim(), n = c.gradient.size();
  const RigidPlace& place = rigid_nodes_.reduction().bodies()[at(body)];
  double largest = 0;
  const auto see = [&](std::span<const double> gradient) {
    Vector force{}, moment{};
    for (std::size_t i = 0; i < n / m; ++i) {
      if (rigid_nodes_.body(c.node[i]) != body) continue;
      Vector arm{}, g{};
      for (std::size_t k = 0; k < m; ++k) {
        arm[k] = nodes().X[constraints_->dof(c.node[i], k)] - place.centre[k];
        g[k] = gradient[m * i + k];
        force[k] += g[k];
      }
      const Vector turning = cross(place.trial * arm, g);
      for (std::size_t k = 0; k < 3; ++k) moment[k] += turning[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (place.held[k]) force[k] = 0;
      if (place.held[3 + k]) moment[k] = 0;
    }
    moment = transposed(place.trial) * moment;
    largest = std::max(largest, dot(force, force) + dot(moment, place.readiness * moment));
  };
  see(c.gradient);
  if (friction_.rubs(c))
    for (std::size_t a = 0; a < constraints_->tangents(); ++a) see(c.slip_gradient.subspan(n * a, n));
  return std::sqrt(largest);
}

void ContactInterface::add_gaps(Vec u, double scale, Vec r) const {
  const bool closes = method().closes_gaps();
  if (!closes && !friction_.reverses()) return;
  const std::vector<double> values = nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const std::size_t m = constraints_->dim();
  const double factor = constraints_->works_exactly() ? 2 * scale : scale;
  constraints_->visit(values, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    const std::size_t n = c.gradient.size();
    const double gap = closes ? method().stiffness(c) * c.gap : 0;
    const auto add = [&](double value, const double* gradient) {
      for (std::size_t i = 0; i < n; ++i)
        if (const std::size_t row = constraints_->dof(c.node[i / m], i % m); !constraints_->fixed(row))
          f[row] += factor * c.weight * (value * gradient[i]);
    };
    if (closes) add(gap, c.gradient.data());
    if (!friction_.rubs(c)) return;
    const Tangential missing = friction_.missing(c, gap);
    for (std::size_t a = 0; a < constraints_->tangents(); ++a) add(missing[a], &c.slip_gradient[n * a]);
  });
  nodes().exchange.add(f, r);
}

// scale w k dg dg, and with friction ds K ds, and -mu k ds.m dg where it slides.
void ContactInterface::tangent_block(const Constraint& c, double scale, std::vector<double>& block) const {
  const std::size_t n = c.gradient.size(), tangents = constraints_->tangents();
  block.resize(n * n);
  const double stiffness = method().stiffness(c), weight = scale * c.weight;
  const std::span<const double> gap_gradient = c.gap_gradient();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      block[n * i + j] = weight * stiffness * c.gradient[i] * gap_gradient[j];
  if (!friction_.rubs(c)) return;
  const Traction t = friction_.linear_traction(c);
  const std::array<Tangential, 2> K = friction_.slip_stiffness(c, t);
  std::vector<double> row(n); // derivatives of the traction
  for (std::size_t a = 0; a < tangents; ++a) {
    const double slide = friction_.coefficient() * t.direction[a] * stiffness;
    for (std::size_t j = 0; j < n; ++j) row[j] = -slide * gap_gradient[j];
    for (std::size_t b = 0; b < tangents; ++b)
      for (std::size_t j = 0; j < n; ++j) row[j] += K[a][b] * c.slip_gradient[n * b + j];
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) block[n * i + j] += weight * c.slip_gradient[n * a + i] * row[j];
  }
}

// The tangent, df/du times scale, in blocks over the dofs of nodes: what stiffness and friction make of the
// gradients, then the second variations.
void ContactInterface::visit_tangent(Vec u, double scale, const BlockVisitor& visitor) const {
  const Timed timed(Event::contact_tangent);
  const std::vector<double> values = nodes().displacement(u);
  std::vector<double> block;
  std::vector<double> of_gap(constraints_->count(), 0.0);
  std::vector<Tangential> of_slip(frictional() ? of_gap.size() : 0, Tangential{});
  const auto visit = [&](const Constraint& c) {
    if (!c.active) return;
    tangent_block(c, scale, block);
    visitor(c.node, block);
    of_gap[at(c.index)] = -scale * c.weight * c.pressure;
    if (!friction_.rubs(c)) return;
    const Tangential t = friction_.linear_traction(c).value;
    of_slip[at(c.index)] = {scale * c.weight * t[0], scale * c.weight * t[1]};
  };
  constraints_->visit(values, Derivatives::tangent, visit, constraints_->pressing());
  constraints_->visit_curvature(values, of_gap, of_slip, visitor);
}

void ContactInterface::add_tangent(Vec u, double scale, Mat K) const {
  const ContactNodes& nodes = this->nodes();
  const auto add = [&](std::span<const PetscInt> rows, std::span<const double> block) {
    const auto n = static_cast<PetscInt>(rows.size()); // PETSc leaves out those with a negative index
    check(MatSetValues(K, n, rows.data(), n, rows.data(), block.data(), ADD_VALUES));
  };
  if (rigid_nodes_.empty()) {
    std::vector<PetscInt> rows;
    const int dim = mesh_->dim();
    return visit_tangent(u, scale, [&](std::span<const int> on, std::span<const double> block) {
      rows.clear();
      for (int node : on)
        for (int k = 0; k < dim; ++k)
          rows.push_back(constraints_->fixed_flags(node)[k] ? -1 : dim * nodes.global[at(node)] + k);
      add(rows, block);
    });
  }
  std::vector<RigidReduction::Node> places;
  RigidReduction::Block reduced;
  return visit_tangent(u, scale, [&](std::span<const int> on, std::span<const double> block) {
    places.clear();
    for (int node : on)
      places.push_back({nodes.global[at(node)], rigid_nodes_.body(node), &nodes.X[constraints_->dof(node, 0)],
                        constraints_->fixed_flags(node)});
    reduced.build(rigid_nodes_.reduction(), places, block);
    add(reduced.rows(), reduced.values());
  });
}

void ContactInterface::multiply(Vec u, double scale, Vec du, Vec y) const {
  std::vector<double> d = nodes().exchange.gather(du), f(d.size(), 0.0);
  const auto leave_out = [&](std::vector<double>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (constraints_->fixed(i)) values[i] = 0;
  };
  leave_out(d);
  const std::size_t m = constraints_->dim();
  visit_tangent(u, scale, [&](std::span<const int> on, std::span<const double> block) {
    const std::size_t n = m * on.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        f[constraints_->dof(on[i / m], i % m)] += block[n * i + j] * d[constraints_->dof(on[j / m], j % m)];
  });
  leave_out(f);
  nodes().exchange.add(f, y);
}

ContactDemands ContactInterface::demands() const {
  return {method().closes_gaps(), method().augments(), frictional(), friction_.reverses()};
}

void ContactInterface::meet(bool loose, bool first_touch) {
  // The first touch takes the part of the penalty that augmentations begin with.
  double& penalty = rows_.penalty->trial[EnforcementRows::value];
  if (first_touch && !by_penalty_ && fallback_) fallback_->begin_attempt(*constraints_, friction_);
  if (by_penalty_ && !first_touch && method_->closes_gaps()) penalty = settings_.penalty;
  by_penalty_ = first_touch;
  fallen_back_ = fallen_back_ || (loose && constraints_->form().overdetermined());
  use_method();
}

void ContactInterface::ease(Vec goal) {
  EnforcementMethod& gentle = fallback_ ? *fallback_ : *method_;
  if (!at_rest_ || !gentle.augments()) return;
  // What grows on a body that flows meets it so in each step. Semismooth sets take it as it is.
  if ((fallback_ || !environment_.flows) && rows_.press_anywhere(mesh_->comm())) return;
  double depth = 0;
  constraints_->visit(goal, Derivatives::none, [&](const Constraint& c) {
    if (!(c.lambda > 0)) depth = std::max(depth, -c.gap);
  });
  eased_ = gentle.ease(*constraints_, max_over_ranks(mesh_->comm(), depth));
  use_method();
}

void ContactInterface::keep_multipliers() {
  before_solve_ = {};
  if (method().closes_gaps()) before_solve_ = {rows_.multiplier->trial, friction_.given()};
}

void ContactInterface::swap_multipliers() {
  if (before_solve_[0].empty()) return;
  rows_.multiplier->trial.swap(before_solve_[0]);
  friction_.given().swap(before_solve_[1]);
}

void ContactInterface::fall_back() {
  fallen_back_ = fallen_back_ || method().closes_gaps();
  use_method();
}

void ContactInterface::follow_slip(Vec u) {
  if (friction_.acts())
    constraints_->form().follow_slip(constraints_->place_of_gradients(nodes().displacement(u)));
}

void ContactInterface::start_newton(Vec u) {
  follow_slip(u);
  if (friction_.acts())
    constraints_->form().turn_slip_once(constraints_->place_of_gradients(nodes().displacement(u)));
  friction_.forget();
  friction_.follow(*constraints_, u);
  method().start_newton(*constraints_, u);
}

SetChange ContactInterface::after_newton_step(Vec u, Vec du, Vec next, bool follow) {
  const bool other = follow && friction_.follow(*constraints_, next);
  SetChange change = method().after_newton_step(*constraints_, friction_, u, du, next);
  change.other = change.other || other;
  follow_slip(next);
  return change;
}

} // namespace impact
