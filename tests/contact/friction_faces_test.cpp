#include "no_friction.hpp"
#include "two_bricks.hpp"

using namespace impact;
using namespace impact::contact_test;

namespace {

// From `crush_bricks` on the upper brick slides, turns and stretches along the surface, so that some nodes
// stick and others slide, each in its own direction.
BrickMotion slide(double by) {
  return [by](int body, const Vector& X) {
    Vector u = crush_bricks(body, X);
    if (body == 1) {
      u[0] += by * (X[0] - 0.5) - 0.5 * by * (X[1] - 0.45);
      u[1] += 0.6 * by * (X[0] - 0.45) + 0.3 * by * X[1] * X[0];
      u[2] += 0.02 * by * X[0];
    }
    return u;
  };
}

struct Case {
  TwoBricks bricks;
  ContactSettings settings;
};

std::vector<Case> cases(double angle = 0) {
  std::vector<Case> all;
  for (const Enforcement enforce : {Enforcement::penalty, Enforcement::auglag})
    for (const auto& [lower, upper, space] : {std::tuple{false, false, MultiplierSpace::standard},
                                              {false, true, MultiplierSpace::dual},
                                              {true, false, MultiplierSpace::dual},
                                              {true, true, MultiplierSpace::standard}}) {
      ContactSettings s = brick_settings(space);
      s.enforce = enforce;
      s.friction = 0.4;
      all.push_back({{lower, upper, angle, true}, s});
      if (lower == upper) continue;
      s.method = ContactMethod::gauss_points;
      s.multipliers = MultiplierSpace::automatic;
      all.push_back({{lower, upper, angle, true}, s});
    }
  return all;
}

std::vector<Case> on_rigid(const char* shape) {
  std::vector<Case> all = cases();
  for (Case& c : all) {
    c.settings.primary = shape;
    c.settings.axis[0] = 0.3;
    c.settings.axis[1] = 1;
    c.settings.axis[2] = 0;
    c.settings.centre[0] = 0.5;
    c.settings.centre[1] = 0.45;
    c.settings.centre[2] = -2;
    c.settings.radius = 1.99;
    c.settings.plane_point[2] = 0.04;
    c.settings.plane_normal[0] = 0.1;
    c.settings.plane_normal[1] = 0.05;
    c.settings.plane_normal[2] = 1;
  }
  return all;
}

double norm(Vec v) {
  double n = 0;
  check(VecNorm(v, NORM_2, &n));
  return n;
}

std::string dir_of(const char* name) { return run_test::fresh_dir(std::string("friction_faces_") + name); }

// In sliding contact at `slide`, from `crush_bricks` with the tractions of a step before.
struct Sliding : BrickRig {
  Handle<Vec> u;
  Sliding(MPI_Comm comm, const std::string& dir, const Case& c)
      : BrickRig(comm, dir, c.bricks, c.settings), u(at(slide(0.15))) {
    step(at(crush_bricks), c.settings);
    step(at(slide(0.02)), c.settings);
    contact.update_search(u);
  }
  void step(const Handle<Vec>& end, const ContactSettings& s) {
    contact.set_time(1);
    contact.update_search(end);
    if (s.enforce == Enforcement::auglag) contact.augment(end);
    contact.advance(end, end, 0);
    state.commit();
  }
  // Nodes that press, nodes that slide.
  std::array<int, 2> counts() const {
    std::array<int, 2> count{};
    const ContactFields fields = contact.nodal_fields(u);
    for (int n = 0; n < mesh.node_count(); ++n)
      if (mesh.owned(n) && fields.status[static_cast<std::size_t>(n)] > 0)
        ++count[fields.status[static_cast<std::size_t>(n)] == 2 ? 1 : 0];
    MPI_Allreduce(MPI_IN_PLACE, count.data(), 2, MPI_INT, MPI_SUM, mesh.comm());
    return count;
  }
};

void expect_consistent_tangent(const Sliding& rig) {
  Handle<Mat> K;
  const PetscInt n = 3 * rig.mesh.owned_node_count();
  check(MatCreateAIJ(PETSC_COMM_WORLD, n, n, PETSC_DETERMINE, PETSC_DETERMINE, 150, nullptr, 150, nullptr,
                     K.out()));
  check(MatSetOption(K, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  rig.contact.add_tangent(rig.u, 1.5, K);
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  PetscBool symmetric = PETSC_TRUE;
  check(MatIsTranspose(K, K, 1e-3, &symmetric));
  EXPECT_FALSE(symmetric) << rig.contact.settings().primary; // some nodes slide
  const Handle<Vec> d = rig.at(wiggle_bricks), assembled = rig.layout.make_global(),
                    free = rig.layout.make_global(), up = rig.layout.make_global(),
                    down = rig.layout.make_global();
  check(MatMult(K, d, assembled));
  rig.contact.multiply(rig.u, 1.5, d, free);
  const double size = norm(assembled), h = 1e-7;
  EXPECT_GT(size, 1);
  check(VecAXPY(free, -1, assembled));
  EXPECT_LE(norm(free), 1e-13 * size);
  check(VecWAXPY(up, h, d, rig.u));
  check(VecWAXPY(down, -h, d, rig.u));
  const Handle<Vec> difference = rig.residual(up, 1.5), lower = rig.residual(down, 1.5);
  check(VecAXPY(difference, -1, lower));
  check(VecScale(difference, 1 / (2 * h)));
  check(VecAXPY(difference, -1, assembled));
  EXPECT_LE(norm(difference), 1e-6 * size);
}

} // namespace

TEST(FrictionFaces, TangentIsTheDerivativeOfTheResidual) {
  const std::string dir = dir_of("tangent");
  for (const std::vector<Case>& all :
       {cases(), on_rigid("plane"), on_rigid("rigid_cylinder"), on_rigid("rigid_sphere")})
    for (const Case& c : all) expect_consistent_tangent(Sliding(PETSC_COMM_WORLD, dir, c));
}

TEST(FrictionFaces, SomeNodesStickAndOthersSlide) {
  const std::string dir = dir_of("status");
  for (const Case& c : cases()) {
    Sliding rig(PETSC_COMM_WORLD, dir, c);
    rig.contact.advance(rig.u, rig.u, 0);
    const auto [stick, slid] = rig.counts();
    EXPECT_GT(stick, 0);
    EXPECT_GT(slid, 2);
  }
}

TEST(FrictionFaces, ForcesAndMomentsOfBothBodiesCancelAndSlidingDissipates) {
  const std::string dir = dir_of("balance");
  for (const Case& c : cases(0.4)) {
    Sliding rig(PETSC_COMM_WORLD, dir, c);
    const ForceSums sums = sum_forces(rig, rig.residual(rig.u), rig.u);
    sums.expect_balance();
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(rig.contact.measures(rig.u).force[k], sums.on_upper[k], 1e-12 * sums.absolute);
    EXPECT_GT(rig.contact.step(rig.u).friction_loss, 1e-4);
  }
}

TEST(FrictionFaces, ForceAndStateDoNotDependOnThePartition) {
  const std::string dir = dir_of("partition");
  for (const Case& c : cases(0.4)) {
    Sliding rig(PETSC_COMM_WORLD, dir, c);
    const auto force = rig.by_place(rig.residual(rig.u, 2.5));
    const double lost = rig.contact.step(rig.u).friction_loss;
    const std::array<int, 2> counts = rig.counts();
    if (run_test::rank_of(PETSC_COMM_WORLD) == 0) {
      Sliding alone(MPI_COMM_SELF, dir, c);
      const auto reference = alone.by_place(alone.residual(alone.u, 2.5));
      for (const auto& [place, f] : force)
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(f[k], reference.at(place)[k], 1e-12);
      EXPECT_NEAR(lost, alone.contact.step(alone.u).friction_loss, 1e-13);
      EXPECT_EQ(counts, alone.counts());
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST(FrictionFaces, ARigidTurnOfAStickingPairDoesNotSlipAndTurnsTheForce) {
  // Both bricks, pressed and dragged within the limit, turn together in steps about an axis of no edge.
  const std::string dir = dir_of("turn");
  for (Case c : cases()) {
    c.settings.friction = 5;
    Sliding rig(PETSC_COMM_WORLD, dir, c);
    const auto at_angle = [&](double angle) {
      return rig.at([angle](int body, const Vector& X) {
        const Vector u = slide(0.15)(body, X);
        const Vector x = turned(angle, {X[0] + u[0], X[1] + u[1], X[2] + u[2]});
        return Vector{x[0] - X[0], x[1] - X[1], x[2] - X[2]};
      });
    };
    rig.step(at_angle(0), c.settings);
    const auto before = rig.by_place(rig.residual(at_angle(0)));
    const auto tangential = rig.contact.measures(rig.u).force;
    EXPECT_GT(std::hypot(tangential[0], tangential[1]), 0.05);
    for (const double angle : {0.3, 0.9, 1.7, 2.2}) {
      const Handle<Vec> u = at_angle(angle);
      rig.contact.set_time(1);
      rig.contact.update_search(u);
      EXPECT_NEAR(rig.contact.step(u).friction_loss, 0, 1e-14);
      for (const auto& [place, f] : rig.by_place(rig.residual(u))) {
        if (before.count(place) == 0) continue;
        const Vector expected = turned(angle, before.at(place));
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(f[k], expected[k], 1e-11);
      }
      rig.contact.advance(u, u, 0);
      rig.state.commit();
    }
  }
}

TEST(FrictionFaces, FieldsShowCoulombsLawOppositeToTheSlip) {
  const std::string dir = dir_of("fields");
  for (const Case& c : cases()) {
    Sliding rig(PETSC_COMM_WORLD, dir, c);
    rig.contact.advance(rig.u, rig.u, 0);
    const ContactFields fields = rig.contact.nodal_fields(rig.u);
    int slid = 0;
    for (std::size_t n = 0; n < fields.status.size(); ++n) {
      double t = 0, s = 0, both = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        t += fields.traction[3 * n + k] * fields.traction[3 * n + k];
        s += fields.slip[3 * n + k] * fields.slip[3 * n + k];
        both += fields.traction[3 * n + k] * fields.slip[3 * n + k];
      }
      if (fields.status[n] == 0) {
        EXPECT_EQ(t, 0);
        EXPECT_EQ(s, 0);
      }
      if (fields.status[n] != 2 || s < 1e-6) continue;
      ++slid;
      EXPECT_LT(both, 0);
      EXPECT_LE(std::sqrt(t),
                0.4 * fields.pressure[n] * 1.06); // faces at an angle press with more than the pressure
    }
    MPI_Allreduce(MPI_IN_PLACE, &slid, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_GT(slid, 2);
  }
}

TEST(FrictionFaces, NoneIsLeftWithACoefficientOfZeroOrWhileSuspended) {
  const std::string dir = dir_of("zero");
  for (const std::vector<Case>& all : {cases(), on_rigid("plane"), on_rigid("rigid_sphere")})
    for (Case c : all) {
      Sliding rough(PETSC_COMM_WORLD, dir, c);
      c.settings.friction = 0;
      Sliding smooth(PETSC_COMM_WORLD, dir, c);
      expect_friction_only_in(rough, smooth, [](Vec v) { return norm(v); });
    }
}
