#pragma once
#include <array>
#include <functional>
#include <impact/math/vector3.hpp>
#include <span>

/// Mortar contact of one secondary face with one primary face in space (theory.md, contact). A triangle is
/// taken as it is; a quadrilateral as the four triangles about the mean of its corners, on which the
/// displacement is linear. The nodal forces of a uniform pressure on a flat quadrilateral are then exactly
/// those of its bilinear shape functions, whatever its angles.
///
/// A primary triangle is projected along the normal of the secondary one. In the barycentric coordinates of
/// the secondary triangle the part that it covers is a polygon, on which the gap is linear, so that the
/// weighted gaps
///   G_a = int Phi_a g dA_0,   a = 0 .. corners - 1
/// have a closed form. They depend on the nodes of the two faces alone and do not change under rigid motions:
/// forces that are multiples of their gradients keep linear and angular momentum exactly. Neighbouring
/// primary faces share the border of their parts and the gap there.
namespace impact {

using Point3 = Vector3;
/// Corners in the order that gives the outward normal; a triangle repeats its third corner.
using FaceCorners = std::array<Point3, 4>;

/// A secondary face in the reference configuration.
struct MortarFace {
  int corners = 3;
  std::array<double, 4> area{};               ///< of its triangles
  std::array<std::array<double, 4>, 4> phi{}; ///< Phi_a = sum_b phi[a][b] N_b

  int triangles() const { return corners == 3 ? 1 : 4; }
};

/// Different corners of a face.
inline int corners_of(const FaceCorners& x) { return x[3] == x[2] ? 3 : 4; }

/// The corners of a face's triangle as sums over those of the face: [corner of the triangle][corner].
using TriangleWeights = std::array<std::array<double, 4>, 3>;
TriangleWeights triangle_weights(int corners, int triangle);
/// Standard functions Phi_a = N_a, or those biorthogonal to N_b over the whole face: int Phi_a N_b = delta_ab
/// int N_b.
MortarFace make_mortar_face(const FaceCorners& X, bool dual);
/// int N_a over the face at the corners x: its nodal areas.
std::array<double, 4> nodal_areas(const FaceCorners& x);
/// Unit outward normal of a triangle, or of a quadrilateral at its middle.
Point3 facet_normal(const FaceCorners& x);

/// Where a primary facet lies as seen from a secondary one.
struct FacetView {
  double part = 0;     ///< of the secondary facet that it covers, between 0 and 1
  double smallest = 0; ///< gap over that part; where it covers none, at the primary's corners or nearest end
  double largest = 0, mean = 0; ///< likewise
};
FacetView view_facet(const FaceCorners& x, const FaceCorners& p);
/// How far apart balls about the two faces are, across the normal of the secondary one and less their
/// distance along it. Where it is positive nothing is covered, unless a face is bent by more than 45 degrees.
double clearance(const FaceCorners& x, const FaceCorners& p);
/// Part of the secondary face, between 0 and 1, that both primary faces cover.
double common_part(const FaceCorners& x, const FaceCorners& a, const FaceCorners& b);
/// Gap at a corner of the secondary face; false where the primary face does not cover it.
bool corner_gap(const FaceCorners& x, int corner, const FaceCorners& p, double& gap);

/// Weighted gaps of a pair, and the derivatives by the dofs of (secondary corners, primary corners), [corner]
/// [dim] in a row, of faces always four of each. Dofs of a corner that a triangle repeats are zero.
struct MortarPair {
  bool covered = false;                             ///< part of the secondary facet is
  bool touched = false;                             ///< false: all zero; true without `covered`: along a side
  std::array<double, 4> gap{};                      ///< G_a
  std::array<double, 4> cover{};                    ///< int Phi_a over the covered part
  std::array<std::array<double, 24>, 4> gradient{}; ///< dG_a
};
/// Without derivatives where `with_gradient` is false.
MortarPair mortar_pair(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                       bool with_gradient);

/// Adds sum_a factor[a] d2G_a, 24 x 24 row by row, to `hessian`; symmetric and exact. False: nothing is
/// touched.
bool add_mortar_hessian(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                        const std::array<double, 4>& factor, std::span<double> hessian);

/// Integrals over the part of the secondary facet that the primary one covers: D_ab = int Phi_a N_b dA_0 and
/// M_al = int Phi_a N_l dA_0 with the shape functions N_l of the primary at the projected places. Rows of
/// both have equal sums, and sum_b D_ab x_b - sum_l M_al p_l = -int Phi_a g n dA_0.
struct MortarWeights {
  bool covered = false; ///< false: all zero
  std::array<std::array<double, 4>, 4> D{}, M{};
};
MortarWeights mortar_weights(const FaceCorners& x, const FaceCorners& p, const MortarFace& face);

/// A triangle of that part (of an edge: an interval, with two corners), in which the places on both sides are
/// linear: [its corner][corner of the facet], as sums over the corners of the secondary and the primary one.
struct CoveredPiece {
  double area = 0;                               ///< reference area, without what `ring` has of it
  std::array<double, 3> ring = {1, 1, 1};        ///< at its corners (MortarEdge)
  TriangleWeights secondary{}, primary{}, phi{}; ///< phi: [its corner][a], Phi_a
  Point3 normal{};                               ///< of the secondary facet there
};
using PieceVisitor = std::function<void(const CoveredPiece&)>;
void visit_covered(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                   const PieceVisitor& visitor);

} // namespace impact
