#pragma once
#include <impact/problem/motion.hpp>
#include <string>

/// Whether a static equilibrium is one at which bodies stay: whether its tangent, the Hessian of the energy
/// at committed points, has no negative eigenvalue. Newton's method stays on its branch past a bifurcation.
namespace impact {

struct UnstableModes {
  PetscInt number = 0;
  double part = 0; ///< of the displacement of free dofs, that lies along the modes
};

/// The modes of the motion's matrix at `u` with negative eigenvalues, as many as its Cholesky factors have
/// negative pivots (Sylvester's law of inertia); none where a cell has no energy. Where there are some
/// `direction`, unless null, becomes one of negative curvature, its largest component 1: that to which an
/// imperfect body buckles, which `scattered` makes of a perfect one. Needs a symmetric tangent. Collective.
UnstableModes find_unstable_modes(MotionProblem& motion, Vec u, bool scattered, Vec direction);

/// A warning about an unstable equilibrium `u`. Empty where it is none, and where factors tell nothing: of
/// contact that closes gaps, of a shell. `path`: of one along which a load may fall, which `falls`, by a mode
/// that the path holds. Needs a symmetric tangent. Collective.
std::string tell_of_instability(MotionProblem& motion, Vec u, bool path, bool falls);

} // namespace impact
