#include <algorithm>
#include <impact/input/database.hpp>
#include <impact/input/known_options.hpp>
#include <impact/input/option_text.hpp>
#include <impact/petsc/bounded_newton.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/scenario/petsc_options.hpp>
#include <impact/time/types.hpp>

namespace impact {

namespace {

/// The kinds that solve, of each prefix; the others do not, or not this problem.
const std::pair<const char*, std::vector<std::string>> solver_types[] = {
    {"motion_", {SNESNEWTONLS}},
    {"damage_", {vi_newton_qp, SNESVINEWTONRSLS, SNESVINEWTONSSLS}},
    {"heat_", {SNESNEWTONLS}},
    {"coupling_", {SNESSHELL}},
    {"uzawa_", {SNESSHELL}}};

/// What PETSc takes without a look, of any solver and of those inside it.
struct SolverNumber {
  const char* name;
  Interval range;
  bool whole = false;
};
const SolverNumber solver_numbers[] = {
    {"snes_rtol", {0, 1, false, true}},
    {"snes_atol", not_negative},
    {"snes_stol", {0, 0, false, false}}, // a short step says nothing about what is left
    {"snes_max_it", {1}, true},
    {"snes_max_funcs", {-1}, true},
    {"snes_lag_jacobian", {1}, true}, // -2, once for all, would not outlive a checkpoint
    {"snes_lag_preconditioner", {1}, true},
    {"snes_linesearch_damping", {0, 1, true, false}},
    {"snes_linesearch_max_it", {1}, true},
    {"ksp_rtol", {0, 1, false, true}},
    {"ksp_atol", not_negative},
    {"ksp_divtol", positive},
    {"ksp_max_it", {1}, true},
    {"ksp_gmres_restart", {1}, true},
    {"ksp_richardson_scale", positive},
    {"pc_factor_levels", {0}, true},
    {"pc_factor_fill", {1}},
    {"pc_sor_omega", {0, 2, true, true}},
    {"pc_sor_its", {1}, true},
    {"pc_asm_overlap", {0}, true},
    {"pc_two_level_nodes", {1}, true},
};

/// Names that PETSc offers and nobody can take.
struct Impossible {
  const char *name, *value, *why;
};
const Impossible impossible[] = {
    {"ksp_type", KSPQCG, "is a search in a trust region and crashes beside most preconditioners; take cg"},
    {"ksp_type", KSPPIPELCG, "does not come to an end; take pipecg"},
    {"ksp_type", KSPPIPECG2, "counts as solved what is not; take pipecg"},
    {"snes_linesearch_type", SNESLINESEARCHNCGLINEAR, "is for gradients, not for Newton's method; take bt"},
    {"pc_factor_mat_ordering_type", MATORDERINGWBM, "ends the program in SuperLU_DIST; take nd or rcm"},
};

/// Whether `-help` shows a number as the option's present value: "... <now 25 : formerly 25>: ...".
bool takes_number(const std::string& help) {
  const std::size_t begin = help.find('<');
  if (begin == std::string::npos) return false;
  const std::string value = help.substr(begin + (help.compare(begin + 1, 4, "now ") == 0 ? 5 : 1));
  char* rest = nullptr;
  std::strtod(value.c_str(), &rest);
  return rest != value.c_str() && (*rest == ' ' || *rest == '>');
}

/// A value of PETSc's that makes no sense, before anything is computed: numbers by the table above, names by
/// what PETSc lists.
void check_value(const GivenOption& option) {
  const std::string name = lower_case(option.key.substr(1));
  for (const auto& [prefix, types] : solver_types)
    if (name == std::string(prefix) + "snes_type" && std::ranges::find(types, option.text) == types.end())
      refuse_option(option, "cannot solve this problem; allowed: " + join(types) + "; leave the option out");
  const std::string* const help = KnownOptions::get().of_solver(name);
  if (help == nullptr) return;
  for (const Impossible& one : impossible)
    if (name.ends_with(std::string("_") + one.name) && lower_case(option.text) == one.value)
      refuse_option(option, one.why);
  if (option.text.empty() && takes_number(*help))
    refuse_option(option, "a value is missing; allowed: a number");
  for (const SolverNumber& one : solver_numbers)
    if (name.ends_with(std::string("_") + one.name)) {
      if (one.whole)
        read_count(option, static_cast<int>(one.range.low), std::numeric_limits<int>::max());
      else
        read_number(option, "", one.range, {}, {});
      return;
    }
  const std::vector<std::string> choices = KnownOptions::get().allowed(name);
  const std::string text = lower_case(option.text);
  if (!choices.empty() &&
      std::ranges::none_of(choices, [&](const std::string& choice) { return lower_case(choice) == text; }))
    read_choice(option, choices);
}

bool given_behind(const std::string& prefix) {
  for (const GivenOption& option : unread_options())
    if (option.key.starts_with("-" + prefix)) return true;
  return false;
}

// A factorisation reads its options only when it is made.
void set_up_factors(PC pc) {
  PetscBool factors = PETSC_FALSE;
  check(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(pc), &factors, PCLU, PCCHOLESKY, ""));
  if (factors) check(PCSetUp(pc));
}

void try_solver(MPI_Comm comm, const std::string& prefix, SNESType type) {
  Handle<SNES> snes;
  const Handle<Mat> matrix = small_matrix(comm);
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(SNESCreate(comm, snes.out()));
  check(SNESSetOptionsPrefix(snes, prefix.c_str()));
  check(SNESSetType(snes, type));
  check(SNESGetKSP(snes, &ksp));
  check(KSPSetOperators(ksp, matrix, matrix)); // what the types are chosen by
  if (prefix == "motion_") { // as a run of this solver begins, so that the options of its factors are read
    check(KSPGetPC(ksp, &pc));
    check(PCSetType(pc, PCLU));
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  }
  check(SNESSetFromOptions(snes));
  if (std::string(type) == SNESSHELL) return;
  check(KSPSetOperators(ksp, matrix, matrix));
  check(KSPGetPC(ksp, &pc));
  // Eisenstat's trick is one of the matrix, which these two multiply by on their own.
  if (has_type(pc, PCEISENSTAT) && has_type(ksp, KSPLSQR, KSPTSIRM))
    throw UserError(ExitCode::usage, "-" + prefix + "pc_type eisenstat: crashes with -" + prefix +
                                         "ksp_type lsqr and tsirm; take cg or gmres, or -" + prefix +
                                         "pc_type sor");
  set_up_factors(pc);
}

void try_integrator(MPI_Comm comm, const std::string& prefix, const std::string& type) {
  Handle<TS> ts;
  check(TSCreate(comm, ts.out()));
  check(TSSetOptionsPrefix(ts, prefix.c_str()));
  check(TSSetType(ts, type.c_str()));
  if (prefix.empty())
    set_time_options(ts);
  else
    check(TSSetFromOptions(ts));
}

std::string field_of(const std::string& option) {
  for (const char* field : {"motion", "damage", "heat"})
    if (lower_case(option).starts_with("-" + std::string(field) + "_")) return field;
  return "";
}

} // namespace

