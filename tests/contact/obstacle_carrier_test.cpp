#include "../mesh/box_mesh.hpp"
#include "../mesh/small_mesh.hpp"
#include <cmath>
#include <gtest/gtest.h>
#include <impact/contact/interface.hpp>
#include <impact/math/rotation.hpp>

/// Contact of a box with a rigid obstacle that a body of the mesh carries.
namespace impact {
namespace {

struct Case {
  std::string shape;
  Shape cell = Shape::quad4;
  ContactMethod method = ContactMethod::mortar;
  double friction = 0;
  MultiplierSpace multipliers = MultiplierSpace::automatic;

  int dim() const { return dimension(cell); }
  std::string text() const {
    return shape + ", " + std::to_string(dim()) + "D, " +
           (method == ContactMethod::mortar ? "mortar" : "points") + ", friction " + std::to_string(friction);
  }
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const char* shape : {"plane", "rigid_sphere", "rigid_cylinder"})
    for (const Shape cell : {Shape::quad4, Shape::hex8, Shape::tet4})
      for (const ContactMethod method : {ContactMethod::gauss_points, ContactMethod::mortar})
        for (const double friction : {0.0, 0.4}) {
          const Case c = {shape, cell, method, friction};
          const bool plane = c.shape == "plane", points = method == ContactMethod::gauss_points;
          if (cell == Shape::quad4 && c.shape == "rigid_sphere") continue; // a cylinder there
          if (cell == Shape::quad4 && !plane && points && friction > 0) continue;
          all.push_back(c);
        }
  return all;
}

// The box with its whole boundary above the obstacle, which stands under it.
struct CarriedRig {
  Case c;
  Mesh mesh;
  FieldLayout layout;
  StateTable state;
  StateRow* row;
  ContactInterface contact;

  CarriedRig(const Case& of, const ContactSettings& settings, double density = 1)
      : c(of), mesh(make_mesh(c)), layout(mesh, "u", c.dim()),
        row(&state.add(StateRow{"u", Support::vertex, c.dim()},
                       static_cast<std::size_t>(c.dim() * mesh.node_count()))),
        contact(mesh, layout, settings, environment(c, density), state) {}

