#include "cpu_clock.hpp"
#include "search_bench.hpp"
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/problem/motion.hpp>
#include <vector>

// Cost per cell of the loops that a Newton iteration spends its time in, on regular meshes of one material,
// or with -search that of the search for contact pairs (search_bench.hpp). usage: impact_bench [-search]
// [-dim 2|3] [-n <cells along an edge>] [-repetitions 7] [-law neo-Hooke|J2|J2-mean] Without -dim and -n: 316
// x 316 quadrilaterals and 40 x 40 x 40 hexahedra, about 200,000 dofs each. One line each: what, CPU
// nanoseconds per cell (smallest of the repetitions) and the spread of the repetitions, (median - smallest) /
// smallest. Read by tools/bench_peers.

namespace impact {
namespace {

struct Line {
  double ns_per_cell, spread;
};

Line measure(PetscInt cells, int repetitions, const std::function<void()>& body) {
  body(); // first touch
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    const double start = cpu_seconds();
    body();
    seconds.push_back(cpu_seconds() - start);
  }
  std::sort(seconds.begin(), seconds.end());
  const double least = seconds.front(), median = seconds[seconds.size() / 2];
  return {1e9 * least / static_cast<double>(cells), (median - least) / least};
}

// The unit square or cube in n cells along each edge; region "solid", its surface "hull".
Mesh unit_box(int dim, int n) {
  const PetscInt faces[3] = {n, n, n};
  Handle<DM> dm;
  check(DMPlexCreateBoxMesh(PETSC_COMM_WORLD, dim, PETSC_FALSE, faces, nullptr, nullptr, nullptr, PETSC_TRUE,
                            dm.out()));
  std::vector<PetscInt> no_patches;
  order_for_locality(dm, no_patches);
  check(DMCreateLabel(dm, "solid"));
  check(DMCreateLabel(dm, "hull"));
  DMLabel solid = nullptr, hull = nullptr;
  check(DMGetLabel(dm, "solid", &solid));
  check(DMGetLabel(dm, "hull", &hull));
  PetscInt start = 0, end = 0;
  check(DMPlexGetHeightStratum(dm, 0, &start, &end));
  for (PetscInt cell = start; cell < end; ++cell) check(DMLabelSetValue(solid, cell, dim));
  check(DMPlexMarkBoundaryFaces(dm, dim - 1, hull));
  return {std::move(dm), {{"solid", dim}, {"hull", dim - 1}}};
}

struct Law {
  const char* name;
  MaterialParameters parameters;
};

std::vector<Law> laws() {
  MaterialParameters elastic;
  elastic.K = 70;
  elastic.G = 27;
  MaterialParameters plastic = elastic;
  plastic.model = Model::j2; // yields nearly everywhere under the displacement below
  plastic.sigma_y = 0.368;
  plastic.voce_r = 0.078;
  plastic.voce_s = 32;
  MaterialParameters mean = plastic;
  mean.locking = Locking::mean;
  return {{"neo-Hooke", elastic}, {"J2", plastic}, {"J2-mean", mean}};
}

// The smooth displacement that the scripts beside this program use.
double displacement(int dim, const double* x, int k) {
  if (k == 0) return 0.02 * x[0] * x[0] + 0.03 * x[1];
  return k == 1 && dim == 3 ? 0.03 * x[2] : 0.03 * x[0];
}

class Bench {
public:
  Bench(int dim, int n, const Law& law, int repetitions, MatrixFormat format = MatrixFormat::aij)
      : law_(law), repetitions_(repetitions), mark_(format == MatrixFormat::sbaij ? ", sbaij" : ""),
        d_(discretise(unit_box(dim, n), {{PointLaw{law.parameters}, {"solid"}}}, Frame::plane_strain, 1)),
        boundary_(d_.mesh, {held_hull()}, 1),
        motion_(d_, declared(), boundary_, contacts_, false, ContactOperator::assembled, format),
        u_(d_.displacement.make_global()), f_(d_.displacement.make_global()) {
    start_ = d_.displacement.make_local();
    std::vector<double> local = start_;
    for (std::size_t i = 0; i < local.size(); ++i) {
      const auto node = i / static_cast<std::size_t>(dim);
      const double* x = &d_.mesh.coordinates()[node * static_cast<std::size_t>(dim)];
      local[i] = displacement(dim, x, static_cast<int>(i) % dim);
    }
    d_.displacement.to_global(local, u_);
    MotionStep step;
    step.t = step.dt = 1;
    step.u_n = &start_;
    motion_.begin(step);
  }

