#pragma once
#include <cmath>
#include <limits>
#include <type_traits>

/// The symbols of one material, in any consistent set of units (Table 1 of the paper).
/// A plain value: no defaults for physical parameters beyond "absent", which the option reader checks.
namespace impact {

enum class Model { elastic, j2, rigid };
enum class Damage { none, at2, at1, wu }; ///< local part of the crack energy (56), see crack.hpp
/// What of the elastic energy is E+ (49); automatic: of options, no law has it.
enum class Split { volumetric, none, star_convex, spectral, no_tension, drucker_prager, automatic };
/// g_e1(phi), ductile: g_e1(phi, alpha); from linear to lorentz: those of a strength (cohesive.hpp)
enum class Degradation { quadratic, cubic, ductile, linear, exponential, cornelissen, lorentz, own };
enum class PlasticDegradation { one, ge };       ///< g_p = 1 (the paper's run) or g_p = g_e1
enum class DamageGradient { spatial, material }; ///< psi_phi with C^-1 (paper, S_phi != 0) or with 1
enum class Conduction { spatial, material }; ///< isotropic where the body is now, or in the reference (paper)
enum class ConductionDegradation { one, ge }; ///< g_theta = 1 or g_theta = g_e1
enum class Locking { none, mean, fbar };      ///< volumetric locking cure on quads and hexes
/// k_0(alpha): sigma_y with Voce and linear parts, sigma_y + b alpha^n, points joined by lines, or a law from
/// outside
enum class HardeningKind { voce, power, table, own };
/// Volumetric law: (52), or that for high pressure (equation_of_state.hpp).
enum class EquationOfState { none, mie_grueneisen };
enum class Softening { none, linear, johnson_cook }; ///< f(theta), a factor on k_0
enum class RateForm { logarithm, power };            ///< of a factor of the rate (55a)

struct HardeningTable;       // material/hardening.hpp
struct HardeningFunctions;   // material/hardening.hpp
struct DegradationFunctions; // material/degradation.hpp

// Parameters stand in the group of what reads them. The kernels for laws with fewer terms copy the groups of
// their terms as a whole (kernel/motion_terms.hpp): a new parameter is declared in its group, and arrives.

/// What every deforming body has.
struct ElasticParameters {
  double K = 0, G = 0; ///< bulk and shear modulus (stress)
  double rho = 0;      ///< reference density
};

/// What flow and the cure of locking add.
struct FlowParameters {
  Model model = Model::elastic;
  Locking locking = Locking::none;
  double sigma_y = 0, voce_r = 0, voce_s = 0, linear_h = 0; ///< k = s_y + r(1 - exp(-s alpha)) + H alpha
  HardeningKind hardening = HardeningKind::voce;
  double power_b = 0, power_n = 1; ///< k_0 = s_y + b alpha^n
  double rate_c = 0, rate_0 = 1;   ///< factor 1 + c ln(rate/rate_0) on k above the rate rate_0
  Softening softening = Softening::none;
  RateForm rate_form = RateForm::logarithm;                   ///< or power: (1 + rate/rate_0)^c
  double softening_w = 0;                                     ///< linear: f = 1 - w (theta - theta_0)
  double theta_ref = 298.15, theta_melt = 0, softening_m = 1; ///< Johnson-Cook: f = 1 - T*^m
  double failure_softening = 0;                               ///< D_c: factor 1 - D_c D on k (55e)
  double taylor_quinney = 0.9;                                ///< chi: k_d = chi k (theory.md, E9)
  const HardeningTable* table = nullptr;                      ///< with HardeningKind::table
  const HardeningFunctions* own_hardening = nullptr;          ///< with HardeningKind::own
};

/// Numbers of a degradation (1-phi)^p / ((1-phi)^p + a_1 phi (1 + a_2 phi + a_2 a_3 phi^2)) (cohesive.hpp).
struct CohesiveShape {
  double p = 2, a1 = 0, a2 = 0, a3 = 0;
};

/// What a degradation reads beside phi and alpha.
struct DegradationParameters {
  Degradation ge = Degradation::quadratic;
  double cubic_s = 1e-4;            ///< slope parameter of the cubic degradation
  double alpha_c = 0;               ///< critical plastic strain of the ductile degradation
  double residual_stiffness = 1e-6; ///< g = (1 - k) g(phi) + k
  CohesiveShape cohesive;           ///< of linear to lorentz
  const DegradationFunctions* own_degradation = nullptr; ///< with Degradation::own
};

/// The symbols of one material. Trivially copyable: a kernel copies what it works with, and a device could
/// too.
struct MaterialParameters : ElasticParameters, FlowParameters, DegradationParameters {
  /// Sets each member by itself: one copy of a constant image hides from the compiler which terms are absent.
  MaterialParameters() {}

  EquationOfState equation_of_state = EquationOfState::none;
  double eos_s = 0;                    ///< slope of the shock speed over the particle speed; K = rho c_0^2
  double eos_gamma = 0;                ///< Grueneisen's Gamma; 0 without heat
  double alpha_t = 0, theta0 = 298.15; ///< thermal expansion, reference temperature
  double c_v = 0;          ///< heat capacity at fixed J_e per reference volume; 0: without temperature
  double conductivity = 0; ///< 0: adiabatic points
  Conduction conduction = Conduction::spatial;
  ConductionDegradation gtheta = ConductionDegradation::ge;
  Damage damage = Damage::none;
  double Gc = 0, gamma = 0;                           ///< toughness (force/length), layer width (length)
  double c = std::numeric_limits<double>::infinity(); ///< damage rate: lambda = (1 + delta - phi)^zeta / c
  double zeta = 1, delta = 0;
  double fatigue_a = 0;      ///< growth of the fatigue variable (area); 0: none
  double b_d = 0;            ///< viscosity: S_d = 2 b_d Cdot (62)
  bool visc_degrade = false; ///< b_d g_e1(phi) instead of b_d
  Split split = Split::volumetric;
  double star_gamma = 0; ///< gamma* of the star-convex split
  double cone = 0;       ///< B of Drucker and Prager's split
  bool sheet = false;    ///< plane stress: the spectral split takes no stretch across for that of a crack
  PlasticDegradation gp = PlasticDegradation::one;
  bool jc_failure = false; ///< whether the failure measure is followed (failure.hpp)
  double jc_d1 = 0, jc_d2 = 0, jc_d3 = 0, jc_d4 = 0, jc_d5 = 0;
  double plastic_threshold = 0; ///< W_0: damage is driven by <H_0 - W_0> (energy per volume)
  DamageGradient damage_gradient = DamageGradient::spatial;
};
static_assert(std::is_trivially_copyable_v<MaterialParameters>);

/// Whether a split asks for the principal stretches, not only for volume and shape.
inline bool by_principal(Split split) {
  return split == Split::spectral || split == Split::no_tension || split == Split::drucker_prager;
}
inline bool has_state(const MaterialParameters& m) { return m.equation_of_state != EquationOfState::none; }

inline double young_modulus(const MaterialParameters& m) { return 9 * m.K * m.G / (3 * m.K + m.G); }
/// c_p of waves of small amplitude.
inline double longitudinal_speed(const MaterialParameters& m) {
  return std::sqrt((m.K + 4 * m.G / 3) / m.rho);
}

} // namespace impact
