#pragma once
#include <impact/contact/interface.hpp>
#include <numeric>
#include <vector>

/// What ContactImpulses knows of one contact in a step: its points that may meet, with the gradients of gaps
/// and slips, and the velocities of its nodes.
namespace impact {

inline double inner(const double* a, const double* b, std::size_t n) {
  return std::inner_product(a, a + n, b, 0.0);
}

/// Rigid bodies with mass whose nodes contacts push.
class ImpulseBodies {
public:
  virtual ~ImpulseBodies() = default;
  /// gain = what velocities of their nodes gain by impulses f at nodes [node][dim]. Collective.
  virtual void strike(Vec f, Vec gain) const = 0;
  /// A bound of that, at the first dof of each node, by impulses of any directions whose sizes stand at the
  /// first dofs. Collective.
  virtual void bound(Vec sizes, Vec most) const = 0;
};

struct ImpulseStep {
  Vec u, before, free; ///< displacement; velocities on either side of it, the later one without impulses
  Vec inverse_mass;    ///< 0 at prescribed dofs and on rigid bodies
  const ImpulseBodies* bodies; ///< null: there are none
  double t, dt;
};

struct ImpulseRows {
  ContactInterface* contact = nullptr;
  std::size_t dim = 0, tangents = 0;
  double friction = 0;
  std::vector<int> index;                             ///< [point] of the constraint
  std::vector<double> weight, gap;                    ///< [point]
  std::vector<double> drift, drift_before;            ///< [point] rate of the gap by the obstacle's motion
  std::vector<double> slip_drift;                     ///< [point][tangent] and of the slip
  std::vector<std::size_t> first, first_share;        ///< [point + 1]
  std::vector<int> node;                              ///< those of a point, secondary ones first
  std::vector<double> gradient, slip_gradient, share; ///< [node][dim]; [node][tangent][dim]; [secondary]
  std::vector<double> direction;                      ///< [point][tangent][dim]
  std::vector<double> inverse_mass, free, velocity;   ///< [node][dim] of the contact's nodes
  std::vector<double> area, floor, bound;             ///< [node] W, W c and D of the theory
  std::vector<double> x, x_before, z, y;              ///< [node][1 + dim]: pressure, traction
  std::vector<double> force, gain;                    ///< [node][dim]; of velocity, on rigid bodies
  std::vector<char> near, near_node;                  ///< [point], [node]

  std::size_t points() const { return index.size(); }
  /// Node of the contact at which a share stands.
  std::size_t node_of(std::size_t point, std::size_t number) const {
    return static_cast<std::size_t>(node[first[point] + number - first_share[point]]);
  }
  /// All points that face something. Collective.
  void collect(ContactInterface& contact, const ImpulseStep& step);
  /// Rates of a gap at velocities [node][dim] of the contact's nodes.
  double rate(std::size_t point, const std::vector<double>& velocity) const;
  /// Pressures and tractions x into the rows of the contact.
  void keep() const;
};

} // namespace impact
