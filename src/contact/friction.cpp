#include <algorithm>
#include <cmath>
#include <impact/contact/friction.hpp>
#include <impact/kernel/contact_pair.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

Tangential Friction::traction_in(const std::vector<double>& tractions, const Constraint& c) const {
  Tangential t{};
  std::copy_n(&tractions[tangents() * at(c.index)], tangents(), t.begin());
  return t;
}

Tangential Friction::held(const Constraint& c) const {
  return forgets(c) ? Tangential{} : traction_in(traction_->trial, c);
}

Tangential Friction::shown(const Constraint& c) const {
  return forgets(c) ? traction_in(traction_->trial, c) : traction(c).value;
}

void Friction::change_surface(const std::vector<int>& place) {
  traction_.change_surface(place);
  slip_.change_surface(place);
  forget();
}

StepTraction Friction::step_traction(const Constraint& c) const {
  const Tangential before = held(c);
  const double eps = law_->eps(), mu = coefficient_;
  if (rubs(c))
    return impact::step_traction(before, c.slip, eps, mu * c.pressure, mu * contact_pressure(0, eps, c.gap));
  // Where nothing lies opposite any more the spring lets go.
  StepTraction released;
  released.loss = inner(before, before) / (2 * eps);
  return released;
}

Traction Friction::traction(const Constraint& c) const {
  if (!rubs(c)) return {};
  if (c.works_exactly()) return step_traction(c).over;
  const Tangential held = this->held(c);
  const double limit = coefficient_ * std::max(c.pressure, 0.0), eps = law_->slip_weight();
  if (law_->is_given()) {
    const double size = std::hypot(held[0], held[1]);
    if (!(size > 0) || size < (1 - 1e-6) * limit) return {held, false, {}, 0};
    return {held, true, {held[0] / size, held[1] / size}, 0};
  }
  Traction t = coulomb({held[0] + eps * c.slip[0], held[1] + eps * c.slip[1]}, limit);
  // The multiplier is the traction while the contact sticks; the slip only decides whether it does.
  if (law_->closes_gaps() && !t.slides) t.value = held;
  return t;
}

Traction Friction::linear_traction(const Constraint& c) const {
  Traction t = traction(c);
  if (slid_.empty() || !t.slides || !(inner(slid_[at(c.index)], t.direction) < 0)) return t;
  const double size = std::hypot(t.value[0], t.value[1]) + t.excess;
  return {{size * t.direction[0], size * t.direction[1]}, false, {}, 0};
}

Tangential Friction::traction_to_keep(const Constraint& c) const {
  if (!acts() || forgets(c)) return {};
  return c.works_exactly() ? step_traction(c).end : traction(c).value;
}

std::array<Tangential, 2> Friction::slip_stiffness(const Constraint& c, const Traction& t) const {
  if (!t.slides) {
    const double stick = law_->stiffness(c);
    return {{{stick, 0}, {0, stick}}};
  }
  if (tangents() == 1) return {};
  const double k = law_->turn_stiffness(c, t);
  const Tangential& m = t.direction;
  return {{{k * m[1] * m[1], -k * m[0] * m[1]}, {-k * m[0] * m[1], k * m[0] * m[0]}}};
}

void Friction::add_heat(const Constraint& c, double& heat) const {
  if (!acts()) return;
  if (c.works_exactly()) {
    heat += c.weight * step_traction(c).loss;
    return;
  }
  if (forgets(c)) {
    heat += c.weight * inner(traction(c).value, c.slip);
    return;
  }
  if (!iterated_) { // (82''')
    const Tangential before = traction_in(traction_->committed, c), now = traction(c).value;
    double lost = 0;
    for (std::size_t a = 0; a < tangents(); ++a) lost += (before[a] + now[a]) / 2 * c.slip[a];
    if (!law_->is_given()) // impulses keep nothing
      lost -= (inner(now, now) - inner(before, before)) / (2 * law_->eps());
    heat += c.weight * lost;
    return;
  }
  const Traction t = traction(c);
  if (!t.slides) return;
  const Tangential before = held(c);
  for (std::size_t a = 0; a < tangents(); ++a) {
    const double elastic = law_->closes_gaps() ? 0 : (t.value[a] - before[a]) / law_->eps();
    heat += c.weight * t.value[a] * (c.slip[a] - elastic);
  }
}

