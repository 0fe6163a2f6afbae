#include "mortar_triangles.hpp"
#include <algorithm>
#include <limits>

/// What a face is, and what of it another one covers.
namespace impact {

using namespace mortar;

namespace {

double area_of(const Triangle& t) {
  const Point3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
  return std::sqrt(dot(n, n)) / 2;
}

double area_of(const FaceCorners& x) {
  double area = 0;
  for (int i = 0; i < triangles_of(x); ++i)
    area += area_of(triangle_of(x, triangle_weights(corners_of(x), i)));
  return area;
}

} // namespace

TriangleWeights triangle_weights(int corners, int triangle) {
  if (corners == 3) return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  TriangleWeights w{};
  w[0][at(triangle)] = 1;
  w[1][at((triangle + 1) % 4)] = 1;
  w[2] = {0.25, 0.25, 0.25, 0.25};
  return w;
}

std::array<double, 4> nodal_areas(const FaceCorners& x) {
  std::array<double, 4> area{};
  for (int i = 0; i < triangles_of(x); ++i) {
    const TriangleWeights w = triangle_weights(corners_of(x), i);
    const double third = area_of(triangle_of(x, w)) / 3;
    for (std::size_t v = 0; v < 3; ++v)
      for (std::size_t a = 0; a < 4; ++a) area[a] += third * w[v][a];
  }
  return area;
}

MortarFace make_mortar_face(const FaceCorners& X, bool dual) {
  MortarFace face;
  face.corners = corners_of(X);
  const auto n = at(face.corners);
  std::array<std::array<double, 4>, 4> mass{};
  for (int i = 0; i < face.triangles(); ++i) {
    const TriangleWeights w = triangle_weights(corners_of(X), i);
    const double area = area_of(triangle_of(X, w));
    face.area[at(i)] = area;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b < n; ++b)
        for (std::size_t v = 0; v < 3; ++v)
          for (std::size_t u = 0; u < 3; ++u) mass[a][b] += area / (u == v ? 6 : 12) * w[v][a] * w[u][b];
  }
  for (std::size_t a = 0; a < n; ++a) face.phi[a][a] = 1;
  if (!dual) return face;
  // phi = diag(int N_a) (int N_a N_b)^-1, by elimination: the matrix is symmetric and positive definite.
  std::array<double, 4> total{};
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) total[a] += mass[a][b];
  std::array<std::array<double, 4>, 4>& inverse = face.phi;
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = 1 / mass[k][k];
    for (std::size_t j = 0; j < n; ++j) {
      mass[k][j] *= pivot;
      inverse[k][j] *= pivot;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = mass[i][k];
      for (std::size_t j = 0; j < n; ++j) {
        mass[i][j] -= factor * mass[k][j];
        inverse[i][j] -= factor * inverse[k][j];
      }
    }
  }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b) inverse[a][b] *= total[a];
  return face;
}

FacetView view_facet(const FaceCorners& x, const FaceCorners& p) {
  double smallest = std::numeric_limits<double>::infinity(), largest = -smallest, sum = 0, part = 0;
  visit_triangles(x, p, [&](const TrianglePair& m) {
    const Polygon<double> polygon = covered_polygon(m.places);
    const double mine = part_of(polygon), area = area_of(m.s);
    if (!(mine > 0)) return;
    const TriangleGaps<double> sums = integrate(polygon);
    sum += area * (sums.gap[0] + sums.gap[1] + sums.gap[2]);
    part += area * mine;
    for (std::size_t v = 0; v < polygon.count; ++v) {
      smallest = std::min(smallest, polygon.place[v].gap);
      largest = std::max(largest, polygon.place[v].gap);
    }
  });
  if (part > 0) return {part / area_of(x), smallest, largest, sum / part};
  const Point3 n = facet_normal(x);
  for (const Point3& corner : p) {
    const double gap = dot(minus(corner, x[0]), n);
    smallest = std::min(smallest, gap);
    largest = std::max(largest, gap);
  }
  return {0, smallest, largest, (smallest + largest) / 2};
}