bool asks_for_damped_steps() {
  PetscReal rho = 1, gamma = 0.5;
  check(PetscOptionsGetReal(nullptr, nullptr, "-ts_newmark_rho", &rho, nullptr));
  check(PetscOptionsGetReal(nullptr, nullptr, "-ts_newmark_gamma", &gamma, nullptr));
  return rho < 1 || gamma > 0.5;
}

void try_petsc_options(MPI_Comm comm, const Scenario& s) {
  for (const GivenOption& option : unread_options()) check_value(option);
  for (const auto& [prefix, types] : solver_types)
    if (given_behind(prefix))
      try_options(prefix, [&, p = prefix, t = types[0].c_str()] { try_solver(comm, p, t); });
  if (given_behind("ts_"))
    try_options("ts_", [&] { try_integrator(comm, "", s.has_motion() ? s.time.type : "static"); });
  if (given_behind("damage_ts_"))
    try_options("damage_ts_", [&] {
      try_integrator(comm, "damage_", s.damage.explicit_substeps > 0 ? TSEULER : TSBEULER);
    });
}

namespace {

/// What the linear and nonlinear solver of a field read from the options and do without.
std::vector<const char*> idle_names(SNES snes) {
  std::vector<const char*> names;
  KSP ksp = nullptr;
  PC pc = nullptr;
  SNESLineSearch search = nullptr;
  MatSolverType package = nullptr;
  PetscBool guesses = PETSC_FALSE;
  check(SNESGetKSP(snes, &ksp));
  check(KSPGetPC(ksp, &pc));
  check(SNESGetLineSearch(snes, &search));
  check(PCFactorGetMatSolverType(pc, &package)); // none of a type that has no factors
  check(KSPGetInitialGuessNonzero(ksp, &guesses));
  const bool alone = has_type(ksp, KSPPREONLY), iterates = has_type(search, SNESLINESEARCHCP),
             searches = iterates || has_type(search, SNESLINESEARCHBT);
  if (alone && guesses) {
    const char* prefix = nullptr;
    check(SNESGetOptionsPrefix(snes, &prefix));
    throw UserError(ExitCode::usage, std::string("-") + prefix + "ksp_initial_guess_nonzero: not with " +
                                         prefix + "ksp_type preonly, a solver without iterations; remove it");
  }
  if (alone) names = {"ksp_rtol", "ksp_atol", "ksp_divtol", "ksp_max_it", "ksp_norm_type", "ksp_pc_side"};
  if (package != nullptr && std::string(package) != MATSOLVERPETSC)
    names.insert(names.end(), {"pc_factor_shift_type", "pc_factor_shift_amount", "pc_factor_zeropivot",
                               "pc_factor_column_pivot", "pc_factor_pivot_in_blocks", "pc_factor_fill",
                               "pc_factor_reuse_fill", "pc_factor_reuse_ordering"});
  if (package != nullptr && std::string(package) == MATSOLVERMUMPS && has_type(pc, PCCHOLESKY))
    names.emplace_back("pc_factor_mat_ordering_type"); // -..._mat_mumps_icntl_7
  if (has_type(snes, vi_newton_qp))
    names.insert(names.end(), {"snes_linesearch_type", "snes_linesearch_max_it"});
  if (!searches) names.emplace_back("snes_linesearch_order");
  if (!iterates)
    names.insert(names.end(), {"snes_linesearch_rtol", "snes_linesearch_atol", "snes_linesearch_ltol"});
  return names;
}

void tell(MPI_Comm comm, bool strict, const std::string& who, const std::vector<std::string>& idle) {
  if (idle.empty()) return;
  const std::string text = who + " " + join(idle);
  if (strict) throw UserError(ExitCode::usage, text + " (-options_strict); remove it");
  check(PetscPrintf(comm, "impact: %s: without effect\n", text.c_str()));
}

/// What is given of the solution of the motion, which explicit steps do not need, and of how other steps
/// grow.
std::vector<std::string> idle_in_explicit_steps() {
  std::vector<std::string> idle;
  for (const std::string& name : option_names()) {
    const std::string lower = lower_case(name);
    const auto begins = [&](const char* with) { return lower.starts_with(with); };
    if ((begins("motion_") || begins("uzawa_") || begins("ts_adapt_grow") || begins("ts_adapt_easy_")) &&
        option_text(name))
      idle.push_back("-" + name);
  }
  return idle;
}

} // namespace

