#include "contact_rig.hpp"
#include <numbers>

using namespace impact;
using namespace impact::contact_test;

TEST(ContactInterface, ResidualTangentAndMeasuresDoNotDependOnThePartition) {
  for (const auto& [name, partition] : partitions)
    for (const Motion& motion : {crush, valley}) {
      TwoBlocks b;
      b.bulge = true;
      b.angle = 0.3;
      std::vector<NodeValues> forces, products, again;
      std::vector<ContactMeasures> measured;
      for (MPI_Comm comm : {MPI_COMM_SELF, PETSC_COMM_WORLD}) {
        Rig rig(comm, b, partition);
        const Handle<Vec> u = rig.at(motion), d = rig.at(wiggle), y = rig.layout.make_global();
        rig.contact.update_search(u);
        rig.contact.augment(u);
        forces.push_back(node_map(rig.mesh, rig.layout, rig.residual(u, 2.5)));
        rig.contact.multiply(u, 2.5, d, y);
        products.push_back(node_map(rig.mesh, rig.layout, y));
        measured.push_back(rig.contact.measures(u));
        EXPECT_GT(norm(rig.residual(u)), 0.1);
      }
      double size = 0;
      for (const auto& [key, value] : products[0])
        size = std::max({size, std::abs(value[0]), std::abs(value[1])});
      EXPECT_LE(largest_difference(forces[0], forces[1]), 1e-12) << name;
      EXPECT_LE(largest_difference(products[0], products[1]), 1e-12 * size) << name;
      EXPECT_EQ(measured[0].active, measured[1].active) << name;
      EXPECT_GE(measured[0].active, 4) << name;
      EXPECT_NEAR(measured[0].energy, measured[1].energy, 1e-12);
      EXPECT_DOUBLE_EQ(measured[0].gap_min, measured[1].gap_min);
      EXPECT_DOUBLE_EQ(measured[0].pressure_max, measured[1].pressure_max);
      EXPECT_DOUBLE_EQ(measured[0].pressure_min, measured[1].pressure_min);
      EXPECT_NEAR(measured[0].length, measured[1].length, 1e-12);
    }
}

TEST(ContactInterface, EqualDistancesAreDecidedAlikeOnEveryNumberOfRanks) {
  // One point straight below the ridge of a symmetric roof whose halves are numbered the other way round in
  // parallel.
  TwoBlocks b;
  b.lower_cells = 2;
  b.lower_right = 2;
  b.upper_cells = 1;
  b.upper_left = 0.5;
  b.upper_right = 1.5;
  const Motion roof = [](int body, double X, double Y) {
    return std::array<double, 2>{0, body == 1 ? -0.05 : -0.25 * std::abs(X - 1) * (Y + 0.6)};
  };
  ContactSettings s = settings_of(100);
  s.points = 1;
  std::vector<std::array<double, 3>> force;
  for (MPI_Comm comm : {MPI_COMM_SELF, PETSC_COMM_WORLD}) {
    Rig rig(
        comm, b, [](int, double part, int ranks) { return part < 0.5 ? ranks - 1 : 0; }, s);
    const Handle<Vec> u = rig.at(roof);
    rig.contact.update_search(u);
    force.push_back(rig.contact.measures(u).force);
  }
  EXPECT_GT(std::abs(force[0][0]), 0.1); // to one side, as the ridge has no normal
  EXPECT_DOUBLE_EQ(force[0][0], force[1][0]);
  EXPECT_DOUBLE_EQ(force[0][1], force[1][1]);
}

TEST(ContactInterface, ForcesAndMomentsOfBothBodiesCancel) {
  for (const auto& [name, partition] : partitions)
    for (const Motion& motion : {crush, valley}) {
      TwoBlocks b;
      b.bulge = true;
      Rig rig(PETSC_COMM_WORLD, b, partition);
      const Handle<Vec> u = rig.at(motion);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      const auto [sum, upper, moment, size] = resultants(rig, u);
      ASSERT_GT(size, 1) << name;
      EXPECT_LE(std::abs(sum[0]) + std::abs(sum[1]), 1e-12 * size) << name;
      EXPECT_LE(std::abs(moment), 1e-12 * size) << name;
      const ContactMeasures m = rig.contact.measures(u);
      EXPECT_NEAR(m.force[0], upper[0], 1e-12 * size);
      EXPECT_NEAR(m.force[1], upper[1], 1e-12 * size);
      EXPECT_GT(m.force[1], 0.1); // the upper body is pushed up
    }
}

TEST(ContactInterface, TangentIsTheDerivativeOfTheResidualAndEqualsTheMatrixFreeProduct) {
  for (const auto& [name, partition] : partitions)
    for (const Motion& motion : {crush, valley}) {
      Rig rig(PETSC_COMM_WORLD, {}, partition);
      const Handle<Vec> u = rig.at(motion);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      SCOPED_TRACE(name);
      const Handle<Mat> K = consistent_tangent(rig, u);
      PetscBool symmetric = PETSC_FALSE;
      check(MatIsTranspose(K, K, 1e-10, &symmetric));
      EXPECT_TRUE(symmetric);
    }
}

TEST(ContactInterface, ResidualIsTheDerivativeOfTheEnergy) {
  TwoBlocks b;
  b.bulge = true;
  Rig rig(PETSC_COMM_WORLD, b, bodies_mixed);
  const Handle<Vec> u = rig.at(crush);
  rig.contact.update_search(u);
  rig.contact.augment(u);
  expect_force_of_the_energy(rig, u);
}

TEST(ContactInterface, BottomOfAValleyPushesAlongTheDirectionToThePoint) {
  // One point at (0.9 + s, -0.1) under the bottom (0.9, 0): its gap is minus the distance, its force points
  // at the bottom.
  TwoBlocks b;
  b.upper_cells = 1;
  b.upper_left = 0.41;
  b.upper_right = 1.41;
  ContactSettings s = settings_of(100);
  s.points = 1;
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, b, partition, s);
    const Handle<Vec> u = rig.at([](int body, double X, double Y) {
      return body == 1 ? std::array<double, 2>{0, -0.1} : valley(body, X, Y);
    });
    rig.contact.update_search(u);
    const ContactMeasures m = rig.contact.measures(u);
    const double distance = std::hypot(0.01, 0.1);
    EXPECT_EQ(m.active, 1) << name;
    EXPECT_NEAR(m.gap_min, -distance, 1e-14) << name;
    EXPECT_NEAR(m.force[0], -100 * 0.01, 1e-12) << name;
    EXPECT_NEAR(m.force[1], 100 * 0.1, 1e-12) << name;
  }
}

