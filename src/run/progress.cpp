#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/input/database.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/shared_cores.hpp>
#include <impact/run/progress.hpp>
#include <vector>

namespace impact {

namespace {

// The choice of a locking cure, and a word where there is none: for each material and shape, once.
void report_locking(const Scenario& s, const Discretisation& d) {
  if (!s.has_motion() || s.plane == PlaneMode::stress) return;
  constexpr const char* names[] = {"linear triangles", "quadrilaterals", "linear tetrahedra", "hexahedra"};
  constexpr std::size_t shapes = 4;
  std::vector<int> found(d.materials.size() * shapes, 0);
  for (const CellGroup& group : d.groups)
    found[static_cast<std::size_t>(group.material) * shapes + static_cast<std::size_t>(group.shape)] = 1;
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_INT, MPI_MAX, d.mesh.comm());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const PointLaw& law = d.materials[i / shapes].law;
    const MaterialParameters& p = law.parameters;
    const auto shape = static_cast<Shape>(i % shapes);
    const bool simplex = shape == Shape::tri3 || shape == Shape::tet4;
    if (!found[i]) continue;
    if (!simplex && p.locking != Locking::none)
      check(PetscPrintf(d.mesh.comm(), "material %s: locking cure of its %s: %s\n", p.id.c_str(),
                        names[i % shapes], p.locking == Locking::mean ? "mean volume of a cell" : "F-bar"));
    // What has a choice of cures locks at the user's will.
    if (!keeps_volume(p) || (!simplex && !law.spectral())) continue;
    check(PetscPrintf(
        d.mesh.comm(),
        "impact: material %s: its %s lock, too stiff, because %s; remedy: %s, or a finer mesh\n",
        p.id.c_str(), names[i % shapes],
        law.flows() ? "plastic flow (j2) keeps the volume" : "it is nearly incompressible (nu from 0.45 on)",
        !simplex               ? "another -material_<id>_split"
        : shape == Shape::tri3 ? "quadrilaterals (Recombine Surface in the .geo)"
                               : "hexahedra (Transfinite Volume and Recombine in the .geo)"));
  }
}

// Of all cells of a material on all ranks.
struct Extent {
  double edge = HUGE_VAL; // the shortest
  double size = 0;        // the longest side of the box around them
};

Extent extent_of(const Discretisation& d, int material) {
  const int dim = d.dim();
  double low[4] = {HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  const auto x = [&](int node, int i) {
    return d.mesh.coordinates()[static_cast<std::size_t>(node * dim + i)];
  };
  for (const CellGroup& group : d.groups) {
    if (group.material != material || group.batch_count == 0) continue;
    const std::size_t per_batch = group.node.size() / static_cast<std::size_t>(group.batch_count);
    for (std::size_t k = 0; k < group.node.size(); ++k) {
      for (int i = 0; i < dim; ++i) {
        low[i] = std::min(low[i], x(group.node[k], i));
        high[i] = std::max(high[i], x(group.node[k], i));
      }
      // The other nodes of the same cell: in the same lane further on in the batch.
      for (std::size_t other = k + lanes; other / per_batch == k / per_batch; other += lanes) {
        double square = 0;
        for (int i = 0; i < dim; ++i) square += std::pow(x(group.node[other], i) - x(group.node[k], i), 2);
        low[3] = std::min(low[3], std::sqrt(square));
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, low, 4, MPI_DOUBLE, MPI_MIN, d.mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, high, 3, MPI_DOUBLE, MPI_MAX, d.mesh.comm());
  Extent extent{low[3], 0};
  for (int i = 0; i < dim; ++i) extent.size = std::max(extent.size, high[i] - low[i]);
  return extent;
}

// A crack narrower than its cells, or wider than its body, is none: its energy is not Gc.
void report_crack_widths(const Discretisation& d) {
  for (std::size_t k = 0; k < d.materials.size(); ++k) {
    const MaterialParameters& p = d.materials[k].law.parameters;
    if (p.damage == Damage::none) continue;
    const Extent extent = extent_of(d, static_cast<int>(k));
    const char* const id = p.id.c_str();
    if (p.gamma < 2 * extent.edge)
      check(PetscPrintf(
          d.mesh.comm(),
          "impact: WARNING: -material_%s_gamma %.4g is %.3g times its shortest edge %.4g: a crack "
          "wants at least 2, or it takes more than Gc; refine where it will run\n",
          id, p.gamma, p.gamma / extent.edge, extent.edge));
    if (p.gamma > extent.size)
      check(
          PetscPrintf(d.mesh.comm(),
                      "impact: WARNING: -material_%s_gamma %.4g is %.3g times the size %.4g of its body: no "
                      "crack has room in it; is the unit right?\n",
                      id, p.gamma, p.gamma / extent.size, extent.size));
  }
}

// What is asked for behind the end never comes.
void report_late_outputs(MPI_Comm comm, const Scenario& s) {
  const double end = s.time.max_time;
  const double steps = s.time.max_steps > 0 ? s.time.max_steps : s.time.dt > 0 ? end / s.time.dt : HUGE_VAL;
  for (const OutputScenario& output : s.outputs) {
    const std::string key = "-output_" + output.id;
    std::string late;
    for (double time : output.times)
      if (end > 0 && time > end * (1 + 1e-9)) late = key + "_times " + number_text(time);
    if (late.empty() && output.every <= steps) continue;
    if (late.empty()) late = key + "_every " + std::to_string(output.every);
    check(PetscPrintf(comm, "impact: WARNING: %s lies behind the end, -ts_max_time %.10g, about %.0f steps\n",
                      late.c_str(), end, steps));
  }
}

} // namespace

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
  report_locking(s, d);
  report_crack_widths(d);
  report_late_outputs(comm, s);
  if (s.has_motion())
    check(PetscPrintf(comm, "motion solver: %s; tangent %s\n", solver.reason.c_str(),
                      solver.symmetric ? "symmetric" : "consistent"));
  else
    check(PetscPrintf(comm, "no motion: bodies stay where they are\n"));
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
