#include "two_bricks.hpp"

using namespace impact;
using namespace impact::contact_test;

namespace {

struct Case {
  TwoBricks bricks;
  ContactSettings settings;
};

std::vector<Case> cases(bool hill, double angle = 0) {
  return {{{false, false, angle, hill}, brick_settings()},
          {{false, true, angle, hill}, brick_settings(MultiplierSpace::dual)},
          {{true, false, angle, hill}, brick_settings(MultiplierSpace::dual)},
          {{true, true, angle, hill}, brick_settings()},
          {{false, true, angle, hill}, brick_points()},
          {{true, false, angle, hill}, brick_points()},
          {{true, true, angle, hill, false, 2}, brick_points()}};
}

double norm(Vec v) {
  double n = 0;
  check(VecNorm(v, NORM_2, &n));
  return n;
}

std::string dir_of(const char* name) { return run_test::fresh_dir(std::string("face_contact_") + name); }

} // namespace

TEST(FaceContact, ForceAndMeasuresDoNotDependOnThePartition) {
  const std::string dir = dir_of("partition");
  for (const Case& c : cases(true, 0.4)) {
    BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
    const Handle<Vec> u = rig.at(crush_bricks);
    rig.contact.update_search(u);
    rig.contact.augment(u);
    const auto force = rig.by_place(rig.residual(u, 2.5));
    const ContactMeasures m = rig.contact.measures(u);
    EXPECT_GE(m.active, 9);
    if (run_test::rank_of(PETSC_COMM_WORLD) == 0) {
      BrickRig alone(MPI_COMM_SELF, dir, c.bricks, c.settings);
      const Handle<Vec> v = alone.at(crush_bricks);
      alone.contact.update_search(v);
      alone.contact.augment(v);
      const auto reference = alone.by_place(alone.residual(v, 2.5));
      const ContactMeasures r = alone.contact.measures(v);
      for (const auto& [place, f] : force)
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(f[k], reference.at(place)[k], 1e-12);
      EXPECT_EQ(m.active, r.active);
      EXPECT_NEAR(m.energy, r.energy, 1e-12);
      EXPECT_NEAR(m.gap_min, r.gap_min, 1e-13);
      EXPECT_NEAR(m.pressure_max, r.pressure_max, 1e-11);
      EXPECT_NEAR(m.length, r.length, 1e-12);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST(FaceContact, TurningTheWholeProblemTurnsTheForces) {
  const std::string dir = dir_of("turned");
  for (const double angle : {0.7, 2.1, 4.4}) {
    const std::vector<Case> straight = cases(true), turned = cases(true, angle);
    for (std::size_t i = 0; i < straight.size(); ++i) {
      std::vector<std::map<std::array<long, 4>, Vector>> force;
      std::vector<ContactMeasures> measured;
      for (const Case& c : {straight[i], turned[i]}) {
        BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
        const Handle<Vec> u = rig.at(crush_bricks);
        rig.contact.update_search(u);
        force.push_back(rig.by_place(rig.residual(u)));
        measured.push_back(rig.contact.measures(u));
      }
      EXPECT_EQ(measured[0].active, measured[1].active);
      EXPECT_NEAR(measured[0].gap_min, measured[1].gap_min, 1e-10);
      EXPECT_NEAR(measured[0].energy, measured[1].energy, 1e-10);
      for (const auto& [place, f] : force[1]) {
        if (force[0].count(place) == 0) continue; // on this rank in one of the two partitions alone
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(f[k], force[0].at(place)[k], 1e-10);
      }
    }
  }
}

TEST(FaceContact, ForcesAndMomentsOfBothBodiesCancel) {
  const std::string dir = dir_of("balance");
  for (const Case& c : cases(true)) {
    BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
    const Handle<Vec> u = rig.at(crush_bricks);
    rig.contact.update_search(u);
    rig.contact.augment(u);
    const ForceSums sums = sum_forces(rig, rig.residual(u), u);
    sums.expect_balance();
    EXPECT_GT(sums.on_upper[2], 0.1); // the upper body is pushed up
    EXPECT_NEAR(rig.contact.measures(u).force[2], sums.on_upper[2], 1e-12 * sums.absolute);
  }
}

TEST(FaceContact, TangentIsTheDerivativeOfTheResidualAndEqualsTheMatrixFreeProduct) {
  const std::string dir = dir_of("tangent");
  for (const Case& c : cases(true)) {
    BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
    const Handle<Vec> u = rig.at(crush_bricks), d = rig.at(wiggle_bricks);
    rig.contact.update_search(u);
    rig.contact.augment(u);
    Handle<Mat> K;
    const PetscInt n = 3 * rig.mesh.owned_node_count();
    check(MatCreateAIJ(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 150, nullptr, 150, nullptr,
                       K.out()));
    check(MatSetOption(K, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
    rig.contact.add_tangent(u, 1.5, K);
    check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
    PetscBool symmetric = PETSC_FALSE;
    check(MatIsTranspose(K, K, 1e-10, &symmetric));
    EXPECT_TRUE(symmetric);
    const Handle<Vec> assembled = rig.layout.make_global(), free = rig.layout.make_global(),
                      up = rig.layout.make_global(), down = rig.layout.make_global();
    check(MatMult(K, d, assembled));
    rig.contact.multiply(u, 1.5, d, free);
    const double size = norm(assembled), h = 1e-7;
    EXPECT_GT(size, 1);
    check(VecAXPY(free, -1, assembled));
    EXPECT_LE(norm(free), 1e-13 * size);
    check(VecWAXPY(up, h, d, u));
    check(VecWAXPY(down, -h, d, u));
    const Handle<Vec> difference = rig.residual(up, 1.5), lower = rig.residual(down, 1.5);
    check(VecAXPY(difference, -1, lower));
    check(VecScale(difference, 1 / (2 * h)));
    check(VecAXPY(difference, -1, assembled));
    EXPECT_LE(norm(difference), 1e-6 * size);
    // And the residual is the derivative of the energy.
    check(VecWAXPY(up, 1e-6, d, u));
    check(VecWAXPY(down, -1e-6, d, u));
    const double slope = (rig.contact.measures(up).energy - rig.contact.measures(down).energy) / 2e-6;
    double expected = 0;
    check(VecDot(rig.residual(u), d, &expected));
    EXPECT_GT(std::abs(expected), 0.1);
    EXPECT_NEAR(slope, expected, 1e-6 * std::abs(expected));
  }
}

TEST(FaceContact, RigidBodiesPushAlongTheirNormalsWithTheirExactTangent) {
  const std::string dir = dir_of("rigid");
  for (const char* shape : {"plane", "rigid_cylinder", "rigid_sphere"})
    for (Case c : cases(true)) {
      c.settings.primary = shape;
      c.settings.plane_normal[1] = 0.1;
      c.settings.plane_normal[2] = 1;
      c.settings.axis[0] = 0.3;
      c.settings.axis[1] = 1;
      c.settings.axis[2] = 0.1;
      c.settings.centre[0] = 0.5;
      c.settings.centre[2] = -2;
      c.settings.radius = 1.99;
      BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
      const Handle<Vec> u = rig.at(crush_bricks), d = rig.at(wiggle_bricks), up = rig.layout.make_global(),
                        down = rig.layout.make_global(), product = rig.layout.make_global();
      rig.contact.set_time(1);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      EXPECT_GT(rig.contact.measures(u).force[2], 0.05) << shape;
      rig.contact.multiply(u, 1, d, product);
      const double h = 1e-7;
      check(VecWAXPY(up, h, d, u));
      check(VecWAXPY(down, -h, d, u));
      const Handle<Vec> difference = rig.residual(up), lower = rig.residual(down);
      check(VecAXPY(difference, -1, lower));
      check(VecScale(difference, 1 / (2 * h)));
      check(VecAXPY(difference, -1, product));
      EXPECT_LE(norm(difference), 1e-6 * norm(product)) << shape;
      EXPECT_GT(norm(product), 0.5) << shape;
    }
}

TEST(FaceContact, AUniformPenetrationGivesTheForcesOfAUniformPressure) {
  const std::string dir = dir_of("uniform");
  for (Case c : cases(false)) {
    // A gap adds the moment of the pressure over it, so it is a small one here.
    const double depth = 1e-9;
    c.settings.penalty = c.settings.penalty_max = 1 / depth;
    BrickRig rig(PETSC_COMM_WORLD, dir, c.bricks, c.settings);
    const Handle<Vec> u = rig.at([&](int body, const Vector&) {
      return Vector{0, 0, body == 1 ? -depth : 0};
    });
    rig.contact.update_search(u);
    const ContactMeasures m = rig.contact.measures(u);
    const bool points = c.settings.method == ContactMethod::gauss_points;
    EXPECT_EQ(m.active, !points ? 16 : c.bricks.upper_tets ? 3 * 18 : 4 * 9);
    EXPECT_NEAR(m.pressure_min, 1, 1e-6); // rounding of the coordinates over the depth
    EXPECT_NEAR(m.pressure_max, 1, 1e-6);
    EXPECT_NEAR(m.length, 0.49, 1e-9);
    EXPECT_NEAR(m.force[2], 0.49, 1e-6);
    if (c.bricks.upper_tets) continue;
    // A corner of the surface carries a quarter of a cell, a side half of one.
    const double cell = 0.49 / 9;
    for (const auto& [place, f] : rig.by_place(rig.residual(u))) {
      if (place[0] == 0 || place[3] != 0) continue;
      const auto inner = [](long x) { return x == 130000 || x == 830000 ? 0.5 : 1.0; };
      EXPECT_NEAR(-f[2], cell * inner(place[1]) * inner(place[2]), 1e-6);
    }
  }
}

TEST(FaceContact, TheFarSideOfAThinPrimaryDoesNotCount) {
  // The lower brick's own bottom looks the same way as the surface that it would meet.
  const std::string dir = dir_of("far_side");
  ContactSettings s = brick_settings();
  s.search_radius = 2;
  BrickRig rig(PETSC_COMM_WORLD, dir, {}, s);
  const Handle<Vec> through = rig.at([](int body, const Vector&) {
    return Vector{0, 0, body == 1 ? -0.3 : 0};
  });
  rig.contact.update_search(through);
  EXPECT_NEAR(rig.contact.measures(through).gap_min, -0.3, 1e-12);
  const Handle<Vec> above = rig.at([](int body, const Vector&) { return Vector{0, 0, body == 1 ? 1.0 : 0}; });
  rig.contact.update_search(above);
  EXPECT_TRUE(std::isnan(rig.contact.measures(above).gap_min));
}
