#pragma once
#include "../mesh/small_mesh.hpp"
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <gtest/gtest.h>
#include <impact/contact/contact_set.hpp>
#include <map>

/// Two bricks one above the other, of hexahedra or tetrahedra that do not match, turned in space; for tests
/// of contact between faces.
namespace impact::contact_test {

using Vector = std::array<double, 3>;

/// Turn by `angle` about (1, 2, 3).
inline Vector turned(double angle, const Vector& x) {
  const double n = std::sqrt(14.0), c = std::cos(angle), s = std::sin(angle);
  const Vector k = {1 / n, 2 / n, 3 / n};
  const double along = (k[0] * x[0] + k[1] * x[1] + k[2] * x[2]) * (1 - c);
  return {c * x[0] + s * (k[1] * x[2] - k[2] * x[1]) + along * k[0],
          c * x[1] + s * (k[2] * x[0] - k[0] * x[2]) + along * k[1],
          c * x[2] + s * (k[0] * x[1] - k[1] * x[0]) + along * k[2]};
}

struct TwoBricks {
  bool lower_tets = false, upper_tets = false;
  double angle = 0;
  bool hill = false;     ///< the lower surface is curved
  bool one_name = false; ///< both surfaces are one boundary, lower_top
  int order = 1;         ///< of the cells; 2 of tetrahedra on both sides
};

/// Regions lower, upper; boundaries lower_top, upper_bottom.
inline std::string brick_text(const TwoBricks& b) {
  run_test::GmshText mesh;
  for (int body = 0; body < 2; ++body) {
    const int n = body == 0 ? 4 : 3;
    const double left = body == 0 ? 0 : 0.13, size = body == 0 ? 1 : 0.7;
    std::vector<int> id;
    for (int k = 0; k <= 1; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          const double x = left + size * i / n, y = left + size * j / n;
          double z = 0.4 * (k + body - 1);
          if (b.hill && body == 0 && k == 1) z -= 0.15 * (x - 0.4) * (x - 0.4) + 0.1 * (y - 0.5) * (y - 0.5);
          const Vector p = turned(b.angle, {x, y, z});
          char line[120];
          std::snprintf(line, sizeof line, "%d %.17g %.17g %.17g\n", ++mesh.node_count, p[0], p[1], p[2]);
          mesh.nodes += line;
          id.push_back(mesh.node_count);
        }
    const auto at = [&](int i, int j, int k) {
      return id[static_cast<std::size_t>((k * (n + 1) + j) * (n + 1) + i)];
    };
    const bool tets = body == 0 ? b.lower_tets : b.upper_tets;
    const int k = body == 0 ? 1 : 0, group = body == 0 || b.one_name ? 3 : 4;
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::array<int, 8> v = {at(i, j, 0), at(i + 1, j, 0), at(i + 1, j + 1, 0), at(i, j + 1, 0),
                                      at(i, j, 1), at(i + 1, j, 1), at(i + 1, j + 1, 1), at(i, j + 1, 1)};
        if (!tets) {
          mesh.element(5, body + 1, {v.begin(), v.end()});
          mesh.element(3, group, {at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)});
          continue;
        }
        // Six about the diagonal 0-6, alike in all cells.
        for (const std::array<std::size_t, 2>& e :
             std::vector<std::array<std::size_t, 2>>{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
          mesh.element(4, body + 1, {v[0], v[e[0]], v[e[1]], v[6]});
        mesh.element(2, group, {at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k)});
        mesh.element(2, group, {at(i, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)});
      }
  }
  if (b.one_name) return mesh.text("3\n3 1 \"lower\"\n3 2 \"upper\"\n2 3 \"lower_top\"\n");
  return mesh.text("4\n3 1 \"lower\"\n3 2 \"upper\"\n2 3 \"lower_top\"\n2 4 \"upper_bottom\"\n");
}

inline ContactSettings brick_settings(MultiplierSpace multipliers = MultiplierSpace::standard) {
  ContactSettings s;
  s.id = "pair";
  s.secondary = "upper_bottom";
  s.primary = "lower_top";
  s.penalty = 100;
  s.multipliers = multipliers;
  s.enforce = Enforcement::auglag;
  return s;
}

/// The same with two Gauss points in each direction.
inline ContactSettings brick_points() {
  ContactSettings s = brick_settings(MultiplierSpace::automatic);
  s.method = ContactMethod::gauss_points;
  return s;
}

/// Displacement by body and place before the turn.
using BrickMotion = std::function<Vector(int body, const Vector& X)>;

struct BrickRig {
  TwoBricks bricks;
  Mesh mesh;
  FieldLayout layout;
  StateTable state;
  ContactInterface contact;

  BrickRig(MPI_Comm comm, const std::string& dir, const TwoBricks& b, const ContactSettings& s)
      : bricks(b), mesh(run_test::mesh_of(comm, dir, brick_text(b), b.order)), layout(mesh, "u", 3),
        contact(mesh, layout, s, in_space(), state) {}

