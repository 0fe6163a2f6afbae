#include "../material/evaluate_point.hpp"
#include "../mesh/box_mesh.hpp"
#include "simulation_case.hpp"
#include <random>

// Manufactured solutions: a smooth displacement is chosen, the body force that makes it the solution follows
// from the law by dual numbers, and the error must fall with the square of the cell size, or its cube in
// cells of second order, and with the square of the time step.

namespace impact {
namespace {

using problem_test::condition;
using problem_test::Field;
using problem_test::MotionCase;
using run_test::box_mesh;

constexpr double pi = std::numbers::pi;

template <int n> Dual<double, n> sine(const Dual<double, n>& x) {
  return Dual<double, n>::chain(x, std::sin(x.v), std::cos(x.v));
}
template <int n> Dual<double, n> cosine(const Dual<double, n>& x) {
  return Dual<double, n>::chain(x, std::cos(x.v), -std::sin(x.v));
}

/// u_i = a sin(pi x_i) prod_{j != i} cos(pi x_j / 2)
template <int dim> double displacement(const double* x, double a, int i) {
  double u = a;
  for (int j = 0; j < dim; ++j) u *= j == i ? std::sin(pi * x[j]) : std::cos(pi * x[j] / 2);
  return u;
}

/// Div P at x.
template <int dim> Vector<double, dim> divergence(const PointLaw& law, const double* x, double a) {
  using T = Dual<double, dim>;
  T X[dim];
  for (int j = 0; j < dim; ++j) X[j] = seed<double, dim>(x[j], j);
  PointInput<T, dim> in;
  for (int k = 0; k < tensor_size(dim); ++k) in.H[k] = T(0.0);
  for (int k = 0; k < dim; ++k)
    for (int l = 0; l < dim; ++l) {
      T h(a);
      for (int j = 0; j < dim; ++j) {
        const T whole = pi * X[j], half = (pi / 2) * X[j];
        if (j == k && j == l)
          h *= pi * cosine(whole);
        else if (j == k)
          h *= sine(whole);
        else if (j == l)
          h *= (-pi / 2) * sine(half);
        else
          h *= cosine(half);
      }
      in.H[tensor_index(dim, k, l)] = h;
    }
  in.old = virgin_history<T, dim>();
  in.phi = T(0.0);
  in.theta = T(law.parameters.theta0);
  const PointResponse<T, dim> at = evaluate(law, in);
  const Tensor<T, dim> P = first_piola(at.tau, at.k.inverse_F);
  Vector<double, dim> sum{};
  for (int i = 0; i < dim; ++i)
    for (int j = 0; j < dim; ++j) sum[i] += P[tensor_index(dim, i, j)].d[j];
  return sum;
}

MaterialParameters soft_solid(Locking locking) {
  MaterialParameters law;
  law.K = 2;
  law.G = 1;
  law.rho = 1.5;
  law.locking = locking;
  return law;
}

using Amplitude = double (*)(double t);

template <int dim> std::vector<Field> motion(Amplitude amplitude) {
  std::vector<Field> u;
  for (int i = 0; i < dim; ++i)
    u.emplace_back(
        [i, amplitude](const double* x, double t) { return displacement<dim>(x, amplitude(t), i); });
  return u;
}

/// Body force per mass: acceleration - Div P / rho.
template <int dim>
std::vector<Field> body_force(const MaterialParameters& p, Amplitude amplitude, Amplitude acceleration) {
  std::vector<Field> b;
  for (int i = 0; i < dim; ++i)
    b.emplace_back([law = PointLaw{p}, i, amplitude, acceleration](const double* x, double t) {
      return displacement<dim>(x, acceleration(t), i) -
             divergence<dim>(law, x, amplitude(t))[i] / law.parameters.rho;
    });
  return b;
}

void print(const char* format, double a, double b, double c) {
  int rank = 0;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  if (rank == 0) std::printf(format, a, b, c);
}

using MakeMesh = std::function<Mesh(int n)>;

MakeMesh regular(Shape shape) {
  return [shape](int n) {
    return run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("manufactured"), box_mesh(shape, n));
  };
}

/// Straight edges between nodes moved by up to 15 % of the cell, alike on all ranks.
MakeMesh distorted(Shape shape) {
  return [shape](int n) {
    std::mt19937 random(7);
    const std::string text = box_mesh(linear(shape), n, [&](std::array<double, 3> x, bool inside) {
      std::uniform_real_distribution<double> shift(-0.15 / n, 0.15 / n);
      for (int k = 0; k < dimension(shape); ++k) {
        const double by = shift(random);
        if (inside) x[unsigned(k)] += by;
      }
      return x;
    });
    return run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("manufactured"), text, shape->order());
  };
}

