#include <algorithm>
#include <array>
#include <cmath>
#include <impact/contact/interface.hpp>
#include <impact/petsc/error.hpp>

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

Traction ContactInterface::traction(const Constraint& c) const {
  if (!rubs(c)) return {};
  const double held = traction_->trial[at(c.index)], limit = settings_.friction * std::max(c.pressure, 0.0);
  if (!semismooth()) return coulomb(held + penalty() * c.slip, limit);
  // The multiplier is the traction while the contact sticks; the slip only decides whether it does.
  Traction t = coulomb(held + activity_weight * penalty() * c.slip, limit);
  if (t.direction == 0) t.value = held;
  return t;
}

void ContactInterface::tangent_block(const Constraint& c, double scale, std::vector<double>& block) const {
  // scale w k dg dg, and with friction k ds ds where it sticks, -mu k ds dg where it slides.
  const std::size_t n = c.gradient.size();
  block.resize(n * n);
  const double stiffness = contact_stiffness(c), weight = scale * c.weight;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) block[n * i + j] = weight * stiffness * c.gradient[i] * c.gradient[j];
  if (!rubs(c)) return;
  const Traction t = traction(c);
  const double stick = t.direction == 0 ? stiffness : 0;
  const double slide = settings_.friction * t.direction * stiffness;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      block[n * i + j] += weight * c.slip_gradient[i] * (stick * c.slip_gradient[j] - slide * c.gradient[j]);
}

ContactStatus ContactInterface::visit_tangent(const std::vector<double>& u, double scale,
                                              const BlockVisitor& visitor) const {
  std::vector<double> block, of_gap(multiplier_->trial.size(), 0.0);
  std::vector<double> of_slip(traction_ != nullptr ? of_gap.size() : 0, 0.0);
  const ContactStatus status = visit(u, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    tangent_block(c, scale, block);
    visitor(c.node, block);
    of_gap[at(c.index)] = -scale * c.weight * c.pressure;
    if (rubs(c)) of_slip[at(c.index)] = scale * c.weight * traction(c).value;
  });
  if (step_.under_way)
    form_->visit_curvature(middle(u), reaching_law(), {of_gap, of_slip}, visitor);
  else
    form_->visit_curvature(u, law(), {of_gap, of_slip}, visitor);
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
  }
  return pose;
}

void ContactInterface::set_time(double t, double mass_shift) {
  penalty_->trial[2] = inertia_penalty_ * mass_shift;
  fallen_back_ = false;
  const StateRow* row = state_->find("u");
  Handle<Vec> u_n;
  if (row != nullptr) {
    u_n = layout_->make_global();
    layout_->to_global(row->committed, u_n);
  }
  time_ = t;
  form_->begin_attempt(pose_at(t), u_n);
  step_.under_way = conserving() && mass_shift > 0;
  step_.u_n = std::move(u_n);
  if (step_.under_way) find_start_gaps();
}

bool ContactInterface::update_search(Vec u) {
  const PairSearch::Outcome outcome = form_->update(u, law());
  if (outcome != PairSearch::Outcome::kept) fetch_fixed();
  if (step_.under_way) find_start_gaps();
  return outcome == PairSearch::Outcome::other_pairs;
}

void ContactInterface::fetch_fixed() {
  fixed_here_.assign(at(dim_) * form_->nodes().global.size(), 0);
  if (!fixed_) return;
  const std::vector<double> flags = form_->nodes().exchange.gather(fixed_);
  std::transform(flags.begin(), flags.end(), fixed_here_.begin(), [](double f) { return f > 0.5 ? 1 : 0; });
}

void ContactInterface::set_fixed_dofs(const std::vector<char>& fixed) {
  if (!fixed_) fixed_ = layout_->make_global();
  layout_->to_global(std::vector<double>(fixed.begin(), fixed.end()), fixed_);
  fetch_fixed();
}

ContactStatus ContactInterface::visit(const std::vector<double>& u, Derivatives derivatives,
                                      const ConstraintVisitor& visitor) const {
  ContactStatus seen;
  seen.finite = all_finite(u);
  seen.search_holds = form_->pairs_hold(form_->nodes().current(u));
  const ConstraintVisitor counted = [&](const Constraint& c) {
    if (c.active) ++seen.active;
    seen.penetration = std::max(seen.penetration, -c.gap);
    visitor(c);
  };
  if (conserving())
    visit_conserving(u, derivatives, counted);
  else
    form_->visit(u, derivatives, law(), counted);
  return seen;
}

