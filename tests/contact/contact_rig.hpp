#pragma once
#include "two_blocks.hpp"
#include <gtest/gtest.h>
#include <impact/contact/contact_set.hpp>

/// A contact between the two blocks with its mesh, layout and state, and displacements at which all kinds of
/// feet occur; for tests of the forms of contact.
namespace impact::contact_test {

/// Constraints at Gauss points; a test of another form says so.
inline ContactSettings settings_of(double penalty) {
  ContactSettings s;
  s.method = ContactMethod::gauss_points;
  s.id = "pair";
  s.secondary = "upper_bottom";
  s.primary = "lower_top";
  s.penalty = penalty;
  return s;
}

/// Mesh, layout, state and one contact. Everything collective on `comm`.
struct Rig {
  TwoBlocks blocks;
  Mesh mesh;
  FieldLayout layout;
  StateTable state;
  ContactInterface contact;

  Rig(MPI_Comm comm, const TwoBlocks& b, const Partition& partition,
      const ContactSettings& s = settings_of(100), ContactEnvironment environment = {})
      : blocks(b), mesh(make_blocks(comm, b, partition)), layout(mesh, "u", 2),
        contact(mesh, layout, s, with_frame(std::move(environment), b.frame), state) {}

  static ContactEnvironment with_frame(ContactEnvironment environment, Frame frame) {
    environment.frame = frame;
    return environment;
  }
  /// The row from which steps begin.
  void add_displacement() {
    state.add(StateRow{"u", Support::vertex, 2}, 2 * static_cast<std::size_t>(mesh.node_count()));
  }
  Handle<Vec> at(const Motion& motion) const { return displacement(mesh, layout, blocks, motion); }
  Handle<Vec> residual(Vec u, double scale = 1) const {
    Handle<Vec> r = layout.make_global();
    contact.add_residual(u, scale, r);
    return r;
  }
};

inline const Motion rest = [](int, double, double) { return std::array<double, 2>{0, 0}; };

inline Motion sink(double depth) {
  return [depth](int body, double, double) { return std::array<double, 2>{0, body == 1 ? -depth : 0}; };
}

// The blocks press into each other, bend and slide: all kinds of feet occur.
inline const Motion crush = [](int body, double X, double Y) {
  if (body == 0) return std::array<double, 2>{0.02 * Y, 0.03 * std::sin(3 * X)};
  return std::array<double, 2>{0.05 + 0.02 * X * Y, -0.04 + 0.02 * std::cos(5 * X)};
};

// The lower surface folds into a valley with a node at its bottom; points of the upper one stand in the wedge
// where the bottom itself is nearest.
inline const Motion valley = [](int body, double X, double Y) {
  if (body == 0) return std::array<double, 2>{0, 0.5 * std::abs(X - 0.9) * (Y + 0.6) / 0.6};
  return std::array<double, 2>{0.001 * std::sin(X), -0.1};
};

inline const Motion wiggle = [](int body, double X, double Y) {
  return std::array<double, 2>{std::sin(7 * X + 3 * Y + body), std::cos(4 * X - 5 * Y - 2 * body)};
};

inline double norm(Vec v) {
  double n = 0;
  check(VecNorm(v, NORM_2, &n));
  return n;
}

inline double dot(Vec a, Vec b) {
  double d = 0;
  check(VecDot(a, b, &d));
  return d;
}

inline double largest_difference(const NodeValues& a, const NodeValues& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (const auto& [key, value] : a) {
    const auto other = b.find(key);
    if (other == b.end()) return 1e300;
    for (std::size_t k = 0; k < 2; ++k) largest = std::max(largest, std::abs(value[k] - other->second[k]));
  }
  return largest;
}

inline Handle<Mat> dense_enough_matrix(const Rig& rig) {
  Handle<Mat> K;
  const PetscInt n = 2 * rig.mesh.owned_node_count();
  check(MatCreateAIJ(rig.mesh.comm(), n, n, PETSC_DETERMINE, PETSC_DETERMINE, 60, nullptr, 60, nullptr,
                     K.out()));
  check(MatSetOption(K, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  return K;
}

inline Handle<Mat> tangent(const Rig& rig, Vec u, double scale) {
  Handle<Mat> K = dense_enough_matrix(rig);
  rig.contact.add_tangent(u, scale, K);
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  return K;
}

/// The lower surface is a shallow hill.
inline TwoBlocks hill() {
  TwoBlocks b;
  b.bulge = true;
  return b;
}

/// The tangent at u, after checks that it is the derivative of the residual and what multiply multiplies by.
inline Handle<Mat> consistent_tangent(const Rig& rig, Vec u) {
  const Handle<Vec> d = rig.at(wiggle);
  Handle<Mat> K = tangent(rig, u, 1.5);
  const Handle<Vec> assembled = rig.layout.make_global(), free = rig.layout.make_global();
  check(MatMult(K, d, assembled));
  rig.contact.multiply(u, 1.5, d, free);
  const double size = norm(assembled), h = 1e-7;
  EXPECT_GT(size, 1);
  const Handle<Vec> up = rig.layout.make_global(), down = rig.layout.make_global();
  check(VecWAXPY(up, h, d, u));
  check(VecWAXPY(down, -h, d, u));
  const Handle<Vec> difference = rig.residual(up, 1.5), lower = rig.residual(down, 1.5);
  check(VecAXPY(difference, -1, lower));
  check(VecScale(difference, 1 / (2 * h)));
  check(VecAXPY(difference, -1, assembled));
  EXPECT_LE(norm(difference), 1e-6 * size);
  check(VecAXPY(free, -1, assembled));
  EXPECT_LE(norm(free), 1e-13 * size);
  return K;
}

/// Checks that the force at u is the derivative of the energy.
inline void expect_force_of_the_energy(Rig& rig, Vec u) {
  const Handle<Vec> d = rig.at(wiggle), moved = rig.layout.make_global();
  const double h = 1e-6;
  check(VecWAXPY(moved, h, d, u));
  const double up = rig.contact.measures(moved).energy;
  check(VecWAXPY(moved, -h, d, u));
  const double down = rig.contact.measures(moved).energy, slope = dot(rig.residual(u), d);
  EXPECT_GT(std::abs(slope), 0.1);
  EXPECT_NEAR((up - down) / (2 * h), slope, 1e-6 * std::abs(slope));
}

/// Sums over all nodes of the residual at u; `upper`: force on the upper body; `size`: sum of absolute
/// values.
struct Resultants {
  std::array<double, 2> force{}, upper{};
  double moment = 0, size = 0;
};
inline Resultants resultants(const Rig& rig, Vec u) {
  Resultants sum;
  const NodeValues force = node_map(rig.mesh, rig.layout, rig.residual(u)),
                   moved = node_map(rig.mesh, rig.layout, u);
  for (const auto& [key, f] : force) {
    const auto& d = moved.at(key);
    for (std::size_t k = 0; k < 2; ++k) {
      sum.force[k] += f[k];
      sum.size += std::abs(f[k]);
      if (key[0] > 0.5) sum.upper[k] -= f[k]; // the residual is minus the force on the body
    }
    sum.moment += (key[1] + d[0]) * f[1] - (key[2] + d[1]) * f[0];
  }
  return sum;
}

inline const std::vector<std::pair<const char*, Partition>> partitions = {{"apart", bodies_apart},
                                                                          {"mixed", bodies_mixed}};

/// The measures of a set-up that was turned by the angle of `b` are those of the straight one, its force
/// turned.
inline void expect_turned(const ContactMeasures& m, const ContactMeasures& straight, const TwoBlocks& b) {
  EXPECT_EQ(m.active, straight.active) << b.angle;
  EXPECT_NEAR(m.energy, straight.energy, 1e-10 * straight.energy) << b.angle;
  EXPECT_NEAR(m.gap_min, straight.gap_min, 1e-10) << b.angle;
  const auto turned = place(b, straight.force[0], straight.force[1]);
  EXPECT_NEAR(m.force[0], turned[0], 1e-10) << b.angle;
  EXPECT_NEAR(m.force[1], turned[1], 1e-10) << b.angle;
}

} // namespace impact::contact_test