/// Edges bent by a smooth map of the box, whose sides bend too.
MakeMesh curved(Shape shape) {
  return [shape](int n) {
    const std::string text = box_mesh(shape, n, [](std::array<double, 3> x, bool) {
      const auto bend = [&](double a, double b) { return 0.08 * std::sin(pi * a) * std::cos(pi * b); };
      return std::array<double, 3>{x[0] + bend(x[1], x[2]), x[1] + bend(x[0], x[2]), x[2]};
    });
    return run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("manufactured"), text);
  };
}

/// u with order `expected`, its gradient, hence the stress, with one less.
template <int dim>
void space_order(const MakeMesh& make, const std::array<int, 3>& meshes, Locking locking, const char* what,
                 double expected = 2) {
  const MaterialParameters law = soft_solid(locking);
  const Amplitude amplitude = [](double t) { return 0.1 * t; }, none = [](double) { return 0.; };
  const std::vector<Field> exact = motion<dim>(amplitude);
  double before = 0, slope_before = 0, order = 0, slope_order = 0;
  std::string text = what;
  for (std::size_t m = 0; m < 3; ++m) {
    MotionCase run(make(meshes[m]), law,
                   {condition("held", "boundary", BcType::displacement, exact),
                    condition("force", "solid", BcType::body_force, body_force<dim>(law, amplitude, none))},
                   {});
    run.run();
    const auto [error, size, slope] =
        problem_test::l2_error(run.discretisation().mesh, run.u(), dim, exact, 1);
    const double ratio = m == 0 ? 0 : std::log(double(meshes[m]) / meshes[m - 1]);
    order = m == 0 ? 0 : std::log(before / error) / ratio;
    slope_order = m == 0 ? 0 : std::log(slope_before / slope) / ratio;
    print(("  " + text + ", n = %.0f: L2 error %.3e, order %.3f").c_str(), meshes[m], error / size, order);
    print(" (reference %.0f), of the gradient %.3e, order %.3f\n", expected, slope, slope_order);
    before = error;
    slope_before = slope;
    if (m == 0) continue;
    EXPECT_GE(order, expected - 0.1) << what;
    EXPECT_LE(order, expected + 0.2) << what;
    EXPECT_GE(slope_order, expected - 1.1) << what;
  }
}

TEST(Manufactured, DisplacementConvergesWithOrderTwoOnQuadrilaterals) {
  space_order<2>(regular(Shape::quad4), {8, 16, 32}, Locking::none, "quad4");
  space_order<2>(regular(Shape::quad4), {8, 16, 32}, Locking::mean, "quad4, mean dilatation");
}
TEST(Manufactured, DisplacementConvergesWithOrderTwoOnTriangles) {
  space_order<2>(regular(Shape::tri3), {8, 16, 32}, Locking::none, "tri3");
}
TEST(Manufactured, DisplacementConvergesWithOrderTwoOnHexahedra) {
  space_order<3>(regular(Shape::hex8), {6, 9, 12}, Locking::none, "hex8");
}
TEST(Manufactured, DisplacementConvergesWithOrderTwoOnTetrahedra) {
  space_order<3>(regular(Shape::tet4), {6, 9, 12}, Locking::none, "tet4");
}
TEST(Manufactured, DisplacementConvergesWithOrderThreeOnSecondOrderTriangles) {
  space_order<2>(regular(Shape::tri6), {4, 8, 16}, Locking::none, "tri6", 3);
  space_order<2>(distorted(Shape::tri6), {4, 8, 16}, Locking::none, "tri6, distorted", 3);
  space_order<2>(curved(Shape::tri6), {4, 8, 16}, Locking::none, "tri6, curved", 3);
  space_order<2>(curved(Shape::tri6), {8, 16, 32}, Locking::mean, "tri6, mean dilatation", 2);
}
TEST(Manufactured, DisplacementConvergesWithOrderThreeOnSecondOrderTetrahedra) {
  space_order<3>(distorted(Shape::tet10), {3, 4, 6}, Locking::none, "tet10, distorted", 3);
  space_order<3>(curved(Shape::tet10), {3, 4, 6}, Locking::none, "tet10, curved", 3);
}