TEST(ContactInterface, FixedDofsHaveNoRowsAndColumnsOnAnyRank) {
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, {}, partition);
    const Handle<Vec> u = rig.at(crush), d = rig.at(wiggle);
    rig.contact.update_search(u);
    // Every vertical dof of the lower surface and every horizontal one of the upper.
    std::vector<char> fixed(rig.layout.make_local().size(), 0);
    for (int node : rig.mesh.nodes("lower_top")) fixed[static_cast<std::size_t>(2 * node + 1)] = 1;
    for (int node : rig.mesh.nodes("upper_bottom")) fixed[static_cast<std::size_t>(2 * node)] = 1;
    const Handle<Mat> whole = tangent(rig, u, 1);
    rig.contact.constraints().set_fixed_dofs(fixed);
    const Handle<Mat> K = tangent(rig, u, 1);
    rig.contact.search().forget();
    rig.contact.update_search(u);
    const Handle<Vec> flags = rig.layout.make_global(), masked = rig.layout.make_global();
    rig.layout.to_global(std::vector<double>(fixed.begin(), fixed.end()), flags);
    check(VecPointwiseMult(masked, flags, d));
    check(VecAYPX(masked, -1, d)); // d without the fixed dofs
    const Handle<Vec> expected = rig.layout.make_global(), assembled = rig.layout.make_global(),
                      free = rig.layout.make_global();
    check(MatMult(whole, masked, expected));
    const Handle<Vec> held = rig.layout.make_global();
    check(VecPointwiseMult(held, flags, expected));
    check(VecAXPY(expected, -1, held));
    check(MatMult(K, d, assembled));
    rig.contact.multiply(u, 1, d, free);
    const double size = norm(expected);
    ASSERT_GT(size, 1);
    ASSERT_GT(norm(held), 0.1) << "the test would hold for flags that are ignored";
    check(VecAXPY(assembled, -1, expected));
    check(VecAXPY(free, -1, expected));
    EXPECT_LE(norm(assembled), 1e-13 * size) << name;
    EXPECT_LE(norm(free), 1e-13 * size) << name;
  }
}

TEST(ContactInterface, CandidatesAreRebuiltOnlyAfterHalfTheSkinAndThenTheSame) {
  ContactSettings s = settings_of(100);
  s.search_radius = 0.6; // by local sizes the list is made anew far earlier
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, {}, partition, s);
    const double skin = rig.contact.settings().search_radius / 2;
    EXPECT_FALSE(rig.contact.update_search(rig.at(rest))); // built by the constructor
    const auto before = rig.contact.couplings();
    rig.contact.search().forget();
    EXPECT_FALSE(rig.contact.update_search(rig.at(rest))); // built again, nothing changed
    EXPECT_EQ(rig.contact.couplings(), before);
    EXPECT_FALSE(rig.contact.update_search(rig.at(sink(0.499 * skin))));
    EXPECT_EQ(rig.contact.couplings(), before);

    // The force does not depend on when the list was built.
    const Handle<Vec> u = rig.at([&](int body, double X, double Y) {
      auto d = crush(body, X, Y);
      d[0] += body == 1 ? 0.2 * skin : 0;
      return d;
    });
    EXPECT_FALSE(rig.contact.update_search(u));
    const Handle<Vec> old_list = rig.residual(u);
    EXPECT_GT(norm(old_list), 0.1);
    rig.contact.search().forget();
    rig.contact.update_search(u);
    const Handle<Vec> new_list = rig.residual(u);
    check(VecAXPY(new_list, -1, old_list));
    EXPECT_LE(norm(new_list), 1e-14 * norm(old_list)) << name;

    const Handle<Vec> away = rig.at([](int body, double, double) {
      return std::array<double, 2>{body * 0.9, 0};
    });
    const Handle<Vec> r = rig.layout.make_global();
    EXPECT_TRUE(rig.contact.update_search(away));
    const long searches = rig.contact.searches();
    EXPECT_FALSE(rig.contact.update_search(away));
    EXPECT_EQ(rig.contact.searches(), searches);
  }
}

TEST(ContactInterface, ByLocalSizesCandidatesAreRebuiltAfterATenthOfAFacetAndThenTheSame) {
  const double tenth = 0.025; // of a facet of the upper block, the shorter one
  const Motion pressed = [](int body, double X, double Y) {
    const std::array<double, 2> d = crush(body, X, Y);
    return std::array<double, 2>{d[0] + 0.05 * body, d[1]};
  };
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, {}, partition);
    const Handle<Vec> r = rig.layout.make_global();
    const auto is_rebuilt_at = [&](const Handle<Vec>& u) {
      const long before = rig.contact.searches();
      rig.contact.update_search(u);
      return rig.contact.searches() > before;
    };
    const auto moved = [&](double way) {
      return rig.at([&](int body, double X, double Y) {
        const std::array<double, 2> d = pressed(body, X, Y);
        return std::array<double, 2>{d[0] + way * body, d[1]};
      });
    };
    const auto before = rig.contact.couplings();
    const Handle<Vec> start = moved(0), near = moved(0.99 * tenth), far = moved(1.01 * tenth);
    EXPECT_TRUE(rig.contact.update_search(start));
    int other = rig.contact.couplings() != before ? 1 : 0; // a rank may have no facets
    MPI_Allreduce(MPI_IN_PLACE, &other, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD);
    EXPECT_EQ(other, 1);
    const auto found = rig.contact.couplings();
    EXPECT_FALSE(is_rebuilt_at(start));
    EXPECT_FALSE(is_rebuilt_at(near));
    EXPECT_TRUE(is_rebuilt_at(far));
    rig.contact.search().forget();
    rig.contact.update_search(start);

    // The force does not depend on when the list was built.
    EXPECT_FALSE(rig.contact.update_search(near));
    EXPECT_EQ(rig.contact.couplings(), found);
    const Handle<Vec> old_list = rig.residual(near);
    EXPECT_GT(norm(old_list), 0.1);
    rig.contact.search().forget();
    rig.contact.update_search(near);
    const Handle<Vec> new_list = rig.residual(near);
    check(VecAXPY(new_list, -1, old_list));
    EXPECT_LE(norm(new_list), 1e-14 * norm(old_list)) << name;
  }
}

