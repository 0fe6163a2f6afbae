#pragma once
#include <impact/kernel/coulomb.hpp>
#include <impact/math/vector3.hpp>
#include <span>

/// Tangential motion of a contact (theory.md, contact, (81'), (81'')). What lay opposite each other at the
/// start of the step is tied to it by an opening: coefficients D_b of the nodes of a secondary facet and M_l
/// of those of a primary one, with equal sums, whose vector
///   v = sum_b D_b x_b - sum_l M_l p_l
/// changes by the relative motion. It is measured in directions r_i that the secondary facet carries along
/// with its tangents g_i = sum_b row[i][b] x_b at a place,
///   s_i = r_i.v - start_i,
/// in the plane r = g/|g|, in space the columns of the rotation R in the polar decomposition (g_1 g_2) = R U,
/// turned by what they lean (below). Traction and slip so keep their components when both sides turn as a
/// whole, and forces that are multiples of the gradients keep linear and angular momentum exactly.
namespace impact {

/// [direction][node] coefficients of the tangents: their sums are zero.
template <std::size_t dim, std::size_t nodes>
using TangentRows = std::array<std::array<double, nodes>, dim - 1>;
template <std::size_t nodes> struct Opening { std::array<double, nodes> D{}, M{}; };
template <std::size_t dim, std::size_t nodes> using FacetNodes = std::array<std::array<double, dim>, nodes>;

/// Rows whose tangents at X are unit vectors at right angles, from derivatives of the shape functions.
template <std::size_t dim, std::size_t nodes>
TangentRows<dim, nodes> tangent_rows(const FacetNodes<dim, nodes>& X, const TangentRows<dim, nodes>& natural);

/// Components [direction] of the directions of slip in the frame of a facet: its tangents, then its normal.
/// Where what lies opposite is not parallel they lie across the normal force, turned with the normal the
/// shortest way, and are as long as that force is over the pressure: a gap along the facet's own normal
/// presses with more than its pressure.
using Lean = std::array<std::array<double, 3>, 2>;
template <std::size_t dim> constexpr Lean upright() {
  Lean lean{};
  for (std::size_t i = 0; i + 1 < dim; ++i) lean[i][i] = 1;
  return lean;
}
/// `n`: components of the normal force in the frame, of either sign; `length`: of the directions.
template <std::size_t dim> Lean lean_to(const std::array<double, dim>& n, double length);

/// r_i.v, and its derivatives by the dofs of (secondary nodes, primary nodes).
template <std::size_t dim, std::size_t nodes> struct FacetSlip {
  Tangential value{};
  std::array<std::array<double, 2 * dim * nodes>, dim - 1> gradient{};
};

/// The directions of a facet at x, where many openings may be measured. Keeps references.
template <std::size_t dim, std::size_t nodes> class SlipDirections {
public:
  SlipDirections(const FacetNodes<dim, nodes>& x, const TangentRows<dim, nodes>& rows, bool with_gradient);
  /// Without derivatives where the directions have none.
  FacetSlip<dim, nodes> slip(const FacetNodes<dim, nodes>& p, const Opening<nodes>& opening,
                             const Lean& lean = upright<dim>()) const;
  /// Components in the frame, of a vector and of v.
  std::array<double, dim> components(const std::array<double, dim>& vector) const;
  std::array<double, dim> opened(const FacetNodes<dim, nodes>& p, const Opening<nodes>& opening) const;

private:
  static constexpr std::size_t variables = dim * (dim - 1); // components of the tangents

  const FacetNodes<dim, nodes>& x_;
  const TangentRows<dim, nodes>& rows_;
  bool with_gradient_;
  std::array<std::array<double, dim>, dim> frame_{};
  std::array<std::array<std::array<double, variables>, dim>, dim> by_tangents_{};
};

/// Adds the second derivatives of sum_i e_i.v_i, one opening per vector e_i of the frame, a square over the
/// dofs of both facets row by row, to `hessian`; symmetric and exact.
template <std::size_t dim, std::size_t nodes>
void add_slip_hessian(const FacetNodes<dim, nodes>& x, const FacetNodes<dim, nodes>& p,
                      const TangentRows<dim, nodes>& rows, const std::array<Opening<nodes>, dim>& opening,
                      std::span<double> hessian);

/// Unit vectors at right angles to n: of the x axis, or of y where that is near n, and across.
std::array<Vector3, 2> tangents_of(const Vector3& n);
/// The directions of a straight face, at the middle of a quadrilateral, in the reference configuration.
struct FaceMap {
  TangentRows<3, 4> row{};
  std::array<Vector3, 2> axis{}; ///< of the tangents
  Vector3 normal{};              ///< outward
};
FaceMap make_face_map(const FacetNodes<3, 4>& X); ///< of corners, of which a triangle repeats its third
/// Components [of t][of axis] of a node's tangents in a face: the vectors t, at right angles to n, once n is
/// turned to the face's normal the shortest way.
std::array<std::array<double, 2>, 2> turned_into(const FaceMap& face, const Vector3& n,
                                                 const std::array<Vector3, 2>& t);

} // namespace impact
