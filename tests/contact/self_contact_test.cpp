#include "contact_rig.hpp"
#include "two_bricks.hpp"
#include <impact/contact/self_contact.hpp>

using namespace impact;
using namespace impact::contact_test;

namespace {

FacetShape edge(double x0, double y0, double x1, double y1, int body = 0) {
  return facet_shape(2, {x0, y0, 0, x1, y1, 0, x1, y1, 0, x1, y1, 0}, body);
}

// Outline of a strip of length 4 and height 0.5, bent to a hairpin when `closed` is 0: edges of 0.25, body to
// the left.
std::vector<FacetShape> strip() {
  std::vector<FacetShape> outline;
  for (int i = 0; i < 16; ++i) {
    outline.push_back(edge(0.25 * i, 0, 0.25 * (i + 1), 0));
    outline.push_back(edge(0.25 * (i + 1), 0.5, 0.25 * i, 0.5));
  }
  return outline;
}

ContactSettings one_name(ContactMethod method, Enforcement enforce) {
  ContactSettings s = settings_of(100);
  s.secondary = s.primary = "skin";
  s.method = method;
  s.enforce = enforce;
  return s;
}

// The skin of blocks or bricks under one name, against the two sides by their names.
struct Choice {
  ContactMethod method;
  Enforcement enforce;
};
const std::vector<Choice> choices = {{ContactMethod::gauss_points, Enforcement::penalty},
                                     {ContactMethod::gauss_points, Enforcement::auglag},
                                     {ContactMethod::mortar, Enforcement::penalty},
                                     {ContactMethod::mortar, Enforcement::auglag}};

} // namespace

TEST(SelfContact, NeighboursAndTheOtherSideOfABodyMayNotTouch) {
  const FacetShape a = edge(0, 0, 1, 0);
  EXPECT_NEAR(a.normal[1], -1, 1e-15);
  EXPECT_NEAR(a.size, 1, 1e-15);
  EXPECT_FALSE(SelfContact::may_touch(a, edge(2, 0, 3, 0), 4));   // the next but one
  EXPECT_TRUE(SelfContact::may_touch(a, edge(3, 0, 4, 0), 4));    // farther along
  EXPECT_TRUE(SelfContact::may_touch(a, edge(2, 0, 3, 0, 1), 4)); // another body
  const FacetShape behind = edge(1, 0.5, 0, 0.5), before = edge(1, -0.5, 0, -0.5);
  EXPECT_FALSE(SelfContact::may_touch(a, behind, 4));
  EXPECT_TRUE(SelfContact::may_touch(a, behind, 0.4)); // not within reach
  EXPECT_TRUE(SelfContact::may_touch(a, before, 4));   // across a slit
  EXPECT_TRUE(SelfContact::may_touch(a, edge(1, 0, 0, 0), 4));
  EXPECT_NEAR(SelfContact::thickness(a, behind), 0.5, 1e-15);
  EXPECT_TRUE(std::isinf(SelfContact::thickness(a, before)));
  EXPECT_TRUE(std::isinf(SelfContact::thickness(a, edge(1, 0.5, 0, 0.5, 1))));
  EXPECT_TRUE(std::isinf(SelfContact::thickness(a, edge(4, 0.5, 3, 0.5)))); // not over it
}

