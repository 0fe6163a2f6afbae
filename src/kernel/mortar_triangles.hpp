#pragma once
#include "mortar_polygon.hpp"
#include <impact/kernel/mortar_face.hpp>
#include <impact/math/index.hpp>

/// The triangles of which the two faces of a mortar pair consist (mortar_face.hpp), and which of them meet.
namespace impact::mortar {

using Triangle = std::array<Point3, 3>;
using Places = std::array<Place<double>, 3>;

inline int triangles_of(const FaceCorners& x) { return corners_of(x) == 3 ? 1 : 4; }

inline Triangle triangle_of(const FaceCorners& x, const TriangleWeights& w) {
  Triangle t{};
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t a = 0; a < 4; ++a)
      if (w[v][a] != 0)
        for (std::size_t k = 0; k < 3; ++k) t[v][k] += w[v][a] * x[a][k];
  return t;
}

// Of the corners of the triangle (0, e1, e2), the places of the three corners of another one.
inline Places places_of(const Triangle& s, const Triangle& p) {
  const Point3 e1 = minus(s[1], s[0]), e2 = minus(s[2], s[0]);
  return {project(e1, e2, minus(p[0], s[0])), project(e1, e2, minus(p[1], s[0])),
          project(e1, e2, minus(p[2], s[0]))};
}

// False where the projections certainly do not meet, or the primary does not run against the secondary.
inline bool may_cover(const Places& p) {
  const auto all = [&](auto&& outside) { return outside(p[0]) && outside(p[1]) && outside(p[2]); };
  return !all([](const Place<double>& q) { return q.b < 0; }) &&
         !all([](const Place<double>& q) { return q.c < 0; }) &&
         !all([](const Place<double>& q) { return 1 - q.b - q.c < 0; }) && twice_area(p[0], p[2], p[1]) > 0;
}

// Barycentric coordinates of a place in a projected primary triangle.
inline std::array<double, 3> barycentric(const Places& q, const Place<double>& here) {
  const double whole = twice_area(q[0], q[2], q[1]);
  return {twice_area(here, q[2], q[1]) / whole, twice_area(q[0], q[2], here) / whole,
          twice_area(q[0], here, q[1]) / whole};
}

// A triangle of the secondary face and one of the primary that may cover something of it.
struct TrianglePair {
  std::size_t i; // number of the secondary triangle
  TriangleWeights ws, wp;
  Triangle s, p;
  Places places;

  // Of a corner of both triangles, secondary ones first: what the face's corner a adds to it.
  double weight(std::size_t vertex, std::size_t a) const {
    return vertex < 3 ? ws[vertex][a] : wp[vertex - 3][a];
  }
  // Phi_a at the secondary triangle's corner v.
  double function(const MortarFace& face, std::size_t a, std::size_t v) const {
    double value = 0;
    for (std::size_t b = 0; b < at(face.corners); ++b) value += face.phi[a][b] * ws[v][b];
    return value;
  }
};

template <class Visitor> void visit_triangles(const FaceCorners& x, const FaceCorners& p, Visitor&& visitor) {
  if (clearance(x, p) > 0) return;
  const int count = triangles_of(x), primary_count = triangles_of(p);
  for (int i = 0; i < count; ++i) {
    const TriangleWeights ws = triangle_weights(corners_of(x), i);
    const Triangle s = triangle_of(x, ws);
    for (int j = 0; j < primary_count; ++j) {
      const TriangleWeights wp = triangle_weights(corners_of(p), j);
      const Triangle t = triangle_of(p, wp);
      const Places places = places_of(s, t);
      if (may_cover(places)) visitor(TrianglePair{at(i), ws, wp, s, t, places});
    }
  }
}

} // namespace impact::mortar