TEST(ContactInterface, ARefusedAttemptLeavesNoTraceInTheCandidates) {
  for (const auto& [name, partition] : partitions)
    for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar}) {
      SCOPED_TRACE(testing::Message() << name << ", mortar " << (method == ContactMethod::mortar));
      ContactSettings s = settings_of(100);
      s.method = method;
      s.enforce = Enforcement::penalty;
      Rig rig(PETSC_COMM_WORLD, {}, partition, s);
      rig.add_displacement();
      const Handle<Vec> start = rig.at(crush);
      rig.layout.to_local(start, rig.state.row("u").trial);
      rig.contact.update_search(start); // what an attempt from here begins with
      rig.state.commit();
      const auto same_force_as = [&](const Handle<Vec>& r) {
        const Handle<Vec> now = rig.residual(start);
        PetscBool equal = PETSC_FALSE;
        check(VecEqual(now, r, &equal));
        return equal == PETSC_TRUE;
      };
      const auto away = [](double way) {
        return [way](int body, double, double) { return std::array<double, 2>{body * way, 0}; };
      };
      rig.contact.set_time(1, 1, true);
      rig.contact.update_search(start);
      const NodePairs found = rig.contact.couplings();
      const Handle<Vec> force = rig.residual(start);
      ASSERT_GT(norm(force), 0.1);

      // Searched twice within an attempt that ends far away: the next one begins as this one did, and says
      // that the matrix has another pattern than it needs.
      EXPECT_TRUE(rig.contact.update_search(rig.at(away(0.9))));
      rig.contact.update_search(rig.at(away(1.8)));
      rig.contact.set_time(0.5, 4, true);
      EXPECT_EQ(rig.contact.couplings(), found);
      EXPECT_TRUE(rig.contact.update_search(start));
      EXPECT_FALSE(rig.contact.update_search(start));
      EXPECT_EQ(rig.contact.couplings(), found);
      EXPECT_TRUE(same_force_as(force));
      // Refused again before it searched: nothing to bring back.
      rig.contact.set_time(0.25, 16, true);
      EXPECT_FALSE(rig.contact.update_search(start));

      // Accepted, what was found last is what the next step begins with.
      const Handle<Vec> there = rig.at(away(0.9));
      EXPECT_TRUE(rig.contact.update_search(there));
      const NodePairs kept = rig.contact.couplings();
      rig.layout.to_local(there, rig.state.row("u").trial);
      rig.state.commit();
      rig.contact.set_time(1, 1, true);
      EXPECT_FALSE(rig.contact.update_search(there));
      EXPECT_EQ(rig.contact.couplings(), kept);
    }
}

TEST(ContactInterface, FreeFlightIsFollowedByContactWhenTheBodiesMeet) {
  TwoBlocks b;
  b.gap = 3;
  Rig rig(PETSC_COMM_WORLD, b, bodies_apart);
  Handle<Vec> u = rig.at(rest);
  EXPECT_EQ(rig.contact.measures(u).active, 0);
  EXPECT_TRUE(rig.contact.review(u).converged);
  EXPECT_TRUE(std::isnan(rig.contact.measures(u).gap_min));
  u = rig.at(sink(2.9));
  rig.contact.update_search(u);
  EXPECT_NEAR(rig.contact.measures(u).gap_min, 0.1, 1e-12);
  EXPECT_TRUE(rig.contact.review(u).converged);
  u = rig.at(sink(3.02));
  rig.contact.update_search(u);
  const AugmentReport report = rig.contact.review(u);
  EXPECT_FALSE(report.converged);
  EXPECT_NEAR(report.penetration, 0.02, 1e-12);
  EXPECT_EQ(report.active, 10);
  EXPECT_NEAR(rig.contact.measures(u).force[1], 100 * 0.02 * 1.25, 1e-12);
  EXPECT_NEAR(rig.contact.measures(u).length, 1.25, 1e-12);
}

TEST(ContactInterface, FastNodesDeeperThanAFacetAreNotLost) {
  TwoBlocks b; // facets of 0.3 below, 0.25 above
  b.gap = 0.01;
  ContactSettings s = settings_of(100);
  s.search_radius = 0.6; // by local sizes only what moved so far within a step is seen so deep
  Rig rig(PETSC_COMM_WORLD, b, bodies_apart, s);
  const Handle<Vec> u = rig.at(sink(0.46));
  rig.contact.update_search(u);
  EXPECT_NEAR(rig.contact.measures(u).force[1], 100 * 0.45 * 1.25, 1e-10);
  // Deeper than the search radius of 0.6 no facet is taken for the one that was passed.
  const Handle<Vec> lost = rig.at(sink(0.63));
  rig.contact.update_search(lost);
  EXPECT_EQ(rig.contact.measures(lost).force[1], 0);
  // Even through the whole body, 0.6 high, when the search radius allows it.
  ContactSettings deep = settings_of(100);
  deep.search_radius = 0.8;
  Rig through(PETSC_COMM_WORLD, b, bodies_apart, deep);
  const Handle<Vec> below = through.at(sink(0.71));
  through.contact.update_search(below);
  EXPECT_NEAR(through.contact.measures(below).force[1], 100 * 0.7 * 1.25, 1e-10);
  // By local sizes what falls so far within a step is held, and is no solution: the next one, which starts
  // there, would miss it. What lies 0.19 deep is one, and is still held there.
  for (const double depth : {0.45, 0.19}) {
    Rig local(PETSC_COMM_WORLD, b, bodies_apart);
    StateRow& start =
        local.state.add({"u", Support::vertex, 2}, 2 * static_cast<std::size_t>(local.mesh.node_count()));
    local.contact.set_time(0);
    const Handle<Vec> fallen = local.at(sink(depth + 0.01)), next = local.at(sink(depth + 0.015));
    local.contact.update_search(fallen);
    EXPECT_NEAR(local.contact.measures(fallen).force[1], 100 * depth * 1.25, 1e-10);
    EXPECT_EQ(local.contact.review(fallen).settled, depth < 0.2);
    local.layout.to_local(fallen, start.trial);
    local.state.commit();
    local.contact.set_time(1);
    local.contact.search().forget(); // as a restart does
    local.contact.update_search(next);
    EXPECT_NEAR(local.contact.measures(next).force[1], depth < 0.2 ? 100 * (depth + 0.005) * 1.25 : 0, 1e-10);
  }
}

