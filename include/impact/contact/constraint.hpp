#pragma once
#include <functional>
#include <impact/kernel/coulomb.hpp>
#include <limits>
#include <span>

/// One gap constraint of a contact as every part of it sees it (theory.md, contact): the form brings what is
/// geometry, the step where gaps and gradients are taken, the enforcement the pressure.
namespace impact {

/// Which derivatives a visit brings: `first`, the gradients along which the forces stand; `tangent`, also
/// those of the gaps where they differ, for linear systems. Forms know the first two.
enum class Derivatives { none, first, tangent };

/// Of a constraint that faces nothing, or was not followed.
inline constexpr double unknown_gap = std::numeric_limits<double>::infinity();

/// One constraint at one displacement. The spans live as long as the visit.
struct Constraint {
  int index = 0;                  ///< place of its multiplier
  double weight = 0, stretch = 1; ///< reference area; current over reference area
  double gap = 0;
  double kept = 0;  ///< overlap that the gap leaves out, because the step does not close it (78')
  double cover = 1; ///< part of the weight that faces something
  /// Gap at the start of a step whose work is exact, else unknown_gap.
  double start_gap = unknown_gap;
  double lambda = 0, pressure = 0; ///< of the enforcement
  bool active = false;
  std::span<const int> node;            ///< into ContactForm::nodes(), secondary ones first
  std::span<const double> share;        ///< of the secondary nodes in the constraint, sum 1
  std::span<const double> spread;       ///< none negative, for means at the nodes, sum 1; empty: share
  std::span<const double> gradient;     ///< [node][dim]
  std::span<const double> end_gradient; ///< of the gap, where the force stands along another one, else empty
  /// Tangential motion since the start of the step, mean over the weight, in directions that the secondary
  /// surface carries along (one in the plane, two in space), and its derivatives over the same nodes; without
  /// friction, or where nothing lay opposite at the start, `slides` is false.
  bool slides = false;
  Tangential slip{};
  std::span<const double> slip_gradient; ///< [direction][node][dim]

  bool works_exactly() const { return start_gap != unknown_gap; }
  std::span<const double> nodal_parts() const { return spread.empty() ? share : spread; }
  /// Mean distance of what faces something; of a penetration the mean over the weight, which is what
  /// pressures close.
  double distance() const { return gap + kept > 0 ? (gap + kept) / cover : gap + kept; }
  std::span<const double> gap_gradient() const { return end_gradient.empty() ? gradient : end_gradient; }
};
using ConstraintVisitor = std::function<void(Constraint&)>;

/// Where the two sides of a constraint meet, for what passes between them: over the covered part of its
/// weight the mean of a nodal field is sum share field, on the secondary side over the first `secondary`
/// nodes, on the other one over the rest. The spans live as long as the visit.
struct Meeting {
  int index = 0;   ///< of the constraint
  double area = 0; ///< reference area of the covered part
  std::size_t secondary = 0;
  std::span<const int> node; ///< into ContactForm::nodes(); one may come on both sides
  /// Sum 1 on either side. A rigid body has none; nor has what covers nothing worth mentioning, area 0.
  std::span<const double> share;
};
using MeetingVisitor = std::function<void(const Meeting&)>;

/// Factors of the second variations, by the index of the constraint.
struct CurvatureFactors {
  std::span<const double> gap;
  std::span<const Tangential> slip; ///< empty without friction

  double of_gap(int index) const { return gap[static_cast<std::size_t>(index)]; }
  Tangential of_slip(int index) const {
    return slip.empty() ? Tangential{} : slip[static_cast<std::size_t>(index)];
  }
};
/// Nodes, and a block [node][dim][node][dim] over their dofs; a node may come twice. Both live as long as the
/// call.
using BlockVisitor = std::function<void(std::span<const int>, std::span<const double>)>;
/// Whether a constraint presses at a gap, or is wanted for another reason; if so, then at all smaller ones.
/// Empty: always.
using ConstraintFilter = std::function<bool(int index, double gap)>;

} // namespace impact
