#pragma once
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/state_table.hpp>
#include <impact/problem/boundary_conditions.hpp>
#include <map>
#include <span>
#include <string>
#include <vector>

/// Prescribed values and loads resolved on one mesh: which local dofs are held, by which condition, and what
/// acts on which facets and nodes. All expressions are evaluated at reference coordinates.
namespace impact {

/// Names of groups by falling dimension, for messages.
std::string groups_text(const std::vector<Group>& groups);

/// One prescribed displacement dof (local numbering node * dim + component), owned by the first condition
/// declared.
struct FixedDof {
  int dof = 0;
  int condition = 0; ///< index into the conditions
  int component = 0;
};

/// Facets under a dead traction or a follower pressure.
struct LoadedFacets {
  int condition = 0;
  FacetTable facets;
};

/// Integral of a rate at x over time (Gauss-Legendre, 5 points: exact to degree 9).
double integral(const Expression& rate, const double* x, int dim, double t0, double t1);
/// Which coordinate is constant over nodes of any ranks, -1: none. Collective.
int plane_axis(const Mesh& mesh, const std::vector<int>& nodes);

/// What a plane mesh stands for; in space nothing is asked of it.
struct PlaneBody {
  Frame frame = Frame::plane_strain;
  double thickness = 1; ///< of the flat frames
};

// Members and functions beyond the usual: one list and one question for each kind of condition.
class BoundaryData {
public:
  /// Finds groups, checks components and conflicts (two conditions with different values on one dof at t = 0
  /// or t_end; require_agreement looks between, a plane group for `symmetry`). Nodes of rigid bodies, [local
  /// node] >= 0, have no prescribed dofs here: what holds them is the business of RigidBodies. A `force` is
  /// that on all of the thickness, or on the full ring. Throws UserError(data). Collective.
  BoundaryData(const Mesh& mesh, std::vector<BoundaryCondition> conditions, double t_end,
               std::span<const int> body_of_node = {}, PlaneBody plane = {});

  const std::vector<BoundaryCondition>& conditions() const { return conditions_; }
  /// Whether a condition has data that are to be evaluated in each step; alike on all ranks.
  bool has_data() const;
  bool has(BcType type) const;
  const std::vector<FixedDof>& fixed() const { return fixed_; }
  /// [local node * dim + k] 1 where the displacement is prescribed.
  const std::vector<char>& fixed_mask() const { return fixed_mask_; }
  /// [local node] the condition that prescribes phi or the temperature, -1 without one.
  const std::vector<int>& damage_condition() const { return damage_condition_; }
  const std::vector<int>& temperature_condition() const { return temperature_condition_; }

  /// Sets the prescribed entries of u (local [node][dim]) at time t1. velocity and acceleration data are
  /// integrated from t0, starting with u_n and the prescribed velocity v_n of those dofs (Gauss-Legendre, 5
  /// points: exact to degree 9).
  void set_displacement(double t0, double t1, const std::vector<double>& u_n, const std::vector<double>& v_n,
                        std::vector<double>& u) const;
  double prescribed(const FixedDof& fixed, double t0, double t1, double u_n, double v_n) const; ///< of one
  /// Velocity and acceleration of the prescribed dofs at the start (one-sided differences of displacement
  /// data over a small part of dt). Dofs with acceleration data keep their velocity.
  void set_initial_rates(double start, double dt, std::vector<double>& v, std::vector<double>& a) const;
  /// Takes dt^2/12 times the jerk of the data from these velocities: those of the trapezoidal rule,
  /// 2 (u_next - u)/dt - v where u is given, then follow the data without a part that alternates, which
  /// accelerations would sum up. Data that have a kink in the first step are not smoothed by that.
  void smooth_velocity(double start, double dt, std::vector<double>& v) const;
  /// Velocity at t1 of dofs with acceleration data, integrated from v_n at t0 (the row
  /// "prescribed_velocity").
  void set_exact_velocity(double t0, double t1, const std::vector<double>& v_n, std::vector<double>& v) const;
  /// Of one dof; others keep theirs.
  double exact_velocity(const FixedDof& fixed, double t0, double t1, double v_n) const;
  void set_damage(double t, std::vector<double>& phi) const { set_held(damage_condition_, t, phi); }
  void set_temperature(double t, std::vector<double>& theta) const {
    set_held(temperature_condition_, t, theta);
  }
  /// Throws UserError(data), on the ranks that hold such a node, where two conditions prescribe different
  /// values at t1 for one node; arguments as for set_displacement, empty vectors for zeros.
  void require_agreement(double t0, double t1, const std::vector<double>& u_n,
                         const std::vector<double>& v_n) const;

