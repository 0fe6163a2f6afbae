#include <algorithm>
#include <chrono>
#include <csignal>
#include <impact/run/stop_requests.hpp>

namespace impact {

namespace {

constexpr int handled[3] = {SIGUSR1, SIGUSR2, SIGTERM};

// A handler can reach nothing but what belongs to the process.
volatile std::sig_atomic_t received[3] = {0, 0, 0};

void count(int signal) {
  for (int i = 0; i < 3; ++i)
    if (signal == handled[i]) received[i] = received[i] + 1;
}

std::chrono::steady_clock::time_point start_of_program() {
  static const auto start = std::chrono::steady_clock::now();
  return start;
}

} // namespace

void install_signal_handlers() {
  start_of_program();
  struct sigaction action {};
  action.sa_handler = count;
  action.sa_flags = SA_RESTART; // a write that a signal meets goes on
  sigemptyset(&action.sa_mask);
  for (const int signal : handled) sigaction(signal, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

double seconds_since_start() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_of_program()).count();
}

StopRequest StopRequests::ask(MPI_Comm comm, bool checkpoint_due) {
  const double now = seconds_since_start();
  if (last_asked_ >= 0) longest_step_ = std::max(longest_step_, now - last_asked_);
  last_asked_ = now;
  const double needed = limits_.margin + longest_step_ + longest_checkpoint_;
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  int asked[5] = {0, 0, 0, rank == 0 && checkpoint_due ? 1 : 0,
                  rank == 0 && limits_.walltime > 0 && now + needed >= limits_.walltime ? 1 : 0};
  for (int i = 0; i < 3; ++i) {
    const int count_now = received[i];
    asked[i] = count_now != seen_[i] ? 1 : 0;
    seen_[i] = count_now;
  }
  MPI_Allreduce(MPI_IN_PLACE, asked, 5, MPI_INT, MPI_MAX, comm);
  StopRequest request;
  request.checkpoint = asked[0] > 0 || asked[3] > 0;
  if (asked[4] > 0) request.stop = "-walltime";
  if (asked[2] > 0) request.stop = "SIGTERM";
  if (asked[1] > 0) request.stop = "SIGUSR2";
  request.checkpoint = request.checkpoint || !request.stop.empty();
  return request;
}

void StopRequests::note_checkpoint(double seconds) {
  longest_checkpoint_ = std::max(longest_checkpoint_, seconds);
  // The step that follows is not longer for it.
  if (last_asked_ >= 0) last_asked_ = seconds_since_start();
}

} // namespace impact
