#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"

// Damage and heat together, in a body whose motion is prescribed. phi is chosen; the temperature is what
// makes the elastic energy of the (cold, held) body just the drive that this phi needs, and the source that
// such a temperature needs follows by differences. Each balance then has the other one's field in it: E+ of
// J_e in the damage equation; conductivity, thermoelastic entropy and the dissipation of damage in the heat
// equation. Solved by the program's own staggered passes.

namespace impact {
namespace {

using problem_test::CaseSettings;
using problem_test::condition;
using problem_test::expression;
using problem_test::Field;
using problem_test::MotionCase;
using run_test::box_mesh;

constexpr double pi = std::numbers::pi;

MaterialParameters material() {
  MaterialParameters law;
  law.K = 2;
  law.G = 1;
  law.b_d = 0.5;
  law.split = Split::none;
  law.damage = Damage::at2;
  law.Gc = 0.15;
  law.gamma = 0.3;
  law.c = 2;
  law.zeta = 1;
  law.c_v = 1.7;
  law.theta0 = 300;
  law.alpha_t = 0.01;
  law.conductivity = 4;
  return law;
}

/// The chosen motion and damage, and what follows from them. `waves` is the amplitude of what varies in
/// space.
class Solution {
public:
  Solution(const MaterialParameters& law, int dim, double waves) : m_(law), dim_(dim), waves_(waves) {}

  /// F_kk - 1, each direction with a rate of its own; the third one is held in the plane.
  double stretch(int k, double t) const {
    constexpr double rate[3] = {0.04, -0.03, 0.02};
    return k < dim_ ? rate[k] * std::sin(t) : 0;
  }
  double phi(const double* x, double t) const {
    return 0.2 + waves_ * (1 + t) * shape(x) + 0.1 * t + 0.1 * t * t;
  }
  double phi_rate(const double* x, double t) const { return waves_ * shape(x) + 0.1 + 0.2 * t; }

  /// From lambda phi_dot = Div(G_c gamma C^-1 Grad phi) + 2 (1 - k) (1 - phi) E - G_c phi/gamma, (43).
  double theta(const double* x, double t) const {
    double laplace = 0;
    for (int k = 0; k < dim_; ++k)
      laplace -= pi * pi * waves_ * (1 + t) * shape(x) / std::pow(1 + stretch(k, t), 2);
    const double p = phi(x, t);
    const double E = (damping(p) * phi_rate(x, t) - m_.Gc * m_.gamma * laplace + m_.Gc * p / m_.gamma) /
                     (2 * (1 - m_.residual_stiffness) * (1 - p));
    double trace = 0;
    for (int k = 0; k < 3; ++k) trace += std::pow(1 + stretch(k, t), 2);
    const double U = E - m_.G / 2 * (trace * std::pow(volume(t), -2. / 3) - 3);
    // J_e > 1 with K/2 ((J_e^2 - 1)/2 - ln J_e) = U
    double Je = 1 + std::sqrt(2 * U / m_.K);
    for (int i = 0; i < 20; ++i)
      Je -= (m_.K / 2 * ((Je * Je - 1) / 2 - std::log(Je)) - U) / (m_.K / 2 * (Je - 1 / Je));
    return m_.theta0 + std::log(volume(t) / Je) / (3 * m_.alpha_t);
  }

  /// theta d eta/dt + Div q - dissipation, (45').
  double source(const double* x, double t) const {
    const auto entropy = [&](double s) {
      const double T = theta(x, s), Je = volume(s) / std::exp(3 * m_.alpha_t * (T - m_.theta0));
      return m_.c_v * std::log(T / m_.theta0) +
             3 * m_.alpha_t * degradation(phi(x, s)) * m_.K / 2 * (Je * Je - 1);
    };
    double divergence = 0, viscous = 0;
    for (int k = 0; k < dim_; ++k) {
      const auto flux = [&](double y) {
        double at[3] = {x[0], x[1], dim_ == 3 ? x[2] : 0};
        at[k] = y;
        const double p = phi(at, t), slope = derivative(
                                         [&](double z) {
                                           at[k] = z;
                                           return theta(at, t);
                                         },
                                         y);
        return -m_.conductivity * degradation(p) * volume(t) / std::pow(1 + stretch(k, t), 2) * slope;
      };
      divergence += derivative(flux, x[k]);
      viscous +=
          m_.b_d * std::pow(derivative([&](double s) { return std::pow(1 + stretch(k, s), 2); }, t), 2);
    }
    return theta(x, t) * derivative(entropy, t) + divergence - viscous -
           damping(phi(x, t)) * std::pow(phi_rate(x, t), 2);
  }

private:
  double shape(const double* x) const {
    double s = 1;
    for (int k = 0; k < dim_; ++k) s *= std::sin(pi * x[k] + 0.3);
    return s;
  }
  double volume(double t) const {
    double J = 1;
    for (int k = 0; k < dim_; ++k) J *= 1 + stretch(k, t);
    return J;
  }
  double damping(double phi) const { return std::pow(1 + m_.delta - phi, m_.zeta) / m_.c; }
  double degradation(double phi) const {
    return (1 - m_.residual_stiffness) * (1 - phi) * (1 - phi) + m_.residual_stiffness;
  }
  template <class Function> static double derivative(Function&& f, double x) { // of fourth order
    const double h = 4e-3;
    return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * h);
  }

