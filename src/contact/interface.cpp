#include <algorithm>
#include <array>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>

/// Forces and tangents of a ContactInterface.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The linear solves of the semismooth method weigh g = 0 by this multiple of the penalty: what they leave of
// a gap falls by about a thousandth per iteration.
constexpr double newton_weight = 1000;
// Its active constraints are those with lambda > c g, c this multiple of the penalty. Without curvature any c
// does; a small one keeps a pressed constraint whose gap is not zero yet for curvature alone.
constexpr double activity_weight = 1e-3;

bool all_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double v) { return std::isfinite(v); });
}

} // namespace

PressureLaw ContactInterface::law() const {
  if (!semismooth()) return {multiplier_->trial, penalty()};
  return {multiplier_->trial, activity_weight * penalty(), newton_weight * penalty(), true};
}

Tangential ContactInterface::held(const Constraint& c) const {
  Tangential t{};
  for (std::size_t i = 0; i < tangents(); ++i) t[i] = traction_->trial[tangents() * at(c.index) + i];
  return t;
}

Traction ContactInterface::traction(const Constraint& c) const {
  if (!rubs(c)) return {};
  const Tangential held = this->held(c);
  if (exact_work()) return step_traction(c).over;
  const double limit = settings_.friction * std::max(c.pressure, 0.0);
  const double eps = law().eps;
  Traction t = coulomb({held[0] + eps * c.slip[0], held[1] + eps * c.slip[1]}, limit);
  // The multiplier is the traction while the contact sticks; the slip only decides whether it does.
  if (semismooth() && !t.slides) t.value = held;
  return t;
}

Traction ContactInterface::linear_traction(const Constraint& c) const {
  Traction t = traction(c);
  if (slid_.empty() || !t.slides || !(inner(slid_[at(c.index)], t.direction) < 0)) return t;
  const double size = std::hypot(t.value[0], t.value[1]) + t.excess;
  return {{size * t.direction[0], size * t.direction[1]}, false, {}, 0};
}

Tangential ContactInterface::traction_to_keep(const Constraint& c) const {
  return exact_work() ? step_traction(c).end : traction(c).value;
}

double ContactInterface::turn_stiffness(const Constraint& c, const Traction& t) const {
  const double limit = std::hypot(t.value[0], t.value[1]), eps = law().eps;
  if (!semismooth()) return eps * limit / (limit + t.excess);
  // Newton's method on |q| t = mu p q, q = t + eps s, with t = mu p q/|q| in its matrix (Hueber, Stadler and
  // Wohlmuth 2008): the new t = mu p m + k (1 - m m)(s + ds), m = q/|q|, k = eps mu p/(|q| - mu p), which at
  // the solution is mu p/|s|. Where sliding sets in it acts as if it stuck.
  const double stick = law().stiffness(c.cover);
  return t.excess * stick > eps * limit ? eps * limit / t.excess : stick;
}

std::array<Tangential, 2> ContactInterface::slip_stiffness(const Constraint& c, const Traction& t) const {
  if (!t.slides) {
    const double stick = law().stiffness(c.cover);
    return {{{stick, 0}, {0, stick}}};
  }
  if (dim_ == 2) return {};
  const double k = turn_stiffness(c, t);
  const Tangential& m = t.direction;
  return {{{k * m[1] * m[1], -k * m[0] * m[1]}, {-k * m[0] * m[1], k * m[0] * m[0]}}};
}

void ContactInterface::tangent_block(const Constraint& c, double scale, TangentSpace& space) const {
  // scale w k dg dg, and with friction ds K ds, and -mu k ds.m dg where it slides.
  const std::size_t n = c.gradient.size();
  auto& [block, row] = space;
  block.resize(n * n);
  row.resize(n);
  const double stiffness = contact_stiffness(c), weight = scale * c.weight;
  const std::span<const double> gap_gradient = c.gap_gradient();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      block[n * i + j] = weight * stiffness * c.gradient[i] * gap_gradient[j];
  if (!rubs(c)) return;
  const Traction t = linear_traction(c);
  const std::array<Tangential, 2> K = slip_stiffness(c, t);
  const auto slip_gradient = [&](std::size_t direction) { return c.slip_gradient.subspan(n * direction, n); };
  for (std::size_t a = 0; a < tangents(); ++a) { // row: derivatives of the traction
    const double slide = settings_.friction * t.direction[a] * stiffness;
    for (std::size_t j = 0; j < n; ++j) row[j] = -slide * gap_gradient[j];
    for (std::size_t b = 0; b < tangents(); ++b)
      for (std::size_t j = 0; j < n; ++j) row[j] += K[a][b] * slip_gradient(b)[j];
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) block[n * i + j] += weight * slip_gradient(a)[i] * row[j];
  }
}

