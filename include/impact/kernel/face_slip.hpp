#pragma once
#include <impact/kernel/contact_slip.hpp>
#include <impact/kernel/mortar_segment.hpp>

/// Tangential motion of a contact in space (theory.md, contact): what contact_slip.hpp says of edges, of
/// faces. An anchor is what lay opposite each other at the start of the step: for each function Phi_a of the
/// secondary face the integrals D_ab, M_al over the part that one primary face covered then, whose opening
/// vectors
///   v_a = sum_b D_ab x_b - sum_l M_al p_l
/// change by the relative motion. They are measured in two directions r_1, r_2 that the secondary face
/// carries along: the columns of the rotation R in the polar decomposition (g_1 g_2) = R U of the map from
/// its reference plane,
///   s_a,beta = r_beta.v_a - start_a,beta,
/// so that traction and slip keep their components when both sides turn as a whole, and forces that are
/// multiples of the gradients keep linear and angular momentum exactly. U is the same on faces that share a
/// plane and a deformation: their directions are too.
namespace impact {

/// The plane of a face in the reference configuration, at the middle of a quadrilateral.
struct FaceMap {
  std::array<Point3, 2> axis{};               ///< unit vectors of the plane, across each other
  Point3 normal{};                            ///< outward
  std::array<std::array<double, 4>, 2> row{}; ///< g_i = sum_a row[i][a] x_a, derivative of x along axis i
};
FaceMap make_face_map(const FaceCorners& X);

/// Unit vectors at right angles to n: of the x axis where it is not too near n, else of the y axis, and
/// across.
std::array<Point3, 2> tangents_of(const Point3& n);
/// Components [of t][of axis] of a node's tangents in a face: the vectors t, at right angles to n, once n is
/// turned to the face's normal the shortest way.
std::array<std::array<double, 2>, 2> turned_into(const FaceMap& face, const Point3& n,
                                                 const std::array<Point3, 2>& t);

struct FacetAnchor {
  MortarWeights weights;
  std::array<std::array<double, 2>, 4> start{}; ///< r_beta.v_a at the start of the step
};

/// Of each function a: components of the slip, and their derivatives by the dofs of MortarPair.
struct FacetSlips {
  std::array<std::array<double, 2>, 4> value{};
  std::array<std::array<std::array<double, 24>, 2>, 4> gradient{};
};
/// Without derivatives where `with_gradient` is false.
FacetSlips facet_slips(const FaceCorners& x, const FaceCorners& p, const FaceMap& map,
                       const FacetAnchor& anchor, bool with_gradient);
/// Adds sum factor[a][beta] d2s_a,beta, 24 x 24 row by row, to `hessian`; symmetric and exact.
void add_slip_hessian(const FaceCorners& x, const FaceCorners& p, const FaceMap& map,
                      const FacetAnchor& anchor, const std::array<std::array<double, 2>, 4>& factor,
                      std::span<double> hessian);

/// The same of edges, whose only direction needs no map: for each function the slip of contact_slip.hpp, and
/// 8 x 8 second derivatives.
FacetSlips facet_slips(const EdgeCorners& x, const EdgeCorners& p, const FaceMap&, const FacetAnchor& anchor,
                       bool);
void add_slip_hessian(const EdgeCorners& x, const EdgeCorners& p, const FaceMap&, const FacetAnchor& anchor,
                      const std::array<std::array<double, 2>, 4>& factor, std::span<double> hessian);

} // namespace impact
