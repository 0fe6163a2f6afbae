#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/time/step_control.hpp>
#include <impact/time/types.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

/// Small second-order problems under a TS, for the tests of this folder.
namespace impact::time_test {

using Entries = std::vector<std::pair<std::string, std::string>>;

/// Entries of the PETSc options database for the life of the object.
class Options {
public:
  explicit Options(Entries entries) : entries_(std::move(entries)) {
    for (const auto& [key, value] : entries_)
      check(PetscOptionsSetValue(nullptr, key.c_str(), value.c_str()));
  }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;
  ~Options() {
    for (const auto& entry : entries_) PetscOptionsClearValue(nullptr, entry.first.c_str());
  }

private:
  Entries entries_;
};

/// F(t, u, v, a), and J = dF/du + shift_v dF/dv + shift_a dF/da.
struct Equations {
  std::function<void(PetscReal t, Vec u, Vec v, Vec a, Vec r)> residual;
  std::function<void(Vec u, PetscReal shift_v, PetscReal shift_a, Mat J)> jacobian;
};

struct Simulation {
  Equations equations;
  Handle<Vec> u, v, r;
  Handle<Mat> J;
  Handle<TS> ts;
  Mailbox mailbox;

  Simulation(Equations given, PetscInt size);
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  SNES snes() const {
    SNES snes = nullptr;
    check(TSGetSNES(ts, &snes));
    return snes;
  }
  PetscReal time() const {
    PetscReal t = 0;
    check(TSGetTime(ts, &t));
    return t;
  }
  TSConvergedReason reason() const {
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    check(TSGetConvergedReason(ts, &reason));
    return reason;
  }
};

/// Starts at t = 0 with type `newmark` and tight tolerances; matrices of at most three diagonals.
inline Simulation::Simulation(Equations given, PetscInt size) : equations(std::move(given)) {
  const MPI_Comm comm = PETSC_COMM_WORLD;
  check(VecCreateMPI(comm, PETSC_DECIDE, size, u.out()));
  check(VecDuplicate(u, v.out()));
  check(VecDuplicate(u, r.out()));
  check(VecZeroEntries(u));
  check(VecZeroEntries(v));
  PetscInt rows = 0;
  check(VecGetLocalSize(u, &rows));
  check(MatCreateAIJ(comm, rows, rows, size, size, 3, nullptr, 2, nullptr, J.out()));
  PetscInt begin = 0, end = 0;
  check(MatGetOwnershipRange(J, &begin, &end));
  for (PetscInt i = begin; i < end; ++i)
    for (PetscInt j = std::max<PetscInt>(i - 1, 0); j <= std::min<PetscInt>(i + 1, size - 1); ++j)
      check(MatSetValue(J, i, j, 0, INSERT_VALUES));
  check(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  register_time_types();
  check(TSCreate(comm, ts.out()));
  check(TSSetType(ts, "newmark"));
  check(TS2SetSolution(ts, u, v));
  const auto residual = [](TS, PetscReal t, Vec x, Vec x_t, Vec x_tt, Vec f,
                           void* context) -> PetscErrorCode {
    auto& self = *static_cast<Simulation*>(context);
    return self.mailbox.guarded([&] { self.equations.residual(t, x, x_t, x_tt, f); });
  };
  const auto jacobian = [](TS, PetscReal, Vec x, Vec, Vec, PetscReal shift_v, PetscReal shift_a, Mat, Mat P,
                           void* context) -> PetscErrorCode {
    auto& self = *static_cast<Simulation*>(context);
    return self.mailbox.guarded([&] { self.equations.jacobian(x, shift_v, shift_a, P); });
  };
  check(TSSetI2Function(ts, r, residual, this));
  check(TSSetI2Jacobian(ts, J, J, jacobian, this));
  check(SNESSetTolerances(snes(), 1e-12, 1e-13, 1e-15, 30, PETSC_DEFAULT));
  KSP ksp = nullptr;
  PC pc = nullptr;
  check(SNESGetKSP(snes(), &ksp));
  check(KSPGetPC(ksp, &pc));
  check(KSPSetType(ksp, KSPCG));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(ksp, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
}

/// Sets one vector entry by entry from its global index.
template <class Value> void fill(Vec x, Value&& value) {
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(x, &begin, &end));
  for (PetscInt i = begin; i < end; ++i) check(VecSetValue(x, i, value(i), INSERT_VALUES));
  check(VecAssemblyBegin(x));
  check(VecAssemblyEnd(x));
}

/// Entry i on all ranks.
inline PetscReal entry(Vec x, PetscInt i) {
  PetscInt begin = 0, end = 0;
  check(VecGetOwnershipRange(x, &begin, &end));
  PetscScalar value = -std::numeric_limits<PetscReal>::infinity();
  if (i >= begin && i < end) check(VecGetValues(x, 1, &i, &value));
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPIU_SCALAR, MPIU_MAX, PETSC_COMM_WORLD);
  return value;
}

/// Equal oscillators m a + c v + k u + cubic u^3 = t load, one per unknown.
struct Oscillator {
  PetscReal m = 1, c = 0, k = 1, cubic = 0, load = 0;
};

inline Equations equations_of(const Oscillator& o) {
  return {.residual =
              [o](PetscReal t, Vec u, Vec v, Vec a, Vec r) {
                PetscInt rows = 0;
                const PetscScalar *us = nullptr, *vs = nullptr, *as = nullptr;
                PetscScalar* rs = nullptr;
                check(VecGetLocalSize(u, &rows));
                check(VecGetArrayRead(u, &us));
                check(VecGetArrayRead(v, &vs));
                check(VecGetArrayRead(a, &as));
                check(VecGetArray(r, &rs));
                for (PetscInt i = 0; i < rows; ++i)
                  rs[i] =
                      o.m * as[i] + o.c * vs[i] + o.k * us[i] + o.cubic * us[i] * us[i] * us[i] - o.load * t;
                check(VecRestoreArray(r, &rs));
                check(VecRestoreArrayRead(a, &as));
                check(VecRestoreArrayRead(v, &vs));
                check(VecRestoreArrayRead(u, &us));
              },
          .jacobian =
              [o](Vec u, PetscReal shift_v, PetscReal shift_a, Mat J) {
                PetscInt begin = 0, end = 0;
                const PetscScalar* us = nullptr;
                check(VecGetOwnershipRange(u, &begin, &end));
                check(VecGetArrayRead(u, &us));
                for (PetscInt i = begin; i < end; ++i) {
                  const PetscReal x = us[i - begin];
                  const PetscReal value = o.m * shift_a + o.c * shift_v + o.k + 3 * o.cubic * x * x;
                  check(MatSetValue(J, i, i, value, INSERT_VALUES));
                }
                check(VecRestoreArrayRead(u, &us));
                check(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
                check(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
              }};
}

inline Equations linear_equations(Mat M, Mat K) {
  return {.residual =
              [M, K](PetscReal, Vec u, Vec, Vec a, Vec r) {
                check(MatMult(M, a, r));
                check(MatMultAdd(K, u, r, r));
              },
          .jacobian =
              [M, K](Vec, PetscReal, PetscReal shift_a, Mat J) {
                check(MatCopy(K, J, DIFFERENT_NONZERO_PATTERN));
                check(MatAXPY(J, shift_a, M, DIFFERENT_NONZERO_PATTERN));
              }};
}

/// Gives a TS with inertia the acceleration that balances the forces at the start: M a = -F(t, u, v, 0), with
/// M = (J(shift) - J(0))/shift at a shift where mass and stiffness are of like size; rows without mass get a
/// = 0.
inline void start(Simulation& simulation) {
  if (!integrator_of(simulation.ts).inertia || acceleration(simulation.ts) != nullptr) return;
  PetscReal dt = 0;
  check(TSGetTimeStep(simulation.ts, &dt));
  const PetscReal shift = 4 / (dt * dt);
  Handle<Vec> a, force, diagonal;
  Handle<Mat> mass;
  Handle<KSP> ksp;
  for (Handle<Vec>* vec : {&a, &force, &diagonal}) check(VecDuplicate(simulation.u, vec->out()));
  check(VecZeroEntries(a));
  simulation.equations.residual(simulation.time(), simulation.u, simulation.v, a, force);
  check(VecScale(force, -1));
  simulation.equations.jacobian(simulation.u, 0, shift, simulation.J);
  check(MatDuplicate(simulation.J, MAT_COPY_VALUES, mass.out()));
  simulation.equations.jacobian(simulation.u, 0, 0, simulation.J);
  check(MatAXPY(mass, -1, simulation.J, SAME_NONZERO_PATTERN));
  check(MatScale(mass, 1 / shift));
  check(MatGetDiagonal(mass, diagonal));
  PetscInt rows = 0;
  PetscScalar *d = nullptr, *f = nullptr;
  check(VecGetLocalSize(diagonal, &rows));
  check(VecGetArray(diagonal, &d));
  check(VecGetArray(force, &f));
  for (PetscInt i = 0; i < rows; ++i)
    if (d[i] == 0) d[i] = 1, f[i] = 0;
  check(VecRestoreArray(force, &f));
  check(VecRestoreArray(diagonal, &d));
  check(MatDiagonalSet(mass, diagonal, INSERT_VALUES));
  PC pc = nullptr;
  check(KSPCreate(PETSC_COMM_WORLD, ksp.out()));
  check(KSPSetOperators(ksp, mass, mass));
  check(KSPSetType(ksp, KSPCG));
  check(KSPGetPC(ksp, &pc));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(ksp, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  check(KSPSolve(ksp, force, a));
  set_acceleration(simulation.ts, a);
}

/// Runs to t_end in steps of dt with the options given so far.
inline void run(Simulation& simulation, PetscReal dt, PetscReal t_end) {
  check(TSSetTimeStep(simulation.ts, dt));
  check(TSSetMaxTime(simulation.ts, t_end));
  check(TSSetMaxSteps(simulation.ts, 1000000));
  set_time_options(simulation.ts);
  start(simulation);
  solve_in_time(simulation.ts);
}

} // namespace impact::time_test