  MaterialParameters m_;
  int dim_;
  double waves_;
};

struct Errors {
  double phi, theta;
};

/// All nodes moved; phi and theta prescribed all around, or nowhere where nothing varies in space.
Errors solve(Shape shape, int n, int steps, double t_end, double waves, HeatForm form) {
  const MaterialParameters law = material();
  const int dim = dimension(shape);
  const Solution exact(law, dim, waves);
  const Field phi = [exact](const double*x, double t) { return exact.phi(x, t); },
              theta = [exact](const double*x, double t) { return exact.theta(x, t); },
              source = [exact](const double*x, double t) { return exact.source(x, t); };
  std::vector<Field> motion;
  for (int k = 0; k < dim; ++k)
    motion.emplace_back([exact, k](const double* x, double t) { return exact.stretch(k, t) * x[k]; });
  const auto scalar = [](std::string id, std::string on, BcType type, Field value) {
    BoundaryCondition bc;
    bc.id = std::move(id);
    bc.on = {std::move(on)};
    bc.type = type;
    bc.value = expression(std::move(value));
    return bc;
  };
  std::vector<BoundaryCondition> conditions{condition("motion", "solid", BcType::displacement, motion),
                                            scalar("source", "solid", BcType::heat_source, source)};
  if (waves != 0) {
    conditions.push_back(scalar("phi", "boundary", BcType::damage, phi));
    conditions.push_back(scalar("theta", "boundary", BcType::temperature, theta));
  }
  CaseSettings settings;
  settings.dt = t_end / steps;
  settings.t_end = t_end;
  settings.initial_phi = phi;
  settings.initial_theta = theta;
  settings.heat.form = form;
  settings.coupling.max_it = 100;
  settings.coupling.atol = 1e-10;
  settings.coupling.theta_tol = 1e-12;
  MotionCase run(
      run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("coupled_order"), box_mesh(shape, n)), law,
      std::move(conditions), settings);
  run.run();
  EXPECT_EQ(run.rejected, 0);
  const Mesh& mesh = run.discretisation().mesh;
  return {problem_test::l2_error(mesh, run.scalar("phi"), 1, {phi}, t_end).error,
          problem_test::l2_error(mesh, run.scalar("theta"), 1, {theta}, t_end).error};
}

/// Errors must fall by ratio^order between runs.
void expect_orders(const char* what, const Errors& before, const Errors& now, double ratio, double reference,
                   double below, double above) {
  const double of_phi = std::log(before.phi / now.phi) / std::log(ratio),
               of_theta = std::log(before.theta / now.theta) / std::log(ratio);
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0)
    std::printf("  %s: L2 errors of phi %.3e, theta %.3e, orders %.3f, %.3f (reference %g)\n", what, now.phi,
                now.theta, of_phi, of_theta, reference);
  for (const double order : {of_phi, of_theta}) {
    EXPECT_GE(order, reference - below) << what;
    EXPECT_LE(order, reference + above) << what;
  }
}

// With steps like the square of the cells both errors are of second order in the cells.
void space_order(Shape shape, int coarsest, const char* what, HeatForm form) {
  Errors before{};
  for (int n = coarsest, steps = 2; n <= 4 * coarsest; n *= 2, steps *= 4) {
    const Errors now = solve(shape, n, steps, 0.2, 0.1, form);
    if (n > coarsest) expect_orders(what, before, now, 2, 2, 0.1, 0.2);
    before = now;
  }
}

TEST(CoupledDamageAndHeat, ConvergeWithOrderTwoInSpace) {
  space_order(Shape::quad4, 4, "quad4, entropy form", HeatForm::entropy);
  space_order(Shape::quad4, 4, "quad4, energy form", HeatForm::energy);
  space_order(Shape::tri3, 6, "tri3, entropy form", HeatForm::entropy);
}

// Without waves all is uniform, so that only the steps err.
TEST(CoupledDamageAndHeat, ConvergeWithOrderOneInTime) {
  for (const HeatForm form : {HeatForm::entropy, HeatForm::energy}) {
    Errors before{};
    for (int steps = 20; steps <= 80; steps *= 2) {
      const Errors now = solve(Shape::quad4, 2, steps, 1, 0, form);
      if (steps > 20)
        expect_orders(form == HeatForm::entropy ? "Euler, entropy form" : "Euler, energy form", before, now,
                      2, 1, 0.1, 0.1);
      before = now;
    }
  }
}

} // namespace
} // namespace impact
