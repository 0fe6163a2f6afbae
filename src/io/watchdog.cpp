#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <impact/io/watchdog.hpp>
#include <impact/petsc/error.hpp>
#include <sys/time.h>
#include <unistd.h>

namespace impact {

namespace {

// A signal handler may touch nothing that is not there beforehand.
std::array<char, 1024> last_words{};

void give_up(int) {
  const ssize_t said = ::write(STDERR_FILENO, last_words.data(), std::strlen(last_words.data()));
  ::_exit(said < 0 ? static_cast<int>(ExitCode::internal) : static_cast<int>(ExitCode::io));
}

void set_timer(double seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = static_cast<time_t>(seconds);
  timer.it_value.tv_usec =
      static_cast<suseconds_t>((seconds - static_cast<double>(timer.it_value.tv_sec)) * 1e6);
  setitimer(ITIMER_REAL, &timer, nullptr);
}

} // namespace

Watchdog::Watchdog(double seconds, const std::string& message) {
  const std::string text = "impact: " + message + "\n";
  const std::size_t length = std::min(text.size(), last_words.size() - 1);
  std::copy_n(text.begin(), length, last_words.begin());
  last_words[length] = '\0';
  std::signal(SIGALRM, give_up);
  set_timer(seconds);
}

Watchdog::~Watchdog() {
  set_timer(0);
  std::signal(SIGALRM, SIG_DFL);
}

} // namespace impact
