#pragma once
#include <impact/mesh/sparse_assembly.hpp>
#include <impact/problem/discretisation.hpp>
#include <impact/problem/settings.hpp>
#include <optional>
#include <petscsnes.h>
#include <string>

/// Which solver the motion has where the options say nothing: preonly + MUMPS up to 2e4 dofs, in the
/// plane fgmres + MUMPS up to 1.5e6, by Cholesky factors unless friction, rigid bodies, follower pressure or
/// F-bar spoil the symmetry, beyond them gmres + gamg; where the tangent is symmetric, in space cg +
/// two_level from 5e3 dofs on, cg + jacobi where steps resolve waves, with gmres for cg under friction in
/// space. The scalar fields have theirs in petsc/field_solver.hpp. `tools/bench_solvers` is the evidence.
namespace impact {

enum class LinearMethod {
  factors,      ///< preonly + lu, or cholesky where a static step has an energy
  kept_factors, ///< fgmres + lu, whose factors serve on
  half_factors, ///< fgmres + cholesky of the upper half of a tangent that is symmetric or nearly so
  multigrid,    ///< gmres + gamg
  two_level,    ///< cg + two_level
  diagonal      ///< cg + jacobi
};

/// Which linear solver and tangent are used where the options say nothing; `reason` is
/// printed.
struct SolverDefaults {
  LinearMethod method = LinearMethod::factors;
  bool symmetric = false;
  bool half_suffices = false; ///< the tangent is symmetric, or nearly so: of flow and viscosity
  bool slides = false;        ///< friction spoils the symmetry of the matrix: gmres for cg
  bool has_energy = false;    ///< that a static step makes stationary: the tangent is its Hessian
  MatrixFormat matrix = MatrixFormat::aij; ///< sbaij: Cholesky for LU, incomplete Cholesky for multigrid
  double cfl = 0;                          ///< dt c_p / shortest edge; 0 without inertia
  bool resolves_waves() const { return cfl > 0 && cfl <= 20; }
  std::string reason;
  bool chosen = false; ///< by options
};
/// What forces other than those of the cells ask of the linear solver.
struct SolverDemands {
  bool closes_gaps = false; ///< contacts, by weights that spoil the condition for an iterative method
  bool frictional = false;  ///< the tangent of sliding is not symmetric
  bool rigid = false;       ///< nor is that of rigid bodies that turn
  bool unsymmetric = false; ///< any of these, or a follower pressure
  bool path = false;        ///< past the limits of loads tangents are indefinite
};
/// Reads -motion_ksp_type and -motion_pc_type to see whether the user chose. Not collective.
SolverDefaults choose_solver(const Discretisation& discretisation, TangentChoice tangent, bool inertia,
                             double dt, SolverDemands demands = {},
                             std::optional<MatrixFormat> matrix = std::nullopt);

/// Whether an iterative solver that nobody asked for may give way to factors where it fails.
bool may_factorise(const Discretisation& discretisation, const SolverDefaults& defaults);

/// Gives the motion's solver its defaults and reads its options. `search`: basic for full steps;
/// `shell`: its matrix is one, whose preconditioner sees the bulk alone. Throws UserError(usage) for choices
/// that cannot work. Collective.
void set_motion_solver(SNES snes, const SolverDefaults& defaults, SNESLineSearchType search, bool shell);

} // namespace impact
