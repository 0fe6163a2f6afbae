#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdarg>
#include <impact/input/database.hpp>
#include <impact/input/known_options.hpp>
#include <impact/input/spelling.hpp>
#include <impact/petsc/error.hpp>
#include <sstream>

namespace impact {

namespace {

// PETSc prints by a process-wide hook, so what takes its place is process-wide too.
std::string& printed() {
  static std::string text;
  return text;
}

PetscErrorCode collect(FILE*, const char format[], va_list values) {
  char line[1 << 15]; // not cleared: a third of the survey's time
  std::size_t length = 0;
  if (const PetscErrorCode code = PetscVSNPrintf(line, sizeof line, format, &length, values)) return code;
  printed() += line;
  return 0;
}

// PETSc prints to collect() while it lives.
class Listening {
public:
  Listening() : print_(std::exchange(PetscVFPrintf, collect)) { printed().clear(); }
  ~Listening() { PetscVFPrintf = print_; }
  Listening(const Listening&) = delete;
  Listening& operator=(const Listening&) = delete;

private:
  PetscErrorCode (*print_)(FILE*, const char[], va_list);
};

// PETSc's database while it lives: nothing that is read there counts as used in the real one.
class OptionsOfTrial {
public:
  OptionsOfTrial() {
    check(PetscOptionsCreate(&options_));
    check(PetscOptionsPush(options_));
  }
  ~OptionsOfTrial() {
    PetscOptionsPop();
    PetscOptionsDestroy(&options_);
  }
  OptionsOfTrial(const OptionsOfTrial&) = delete;
  OptionsOfTrial& operator=(const OptionsOfTrial&) = delete;
  void set(const std::string& name, const std::string& text) {
    check(PetscOptionsSetValue(options_, ("-" + name).c_str(), text.empty() ? nullptr : text.c_str()));
  }

private:
  PetscOptions options_ = nullptr;
};

std::vector<std::string> registered(PetscFunctionList list) {
  const char** names = nullptr;
  int count = 0;
  check(PetscFunctionListGet(list, &names, &count));
  std::vector<std::string> all;
  for (int i = 0; i < count; ++i)
    if (names[i] != nullptr) all.emplace_back(names[i]);
  check(PetscFree(names));
  return all;
}

// Makes one solver of each kind; each needs a prefix of its own, since PETSc prints a help only once.
class Survey {
public:
  explicit Survey(MPI_Comm comm) : comm_(comm), matrix_(small_matrix(comm)) {}

  void run() {
    for (const char* type : {SNESNEWTONLS, SNESVINEWTONRSLS, SNESVINEWTONSSLS, SNESSHELL})
      solver([&](SNES snes, KSP, PC) { return SNESSetType(snes, type); });
    for (const std::string& type : registered(SNESLineSearchList))
      solver([&](SNES snes, KSP, PC) {
        SNESLineSearch search = nullptr;
        check(SNESGetLineSearch(snes, &search));
        return SNESLineSearchSetType(search, type.c_str());
      });
    for (const std::string& type : registered(KSPList))
      solver([&](SNES, KSP ksp, PC) { return KSPSetType(ksp, type.c_str()); }, Asked::ksp);
    for (const std::string& type : registered(PCList))
      solver([&](SNES, KSP, PC pc) { return PCSetType(pc, type.c_str()); }, Asked::pc);
    for (const char* type : {"euclid", "pilut", "parasails", "boomeramg", "ams", "ads"})
      solver(
          [&](SNES, KSP, PC pc) {
            check(PCSetType(pc, PCHYPRE));
            return PCHYPRESetType(pc, type);
          },
          Asked::pc);
    // What a factorisation takes shows when it is made, what is printed of a solve when it has ended.
    for (const char* type : {PCLU, PCCHOLESKY})
      for (const char* package : {MATSOLVERPETSC, MATSOLVERMUMPS, MATSOLVERSUPERLU_DIST})
        solver(
            [&](SNES, KSP ksp, PC pc) {
              check(KSPSetType(ksp, KSPGMRES));
              check(PCSetType(pc, type));
              return PCFactorSetMatSolverType(pc, package);
            },
            Asked::solve);
    for (const char* type : {"newmark", "static", TSBEULER, TSTHETA, TSALPHA2}) integrator(type, nullptr);
    for (const char* type : {TSADAPTNONE, TSADAPTBASIC}) integrator(TSBEULER, type);
  }

private:
  // Whose help is printed; the others' would be the same again.
  enum class Asked { snes, ksp, pc, solve };
  template <class Choose> void solver(const Choose& choose, Asked asked = Asked::snes) {
    Handle<SNES> snes;
    KSP ksp = nullptr;
    PC pc = nullptr;
    check(SNESCreate(comm_, snes.out()));
    check(SNESSetOptionsPrefix(snes, prefix().c_str()));
    check(SNESGetKSP(snes, &ksp));
    check(KSPGetPC(ksp, &pc));
    check(KSPSetOperators(ksp, matrix_, matrix_));
    check(KSPSetType(ksp, KSPPREONLY));
    check(PCSetType(pc, PCNONE));
    // A kind that this PETSc does not have, or has only with more than a matrix, has no help to read.
    if (choose(snes, ksp, pc) != 0) return;
    if (asked == Asked::pc) static_cast<void>(PCSetFromOptions(pc));
    if (asked == Asked::ksp) static_cast<void>(KSPSetFromOptions(ksp));
    if (asked == Asked::pc || asked == Asked::ksp || SNESSetFromOptions(snes) != 0 || asked == Asked::snes)
      return;
    const Handle<Vec> x = vector();
    KSPSolve(ksp, x, vector()); // not in place, which PETSc leaves a vector of
    check(KSPReset(ksp));       // the next solve sets up anew and would leave the vectors of this one
    if (SNESSetFunction(snes, x, identity, nullptr) == 0 &&
        SNESSetJacobian(snes, matrix_, matrix_, constant, nullptr) == 0)
      SNESSolve(snes, nullptr, vector());
  }