TEST(SelfContact, ExactlyOneFacetOfAPairIsSecondaryWhateverTheTurn) {
  const std::vector<FacetShape> outline = strip();
  const SelfContact rule(PETSC_COMM_SELF, 2, outline);
  for (std::size_t i = 0; i < outline.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_NE(rule.is_secondary(outline[i], outline[j]), rule.is_secondary(outline[j], outline[i]));
  for (const double angle : {0.3, 1.1, 2.9, 4.6}) {
    const double c = std::cos(angle), s = std::sin(angle);
    std::vector<FacetShape> turned = outline;
    for (FacetShape& f : turned) {
      f.centre = {c * f.centre[0] - s * f.centre[1] + 3, s * f.centre[0] + c * f.centre[1], 0};
      f.normal = {c * f.normal[0] - s * f.normal[1], s * f.normal[0] + c * f.normal[1], 0};
    }
    // The strip looks the same after half a turn: one answer for all pairs is the same or the opposite.
    const SelfContact other(PETSC_COMM_SELF, 2, turned);
    int same = 0, pairs = 0;
    for (std::size_t i = 0; i < outline.size(); ++i)
      for (std::size_t j = 0; j < i; ++j, ++pairs)
        same += rule.is_secondary(outline[i], outline[j]) == other.is_secondary(turned[i], turned[j]) ? 1 : 0;
    EXPECT_TRUE(same == pairs || same == 0) << angle << ": " << same << " of " << pairs;
  }
}

TEST(SelfContact, AFoldedSideAndASlitHaveOneSecondarySideEach) {
  const std::vector<FacetShape> outline = strip();
  const SelfContact rule(PETSC_COMM_SELF, 2, outline);
  // The strip folded in the middle: lower edges i and 15 - i meet.
  int first = 0;
  for (std::size_t i = 0; i < 7; ++i)
    first += rule.is_secondary(outline[2 * i], outline[2 * (15 - i)]) ? 1 : 0;
  EXPECT_TRUE(first == 0 || first == 7) << first;
  // A slit at any angle: edges on one side against those on the other, whose centres hardly differ.
  for (double angle = 0; angle < 3.2; angle += 0.1) {
    const double c = std::cos(angle), s = std::sin(angle);
    int upper = 0;
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < 3; ++j) {
        const double shift = i + 0.4 * (j - 1);
        upper += rule.is_secondary(edge(c * i, s * i, c * (i + 1), s * (i + 1)),
                                   edge(c * (shift + 1), s * (shift + 1), c * shift, s * shift))
                     ? 1
                     : 0;
      }
    EXPECT_TRUE(upper == 0 || upper == 30) << angle << ": " << upper;
  }
}

TEST(SelfContact, ASkinUnderOneNameActsAsOneOfTheTwoSidesByTheirNames) {
  for (const Choice& choice : choices)
    for (const auto& [name, partition] : partitions)
      for (const double angle : {0.0, 0.9, 2.2}) {
        TwoBlocks b;
        b.angle = angle;
        Rig skin(PETSC_COMM_WORLD, b, partition, one_name(choice.method, choice.enforce));
        const Handle<Vec> u = skin.at(crush);
        skin.contact.update_search(u);
        const Handle<Vec> r = skin.residual(u);
        double least = 1e300;
        for (const bool swapped : {false, true}) {
          ContactSettings s = one_name(choice.method, choice.enforce);
          s.secondary = swapped ? "lower_top" : "upper_bottom";
          s.primary = swapped ? "upper_bottom" : "lower_top";
          Rig named(PETSC_COMM_WORLD, b, partition, s);
          named.contact.update_search(u);
          Handle<Vec> difference = named.residual(u);
          const double size = norm(difference);
          EXPECT_GT(size, 0.5);
          check(VecAXPY(difference, -1, r));
          least = std::min(least, norm(difference) / size);
        }
        EXPECT_LT(least, 1e-12) << name << angle << " " << static_cast<int>(choice.method);
      }
}

TEST(SelfContact, FrictionUnderOneNameIsThatOfTheTwoSidesByTheirNames) {
  const Motion slid = [](int body, double X, double Y) {
    std::array<double, 2> u = crush(body, X, Y);
    if (body == 1) u = {u[0] + 0.15 * (X - 0.9), u[1] + 0.0015 * X};
    return u;
  };
  for (const Choice& choice : choices)
    for (const auto& [name, partition] : partitions)
      for (const double angle : {0.0, 2.2}) {
        SCOPED_TRACE(testing::Message()
                     << name << ", " << angle << ", mortar " << (choice.method == ContactMethod::mortar));
        TwoBlocks b;
        b.angle = angle;
        // Force and heat of a step from `crush` to `slid`.
        const auto step = [&, &partition = partition](const std::string& secondary,
                                                      const std::string& primary) {
          ContactSettings s = one_name(choice.method, choice.enforce);
          s.secondary = secondary;
          s.primary = primary;
          s.friction = 0.4;
          Rig rig(PETSC_COMM_WORLD, b, partition, s);
          const Handle<Vec> start = rig.at(crush), again = rig.at(crush), u = rig.at(slid);
          rig.contact.update_search(start);
          if (choice.enforce == Enforcement::auglag) rig.contact.augment(start);
          rig.contact.advance(start, again, 0);
          rig.state.commit();
          rig.contact.update_search(u);
          return std::pair(rig.residual(u), rig.contact.step(u).friction_loss);
        };
        const auto [force, heat] = step("skin", "skin");
        EXPECT_GT(heat, 1e-4);
        std::array<double, 2> off{}, lost{};
        for (const bool swapped : {false, true}) {
          auto [difference, named] =
              swapped ? step("lower_top", "upper_bottom") : step("upper_bottom", "lower_top");
          const double size = norm(difference);
          EXPECT_GT(size, 0.5);
          check(VecAXPY(difference, -1, force));
          off[swapped ? 1 : 0] = norm(difference) / size;
          lost[swapped ? 1 : 0] = std::abs(named - heat);
        }
        const std::size_t same = off[0] < off[1] ? 0 : 1;
        EXPECT_LT(off[same], 1e-12);
        EXPECT_LT(lost[same], 1e-13);
        EXPECT_GT(off[1 - same], 1e-6);
      }
}