ContactStatus ContactInterface::visit_tangent(const std::vector<double>& u, double scale,
                                              const BlockVisitor& visitor) const {
  const Timed timed(Event::contact_tangent);
  TangentSpace space;
  std::vector<double> of_gap(multiplier_->trial.size(), 0.0);
  std::vector<Tangential> of_slip(traction_ != nullptr ? of_gap.size() : 0, Tangential{});
  const ContactStatus status = visit(u, Derivatives::tangent, [&](const Constraint& c) {
    if (!c.active) return;
    tangent_block(c, scale, space);
    visitor(c.node, space.block);
    of_gap[at(c.index)] = -scale * c.weight * c.pressure;
    if (!rubs(c)) return;
    const Tangential t = linear_traction(c).value;
    of_slip[at(c.index)] = {scale * c.weight * t[0], scale * c.weight * t[1]};
  });
  switch (step_.rule) {
  case StepRule::none:
    form_->visit_curvature(u, law(), {of_gap, of_slip}, visitor);
    break;
  case StepRule::start:
    break;
  case StepRule::middle: // which moves by half of what u does
    for (double& factor : of_gap) factor /= 2;
    for (Tangential& factor : of_slip) factor = {factor[0] / 2, factor[1] / 2};
    [[fallthrough]];
  case StepRule::exact_work: // the same half, of twice the force
    form_->visit_curvature(place_of_gradients(u), reaching_law(), {of_gap, of_slip}, visitor);
  }
  return status;
}

std::array<double, 3> ContactInterface::obstacle_displacement(double t) const {
  std::array<double, 3> displacement{};
  if (!settings_.rigid()) return displacement;
  for (std::size_t k = 0; k < at(dim_); ++k)
    if (settings_.rigid_motion[k]) displacement[k] = settings_.rigid_motion[k](t);
  return displacement;
}

ObstaclePose ContactInterface::pose_at(double t) const {
  const bool plane = settings_.primary == "plane", sphere = settings_.primary == "rigid_sphere";
  const std::array<double, 3> now = obstacle_displacement(t);
  ObstaclePose pose;
  pose.obstacle.shape = plane    ? RigidObstacle::Shape::plane
                        : sphere ? RigidObstacle::Shape::sphere
                                 : RigidObstacle::Shape::cylinder;
  pose.obstacle.radius = settings_.radius;
  for (std::size_t k = 0; k < 3; ++k) {
    pose.obstacle.point[k] = (plane ? settings_.plane_point : settings_.centre)[k] + now[k];
    pose.obstacle.direction[k] = (plane ? settings_.plane_normal : settings_.axis)[k];
    pose.moved[k] = now[k] - totals_->committed[at(2 * dim_ + 1) + k];
    pose.obstacle.outward[k] = outward_[k];
    pose.obstacle.pole[k] = pose.obstacle.point[k] + settings_.radius * outward_[k];
  }
  return pose;
}

void ContactInterface::set_time(double t, double mass_shift, bool stabilised) {
  penalty_->trial[2] = inertia_penalty_ * mass_shift;
  fallen_back_ = false;
  at_rest_ = !(mass_shift > 0);
  const StateRow* row = state_->find("u");
  Handle<Vec> u_n;
  if (row != nullptr) {
    u_n = layout_->make_global();
    layout_->to_global(row->committed, u_n);
  }
  time_ = t;
  form_->begin_attempt(pose_at(t), u_n ? u_n.get() : nullptr);
  if (form_->list_restored()) use_new_nodes();
  step_.rule = !(mass_shift > 0) || !u_n ? StepRule::none
               : conserving()            ? StepRule::exact_work
               : stabilised              ? StepRule::middle
                                         : StepRule::none;
  step_.shock = {};
  step_.u_n = std::move(u_n);
  if (exact_work()) {
    if (!step_.last_force) step_.last_force = layout_->make_global();
    layout_->to_global(force_->committed, step_.last_force);
  }
  if (step_.rule != StepRule::none) find_start_gaps();
}

