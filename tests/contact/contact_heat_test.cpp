#include "contact_rig.hpp"
#include "two_bricks.hpp"
#include <impact/contact/contact_heat.hpp>

using namespace impact;
using namespace impact::contact_test;

namespace {

ContactSettings conducting(ContactMethod method) {
  ContactSettings s = settings_of(100);
  s.method = method;
  s.enforce = Enforcement::penalty;
  s.conductance = 5;
  s.conductance_exponent = 0.95;
  s.conductance_pressure = 2;
  return s;
}

// A temperature that jumps between the bodies, and is no polynomial on either.
template <class Rig> Handle<Vec> temperature(const Rig& rig, const FieldLayout& scalar, double phase) {
  std::vector<double> local = scalar.make_local();
  const auto X = rig.mesh.coordinates();
  const auto dim = static_cast<std::size_t>(rig.mesh.dim());
  for (std::size_t n = 0; n < local.size(); ++n)
    local[n] = 300 + 20 * std::sin(3 * X[dim * n] + phase) + 10 * X[dim * n + dim - 1];
  for (int node : rig.mesh.nodes("upper")) local[static_cast<std::size_t>(node)] += 40;
  Handle<Vec> theta = scalar.make_global();
  scalar.to_global(local, theta);
  return theta;
}

// Sums of a nodal vector over the upper body and over all.
template <class Rig> std::array<double, 2> sums(const Rig& rig, const FieldLayout& scalar, Vec r) {
  std::vector<double> local = scalar.make_local();
  scalar.to_local(r, local);
  std::array<double, 2> sum{};
  for (int node : rig.mesh.nodes("upper"))
    if (rig.mesh.owned(node)) sum[0] += local[static_cast<std::size_t>(node)];
  for (int node = 0; node < rig.mesh.node_count(); ++node)
    if (rig.mesh.owned(node)) sum[1] += local[static_cast<std::size_t>(node)];
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

// Linear in the temperature with a symmetric tangent that is not negative and leaves uniform temperatures
// alone; what one body loses the other gains.
template <class Rig> void expect_conduction(Rig& rig, Vec u) {
  const FieldLayout scalar(rig.mesh, "theta", 1);
  rig.contact.update_search(u);
  ContactHeat heat(rig.mesh, rig.contact);
  const Handle<Vec> one = temperature(rig, scalar, 0), other = temperature(rig, scalar, 2),
                    old = temperature(rig, scalar, 1), none = scalar.make_global();
  heat.begin(u, old, 0.3, 0.7, 0);
  const auto residual = [&](Vec theta) {
    Handle<Vec> r = scalar.make_global();
    heat.add_residual(theta, r);
    return r;
  };
  Handle<Mat> K;
  const PetscInt n = rig.mesh.owned_node_count();
  check(MatCreateAIJ(rig.mesh.comm(), n, n, PETSC_DETERMINE, PETSC_DETERMINE, 60, nullptr, 60, nullptr,
                     K.out()));
  check(MatSetOption(K, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  heat.add_tangent(none, K);
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));

  const Handle<Vec> r = residual(one), change = scalar.make_global(), Kd = scalar.make_global();
  const double size = norm(r);
  ASSERT_GT(size, 1);
  const std::array<double, 2> sum = sums(rig, scalar, r);
  EXPECT_LE(std::abs(sum[1]), 1e-12 * size);
  EXPECT_GT(sum[0], 1e-2 * size); // the upper body is the hotter one
  const ContactHeat::Heat booked = heat.book(one, none);
  EXPECT_NEAR(booked.conducted, -sum[0], 1e-12 * size); // and the secondary side
  EXPECT_EQ(booked.outside, 0);
  EXPECT_EQ(norm(none), 0);

  check(VecWAXPY(change, -1, other, one));
  check(MatMult(K, change, Kd));
  EXPECT_GT(dot(Kd, change), 1e-3 * norm(Kd) * norm(change));
  const Handle<Vec> second = residual(other);
  check(VecAXPY(second, -1, r));
  check(VecAXPY(second, 1, Kd));
  EXPECT_LE(norm(second), 1e-12 * size);
  PetscBool symmetric = PETSC_FALSE;
  check(MatIsSymmetric(K, 1e-14 * size, &symmetric));
  EXPECT_TRUE(symmetric);
  check(VecSet(change, 1));
  check(MatMult(K, change, Kd));
  EXPECT_LE(norm(Kd), 1e-13 * size);
  // With every node held nothing stands in the matrix.
  check(MatZeroEntries(K));
  heat.add_tangent(change, K);
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  check(MatMult(K, one, Kd));
  EXPECT_EQ(norm(Kd), 0);
}

} // namespace

TEST(ContactHeat, ConductsBetweenTheBodiesWithASymmetricTangent) {
  for (const auto& [name, partition] : partitions)
    for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar}) {
      SCOPED_TRACE(name);
      Rig rig(PETSC_COMM_WORLD, hill(), partition, conducting(method));
      const Handle<Vec> u = rig.at(crush);
      expect_conduction(rig, u);
    }
}