TEST(SelfContact, TurningTheWholeProblemTurnsTheForces) {
  for (const Choice& choice : choices) {
    ContactMeasures straight;
    for (int degrees = 0; degrees <= 90; degrees += 9) {
      TwoBlocks b;
      b.angle = degrees * std::acos(-1.0) / 180;
      Rig rig(PETSC_COMM_WORLD, b, bodies_mixed, one_name(choice.method, choice.enforce));
      const Handle<Vec> u = rig.at(crush);
      rig.contact.update_search(u);
      const ContactMeasures m = rig.contact.measures(u);
      if (degrees == 0) straight = m;
      EXPECT_GT(m.active, 2);
      expect_turned(m, straight, b);
    }
  }
}

TEST(SelfContact, KeepsMomentaAndHasTheDerivativesOfItsEnergy) {
  for (const Choice& choice : choices) {
    Rig rig(PETSC_COMM_WORLD, hill(), bodies_mixed, one_name(choice.method, choice.enforce));
    const Handle<Vec> u = rig.at(crush);
    rig.contact.update_search(u);
    rig.contact.augment(u);
    consistent_tangent(rig, u);
    expect_force_of_the_energy(rig, u);
    const Resultants sum = resultants(rig, u);
    EXPECT_GT(sum.size, 1);
    EXPECT_NEAR(std::hypot(sum.force[0], sum.force[1]), 0, 1e-13 * sum.size);
    EXPECT_NEAR(sum.moment, 0, 1e-13 * sum.size);
  }
}

TEST(SelfContact, BodiesAtRestAndTurnedDoNotTouchThemselves) {
  for (const Choice& choice : choices) {
    TwoBlocks b;
    b.gap = 0.2;
    Rig rig(PETSC_COMM_WORLD, b, bodies_mixed, one_name(choice.method, choice.enforce));
    // Thin blocks with small cells, turned and bent: no part lies in another one.
    for (const double bend : {0.0, 0.8}) {
      const Handle<Vec> u = rig.at([bend](int, double X, double Y) {
        const double c = std::cos(0.7), s = std::sin(0.7), y = Y + bend * X * X / 2;
        return std::array<double, 2>{c * X - s * y - X, s * X + c * y - Y};
      });
      rig.contact.update_search(u);
      EXPECT_EQ(rig.contact.measures(u).active, 0);
      EXPECT_EQ(norm(rig.residual(u)), 0);
    }
  }
}

TEST(SelfContact, FacesUnderOneNameActAsOneOfTheTwoSidesByTheirNames) {
  const std::string dir = run_test::fresh_dir("self_contact_faces");
  for (const double angle : {0.0, 0.8, 2.3})
    for (const bool tets : {false, true}) {
      TwoBricks one{tets, false, angle, true, true};
      ContactSettings s = brick_settings();
      s.secondary = s.primary = "lower_top";
      BrickRig skin(PETSC_COMM_WORLD, dir, one, s);
      const Handle<Vec> u = skin.at(crush_bricks);
      skin.contact.update_search(u);
      const auto force = skin.by_place(skin.residual(u));
      std::array<double, 2> difference{};
      double size = 0;
      for (const std::size_t swapped : {0U, 1U}) {
        ContactSettings named = brick_settings();
        if (swapped == 1) std::swap(named.secondary, named.primary);
        BrickRig rig(PETSC_COMM_WORLD, dir, {tets, false, angle, true}, named);
        const Handle<Vec> v = rig.at(crush_bricks);
        rig.contact.update_search(v);
        for (const auto& [place, f] : rig.by_place(rig.residual(v))) {
          if (force.count(place) == 0) continue; // the mesh went to the ranks in another way
          for (std::size_t k = 0; k < 3; ++k) {
            difference[swapped] = std::max(difference[swapped], std::abs(f[k] - force.at(place)[k]));
            size = std::max(size, std::abs(f[k]));
          }
        }
      }
      MPI_Allreduce(MPI_IN_PLACE, difference.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
      MPI_Allreduce(MPI_IN_PLACE, &size, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
      EXPECT_GT(size, 0.1);
      EXPECT_LT(std::min(difference[0], difference[1]), 1e-12) << angle << tets;
    }
}
