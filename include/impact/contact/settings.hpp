#pragma once
#include <array>
#include <cmath>
#include <functional>
#include <impact/kernel/frame.hpp>
#include <limits>
#include <memory>
#include <string>

/// What the user says of one contact (options/README.md, contact). A plain value, lengths and stresses in run
/// units.
namespace impact {

enum class ContactMethod { automatic, gauss_points, mortar };
enum class MultiplierSpace { automatic, standard, dual }; ///< of the mortar method
enum class Enforcement { automatic, penalty, auglag, semismooth, impulse };
class EnforcementMethod;
struct EnforcementRows;

enum class InitialOverlap { adjust, error, allow };
/// automatic: stabilised, but none beside a conserving one; conserving: a penalty whose work is exact
enum class ImpactUpdate { automatic, stabilised, conserving, none };
/// Grow when max|g| fell by less than 4; or the paper's rule.
enum class PenaltyGrowth { on_slow_gap, every_augmentation };

struct ContactSettings {
  static constexpr double automatic =
      std::numeric_limits<double>::quiet_NaN(); ///< "auto" for the numbers below
  std::string id, secondary;
  std::string primary; ///< a boundary, or a rigid body: "plane", "rigid_sphere", "rigid_cylinder"
  double plane_point[3] = {0, 0, 0}, plane_normal[3] = {0, 1, 0}; ///< outward normal of the rigid half space
  double centre[3] = {0, 0, 0}, axis[3] = {0, 0, 1};              ///< of a rigid sphere, a rigid cylinder
  double radius = 0;                                              ///< of both
  std::array<std::function<double(double t)>, 3>
      rigid_motion;    ///< displacement of the rigid body; empty: none
  std::string carrier; ///< region of the rigid body of the mesh that carries it; empty: it moves as told
  ContactMethod method = ContactMethod::automatic; ///< automatic: mortar, gauss_points of second order
  MultiplierSpace multipliers =
      MultiplierSpace::automatic;               ///< automatic: standard in the plane, dual in space
  Enforcement enforce = Enforcement::automatic; ///< automatic: resolve_settings.hpp
  /// Makes a method of one's own, which takes the place of `enforce`; empty: none.
  std::function<std::unique_ptr<EnforcementMethod>(const ContactSettings&, const EnforcementRows&)>
      own_enforcement;
  double friction = 0;                    ///< Coulomb's coefficient
  double conductance = 0;                 ///< h_c, power per current area and temperature; 0: insulated
  double conductance_pressure = 0;        ///< p_0 of h = h_c (p/p_0)^m
  double conductance_exponent = 0;        ///< m; 0: h = h_c wherever the contact is closed
  double conductance_gap = automatic;     ///< with m = 0: places that are no further apart count as closed;
                                          ///< automatic: 1e-6 of the mean secondary facet
  double friction_heat_split = automatic; ///< part of the frictional heat that enters the secondary side;
                                          ///< automatic: 1/2, all of it against a rigid body
  std::function<double(double t)> rigid_temperature; ///< of the rigid body; empty: it is insulated
  double penalty =
      automatic; ///< stress per length; automatic: 10 E/h, E of the softer side, h the mean secondary facet
  double penalty_increment =
      automatic; ///< automatic: the starting penalty, or 4 times its automatic value from below that
  double penalty_max = automatic; ///< automatic: 1e4 times the automatic penalty
  PenaltyGrowth growth = PenaltyGrowth::on_slow_gap;
  double gap_tol = automatic; ///< a length; automatic: 1e-3 of the secondary facet
  double pressure_tol = 1e-2; ///< change relative to the largest multiplier
  int points = 0;             ///< Gauss points per secondary facet (P + 1); 0: not given, 2
  double search_radius =
      automatic;             ///< automatic: pairs by the facets' own sizes, 0.8 of the smallest facet deep
  bool local_search = false; ///< the radius was automatic
  bool automatic_penalty = false; ///< the penalty was
  bool inertia = false;           ///< bodies have some
  bool exposed = false;           ///< cells have left, and facets inside the bodies take part
  bool iterated = true;           ///< what points face is held while Newton's method works
  bool changing = false;          ///< cells may leave: what comes free keeps no spring of friction
  bool at_nodes = false;          ///< points stand at the nodes of facets, with the areas of their shapes
  InitialOverlap initial = InitialOverlap::error;
  double initial_tol = automatic; ///< automatic: 1e-3 of the facet
  ImpactUpdate impact = ImpactUpdate::automatic;

  bool rigid() const { return rigid_name(primary); }
  /// h of a closed place under the pressure p per current area.
  double conductance_at(double p) const {
    return conductance_exponent == 0 ? conductance
                                     : conductance * std::pow(p / conductance_pressure, conductance_exponent);
  }
  static bool rigid_name(const std::string& name) {
    return name == "plane" || name == "rigid_sphere" || name == "rigid_cylinder";
  }
};

/// What the caller knows and the user's settings do not say.
struct ContactEnvironment {
  Frame frame = Frame::plane_strain;
  double thickness = 1; ///< multiplies what is reported of plane problems
  double modulus = 0;   ///< Young's modulus of the softer undegraded side
  double density = 0;   ///< of the heaviest side where bodies have inertia, else 0
  double length = 0;    ///< cell size beside the surface; 0: mean secondary facet
  bool flows = false;   ///< the material of a side does
};

} // namespace impact
