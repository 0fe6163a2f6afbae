#include <cmath>
#include <cstdio>
#include <impact/petsc/error.hpp>
#include <impact/run/progress.hpp>
#include <impact/scenario/columns.hpp>

namespace impact {

Progress::Progress(MPI_Comm comm, double t_end)
    : comm_(comm), t_end_(t_end), start_(std::chrono::steady_clock::now()) {}

double Progress::wall() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::header() const { check(PetscPrintf(comm_, "%s\n", terminal_heads().c_str())); }

void Progress::line(const Snapshot& at, const StepCounts& c, const Ledger& ledger, int active) {

  const double wall = this->wall();
  if (first_time_ < 0) first_time_ = at.time - at.dt;
  const double done = at.time - first_time_;
  const double left = done > 0 ? wall * (t_end_ - at.time) / done : 0;
  check(PetscPrintf(comm_, "%8ld %12.6g %10.3g %3d %4d %6d %4d %3d %4d %8.5f %9.3g %10.2e %8s %8s\n", at.step,
                    at.time, at.dt, at.tries, static_cast<int>(c.newton), static_cast<int>(c.linear),
                    static_cast<int>(c.damage), static_cast<int>(c.uzawa), active, ledger.energies().phi_max,
                    ledger.energies().alpha_max, ledger.balance_first_law(), clock(wall).c_str(),
                    clock(left).c_str()));
}

std::string Progress::clock(double seconds) {
  char text[32];
  const long s = std::lround(seconds);
  if (s < 3600)
    std::snprintf(text, sizeof(text), "%ld:%02ld", s / 60, s % 60);
  else
    std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  return text;
}

} // namespace impact