  static std::array<double, 3> centre(const Case& c) {
    return {0.45, c.shape == "plane" ? 0.03 : -1.96, c.dim() == 3 ? 0.55 : 0};
  }
  static Mesh make_mesh(const Case& c) {
    const std::string dir = run_test::fresh_dir("obstacle_carrier");
    on_rank_zero(PETSC_COMM_WORLD, [&] {
      std::ofstream(dir + "/mesh.msh") << run_test::box_mesh(c.cell, c.dim() == 2 ? 6 : 3);
    });
    MeshRequest request;
    request.file = dir + "/mesh.msh";
    request.refine = c.cell == Shape::tet4 ? 1 : 0; // more nodes than the carrier needs
    request.add = [&](int dim, const std::array<double, 6>&) {
      const std::array<double, 3> x = centre(c);
      AddedCell cell{"obstacle", {x, x, x}};
      if (dim == 3) cell.corner.push_back(x);
      for (std::size_t b = 0; b < cell.corner.size(); ++b) {
        const double at = 2.1 * static_cast<double>(b);
        cell.corner[b][0] += 0.5 * std::cos(at) + 0.1;
        cell.corner[b][1] += 0.5 * std::sin(at);
        if (dim == 3) cell.corner[b][2] += b == 3 ? 0.6 : 0;
      }
      return std::vector<AddedCell>{cell};
    };
    return read_mesh(PETSC_COMM_WORLD, request);
  }
  static ContactSettings settings_of(const Case& c) {
    ContactSettings s;
    s.id = "foot";
    s.secondary = "boundary";
    s.primary = c.shape;
    s.method = c.method;
    s.friction = c.friction;
    s.multipliers = c.multipliers;
    s.enforce = Enforcement::penalty;
    s.penalty = 100;
    s.initial = InitialOverlap::allow;
    s.carrier = "obstacle";
    const std::array<double, 3> x = centre(c);
    for (std::size_t k = 0; k < 3; ++k) s.centre[k] = s.plane_point[k] = x[k];
    s.radius = 2;
    const double tilt[3] = {0.05, 1, c.dim() == 3 ? 0.1 : 0}, axis[3] = {0.2, 0.1, 1};
    std::copy(tilt, tilt + 3, s.plane_normal);
    std::copy(axis, axis + 3, s.axis);
    return s;
  }
  static ContactEnvironment environment(const Case& c, double density) {
    ContactEnvironment e;
    e.frame = c.dim() == 3 ? Frame::solid : Frame::plane_strain;
    e.density = density;
    return e;
  }
  // The box bends, the obstacle turns and moves; local [node][dim].
  std::vector<double> motion(double size) const {
    const auto d = static_cast<std::size_t>(c.dim());
    std::vector<double> u = layout.make_local();
    const auto X = mesh.coordinates();
    for (std::size_t node = 0; node < u.size() / d; ++node) {
      const double x = X[d * node], y = X[d * node + 1], z = d == 3 ? X[d * node + 2] : 0;
      u[d * node] = size * (0.3 * y + 0.1 * x);
      u[d * node + 1] = -size * (0.1 + 0.1 * std::cos(3 * x + z));
      if (d == 3) u[d * node + 2] = size * (0.2 * y - 0.1 * x);
    }
    const Matrix3 R = rotation_of({d == 3 ? 0.2 * size : 0, d == 3 ? -0.3 * size : 0, 0.4 * size});
    const std::array<double, 3> centre = this->centre(c);
    for (int node : mesh.nodes("obstacle")) {
      Vector3 Y{};
      for (std::size_t k = 0; k < d; ++k) Y[k] = X[d * static_cast<std::size_t>(node) + k] - centre[k];
      const Vector3 r = R * Y;
      for (std::size_t k = 0; k < d; ++k)
        u[d * static_cast<std::size_t>(node) + k] = r[k] - Y[k] + (k == 1 ? 0.05 : -0.1) * size;
    }
    return u;
  }
  Handle<Vec> global(const std::vector<double>& local) const {
    Handle<Vec> u = layout.make_global();
    layout.to_global(local, u);
    return u;
  }
  Handle<Vec> wiggle() const {
    std::vector<double> u = layout.make_local();
    const auto X = mesh.coordinates();
    const auto d = static_cast<std::size_t>(c.dim());
    for (std::size_t i = 0; i < u.size(); ++i)
      u[i] = std::sin(5 * X[d * (i / d)] - 3 * X[d * (i / d) + 1] + 2 * static_cast<double>(i % d));
    return global(u);
  }
  Handle<Vec> residual(Vec u) const {
    Handle<Vec> r = layout.make_global();
    contact.add_residual(u, 1, r);
    return r;
  }
};

double norm(Vec v) {
  double n = 0;
  check(VecNorm(v, NORM_2, &n));
  return n;
}

// Steps from a state that is turned already to one that is turned farther: without inertia, stabilised,
// energy-conserving. `from`: where they start, the end being at 0.5.
enum class Rule { still, stabilised, conserving };

template <class From, class Body> void for_each_step(From&& from, Body&& body) {
  for (const Case& c : cases())
    for (const Rule rule : {Rule::still, Rule::stabilised, Rule::conserving}) {
      ContactSettings settings = CarriedRig::settings_of(c);
      if (rule == Rule::conserving) settings.impact = ImpactUpdate::conserving;
      CarriedRig rig(c, settings);
      rig.row->committed = rig.motion(from(c, rule));
      rig.contact.set_time(1, rule == Rule::still ? 0 : 7, rule == Rule::stabilised);
      const std::vector<double> now = rig.motion(0.5);
      const Handle<Vec> u = rig.global(now);
      rig.contact.update_search(u);
      SCOPED_TRACE(c.text() + ", step " + std::to_string(static_cast<int>(rule)));
      EXPECT_GT(rig.contact.measures(u).active, 2);
      body(rig, rule, now, u);
    }
}

} // namespace

