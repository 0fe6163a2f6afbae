#include "contact_rig.hpp"

using namespace impact;
using namespace impact::contact_test;

namespace {

std::vector<ContactSettings> mortars(Enforcement enforce = Enforcement::auglag) {
  std::vector<ContactSettings> all;
  for (const MultiplierSpace space : {MultiplierSpace::standard, MultiplierSpace::dual}) {
    ContactSettings s = settings_of(100);
    s.method = ContactMethod::mortar;
    s.multipliers = space;
    s.enforce = enforce;
    all.push_back(s);
  }
  return all;
}

} // namespace

TEST(MortarForm, ForceAndMeasuresDoNotDependOnThePartition) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : mortars()) {
      TwoBlocks b = hill();
      b.angle = 0.3;
      std::vector<NodeValues> forces;
      std::vector<ContactMeasures> measured;
      for (MPI_Comm comm : {MPI_COMM_SELF, PETSC_COMM_WORLD}) {
        Rig rig(comm, b, partition, s);
        const Handle<Vec> u = rig.at(crush);
        rig.contact.update_search(u);
        rig.contact.augment(u);
        forces.push_back(node_map(rig.mesh, rig.layout, rig.residual(u, 2.5)));
        measured.push_back(rig.contact.measures(u));
        EXPECT_GT(norm(rig.residual(u)), 0.1);
      }
      EXPECT_LE(largest_difference(forces[0], forces[1]), 1e-12) << name;
      EXPECT_EQ(measured[0].active, measured[1].active) << name;
      EXPECT_GE(measured[0].active, 3) << name;
      EXPECT_NEAR(measured[0].energy, measured[1].energy, 1e-12);
      EXPECT_NEAR(measured[0].gap_min, measured[1].gap_min, 1e-13);
      EXPECT_NEAR(measured[0].pressure_max, measured[1].pressure_max, 1e-11);
      EXPECT_NEAR(measured[0].length, measured[1].length, 1e-12);
    }
}

// Nodes whose facets face something in part alone know how far that is.
TEST(MortarForm, TheGapOfAnOverhangIsTheDistance) {
  for (const ContactSettings& s : mortars()) {
    TwoBlocks b;
    b.gap = 0;
    Rig rig(PETSC_COMM_WORLD, b, bodies_apart, s);
    const Handle<Vec> u = rig.at([](int body, double, double) {
      return std::array<double, 2>{body == 1 ? 0.837 : 0, body == 1 ? 0.05 : 0};
    });
    rig.contact.update_search(u);
    EXPECT_NEAR(rig.contact.measures(u).gap_min, 0.05, 1e-12);
    const ContactFields fields = rig.contact.nodal_fields(u);
    int near = 0;
    for (const double gap : fields.gap)
      if (!std::isnan(gap)) {
        EXPECT_NEAR(gap, 0.05, 1e-12);
        ++near;
      }
    MPI_Allreduce(MPI_IN_PLACE, &near, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_GE(near, 3);
  }
}

TEST(MortarForm, ForcesAndMomentsOfBothBodiesCancel) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : mortars()) {
      Rig rig(PETSC_COMM_WORLD, hill(), partition, s);
      const Handle<Vec> u = rig.at(crush);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      const auto [sum, upper, moment, size] = resultants(rig, u);
      ASSERT_GT(size, 1) << name;
      EXPECT_LE(std::abs(sum[0]) + std::abs(sum[1]), 1e-13 * size) << name;
      EXPECT_LE(std::abs(moment), 1e-13 * size) << name;
      const ContactMeasures m = rig.contact.measures(u);
      EXPECT_NEAR(m.force[1], upper[1], 1e-12 * size);
      EXPECT_GT(m.force[1], 0.1); // the upper body is pushed up
    }
}

TEST(MortarForm, TangentIsTheDerivativeOfTheResidualAndEqualsTheMatrixFreeProduct) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : mortars()) {
      Rig rig(PETSC_COMM_WORLD, hill(), partition, s);
      const Handle<Vec> u = rig.at(crush);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      SCOPED_TRACE(name);
      const Handle<Mat> K = consistent_tangent(rig, u);
      PetscBool symmetric = PETSC_FALSE;
      check(MatIsTranspose(K, K, 1e-10, &symmetric));
      EXPECT_TRUE(symmetric);
    }
}

TEST(MortarForm, ResidualIsTheDerivativeOfTheEnergy) {
  for (const ContactSettings& s : mortars()) {
    Rig rig(PETSC_COMM_WORLD, hill(), bodies_mixed, s);
    const Handle<Vec> u = rig.at(crush);
    rig.contact.update_search(u);
    rig.contact.augment(u);
    expect_force_of_the_energy(rig, u);
  }
}

