#pragma once
#include <array>
#include <impact/contact/pair_search.hpp>
#include <impact/contact/settings.hpp>
#include <impact/contact/surface.hpp>
#include <impact/kernel/facet_slip.hpp>
#include <impact/kernel/rigid_obstacle.hpp>
#include <span>
#include <string>
#include <vector>

/// The rigid plane, sphere or cylinder of a contact as its forms see it: one that moves as told, or one that
/// moves as a rigid body of the mesh does (theory.md, contact). Of the nodes of such a carrier dim + 1 that
/// span the space are its corners: whatever the obstacle carries along, places and directions, is an affine
/// function of theirs, exact for rigid motions (71'''). Gaps and slips are then functions of the secondary
/// nodes and the corners, so that inertia, finite rotation, prescribed components, checkpoints and the move
/// to other ranks are those of any rigid body. One that moves as told has no corners.
namespace impact {

/// Where a rigid obstacle stands in an attempt; one with mass: in the reference configuration, not moved.
struct ObstaclePose {
  RigidObstacle obstacle;        ///< at the end of the step
  std::array<double, 3> moved{}; ///< its displacement since the start of the step
};

/// From the centre of a round one to its pole, on the side of the secondary surface; zero of a plane.
/// Collective.
std::array<double, 3> pole_of(const ContactSettings& settings, const Mesh& mesh,
                              const ContactSurface& secondary);
/// Its displacement, as the settings tell; zero where they tell nothing.
std::array<double, 3> rigid_displacement(const ContactSettings& settings, int dim, double t);
/// `outward`: pole_of; `before`: its displacement at the start of the step.
ObstaclePose rigid_pose(const ContactSettings& settings, int dim, double t,
                        const std::array<double, 3>& outward, const double* before);

/// More functions than usual: a place or a direction that is carried along, and each derivative by what
/// carries it.
class Obstacle {
public:
  /// By corners: of a place, sum 1; of a direction, sum 0. In the plane the last one is zero.
  using Weights = std::array<double, 4>;
  /// What a function of a carried place and a carried direction says of the corners.
  struct Shares {
    Weights place{}, direction{};
  };

  /// It moves as told.
  explicit Obstacle(const Mesh& mesh);
  /// `region`: of the mesh, all of it one rigid body; `at_rest`: the obstacle in the reference configuration.
  /// Throws UserError(data): the region has no extent. Collective.
  Obstacle(const Mesh& mesh, const std::string& region, const RigidObstacle& at_rest);

  bool carried() const { return !node_.empty(); }
  const std::vector<PetscInt>& nodes() const { return node_; } ///< global, of the corners
  const std::vector<int>& slots() const { return slot_; }      ///< the same in the nodes of the contact
  void locate(const ContactNodes& nodes);
  /// Where one that moves as told stands in an attempt.
  void begin_attempt(const ObstaclePose& pose) {
    if (!carried()) pose_ = pose;
  }
  /// As told, or in the reference configuration.
  const RigidObstacle& reference() const { return pose_.obstacle; }
  bool plane() const { return pose_.obstacle.shape == RigidObstacle::Shape::plane; }

  /// The obstacle at the displacement u [node][dim] of the nodes of the contact. Where u is no rigid motion
  /// but the mean of two, the direction of a carried one is shorter than 1.
  RigidObstacle at(const ContactValues& u) const;
  /// Gap of a place x to it.
  CarriedFunction gap(const RigidObstacle& now, const std::array<double, 3>& x) const;
  /// Of its point and direction.
  const Shares& shares() const { return shares_; }
  Weights of_direction(const std::array<double, 3>& at_rest) const;
  /// Directions of slip on a plane: one in the plane, two in space; of one with a carrier at rest.
  std::array<std::array<double, 3>, 2> tangents() const;

  /// What lies opposite the nodes of secondary facets at coordinates x [node][dim] of the nodes is carried
  /// along from now on.
  void anchor(const ContactNodes& nodes, const ContactValues& x);
  /// Such a place at u, seen from a node.
  template <std::size_t d>
  std::array<double, d> place(const ContactNodes& nodes, int facet, std::size_t corner, int origin,
                              const ContactValues& u) const {
    const std::size_t number = per_facet_ * static_cast<std::size_t>(facet) + corner;
    std::array<double, d> x{};
    for (std::size_t b = 0; b < slot_.size(); ++b) {
      const std::array<double, d> y = nodes.place<d>(slot_[b], origin, u);
      for (std::size_t k = 0; k < d; ++k) x[k] += carried_[number][b] * y[k];
    }
    for (std::size_t k = 0; !carried() && k < d; ++k) {
      const std::size_t i = d * static_cast<std::size_t>(origin) + k;
      x[k] = start_[d * number + k] + pose_.moved[k] - nodes.X[i] - u[i];
    }
    return x;
  }

  /// Slip of a facet along a direction of a plane, t.sum_a weight_a (x_a - what it lay opposite of), as a
  /// function of these differences and the direction; its value is added to `value`.
  struct PlaneSlip {
    CarriedFunction function;
    Shares shares;
  };
  void add_slip(const ContactNodes& nodes, int facet, std::span<const double> weight,
                const std::array<double, 3>& tangent, const ContactValues& u, double& value,
                PlaneSlip& slip) const;

  /// Adds factor times the derivatives of f by (secondary nodes, whose weights in the place are `shape`,
  /// corners): [node][dim], and d2f to a matrix over the same.
  void add_gradient(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                    double factor, double* gradient) const;
  void add_hessian(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                   double factor, double* block) const;

  /// Derivatives by carried places of a facet [node][dim] become those by the corners of the carrier; and a
  /// matrix over (secondary nodes, carried places) one over (secondary nodes, corners of the carrier).
  void chain(int facet, const double* by_places, double* by_corners) const;
  void chain_block(int facet, std::span<const double> block, std::vector<double>& chained) const;

private:
  std::size_t dim_, per_facet_ = 0; // nodes of a facet, as anchored
  ObstaclePose pose_;               // of a carried one: in the reference configuration
  std::vector<PetscInt> node_;
  std::vector<int> slot_;
  std::array<Weights, 3> axis_{}; // of the directions x, y, z
  Shares shares_;
  std::vector<double> start_;    // [secondary facet][node][dim] when it was anchored
  std::vector<Weights> carried_; // [secondary facet][node]
};

} // namespace impact
