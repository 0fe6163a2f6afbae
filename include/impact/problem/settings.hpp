#pragma once
#include <impact/kernel/cell_kernels.hpp>
#include <impact/mesh/sparse_assembly.hpp>
#include <optional>
#include <string>

/// Choices of the solution method that the user makes by options.
namespace impact {

enum class DamageBounds { vi, history, clip, none };
enum class TangentChoice { automatic, consistent, symmetric };
enum class ContactOperator { assembled, shell };

struct DamageScenario {
  DamageForm form = DamageForm::multiplied;
  double theta = 1;
  DamageBounds bounds = DamageBounds::vi;
  double substep = 0;        ///< -damage_ts_dt; 0: none
  int explicit_substeps = 0; ///< at most so many of them, of the rate law explicitly; 0: none
  int order = 0;             ///< of phi; 0: that of the cells
};

struct HeatScenario {
  HeatForm form = HeatForm::entropy;
  std::optional<HeatForm> form_given = std::nullopt; ///< absent: energy where nothing but heat is solved
  double theta = 1;   ///< time weight of conduction, loads and temperature: 1 backward Euler, 1/2 trapezoid
  double substep = 0; ///< -heat_ts_dt; 0: none
  int order = 0;      ///< of theta; 0: that of the cells
  std::optional<bool> lumped = std::nullopt; ///< whether c_V stands at the nodes; absent: see build_on
};

/// Coefficients of the bulk viscosity of explicit steps (kernel/bulk_viscosity.hpp).
struct BulkViscosity {
  double linear = 0, quadratic = 0;
  bool acts() const { return linear > 0 || quadratic > 0; }
};

/// Steps by central differences.
struct ExplicitScenario {
  double cfl = 0.8; ///< largest part of the stable step of the cells
  BulkViscosity bulk;
  double scaled_step = 0;      ///< cells get the mass for a stable step of this length; 0: they keep theirs
  double scaling_limit = 0.05; ///< largest part of the mass of all bodies that may be added
};

/// What the next pass of a staggered step starts from: the last phi, or one extrapolated from the last two
/// passes.
enum class PassRelaxation { none, aitken };

/// Which static equilibria are left where they are unstable: those of bodies that lie to one side, all, none.
enum class LeaveUnstable { imperfect, always, never };

struct CouplingScenario {
  int max_it = 1;
  bool follow_cracks = false; ///< max_it counts no pass in which phi grows
  double atol = 1e-4;
  double theta_tol = -1; ///< of the temperature, relative to its largest value; negative: atol
  PassRelaxation relaxation = PassRelaxation::aitken;
  double reuse_tangent = -1;        ///< see TangentReuse; negative: as suits the linear solver
  double reuse_preconditioner = -1; ///< see PreconditionerReuse; negative: as suits the linear solver
  LeaveUnstable leave_unstable = LeaveUnstable::imperfect;
  double max_dphi = 0;    ///< largest increment of phi in a step; 0: no limit
  double max_dalpha = 0;  ///< largest increment of the plastic strain
  double max_dtheta = 0;  ///< largest change of the temperature
  double max_closing = 1; ///< largest depth in facets at which a contact may close; 0: no limit
  double path_dissipation =
      0; ///< that a step of the length dt asks of cracks; 0: loads are given, see PathControl
  double path_length = 0;    ///< that bodies move by in a step of the length dt; 0: not asked, see ArcLength
  bool report_error = false; ///< evaluate StepRecord::internal_of_next_pass
  double dt = 0;             ///< -ts_dt
  double crack_level = 0.9;  ///< phi from which a node counts as cracked
  std::string length_unit = "m";
  bool moves = true;    ///< -physics has motion
  int damage_every = 1; ///< explicit steps between two solves of damage
  ExplicitScenario by_central_differences;
};

} // namespace impact
