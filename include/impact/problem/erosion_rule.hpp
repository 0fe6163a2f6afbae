#pragma once
#include <limits>

/// When a cell leaves its body (erosion.hpp).
namespace impact {

/// What the user says of one material. A cell leaves when any of the criteria holds that were given.
struct ErosionRule {
  static constexpr double none = std::numeric_limits<double>::infinity();

  bool on = false;
  bool keeps_mass = true; ///< the mass of what leaves stays with the nodes
  double points = 1;      ///< part of the points of a cell that must have reached what follows
  double phi = 0.99;      ///< damage of a broken cell
  double strain = none;   ///< plastic strain
  bool failure = false;   ///< the failure measure is 1
  double J = 0;           ///< det F at any point; 0: what has no volume any more
  double stretch = none;  ///< largest principal stretch of any point
  double step = 0;        ///< stable step over that of the undeformed cell

  /// Whether something is said of the shape, which a broken cell must then have, too.
  bool by_shape() const { return J > 0 || stretch < none || step > 0; }
};

/// What has left so far: components of the row "erosion_totals"; momentum: three of them, of mass that went.
/// Energy, mass and momentum of a plane problem times the thickness.
struct ErosionTotals {
  /// `force`: on nodes that lost all their mass, whose impulse in the half step to come goes after them.
  enum { cells, mass, energy, momentum, force = momentum + 3, components = force + 3 };
};

} // namespace impact
