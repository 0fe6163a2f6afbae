#pragma once
#include <impact/kernel/frame.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/mesh.hpp>
#include <string>
#include <vector>

/// The two surfaces of a contact on this rank: edges with their reference lengths, integration points and
/// neighbours. Each edge belongs to the rank of its cell, so its points and multipliers have exactly one
/// owner.
namespace impact {

struct ContactSurface {
  std::string group;
  std::vector<int> local; ///< [facet][2] mesh nodes, in the order that gives the outward normal (t_y, -t_x)
  std::vector<PetscInt> node; ///< [facet][2] global nodes
  std::vector<double> X;      ///< [facet][2][2] reference coordinates
  std::vector<double> length; ///< [facet] reference length
  std::vector<char> reversed; ///< [facet] 1: the cone of the mesh runs against the order of `local`

  int count() const { return static_cast<int>(length.size()); }
};

/// Integration points of the secondary surface. Points are numbered along the cone of the facet in the mesh,
/// which is the same for every partition, so that what is kept per point can move to other ranks.
struct SurfacePoints {
  int per_facet = 0;
  std::vector<double> shape;  ///< [facet][point][2] shape functions of the facet's nodes
  std::vector<double> weight; ///< [facet][point] reference area: per unit thickness, or of the full ring
};

/// Facets of a boundary group. Throws UserError(data) when the group is unknown, empty or not of dimension 1.
/// Collective.
ContactSurface make_surface(const Mesh& mesh, const std::string& contact, const std::string& group);

/// Gauss points, 1 to 16 per facet; exact for polynomials of degree 2 points - 1. Throws UserError(usage).
SurfacePoints make_points(const ContactSurface& surface, const std::string& contact, int per_facet,
                          Frame frame);

/// Global numbers of the far nodes of the neighbouring edges, [facet][2] (before the first node, after the
/// second), -1 at an end of the surface or where more than two edges meet. `layout`: any two-component field.
/// Collective.
std::vector<PetscInt> surface_neighbours(const FieldLayout& layout, const ContactSurface& surface);

/// Abscissae in [-1, 1], ascending, and weights (sum 2) of the Gauss rule.
struct GaussRule {
  std::vector<double> xi, weight;
};
GaussRule gauss_rule(int points);

} // namespace impact
