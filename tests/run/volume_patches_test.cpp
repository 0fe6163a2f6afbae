#include "../mesh/box_mesh.hpp"
#include <cmath>
#include <gtest/gtest.h>
#include <impact/balance/energies.hpp>
#include <impact/problem/motion.hpp>

// The volume that patches of linear triangles and tetrahedra share: force from an energy, exact tangent,
// objectivity.

namespace impact {
namespace {

using Field = std::function<double(const double* x, int i)>;

/// A body of distorted triangles or tetrahedra in patches, at some displacement, with some damage and some
/// temperature where its law has them.
struct Body {
  Discretisation d;
  StateTable state;
  BoundaryData boundary;
  ContactSet contacts;
  std::vector<double> phi, theta;
  MotionProblem motion;

  static Mesh mesh(Shape shape, bool off_axis) {
    const std::string text = run_test::box_mesh(shape, 3, [=](std::array<double, 3> x, bool) {
      return std::array{x[0] + 0.06 * x[1] * x[1] + (off_axis ? 0.3 : 0.0),
                        x[1] - 0.05 * x[0] * x[2] + 0.04 * x[0], x[2] * (1 + 0.07 * x[0] * x[1])};
    });
    return run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("patches"), text, 0, {{"solid"}});
  }
  StateTable& declared() {
    declare_state(d, state);
    return state;
  }
  Body(Shape shape, Frame frame, MaterialParameters law, MatrixFormat format = MatrixFormat::aij)
      : d(discretise(mesh(shape, frame == Frame::axisymmetric), {{PointLaw{law}, {"solid"}}},
                     frame == Frame::solid ? Frame::plane_strain : frame, 1)),
        boundary(d.mesh, {}, 1),
        phi(nodal([](const double* x, int) { return 0.2 + 0.15 * std::sin(5 * x[0] + x[1]); }, 1)),
        theta(nodal([](const double* x, int) { return 300 + 40 * x[1] * x[0]; }, 1)),
        motion(d, declared(), boundary, contacts, format == MatrixFormat::sbaij, ContactOperator::assembled,
               format) {
    MotionStep step;
    step.t = step.dt = 1;
    step.u_n = &state.row("u").committed;
    if (d.has_damage()) step.phi = &phi;
    if (d.has_heat()) step.theta = &theta;
    motion.begin(step);
  }
  std::vector<double> nodal(const Field& field, int components) const {
    std::vector<double> values;
    for (int n = 0; n < d.mesh.node_count(); ++n)
      for (int i = 0; i < components; ++i)
        values.push_back(field(&d.mesh.coordinates()[static_cast<std::size_t>(n * d.dim())], i));
    return values;
  }
  Handle<Vec> vector(const Field& field) const { return d.global_of(nodal(field, d.dim())); }
  Handle<Vec> force(Vec u) {
    Handle<Vec> f = d.displacement.make_global();
    EXPECT_TRUE(motion.residual(u, nullptr, f));
    return f;
  }
  double energy(Vec u) {
    StateRow* const row = d.has_damage() ? &state.row("phi") : nullptr;
    if (row) row->committed = phi;
    if (d.has_heat()) state.row("theta").committed = theta;
    return find_energies(d, BodyRows(state), u, nullptr, false).total.elastic;
  }
};

double some(const double* x, int i) {
  return 0.06 * std::sin(3 * x[0] + 2 * x[1] * (i + 1) + 1.3 * i) + 0.04 * x[(i + 1) % 2] * x[0];
}
double way(const double* x, int i) { return std::cos(7 * x[0] - 4 * x[1] + 2 * i) + 0.3 * i; }

Handle<Vec> moved(Vec u, double by, Vec along) {
  Handle<Vec> sum;
  check(VecDuplicate(u, sum.out()));
  check(VecWAXPY(sum, by, along, u));
  return sum;
}

MaterialParameters elastic() {
  MaterialParameters law;
  law.K = 40;
  law.G = 1;
  law.locking = Locking::mean;
  return law;
}
MaterialParameters warm_and_damaged() {
  MaterialParameters law = elastic();
  law.damage = Damage::at2;
  law.Gc = 0.1;
  law.gamma = 0.3;
  law.alpha_t = 1e-4;
  law.c_v = 1;
  law.theta0 = 293;
  return law;
}
MaterialParameters plastic() {
  MaterialParameters law = elastic();
  law.model = Model::j2;
  law.sigma_y = 0.05;
  law.linear_h = 0.1;
  return law;
}

const std::pair<Shape, Frame> cases[] = {
    {Shape::tri3, Frame::plane_strain}, {Shape::tri3, Frame::axisymmetric}, {Shape::tet4, Frame::solid}};

TEST(VolumePatches, TheTangentIsTheDerivativeOfTheForce) {
  for (const auto& [shape, frame] : cases)
    for (const MaterialParameters& law : {elastic(), warm_and_damaged(), plastic()}) {
      Body body(shape, frame, law);
      EXPECT_GT(body.d.patches.count(), 0);
      const Handle<Vec> u = body.vector(some), along = body.vector(way);
      ASSERT_TRUE(body.motion.tangent(u, 0));
      Handle<Vec> by_tangent = body.d.displacement.make_global();
      check(MatMult(body.motion.jacobian(), along, by_tangent));
      const double size = Get(VecNorm)(by_tangent, NORM_INFINITY), h = 1e-6;
      const Handle<Vec> up = body.force(moved(u, h, along)), down = body.force(moved(u, -h, along));
      check(VecAXPY(by_tangent, -0.5 / h, up));
      check(VecAXPY(by_tangent, 0.5 / h, down));
      EXPECT_LT(Get(VecNorm)(by_tangent, NORM_INFINITY), 1e-8 * size);
    }
}

// Of symmetric blocks all entries come back from half of them.
TEST(VolumePatches, SymmetricBlocksGiveTheSameProduct) {
  for (const auto& [shape, frame] : cases) {
    Body all(shape, frame, elastic()), half(shape, frame, elastic(), MatrixFormat::sbaij);
    const Handle<Vec> u = all.vector(some), along = all.vector(way);
    Handle<Vec> a = all.d.displacement.make_global(), b = all.d.displacement.make_global();
    ASSERT_TRUE(all.motion.tangent(u, 0) && half.motion.tangent(u, 0));
    check(MatMult(all.motion.jacobian(), along, a));
    check(MatMult(half.motion.jacobian(), along, b));
    check(VecAXPY(b, -1, a));
    EXPECT_LT(Get(VecNorm)(b, NORM_INFINITY), 1e-13 * Get(VecNorm)(a, NORM_INFINITY));
  }
}

TEST(VolumePatches, TheForceIsTheDerivativeOfTheEnergy) {
  for (const auto& [shape, frame] : cases)
    for (const MaterialParameters& law : {elastic(), warm_and_damaged()}) {
      MaterialParameters without_crack = law;
      without_crack.Gc *= 1e-12; // its energy is booked elsewhere
      Body body(shape, frame, without_crack);
      const Handle<Vec> u = body.vector(some), along = body.vector(way), f = body.force(u);
      const double h = 1e-6,
                   power = Get(VecDot)(f, along); // damage knows tension from compression: no fourth order
      const double slope = (body.energy(moved(u, h, along)) - body.energy(moved(u, -h, along))) / (2 * h);
      EXPECT_NEAR(slope, power, 1e-8 * std::abs(power));
    }
}

TEST(VolumePatches, TheForceTurnsWithTheBody) {
  const double c = std::cos(0.7), s = std::sin(0.7);
  for (const Shape shape : {Shape::tri3, Shape::tet4}) {
    Body body(shape, shape == Shape::tet4 ? Frame::solid : Frame::plane_strain, elastic());
    const Field turned = [&](const double* x, int i) { // Q (x + u) - x
      const double y[2] = {x[0] + some(x, 0), x[1] + some(x, 1)};
      return i == 2 ? some(x, 2) : i == 0 ? c * y[0] - s * y[1] - x[0] : s * y[0] + c * y[1] - x[1];
    };
    const std::vector<double> f = body.d.local_of(body.force(body.vector(some))),
                              g = body.d.local_of(body.force(body.vector(turned)));
    const auto dim = static_cast<std::size_t>(body.d.dim());
    for (std::size_t i = 0; i < f.size(); i += dim) {
      EXPECT_NEAR(g[i], c * f[i] - s * f[i + 1], 1e-12);
      EXPECT_NEAR(g[i + 1], s * f[i] + c * f[i + 1], 1e-12);
      if (dim == 3) {
        EXPECT_NEAR(g[i + 2], f[i + 2], 1e-12);
      }
    }
  }
}

} // namespace
} // namespace impact