  void residual() {
    report("residual", [&] { sound(motion_.residual(u_, nullptr, f_)); });
  }
  // What one Newton iteration asks for: both, and the tangent added into the default matrix.
  void residual_and_tangent() {
    report("residual + tangent", [&] {
      sound(motion_.residual(u_, nullptr, f_));
      sound(motion_.tangent(u_, 0));
    });
  }
  void tangent() {
    report("tangent", [&] { sound(motion_.tangent(u_, 0)); });
  }
  void advance() {
    MotionProblem::Increments sums;
    report("state update", [&] { sound(motion_.advance(u_, sums)); });
    const StateRow& history = state_.row("history");
    const auto components = static_cast<std::size_t>(history_size(d_.frame));
    std::size_t flowing = 0, points = 0; // the last component is alpha
    for (std::size_t i = (components - 1) * lanes; i < history.trial.size();
         i += components * lanes, ++points)
      flowing += history.trial[i] > 0;
    std::printf("  flowing points: %.0f %%\n",
                100 * static_cast<double>(flowing) / static_cast<double>(points));
  }
  void multiply() {
    report("MatMult", [&] { check(MatMult(motion_.matrix(), u_, f_)); });
  }

private:
  static BoundaryCondition held_hull() {
    BoundaryCondition bc;
    bc.id = "hull";
    bc.on = {"hull"};
    bc.type = BcType::fix;
    return bc;
  }
  StateTable& declared() {
    declare_state(d_, state_);
    return state_;
  }
  static void sound(bool good) {
    if (!good) throw UserError(ExitCode::internal, "bench: the displacement breaks a cell");
  }
  void report(const char* what, const std::function<void()>& body) {
    const PetscInt cells = d_.mesh.global_cell_count();
    const Line line = measure(cells, repetitions_, body);
    std::printf("%dD, %s, %s%s: %.1f cpu-ns/cell, spread %.0f %%, %d cells, %d lanes\n", d_.dim(), law_.name,
                what, mark_, line.ns_per_cell, 100 * line.spread, static_cast<int>(cells), lanes);
    std::fflush(stdout);
  }

  Law law_;
  int repetitions_;
  const char* mark_; // behind the names of what a matrix format other than AIJ is given to do
  Discretisation d_;
  StateTable state_;
  BoundaryData boundary_;
  ContactSet contacts_;
  MotionProblem motion_;
  Handle<Vec> u_, f_;
  std::vector<double> start_;
};

void run() {
  char only[16] = "";
  PetscInt dim = 0, n = 0, repetitions = 7;
  check(PetscOptionsGetInt(nullptr, nullptr, "-dim", &dim, nullptr));
  check(PetscOptionsGetInt(nullptr, nullptr, "-n", &n, nullptr));
  check(PetscOptionsGetInt(nullptr, nullptr, "-repetitions", &repetitions, nullptr));
  check(PetscOptionsGetString(nullptr, nullptr, "-law", only, sizeof(only), nullptr));
  PetscBool search = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, nullptr, "-search", &search));
  if (search) return bench_search(static_cast<int>(repetitions));
  for (const int d : {2, 3}) {
    if (dim != 0 && d != dim) continue;
    const int edge = n > 0 ? static_cast<int>(n) : d == 2 ? 316 : 40;
    for (const Law& law : laws()) {
      if (only[0] != 0 && std::string(only) != law.name) continue;
      Bench bench(d, edge, law, static_cast<int>(repetitions));
      bench.residual();
      bench.tangent();
      bench.residual_and_tangent();
      bench.advance();
      if (law.parameters.model != Model::elastic) continue;
      bench.multiply();
      Bench half(d, edge, law, static_cast<int>(repetitions), MatrixFormat::sbaij);
      half.tangent();
      half.residual_and_tangent();
      half.multiply();
    }
  }
}

} // namespace
} // namespace impact

int main(int argc, char** argv) {
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0) return 6;
  int status = 0, ranks = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  try {
    if (ranks > 1) throw impact::UserError(impact::ExitCode::usage, "bench: CPU time is judged on one rank");
    impact::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "impact_bench: %s\n", error.what());
    status = 1;
  }
  const int finalised = PetscFinalize();
  return status != 0 ? status : finalised;
}