TEST(Manufactured, DisplacementConvergesWithOrderThreeOnSecondOrderQuadrilaterals) {
  space_order<2>(distorted(Shape::quad9), {4, 8, 16}, Locking::none, "quad9, distorted", 3);
  space_order<2>(curved(Shape::quad9), {4, 8, 16}, Locking::none, "quad9, curved", 3);
  space_order<2>(regular(Shape::quad8), {4, 8, 16}, Locking::none, "quad8", 3);
  space_order<2>(distorted(Shape::quad9), {4, 8, 16}, Locking::mean, "quad9, distorted, mean dilatation", 3);
  space_order<2>(curved(Shape::quad9), {4, 8, 16}, Locking::mean, "quad9, curved, mean dilatation", 3);
  space_order<2>(regular(Shape::quad8), {4, 8, 16}, Locking::mean, "quad8, mean dilatation", 3);
}
TEST(Manufactured, DisplacementConvergesWithOrderThreeOnSecondOrderHexahedra) {
  space_order<3>(distorted(Shape::hex27), {2, 4, 6}, Locking::none, "hex27, distorted", 3);
  space_order<3>(curved(Shape::hex27), {3, 4, 5}, Locking::none, "hex27, curved", 3);
  space_order<3>(regular(Shape::hex20), {3, 4, 5}, Locking::none, "hex20", 3);
  space_order<3>(curved(Shape::hex27), {3, 4, 5}, Locking::mean, "hex27, curved, mean dilatation", 3);
}

TEST(Manufactured, NewmarkConvergesWithOrderTwoInTime) {
  // The mesh stays: differences of successive solutions show the error in time alone.
  const MaterialParameters law = soft_solid(Locking::none);
  const Amplitude amplitude = [](double t) { return 0.1 * std::sin(2 * pi * t); },
                  acceleration = [](double t) { return -0.4 * pi * pi * std::sin(2 * pi * t); };
  const std::vector<Field> exact = motion<2>(amplitude);
  const std::vector<Field> start = motion<2>([](double) { return 0.2 * pi; });
  std::vector<std::vector<double>> u;
  for (const int steps : {10, 20, 40, 80}) {
    Mesh mesh =
        run_test::mesh_of(PETSC_COMM_WORLD, run_test::fresh_dir("manufactured"), box_mesh(Shape::quad4, 8));
    MotionCase run(
        std::move(mesh), law,
        {condition("held", "boundary", BcType::displacement, exact),
         condition("force", "solid", BcType::body_force, body_force<2>(law, amplitude, acceleration))},
        {.inertia = true, .dt = 0.4 / steps, .t_end = 0.4, .initial_velocity = start});
    run.run();
    ASSERT_EQ(run.iterations.size(), static_cast<std::size_t>(steps));
    u.push_back(run.u());
    const auto [error, size, slope] =
        problem_test::l2_error(run.discretisation().mesh, run.u(), 2, exact, 0.4);
    print("  %.0f steps: L2 distance from the exact solution %.3e (mesh included)%.0s\n", steps, error / size,
          0);
  }
  double difference[3] = {0, 0, 0};
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t i = 0; i < u[0].size(); ++i) difference[m] += std::pow(u[m + 1][i] - u[m][i], 2);
  MPI_Allreduce(MPI_IN_PLACE, difference, 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  for (std::size_t m = 1; m < 3; ++m) {
    const double order = std::log2(difference[m - 1] / difference[m]) / 2;
    print("  %.0f steps and its halves: order %.3f (reference 2)%.0s\n", m == 1 ? 20 : 40, order, 0);
    EXPECT_GE(order, 1.9);
    EXPECT_LE(order, 2.1);
  }
}

} // namespace
} // namespace impact
