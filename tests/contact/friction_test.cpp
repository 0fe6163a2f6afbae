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
      EXPECT_GT(rig.contact.step(rig.u).friction_loss, 1e-4) << shape;
    }
}

TEST(Friction, WhatWouldSlideTheOtherWaySticksInTheNextLinearSolve) {
  const auto shifted = [](double by) {
    return [by](int body, double X, double Y) {
      std::array<double, 2> u = crush(body, X, Y);
      if (body == 1) u = {u[0] + by, u[1] - 0.06}; // so deep that no constraint opens on the way
      return u;
    };
  };
  for (ContactSettings s : frictional()) {
    SCOPED_TRACE(testing::Message() << "mortar " << (s.method == ContactMethod::mortar));
    Sliding rig(s, bodies_mixed);
    s.friction = 1e9;
    Sliding rough(s, bodies_mixed);
    const Handle<Vec> forth = rig.at(shifted(0.1)), further = rig.at(shifted(0.11)),
                      back = rig.at(shifted(-0.1)), gaps = rig.layout.make_global(),
                      still = rig.layout.make_global();
    rig.contact.start_newton(forth);
    rough.contact.start_newton(forth); // by which directions friction acts
    EXPECT_FALSE(rig.contact.after_newton_step(forth, still, further, true).other);
    EXPECT_FALSE(rig.contact.demands().reverses);
    EXPECT_TRUE(rig.contact.after_newton_step(forth, still, back, true).other);
    EXPECT_TRUE(rig.contact.demands().reverses);
    // Force and tangent of the linear solve are those of a contact that cannot slide.
    const Handle<Vec> r = rig.residual(back), stuck = rough.residual(back);
    const double size = norm(stuck);
    check(VecAXPY(r, -1, stuck));
    EXPECT_GT(norm(r), 1e-2 * size);
    rig.contact.add_gaps(back, 1, gaps);
    check(VecAXPY(r, 1, gaps));
    EXPECT_LE(norm(r), 1e-12 * size);
    const Handle<Mat> K = tangent(rig, back, 1.5), of_stuck = tangent(rough, back, 1.5);
    double tangent_size = 0, difference = 0;
    check(MatNorm(of_stuck, NORM_FROBENIUS, &tangent_size));
    check(MatAXPY(K, -1, of_stuck, DIFFERENT_NONZERO_PATTERN));
    check(MatNorm(K, NORM_FROBENIUS, &difference));
    EXPECT_LE(difference, 1e-12 * tangent_size);
    // It sticks in one solve only, and nothing is remembered from one Newton solve to the next.
    EXPECT_TRUE(rig.contact.after_newton_step(forth, still, back, true).other);
    EXPECT_FALSE(rig.contact.demands().reverses);
    rig.contact.after_newton_step(forth, still, forth, true);
    rig.contact.start_newton(back);
    EXPECT_FALSE(rig.contact.demands().reverses);
    check(VecSet(gaps, 0));
    rig.contact.add_gaps(back, 1, gaps);
    EXPECT_EQ(norm(gaps), 0);
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
    EXPECT_GT(rig.contact.step(rig.u).friction_loss, 1e-4);
  }
}

