#pragma once
#include <array>
#include <impact/kernel/mortar_face.hpp>

/// Contact of one point of a secondary face with one triangle of a primary face in space (theory.md,
/// contact). The gap is measured along the secondary face's own normal n, at the middle of a quadrilateral,
/// to the plane of the triangle,
///   g = (v_0 - x).m / (n.m),   m = (v_1 - v_0) x (v_2 - v_0),
/// so that every place of the secondary surface looks at one place of the primary, over its edges too. The
/// gap depends on the nodes of the two faces alone and does not change under rigid motions: forces that are
/// multiples of its gradient keep linear and angular momentum exactly. A quadrilateral primary is the four
/// triangles of mortar_face.hpp.
namespace impact {

/// A point of a secondary face, `shape` the weights of its corners, and a triangle of a primary face.
struct FaceRay {
  FaceCorners x;
  std::array<double, 4> shape;
  FaceCorners p;
  TriangleWeights triangle;
};

struct RayFoot {
  double gap = 0;                  ///< negative behind the triangle
  double opposition = 0;           ///< product of the two unit normals, -1 where they oppose
  std::array<double, 3> part{};    ///< of the triangle's corners in the foot, sum 1; negative beyond a side
  std::array<double, 3> normal{};  ///< of the triangle
  std::array<double, 4> weights{}; ///< of the primary face's corners in the foot
};

RayFoot cast_ray(const FaceRay& ray);

/// dg as a row over the dofs of (secondary corners 0 .. 3, primary corners 0 .. 3), x before y before z. Dofs
/// of a corner that a triangle repeats are zero.
std::array<double, 24> ray_gradient(const FaceRay& ray);

/// Adds factor d2g, 24 x 24 row by row, to `hessian`; symmetric and exact.
void add_ray_hessian(const FaceRay& ray, double factor, std::span<double> hessian);

} // namespace impact
