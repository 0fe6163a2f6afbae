#include "../contact/contact_rig.hpp"
#include "../input/options_scope.hpp"
#include "../mesh/small_mesh.hpp"
#include "exponential_penalty.hpp"
#include <impact/run/simulation.hpp>

namespace impact::contact_test {
namespace {

ContactSettings exponential(double penalty, double scale) {
  ContactSettings s = settings_of(penalty);
  s.own_enforcement = [scale](const ContactSettings& settings, const EnforcementRows& rows) {
    return std::make_unique<ExponentialPenalty>(settings, rows, scale);
  };
  return s;
}

TEST(OwnEnforcement, ForceIsTheDerivativeOfItsEnergyAndTheTangentThatOfTheForce) {
  for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar}) {
    ContactSettings s = exponential(100, 0.02);
    s.method = method;
    Rig rig(PETSC_COMM_WORLD, hill(), bodies_mixed, s);
    const Handle<Vec> u = rig.at(crush);
    rig.contact.update_search(u);
    expect_force_of_the_energy(rig, u);
    consistent_tangent(rig, u);
    EXPECT_TRUE(rig.contact.review(u).converged);
  }
}

// Impulse on the upper one of two bodies that meet, over a few steps of a whole run.
double impulse_of(const std::string& mesh, const ContactSettings& asked) {
  OptionsScope scope({{"-mesh", mesh},
                      {"-materials", "soft"},
                      {"-material_soft_region", "lower,upper"},
                      {"-material_soft_E", "1e3"},
                      {"-material_soft_nu", "0.3"},
                      {"-material_soft_rho", "1"},
                      {"-ics", "flight"},
                      {"-ic_flight_on", "upper"},
                      {"-ic_flight_vy", "-1"},
                      {"-contacts", "pair"},
                      {"-contact_pair_secondary", "upper_bottom"},
                      {"-contact_pair_primary", "lower top"},
                      {"-contact_pair_enforce", "penalty"},
                      {"-contact_pair_penalty", "1e3"},
                      {"-output_dir", run_test::fresh_dir("own_enforcement_out")},
                      {"-checkpoint_wall", "0"},
                      {"-ts_dt", "1e-3"},
                      {"-ts_max_time", "4e-3"}});
  Scenario scenario = read_scenario(PETSC_COMM_WORLD);
  scenario.contacts[0].own_enforcement = asked.own_enforcement;
  double impulse = 0;
  StepProbe probe;
  probe.after = [&](const Attempt&, long, StateTable& state) {
    impulse = state.row("contact_pair_totals").committed[1];
  };
  EXPECT_EQ(simulate(PETSC_COMM_WORLD, scenario, probe), ExitCode::ok);
  return impulse;
}

TEST(OwnEnforcement, RunsSteps) {
  const std::string mesh = run_test::fresh_dir("own_enforcement") + "/mesh.msh";
  on_rank_zero(PETSC_COMM_WORLD, [&] { std::ofstream(mesh) << run_test::two_bodies(4); });
  const double linear = impulse_of(mesh, {}), stiff = impulse_of(mesh, exponential(1e3, 1e-3)),
               nearly_linear = impulse_of(mesh, exponential(1e3, 1e6));
  EXPECT_GT(linear, 0);
  EXPECT_GT(stiff, 1.01 * linear);
  EXPECT_NEAR(nearly_linear, linear, 1e-8 * linear);
}

} // namespace
} // namespace impact::contact_test