TEST(MortarForm, AUniformPenetrationGivesUniformMultipliersAndForcesOfAUniformPressure) {
  // The upper block covers its whole lower side: int N_b over an edge is half its length, on any mesh of the
  // other side.
  for (ContactSettings s : mortars()) {
    // A gap adds the moment of the pressure over it, so it is a small one here.
    const double depth = 1e-10;
    s.penalty = s.penalty_max = 1 / depth;
    Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s);
    const Handle<Vec> u = rig.at(sink(depth));
    rig.contact.update_search(u);
    const NodeValues force = node_map(rig.mesh, rig.layout, rig.residual(u));
    const double pressure = 1, edge = (rig.blocks.upper_right - rig.blocks.upper_left) / 5;
    for (const auto& [key, f] : force) {
      if (key[0] < 0.5 || key[2] > 1e-9) continue;
      const bool corner = std::min(key[1] - rig.blocks.upper_left, rig.blocks.upper_right - key[1]) < 1e-9;
      EXPECT_NEAR(-f[1], pressure * edge * (corner ? 0.5 : 1), 2e-6);
    }
    const ContactMeasures m = rig.contact.measures(u);
    EXPECT_NEAR(m.pressure_min, pressure, 2e-6); // rounding of the coordinates over the depth
    EXPECT_NEAR(m.pressure_max, pressure, 2e-6);
    EXPECT_NEAR(m.length, 5 * edge, 1e-9);
  }
}

TEST(MortarForm, AStepBehindTheOtherSurfaceDoesNotCountAsAGap) {
  // A facet that hangs half over the end of the primary surface carries what the covered half does.
  TwoBlocks b;
  b.upper_left = 1.5;
  b.upper_right = 2.7;
  b.upper_cells = 2;
  ContactSettings s = mortars()[0];
  Rig rig(PETSC_COMM_WORLD, b, bodies_mixed, s);
  const Handle<Vec> u = rig.at(sink(0.01));
  rig.contact.update_search(u);
  // Covered: 0.6 of 1.2, one edge of two.
  const ContactMeasures m = rig.contact.measures(u);
  EXPECT_EQ(m.active, 2);
  // Node 0: int over its edge of N = 0.3 = w. Node 1: covered 0.3 of 0.6, so half the mean gap over that
  // half.
  EXPECT_NEAR(m.force[1], 100 * 0.01 * (0.3 + 0.5 * 0.3), 1e-12);
}

TEST(SemismoothContact, StepsOfTheLinearisedSystemCloseTheGapAndKeepWhatPresses) {
  for (ContactSettings s : mortars(Enforcement::semismooth)) {
    Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s);
    const Handle<Vec> u = rig.at(sink(0.01)), back = rig.at(sink(0)), step = rig.layout.make_global();
    rig.contact.update_search(u);
    EXPECT_FALSE(rig.contact.gaps_left(u).closed);
    // A full step that closes the gap exactly leaves the multipliers where they were: at zero.
    check(VecWAXPY(step, -1, u, back));
    EXPECT_TRUE(rig.contact.after_newton_step(u, step, back, false).other);
    EXPECT_NEAR(rig.contact.measures(back).pressure_max, 0, 1e-9);
    EXPECT_TRUE(rig.contact.gaps_left(back).closed);
    // One that leaves a part of it raises them by gamma times that part.
    const Handle<Vec> above = rig.at(sink(1e-6));
    EXPECT_FALSE(rig.contact.gaps_left(above).closed);
    check(VecWAXPY(step, -1, u, above));
    rig.contact.after_newton_step(u, step, above, false);
    EXPECT_NEAR(rig.contact.measures(above).pressure_min, 1e5 * 1e-6, 1e-6);
    EXPECT_NEAR(rig.contact.measures(above).pressure_max, 1e5 * 1e-6, 1e-6);
  }
}

TEST(SemismoothContact, TouchingSurfacesTakePartInTheFirstIteration) {
  for (const ContactSettings& s : mortars(Enforcement::semismooth)) {
    Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s);
    const Handle<Vec> u = rig.at(rest);
    rig.contact.update_search(u);
    EXPECT_EQ(rig.contact.measures(u).active, 0);
    rig.contact.start_newton(u);
    EXPECT_EQ(rig.contact.measures(u).active, 6);
    const Handle<Vec> apart = rig.at(sink(-0.01));
    rig.contact.update_search(apart);
    rig.contact.start_newton(apart);
    EXPECT_EQ(rig.contact.measures(apart).active, 0);
  }
}
