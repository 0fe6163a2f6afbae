#include <algorithm>
#include <impact/input/known_options.hpp>
#include <impact/input/option_text.hpp>
#include <impact/petsc/bounded_newton.hpp>
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
};

/// A value of PETSc's that makes no sense, before anything is computed: numbers by the table above, names by
/// what PETSc lists.
void check_value(const GivenOption& option) {
  const std::string name = lower_case(option.key.substr(1));
  for (const auto& [prefix, types] : solver_types)
    if (name == std::string(prefix) + "snes_type" && std::ranges::find(types, option.text) == types.end())
      refuse_option(option, "cannot solve this problem; allowed: " + join(types) + "; leave the option out");
  if (!KnownOptions::get().of_solver(name)) return;
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

void try_petsc_options(MPI_Comm comm, const Scenario& s) {
  for (const GivenOption& option : unread_options()) check_value(option);
  for (const auto& [prefix, types] : solver_types)
    if (given_behind(prefix))
      try_options(prefix, [&, p = prefix, t = types[0].c_str()] { try_solver(comm, p, t); });
  if (given_behind("ts_"))
    try_options("ts_", [&] { try_integrator(comm, "", s.has_motion() ? s.time.type : "static"); });
  if (given_behind("damage_ts_"))
    try_options("damage_ts_", [&] { try_integrator(comm, "damage_", TSBEULER); });
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