TEST(Friction, ForceDoesNotDependOnThePartition) {
  for (const auto& [name, partition] : partitions)
    for (const ContactSettings& s : frictional()) {
      std::vector<NodeValues> forces;
      std::vector<double> lost;
      for (MPI_Comm comm : {MPI_COMM_SELF, PETSC_COMM_WORLD}) {
        Sliding rig(s, partition, comm);
        forces.push_back(node_map(rig.mesh, rig.layout, rig.residual(rig.u, 2.5)));
        lost.push_back(rig.contact.step(rig.u).friction_loss);
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

TEST(Friction, ConservingStepKeepsBothMomentaAndItsWorkIsEnergyAndHeat) {
  for (const auto& [name, partition] : partitions)
    for (ContactSettings s : frictional())
      for (const double mu : {0.0, 0.4, 5.0}) {
        if (s.enforce != Enforcement::penalty) continue;
        SCOPED_TRACE(testing::Message()
                     << name << ", coefficient " << mu << ", mortar " << (s.method == ContactMethod::mortar));
        s.impact = ImpactUpdate::conserving;
        s.friction = mu;
        ContactEnvironment heavy;
        heavy.density = 1;
        Rig rig(PETSC_COMM_WORLD, hill(), partition, s, heavy);
        rig.add_displacement();
        const Handle<Vec> start = rig.at(crush);
        rig.layout.to_local(start, rig.state.row("u").trial);
        rig.contact.update_search(start);
        rig.contact.advance(start, start, 0);
        rig.state.commit();
        double energy = rig.contact.measures(start).energy, all_heat = 0;
        // Two steps, each with a turn of both bodies; in the second one springs hold tractions at its start.
        for (int step = 1; step <= 2; ++step) {
          const Handle<Vec> u = rig.at([step](int body, double X, double Y) {
            const std::array<double, 2> d = slide(0.05 * step)(body, X, Y);
            const double angle = 0.3 * step, x = X + d[0], y = Y + d[1];
            return std::array<double, 2>{std::cos(angle) * x - std::sin(angle) * y - X,
                                         std::sin(angle) * x + std::cos(angle) * y - Y};
          });
          const Handle<Vec> before = rig.layout.make_global(), middle = rig.layout.make_global();
          rig.layout.to_global(rig.state.row("u").committed, before);
          rig.contact.set_time(step, 1);
          rig.contact.update_search(u);
          const Handle<Vec> r = rig.residual(u), r_n = rig.layout.make_global();
          rig.layout.to_global(rig.state.row("contact_pair_force").committed, r_n);
          check(VecAXPBY(r, 0.5, 0.5, r_n)); // minus the force over the step
          check(VecWAXPY(middle, 1, before, u));
          check(VecScale(middle, 0.5));
          const NodeValues force = node_map(rig.mesh, rig.layout, r),
                           at = node_map(rig.mesh, rig.layout, middle);
          std::array<double, 3> sum{};
          double size = 0;
          for (const auto& [key, f] : force) {
            const auto& d = at.at(key);
            for (std::size_t k = 0; k < 2; ++k) {
              sum[k] += f[k];
              size += std::abs(f[k]);
            }
            sum[2] += (key[1] + d[0]) * f[1] - (key[2] + d[1]) * f[0];
          }
          ASSERT_GT(size, 1);
          for (const double total : sum) EXPECT_LE(std::abs(total), 1e-12 * size);
          const double work = dot(r, u) - dot(r, before), heat = rig.contact.step(u).friction_loss;
          const double now = rig.contact.measures(u).energy;
          EXPECT_NEAR(rig.contact.step(u).released, 0, 1e-13);
          EXPECT_NEAR(work, now - energy + heat, 1e-12 * (1 + std::abs(work)));
          EXPECT_GE(heat, 0);
          all_heat += heat;
          rig.contact.advance(before, u, 1);
          rig.layout.to_local(u, rig.state.row("u").trial);
          rig.state.commit();
          EXPECT_NEAR(rig.contact.measures(u).energy, now, 1e-12 * now);
          energy = now;
        }
        // The upper body is carried off sideways: what its springs held is not work.
        // It leaves along the surface, both turned by 0.6.
        const Handle<Vec> away = rig.at([](int body, double X, double Y) {
          const std::array<double, 2> d = slide(0.1)(body, X, Y);
          const double x = X + d[0] + (body == 1 ? 8 : 0), y = Y + d[1];
          return std::array<double, 2>{std::cos(0.6) * x - std::sin(0.6) * y - X,
                                       std::sin(0.6) * x + std::cos(0.6) * y - Y};
        });
        rig.contact.set_time(3, 1);
        rig.contact.update_search(away);
        const Handle<Vec> r = rig.residual(away), r_n = rig.layout.make_global(),
                          du = rig.layout.make_global();
        rig.layout.to_global(rig.state.row("contact_pair_force").committed, r_n);
        check(VecAXPBY(r, 0.5, 0.5, r_n));
        rig.layout.to_global(rig.state.row("u").committed, du);
        check(VecAYPX(du, -1, away));
        const double work = dot(r, du), released = rig.contact.step(away).released;
        EXPECT_GT(released, energy / 2);
        EXPECT_NEAR(work,
                    rig.contact.measures(away).energy - energy + released +
                        rig.contact.step(away).friction_loss,
                    1e-12 * (1 + std::abs(work)));
        if (mu == 0) {
          EXPECT_EQ(all_heat, 0);
        } else if (mu < 1) {
          EXPECT_GT(all_heat, 1e-4);
        }
      }
}