bool ContactInterface::update_search(Vec u) {
  const Timed timed(Event::contact_search);
  const PairSearch::Outcome outcome = form_->update(u, law());
  if (outcome != PairSearch::Outcome::kept) use_new_nodes();
  // Whether pressures stagnate is seen on the same constraints only.
  if (outcome == PairSearch::Outcome::other_pairs) last_change_ = HUGE_VAL;
  if (step_.rule != StepRule::none) find_start_gaps();
  return outcome == PairSearch::Outcome::other_pairs;
}

void ContactInterface::use_new_nodes() {
  ++searches_;
  fetch_fixed();
  fetch_bodies();
}

void ContactInterface::fetch_fixed() {
  fixed_here_.assign(at(dim_) * form_->nodes().global.size(), 0);
  if (!fixed_) return;
  const std::vector<double> flags = form_->nodes().exchange.gather(fixed_);
  std::transform(flags.begin(), flags.end(), fixed_here_.begin(), [](double f) { return f > 0.5 ? 1 : 0; });
  const std::vector<int>& mine = form_->nodes().secondary;
  supported_ =
      multiplier_->support == Support::vertex && std::any_of(mine.begin(), mine.end(), [&](int node) {
        return std::any_of(&fixed_here_[dof(node, 0)], &fixed_here_[dof(node, 0)] + dim_,
                           [](char fixed) { return fixed != 0; });
      });
}

// On a plane of symmetry, and wherever the node of a constraint and what it faces are held alike, nothing
// slides: the traction along it would feel the bodies through the neighbours alone, and grow to its limit
// against slips that nothing can close.
void ContactInterface::hold_slip(const std::vector<double>& u, Constraint& c,
                                 std::vector<double>& gradient) const {
  const ContactNodes& nodes = form_->nodes();
  if (!c.slides || nodes.start.empty()) return;
  const std::size_t n = c.gradient.size(), mine = c.share.size();
  const auto own =
      static_cast<std::size_t>(std::max_element(c.share.begin(), c.share.end()) - c.share.begin());
  const auto moved = [&](std::size_t i) { return nodes.X[i] + u[i] - nodes.start[i]; };
  for (std::size_t k = 0; k < at(dim_); ++k) {
    const std::size_t row = dof(c.node[own], k);
    if (!fixed_here_[row] ||
        std::none_of(c.node.begin() + static_cast<std::ptrdiff_t>(mine), c.node.end(), [&](int other) {
          const std::size_t i = dof(other, k);
          return fixed_here_[i] && std::abs(moved(i) - moved(row)) <= 1e-9 * mean_length_;
        }))
      continue;
    // The direction in which the surfaces are held, in those of the slip.
    Tangential held{};
    double all = 0;
    for (std::size_t a = 0; a < tangents(); ++a) {
      held[a] = c.slip_gradient[n * a + at(dim_) * own + k];
      for (std::size_t m = 0; m < at(dim_); ++m)
        all += std::pow(c.slip_gradient[n * a + at(dim_) * own + m], 2);
    }
    const double size = std::hypot(held[0], held[1]);
    if (!(size * size * static_cast<double>(tangents()) > all / 4)) continue; // it lies across the surface
    if (c.slip_gradient.data() != gradient.data())
      gradient.assign(c.slip_gradient.begin(), c.slip_gradient.end());
    c.slip_gradient = gradient;
    for (double& component : held) component /= size;
    const double slip = inner(held, c.slip);
    for (std::size_t a = 0; a < tangents(); ++a) c.slip[a] -= slip * held[a];
    for (std::size_t j = 0; j < n; ++j) {
      double along = 0;
      for (std::size_t a = 0; a < tangents(); ++a) along += held[a] * gradient[n * a + j];
      for (std::size_t a = 0; a < tangents(); ++a) gradient[n * a + j] -= along * held[a];
    }
  }
}

