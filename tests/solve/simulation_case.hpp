#pragma once
#include "../time/simulation.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <impact/math/rotation.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/solve/coupling.hpp>
#include <impact/time/step_control.hpp>
#include <impact/time/types.hpp>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

/// A run put together by hand from a mesh, one law and conditions given as functions: what the manufactured
/// solutions need.
namespace impact::problem_test {

using Field = std::function<double(const double* x, double t)>;

inline Expression expression(Field field) {
  return {"test", [field = std::move(field)](const double* x, int, double t) { return field(x, t); }};
}

/// The displacement (or body force) given by one function per component on the groups `on`.
inline BoundaryCondition condition(std::string id, std::string on, BcType type,
                                   const std::vector<Field>& fields) {
  BoundaryCondition bc;
  bc.id = std::move(id);
  bc.on = {std::move(on)};
  bc.type = type;
  for (std::size_t k = 0; k < fields.size(); ++k) bc.component[k] = expression(fields[k]);
  return bc;
}

struct CaseSettings {
  bool inertia = false;
  std::optional<Integrator> integrator{}; ///< in place of the trapezoidal rule
  double dt = 1, t_end = 1;
  std::vector<Field> initial_velocity{};
  Field initial_phi{}, initial_theta{}; ///< of laws with damage, with heat
  HeatScenario heat{};
  CouplingScenario coupling{};
};

/// One material on the region "solid", with damage and heat where it has them.
class MotionCase {
public:
  MotionCase(Mesh mesh, const MaterialParameters& law, std::vector<BoundaryCondition> conditions,
             const CaseSettings& settings)
      : settings_(settings),
        d_(discretise(std::move(mesh), {{PointLaw{law}, {"solid"}}}, Frame::plane_strain, 1)),
        boundary_(d_.mesh, std::move(conditions), settings.t_end) {
    register_time_types();
    declare_state(d_, state_);
    const SolverDefaults solver; // direct
    motion_.emplace(d_, state_, boundary_, contacts_, false);
    if (d_.has_damage()) damage_.emplace(d_, state_, boundary_, DamageScenario{});
    if (d_.has_heat()) heat_.emplace(d_, state_, boundary_, settings.heat, true);
    check(TSCreate(d_.mesh.comm(), ts_.out()));
    check(TSSetProblemType(ts_, TS_NONLINEAR));
    check(TSSetType(ts_, settings.inertia ? "newmark" : "static"));
    check(TSSetTimeStep(ts_, settings.dt));
    check(TSSetMaxTime(ts_, settings.t_end));
    check(TSSetMaxSteps(ts_, 100000));
    CouplingScenario full_newton = settings.coupling; // its order is one of the claims
    full_newton.reuse_tangent = 0;
    // Each pass begins with the tolerance of the options.
    const time_test::Options to_round_off(time_test::Entries{{"-motion_snes_rtol", "1e-13"}});
    coupling_.emplace(ts_, Fields{*motion_, damage_ ? &*damage_ : nullptr, heat_ ? &*heat_ : nullptr, state_},
                      full_newton, solver, false);
    set_time_options(ts_);
    if (settings.integrator) set_integrator(ts_, *settings.integrator);
    u_ = d_.displacement.make_global();
    v_ = d_.displacement.make_global();
    a_ = d_.displacement.make_global();
  }

