#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <impact/input/database.hpp>
#include <impact/input/known_options.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/shared_cores.hpp>
#include <impact/run/simulation.hpp>
#include <impact/run/stop_requests.hpp>
#include <impact/scenario/scenario.hpp>
#include <string>
#include <vector>

namespace impact {
#ifdef IMPACT_FAULT_INJECTION
StepProbe fault_probe(); // tests/fault_injection.cpp: the tests' own program
#else
static StepProbe fault_probe() { return {}; }
#endif
} // namespace impact

namespace {

// One clear line; with several ranks only an error that may differ between them ends the job by force.
int report(const char* text, impact::ExitCode code, bool collective) {
  int rank = 0, size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  if (!collective && size > 1) {
    std::fprintf(stderr, "impact: rank %d: %s\n", rank, text);
    MPI_Abort(PETSC_COMM_WORLD, static_cast<int>(code));
  }
  if (rank == 0) std::fprintf(stderr, "impact: %s\n", text);
  return static_cast<int>(code);
}

constexpr const char* usage = R"(impact, contact, plasticity and fracture in impact problems

  impact -options_file run.opts [-<option> <value>]...   a run; mpirun -n 2 impact ... on two ranks
  impact -options_file run.opts -dry_run on              checks it, prints its resolved input, and stops
  impact -options_file run.opts -help                    the same behind a list of all options
  impact -reference                                      all options but PETSc's, with units and defaults
  impact -version

README.md has a first run; the folder options has examples.
)";

/// What a command line asks of the program itself, for which nothing is computed; empty for a run.
std::string answer_to(const std::vector<std::string>& words) {
  const auto says = [&](const char* option) { return std::ranges::find(words, option) != words.end(); };
  if (words.empty() || says("--help") || says("-h") || words == std::vector<std::string>{"-help"})
    return usage;
  if (says("-reference")) return impact::option_reference();
  if (says("-version") || says("--version"))
    return "impact " IMPACT_VERSION ", with PETSc " + std::to_string(PETSC_VERSION_MAJOR) + "." +
           std::to_string(PETSC_VERSION_MINOR) + "." + std::to_string(PETSC_VERSION_SUBMINOR) + "\n";
  return "";
}

/// Before MPI starts.
bool first_of_job() {
  const char* const rank = std::getenv("OMPI_COMM_WORLD_RANK");
  return rank == nullptr || std::strcmp(rank, "0") == 0;
}

} // namespace

int main(int argc, char** argv) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) {
    std::fprintf(stderr,
                 "impact: this program was compiled for x86-64-v3 (AVX2, FMA), which this processor lacks\n");
    return static_cast<int>(impact::ExitCode::internal);
  }
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (const std::string answer = answer_to(words); !answer.empty()) {
    if (first_of_job()) std::fputs(answer.c_str(), words.empty() ? stderr : stdout);
    return static_cast<int>(words.empty() ? impact::ExitCode::usage : impact::ExitCode::ok);
  }
  impact::yield_while_waiting();
  impact::hold_to_one_thread();
  impact::install_signal_handlers();
  try {
    impact::check_option_files(argc, argv);
  } catch (const impact::UserError& error) {
    if (first_of_job()) std::fprintf(stderr, "impact: %s\n", error.what()); // each sees the same files
    return static_cast<int>(error.code());
  }
  impact::install_quiet_error_handler(); // before the options files are read: they may be malformed
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) {
    const std::string why = impact::last_petsc_message();
    std::fprintf(stderr, "impact: %s\n", impact::explain_unread_files(argc, argv, why).c_str());
    return static_cast<int>(impact::ExitCode::usage);
  }
  impact::install_signal_handlers(); // PETSc put handlers of its own in place
  int code = 0;
  try {
    const impact::Scenario scenario = impact::read_scenario(PETSC_COMM_WORLD);
    code = static_cast<int>(impact::simulate(PETSC_COMM_WORLD, scenario, impact::fault_probe()));
  } catch (const impact::UserError& error) {
    code = report(error.what(), error.code(), true);
  } catch (const impact::PetscError& error) {
    // An option of a solver inside a solver, which is read when that is made.
    const std::string option = impact::refused_option(error.said());
    const bool refused = !option.empty();
    code = report(refused ? option.c_str() : error.what(),
                  refused ? impact::ExitCode::usage : impact::ExitCode::internal, false);
  } catch (const std::exception& error) {
    code = report(error.what(), impact::ExitCode::internal, false);
  }
  impact::ignore_signals();
  PetscFinalize();
  return code;
}
