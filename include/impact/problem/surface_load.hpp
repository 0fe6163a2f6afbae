#pragma once
#include <functional>
#include <impact/kernel/boundary_load.hpp>
#include <impact/mesh/middle_values.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/discretisation.hpp>
#include <petscmat.h>
#include <span>
#include <vector>

/// Loads on boundary facets: dead tractions per reference area and follower pressures per current area.
/// Facets are edges, triangles and quadrilaterals; axisymmetric edges carry 2 pi R.
namespace impact {

/// force [node][dim] += int N_a t dA_0; t(x, value) gives the traction at a reference point.
void add_dead_traction(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                       const std::function<void(const double* x, double* value)>& traction,
                       std::vector<double>& force);

/// area [node][dim] += int |N_a| sum_b |N_b| dA_0: as much of int N_a N_b as a node can feel, whatever the
/// signs of the functions; int N_a dA_0 of first order.
void add_felt_area(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                   std::vector<double>& area);

/// force [node][dim] += -int N_a p n da over the deformed facets; p(x) at the reference point, n outward.
void add_follower_pressure(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                           const std::vector<double>& u,
                           const std::function<double(const double* x)>& pressure,
                           std::vector<double>& force);

/// matrix += d/du of the same force by MatSetValues; rows and columns of `fixed` local dofs are left out. The
/// caller assembles. Unsymmetric where the loaded surface has an edge.
void add_follower_pressure_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                                   const std::vector<double>& u,
                                   const std::function<double(const double* x)>& pressure,
                                   const std::vector<char>& fixed, std::span<const PetscInt> global_node,
                                   Mat matrix);

/// Heat through the facets of a group at one time: a given flux inwards, or h (theta_around - theta), per
/// reference area, at the points of the facets.
struct SurfaceHeat {
  std::vector<double> coefficient, inflow; ///< [facet][point]: h, and flux or h theta_around
};

/// weight * int (inflow - coefficient theta) dA_0, which load [node] += N_a of it. theta [node].
double add_surface_heat(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                        const SurfaceHeat& heat, const std::vector<double>& theta, double weight,
                        std::vector<double>& load);

/// matrix += weight * int coefficient N_a N_b dA_0 by MatSetValues; rows and columns of `held` nodes are left
/// out. The caller assembles.
void add_surface_heat_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                              const SurfaceHeat& heat, double weight, const std::vector<char>& held,
                              const MiddleValues* middles, std::span<const PetscInt> global_node, Mat matrix);

/// body(facet, point, position [dim]) at all points of the facets, in the order of SurfaceHeat.
void for_each_facet_point(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                          const std::function<void(std::size_t index, const double* x)>& body);

/// Entries that SurfaceHeat has per facet.
inline constexpr int points_per_facet = max_facet_nodes;

/// int dA_0 over the facets of this rank; in a plane per thickness.
double area_of(const FacetTable& facets, Frame frame, const std::vector<double>& X);

} // namespace impact