void ContactInterface::fetch_bodies() {
  body_here_.clear();
  if (!body_) return;
  const std::vector<double> numbers = form_->nodes().exchange.gather(body_);
  for (std::size_t i = 0; i < numbers.size(); i += at(dim_))
    body_here_.push_back(static_cast<int>(numbers[i] + 0.5) - 1);
}

void ContactInterface::set_rigid_nodes(const RigidReduction& reduction, const std::vector<int>& body) {
  reduction_ = &reduction;
  body_ = layout_->make_global();
  std::vector<double> numbers = layout_->make_local();
  for (std::size_t node = 0; node < body.size(); ++node) numbers[at(dim_) * node] = body[node] + 1;
  layout_->to_global(numbers, body_);
  fetch_bodies();
}

NodePairs ContactInterface::couplings() const {
  NodePairs pairs = form_->couplings();
  if (body_here_.empty()) return pairs;
  // The unknowns of a body stand at two of its nodes.
  const ContactNodes& nodes = form_->nodes();
  const auto places = [&](PetscInt node, std::array<PetscInt, 2>& place) -> std::size_t {
    const int slot = nodes.slot(node);
    const int body = slot < 0 ? -1 : body_here_[at(slot)];
    place = body < 0 ? std::array<PetscInt, 2>{node, node} : reduction_->bodies()[at(body)].slot;
    return body < 0 ? 1 : 2;
  };
  NodePairs reduced;
  for (const auto& [i, j] : pairs) {
    std::array<PetscInt, 2> a{}, b{};
    const std::size_t of_a = places(i, a), of_b = places(j, b);
    for (std::size_t p = 0; p < of_a; ++p)
      for (std::size_t q = 0; q < of_b; ++q)
        if (a[p] != b[q]) reduced.emplace_back(std::min(a[p], b[q]), std::max(a[p], b[q]));
  }
  sort_unique(reduced);
  return reduced;
}

void ContactInterface::set_fixed_dofs(const std::vector<char>& fixed) {
  if (!fixed_) fixed_ = layout_->make_global();
  layout_->to_global(std::vector<double>(fixed.begin(), fixed.end()), fixed_);
  fetch_fixed();
}

ContactStatus ContactInterface::visit(const std::vector<double>& u, Derivatives derivatives,
                                      const ConstraintVisitor& visitor) const {
  const Timed timed(Event::contact_forces);
  ContactStatus seen;
  seen.finite = all_finite(u);
  seen.search_holds = form_->pairs_hold(form_->nodes().current(u));
  std::vector<double> held;
  const bool holds = supported_ && frictional();
  if (holds) derivatives = std::max(derivatives, Derivatives::first);
  const ConstraintVisitor counted = [&](const Constraint& c) {
    if (c.active) ++seen.active;
    seen.penetration = std::max(seen.penetration, -c.gap);
    if (!holds) return visitor(c);
    Constraint own = c;
    held.clear();
    hold_slip(u, own, held);
    visitor(own);
  };
  if (step_.rule != StepRule::none)
    visit_step(u, derivatives, counted);
  else if (conserving())
    visit_followed(u, derivatives, counted);
  else
    form_->visit(u, derivatives, law(), counted);
  return seen;
}

ContactStatus ContactInterface::add_residual(Vec u, double scale, Vec r) const {
  const std::vector<double> values = form_->nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const auto m = at(dim_);
  const double factor = exact_work() ? 2 * scale : scale;
  const ContactStatus status = visit(values, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    const std::size_t n = c.gradient.size();
    for (std::size_t i = 0; i < n; ++i)
      f[dof(c.node[i / m], i % m)] -= factor * c.weight * c.pressure * c.gradient[i];
    if (!rubs(c)) return;
    const Tangential t = traction(c).value;
    for (std::size_t i = 0; i < tangents() * n; ++i)
      f[dof(c.node[i % n / m], i % m)] += factor * c.weight * t[i / n] * c.slip_gradient[i];
  });
  form_->nodes().exchange.add(f, r);
  if (exact_work()) check(VecAXPY(r, -scale, step_.last_force));
  return status;
}