double common_part(const FaceCorners& x, const FaceCorners& a, const FaceCorners& b) {
  double common = 0;
  visit_triangles(x, a, [&](const TrianglePair& m) {
    const Polygon<double> first = covered_polygon(m.places);
    if (!(part_of(first) > 0)) return;
    for (int j = 0; j < triangles_of(b); ++j) {
      const Places other = places_of(m.s, triangle_of(b, triangle_weights(corners_of(b), j)));
      if (!may_cover(other)) continue;
      Polygon<double> both = first;
      for (std::size_t e : {0, 2, 1}) {
        const Place<double>&from = other[e], &to = other[(e + 2) % 3];
        both = cut(both, [&](const Place<double>& q) { return twice_area(from, to, q); });
      }
      common += area_of(m.s) * part_of(both);
    }
  });
  return common / area_of(x);
}

MortarWeights mortar_weights(const FaceCorners& x, const FaceCorners& p, const MortarFace& face) {
  MortarWeights weights;
  visit_triangles(x, p, [&](const TrianglePair& m) {
    Polygon<double> polygon = covered_polygon(m.places);
    if (!(part_of(polygon) > 0)) return;
    weights.covered = true;
    // int L_v f for the six functions f: in the place of the gap.
    for (std::size_t u = 0; u < 6; ++u) {
      for (std::size_t k = 0; k < polygon.count; ++k) {
        Place<double>& q = polygon.place[k];
        q.gap = u == 0 ? 1 - q.b - q.c : u == 1 ? q.b : u == 2 ? q.c : barycentric(m.places, q)[u - 3];
      }
      const std::array<double, 3> sums = integrate(polygon).gap;
      for (std::size_t a = 0; a < at(face.corners); ++a)
        for (std::size_t v = 0; v < 3; ++v) {
          const double phi = face.area[m.i] * m.function(face, a, v) * sums[v];
          for (std::size_t b = 0; b < 4; ++b) (u < 3 ? weights.D : weights.M)[a][b] += phi * m.weight(u, b);
        }
    }
  });
  return weights;
}

void visit_covered(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                   const PieceVisitor& visitor) {
  visit_triangles(x, p, [&](const TrianglePair& m) {
    const Polygon<double> polygon = covered_polygon(m.places);
    const Point3 across = cross(minus(m.s[1], m.s[0]), minus(m.s[2], m.s[0]));
    const double length = std::sqrt(dot(across, across));
    for (std::size_t k = 1; k + 1 < polygon.count; ++k) {
      const Places corner = {polygon.place[0], polygon.place[k], polygon.place[k + 1]};
      CoveredPiece t;
      t.area = face.area[m.i] * twice_area(corner[0], corner[1], corner[2]);
      for (std::size_t c = 0; c < 3; ++c) t.normal[c] = across[c] / length;
      for (std::size_t v = 0; v < 3; ++v) {
        const std::array<double, 3> L = {1 - corner[v].b - corner[v].c, corner[v].b, corner[v].c},
                                    l = barycentric(m.places, corner[v]);
        for (std::size_t u = 0; u < 3; ++u)
          for (std::size_t a = 0; a < 4; ++a) {
            t.secondary[v][a] += L[u] * m.ws[u][a];
            t.primary[v][a] += l[u] * m.wp[u][a];
            t.phi[v][a] += L[u] * m.function(face, a, u);
          }
      }
      visitor(t);
    }
  });
}

bool corner_gap(const FaceCorners& x, int corner, const FaceCorners& p, double& gap) {
  // The corner is the first one of the triangle with its number, or a corner of the only one.
  const bool triangle = corners_of(x) == 3;
  const Triangle s = triangle_of(x, triangle_weights(corners_of(x), corner));
  const int v = triangle ? corner : 0;
  const Place<double> here = {v == 1 ? 1.0 : 0.0, v == 2 ? 1.0 : 0.0, 0};
  for (int j = 0; j < triangles_of(p); ++j) {
    const Places q = places_of(s, triangle_of(p, triangle_weights(corners_of(p), j)));
    if (!(twice_area(q[0], q[2], q[1]) > 0)) continue;
    const std::array<double, 3> L = barycentric(q, here);
    if (std::min({L[0], L[1], L[2]}) < -1e-9) continue;
    gap = L[0] * q[0].gap + L[1] * q[1].gap + L[2] * q[2].gap;
    return true;
  }
  return false;
}

} // namespace impact
