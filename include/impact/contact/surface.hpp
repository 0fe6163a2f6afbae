#pragma once
#include <array>
#include <impact/contact/search.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/mesh.hpp>
#include <string>
#include <vector>

/// The two surfaces of a contact on this rank: edges in the plane, triangles and quadrilaterals in space, of
/// first or second order, with their reference sizes; of straight edges also neighbours. Each facet belongs
/// to the rank of its cell, so its points and multipliers have exactly one owner.
namespace impact {

/// Nodes that are stored per facet of a mesh: 2 in the plane, 4 in space, where a triangle repeats its third
/// one; of second order 3 and 6, 8 or 9, the corners first, then the middles of the sides and of the facet.
int stored_nodes(const Mesh& mesh);
/// Those among them that are corners.
constexpr int stored_corners(int per_facet) {
  return per_facet == 3 ? 2 : per_facet == 6 ? 3 : per_facet > 6 ? 4 : per_facet;
}

struct ContactSurface {
  std::string group;
  int per_facet = 2; ///< stored_nodes
  /// [facet][node] mesh nodes; an edge in the order that gives the outward normal (t_y, -t_x), a face
  /// counter-clockwise as seen from outside.
  std::vector<int> local;
  std::vector<PetscInt> node; ///< [facet][node] global nodes
  std::vector<double> X;      ///< [facet][node][dim] reference coordinates
  std::vector<double> length; ///< [facet] longest side
  std::vector<char> reversed; ///< [facet] of edges, 1: the cone of the mesh runs against the order of `local`
  /// [facet] its number as the run began, -1: it lay inside a body; empty: none of them has changed.
  std::vector<int> at_start;

  int count() const { return static_cast<int>(length.size()); }
};

/// Longest side of a facet whose corners [corner][dim] follow each other.
double longest_side(const double* corner, int corners, int dim);

/// Facets of a boundary group. Throws UserError(data) when the group is unknown, empty or no boundary, or has
/// faces of second order of two kinds.
/// Collective.
ContactSurface make_surface(const Mesh& mesh, const std::string& contact, const std::string& group);

/// The surface that these facets make.
ContactSurface surface_of(const Mesh& mesh, const std::string& group, const FacetTable& facets);

/// Global nodes of the facets of the surface that meet a node owned by this rank, whoever owns their cells;
/// sorted. Collective: one message per pair of ranks that share a facet.
std::vector<GlobalFacet> facets_at_owned_nodes(const Mesh& mesh, const ContactSurface& surface);

/// Global numbers of the far nodes of the neighbouring edges, [facet][2] (before the first node, after the
/// second), -1 at an end of the surface or where more than two edges meet; all -1 in space and of second
/// order. `layout`: the displacement's. Collective.
std::vector<PetscInt> surface_neighbours(const FieldLayout& layout, const ContactSurface& surface);

/// Abscissae in [-1, 1], ascending, and weights (sum 2) of the Gauss rule.
struct GaussRule {
  std::vector<double> xi, weight;
};
GaussRule gauss_rule(int points);

/// Places in a triangle, as parts of its corners, and weights of sum 1: 1, 3, 6 points for `points` 1, 2, 3,
/// exact to degree 1, 2, 4, and points x points from 4 on.
struct TriangleRule {
  std::vector<std::array<double, 3>> part;
  std::vector<double> weight;
};
TriangleRule triangle_rule(int points);

} // namespace impact
