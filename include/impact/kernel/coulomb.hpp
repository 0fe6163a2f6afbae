#pragma once
#include <algorithm>
#include <array>
#include <cmath>

/// Coulomb's law for what is tangential in a contact (theory.md, contact, (82')).
namespace impact {

/// Components of what is tangential: one in the plane, the second one zero; two in space.
using Tangential = std::array<double, 2>;
inline double inner(const Tangential& a, const Tangential& b) { return a[0] * b[0] + a[1] * b[1]; }

/// Coulomb's law for a tangential traction, per reference area: trial q = t_old + eps s, stick while |q| does
/// not exceed friction times pressure.
struct Traction {
  Tangential value{};
  bool slides = false;
  Tangential direction{}; ///< of a sliding contact: q / |q|
  double excess = 0;      ///< of a sliding contact: |q| - limit
};
inline Traction coulomb(const Tangential& q, double limit) {
  const double size = std::hypot(q[0], q[1]);
  if (!(size > limit)) return {q, false, {}, 0};
  const Tangential m = {q[0] / size, q[1] / size};
  return {{limit * m[0], limit * m[1]}, true, m, size - limit};
}

/// Tractions of a step whose work is exact (theory.md, motion in time). The spring of the penalty holds
/// `held` at the start; `over` acts during the step, Coulomb's law for the middle of the spring's way,
/// q = held + eps s / 2; `end` is what the spring holds at the end.
struct StepTraction {
  Traction over;
  Tangential end{};
  double loss = 0; ///< over.s - (|end|^2 - |held|^2) / (2 eps) >= 0
};
/// `limit`: friction times the pressure of the step; `limit_end`: times that of its end. Where it slides the
/// spring keeps its limit at the end, or all that it was given if that is less.
inline StepTraction step_traction(const Tangential& held, const Tangential& slip, double eps, double limit,
                                  double limit_end) {
  StepTraction t;
  t.over = coulomb({held[0] + eps * slip[0] / 2, held[1] + eps * slip[1] / 2}, limit);
  const double before = inner(held, held), work = inner(t.over.value, slip);
  Tangential along = t.over.direction;
  // Never negative: with a = held.m it is at least (a - 2 limit)^2.
  double size = std::sqrt(std::max(0.0, before + 2 * eps * work));
  if (!t.over.slides) {
    const Tangential whole = {held[0] + eps * slip[0], held[1] + eps * slip[1]};
    size = std::hypot(whole[0], whole[1]);
    if (size > 0) along = {whole[0] / size, whole[1] / size};
  }
  const double kept = std::min(size, limit_end);
  t.end = {kept * along[0], kept * along[1]};
  // What sticks within its limit loses nothing.
  if (t.over.slides || kept < size) t.loss = work - (kept * kept - before) / (2 * eps);
  return t;
}

} // namespace impact