void ContactInterface::add_gaps(Vec u, double scale, Vec r) const {
  if (!semismooth() && !reverses_) return;
  const PressureLaw law = this->law();
  const std::vector<double> values = form_->nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const auto m = at(dim_);
  const double factor = exact_work() ? 2 * scale : scale;
  visit(values, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    const std::size_t n = c.gradient.size();
    const double gap = law.stiffness(c.cover) * c.gap;
    const auto add = [&](std::size_t i, double value) {
      if (const std::size_t row = dof(c.node[i % n / m], i % m); !fixed_here_[row])
        f[row] += factor * c.weight * value;
    };
    if (!semismooth()) {
      if (!rubs(c)) return;
      const Tangential now = traction(c).value, then = linear_traction(c).value;
      for (std::size_t i = 0; i < tangents() * n; ++i)
        add(i, (then[i / n] - now[i / n]) * c.slip_gradient[i]);
      return;
    }
    for (std::size_t i = 0; i < n; ++i) add(i, gap * c.gradient[i]);
    if (!rubs(c)) return;
    const Traction t = traction(c);
    const std::array<Tangential, 2> K = slip_stiffness(c, t);
    for (std::size_t a = 0; a < tangents(); ++a) {
      const double missing = inner(K[a], c.slip) - settings_.friction * t.direction[a] * gap;
      for (std::size_t i = 0; i < n; ++i) add(i, missing * c.slip_gradient[n * a + i]);
    }
  });
  form_->nodes().exchange.add(f, r);
}

ContactStatus ContactInterface::add_tangent(Vec u, double scale, Mat K) const {
  const ContactNodes& nodes = form_->nodes();
  if (!body_here_.empty()) return add_reduced_tangent(u, scale, K);
  std::vector<PetscInt> rows;
  return visit_tangent(
      nodes.displacement(u), scale, [&](std::span<const int> on, std::span<const double> block) {
        rows.clear();
        for (int node : on)
          for (std::size_t k = 0; k < at(dim_); ++k)
            // PETSc leaves out rows and columns with a negative index.
            rows.push_back(
                fixed_here_[dof(node, k)] ? -1 : dim_ * nodes.global[at(node)] + static_cast<PetscInt>(k));
        const auto n = static_cast<PetscInt>(rows.size());
        check(MatSetValues(K, n, rows.data(), n, rows.data(), block.data(), ADD_VALUES));
      });
}

ContactStatus ContactInterface::add_reduced_tangent(Vec u, double scale, Mat K) const {
  const ContactNodes& nodes = form_->nodes();
  std::vector<RigidReduction::Node> places;
  RigidReduction::Block reduced;
  return visit_tangent(nodes.displacement(u), scale,
                       [&](std::span<const int> on, std::span<const double> block) {
                         places.clear();
                         for (int node : on)
                           places.push_back({nodes.global[at(node)], body_here_[at(node)],
                                             &nodes.X[dof(node, 0)], &fixed_here_[dof(node, 0)]});
                         reduced.build(*reduction_, places, block);
                         const auto n = static_cast<PetscInt>(reduced.rows().size());
                         check(MatSetValues(K, n, reduced.rows().data(), n, reduced.rows().data(),
                                            reduced.values().data(), ADD_VALUES));
                       });
}

void ContactInterface::multiply(Vec u, double scale, Vec du, Vec y) const {
  const ContactNodes& nodes = form_->nodes();
  std::vector<double> d = nodes.exchange.gather(du), f(d.size(), 0.0);
  for (std::size_t i = 0; i < d.size(); ++i)
    if (fixed_here_[i]) d[i] = 0;
  const auto m = at(dim_);
  visit_tangent(nodes.displacement(u), scale, [&](std::span<const int> on, std::span<const double> block) {
    const std::size_t n = m * on.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        f[dof(on[i / m], i % m)] += block[n * i + j] * d[dof(on[j / m], j % m)];
  });
  for (std::size_t i = 0; i < f.size(); ++i)
    if (fixed_here_[i]) f[i] = 0;
  nodes.exchange.add(f, y);
}