TEST(ContactInterface, WhatClosesWithinAStepIsMeasuredInFacets) {
  TwoBlocks b; // facets of 0.3 below, 0.25 above
  b.gap = 0.01;
  for (ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar})
    for (const auto& [name, partition] : partitions) {
      ContactSettings s = settings_of(100);
      s.method = method;
      Rig rig(PETSC_COMM_WORLD, b, partition, s);
      const Handle<Vec> u = rig.at(sink(0.26));
      rig.contact.update_search(u);
      EXPECT_EQ(rig.contact.constraints().closed_within_step(u, 0.5), 0) << name << ": no step has begun";
      StateRow& start =
          rig.state.add({"u", Support::vertex, 2}, 2 * static_cast<std::size_t>(rig.mesh.node_count()));
      rig.contact.set_time(0);
      rig.contact.update_search(u);
      EXPECT_NEAR(rig.contact.constraints().closed_within_step(u, 0.5), 1, 1e-12) << name;
      EXPECT_EQ(rig.contact.constraints().closed_within_step(u, 1.01), 0) << name;
      // It lay 0.1 deep before.
      rig.layout.to_local(rig.at(sink(0.11)), start.committed);
      rig.contact.set_time(0);
      rig.contact.update_search(u);
      EXPECT_NEAR(rig.contact.constraints().closed_within_step(u, 0.5), 0.6, 1e-12) << name;
    }
  // A plane that rises by 0.2 towards a block 0.05 above it.
  ContactSettings s = settings_of(100);
  s.primary = "plane";
  s.rigid_motion[1] = [](double t) { return 0.2 * t - 0.05; };
  Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s);
  rig.state.add({"u", Support::vertex, 2}, 2 * static_cast<std::size_t>(rig.mesh.node_count()));
  const Handle<Vec> rest = rig.at(sink(0));
  rig.contact.set_time(0);
  rig.contact.advance(rest, rest, 0);
  rig.state.commit();
  rig.contact.set_time(1);
  rig.contact.update_search(rest);
  EXPECT_NEAR(rig.contact.constraints().closed_within_step(rest, 0.1), 0.15 / 0.25, 1e-12);
}

TEST(ContactInterface, PointThatPassedAFacetInTheStepIsHeldAtAnyDepth) {
  TwoBlocks b; // facets of 0.3 below, 0.25 above; search radius 0.6
  b.gap = 0.8;
  const Motion aside = [](int body, double, double) {
    return body == 1 ? std::array<double, 2>{6, -2.4} : std::array<double, 2>{0, 0};
  };
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, b, partition);
    StateRow row;
    row.name = "u";
    row.support = Support::vertex;
    row.components = 2;
    StateRow& start = rig.state.add(row, 2 * static_cast<std::size_t>(rig.mesh.node_count()));
    rig.contact.set_time(0);
    const Handle<Vec> u = rig.at(sink(2.4)), lost = rig.at(aside);
    rig.contact.update_search(u);
    EXPECT_NEAR(rig.contact.measures(u).force[1], 100 * 1.6 * 1.25, 1e-9) << name;
    EXPECT_FALSE(rig.contact.review(u).settled) << name;
    // At the height of the surface it was beside the block: nothing was passed.
    rig.contact.update_search(lost);
    EXPECT_EQ(rig.contact.measures(lost).active, 0) << name;
    EXPECT_TRUE(rig.contact.review(lost).settled) << name;
    // A body that was below before the step is no contact.
    const Handle<Vec> below = rig.at(sink(2.3));
    rig.layout.to_local(below, start.committed);
    rig.contact.set_time(0);
    rig.contact.update_search(u);
    EXPECT_EQ(rig.contact.measures(u).active, 0) << name;
  }
}

TEST(ContactInterface, PointsKeepTheirEdgeOverAVertexUntilTheOverlapEnds) {
  // The lower surface has a flat kink at X = 0.9; one point crosses it, in contact, from the left.
  TwoBlocks b;
  b.upper_cells = 1;
  b.upper_left = 0.4;
  b.upper_right = 1.4;
  const double slope = 0.004, half_edge = 0.15;
  ContactSettings s = settings_of(100);
  s.points = 1;
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, b, partition, s);
    // The point at x: depth 0.001 below the node of the kink.
    auto place_at = [&](double x) {
      return rig.at([=](int body, double X, double Y) {
        if (body == 1) return std::array<double, 2>{x - 0.9, -0.001};
        return std::array<double, 2>{0, -slope * std::max(0.0, X - 0.9) * (Y + 0.6) / 0.6};
      });
    };
    auto sideways = [&](Vec u) { return rig.contact.measures(u).force[0]; };
    rig.contact.set_time(0);
    const Handle<Vec> before = place_at(0.9 - 0.02 * half_edge), over = place_at(0.9 + 0.03 * half_edge),
                      beyond = place_at(0.9 + 0.08 * half_edge);
    rig.contact.update_search(before);
    EXPECT_TRUE(rig.contact.review(before).settled) << name;
    EXPECT_NEAR(sideways(before), 0, 1e-12) << name;
    // Without another call nothing changes, even far over the vertex: Newton's method sees one edge.
    EXPECT_NEAR(sideways(beyond), 0, 1e-12) << name;
    rig.contact.update_search(over);
    EXPECT_TRUE(rig.contact.review(over).settled) << name;
    EXPECT_NEAR(sideways(over), 0, 1e-12) << name;
    // Past the overlap the other edge pushes, and what was solved with the first one is no solution.
    rig.contact.update_search(beyond);
    EXPECT_FALSE(rig.contact.review(beyond).settled) << name;
    EXPECT_FALSE(rig.contact.review(beyond).converged) << name;
    EXPECT_NEAR(sideways(beyond) / rig.contact.measures(beyond).force[1], slope, 1e-9) << name;
    rig.contact.update_search(beyond);
    EXPECT_TRUE(rig.contact.review(beyond).settled) << name;
    // Back within the overlap it stays on the second edge; a new attempt begins with the nearest.
    rig.contact.update_search(over);
    EXPECT_GT(sideways(over), 1e-6) << name;
    const Handle<Vec> back = place_at(0.9 - 0.03 * half_edge);
    rig.contact.update_search(back);
    EXPECT_GT(sideways(back), 1e-6) << name;
    rig.contact.set_time(0);
    rig.contact.update_search(back);
    EXPECT_NEAR(sideways(back), 0, 1e-12) << name;
  }
}

TEST(ContactInterface, SidesSwappedGiveTheOppositeForceOnMatchingLengths) {
  TwoBlocks b; // the ends of the upper block stand on nodes of the lower one, the meshes do not match between
  b.lower_cells = 7;
  b.upper_left = 0.3;
  b.upper_right = 1.5;
  for (const auto& [name, partition] : partitions) {
    Rig one(PETSC_COMM_WORLD, b, partition);
    ContactSettings swapped = settings_of(100);
    std::swap(swapped.secondary, swapped.primary);
    Rig other(PETSC_COMM_WORLD, b, partition, swapped);
    const Handle<Vec> u = one.at(sink(0.01)), v = other.at(sink(0.01));
    const auto f = one.contact.measures(u).force, g = other.contact.measures(v).force;
    EXPECT_NEAR(f[1], 100 * 0.01 * 1.2, 1e-13);
    EXPECT_NEAR(f[0], 0, 1e-13);
    EXPECT_NEAR(g[0], -f[0], 1e-13) << name;
    EXPECT_NEAR(g[1], -f[1], 1e-13) << name;
  }
}

