#pragma once
#include <impact/kernel/frame.hpp>

/// Loads on one boundary facet (line of 2 or 3 nodes in the plane; triangle of 3 or 6, quadrilateral of 4, 8
/// or 9 nodes in space), point by point, so that the caller evaluates its load where it stands. Lines run
/// with the body on their left (counter-clockwise cells), faces counter-clockwise seen from outside: the
/// normal below then points outward.
namespace impact {

inline constexpr int max_facet_nodes = 9; ///< and points

/// One quadrature point of a facet; the rule integrates N_a N_b exactly on an affine facet.
struct FacetPoint {
  double N[max_facet_nodes];
  double dN[max_facet_nodes][2];
  double weight;
};

/// q < facet_points. The corners of a facet come first, then the middles of its edges, then its own.
int facet_points(int dim, int nodes);
FacetPoint facet_point(int dim, int nodes, int q);

/// Position of the point, from node coordinates X [node][dim] to x [dim].
void facet_position(const FacetPoint&, int nodes, int dim, const double* X, double* x);

/// dA_0 of the point: its share of the reference area, with 2 pi R for axisymmetric facets. X [node][dim].
double reference_area(const FacetPoint&, int nodes, Frame, const double* X);

/// f [node][dim] += N_a t dA_0: a traction t [dim] per reference area that keeps its direction. X [node][dim]
/// are reference coordinates; axisymmetric facets carry the weight 2 pi R.
void add_dead_traction(const FacetPoint&, int nodes, Frame, const double* X, const double* t, double* f);

/// f [node][dim] -= p N_a n da: a pressure per current area along the current normal. x [node][dim] are
/// current coordinates. K [node][dim][node][dim], where not nullptr, += df/dx (unsymmetric on a boundary that
/// is not closed).
void add_follower_pressure(const FacetPoint&, int nodes, Frame, const double* x, double p, double* f,
                           double* K);

} // namespace impact