void ContactInterface::start_newton(Vec u) {
  slid_.clear();
  slides_.clear();
  kind_.clear();
  reverses_ = false;
  follow_sliding(u);
  if (!semismooth()) return;
  // Surfaces that touch without a pressure so far: the first iterate must not pass through them, or has no
  // solution where nothing else holds a body.
  const double touch = 1e-8 * mean_length_, token = touch * penalty();
  std::vector<double> lambda = multiplier_->trial;
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    if (!(c.lambda > 0)) lambda[at(c.index)] = std::abs(c.gap) < touch ? token : 0.0;
  });
  share(lambda, 1);
  multiplier_->trial = std::move(lambda);
}

bool ContactInterface::follow_sliding(Vec u) {
  if (!frictional() || semismooth() || friction_suspended_) return false;
  slid_.swap(slides_);
  slid_.resize(multiplier_->trial.size(), Tangential{});
  slides_.assign(slid_.size(), Tangential{});
  std::vector<char> kind(slid_.size(), 0); // 1: sticks; 2: slides; 3: sticks and would slide the other way
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    if (!c.active) return;
    kind[at(c.index)] = 1;
    if (!rubs(c)) return;
    const Traction t = linear_traction(c);
    slides_[at(c.index)] = t.direction;
    kind[at(c.index)] = t.slides ? 2 : traction(c).slides ? 3 : 1;
  });
  std::array<int, 2> any = {kind != kind_ ? 1 : 0, std::count(kind.begin(), kind.end(), 3) > 0 ? 1 : 0};
  MPI_Allreduce(MPI_IN_PLACE, any.data(), 2, MPI_INT, MPI_MAX, mesh_->comm());
  kind_ = std::move(kind);
  reverses_ = any[1] == 1;
  return any[0] == 1;
}

bool ContactInterface::take_newton_step(Vec u, Vec du, Vec next) {
  const ContactNodes& nodes = form_->nodes();
  const PressureLaw law = this->law();
  const std::vector<double> d = nodes.exchange.gather(du);
  const auto m = at(dim_);
  std::vector<double> lambda(multiplier_->trial.size(), 0.0), held(tangents() * lambda.size(), 0.0);
  std::vector<char> active(lambda.size(), 0); // 1: sticks or has no friction; 2: slides
  const auto kind = [&](const Constraint& c) { return static_cast<char>(traction(c).slides ? 2 : 1); };
  visit(nodes.displacement(u), Derivatives::tangent, [&](const Constraint& c) {
    if (!c.active) return;
    const std::size_t n = c.gradient.size();
    const std::span<const double> gap_gradient = c.gap_gradient();
    double gap = c.gap;
    Tangential slip = c.slip;
    for (std::size_t i = 0; i < n; ++i) {
      const double change = d[dof(c.node[i / m], i % m)];
      gap += gap_gradient[i] * change;
      if (c.slides)
        for (std::size_t a = 0; a < tangents(); ++a) slip[a] += c.slip_gradient[n * a + i] * change;
    }
    lambda[at(c.index)] = c.lambda - law.stiffness(c.cover) * gap;
    active[at(c.index)] = kind(c);
    if (!rubs(c)) return;
    const Traction t = traction(c);
    const std::array<Tangential, 2> K = slip_stiffness(c, t);
    const double limit = settings_.friction * std::max(0.0, lambda[at(c.index)]);
    for (std::size_t a = 0; a < tangents(); ++a)
      held[tangents() * at(c.index) + a] =
          (t.slides ? limit * t.direction[a] : t.value[a]) + inner(K[a], slip);
  });
  share(lambda, 1);
  multiplier_->trial = std::move(lambda);
  if (traction_ != nullptr && !friction_suspended_) {
    share(held, dim_ - 1);
    traction_->trial = std::move(held);
  }
  std::vector<char> then(active.size(), 0);
  visit(nodes.displacement(next), Derivatives::none, [&](const Constraint& c) {
    if (c.active) then[at(c.index)] = kind(c);
  });
  return !all_ranks_agree(mesh_->comm(), then == active);
}

} // namespace impact