ContactStatus ContactInterface::add_residual(Vec u, double scale, Vec r) const {
  const std::vector<double> values = form_->nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const auto m = at(dim_);
  const double factor = step_.under_way ? 2 * scale : scale;
  const ContactStatus status = visit(values, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    const double t = traction(c).value;
    for (std::size_t i = 0; i < c.gradient.size(); ++i)
      f[dof(c.node[i / m], i % m)] -=
          factor * c.weight * (c.pressure * c.gradient[i] - (t != 0 ? t * c.slip_gradient[i] : 0));
  });
  form_->nodes().exchange.add(f, r);
  if (step_.under_way) subtract_last_force(scale, r);
  return status;
}

void ContactInterface::add_gaps(Vec u, double scale, Vec r) const {
  if (!semismooth()) return;
  const PressureLaw law = this->law();
  const std::vector<double> values = form_->nodes().displacement(u);
  std::vector<double> f(values.size(), 0.0);
  const auto m = at(dim_);
  visit(values, Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    const double gap = law.stiffness(c.scale) * c.gap;
    const double direction = traction(c).direction;
    const double slip =
        direction == 0 ? law.stiffness(c.scale) * c.slip : -settings_.friction * direction * gap;
    for (std::size_t i = 0; i < c.gradient.size(); ++i)
      if (const std::size_t row = dof(c.node[i / m], i % m); !fixed_here_[row])
        f[row] += scale * c.weight * (gap * c.gradient[i] + (rubs(c) ? slip * c.slip_gradient[i] : 0));
  });
  form_->nodes().exchange.add(f, r);
}

ContactStatus ContactInterface::add_tangent(Vec u, double scale, Mat K) const {
  const ContactNodes& nodes = form_->nodes();
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
  if (!semismooth()) return;
  // Surfaces that touch without a pressure so far: the first iterate must not pass through them, or has no
  // solution where nothing else holds a body.
  const double touch = 1e-8 * mean_length_, token = touch * penalty();
  std::vector<double> lambda = multiplier_->trial;
  visit(form_->nodes().displacement(u), Derivatives::none, [&](const Constraint& c) {
    if (!(c.lambda > 0)) lambda[at(c.index)] = std::abs(c.gap) < touch ? token : 0.0;
  });
  share(lambda);
  multiplier_->trial = std::move(lambda);
}

bool ContactInterface::take_newton_step(Vec u, Vec du, Vec next) {
  const ContactNodes& nodes = form_->nodes();
  const PressureLaw law = this->law();
  const std::vector<double> d = nodes.exchange.gather(du);
  const auto m = at(dim_);
  std::vector<double> lambda(multiplier_->trial.size(), 0.0), held(lambda.size(), 0.0);
  std::vector<char> active(lambda.size(), 0); // 1: sticks or has no friction; 2: slides
  const auto kind = [&](const Constraint& c) {
    return static_cast<char>(traction(c).direction == 0 ? 1 : 2);
  };
  visit(nodes.displacement(u), Derivatives::first, [&](const Constraint& c) {
    if (!c.active) return;
    double gap = c.gap, slip = c.slip;
    for (std::size_t i = 0; i < c.gradient.size(); ++i) {
      const double change = d[dof(c.node[i / m], i % m)];
      gap += c.gradient[i] * change;
      if (c.slides) slip += c.slip_gradient[i] * change;
    }
    lambda[at(c.index)] = c.lambda - law.stiffness(c.scale) * gap;
    active[at(c.index)] = kind(c);
    if (!rubs(c)) return;
    const double direction = traction(c).direction;
    held[at(c.index)] = direction == 0 ? traction_->trial[at(c.index)] + law.stiffness(c.scale) * slip
                                       : settings_.friction * direction * std::max(0.0, lambda[at(c.index)]);
  });
  share(lambda);
  multiplier_->trial = std::move(lambda);
  if (traction_ != nullptr && !friction_suspended_) {
    share(held);
    traction_->trial = std::move(held);
  }
  std::vector<char> then(active.size(), 0);
  visit(nodes.displacement(next), Derivatives::none, [&](const Constraint& c) {
    if (c.active) then[at(c.index)] = kind(c);
  });
  return !all_ranks_agree(mesh_->comm(), then == active);
}

} // namespace impact
