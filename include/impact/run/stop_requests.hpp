#pragma once
#include <petscsys.h>
#include <string>
#include <vector>

/// What the outside asks of a run between two steps: signals and the wall clock. A handler counts and rank 0
/// says that the end is near; the ranks agree at the end of a step, so a signal to one rank is enough.
namespace impact {

/// SIGUSR1: checkpoint; SIGUSR2, SIGTERM, SIGXCPU, SIGINT and SIGHUP: checkpoint and stop; a second SIGINT
/// ends the program at once. SIGINT and SIGHUP stay ignored where the program was started so (nohup, a
/// script's background). SIGPIPE and SIGXFSZ are ignored: a closed pipe behind the progress lines and a file
/// above its quota become error codes of the write. Once before PetscInitialize, and once after it, because
/// PETSc sets handlers of its own. Also starts the clock of seconds_since_start at the first call.
void install_signal_handlers();

/// For the end of the program, before PetscFinalize: all is said and saved, and no signal changes that.
void ignore_signals();

/// Seconds on the clock since the program started.
double seconds_since_start();

struct StopRequest {
  bool checkpoint = false;
  std::string stop; ///< why the run shall stop; empty: it shall not
};

/// Limits by the clock, in seconds; 0: none.
struct WallLimits {
  double walltime = 0; ///< of the whole job, counted from the start of the program
  double margin = 0;   ///< what must be left when the run stops
};

/// The signal to this rank that wants the end of the run, or "-walltime" where no more than its margin is
/// left; empty: neither. For long work of one rank.
std::string reason_to_stop(const WallLimits& limits);

class StopRequests {
public:
  explicit StopRequests(WallLimits limits) : limits_(limits) {}

  /// Signals since the last call, and whether the rest of the wall time still holds the margin, one more step
  /// and one checkpoint, as long as the longest ones so far. `checkpoint_due` of rank 0 is passed on.
  /// Collective, once per step.
  StopRequest ask(MPI_Comm comm, bool checkpoint_due);
  /// Tells how long a checkpoint took.
  void note_checkpoint(double seconds);

private:
  WallLimits limits_;
  double last_asked_ = -1, longest_step_ = 0, longest_checkpoint_ = 0;
  std::vector<int> seen_; // of each signal
};

} // namespace impact
