#include <cmath>
#include <cstdio>
#include <impact/input/database.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/shared_cores.hpp>
#include <impact/run/progress.hpp>

namespace impact {

void report_setup(const Scenario& s, const Discretisation& d, const SolverDefaults& solver) {
  const MPI_Comm comm = d.mesh.comm();
  int ranks = 1;
  const int threads = threads_per_rank();
  MPI_Comm_size(comm, &ranks);
  check(PetscPrintf(comm, "impact: %s\n", s.title.empty() ? "(no title)" : s.title.c_str()));
  check(PetscPrintf(comm,
                    "mesh %s: %lld nodes, %lld cells, shortest edge %.4g; %d rank%s, %d thread%s each\n",
                    s.mesh.file.c_str(), static_cast<long long>(d.mesh.global_node_count()),
                    static_cast<long long>(d.mesh.global_cell_count()), d.mesh.smallest_edge(), ranks,
                    ranks == 1 ? "" : "s", threads, threads == 1 ? "" : "s"));
  for (const MaterialAssignment& m : d.materials) {
    const MaterialParameters& p = m.law.parameters;
    if (m.law.rigid()) {
      check(PetscPrintf(comm, "material %s: rigid, rho %.6g\n", p.id.c_str(), p.rho));
      continue;
    }
    check(PetscPrintf(comm, "material %s: %s%s%s, K %.6g, G %.6g, rho %.6g\n", p.id.c_str(),
                      p.model == Model::j2 ? "j2" : "elastic",
                      p.damage == Damage::at2   ? " with at2 damage"
                      : p.damage == Damage::at1 ? " with at1 damage"
                                                : "",
                      m.law.fatigues() ? " and fatigue" : "", p.K, p.G, p.rho));
  }
  if (s.has_heat())
    for (const MaterialAssignment& m : d.materials)
      check(PetscPrintf(comm, "heat in %s: c_V %.6g, conductivity %.6g, alpha_t %.6g, theta_0 %.6g\n",
                        m.law.parameters.id.c_str(), m.law.parameters.c_v, m.law.parameters.conductivity,
                        m.law.parameters.alpha_t, m.law.parameters.theta0));
  if (s.has_motion())
    check(PetscPrintf(comm, "motion solver: %s; tangent %s\n", solver.reason.c_str(),
                      solver.symmetric ? "symmetric" : "consistent"));
  else
    check(PetscPrintf(comm, "no motion: bodies stay where they are\n"));
}

void report_unused_options(MPI_Comm comm, bool strict) {
  std::string text;
  for (const std::string& option : unconsumed_options()) text += (text.empty() ? "" : ", ") + option;
  text = broadcast(comm, text);
  if (text.empty()) return;
  if (strict) throw UserError(ExitCode::usage, "options that nothing used: " + text + " (-options_strict)");
  check(PetscPrintf(comm, "impact: options that nothing used: %s\n", text.c_str()));
}

Progress::Progress(MPI_Comm comm, double t_end)
    : comm_(comm), t_end_(t_end), start_(std::chrono::steady_clock::now()) {}

double Progress::wall() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void Progress::header() const {
  check(PetscPrintf(comm_, "%8s %12s %10s %3s %4s %6s %4s %3s %4s %8s %9s %10s %8s %8s\n", "step", "t", "dt",
                    "try", "newt", "linear", "dam", "uz", "act", "max phi", "max alpha", "1st law", "wall",
                    "left"));
}

void Progress::line(const Snapshot& at, const StepCounts& c, const Ledger& ledger, int active) {

  const double wall = this->wall();
  if (first_time_ < 0) first_time_ = at.time - at.dt;
  const double done = at.time - first_time_;
  const double left = done > 0 ? wall * (t_end_ - at.time) / done : 0;
  check(PetscPrintf(comm_, "%8ld %12.6g %10.3g %3d %4d %6d %4d %3d %4d %8.5f %9.3g %10.2e %8s %8s\n", at.step,
                    at.time, at.dt, at.tries, static_cast<int>(c.newton), static_cast<int>(c.linear),
                    static_cast<int>(c.damage), static_cast<int>(c.uzawa), active, ledger.phi_max(),
                    ledger.alpha_max(), ledger.balance_first_law(), clock(wall).c_str(),
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