TEST(ContactInterface, TurningTheWholeProblemTurnsTheForces) {
  ContactMeasures straight;
  for (int degrees = 0; degrees <= 90; degrees += 9) {
    TwoBlocks b;
    b.bulge = true;
    b.angle = degrees * std::numbers::pi / 180;
    Rig rig(PETSC_COMM_WORLD, b, bodies_mixed);
    const Handle<Vec> u = rig.at(crush);
    rig.contact.update_search(u);
    const ContactMeasures m = rig.contact.measures(u);
    if (degrees == 0) straight = m;
    expect_turned(m, straight, b);
  }
}

TEST(ContactInterface, AugmentationOfOneSpringReproducesTheOracle) {
  // oracle.py O13 with the upper block as the spring's mass: k u = F - A <lambda - eps (g0 - u)>. Gaps and
  // ratio as there.
  const double k = 1e9, F = 5e3, g0 = 1e-6, A = 1.25, eps = 4e9 / A;
  const std::array<double, 5> gaps = {-8e-07, -1.6e-07, -3.2e-08, -6.4e-09, -1.28e-09};
  ContactSettings s = settings_of(eps);
  s.gap_tol = 1e-8;
  s.pressure_tol = 2e-3;
  TwoBlocks b;
  b.gap = g0;
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, b, partition, s);
    rig.contact.start_augmentation();
    double force = 0;
    int converged_after = 0;
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      const double down = (F - force + 4e9 * g0) / (k + 4e9);
      const Handle<Vec> u = rig.at(sink(down));
      EXPECT_NEAR(rig.contact.measures(u).force[1], F - k * down, 1e-6 * F) << "equilibrium " << i;
      const AugmentReport report = rig.contact.augment(u);
      EXPECT_NEAR(report.penetration, -gaps[i], 1e-14)
          << name << " " << i; // rounding of coordinates of size one
      EXPECT_DOUBLE_EQ(report.penalty, eps);
      EXPECT_EQ(report.active, 10);
      force = report.multiplier * A;
      if (report.converged && converged_after == 0) converged_after = static_cast<int>(i) + 1;
    }
    EXPECT_NEAR(force, 4000, 4000 * std::pow(0.2, 5) * 1.01);
    EXPECT_GE(force, 4000 * (1 - 2e-3));
    // The gap is below 1e-8 first at the fourth, the relative change 0.2^i * 4 below 2e-3 first at the fifth.
    EXPECT_EQ(converged_after, 5);
  }
}

TEST(ContactInterface, PenaltyGrowsWhenTheGapFallsTooSlowlyOrByThePapersRule) {
  ContactSettings s = settings_of(100);
  s.penalty_increment = 50;
  s.penalty_max = 220;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_apart, s);
  rig.contact.start_augmentation();
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(8e-3))).penalty, 100);
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(1.9e-3))).penalty, 100); // fell by more than 4
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(5e-4))).penalty, 100);   // by less
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(5e-4))).penalty, 150);
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(5e-4))).penalty, 200);
  EXPECT_DOUBLE_EQ(rig.contact.augment(rig.at(sink(5e-4))).penalty, 220); // the cap
  EXPECT_DOUBLE_EQ(rig.contact.review(rig.at(sink(5e-4))).penalty, 220);

  s.growth = PenaltyGrowth::every_augmentation;
  Rig paper(PETSC_COMM_WORLD, {}, bodies_apart, s);
  paper.contact.start_augmentation();
  EXPECT_DOUBLE_EQ(paper.contact.augment(paper.at(sink(8e-3))).penalty, 100);
  EXPECT_DOUBLE_EQ(paper.contact.augment(paper.at(sink(1e-3))).penalty, 150);
  EXPECT_DOUBLE_EQ(paper.contact.review(paper.at(sink(1e-4))).penalty, 200);
}

TEST(ContactInterface, MultipliersFollowTheStateTable) {
  Rig rig(PETSC_COMM_WORLD, {}, bodies_apart);
  const Handle<Vec> u = rig.at(sink(0.01)), open = rig.at(sink(-1e-3));
  const double width = 1.25;
  rig.contact.augment(u);
  EXPECT_NEAR(rig.contact.measures(u).force[1], width * 2, 1e-12);
  rig.state.rollback();
  EXPECT_NEAR(rig.contact.measures(u).force[1], width * 1, 1e-12);
  rig.contact.augment(u);
  rig.state.commit();
  rig.state.rollback();
  EXPECT_NEAR(rig.contact.measures(u).force[1], width * 2, 1e-12);
  // A multiplier holds a slightly open point, and a review stores nothing.
  EXPECT_NEAR(rig.contact.measures(open).force[1], width * 0.9, 1e-12);
  rig.contact.review(open);
  EXPECT_NEAR(rig.contact.measures(open).force[1], width * 0.9, 1e-12);
  // Points that face nothing any more lose theirs.
  const Handle<Vec> gone = rig.at(sink(-5));
  rig.contact.update_search(gone);
  EXPECT_FALSE(rig.contact.augment(gone).converged);
  EXPECT_TRUE(rig.contact.review(gone).converged);
  const Handle<Vec> back = rig.at(sink(0.01));
  rig.contact.update_search(back);
  EXPECT_NEAR(rig.contact.measures(back).force[1], width * 1, 1e-12);
}

TEST(ContactInterface, PurePenaltyNeverChangesMultipliers) {
  ContactSettings s = settings_of(100);
  s.enforce = Enforcement::penalty;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_apart, s);
  const Handle<Vec> u = rig.at(sink(0.01));
  EXPECT_TRUE(rig.contact.augment(u).converged);
  EXPECT_NEAR(rig.contact.measures(u).force[1], 1.25, 1e-12);
}

// p = eps d (1 + d^2/s^2) and its energy eps (d^2/2 + d^4/4s^2), over a width of 1.25; forces are the
// derivative of the energy, the tangent that of the forces.
TEST(ContactInterface, PenaltiesOfExplicitStepsStiffenWithTheirDepth) {
  ContactSettings s = settings_of(100);
  s.enforce = Enforcement::penalty;
  s.method = ContactMethod::gauss_points;
  s.iterated = false;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_apart, s);
  rig.contact.set_penalty(100, 0.02);
  const auto law = [](double d) { return 100 * d * (1 + d * d / 4e-4); };
  for (const double depth : {0.01, 0.02, 0.05}) {
    const Handle<Vec> u = rig.at(sink(depth));
    const ContactMeasures m = rig.contact.measures(u);
    EXPECT_NEAR(m.force[1], 1.25 * law(depth), 1e-11) << depth;
    EXPECT_NEAR(m.energy, 1.25 * 100 * depth * depth * (0.5 + depth * depth / 16e-4), 1e-12) << depth;
    expect_force_of_the_energy(rig, u);
    consistent_tangent(rig, u);
  }
  rig.contact.set_penalty(100, 0);
  EXPECT_NEAR(rig.contact.measures(rig.at(sink(0.05))).force[1], 1.25 * 5, 1e-12);
}

