#pragma once
#include <functional>
#include <impact/kernel/frame.hpp>
#include <impact/mesh/mesh.hpp>
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

} // namespace impact
