#include "contact_rig.hpp"
#include "no_friction.hpp"

using namespace impact;
using namespace impact::contact_test;

namespace {

// The bodies press into each other where they were, and slide with a difference along the surface, so that
// some constraints stick and others slide.
Motion slide(double by) {
  return [by](int body, double X, double Y) {
    std::array<double, 2> u = crush(body, X, Y);
    if (body == 1) {
      u[0] += by * (X - 0.9);
      u[1] += 0.01 * by * X;
    }
    return u;
  };
}

std::vector<ContactSettings> frictional() {
  std::vector<ContactSettings> all;
  for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar})
    for (const Enforcement enforce : {Enforcement::penalty, Enforcement::auglag}) {
      ContactSettings s = settings_of(100);
      s.method = method;
      s.enforce = enforce;
      s.friction = 0.4;
      all.push_back(s);
    }
  return all;
}

// In sliding contact at `slide`, from `crush`.
struct Sliding : Rig {
  Handle<Vec> u;
  Sliding(const ContactSettings& s, const Partition& partition, MPI_Comm comm = PETSC_COMM_WORLD)
      : Rig(comm, hill(), partition, s), u(at(slide(0.15))) {
    const Handle<Vec> start = at(crush), again = at(crush);
    contact.update_search(start);
    if (s.enforce == Enforcement::auglag) contact.augment(start);
    contact.advance(start, again, 0);
    state.commit();
    contact.update_search(u);
  }
};

} // namespace

TEST(Friction, TangentIsTheDerivativeOfTheResidualAndIsNotSymmetric) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : frictional()) {
      Sliding rig(s, partition);
      SCOPED_TRACE(name);
      const Handle<Mat> K = consistent_tangent(rig, rig.u);
      PetscBool symmetric = PETSC_TRUE;
      check(MatIsTranspose(K, K, 1e-3, &symmetric));
      EXPECT_FALSE(symmetric); // some constraints slide
    }
}

TEST(Friction, OfMortarOnRigidBodiesHasItsExactTangent) {
  for (const char* shape : {"plane", "rigid_cylinder"})
    for (ContactSettings s : frictional()) {
      if (s.method != ContactMethod::mortar) continue;
      s.primary = shape;
      s.plane_normal[0] = 0.02;
      s.plane_point[1] = 0.01;
      s.centre[0] = 0.9;
      s.centre[1] = -2;
      s.radius = 2;
      Sliding rig(s, bodies_mixed);
      const Handle<Mat> K = consistent_tangent(rig, rig.u);
      PetscBool symmetric = PETSC_TRUE;
      check(MatIsTranspose(K, K, 1e-3, &symmetric));
      EXPECT_FALSE(symmetric) << shape;
      EXPECT_GT(rig.contact.friction_loss(rig.u), 1e-4) << shape;
    }
}

TEST(Friction, FieldsObeyCoulombsLaw) {
  for (const ContactSettings& s : frictional()) {
    Sliding rig(s, bodies_mixed);
    rig.contact.advance(rig.u, rig.u, 0);
    const ContactFields fields = rig.contact.nodal_fields(rig.u);
    std::array<int, 2> count{}; // sticks, slides
    for (std::size_t n = 0; n < fields.status.size(); ++n) {
      const double t = std::hypot(fields.traction[3 * n], fields.traction[3 * n + 1]);
      const double* slip = &fields.slip[3 * n];
      EXPECT_EQ(fields.traction[3 * n + 2], 0);
      if (fields.status[n] == 0) {
        EXPECT_EQ(t, 0);
        continue;
      }
      ++count[fields.status[n] == 2 ? 1 : 0];
      EXPECT_LE(t, 0.4 * fields.pressure[n] * 1.05); // edges that meet in a node are not quite in line
      if (fields.status[n] == 2 && s.method == ContactMethod::mortar && std::hypot(slip[0], slip[1]) > 1e-3) {
        EXPECT_LT(fields.traction[3 * n] * slip[0] + fields.traction[3 * n + 1] * slip[1], 0);
        EXPECT_GE(t, 0.4 * fields.pressure[n] * 0.9);
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, count.data(), 2, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_GT(count[0], 0);
    EXPECT_GT(count[1], 0);
  }
}

TEST(Friction, ForcesAndMomentsOfBothBodiesCancelAndSlidingDissipates) {
  for (const ContactSettings& s : frictional()) {
    Sliding rig(s, bodies_mixed);
    const auto [sum, upper, moment, size] = resultants(rig, rig.u);
    ASSERT_GT(size, 1);
    EXPECT_LE(std::abs(sum[0]) + std::abs(sum[1]), 1e-12 * size);
    EXPECT_LE(std::abs(moment), 1e-12 * size);
    EXPECT_GT(rig.contact.friction_loss(rig.u), 1e-4);
  }
}

TEST(Friction, ForceDoesNotDependOnThePartition) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : frictional()) {
      std::vector<NodeMap> forces;
      std::vector<double> lost;
      for (MPI_Comm comm : {MPI_COMM_SELF, PETSC_COMM_WORLD}) {
        Sliding rig(s, partition, comm);
        forces.push_back(node_map(rig.mesh, rig.layout, rig.residual(rig.u, 2.5)));
        lost.push_back(rig.contact.friction_loss(rig.u));
      }
      EXPECT_LE(largest_difference(forces[0], forces[1]), 1e-12) << name;
      EXPECT_NEAR(lost[0], lost[1], 1e-13) << name;
    }
}

TEST(Friction, NoneIsLeftWithACoefficientOfZeroOrWhileSuspended) {
  for (ContactSettings s : frictional()) {
    Sliding rough(s, bodies_apart);
    s.friction = 0;
    Sliding smooth(s, bodies_apart);
    expect_friction_only_in(rough, smooth, [](Vec v) { return norm(v); });
  }
}