  void integrator(const char* type, const char* adapt) {
    Handle<TS> ts;
    TSAdapt control = nullptr;
    check(TSCreate(comm_, ts.out()));
    check(TSSetOptionsPrefix(ts, prefix().c_str()));
    if (TSSetType(ts, type) != 0) return;
    check(TSGetAdapt(ts, &control));
    if (adapt == nullptr || TSAdaptSetType(control, adapt) == 0) TSSetFromOptions(ts);
  }

  Handle<Vec> vector() const {
    Vec x = nullptr;
    check(MatCreateVecs(matrix_, &x, nullptr));
    check(VecSet(x, 1));
    return Handle<Vec>(x);
  }
  static PetscErrorCode identity(SNES, Vec x, Vec f, void*) { return VecCopy(x, f); }
  static PetscErrorCode constant(SNES, Vec, Mat, Mat, void*) { return 0; }
  std::string prefix() { return "known" + std::to_string(count_++) + "_"; }

  MPI_Comm comm_;
  Handle<Mat> matrix_;
  int count_ = 0;
};

// Whether the value is a word of the message, or a number of it.
bool names_value(const std::string& message, const std::string& value) {
  if (value.empty()) return false;
  const std::string in = lower_case(message), word = lower_case(value);
  char* rest = nullptr;
  const double number = std::strtod(word.c_str(), &rest);
  if (*rest != '\0') return find_word(in, word) != std::string::npos;
  for (const char* c = in.c_str(); *c != '\0'; ++c) {
    if (!std::isdigit(static_cast<unsigned char>(*c)) && *c != '-') continue;
    const double said = std::strtod(c, &rest);
    if (rest == c) continue;
    const bool index = c != in.c_str() && c[-1] == '(' && *rest == ')'; // as in INFOG(1)=-37
    if (!index && std::abs(said - number) <= 1e-4 * std::abs(number)) return true;
    c = rest - 1;
  }
  return false;
}

std::string explain(const std::string& message, const std::string& prefix,
                    const std::vector<GivenOption>& options) {
  for (const GivenOption& option : options) {
    if (!option.key.starts_with("-" + prefix) || !names_value(message, option.text)) continue;
    std::vector<std::string> choices = KnownOptions::get().allowed(option.key.substr(1));
    const bool number = message.find("numeric value") != std::string::npos ||
                        message.find("integer value") != std::string::npos;
    const bool listed = std::ranges::find(choices, option.text) != choices.end();
    const std::string near = listed ? "" : nearest_name(option.text, choices, 2);
    std::erase(choices, option.text);
    return option.key + " \"" + option.text + "\": PETSc refuses it (" + message + ")" +
           (near.empty() ? "" : "; did you mean " + near + "?") + (listed ? "; others: " : "; allowed: ") +
           (!choices.empty() ? join(choices)
            : number         ? "a number"
                             : "what PETSc's manual says of this option");
  }
  std::string types;
  for (const GivenOption& option : options)
    if ((option.key.ends_with("_type") || option.key.find("_mat_mumps_") != std::string::npos ||
         option.key.find("_pc_") != std::string::npos) &&
        !option.key.starts_with("-ts_") && KnownOptions::get().of_solver(option.key.substr(1)))
      types += (types.empty() ? "" : " ") + option.key + " " + option.text;
  return types.empty() ? ""
                       : "PETSc cannot solve with " + types + " (" + message + "); leave one of them out";
}

} // namespace

Handle<Mat> small_matrix(MPI_Comm comm) {
  Handle<Mat> matrix;
  PetscInt first = 0, end = 0;
  check(MatCreateAIJ(comm, 2, 2, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, matrix.out()));
  check(MatGetOwnershipRange(matrix, &first, &end));
  for (PetscInt i = first; i < end; ++i) check(MatSetValue(matrix, i, i, 1, INSERT_VALUES));
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

KnownOptions::KnownOptions() {
  {
    OptionsOfTrial trial;
    trial.set("help", "");
    const Listening listening;
    Survey(PETSC_COMM_SELF).run();
    last_petsc_message();
  }
  // Lines "  -known7_ksp_rtol <now 1e-05 : formerly 1e-05>: ...".
  std::istringstream lines(std::exchange(printed(), std::string()));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t dash = line.find_first_not_of(" \t");
    if (dash == std::string::npos || dash == 0 || line[dash] != '-') continue;
    const std::size_t end = std::min(line.find_first_of(" :<\t,", dash), line.size());
    std::string name = lower_case(line.substr(dash + 1, end - dash - 1));
    if (name.empty() || !std::isalpha(static_cast<unsigned char>(name[0]))) continue;
    const bool solver = name.starts_with("known") && name.find('_') != std::string::npos;
    if (solver) name.erase(0, name.find('_') + 1);
    if (solver) solver_.emplace(name, line.substr(end));
    if (!solver || name.starts_with("ts_")) global_.emplace(name, line.substr(end));
  }
}

const KnownOptions& KnownOptions::get() {
  static const KnownOptions known; // PETSc prints its helps only once in a process
  return known;
}

const std::string* KnownOptions::of_solver(const std::string& name) const {
  for (std::size_t at = 0; at != std::string::npos; at = name.find('_', at + 1))
    if (const auto found = solver_.find(lower_case(name.substr(at == 0 ? 0 : at + 1)));
        found != solver_.end())
      return &found->second;
  return nullptr;
}

std::vector<std::string> KnownOptions::allowed(const std::string& name) const {
  std::vector<std::string> choices;
  const std::string one_of = "(one of)", *help = of_solver(name);
  const std::size_t begin = help != nullptr ? help->find(one_of) : std::string::npos;
  if (begin == std::string::npos) return choices;
  std::istringstream words(help->substr(begin + one_of.size()));
  for (std::string word; words >> word && word[0] != '(';)
    for (const std::string& choice : split_list(word)) choices.push_back(choice);
  return choices;
}

void try_options(const std::string& prefix, const std::function<void()>& set_up) {
  const std::vector<GivenOption> options = unread_options();
  std::string message;
  {
    OptionsOfTrial trial;
    for (const GivenOption& option : options)
      if (option.key.starts_with("-" + prefix)) trial.set(option.key.substr(1), option.text);
    try {
      set_up();
    } catch (const PetscError& error) {
      message = error.said();
    }
  }
  if (message.empty()) return;
  last_petsc_message();
  const std::string text = explain(message, prefix, options);
  throw UserError(ExitCode::usage,
                  text.empty() ? "the options -" + prefix + "...: PETSc refuses one of them (" + message + ")"
                               : text);
}

std::string refused_option(const std::string& petsc_message) {
  const KnownOptions& known = KnownOptions::get();
  std::vector<GivenOption> options;
  for (const std::string& name : option_names()) {
    if (known.of_solver(name) == nullptr && !known.global().contains(lower_case(name))) continue; // ours
    if (const auto text = option_text(name)) options.push_back({"-" + name, *text});
  }
  return explain(petsc_message, "", options);
}

} // namespace impact
