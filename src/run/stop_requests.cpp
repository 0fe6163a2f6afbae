#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <impact/run/stop_requests.hpp>
#include <iterator>
#include <unistd.h>

namespace impact {

namespace {

struct Handled {
  int number;
  const char* name;
  bool ends; // the run; else it goes on after a checkpoint
};

// The later one names the reason.
constexpr Handled handled[] = {{SIGUSR1, "SIGUSR1", false}, {SIGHUP, "SIGHUP", true},
                               {SIGXCPU, "SIGXCPU", true},  {SIGINT, "SIGINT", true},
                               {SIGTERM, "SIGTERM", true},  {SIGUSR2, "SIGUSR2", true}};
constexpr std::size_t handled_count = std::size(handled);

// A handler can reach nothing but what belongs to the process.
volatile std::sig_atomic_t received[handled_count] = {};
volatile std::sig_atomic_t speaks = 0;

void say(const char* text) {
  if (::write(STDERR_FILENO, text, std::strlen(text)) < 0) return;
}

// A step may take long, and a batch system or mpirun may not wait for it.
void count(int signal) {
  for (std::size_t i = 0; i < handled_count; ++i) {
    if (signal != handled[i].number) continue;
    received[i] = received[i] + 1;
    if (signal == SIGINT && received[i] > 1) {
      std::signal(SIGINT, SIG_DFL);
      std::raise(SIGINT);
    }
    if (!handled[i].ends || received[i] > 1 || speaks == 0) continue;
    say("impact: ");
    say(handled[i].name);
    say(signal == SIGINT
            ? ": the run ends after this step; a second one ends it at once, without a checkpoint\n"
            : ": the run ends after this step\n");
  }
}

std::chrono::steady_clock::time_point start_of_program() {
  static const auto start = std::chrono::steady_clock::now();
  return start;
}

// nohup and a shell's background jobs ask for it.
std::array<bool, handled_count> ignored_now() {
  std::array<bool, handled_count> ignored{};
  for (std::size_t i = 0; i < handled_count; ++i) {
    struct sigaction now {};
    const bool may = handled[i].number == SIGINT || handled[i].number == SIGHUP;
    ignored[i] = may && sigaction(handled[i].number, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
  }
  return ignored;
}

} // namespace

void install_signal_handlers() {
  start_of_program();
  static const std::array<bool, handled_count> ignored = ignored_now(); // at the first call
  struct sigaction action {};
  action.sa_flags = SA_RESTART; // a write that a signal meets goes on
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < handled_count; ++i) {
    action.sa_handler = ignored[i] ? SIG_IGN : count;
    sigaction(handled[i].number, &action, nullptr);
  }
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  int with_mpi = 0, rank = 0;
  MPI_Initialized(&with_mpi);
  if (with_mpi != 0) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  speaks = with_mpi != 0 && rank == 0 ? 1 : 0;
}

void ignore_signals() {
  for (const Handled& one : handled) std::signal(one.number, SIG_IGN);
  PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"); // else PetscFinalize restores their defaults
}

double seconds_since_start() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_of_program()).count();
}

std::string reason_to_stop(const WallLimits& limits) {
  for (std::size_t i = handled_count; i-- > 0;)
    if (handled[i].ends && received[i] > 0) return handled[i].name;
  return limits.walltime > 0 && seconds_since_start() + limits.margin >= limits.walltime ? "-walltime" : "";
}

StopRequest StopRequests::ask(MPI_Comm comm, bool checkpoint_due) {
  const double now = seconds_since_start();
  if (last_asked_ >= 0) longest_step_ = std::max(longest_step_, now - last_asked_);
  last_asked_ = now;
  const double needed = limits_.margin + longest_step_ + longest_checkpoint_;
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  constexpr std::size_t due = handled_count, late = due + 1;
  std::array<int, handled_count + 2> asked{};
  asked[due] = rank == 0 && checkpoint_due ? 1 : 0;
  asked[late] = rank == 0 && limits_.walltime > 0 && now + needed >= limits_.walltime ? 1 : 0;
  seen_.resize(handled_count);
  for (std::size_t i = 0; i < handled_count; ++i) {
    const int count_now = received[i];
    asked[i] = count_now != seen_[i] ? 1 : 0;
    seen_[i] = count_now;
  }
  MPI_Allreduce(MPI_IN_PLACE, asked.data(), static_cast<int>(asked.size()), MPI_INT, MPI_MAX, comm);
  StopRequest request;
  request.checkpoint = asked[due] > 0;
  if (asked[late] > 0) request.stop = "-walltime";
  for (std::size_t i = 0; i < handled_count; ++i) {
    if (asked[i] == 0) continue;
    request.checkpoint = true;
    if (handled[i].ends) request.stop = handled[i].name;
  }
  request.checkpoint = request.checkpoint || !request.stop.empty();
  return request;
}

void StopRequests::note_checkpoint(double seconds) {
  longest_checkpoint_ = std::max(longest_checkpoint_, seconds);
  // The step that follows is not longer for it.
  if (last_asked_ >= 0) last_asked_ = seconds_since_start();
}

} // namespace impact
