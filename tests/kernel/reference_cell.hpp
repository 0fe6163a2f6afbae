#pragma once
#include "../material/law_sampler.hpp"

#include <gtest/gtest.h>
#include <impact/element/second_order_products.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/kernel/shape.hpp>
#include <numbers>
#include <stdexcept>
#include <string_view>
#include <vector>

/// A plain scalar element around the plain law: one cell, dense tensors, any locking cure; T is double or
/// complex, so that forces can be compared with the complex step of the energy and tangents with that of the
/// force.
namespace impact {

/// The kernels that the program has for a cell.
template <class Cell, Frame frame> const CellKernels& kernels() {
  const Shape shape = find_shape(Cell::dim, Cell::names.polytope, Cell::nodes);
  if (shape == Shape()) throw std::logic_error(Cell::names.polytope);
  return shape.kernels(frame);
}

} // namespace impact

namespace reference {

using impact::Frame;
using impact::Locking;

/// Every shape of cell in the frames that it may stand in, for typed tests.
template <class C, Frame f> struct Element {
  using Cell = C;
  static constexpr Frame frame = f;
};
using Elements =
    testing::Types<Element<impact::Tri3, Frame::plane_strain>, Element<impact::Tri3, Frame::axisymmetric>,
                   Element<impact::Quad4, Frame::plane_strain>, Element<impact::Quad4, Frame::axisymmetric>,
                   Element<impact::Tet4, Frame::solid>, Element<impact::Hex8, Frame::solid>,
                   Element<impact::Tri6, Frame::plane_strain>, Element<impact::Tri6, Frame::axisymmetric>,
                   Element<impact::Tet10, Frame::solid>, Element<impact::Quad9, Frame::plane_strain>,
                   Element<impact::Quad9, Frame::axisymmetric>, Element<impact::Hex27, Frame::solid>,
                   Element<impact::Quad8, Frame::plane_strain>, Element<impact::Quad8, Frame::axisymmetric>,
                   Element<impact::Hex20, Frame::solid>>;

template <class Cell> inline constexpr int corners = Cell::nodes;
template <class Cell>
requires impact::is_second_order<Cell>
inline constexpr int corners<Cell> = Cell::Corners::nodes;

/// Node a of the cell with sides of length 1.
template <class Cell> std::array<double, 3> node_place(int a) {
  const auto xi = impact::place_of_node<Cell>(unsigned(a));
  constexpr bool simplex = corners<Cell> == Cell::dim + 1;
  std::array<double, 3> x{};
  for (unsigned k = 0; k < Cell::dim; ++k) x[k] = simplex ? xi[k] : (1 + xi[k]) / 2;
  return x;
}

/// Functions of the linear cell at the place of node a.
template <class Cell> auto corner_functions(int a) {
  const auto xi = impact::place_of_node<Cell>(unsigned(a));
  if constexpr (impact::is_second_order<Cell>)
    return Cell::Corners::N(xi);
  else
    return Cell::N(xi);
}

/// Values at random from 0 to `most` at the nodes leave that range between those of boxes of second order:
/// there the ones after the corners become near to the linear function of these.
template <class Cell> void hold_between_nodes(double* value, double most) {
  if (!impact::is_second_order<Cell> || corners<Cell> != 1 << Cell::dim) return;
  for (int a = corners<Cell>; a < Cell::nodes; ++a) {
    value[a] = (value[a] - most / 2) / 8;
    const auto N = corner_functions<Cell>(a);
    for (int b = 0; b < corners<Cell>; ++b) value[a] += N[unsigned(b)] * value[b];
  }
}

/// Aluminium with the k-th choice of locking cure, split, degradations, viscosity, damage gradient and
/// equation of state.
inline impact::MaterialParameters every_option(int k) {
  impact::MaterialParameters m = aluminium();
  m.locking = k % 3 == 0 ? Locking::mean : k % 3 == 1 ? Locking::fbar : Locking::none;
  m.split = k % 2 ? impact::Split::none : impact::Split::volumetric;
  m.gp = k % 4 < 2 ? impact::PlasticDegradation::one : impact::PlasticDegradation::ge;
  m.b_d = k % 5 < 2 ? 0 : 1e5;
  m.visc_degrade = k % 5 == 3;
  m.damage_gradient = k % 7 < 5 ? impact::DamageGradient::spatial : impact::DamageGradient::material;
  m.ge = k % 11 ? impact::Degradation::quadratic : impact::Degradation::cubic;
  if (k % 13 > 9) set_state(m, k % 2);
  return m;
}

/// Lumps a consistent mass M [node][node]: its row sums, or its diagonal with their sum.
template <class Cell> void lump(const impact::Batch* M, impact::Batch* mass) {
  constexpr int n = Cell::nodes;
  impact::Batch all = 0.0, diagonal = 0.0;
  for (int a = 0; a < n; ++a) {
    mass[a] = 0.0;
    for (int b = 0; b < n; ++b) mass[a] += M[a * n + b];
    all += mass[a];
    diagonal += M[a * n + a];
  }
  for (int a = 0; impact::is_second_order<Cell> && a < n; ++a) mass[a] = M[a * n + a] * all / diagonal;
}

/// One random cell with its fields.
template <class Cell, Frame frame> struct CellCase {
  static constexpr int dim = Cell::dim, nodes = Cell::nodes, points = Cell::points, dofs = nodes * dim;
  double X[dofs], u[dofs], u_n[dofs], accel[dofs], phi[nodes], theta[nodes];
  impact::PointHistory<double, dim> history[points];
  double dt = 1e-3, mass_shift = 0;

  /// Distorted reference cell of size h; displacement = random affine map of size `strain` plus noise; random
  /// history.
  CellCase(Sampler& random, double strain, double h = 1e-3, double prestrain = 0.005) {
    double H[3][3], H_n[3][3];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        H[i][j] = random.uniform(-strain, strain), H_n[i][j] = random.uniform(-strain, strain);
    for (int a = 0; a < nodes; ++a) {
      const auto c = node_place<Cell>(a);
      for (int i = 0; i < dim; ++i) {
        const double noise = random.uniform(-0.15, 0.15);
        X[a * dim + i] = h * (c[unsigned(i)] + noise + (frame == Frame::axisymmetric && i == 0 ? 2 : 0));
        if constexpr (impact::is_second_order<Cell>) // slightly bent between its corners
          if (a >= corners<Cell>) {
            X[a * dim + i] = h * noise / 5;
            const auto N = corner_functions<Cell>(a);
            for (int b = 0; b < corners<Cell>; ++b) X[a * dim + i] += N[unsigned(b)] * X[b * dim + i];
          }
      }
      phi[a] = random.uniform(0, 0.8);
      theta[a] = random.uniform(290, 400);
    }
    for (int a = 0; a < nodes; ++a)
      for (int i = 0; i < dim; ++i) {
        const int k = a * dim + i;
        const double noise =
            (impact::is_second_order<Cell> ? 0.1 : 0.3) * strain * h; // shorter waves are steeper
        u[k] = random.uniform(-1, 1) * noise;
        u_n[k] = random.uniform(-1, 1) * noise;
        for (int j = 0; j < dim; ++j) u[k] += H[i][j] * X[a * dim + j], u_n[k] += H_n[i][j] * X[a * dim + j];
        accel[k] = random.uniform(-1e6, 1e6);
      }
    hold_between_nodes<Cell>(phi, 0.8);
    for (auto& p : history) p = random.history<dim>(prestrain);
  }
};

/// Gradients at one point: N, dN/dX and the weight.
template <class Cell, Frame frame> struct Point {
  double N[Cell::nodes], dN[Cell::nodes][Cell::dim], weight, R;

  Point(const double* X, const typename Cell::Point& xi, double w) {
    constexpr int d = Cell::dim;
    const auto n = Cell::N(xi);
    const auto g = Cell::dN(xi);
    Matrix<double> J = unit<double>(); // dX_i/dxi_j
    R = 0;
    for (unsigned i = 0; i < d; ++i)
      for (unsigned j = 0; j < d; ++j) {
        J[3 * i + j] = 0;
        for (unsigned a = 0; a < Cell::nodes; ++a) J[3 * i + j] += X[a * d + i] * g[a][j];
      }
    const Matrix<double> inv = inverse(J);
    for (unsigned a = 0; a < Cell::nodes; ++a) {
      N[a] = n[a];
      R += n[a] * X[a * d];
      for (unsigned i = 0; i < d; ++i) {
        dN[a][i] = 0;
        for (unsigned j = 0; j < d; ++j) dN[a][i] += g[a][j] * inv[3 * j + i];
      }
    }
    weight = w * det(J) * (frame == Frame::axisymmetric ? 2 * std::numbers::pi * R : 1);
  }

  template <class T> Matrix<T> F(const T* u) const {
    Matrix<T> f = unit<T>();
    for (int i = 0; i < Cell::dim; ++i)
      for (int j = 0; j < Cell::dim; ++j)
        for (int a = 0; a < Cell::nodes; ++a) f[unsigned(3 * i + j)] += u[a * Cell::dim + i] * dN[a][j];
    if (frame == Frame::axisymmetric)
      for (int a = 0; a < Cell::nodes; ++a) f[8] += u[a * Cell::dim] * N[a] / R;
    return f;
  }
  double at(const double* nodal) const {
    double s = 0;
    for (int a = 0; a < Cell::nodes; ++a) s += N[a] * nodal[a];
    return s;
  }
  template <class T> void add_force(const Matrix<T>& P, T* r) const {
    for (int a = 0; a < Cell::nodes; ++a)
      for (int i = 0; i < Cell::dim; ++i) {
        for (int j = 0; j < Cell::dim; ++j)
          r[a * Cell::dim + i] += weight * P[unsigned(3 * i + j)] * dN[a][j];
        if (frame == Frame::axisymmetric && i == 0) r[a * Cell::dim] += weight * P[8] * N[a] / R;
      }
  }
  Matrix<double> outer_gradient(const double* nodal) const { // g (x) g of Grad phi
    double g[3] = {0, 0, 0};
    for (int i = 0; i < Cell::dim; ++i)
      for (int a = 0; a < Cell::nodes; ++a) g[i] += nodal[a] * dN[a][i];
    Matrix<double> m;
    for (unsigned i = 0; i < 3; ++i)
      for (unsigned j = 0; j < 3; ++j) m[3 * i + j] = g[i] * g[j];
    return m;
  }
};

template <class Cell, Frame frame> std::vector<Point<Cell, frame>> points(const double* X) {
  std::vector<Point<Cell, frame>> p;
  for (int q = 0; q < Cell::points; ++q) p.emplace_back(X, Cell::point(q), Cell::weight(q));
  return p;
}

/// What `mean` makes of values at the points: their mean, or in quadrilaterals and hexahedra of second order
/// the function c_0 + c.X that is next to them in the square over the volume, by its normal equations.
template <class Cell, Frame frame, class T>
std::vector<T> shared(const double* X, const std::vector<Point<Cell, frame>>& at,
                      const std::vector<T>& values) {
  constexpr bool varies = impact::is_second_order<Cell> && Cell::dim + 1 < corners<Cell>;
  constexpr unsigned n = varies ? Cell::dim + 1 : 1;
  const auto mode = [&](unsigned q, unsigned k) {
    double x = k == 0 ? 1 : 0; // lengths of cells in tests are 1e-3
    for (unsigned a = 0; k > 0 && a < Cell::nodes; ++a) x += 1e3 * at[q].N[a] * X[a * Cell::dim + k - 1];
    return x;
  };
  double A[n][n] = {};
  T c[n];
  for (unsigned k = 0; k < n; ++k) {
    c[k] = 0.0;
    for (unsigned q = 0; q < at.size(); ++q) {
      c[k] += at[q].weight * mode(q, k) * values[q];
      for (unsigned l = 0; l < n; ++l) A[k][l] += at[q].weight * mode(q, k) * mode(q, l);
    }
  }
  for (unsigned k = 0; k < n; ++k)
    for (unsigned i = k + 1; i < n; ++i) {
      const double f = A[i][k] / A[k][k];
      for (unsigned j = k; j < n; ++j) A[i][j] -= f * A[k][j];
      c[i] -= f * c[k];
    }
  for (unsigned k = n; k-- > 0;) {
    for (unsigned j = k + 1; j < n; ++j) c[k] -= A[k][j] * c[j];
    c[k] /= A[k][k];
  }
  std::vector<T> field(at.size(), T(0.0));
  for (unsigned q = 0; q < at.size(); ++q)
    for (unsigned k = 0; k < n; ++k) field[q] += mode(q, k) * c[k];
  return field;
}
/// The volume ratio of `mean` at the points.
template <class Cell, Frame frame, class T>
std::vector<T> shared_volume(const double* X, const std::vector<Point<Cell, frame>>& at, const T* u) {
  std::vector<T> J;
  for (const auto& q : at) J.push_back(det(q.F(u)));
  return shared(X, at, J);
}
/// The pressure of `mean` at the points; phi and theta as of the case, or no damage.
template <class Cell, Frame frame, class T>
std::vector<T> shared_pressure(const MaterialParameters& m, const CellCase<Cell, frame>& c,
                               const std::vector<Point<Cell, frame>>& at, const T* u, bool damaged = true) {
  std::vector<T> p = shared_volume(c.X, at, u);
  for (unsigned q = 0; q < at.size(); ++q)
    p[q] = pressure(m, p[q], T(J_theta(m, at[q].at(c.theta))), T(damaged ? at[q].at(c.phi) : 0.0));
  return shared(c.X, at, p);
}

template <class T> Matrix<T> right_cauchy_green(const Matrix<T>& F) { return multiply(transpose(F), F); }

/// Force vector of the cell without inertia.
template <class Cell, Frame frame, class T>
std::vector<T> force(const MaterialParameters& m, const CellCase<Cell, frame>& c, const std::vector<T>& u) {
  const auto at = points<Cell, frame>(c.X);
  const Point<Cell, frame> centre(c.X, Cell::centroid(), 1);
  std::vector<T> r(u.size(), T(0.0));
  const T J_0 = det(centre.F(u.data()));
  const std::vector<T> p_mean = shared_pressure(m, c, at, u.data());
  for (int k = 0; k < Cell::points; ++k) {
    const auto& q = at[unsigned(k)];
    const T phi = q.at(c.phi), J_th = J_theta(m, q.at(c.theta));
    const Matrix<T> F = q.F(u.data()), Fi = inverse(F), FiT = transpose(Fi);
    const T J = det(F);
    Matrix<T> tau =
        return_map(m, F, dense<Cell::dim>(c.history[k].A), c.history[k].alpha, phi, q.at(c.theta), c.dt).s;
    T p = p_mean[unsigned(k)];
    if (m.locking == Locking::none) p = pressure(m, J, J_th, phi);
    if (m.locking == Locking::fbar) {
      for (T& x : tau) x *= J / J_0;
      p = pressure(m, J_0, J_th, phi);
    }
    for (unsigned i = 0; i < 3; ++i) tau[4 * i] += p * J;
    Matrix<T> P = multiply(tau, FiT);
    Matrix<T> S{};
    if (m.b_d > 0) {
      const Matrix<T> C = right_cauchy_green(F);
      const Matrix<double> C_n = right_cauchy_green(q.F(c.u_n));
      const T b = m.b_d * (m.visc_degrade ? g_e1(m, phi) : T(1.0));
      for (unsigned i = 0; i < 9; ++i) S[i] += 2.0 * b / c.dt * (C[i] - C_n[i]);
    }
    if (m.damage == impact::Damage::at2 && m.damage_gradient == impact::DamageGradient::spatial) {
      const Matrix<T> Ci = inverse(right_cauchy_green(F));
      const Matrix<T> ww = multiply(multiply(Ci, q.outer_gradient(c.phi)), Ci);
      for (unsigned i = 0; i < 9; ++i) S[i] -= m.Gc * m.gamma * ww[i];
    }
    const Matrix<T> FS = multiply(F, S);
    for (unsigned i = 0; i < 9; ++i) P[i] += FS[i];
    q.add_force(P, r.data());
  }
  return r;
}

/// Energy whose derivative the force of an elastic cell at fixed history is (locking none or mean), with the
/// incremental viscous potential.
template <class Cell, Frame frame, class T>
T energy(const MaterialParameters& m, const CellCase<Cell, frame>& c, const std::vector<T>& u) {
  const auto at = points<Cell, frame>(c.X);
  T sum = 0.0;
  const std::vector<T> J_mean = shared_volume(c.X, at, u.data());
  for (int k = 0; k < Cell::points; ++k) {
    const auto& q = at[unsigned(k)];
    const T phi = q.at(c.phi);
    const Matrix<T> F = q.F(u.data()), C = right_cauchy_green(F);
    const T J_vol = m.locking == Locking::mean ? J_mean[unsigned(k)] : det(F);
    sum += q.weight *
           elastic_energy(m, C, dense<Cell::dim>(c.history[k].A), J_vol, phi, T(J_theta(m, q.at(c.theta))));
    if (m.b_d > 0) {
      const Matrix<double> C_n = right_cauchy_green(q.F(c.u_n));
      T square = 0.0;
      for (unsigned i = 0; i < 9; ++i) square += (C[i] - C_n[i]) * (C[i] - C_n[i]);
      sum += q.weight * m.b_d * (m.visc_degrade ? g_e1(m, phi) : T(1.0)) / (2 * c.dt) * square;
    }
    if (m.damage == impact::Damage::at2 && m.damage_gradient == impact::DamageGradient::spatial) {
      const Matrix<T> Ci = inverse(C);
      const Matrix<double> gg = q.outer_gradient(c.phi);
      for (unsigned i = 0; i < 9; ++i) sum += q.weight * m.Gc * m.gamma / 2 * Ci[i] * gg[i];
    }
  }
  return sum;
}

/// The same cases as lanes of the library's input.
template <class Cell, Frame frame> struct CellBatch {
  using Case = CellCase<Cell, frame>;
  static constexpr int dim = Cell::dim, nodes = Cell::nodes, dofs = nodes * dim,
                       history_components = impact::history_size(frame);
  impact::Batch X[dofs], u[dofs], u_n[dofs], accel[dofs], phi[nodes], theta[nodes];
  impact::Batch history[Cell::points * history_components];

  explicit CellBatch(const std::vector<Case>& cases) {
    for (int l = 0; l < impact::lanes; ++l) {
      const Case& c = cases[unsigned(l) % cases.size()];
      for (int i = 0; i < dofs; ++i) {
        X[i].set(l, c.X[i]);
        u[i].set(l, c.u[i]);
        u_n[i].set(l, c.u_n[i]);
        accel[i].set(l, c.accel[i]);
      }
      for (int a = 0; a < nodes; ++a) phi[a].set(l, c.phi[a]), theta[a].set(l, c.theta[a]);
      for (int q = 0; q < Cell::points; ++q) {
        for (int i = 0; i < impact::symmetric_size(dim); ++i)
          history[q * history_components + i].set(l, c.history[q].A[i]);
        history[q * history_components + impact::symmetric_size(dim)].set(l, c.history[q].alpha);
        if constexpr (frame == Frame::plane_stress) // F_33 - 1
          history[q * history_components + history_components - 1].set(l, 1e-3 * (q - 1));
      }
    }
  }
  impact::MotionInput input(double dt) const {
    impact::MotionInput in;
    in.X = X;
    in.u = u;
    in.u_n = u_n;
    in.phi = phi;
    in.theta = theta;
    in.history = history;
    in.dt = dt;
    return in;
  }
};

template <class Cell, Frame frame>
std::vector<CellCase<Cell, frame>> cases(Sampler& random, double strain, double prestrain = 0.005) {
  std::vector<CellCase<Cell, frame>> c;
  for (int l = 0; l < impact::lanes; ++l) c.emplace_back(random, strain, 1e-3, prestrain);
  return c;
}

} // namespace reference