  static ContactEnvironment in_space() {
    ContactEnvironment environment;
    environment.frame = Frame::solid;
    return environment;
  }
  std::vector<int> body_of() const {
    std::vector<int> body(static_cast<std::size_t>(mesh.node_count()), 0);
    for (int node : mesh.nodes("upper")) body[static_cast<std::size_t>(node)] = 1;
    return body;
  }
  Handle<Vec> at(const BrickMotion& motion) const {
    std::vector<double> local = layout.make_local();
    const std::vector<int> body = body_of();
    for (std::size_t n = 0; n < body.size(); ++n) {
      const auto X = mesh.coordinates();
      const Vector u = turned(bricks.angle,
                              motion(body[n], turned(-bricks.angle, {X[3 * n], X[3 * n + 1], X[3 * n + 2]})));
      std::copy(u.begin(), u.end(), local.begin() + static_cast<std::ptrdiff_t>(3 * n));
    }
    Handle<Vec> u = layout.make_global();
    layout.to_global(local, u);
    return u;
  }
  Handle<Vec> residual(Vec u, double scale = 1) const {
    Handle<Vec> r = layout.make_global();
    contact.add_residual(u, scale, r);
    return r;
  }
  /// Values by body and reference place (to 1e-6) of this rank's nodes, turned back.
  std::map<std::array<long, 4>, Vector> by_place(Vec global) const {
    std::vector<double> local = layout.make_local();
    layout.to_local(global, local);
    const std::vector<int> body = body_of();
    std::map<std::array<long, 4>, Vector> map;
    for (std::size_t n = 0; n < body.size(); ++n) {
      const auto x = mesh.coordinates();
      const Vector X = turned(-bricks.angle, {x[3 * n], x[3 * n + 1], x[3 * n + 2]});
      map[{body[n], std::lround(1e6 * X[0]), std::lround(1e6 * X[1]), std::lround(1e6 * X[2])}] =
          turned(-bricks.angle, {local[3 * n], local[3 * n + 1], local[3 * n + 2]});
    }
    return map;
  }
};

/// The bricks press into each other, bend and slide.
inline const BrickMotion crush_bricks = [](int body, const Vector& X) {
  if (body == 0)
    return Vector{0.02 * X[2], 0.01 * X[1] * X[2], 0.03 * std::sin(3 * X[0]) * std::cos(2 * X[1])};
  return Vector{0.05 + 0.02 * X[0] * X[2], 0.03 * X[1], -0.05 + 0.02 * std::cos(5 * X[0] + X[1])};
};

inline const BrickMotion wiggle_bricks = [](int body, const Vector& X) {
  return Vector{std::sin(7 * X[0] + 3 * X[1] + body), std::cos(4 * X[0] - 5 * X[2] - 2 * body),
                std::sin(5 * X[1] + 2 * X[0] - body)};
};

/// Of the forces of a residual, over all ranks: sum, moment about the origin, sum of the absolute values, and
/// minus the force on the upper body.
struct ForceSums {
  Vector force{}, moment{}, on_upper{};
  double absolute = 0;

  /// Force and moment vanish to 1e-13 of the absolute values, which are more than 1.
  void expect_balance() const {
    ASSERT_GT(absolute, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(force[k]), 1e-13 * absolute);
      EXPECT_LE(std::abs(moment[k]), 1e-13 * absolute);
    }
  }
};

template <class Rig> ForceSums sum_forces(const Rig& rig, Vec residual, Vec u) {
  std::vector<double> f = rig.layout.make_local(), moved = rig.layout.make_local();
  rig.layout.to_local(residual, f);
  rig.layout.to_local(u, moved);
  std::array<double, 10> sum{};
  const std::vector<int> body = rig.body_of();
  for (int n = 0; n < rig.mesh.node_count(); ++n) {
    if (!rig.mesh.owned(n)) continue;
    const std::size_t i = 3 * static_cast<std::size_t>(n);
    const auto X = rig.mesh.coordinates();
    const Vector x = {X[i] + moved[i], X[i + 1] + moved[i + 1], X[i + 2] + moved[i + 2]};
    for (std::size_t k = 0; k < 3; ++k) {
      sum[k] += f[i + k];
      sum[3 + k] += x[(k + 1) % 3] * f[i + (k + 2) % 3] - x[(k + 2) % 3] * f[i + (k + 1) % 3];
      sum[6] += std::abs(f[i + k]);
      if (body[static_cast<std::size_t>(n)] == 1) sum[7 + k] -= f[i + k];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sum.data(), 10, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return {{sum[0], sum[1], sum[2]}, {sum[3], sum[4], sum[5]}, {sum[7], sum[8], sum[9]}, sum[6]};
}

} // namespace impact::contact_test