  /// Runs to the end with Newton converged to round-off.
  void run() {
    const SNES newton = coupling_->motion_solver().snes();
    check(SNESSetTolerances(newton, 1e-5 * motion_->reference_force(), PETSC_DEFAULT, 0, 25, PETSC_DEFAULT));
    std::vector<double>& u = state_.row("u").trial;
    std::vector<double>& v = state_.row("v").trial;
    for (std::size_t i = 0; i < v.size() && !settings_.initial_velocity.empty(); ++i)
      v[i] = settings_.initial_velocity[i % dim()](node(i / dim()), 0);
    if (damage_) set_scalar("phi", settings_.initial_phi);
    if (heat_) set_scalar("theta", settings_.initial_theta);
    boundary_.set_displacement(0, 0, u, v, u);
    boundary_.set_initial_rates(0, settings_.dt, v, state_.row("a").trial);
    state_.row("mean_rate").trial = v;
    state_.row("prescribed_velocity").trial = v;
    state_.commit();
    d_.displacement.to_global(state_.row("u").committed, u_);
    d_.displacement.to_global(state_.row("v").committed, v_);
    check(TS2SetSolution(ts_, u_, v_));
    coupling_->begin_between_steps(0, u_, v_);
    coupling_->start(u_, v_, a_);
    StepHooks hooks;
    hooks.before_attempt = [this](TS, const Attempt& attempt) { coupling_->before_attempt(attempt); };
    if (settings_.inertia && coupling_->corrects())
      hooks.correct = [this](TS, Vec u_end, Vec v_end, Vec a_end) {
        coupling_->correct(u_end, v_end, a_end);
      };
    hooks.guess = [this](TS, const Attempt& attempt, Vec guess) {
      coupling_->guess(attempt, guess);
      residuals.clear();
    };
    hooks.on_reject = [this](TS, const Attempt&) {
      ++rejected;
      coupling_->reject();
    };
    hooks.on_accept = [this](TS, const Attempt& attempt) {
      Vec now = nullptr, rate = nullptr;
      check(TS2GetSolution(ts_, &now, &rate));
      StateRow& row = state_.row("u");
      d_.displacement.to_local(now, row.trial);
      d_.displacement.to_local(rate, state_.row("v").trial);
      for (std::size_t i = 0; i < row.trial.size(); ++i)
        state_.row("mean_rate").trial[i] = (row.trial[i] - row.committed[i]) / attempt.dt;
      state_.commit();
      iterations.push_back(static_cast<int>(coupling_->counts().newton));
    };
    set_step_hooks(ts_, std::move(hooks));
    check(SNESMonitorSet(
        newton,
        [](SNES, PetscInt, PetscReal norm, void* self) -> PetscErrorCode {
          static_cast<MotionCase*>(self)->residuals.push_back(norm);
          return 0;
        },
        this, nullptr));
    solve_in_time(ts_);
    TSConvergedReason reason = TS_CONVERGED_ITERATING;
    check(TSGetConvergedReason(ts_, &reason));
    ASSERT_GT(reason, 0) << coupling_->failure_text();
  }

  std::size_t dim() const { return static_cast<std::size_t>(d_.dim()); }
  const double* node(std::size_t i) const { return &d_.mesh.coordinates()[i * dim()]; }
  const Discretisation& discretisation() const { return d_; }
  const std::vector<double>& u() const { return state_.row("u").committed; }
  const std::vector<double>& scalar(const char* name) const { return state_.row(name).committed; }

  std::vector<int> iterations;   ///< of Newton's method, per step
  std::vector<double> residuals; ///< norms of the last Newton solve, the guess's first
  int rejected = 0;

private:
  void set_scalar(const char* name, const Field& field) {
    std::vector<double>& values = state_.row(name).trial;
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = field(node(i), 0);
  }

