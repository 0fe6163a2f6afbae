#include <algorithm>
#include <cmath>
#include <impact/mesh/two_level.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/slope_search.hpp>
#include <impact/solve/solver_defaults.hpp>
#include <string_view>

namespace impact {

namespace {

std::string option_text(const char* name) {
  char text[128] = "";
  PetscBool set = PETSC_FALSE;
  check(PetscOptionsGetString(nullptr, nullptr, name, text, sizeof(text), &set));
  return set ? text : "";
}

// Unknowns in space whose factors are still cheaper than GMRES with GAMG, whose iterations grow with K / G.
// K / G 2000 under pressure, tetrahedra of second order: 15 s for 78 (2.6e4 unknowns, 4 steps), 29 s and 2 GB
// for 87 s and 0.6 GB (1.06e5, one step).
constexpr long long most_factorised = 200000;

int ranks_of(KSP ksp) {
  int ranks = 1;
  MPI_Comm_size(PetscObjectComm(reinterpret_cast<PetscObject>(ksp)), &ranks);
  return ranks;
}

// Before the options are read.
void set_linear_solver(KSP ksp, const SolverDefaults& defaults) {
  const bool half = defaults.matrix == MatrixFormat::sbaij;
  const PC pc = Get(KSPGetPC)(ksp);
  const auto take = [&](KSPType krylov, PCType preconditioner, PetscInt most, double rtol = 1e-8) {
    check(KSPSetType(ksp, krylov));
    check(PCSetType(pc, preconditioner));
    check(KSPSetTolerances(ksp, rtol, PETSC_DEFAULT, PETSC_DEFAULT, most));
  };
  // What slides asks full steps of Newton's method: solves to 1e-6 need no more of them than exact ones,
  // solves to 1e-4 three times as many where points open.
  const auto iterate = [&](PCType preconditioner) {
    take(defaults.slides ? KSPGMRES : KSPCG, preconditioner, 10000, defaults.slides ? 1e-6 : 1e-8);
  };
  // One application of the factors in each iteration; GMRES has another one in each solve.
  switch (defaults.method) {
  case LinearMethod::factors:
  case LinearMethod::kept_factors:
  case LinearMethod::half_factors:
    take(defaults.method == LinearMethod::factors ? KSPPREONLY : KSPFGMRES,
         half || defaults.has_energy || defaults.method == LinearMethod::half_factors ? PCCHOLESKY : PCLU,
         1000);
    return check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  case LinearMethod::multigrid:
    // The blocks of bjacobi are factorised like the matrix of one rank: a symmetric format by ICC.
    return take(KSPGMRES, !half ? PCGAMG : ranks_of(ksp) == 1 ? PCICC : PCBJACOBI, half ? 10000 : 1000);
  case LinearMethod::two_level:
    return iterate(two_level_type);
  case LinearMethod::diagonal:
    return iterate(PCJACOBI);
  }
}

// Linear solves no more exact than the Newton iteration around them deserves, unless the options say how
// exact (S. Eisenstat, H. Walker, SIAM J. Sci. Comput. 17 (1996) 16, choice 2, not below what is left to do).
void set_forcing(SNES snes, double forcing) {
  if (!option_text("-motion_ksp_rtol").empty()) return;
  check(SNESKSPSetUseEW(snes, PETSC_TRUE));
  check(SNESKSPSetParametersEW(snes, 3, forcing, forcing, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT,
                               PETSC_DEFAULT));
}

// Throws UserError(usage) when the options gave `ksp` a preconditioner that cannot work with the matrix.
void check_preconditioner(KSP ksp, MatrixFormat matrix) {
  if (matrix != MatrixFormat::sbaij) return;
  const PC pc = Get(KSPGetPC)(ksp);
  const PCType type = Get(PCGetType)(pc);
  const int ranks = ranks_of(ksp);
  const std::string name = type ? type : PCNONE;
  if (name == PCCHOLESKY || name == PCBJACOBI || name == PCJACOBI || name == PCNONE || name == two_level_type)
    return;
  if (name == PCICC && ranks == 1) return;
  throw UserError(ExitCode::usage,
                  "-motion_pc_type \"" + name +
                      "\": cannot work with -motion_mat_type sbaij; allowed: cholesky, " +
                      (ranks == 1 ? "icc, " : "") +
                      "bjacobi, jacobi, two_level, none; choose one of them, or -motion_mat_type aij");
}

} // namespace

SolverDefaults choose_solver(const Discretisation& d, TangentChoice tangent, bool inertia, double dt,
                             SolverDemands demands, std::optional<MatrixFormat> matrix) {
  SolverDefaults choice;
  const auto dofs = d.mesh.global_node_count() * d.dim();
  double speed = 0;
  bool flows = false;
  bool keeps_volume = false; // so that iterations grow with K / G
  // Stresses of viscosity and the consistent tangent of flow differ from symmetry by far less than a digit.
  choice.half_suffices = !demands.unsymmetric;
  for (const PointLaw& law : d.laws) {
    const MaterialParameters& p = law.parameters;
    if (law.rigid()) continue;
    if (p.rho > 0) speed = std::max(speed, longitudinal_speed(p));
    flows = flows || law.flows();
    keeps_volume = keeps_volume || p.K > 100 * p.G;
    choice.half_suffices = choice.half_suffices && p.locking != Locking::fbar;
  }
  choice.cfl = inertia ? dt * speed / d.mesh.smallest_edge() : 0;
  const bool plane = d.dim() == 2, small = is_factorised(d.mesh), slides = demands.frictional,
             may_iterate = !d.has_viscosity() && !demands.rigid && !demands.path && !(slides && plane) &&
                           !(demands.closes_gaps && (small || slides));
  choice.slides = slides;
  choice.has_energy = choice.half_suffices && !flows && !d.has_viscosity() && !inertia &&
                      !demands.closes_gaps && !d.has_damage();
  choice.reason = text_of("%lld dofs", static_cast<long long>(dofs));
  if (choice.resolves_waves() && may_iterate) {
    choice.method = LinearMethod::diagonal;
    choice.reason = text_of("dt is %.3g times h/c_p", choice.cfl);
  } else if (!plane && may_iterate && (slides || !demands.unsymmetric) &&
             dofs > (keeps_volume ? 20000 : 5000) && tangent != TangentChoice::consistent)
    choice.method = LinearMethod::two_level;
  else if (!small && !((keeps_volume || demands.path) && dofs <= most_factorised && !demands.closes_gaps))
    choice.method = LinearMethod::multigrid;
  else if (plane && dofs > 20000 && choice.half_suffices)
    choice.method = LinearMethod::half_factors;
  else if (dofs > 20000 && !demands.closes_gaps)
    choice.method = LinearMethod::kept_factors;

  const std::string ksp = option_text("-motion_ksp_type"), pc = option_text("-motion_pc_type");
  // A preconditioner that only improves a guess wants a Krylov method around it, and exact factors want none.
  const bool exact = pc == "lu" || pc == "cholesky";
  if (choice.method == LinearMethod::two_level && (exact || ksp == KSPPREONLY))
    choice.method = LinearMethod::factors;
  else if (ksp.empty() && !pc.empty() && !exact && choice.method != LinearMethod::diagonal)
    choice.method = LinearMethod::multigrid;
  const auto iterates = [&] {
    return choice.method == LinearMethod::two_level || choice.method == LinearMethod::diagonal;
  };
  choice.symmetric = iterates() && !slides;
  if (!ksp.empty()) choice.symmetric = ksp == KSPCG || ksp == KSPMINRES;
  choice.chosen = !ksp.empty() || !pc.empty();
  if (choice.chosen) choice.reason = "chosen by options";
  if (tangent != TangentChoice::automatic) choice.symmetric = tangent == TangentChoice::symmetric;
  // Products and assembly of the half take less than half the time of a run with conjugate gradients.
  const bool half = iterates() && ksp.empty() && pc.empty() && choice.symmetric && !demands.unsymmetric;
  choice.matrix = matrix.value_or(half ? MatrixFormat::sbaij : MatrixFormat::aij);
  return choice;
}

bool may_factorise(const Discretisation& d, const SolverDefaults& defaults) {
  const bool iterates = defaults.method == LinearMethod::multigrid ||
                        defaults.method == LinearMethod::two_level ||
                        defaults.method == LinearMethod::diagonal;
  return iterates && !defaults.chosen && can_be_factorised(d.mesh);
}

void set_motion_solver(SNES snes, const SolverDefaults& defaults, SNESLineSearchType search, bool shell) {
  const KSP ksp = Get(SNESGetKSP)(snes);
  const PC pc = Get(KSPGetPC)(ksp);
  set_linear_solver(ksp, defaults);
  if (shell) {
    // The preconditioner sees the bulk alone: a direct "solve" with it would solve the wrong system, and
    // GAMG's smoothers must not take the shell for their matrix.
    if (defaults.method == LinearMethod::factors)
      check(KSPSetTolerances(ksp, 1e-10, PETSC_DEFAULT, PETSC_DEFAULT, 1000));
    check(KSPSetType(ksp, KSPGMRES));
    check(PCSetUseAmat(pc, PETSC_FALSE));
  }
  register_slope_search();
  check(SNESLineSearchSetType(Get(SNESGetLineSearch)(snes), search));
  if (defaults.method != LinearMethod::factors && defaults.method != LinearMethod::diagonal &&
      search != std::string_view(SNESLINESEARCHBASIC))
    set_forcing(snes,
                defaults.method == LinearMethod::two_level || defaults.method == LinearMethod::half_factors
                    ? 1e-3
                    : 1e-2);
  check(SNESSetFromOptions(snes));
  // Slip under friction takes a hundred iterations of multigrid, which restarts at PETSc's 30 do not bring to
  // an end. Memory is taken as iterations need it. Beside a shell, whose preconditioner leaves the penalties
  // of the contact to the iterations, longer spaces lose their orthogonality (4 times the iterations).
  if (!shell && option_text("-motion_ksp_gmres_restart").empty()) check(KSPGMRESSetRestart(ksp, 200));
  settle_smoothers(pc);
  check_preconditioner(ksp, defaults.matrix);
  if (shell && has_type(ksp, KSPPREONLY))
    throw UserError(ExitCode::usage,
                    "-motion_ksp_type preonly: not with -contact_operator shell, whose preconditioner "
                    "does not see the contact; use gmres, or -contact_operator assembled");
}

} // namespace impact