TEST(ContactInterface, WorkAndImpulseOfAStepAreTrapezoidal) {
  ContactEnvironment environment;
  environment.thickness = 3;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, settings_of(100), environment);
  const Handle<Vec> start = rig.at(rest), mid = rig.at(sink(0.01)), end = rig.at(sink(0.03));
  rig.contact.advance(start, start, 0);
  rig.state.commit();
  rig.contact.advance(start, mid, 0.5);
  rig.state.commit();
  rig.contact.advance(mid, end, 0.25);
  // The force is linear in the depth, so the work is exactly minus the energy: 3 * 100/2 * 0.03^2 * 1.25.
  const ContactMeasures m = rig.contact.measures(end);
  EXPECT_NEAR(m.energy, 0.16875, 1e-12);
  EXPECT_NEAR(m.work, -m.energy, 1e-12);
  EXPECT_NEAR(m.impulse[1], 3 * 1.25 * (0.5 * 0.5 + 0.25 * 2), 1e-12);
  EXPECT_NEAR(m.impulse[0], 0, 1e-12);
  rig.state.rollback();
  EXPECT_NEAR(rig.contact.measures(end).impulse[1], 3 * 1.25 * 0.25, 1e-12);
}

TEST(ContactInterface, NodalFieldsOfAUniformContactAreUniform) {
  for (const auto& [name, partition] : partitions) {
    Rig rig(PETSC_COMM_WORLD, {}, partition);
    const ContactFields fields = rig.contact.nodal_fields(rig.at(sink(0.02)));
    const std::vector<double>&pressure = fields.pressure, &gap = fields.gap;
    std::vector<char> on_surface(pressure.size(), 0);
    for (int node : rig.mesh.nodes("upper_bottom")) on_surface[static_cast<std::size_t>(node)] = 1;
    for (std::size_t n = 0; n < pressure.size(); ++n) {
      if (on_surface[n]) {
        EXPECT_NEAR(pressure[n], 2, 1e-11) << name;
        EXPECT_NEAR(gap[n], -0.02, 1e-13) << name;
        EXPECT_EQ(fields.status[n], 2) << name; // nothing holds it
      } else {
        EXPECT_EQ(pressure[n], 0);
        EXPECT_TRUE(std::isnan(gap[n]));
        EXPECT_EQ(fields.status[n], 0);
      }
    }
  }
}

// Either surface is the secondary one of a contact of its own.
TEST(ContactSet, ANodeKeepsTheGapOfTheContactThatKnowsIt) {
  for (const auto& [name, partition] : partitions) {
    const TwoBlocks blocks;
    const Mesh mesh = make_blocks(PETSC_COMM_WORLD, blocks, partition);
    const FieldLayout layout(mesh, "u", 2);
    StateTable state;
    ContactSet contacts;
    ContactSettings s = settings_of(100);
    contacts.emplace_back(mesh, layout, s, ContactEnvironment(), state);
    std::swap(s.secondary, s.primary);
    s.id = "other_way";
    contacts.emplace_back(mesh, layout, s, ContactEnvironment(), state);
    const Handle<Vec> u = displacement(mesh, layout, blocks, sink(0.02));
    const ContactFields both = contacts.nodal_fields(u);
    for (const ContactInterface& contact : contacts) {
      const std::vector<double> alone = contact.nodal_fields(u).gap;
      for (std::size_t node = 0; node < alone.size(); ++node)
        if (!std::isnan(alone[node])) {
          EXPECT_EQ(both.gap[node], alone[node]) << name << " " << contact.id();
        }
    }
  }
}

TEST(ContactInterface, AxisymmetricAreaIsTheFullRing) {
  TwoBlocks b;
  b.frame = Frame::axisymmetric;
  Rig rig(PETSC_COMM_WORLD, b, bodies_mixed);
  const double ring = std::numbers::pi * (1.6 * 1.6 - 0.35 * 0.35);
  const ContactMeasures m = rig.contact.measures(rig.at(sink(0.02)));
  EXPECT_NEAR(m.force[1], 100 * 0.02 * ring, 1e-11);
  EXPECT_NEAR(m.length, ring, 1e-11);
  EXPECT_NEAR(m.pressure_max, 2, 1e-12);
  // Pressures count on the current area: a ring grown by 10 % in R carries the same nominal pressure on more
  // of it.
  const ContactMeasures grown = rig.contact.measures(rig.at([](int body, double X, double) {
    return std::array<double, 2>{body * 0.1 * X, -0.02 * body};
  }));
  EXPECT_NEAR(grown.pressure_max, 2 / 1.21, 1e-12);
}

TEST(ContactInterface, RigidPlaneHoldsABodyAtAnyAngleAndMoves) {
  for (int turn = 0; turn < 14; ++turn) {
    const int degrees = 15 * (turn / 2);
    TwoBlocks b;
    b.angle = degrees * std::numbers::pi / 180;
    const auto normal = place(b, 0, 1), point = place(b, 0.7, 0);
    ContactSettings s = settings_of(100);
    s.primary = "plane";
    s.method = turn % 2 == 0 ? ContactMethod::gauss_points : ContactMethod::mortar;
    s.enforce = Enforcement::auglag;
    s.plane_point[0] = point[0];
    s.plane_point[1] = point[1];
    s.plane_normal[0] = 3 * normal[0];
    s.plane_normal[1] = 3 * normal[1];
    for (std::size_t k = 0; k < 2; ++k) s.rigid_motion[k] = [normal, k](double t) { return -t * normal[k]; };
    Rig rig(PETSC_COMM_WORLD, b, bodies_mixed, s);
    EXPECT_TRUE(s.method == ContactMethod::mortar || rig.contact.couplings().empty());
    const Handle<Vec> u = rig.at(sink(0.02)), d = rig.at(wiggle), product = rig.layout.make_global();
    const auto upward = place(b, 0, 1);
    auto f = rig.contact.measures(u).force;
    EXPECT_NEAR(f[0], 2.5 * upward[0], 1e-12) << degrees;
    EXPECT_NEAR(f[1], 2.5 * upward[1], 1e-12) << degrees;
    rig.contact.set_time(0.015); // the plane has gone down by 0.015
    f = rig.contact.measures(u).force;
    EXPECT_NEAR(f[0], 0.625 * upward[0], 1e-12) << degrees;
    EXPECT_NEAR(f[1], 0.625 * upward[1], 1e-12) << degrees;
    const Handle<Mat> K = tangent(rig, u, 1);
    check(MatMult(K, d, product));
    const double h = 1e-4; // the residual is linear
    const Handle<Vec> moved = rig.layout.make_global();
    check(VecWAXPY(moved, h, d, u));
    const Handle<Vec> difference = rig.residual(moved), before = rig.residual(u);
    check(VecAXPY(difference, -1, before));
    check(VecAXPY(difference, -h, product));
    EXPECT_GT(norm(product), 1);
    EXPECT_LE(norm(difference), 1e-12 * norm(product));
  }
}

