#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/solve/stability.hpp>
#include <petscblaslapack.h>

namespace impact {

namespace {

Handle<Mat> factorise(Mat A) {
  Handle<Mat> factors;
  MatFactorInfo how;
  check(MatFactorInfoInitialize(&how));
  check(MatGetFactor(A, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, factors.out()));
  check(MatMumpsSetIcntl(factors, 13, 1)); // pivots of a root that ranks share by ScaLAPACK are not counted
  check(MatCholeskyFactorSymbolic(factors, A, nullptr, &how));
  check(MatCholeskyFactorNumeric(factors, A, &how));
  return factors;
}

// On free dofs -u: past a load at which it buckles, an imperfect body that does not bends to the other side
// than below it. With `scattered` also little numbers of any sign that follow the places, not the ranks.
void start_direction(const MotionProblem& motion, Vec u, bool scattered, Vec x) {
  const Discretisation& d = motion.discretisation();
  const double size = Get(VecNorm)(u, NORM_INFINITY), little = !scattered ? 0 : size > 0 ? 1e-6 * size : 1;
  std::vector<double> local = d.local_of(u);
  const auto X = d.mesh.coordinates();
  const auto dim = static_cast<std::size_t>(d.dim());
  for (std::size_t i = 0; i < local.size(); ++i) {
    double sum = static_cast<double>(i % dim);
    for (std::size_t k = 0; k < dim; ++k)
      sum += static_cast<double>(k + 1) * X[i / dim * dim + k] / d.mesh.smallest_edge();
    local[i] = motion.boundary().fixed_mask()[i] ? 0 : little * std::sin(12.9898 * sum) - local[i];
  }
  d.displacement.to_global(local, x);
}

// Of a symmetric tridiagonal matrix: the first unit vector without its part in the eigenvectors whose
// eigenvalue is not negative.
std::vector<double> negative_part(std::vector<double> diagonal, std::vector<double> beside) {
  const std::size_t n = diagonal.size();
  const auto size = static_cast<PetscBLASInt>(n);
  std::vector<double> vectors(n * n), work(2 * n), part(n, 0.0);
  PetscBLASInt info = 0;
  LAPACKsteqr_("I", &size, diagonal.data(), beside.data(), vectors.data(), &size, work.data(), &info);
  for (std::size_t i = 0; i < n && diagonal[i] < 0; ++i) // they ascend
    for (std::size_t k = 0; k < n; ++k) part[k] += vectors[i * n] * vectors[i * n + k];
  return part;
}

// By Lanczos' method for the inverse, whose negative eigenvalues lie at an end of its spectrum: y, the part
// of x in their space as far as it is found, becomes x = -inverse y, whose curvature -x.y is negative. Modes
// come in pairs where sections are square, and of their plane it takes the direction that x has. The size of
// y over that of x.
double find_direction(Mat factors, Vec x) {
  constexpr int most = 30;
  std::vector<Handle<Vec>> basis;
  std::vector<double> diagonal, beside;
  double largest = 0;
  for (int k = 0; k < most; ++k) {
    const PetscReal norm = Get(VecNorm)(x, NORM_2);
    if (norm == 0 && k == 0) return 0;
    if (k > 0 && norm <= 1e-10 * largest) break; // all of the space
    if (k > 0) beside.push_back(norm);
    largest = std::max(largest, norm);
    check(VecScale(x, 1 / norm));
    check(VecDuplicate(x, basis.emplace_back().out()));
    check(VecCopy(x, basis.back()));
    check(MatSolve(factors, basis.back(), x));
    diagonal.push_back(Get(VecDot)(x, basis.back()));
    largest = std::max(largest, std::abs(diagonal.back()));
    for (int again = 0; again < 2; ++again)
      for (const Handle<Vec>& q : basis) check(VecAXPY(x, -Get(VecDot)(x, q), q));
  }
  const std::vector<double> part = negative_part(diagonal, beside);
  if (part[0] <= 0) return 0;
  check(VecScale(basis[0], part[0]));
  for (std::size_t k = 1; k < part.size(); ++k) check(VecAXPY(basis[0], part[k], basis[k]));
  check(MatSolve(factors, basis[0], x));
  check(VecScale(x, -1 / Get(VecNorm)(x, NORM_INFINITY)));
  return std::sqrt(part[0]);
}

} // namespace

UnstableModes find_unstable_modes(MotionProblem& motion, Vec u, bool scattered, Vec direction) {
  UnstableModes modes;
  if (!motion.tangent(u, 0)) return modes;
  const Handle<Mat> factors = factorise(motion.matrix());
  check(MatMumpsGetInfog(factors, 12, &modes.number));
  if (modes.number <= 0 || direction == nullptr) return modes;
  start_direction(motion, u, scattered, direction);
  modes.part = find_direction(factors, direction);
  return modes;
}

std::string tell_of_instability(MotionProblem& motion, Vec u, bool path, bool falls) {
  if (motion.jacobian() != motion.matrix() || motion.contacts().demands().closes_gaps) return "";
  const PetscInt modes = find_unstable_modes(motion, u, false, nullptr).number;
  if (modes <= (falls ? 1 : 0)) return "";
  return text_of("impact: WARNING: the equilibrium at the end is unstable, its tangent has %d negative "
                 "eigenvalue%s: a load where bodies buckle or snap was passed, and real ones leave this "
                 "branch: give them an imperfection of the shape or a small load aside%s\n",
                 static_cast<int>(modes), modes == 1 ? "" : "s",
                 path ? "" : ", -motion_leave_unstable on, or inertia (-ts_type newmark)");
}

} // namespace impact