TEST(ContactHeat, ConductsInSpaceToo) {
  ContactSettings standard = conducting(ContactMethod::mortar), dual = standard;
  standard.multipliers = MultiplierSpace::standard;
  dual.multipliers = MultiplierSpace::dual;
  for (const ContactSettings& s : {standard, dual, conducting(ContactMethod::gauss_points)}) {
    BrickRig rig(PETSC_COMM_WORLD, run_test::fresh_dir("contact_heat"), {}, s);
    const Handle<Vec> u = rig.at(crush_bricks);
    expect_conduction(rig, u);
  }
}

TEST(ContactHeat, FollowsTheLawOfThePressure) {
  ContactSettings s = settings_of(100);
  EXPECT_EQ(s.conductance_at(3), 0);
  s.conductance = 8;
  EXPECT_EQ(s.conductance_at(0), 8);
  s.conductance_exponent = 0.5;
  s.conductance_pressure = 4;
  EXPECT_DOUBLE_EQ(s.conductance_at(1), 4);
  EXPECT_DOUBLE_EQ(s.conductance_at(16), 16);
}

// All that sliding makes enters the bodies, in the parts of the split, wherever the ranks meet.
TEST(ContactHeat, FrictionalHeatEntersBothBodiesInItsParts) {
  for (const auto& [name, partition] : partitions)
    for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar})
      for (const double split : {ContactSettings::automatic, 0.0, 0.7}) {
        SCOPED_TRACE(name);
        ContactSettings s = conducting(method);
        s.conductance = 0;
        s.friction = 0.4;
        s.friction_heat_split = split;
        Rig rig(PETSC_COMM_WORLD, hill(), partition, s);
        const Handle<Vec> start = rig.at(crush), again = rig.at(crush),
                          u = rig.at([](int body, double X, double Y) {
                            std::array<double, 2> place = crush(body, X, Y);
                            if (body == 1) place[0] += 0.15 * (X - 0.9);
                            return place;
                          });
        rig.contact.update_search(start);
        rig.contact.advance(start, again, 0);
        rig.state.commit();
        rig.contact.update_search(u);
        const FieldLayout scalar(rig.mesh, "theta", 1);
        ContactHeat heat(rig.mesh, rig.contact);
        const Handle<Vec> theta = temperature(rig, scalar, 0), r = scalar.make_global(),
                          none = scalar.make_global();
        heat.begin(u, theta, 0.3, 1, 0);
        heat.add_residual(theta, r);
        const double lost = rig.contact.step(u).friction_loss;
        ASSERT_GT(lost, 1e-3);
        const std::array<double, 2> sum = sums(rig, scalar, r);
        EXPECT_NEAR(sum[1], -lost, 1e-13 * lost);
        EXPECT_NEAR(sum[0], -(std::isnan(split) ? 0.5 : split) * lost, 1e-13 * lost);
        EXPECT_NEAR(heat.book(theta, none).friction, lost, 1e-13 * lost);
        EXPECT_TRUE(heat.couplings().empty()); // nothing is conducted
      }
}