Tangential Friction::after_linear_solve(const Constraint& c, double lambda, const Tangential& slip) const {
  const Traction t = traction(c);
  const std::array<Tangential, 2> K = slip_stiffness(c, t);
  const double limit = coefficient_ * std::max(0.0, lambda);
  Tangential then{};
  for (std::size_t a = 0; a < tangents(); ++a)
    then[a] = (t.slides ? limit * t.direction[a] : t.value[a]) + inner(K[a], slip);
  return then;
}

Tangential Friction::missing(const Constraint& c, double gap_force) const {
  const Traction t = traction(c);
  if (!law_->closes_gaps()) {
    const Tangential then = linear_traction(c).value;
    return {then[0] - t.value[0], then[1] - t.value[1]};
  }
  const std::array<Tangential, 2> K = slip_stiffness(c, t);
  Tangential missing{};
  for (std::size_t a = 0; a < tangents(); ++a)
    missing[a] = inner(K[a], c.slip) - coefficient_ * t.direction[a] * gap_force;
  return missing;
}

void Friction::forget() {
  slid_.clear();
  slides_.clear();
  kind_.clear();
  reverses_ = false;
}

bool Friction::follow(const Constraints& constraints, Vec u) {
  if (!acts() || law_->closes_gaps() || suspended_) return false;
  slid_.swap(slides_);
  slid_.resize(constraints.count(), Tangential{});
  slides_.assign(slid_.size(), Tangential{});
  enum Kind : char { faces_none, holds, moves, turns }; // the last one holds and would slide the other way
  std::vector<char> kind(slid_.size(), faces_none);
  const auto visitor = [&](const Constraint& c) {
    if (!c.active) return;
    kind[at(c.index)] = holds;
    if (!rubs(c)) return;
    const Traction t = linear_traction(c);
    slides_[at(c.index)] = t.direction;
    kind[at(c.index)] = t.slides ? moves : traction(c).slides ? turns : holds;
  };
  constraints.visit(u, Derivatives::none, visitor, constraints.pressing());
  std::array<int, 2> any = {kind != kind_ ? 1 : 0, std::count(kind.begin(), kind.end(), turns) > 0 ? 1 : 0};
  max_over_ranks(constraints.comm(), any);
  kind_ = std::move(kind);
  reverses_ = any[1] == 1;
  return any[0] == 1;
}

void Friction::keep_tractions(std::vector<double>& tractions) {
  if (acts() && !suspended_) traction_->trial = std::move(tractions);
}

ConstraintFilter Friction::acting() const {
  return [this](int index, double gap) {
    if (law_->presses(index, gap)) return true;
    if (!acts()) return false;
    for (std::size_t a = 0, first = tangents() * at(index); a < tangents(); ++a)
      if (traction_->committed[first + a] != 0 || traction_->trial[first + a] != 0) return true;
    return false;
  };
}

void Friction::begin_end() {
  if (!acts()) return;
  next_slip_.assign(slip_->trial.size(), 0.0);
  next_traction_.assign(traction_->trial.size(), 0.0);
}

// What sticks from now on does so with the traction of this state.
void Friction::note_end(const Constraint& c) {
  if (!acts()) return;
  const std::size_t m = tangents(), first = (m + 1) * at(c.index);
  const Traction t = traction(c);
  const Tangential kept = forgets(c) ? t.value : traction_to_keep(c);
  std::copy_n(kept.begin(), m, &next_traction_[m * at(c.index)]);
  if (!c.active) return;
  for (std::size_t a = 0; a < m; ++a)
    next_slip_[first + a] = c.slip[a] + (forgets(c) ? 0 : slip_->committed[first + a]);
  // What has closed just now had no friction yet.
  next_slip_[first + m] = !c.slides || t.slides ? slides : sticks;
}

void Friction::advance(const Constraints& constraints) {
  if (!acts()) return;
  const std::size_t m = tangents();
  closed_.resize(next_slip_.size() / (m + 1));
  for (std::size_t i = 0, state = m; i < closed_.size(); ++i, state += m + 1)
    if (next_slip_[state] != 0 && slip_->committed[state] == 0) ++closed_[i];
  constraints.share(next_traction_, m);
  constraints.share(next_slip_, m + 1);
  traction_->trial.swap(next_traction_);
  slip_->trial.swap(next_slip_);
  traction_.tell_table();
  slip_.tell_table();
}

double Friction::reopenings(MPI_Comm comm) const {
  std::array<double, 2> sum{}; // closings, and constraints that did
  for (const int times : closed_) {
    sum[0] += times;
    sum[1] += times > 0 ? 1 : 0;
  }
  sum_over_ranks(comm, sum);
  return sum[1] > 0 ? sum[0] / sum[1] - 1 : 0;
}

} // namespace impact