TEST(ContactInterface, RoundRigidBodiesPushAlongTheirNormalsWithTheirExactTangent) {
  for (const char* shape : {"rigid_cylinder", "rigid_sphere"})
    for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar}) {
      ContactSettings s = settings_of(100);
      s.primary = shape;
      s.method = method;
      s.enforce = Enforcement::auglag;
      s.centre[0] = 1;
      s.centre[1] = -2;
      s.radius = 1.995;
      Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s);
      const Handle<Vec> u = rig.at(crush);
      rig.contact.set_time(1);
      rig.contact.update_search(u);
      rig.contact.augment(u);
      consistent_tangent(rig, u);
      expect_force_of_the_energy(rig, u);
      EXPECT_GT(rig.contact.measures(u).force[1], 0.1);
    }
}

TEST(ContactInterface, WorkOfAMovingRigidBodyIsItsForceTimesItsMotion) {
  ContactSettings s = settings_of(100);
  s.primary = "plane";
  s.enforce = Enforcement::penalty;
  s.rigid_motion[1] = [](double t) { return 0.01 * t; };
  ContactEnvironment environment;
  environment.thickness = 3;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s, environment);
  const Handle<Vec> u = rig.at(sink(0.02));
  rig.contact.set_time(1);
  rig.contact.advance(u, u, 0);
  rig.state.commit();
  rig.contact.set_time(3);
  // 100 x 1.25 x depth at both ends of the step, over a way of 0.02.
  EXPECT_NEAR(rig.contact.step(u).obstacle_work, 3 * 125 * 0.04 * 0.02, 1e-12);
  // The force of a stabilised step is that of its end.
  rig.add_displacement();
  rig.contact.set_time(3, 1, true);
  EXPECT_NEAR(rig.contact.step(u).obstacle_work, 3 * 125 * 0.05 * 0.02, 1e-12);
}

// Of a force F that is switched on and off the displacement gets F over the step, beta Y + (1/2 - beta) Y_n =
// F/2, and the velocity gamma Y + (1 - gamma) Y_n; by the trapezoidal rule, where Y would alternate, both get
// F.
TEST(ContactInterface, WhatAStepCarriesMovesTheBodiesByItsForce) {
  ContactSettings s = settings_of(100);
  s.primary = "plane";
  for (const double rho : {1.0, 0.8, 0.0}) {
    const double alpha_m = 2 / (1 + rho), gamma = alpha_m - 0.5,
                 beta = alpha_m * alpha_m / 4; // Newmark's family
    Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s, {});
    rig.add_displacement();
    double carried = 0, impulse = 0;
    for (const double depth : {0.02, 0.03, 0.0, 0.0}) {
      const Handle<Vec> u = rig.at(sink(depth)), carry = rig.layout.make_global();
      rig.contact.set_time(1, 7, true, {alpha_m / (2 * beta), alpha_m, gamma, rho == 1 ? 0.5 : 0});
      rig.contact.add_carried(1, carry);
      PetscReal size = 0;
      check(VecNorm(carry, NORM_1, &size));
      EXPECT_NEAR(size, std::abs(carried), 1e-12);
      rig.contact.advance(u, u, 0.5);
      rig.state.commit();
      const double force = 125 * depth,
                   Y = rho == 1 ? force : (force - (1 - 2 * beta) * carried) / (2 * beta);
      impulse += 0.5 * (rho == 1 ? force : gamma * Y + (1 - gamma) * carried);
      carried = Y;
      EXPECT_NEAR(rig.contact.measures(u).impulse[1], impulse, 1e-12);
    }
  }
}

TEST(ContactInterface, InitialOverlapIsAdjustedRefusedOrAllowedButRoundingIsNone) {
  TwoBlocks b;
  b.gap = -2e-4; // the tolerance is 1e-3 of the secondary facet, 2.5e-4
  ContactSettings s = settings_of(100);
  for (const auto& [name, partition] : partitions) {
    s.initial = InitialOverlap::adjust;
    Rig adjust(PETSC_COMM_WORLD, b, partition, s);
    const InitialOverlapReport report = adjust.contact.initial_overlap();
    EXPECT_EQ(report.nodes, 6) << name;
    EXPECT_NEAR(report.deepest, 2e-4, 1e-15);
    std::vector<double> expected(report.shift.size(), 0.0);
    for (int node : adjust.mesh.nodes("upper_bottom"))
      expected[static_cast<std::size_t>(2 * node + 1)] = 2e-4;
    for (std::size_t i = 0; i < expected.size(); ++i)
      EXPECT_NEAR(report.shift[i], expected[i], 1e-15) << name << i;

    s.initial = InitialOverlap::error;
    Rig refuse(PETSC_COMM_WORLD, b, partition, s);
    try {
      refuse.contact.initial_overlap();
      ADD_FAILURE() << "an overlap was accepted";
    } catch (const UserError& error) {
      EXPECT_EQ(error.code(), ExitCode::data);
      EXPECT_NE(std::string(error.what()).find("`upper_bottom` overlaps `lower_top` by 0.0002"),
                std::string::npos)
          << error.what();
    }
    s.initial = InitialOverlap::allow;
    Rig allow(PETSC_COMM_WORLD, b, partition, s);
    EXPECT_EQ(allow.contact.initial_overlap().nodes, 0);
  }
  s.initial = InitialOverlap::adjust;
  TwoBlocks deep = b;
  deep.gap = -3e-4;
  Rig too_deep(PETSC_COMM_WORLD, deep, bodies_mixed, s);
  EXPECT_THROW(too_deep.contact.initial_overlap(), UserError);
  s.initial = InitialOverlap::error;
  TwoBlocks touching = b;
  touching.gap = -1e-15;
  touching.angle = 0.7;
  Rig touch(PETSC_COMM_WORLD, touching, bodies_mixed, s);
  EXPECT_EQ(touch.contact.initial_overlap().nodes, 0);
}

