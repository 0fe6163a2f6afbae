#include <algorithm>
#include <cmath>
#include <impact/contact/constraints.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>

namespace impact {

Constraints::Constraints(const Mesh& mesh, const FieldLayout& layout, std::unique_ptr<ContactForm> form,
                         double mean_length, bool frictional)
    : mesh_(&mesh), layout_(&layout), form_(std::move(form)), dim_(at(mesh.dim())), mean_length_(mean_length),
      frictional_(frictional) {}

void Constraints::declare(std::size_t count, bool nodal, StateRow* gap) {
  count_ = count;
  nodal_ = nodal;
  gap_ = gap;
}

void Constraints::set_fixed_dofs(const std::vector<char>& fixed) {
  if (!fixed_) fixed_ = layout_->make_global();
  layout_->to_global(std::vector<double>(fixed.begin(), fixed.end()), fixed_);
  fetch_fixed();
}

void Constraints::fetch_fixed() {
  fixed_here_.assign(dim_ * nodes().global.size(), 0);
  if (!fixed_) return;
  const std::vector<double> flags = nodes().exchange.gather(fixed_);
  std::transform(flags.begin(), flags.end(), fixed_here_.begin(), [](double f) { return f > 0.5 ? 1 : 0; });
  const std::vector<int>& mine = nodes().secondary;
  supported_ = nodal_ && std::any_of(mine.begin(), mine.end(), [&](int node) {
                 const auto first = fixed_here_.begin() + static_cast<std::ptrdiff_t>(dof(node, 0));
                 return std::any_of(first, first + static_cast<std::ptrdiff_t>(dim_),
                                    [](char held) { return held != 0; });
               });
}

void Constraints::visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
                        const ConstraintFilter& wanted) const {
  const Timed timed(Event::contact_forces);
  std::vector<double> held;
  const bool holds = supported_ && frictional_;
  if (holds) derivatives = std::max(derivatives, Derivatives::first);
  const ConstraintVisitor pressed = [&](Constraint& c) {
    law_->press(c);
    if (holds) hold_slip(u, c, held);
    visitor(c);
  };
  if (step_.rule != StepRule::none)
    visit_step(u, derivatives, pressed);
  else if (conserving())
    visit_followed(u, derivatives, pressed);
  else
    form_->visit(
        u, derivatives,
        [&](Constraint& c) { // at the end of a step, as the step saw it
          keep_overlap(c);
          leave_jump(u, derivatives, c);
          pressed(c);
        },
        wanted);
}

// On a plane of symmetry, and wherever the node of a constraint and what it faces are held alike and never
// moved against each other, nothing slides: the traction along it would feel the bodies through the
// neighbours alone, and grow to its limit against slips that nothing can close.
void Constraints::hold_slip(const ContactValues& u, Constraint& c, std::vector<double>& gradient) const {
  if (!c.slides || nodes().start.empty()) return;
  const std::size_t n = c.gradient.size(), mine = c.share.size();
  const auto own =
      static_cast<std::size_t>(std::max_element(c.share.begin(), c.share.end()) - c.share.begin());
  for (std::size_t k = 0; k < dim_; ++k) {
    const std::size_t row = dof(c.node[own], k);
    if (!fixed(row) ||
        std::none_of(c.node.begin() + static_cast<std::ptrdiff_t>(mine), c.node.end(), [&](int other) {
          const std::size_t i = dof(other, k);
          return fixed(i) && std::abs(u[i] - u[row]) <= 1e-9 * mean_length_;
        }))
      continue;
    // The direction in which the surfaces are held, in those of the slip.
    Tangential held{};
    double all = 0;
    for (std::size_t a = 0; a < tangents(); ++a) {
      held[a] = c.slip_gradient[n * a + dim_ * own + k];
      for (std::size_t m = 0; m < dim_; ++m) all += std::pow(c.slip_gradient[n * a + dim_ * own + m], 2);
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

void Constraints::share(std::vector<double>& values, std::size_t components) const {
  if (!nodal_) return;
  // One constraint per node, evaluated by the node's owner.
  std::vector<double> vectors = layout_->make_local();
  for (std::size_t i = 0; i < values.size(); ++i)
    vectors[dim_ * (i / components) + i % components] = values[i];
  const Handle<Vec> owned = layout_->make_global();
  layout_->to_global(vectors, owned);
  layout_->to_local(owned, vectors);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = vectors[dim_ * (i / components) + i % components];
}

std::vector<double> Constraints::owned() const {
  std::vector<double> own(count_, 1.0);
  for (std::size_t i = 0; nodal_ && i < count_; ++i) own[i] = mesh_->owned(static_cast<int>(i)) ? 1 : 0;
  return own;
}

} // namespace impact