TEST(ObstacleCarrier, TangentsAreTheDerivativesOfTheForcesOnBothSides) {
  // What is measured along gradients at the middle of a step, slips and the gaps of the conserving update,
  // has a tangent that is exact for short steps.
  const auto from = [](const Case& c, Rule rule) {
    const bool at_end = rule == Rule::still || (rule == Rule::stabilised && c.friction == 0);
    return at_end ? 0.25 : 0.5 - 1e-8;
  };
  for_each_step(from, [](CarriedRig& rig, Rule, const std::vector<double>&, Vec u) {
    const Handle<Vec> d = rig.wiggle(), product = rig.layout.make_global(), at = rig.layout.make_global();
    rig.contact.multiply(u, 1, d, product);
    const double h = 1e-7;
    check(VecWAXPY(at, h, d, u));
    const Handle<Vec> difference = rig.residual(at);
    check(VecWAXPY(at, -h, d, u));
    const Handle<Vec> lower = rig.residual(at);
    check(VecAXPY(difference, -1, lower));
    check(VecScale(difference, 1 / (2 * h)));
    check(VecAXPY(difference, -1, product));
    EXPECT_GT(norm(product), 1);
    EXPECT_LE(norm(difference), 1e-6 * norm(product));
  });
}

TEST(ObstacleCarrier, ForcesAndMomentsOnBothSidesBalance) {
  const auto far = [](const Case&, Rule) { return 0.25; };
  for_each_step(far, [](CarriedRig& rig, Rule rule, const std::vector<double>& now, Vec u) {
    const auto d = static_cast<std::size_t>(rig.c.dim());
    const Handle<Vec> r = rig.residual(u);
    std::vector<double> force = rig.layout.make_local();
    rig.layout.to_local(r, force);
    const auto X = rig.mesh.coordinates();
    std::array<double, 7> sum{}; // force, moment, size
    for (std::size_t node = 0; node < force.size() / d; ++node) {
      if (!rig.mesh.owned(static_cast<int>(node))) continue;
      Vector3 f{}, x{};
      for (std::size_t k = 0; k < d; ++k) {
        const std::size_t i = d * node + k;
        f[k] = force[i];
        x[k] = X[i] + (rule == Rule::still ? now[i] : (now[i] + rig.row->committed[i]) / 2);
        sum[k] += f[k];
      }
      const Vector3 moment = cross(x, f);
      for (std::size_t k = 0; k < 3; ++k) sum[3 + k] += moment[k];
      sum[6] += std::abs(f[1]);
    }
    MPI_Allreduce(MPI_IN_PLACE, sum.data(), 7, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_GT(sum[6], 0.1);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(sum[k], 0, 1e-13 * sum[6]) << k;
  });
}

TEST(ObstacleCarrier, StandsWhereTheBodyCarriesIt) {
  Case c;
  c.shape = "rigid_cylinder";
  c.cell = Shape::hex8;
  const CarriedRig rig(c, CarriedRig::settings_of(c));
  const RigidObstacle at_rest = {RigidObstacle::Shape::cylinder, CarriedRig::centre(c), {0.6, 0, 0.8}, 2};
  Obstacle carrier(rig.mesh, "obstacle", at_rest);
  ASSERT_EQ(carrier.nodes().size(), 4U);
  carrier.locate(rig.contact.nodes());
  const std::vector<double> u = rig.contact.nodes().displacement(rig.global(rig.motion(1)));
  const RigidObstacle now = carrier.at(u);
  const Vector3 turned = rotation_of({0.2, -0.3, 0.4}) * Vector3{0.6, 0, 0.8};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(now.direction[k], turned[k], 1e-14);
    EXPECT_NEAR(now.point[k], CarriedRig::centre(c)[k] + (k == 1 ? 0.05 : -0.1), 1e-14);
  }
}

} // namespace impact
