#pragma once
#include <array>
#include <impact/contact/pair_search.hpp>
#include <impact/kernel/rigid_obstacle.hpp>
#include <impact/mesh/mesh.hpp>
#include <span>
#include <string>
#include <vector>

/// A rigid plane, sphere or cylinder that moves as a rigid body of the mesh does (theory.md, contact). Of the
/// body's nodes dim + 1 that span the space are its corners: whatever the obstacle carries along, places and
/// directions, is an affine function of theirs, exact for rigid motions. Gaps and slips are then functions of
/// the secondary nodes and the corners, so that inertia, finite rotation, prescribed components, checkpoints
/// and the move to other ranks are those of any rigid body.
namespace impact {

class ObstacleCarrier {
public:
  /// By corners: of a place, sum 1; of a direction, sum 0. In the plane the last one is zero.
  using Weights = std::array<double, 4>;
  /// What a function of a carried place and a carried direction says of the corners.
  struct Shares {
    Weights place{}, direction{};
  };

  /// None: the obstacle moves as told.
  ObstacleCarrier() = default;
  /// `region`: of the mesh, all of it one rigid body; `at_rest`: the obstacle in the reference configuration.
  /// Throws UserError(data): the region has no extent. Collective.
  ObstacleCarrier(const Mesh& mesh, const std::string& region, const RigidObstacle& at_rest);

  bool empty() const { return node_.empty(); }
  int count() const { return static_cast<int>(node_.size()); }
  const std::vector<PetscInt>& nodes() const { return node_; } ///< global, of the corners
  const std::vector<int>& slots() const { return slot_; }      ///< the same in the nodes of the contact
  void locate(const ContactNodes& nodes);

  /// The obstacle at the displacement u [node][dim] of the nodes of the contact. Where u is no rigid motion
  /// but the mean of two, its direction is shorter than 1.
  RigidObstacle obstacle(const std::vector<double>& u) const;
  /// Of the obstacle's point and direction.
  const Shares& shares() const { return shares_; }
  Weights of_direction(const std::array<double, 3>& at_rest) const;

  /// What lies opposite the secondary corners at coordinates x [node][dim] of the nodes is carried along from
  /// now on.
  void anchor(const ContactNodes& nodes, const std::vector<double>& x);
  /// Weights of such a place.
  const Weights& carried(int facet, int corner) const {
    return carried_[corners_ * static_cast<std::size_t>(facet) + static_cast<std::size_t>(corner)];
  }
  /// The place itself at u, seen from a node.
  template <std::size_t d>
  std::array<double, d> place(const ContactNodes& nodes, int facet, int corner, int origin,
                              const std::vector<double>& u) const {
    const Weights& weight = carried(facet, corner);
    std::array<double, d> x{};
    for (std::size_t b = 0; b < slot_.size(); ++b) {
      const std::array<double, d> y = nodes.place<d>(slot_[b], origin, u);
      for (std::size_t k = 0; k < d; ++k) x[k] += weight[b] * y[k];
    }
    return x;
  }

  /// Slip of a facet along a direction of a plane, t.sum_a weight_a (x_a - what it lay opposite of), as a
  /// function of these differences and the direction.
  struct PlaneSlip {
    CarriedFunction function;
    Shares shares;
  };
  PlaneSlip slip(const ContactNodes& nodes, int facet, std::span<const double> weight,
                 const std::array<double, 3>& tangent_at_rest, const std::vector<double>& u) const;

  /// Adds factor times the derivatives of f by (secondary nodes, whose weights in the place are `shape`,
  /// corners): [node][dim], and d2f to a matrix over the same.
  void add_gradient(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                    double factor, double* gradient) const;
  void add_hessian(const CarriedFunction& f, std::span<const double> shape, const Shares& shares,
                   double factor, double* block) const;

  /// Derivatives by carried places of a facet [corner][dim] become those by the corners of the carrier; and a
  /// matrix over (secondary corners, carried places) one over (secondary corners, corners of the carrier).
  void chain(int facet, const double* by_places, double* by_corners) const;
  void chain_block(int facet, std::span<const double> block, std::vector<double>& chained) const;

private:
  std::size_t dim_ = 2, corners_ = 2;
  RigidObstacle at_rest_;
  std::vector<PetscInt> node_;
  std::vector<int> slot_;
  std::array<Weights, 3> axis_{}; // of the directions x, y, z
  Shares shares_;
  std::vector<Weights> carried_; // [secondary facet][corner]
};

} // namespace impact