void tell_idle_options(MPI_Comm comm, const Scenario& s, const std::vector<SNES>& solvers) {
  std::vector<std::string> idle;
  for (SNES snes : solvers) {
    const char* prefix = nullptr;
    check(SNESGetOptionsPrefix(snes, &prefix));
    for (const char* name : idle_names(snes))
      if (option_text(std::string(prefix) + name)) idle.push_back(std::string("-") + prefix + name);
  }
  tell(comm, s.strict, "the solvers that this run chose do without", idle);
  if (s.explicit_steps())
    tell(comm, s.strict, "explicit steps, which solve no equation of motion, do without",
         idle_in_explicit_steps());
}

UnreadOptions::UnreadOptions(MPI_Comm comm, const Scenario& s) : comm_(comm), strict_(s.strict) {
  std::vector<std::string> useless;
  for (const GivenOption& option : unread_options()) {
    const std::string field = field_of(option.key);
    const bool there = field == "damage" ? s.has_damage() : field == "heat" ? s.has_heat() : s.has_motion();
    if (field.empty() || there)
      pending_.insert(option.key);
    else
      useless.push_back(option.key);
  }
  if (useless.empty()) return;
  if (strict_)
    throw UserError(ExitCode::usage,
                    "of fields that this run does not solve: " + join(useless) + " (-options_strict)");
  check(PetscPrintf(comm, "impact: without effect, for this run does not solve these fields: %s\n",
                    join(useless).c_str()));
}

void UnreadOptions::judge(const std::vector<std::string>& solved) {
  if (pending_.empty()) return;
  solved_.insert(solved.begin(), solved.end());
  std::set<std::string> left;
  std::vector<std::string> refused, told;
  for (const GivenOption& option : unread_options()) {
    if (!pending_.count(option.key)) continue;
    const std::string field = field_of(option.key);
    if (!field.empty() && !solved_.count(field)) {
      left.insert(option.key);
      continue;
    }
    // -motion_ksp_rtol is right where the program chose another solver; a solver's part may be misspelt.
    const bool right =
        !field.empty() && KnownOptions::get().solver().count(lower_case(option.key).substr(field.size() + 2));
    const bool wrong = strict_ || (!right && on_command_line(option.key.substr(1)));
    (wrong ? refused : told).push_back(option.key);
  }
  pending_ = left;
  if (const std::string text = broadcast(comm_, join(refused)); !text.empty())
    throw UserError(ExitCode::usage,
                    "nothing in this run reads " + text +
                        ": the solvers that it chose have no such option, or no part of that "
                        "name; see -motion_snes_view; remove it");
  if (!told.empty())
    check(PetscPrintf(comm_, "impact: nothing in this run reads %s: without effect\n", join(told).c_str()));
}

} // namespace impact
