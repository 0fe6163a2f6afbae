#pragma once
#include <impact/problem/motion.hpp>
#include <string>

namespace impact {

/// A warning about a static equilibrium `u` that a real body leaves at the least disturbance: its tangent,
/// the second variation of the energy at committed points, has negative eigenvalues, as many as the pivots of
/// its Cholesky factors (Sylvester's law of inertia). Newton's method stays on such a branch past a
/// bifurcation. Empty where there are none, and where factors would be dear or tell nothing: beyond
/// `is_factorised`, of contact that closes gaps, of a shell. Needs a symmetric tangent. Collective.
std::string tell_of_instability(MotionProblem& motion, Vec u);

} // namespace impact
