#pragma once
#include <impact/math/rotation.hpp>

/// Turns of a rigid body that no moment acts on, by the implicit midpoint rule of Euler's equations with the
/// exponential map, in the axes of the body: with Q = exp(dt Omega)
///   J Omega = (Pi + Pi')/2,   Pi' = Q^T Pi.
/// Pi' - Pi is across Omega, so that energy and momentum are kept exactly; the turn is of second order, and
/// exact about a principal axis.
namespace impact {

/// The rotation vector dt Omega of a turn from the momentum Pi on. For turns below a radian or so.
Vector3 free_turn(const Matrix3& inverse_of_inertia, const Vector3& momentum, double dt);
/// dt Pi = (this matrix) (dt Omega): which momentum makes a turn.
Matrix3 momentum_by_turn(const Matrix3& inertia, const Vector3& turn);

} // namespace impact
