#pragma once
#include <string>

namespace impact {

/// Ends the process with `message` on the terminal and exit status 4 when it is not destroyed within
/// `seconds`: for collective writes, in which HDF5 waits for ever on the other ranks after a failure of its
/// own. One at a time; uses SIGALRM.
class Watchdog {
public:
  Watchdog(double seconds, const std::string& message);
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
};

} // namespace impact