  /// Facets with a heat flux or a convection, and the condition of regions with a heat source.
  const std::vector<LoadedFacets>& heat_fluxes() const { return heat_fluxes_; }
  std::vector<int> heat_sources() const;
  /// Scalar (pressure, flux inwards, temperature around, source) and coefficient of a condition at a
  /// reference point.
  double scalar_value(int condition, const double* x, double t) const;
  double ambient_temperature(int condition, const double* x, double t) const; ///< of a convection, K
  double heat_coefficient(int condition, const double* x, double t) const;

  /// Body forces per mass at the nodes of their regions, [node][dim], those beside others too (BodyLoad knows
  /// whose cells they act on); false when none acts. That of one condition is added.
  bool body_force(double t, std::vector<double>& f) const;
  void add_body_force(int condition, double t, std::vector<double>& f) const;
  /// Adds the forces on points and lines at time t to [node][dim], to be summed over ranks.
  void add_nodal_forces(double t, std::vector<double>& f) const;
  const std::vector<LoadedFacets>& tractions() const { return tractions_; } ///< dead, per reference area
  const std::vector<LoadedFacets>& pressures() const { return pressures_; } ///< follower, per current area
  const std::vector<LoadedFacets>& foundations() const { return foundations_; } ///< what gives_way
  /// Value of a traction or force condition at a reference point, per reference area. t [dim].
  void traction(const LoadedFacets& load, const double* x, double t, double* value) const;

private:
  void resolve_fixed(const Mesh& mesh, std::span<const int> body_of_node);
  void resolve_loads(const Mesh& mesh, PlaneBody plane);
  std::vector<int> resolve_held(const Mesh& mesh, BcType type);
  void set_held(const std::vector<int>& holder, double t, std::vector<double>& field) const;
  template <class Wanted, class Body> void visit_groups(const Mesh& mesh, Wanted&& wanted, Body&& body) const;
  bool has_acceleration(const FixedDof& fixed) const {
    const BoundaryCondition& bc = conditions_[static_cast<std::size_t>(fixed.condition)];
    return bc.type == BcType::acceleration && bc.component[fixed.component];
  }

  int dim_, node_count_;
  double smallest_edge_;
  std::vector<double> x_;
  std::vector<BoundaryCondition> conditions_;
  std::vector<FixedDof> fixed_;
  std::vector<char> fixed_mask_;
  std::map<int, std::vector<int>> body_nodes_; ///< [condition] nodes of its regions
  std::vector<LoadedFacets> tractions_, pressures_, foundations_, heat_fluxes_;
  std::vector<int> damage_condition_, temperature_condition_;
  struct SharedValue {
    int node, first, second;
  };
  std::vector<std::pair<FixedDof, FixedDof>> shared_dofs_; ///< held by two conditions, which must agree
  std::vector<SharedValue> shared_values_;                 ///< of phi and temperature
  struct NodalForce {
    int node, condition;
    double share;
  };
  std::vector<NodalForce> nodal_forces_;
  std::vector<double> force_area_; ///< per condition: reference area of a `force` group, length or count,
                                   ///< times the thickness
};

} // namespace impact
