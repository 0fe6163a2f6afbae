#pragma once
#include <cmath>
#include <impact/kernel/mortar_face.hpp>
#include <random>

/// Random pairs of faces that lie opposite each other, for tests of contact between faces.
namespace impact::face_test {

inline Point3 minus(const Point3& a, const Point3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline double dot(const Point3& a, const Point3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Point3 cross(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

struct Pair {
  int corners = 4, primary_corners = 4;
  FaceCorners x, p;
  MortarFace face;
};

// Two faces roughly opposite to each other, warped, shifted, turned, of different sizes.
inline Pair random_pair(std::mt19937& random, int corners, int primary_corners, bool dual = false) {
  std::uniform_real_distribution<double> u(-1, 1);
  Pair pair{corners, primary_corners, {}, {}, {}};
  const FaceCorners square = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  const double size = 1 + 0.5 * u(random), dx = 0.6 * u(random), dy = 0.6 * u(random), turn = u(random);
  for (std::size_t a = 0; a < 4; ++a) {
    pair.x[a] = {square[a][0] + 0.1 * u(random), square[a][1] + 0.1 * u(random), 0.1 * u(random)};
    // The same order seen from above, hence the other way round for its own body.
    const Point3& q = square[3 - a];
    const double X = size * (q[0] - 0.5), Y = size * (q[1] - 0.5);
    pair.p[a] = {0.5 + dx + std::cos(turn) * X - std::sin(turn) * Y,
                 0.5 + dy + std::sin(turn) * X + std::cos(turn) * Y, -0.1 + 0.1 * u(random)};
  }
  if (corners == 3) pair.x[3] = pair.x[2];
  if (primary_corners == 3) pair.p[3] = pair.p[2];
  FaceCorners X = pair.x;
  for (Point3& point : X) point[0] *= 1.2;
  pair.face = make_mortar_face(X, dual);
  return pair;
}

inline double& dof(Pair& pair, std::size_t i) { return (i < 12 ? pair.x : pair.p)[i % 12 / 3][i % 3]; }

// A triangle repeats its third corner: both move.
inline void shift(Pair& pair, std::size_t i, double by) {
  dof(pair, i) += by;
  const bool triangle = (i < 12 ? pair.corners : pair.primary_corners) == 3;
  if (triangle && i % 12 / 3 == 2) dof(pair, i + 3) += by;
}

inline bool repeated(const Pair& pair, std::size_t i) {
  return i % 12 / 3 == 3 && (i < 12 ? pair.corners : pair.primary_corners) == 3;
}

inline const std::array<std::array<int, 2>, 4> kinds = {{{3, 3}, {3, 4}, {4, 3}, {4, 4}}};

} // namespace impact::face_test
