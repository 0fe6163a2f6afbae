#include "../material/rational_degradation.hpp"
#include "../material/swift_hardening.hpp"
#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"
#include <impact/petsc/ranks.hpp>

// A hardening and a degradation that the program does not have, one file each, carry a step; and what the
// program has gives the same when it comes by the way of laws from outside.

namespace impact {
namespace {

using problem_test::condition;
using problem_test::MotionCase;

/// Displacements of a square that is sheared and stretched in two steps.
MotionCase pulled(const MaterialParameters& law) {
  std::vector<problem_test::Field> pull = {
      [](const double* x, double t) { return t * (0.01 * x[1] + 0.004 * x[0] * x[0]); },
      [](const double* x, double t) { return t * (0.006 * x[1] * x[0] + 0.002 * x[0]); }};
  problem_test::CaseSettings settings;
  settings.dt = 0.5;
  settings.initial_phi = [](const double*, double) { return 0.0; };
  return {run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("own_laws"),
                            run_test::box_mesh(Shape::quad4, 3)),
          law,
          {condition("held", "boundary", BcType::displacement, pull)},
          settings};
}

MaterialParameters plastic() {
  MaterialParameters law;
  law.model = Model::j2;
  law.K = 70e9;
  law.G = 27e9;
  law.sigma_y = 3e8;
  law.power_b = 4e8;
  law.power_n = 0.3;
  return law;
}

MaterialParameters brittle() {
  MaterialParameters law;
  law.K = 70e9;
  law.G = 27e9;
  law.damage = Damage::at2;
  law.Gc = 2e4;
  law.gamma = 0.2;
  return law;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return max_over_ranks(PETSC_COMM_WORLD, largest);
}

TEST(OwnLaws, AHardeningOfTheListIsTheSameFromOutside) {
  MaterialParameters law = plastic();
  law.hardening = HardeningKind::power;
  MotionCase ours = pulled(law);
  ours.run();
  law.hardening = HardeningKind::own;
  law.own_hardening = &hardening_functions<PowerHardening>;
  MotionCase own = pulled(law);
  own.run();
  EXPECT_LT(difference(ours.u(), own.u()), 1e-15);
}

TEST(OwnLaws, AHardeningFromOutsideCarriesAStep) {
  MaterialParameters law = plastic();
  law.hardening = HardeningKind::own;
  law.own_hardening = &hardening_functions<SwiftHardening>;
  MotionCase run = pulled(law);
  run.run();
  const Discretisation& d = run.discretisation();
  EXPECT_GT(max_over_ranks(PETSC_COMM_WORLD, largest_alpha(d.frame, run.scalar("history"))), 1e-3);
  ASSERT_EQ(run.iterations.size(), 2u) << "no step may be cut";
  EXPECT_LE(run.iterations[1], 8);
}

TEST(OwnLaws, ADegradationOfTheListIsTheSameFromOutside) {
  MaterialParameters law = brittle();
  MotionCase ours = pulled(law);
  ours.run();
  law.ge = Degradation::own;
  law.own_degradation = &degradation_functions<QuadraticDegradation>;
  MotionCase own = pulled(law);
  own.run();
  EXPECT_LT(difference(ours.scalar("phi"), own.scalar("phi")), 1e-13);
  EXPECT_LT(difference(ours.u(), own.u()), 1e-13);
}

TEST(OwnLaws, ADegradationFromOutsideCarriesAStep) {
  MaterialParameters law = brittle();
  law.ge = Degradation::own;
  law.own_degradation = &degradation_functions<RationalDegradation>;
  EXPECT_FALSE(is_convex(law)); // so that the damage solve keeps to its bounds
  MotionCase run = pulled(law);
  run.run();
  const std::vector<double>& phi = run.scalar("phi");
  const double largest =
      max_over_ranks(PETSC_COMM_WORLD, phi.empty() ? 0 : *std::max_element(phi.begin(), phi.end()));
  EXPECT_GT(largest, 0.05);
  EXPECT_LT(largest, 1);
}

} // namespace
} // namespace impact