TEST(ContactInterface, AutomaticValuesAndWarningsAreStated) {
  ContactSettings s = settings_of(ContactSettings::automatic);
  s.method = ContactMethod::automatic;
  ContactEnvironment environment;
  environment.modulus = 70;
  Rig rig(PETSC_COMM_WORLD, {}, bodies_mixed, s, environment);
  EXPECT_EQ(rig.contact.settings().method, ContactMethod::mortar);
  EXPECT_EQ(rig.contact.settings().multipliers, MultiplierSpace::standard);
  EXPECT_EQ(rig.contact.settings().enforce, Enforcement::semismooth);
  EXPECT_NEAR(rig.contact.settings().penalty, 10 * 70 / 0.25, 1e-9);
  EXPECT_NEAR(rig.contact.settings().penalty_max, 1e5 * 70 / 0.25, 1e-4);
  EXPECT_NEAR(rig.contact.settings().gap_tol, 2.5e-4, 1e-15);
  EXPECT_NEAR(rig.contact.settings().search_radius, 0.6, 1e-12);
  EXPECT_TRUE(rig.contact.settings().local_search);
  EXPECT_TRUE(rig.contact.warnings().empty());
  s.method = ContactMethod::gauss_points;
  s.search_radius = 0.5;
  const Rig points(PETSC_COMM_WORLD, {}, bodies_mixed, s, environment);
  EXPECT_EQ(points.contact.settings().enforce, Enforcement::auglag);
  EXPECT_FALSE(points.contact.settings().local_search);
  TwoBlocks fine;
  fine.lower_cells = 40; // facets of 0.0525 under points 0.125 apart
  Rig slips(PETSC_COMM_WORLD, fine, bodies_mixed);
  ASSERT_EQ(slips.contact.warnings().size(), 1U);
  EXPECT_NE(slips.contact.warnings()[0].find("shorter than the spacing"), std::string::npos);
  s = settings_of(100);
  s.method = ContactMethod::automatic; // mean gaps: nothing slips between points
  EXPECT_TRUE(Rig(PETSC_COMM_WORLD, fine, bodies_mixed, s).contact.warnings().empty());
}

TEST(ContactInterface, WrongSettingsAreRefusedOnAllRanks) {
  auto refused = [](const ContactSettings& s) {
    try {
      Rig rig(PETSC_COMM_WORLD, {}, bodies_apart, s);
    } catch (const UserError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  ContactSettings s = settings_of(100);
  s.primary = "lower_top_";
  EXPECT_NE(refused(s).find("no boundary `lower_top_` in the mesh; boundaries are: lower_top, upper_bottom"),
            std::string::npos);
  EXPECT_NE(refused(settings_of(ContactSettings::automatic)).find("-contact_pair_penalty"),
            std::string::npos);
  EXPECT_NE(refused(settings_of(-1)).find("-contact_pair_penalty: -1"), std::string::npos);
  s = settings_of(100);
  s.points = 17;
  EXPECT_NE(refused(s).find("-contact_pair_points 17"), std::string::npos);
  s.points = 3;
  s.method = ContactMethod::mortar;
  EXPECT_NE(refused(s).find("-contact_pair_points: Gauss points are for the method gpts"), std::string::npos);
  s = settings_of(100);
  s.multipliers = MultiplierSpace::dual;
  EXPECT_NE(refused(s).find("-contact_pair_multipliers: shape functions are for"), std::string::npos);
  EXPECT_EQ(refused(settings_of(100)), "accepted");
}

TEST(ContactInterface, DisplacementThatIsNotANumberLeavesTheListAlone) {
  Rig rig(PETSC_COMM_WORLD, {}, bodies_apart);
  const auto before = rig.contact.couplings();
  const Handle<Vec> u = rig.at([](int body, double, double) {
    return std::array<double, 2>{0, body / 0.0 * 0.0};
  });
  EXPECT_FALSE(rig.contact.update_search(u));
  EXPECT_EQ(rig.contact.couplings(), before);
}

TEST(ContactInterface, AStabilisedStepHasNoMomentAboutItsMiddleAndItsExactTangent) {
  for (const auto& [name, partition] : partitions)
    for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar}) {
      SCOPED_TRACE(testing::Message() << name << ", mortar " << (method == ContactMethod::mortar));
      ContactSettings s = settings_of(100);
      s.method = method;
      s.enforce = Enforcement::auglag;
      Rig rig(PETSC_COMM_WORLD, hill(), partition, s);
      rig.add_displacement();
      const Handle<Vec> start = rig.at(crush);
      rig.layout.to_local(start, rig.state.row("u").trial);
      rig.contact.update_search(start);
      rig.contact.augment(start);
      rig.contact.advance(start, start, 0);
      rig.state.commit();
      const Handle<Vec> u = rig.at([](int body, double X, double Y) {
        const std::array<double, 2> d = crush(body, X, Y);
        const double x = X + d[0] + (body == 1 ? 0.005 : 0), y = Y + d[1], c = std::cos(0.3),
                     sine = std::sin(0.3);
        return std::array<double, 2>{c * x - sine * y - X, sine * x + c * y - Y};
      });
      rig.contact.set_time(1, 1, true);
      rig.contact.update_search(u);
      // Forces at the end of the step, moments about its middle; for the projection, about its start.
      for (const bool projection : {false, true}) {
        if (projection) { // whose multipliers start from zero; here forces are wanted
          std::vector<double>& multipliers = rig.state.row("contact_pair_multiplier").trial;
          const std::vector<double> kept = multipliers;
          rig.contact.begin_projection();
          multipliers = kept;
        }
        const NodeValues force = node_map(rig.mesh, rig.layout, rig.residual(u)),
                         before = node_map(rig.mesh, rig.layout, start),
                         after = node_map(rig.mesh, rig.layout, u);
        std::array<double, 3> sum{};
        double size = 0;
        for (const auto& [key, f] : force) {
          const double part = projection ? 0 : 0.5;
          std::array<double, 2> x = {key[1], key[2]};
          for (std::size_t k = 0; k < 2; ++k) {
            x[k] += (1 - part) * before.at(key)[k] + part * after.at(key)[k];
            sum[k] += f[k];
            size += std::abs(f[k]);
          }
          sum[2] += x[0] * f[1] - x[1] * f[0];
        }
        ASSERT_GT(size, 1);
        for (const double total : sum) EXPECT_LE(std::abs(total), 1e-12 * size);
        const Handle<Mat> K = consistent_tangent(rig, u);
        PetscBool symmetric = PETSC_TRUE;
        check(MatIsTranspose(K, K, 1e-6, &symmetric));
        EXPECT_EQ(symmetric == PETSC_TRUE, projection);
      }
      rig.contact.end_projection();
      rig.contact.constraints().keep_symmetric(true);
      const Handle<Mat> K = tangent(rig, u, 1);
      PetscBool symmetric = PETSC_FALSE;
      check(MatIsTranspose(K, K, 1e-9, &symmetric));
      EXPECT_TRUE(symmetric);
    }
}