  CaseSettings settings_;
  Discretisation d_;
  StateTable state_;
  BoundaryData boundary_;
  ContactSet contacts_;
  std::optional<MotionProblem> motion_;
  std::optional<DamageProblem> damage_;
  std::optional<HeatProblem> heat_;
  Handle<TS> ts_;
  std::optional<Coupling> coupling_;
  Handle<Vec> u_, v_, a_;
};

/// L2 norms of field - exact, of exact, and of the gradient of field - exact, for a nodal field
/// [node][components], by four Gauss points along each axis of the reference cell (collapsed for simplices).
/// All ranks.
struct FieldError {
  double error = 0, size = 0, gradient = 0;
};
inline FieldError l2_error(const Mesh& mesh, const std::vector<double>& field, int components,
                           const std::vector<Field>& exact, double t) {
  constexpr double s = 0.86113631159405257522, m = 0.33998104358485626480;
  constexpr double ws = 0.34785484513745385737, wm = 0.65214515486254614263;
  constexpr double place[4] = {-s, -m, m, s}, weight[4] = {ws, wm, wm, ws};
  double sums[3] = {0, 0, 0};
  for (const CellTable& table : mesh.cells()) {
    const bool simplex = table.shape->simplex();
    const auto dim = table.shape->dim, nodes = table.shape->nodes;
    const std::size_t count = table.point.size();
    for (std::size_t cell = 0; cell < count; ++cell)
      for (int q = 0; q < (dim == 3 ? 64 : 16); ++q) {
        double xi[3] = {0, 0, 0};
        double w = 1;
        for (int k = 0; k < dim; ++k) {
          const int i = q >> (2 * k) & 3;
          xi[k] = simplex ? (1 + place[i]) / 2 : place[i];
          w *= simplex ? weight[i] / 2 : weight[i];
        }
        if (simplex) { // the unit cube onto the simplex
          double left = 1;
          for (int k = 0; k < dim; ++k) {
            const double along = xi[k];
            xi[k] = along * left;
            w *= k + 1 < dim ? std::pow(1 - along, dim - 1 - k) : 1;
            left *= 1 - along;
          }
        }
        double N[max_nodes], dN[3 * max_nodes];
        table.shape->basis(xi, N, dN);
        double x[3] = {0, 0, 0}, F[3][3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, dim == 2 ? 1. : 0.}},
               value[3] = {0, 0, 0}, slope[3][3] = {};
        for (int a = 0; a < nodes; ++a) {
          const auto node =
              static_cast<std::size_t>(table.connectivity[cell * unsigned(nodes) + unsigned(a)]);
          for (int i = 0; i < dim; ++i) {
            const double X = mesh.coordinates()[node * unsigned(dim) + unsigned(i)];
            x[i] += N[a] * X;
            for (int j = 0; j < dim; ++j) F[i][j] += X * dN[a * dim + j];
          }
          for (int i = 0; i < components; ++i) {
            const double nodal = field[node * unsigned(components) + unsigned(i)];
            value[i] += N[a] * nodal;
            for (int j = 0; j < dim; ++j) slope[i][j] += nodal * dN[a * dim + j];
          }
        }
        const double det = F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) -
                           F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
                           F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
        for (int i = 0; i < components; ++i) {
          const double is = exact[unsigned(i)](x, t);
          sums[0] += w * det * (value[i] - is) * (value[i] - is);
          sums[1] += w * det * is * is;
          for (int j = 0; j < dim; ++j) { // along dx/dxi_j, by a central difference of the exact field
            constexpr double h = 1e-4;
            double ends[2] = {0, 0};
            for (int end = 0; end < 2; ++end) {
              double y[3] = {x[0], x[1], x[2]};
              for (int k = 0; k < dim; ++k) y[k] += (end == 0 ? -h : h) * F[k][j];
              ends[end] = exact[unsigned(i)](y, t);
            }
            slope[i][j] -= (ends[1] - ends[0]) / (2 * h);
          }
        }
        const Matrix3 from_xi =
            inverse(Matrix3{F[0][0], F[0][1], F[0][2], F[1][0], F[1][1], F[1][2], F[2][0], F[2][1], F[2][2]});
        for (int i = 0; i < components; ++i)
          for (int k = 0; k < dim; ++k) {
            double g = 0;
            for (int j = 0; j < dim; ++j) g += slope[i][j] * from_xi[unsigned(3 * j + k)];
            sums[2] += w * det * g * g;
          }
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums, 3, MPI_DOUBLE, MPI_SUM, mesh.comm());
  return {std::sqrt(sums[0]), std::sqrt(sums[1]), std::sqrt(sums[2])};
}

} // namespace impact::problem_test
