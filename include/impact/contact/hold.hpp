#pragma once

/// Holding on to what a constraint faces while Newton's method works. At a kink of a surface, the end of a
/// facet, the side of a step, what lies nearest changes with the iterates and the direction of the force with
/// it: Newton's method jumps to and fro. What was chosen between the solves is therefore held in them, and
/// what changes it too often within an attempt at a step is held no longer, or no longer changed.
namespace impact {

/// Of the points of a form, in units of their facet's coordinates.
struct HoldRule {
  double overlap; ///< a point is held as long as it stands at most this far beyond the facet,
  double limit;   ///< and in an iterate, which may stray, this far
};
/// Half an edge is one unit: 1/40 of its length, and a quarter.
inline constexpr HoldRule hold_on_edge = {0.05, 0.5};
/// A triangle's height is one unit: as far as on an edge, 1/40, and the whole height.
inline constexpr HoldRule hold_on_triangle = {0.025, 1};
/// A point is held to what is nearer than this part of its own facet's size.
inline constexpr double hold_range = 0.1;

/// How often what a constraint, or a facet, faces has changed in an attempt while it pressed.
class Switches {
public:
  bool exhausted() const { return count_ >= most; }
  void note() { ++count_; }

private:
  static constexpr int most = 4;
  int count_ = 0;
};

} // namespace impact
