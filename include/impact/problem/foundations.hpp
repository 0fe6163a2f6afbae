#pragma once
#include <cmath>
#include <functional>
#include <impact/math/rotation.hpp>
#include <impact/math/vector3.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <petscmat.h>
#include <span>
#include <vector>

/// Foundations: springs and dashpots under surfaces of deformable bodies,
///   P N = -[k_n N N^T + k_t (1 - N N^T)] u - [c_n N N^T + c_t (1 - N N^T)] v     (3')
/// per reference area, N being the outward normal of the undeformed surface. What lets waves leave is one of
/// c_n = rho c_p and c_t = rho c_s alone (J. Lysmer, R. Kuhlemeyer, J. Engng Mech. Div. ASCE 95 (1969) 859).
namespace impact {

class Foundations {
public:
  /// Both must outlive the object. Throws UserError(data) for surfaces of rigid bodies and of cells that may
  /// leave their bodies. Collective.
  Foundations(const Discretisation& discretisation, const BoundaryData& boundary);

  bool empty() const { return empty_; }                ///< alike on all ranks
  bool springs() const { return softest_ < HUGE_VAL; } ///< the same: has springs
  bool damps() const { return damps_; }                ///< the same: has dashpots
  /// The least stiffness of springs, traction over displacement; infinite without. Alike on all ranks.
  double softest() const { return softest_; }

  /// force [node][dim] += `sign` times what springs exert at displacement u [node][dim]; returns what those
  /// of this rank's facets store, per unit thickness (3'').
  double add_springs(const std::vector<double>& u, double sign, std::vector<double>& force) const;
  /// The same of dashpots at velocity v. With a lumped mass they stand at the nodes, as that does.
  void add_dashpots(const std::vector<double>& v, double sign, std::vector<double>& force) const;
  /// matrix += the derivative of minus the force where v = slope u + .., without rows and columns of `held`
  /// dofs, by MatSetValues. The caller assembles.
  void add_tangent(double slope, const std::vector<char>& held, Mat matrix) const;
  /// sums [condition][3] += the forces on the bodies by this rank's facets; v may be empty.
  void add_resultants(const std::vector<double>& u, const std::vector<double>& v,
                      std::vector<Vector3>& sums) const;

  /// A bound of the square of the frequencies that the springs alone give to these masses. Collective.
  double frequency(Vec lumped_mass) const;
  /// What an explicit step knows when it looks for its acceleration; a_n null: at the start, whose first half
  /// step the dashpots feel at its end, or strong ones would turn the motion round.
  struct Rates {
    double dt;
    Vec v_n, a_n;
  };
  /// Dashpots on lumped masses, whose velocity is that at the end of the step: M a = F - C v with
  /// v = v_n + dt/2 (a_n + a) node by node (3'''); M a = F before. Accelerations of `fixed` dofs stay. Their
  /// force is added to `external` and put into `damping`.
  void damp(const Rates& rates, Vec lumped_mass, const std::vector<char>& fixed, Vec a, Vec external,
            Vec damping) const;

  /// Directions in which a place is held by springs or dashpots: a node beside it, the place, the direction.
  void visit_held(const std::function<void(int node, const double* x, const double* direction)>& body) const;

private:
  /// Along the normal and across it, per reference area.
  struct Stiffness {
    double normal = 0, across = 0;
    bool any() const { return normal > 0 || across > 0; }
  };
  struct Point {
    double area;
    Vector3 normal;
    Stiffness spring, dashpot;
  };
  struct Surface {
    int condition;
    FacetTable facets;
    std::vector<Point> points; ///< [facet][max_facet_nodes]
  };
  struct Damper {
    int node; ///< owned
    Matrix3 C;
  };
  static Vector3 resist(const Stiffness& by, const Vector3& normal, const Vector3& w);
  Surface make_surface(const LoadedFacets& load, const BoundaryData& boundary,
                       std::span<const int> group_of_cell) const;
  Stiffness impedance(const PointLaw& law) const;
  /// body(surface, nodes, point, its data) at all points, then done(nodes).
  template <class Body, class Done> void visit(Body&& body, Done&& done) const;
  void make_dampers();

  const Discretisation& d_;
  std::vector<double> X_;
  std::vector<Surface> surfaces_;
  std::vector<Damper> dampers_; ///< with a lumped mass
  bool empty_ = true, damps_ = false;
  double softest_ = HUGE_VAL;
};

} // namespace impact
