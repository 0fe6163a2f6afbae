#pragma once
#include <impact/math/vector3.hpp>

/// Rotations in space as matrices and vectors. A plane rotation is one about the third axis.
namespace impact {

using Matrix3 = std::array<double, 9>; ///< row by row

inline constexpr Matrix3 unit_matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1};

Matrix3 operator*(const Matrix3& a, const Matrix3& b);
Vector3 operator*(const Matrix3& a, const Vector3& x);
Matrix3 transposed(const Matrix3& a);
double trace(const Matrix3& a);
double determinant(const Matrix3& a);
/// Of a matrix with a determinant.
Matrix3 inverse(const Matrix3& a);
/// a x: the matrix W with W x = a x x.
Matrix3 cross_matrix(const Vector3& a);
/// w with sum_jk e_ijk A_kj: the sum of r x f where A is the sum of f r^T.
Vector3 axial(const Matrix3& a);

/// The rotation R nearest to A, largest trace of R^T A: the orthogonal factor of A = R U (Newton's iteration
/// for the polar decomposition, N. J. Higham 1986). det A > 0; for others the entries are not numbers.
Matrix3 nearest_rotation(const Matrix3& a);
/// exp of a rotation vector: axis times angle.
Matrix3 rotation_of(const Vector3& vector);
/// Rotation vector of length 0 to pi.
Vector3 rotation_vector(const Matrix3& rotation);
/// Cayley's transform of a vector 2 tan(angle/2) along the axis: x_1 - x_0 = c x (x_0 + x_1)/2.
Matrix3 cayley(const Vector3& c);
/// Its inverse, for angles below pi.
Vector3 cayley_vector(const Matrix3& rotation);

} // namespace impact
