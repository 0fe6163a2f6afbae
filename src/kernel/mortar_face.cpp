#include "mortar_polygon.hpp"
#include <algorithm>
#include <impact/kernel/mortar_face.hpp>
#include <impact/math/index.hpp>
#include <limits>

namespace impact {

namespace {

using Triangle = std::array<Point3, 3>;
using Places = std::array<Place<double>, 3>;

int triangles_of(const FaceCorners& x) { return corners_of(x) == 3 ? 1 : 4; }

Triangle triangle_of(const FaceCorners& x, const TriangleWeights& w) {
  Triangle t{};
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t a = 0; a < 4; ++a)
      if (w[v][a] != 0)
        for (std::size_t k = 0; k < 3; ++k) t[v][k] += w[v][a] * x[a][k];
  return t;
}

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

// Of the corners of the triangle (0, e1, e2), the places of the three corners of another one.
Places places_of(const Triangle& s, const Triangle& p) {
  const Point3 e1 = minus(s[1], s[0]), e2 = minus(s[2], s[0]);
  return {project(e1, e2, minus(p[0], s[0])), project(e1, e2, minus(p[1], s[0])),
          project(e1, e2, minus(p[2], s[0]))};
}

// False where the projections certainly do not meet, or the primary does not run against the secondary.
bool may_cover(const Places& p) {
  const auto all = [&](auto&& outside) { return outside(p[0]) && outside(p[1]) && outside(p[2]); };
  return !all([](const Place<double>& q) { return q.b < 0; }) &&
         !all([](const Place<double>& q) { return q.c < 0; }) &&
         !all([](const Place<double>& q) { return 1 - q.b - q.c < 0; }) && twice_area(p[0], p[2], p[1]) > 0;
}

// Barycentric coordinates of a place in a projected primary triangle.
std::array<double, 3> barycentric(const Places& q, const Place<double>& here) {
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

// Projections of the primary's corners with derivatives by (e1, e2, d), and what they make of the integrals:
// two short chains of nine variables instead of one of eighteen.
constexpr int stage = 9;
using First = Dual<double, stage>;
using Second = Dual<First, stage>;

First seeded(double value, int i, const First&) { return seed<double, stage>(value, i); }
Second seeded(double value, int i, const Second&) {
  Second y(seed<double, stage>(value, i));
  y.d[i] = First(1.0);
  return y;
}

// The projection of a primary's corner b, its derivatives by (e1, e2, d).
template <class T> Place<T> seeded_projection(const TrianglePair& m, std::size_t b) {
  const Triangle span = {minus(m.s[1], m.s[0]), minus(m.s[2], m.s[0]), minus(m.p[b], m.s[0])};
  Vector3Of<T> e1, e2, d;
  for (std::size_t k = 0; k < 3; ++k) {
    e1[k] = seeded(span[0][k], static_cast<int>(k), T());
    e2[k] = seeded(span[1][k], static_cast<int>(3 + k), T());
    d[k] = seeded(span[2][k], static_cast<int>(6 + k), T());
  }
  return project(e1, e2, d);
}

// A row over the dofs of the corners of two triangles, (s0 s1 s2 p0 p1 p2).
using Row = std::array<double, 18>;

// Puts a row over (e1, e2, d) of primary corner b on the dofs of the six corners.
void spread(const double* row, std::size_t b, Row& out) {
  for (std::size_t k = 0; k < 3; ++k) {
    out[3 + k] += row[k];
    out[6 + k] += row[3 + k];
    out[9 + 3 * b + k] += row[6 + k];
    out[k] -= row[k] + row[3 + k] + row[6 + k];
  }
}

// d places / d (s0 s1 s2 p0 p1 p2), by (b, c, gap) of each corner.
std::array<Row, stage> place_gradient(const TrianglePair& m) {
  std::array<Row, stage> J{};
  for (std::size_t b = 0; b < 3; ++b) {
    const Place<First> p = seeded_projection<First>(m, b);
    std::size_t row = 3 * b;
    for (const First* value : {&p.b, &p.c, &p.gap}) spread(value->d, b, J[row++]);
  }
  return J;
}

// Adds an 18 x 18 block over the corners of two triangles to the 24 x 24 of the two faces.
void add_to_faces(const std::array<double, 324>& block, const TrianglePair& m, std::span<double> hessian) {
  for (std::size_t v = 0; v < 6; ++v)
    for (std::size_t a = 0; a < 4; ++a) {
      if (m.weight(v, a) == 0) continue;
      const std::size_t row = 3 * (a + (v < 3 ? 0 : 4));
      for (std::size_t w = 0; w < 6; ++w)
        for (std::size_t b = 0; b < 4; ++b) {
          const double factor = m.weight(v, a) * m.weight(w, b);
          if (factor == 0) continue;
          const std::size_t column = 3 * (b + (w < 3 ? 0 : 4));
          for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
              hessian[24 * (row + i) + column + j] += factor * block[18 * (3 * v + i) + 3 * w + j];
        }
    }
}

// Adds sum_q G'_q q'' of the projections q to the block over the corners of two triangles.
void add_bending(const TrianglePair& m, const std::array<First, stage>& sum, std::array<double, 324>& block) {
  for (std::size_t b = 0; b < 3; ++b) {
    const Place<Second> place = seeded_projection<Second>(m, b);
    const Second weighted = First(sum[3 * b].v) * place.b + First(sum[3 * b + 1].v) * place.c +
                            First(sum[3 * b + 2].v) * place.gap;
    std::array<Row, stage> half{};
    for (std::size_t q = 0; q < stage; ++q) spread(weighted.d[q].d, b, half[q]);
    for (std::size_t k = 0; k < 18; ++k) {
      std::array<double, stage> column;
      for (std::size_t q = 0; q < stage; ++q) column[q] = half[q][k];
      Row whole{};
      spread(column.data(), b, whole);
      for (std::size_t j = 0; j < 18; ++j) block[18 * j + k] += whole[j];
    }
  }
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

MortarPair mortar_pair(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                       bool with_gradient) {
  MortarPair pair;
  visit_triangles(x, p, [&](const TrianglePair& m) {
    const Polygon<double> polygon = covered_polygon(m.places);
    if (polygon.count < 3) return;
    pair.touched = true;
    pair.covered = pair.covered || part_of(polygon) > 0;
    const TriangleGaps<double> sums = integrate(polygon);
    std::array<std::array<double, 3>, 4> phi{};
    for (std::size_t a = 0; a < at(face.corners); ++a)
      for (std::size_t v = 0; v < 3; ++v) {
        phi[a][v] = face.area[m.i] * m.function(face, a, v);
        pair.gap[a] += phi[a][v] * sums.gap[v];
        pair.cover[a] += phi[a][v] * sums.cover[v];
      }
    if (!with_gradient) return;
    const auto by_place = gap_derivatives(m.places, polygon);
    const std::array<Row, stage> J = place_gradient(m);
    std::array<Row, 3> gradient{};
    for (std::size_t v = 0; v < 3; ++v)
      for (std::size_t q = 0; q < stage; ++q)
        for (std::size_t k = 0; k < 18; ++k) gradient[v][k] += by_place[v][q] * J[q][k];
    for (std::size_t a = 0; a < at(face.corners); ++a) {
      Row row{};
      for (std::size_t v = 0; v < 3; ++v)
        for (std::size_t k = 0; k < 18; ++k) row[k] += phi[a][v] * gradient[v][k];
      for (std::size_t v = 0; v < 6; ++v)
        for (std::size_t b = 0; b < 4; ++b)
          for (std::size_t k = 0; k < 3; ++k)
            pair.gradient[a][3 * (b + (v < 3 ? 0 : 4)) + k] += m.weight(v, b) * row[3 * v + k];
    }
  });
  return pair;
}

bool add_mortar_hessian(const FaceCorners& x, const FaceCorners& p, const MortarFace& face,
                        const std::array<double, 4>& factor, std::span<double> hessian) {
  bool touched = false;
  visit_triangles(x, p, [&](const TrianglePair& m) {
    if (covered_polygon(m.places).count < 3) return;
    touched = true;
    std::array<double, 3> f{};
    for (std::size_t a = 0; a < at(face.corners); ++a)
      for (std::size_t v = 0; v < 3; ++v) f[v] += face.area[m.i] * factor[a] * m.function(face, a, v);
    std::array<Place<First>, 3> places;
    for (std::size_t b = 0; b < 3; ++b) {
      const Place<double>& q = m.places[b];
      const int first = static_cast<int>(3 * b);
      places[b] = {seed<double, stage>(q.b, first), seed<double, stage>(q.c, first + 1),
                   seed<double, stage>(q.gap, first + 2)};
    }
    const auto by_place = gap_derivatives(places, covered_polygon(places));
    std::array<First, stage> sum; // first derivatives, and of those the second ones
    for (std::size_t q = 0; q < stage; ++q)
      sum[q] = f[0] * by_place[0][q] + f[1] * by_place[1][q] + f[2] * by_place[2][q];
    const std::array<Row, stage> J = place_gradient(m);
    // J^T G'' J
    std::array<Row, stage> GJ{};
    for (std::size_t q = 0; q < stage; ++q)
      for (std::size_t r = 0; r < stage; ++r)
        for (std::size_t k = 0; k < 18; ++k) GJ[q][k] += sum[q].d[r] * J[r][k];
    std::array<double, 324> block{};
    for (std::size_t q = 0; q < stage; ++q)
      for (std::size_t k = 0; k < 18; ++k)
        for (std::size_t j = 0; j < 18; ++j) block[18 * k + j] += J[q][k] * GJ[q][j];
    add_bending(m, sum, block);
    add_to_faces(block, m, hessian);
  });
  return touched;
}

} // namespace impact
