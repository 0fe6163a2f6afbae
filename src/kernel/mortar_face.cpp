#include <algorithm>
#include <cmath>
#include <impact/kernel/contact_pair.hpp>
#include <impact/kernel/mortar_face.hpp>
#include <impact/math/dual.hpp>
#include <impact/math/vector3.hpp>
#include <limits>

namespace impact {

namespace {

template <class T> using Vector = Vector3Of<T>;
using Triangle = std::array<Point3, 3>;

double real_part(double x) { return x; }
template <class B, int n> double real_part(const Dual<B, n>& x) { return real_part(x.v); }

using Weights = std::array<std::array<double, 4>, 3>;

Triangle triangle_of(const FaceCorners& x, const Weights& w) {
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

double area_of(int corners, const FaceCorners& x) {
  double area = 0;
  for (int i = 0; i < (corners == 3 ? 1 : 4); ++i)
    area += area_of(triangle_of(x, triangle_weights(corners, i)));
  return area;
}

// A place on the secondary triangle (its second and third barycentric coordinate) and the gap there. `a`, the
// first coordinate, in polygons alone: carried along like the others, its small values mean as much as
// theirs. Taken from b and c they would be rounding, and two neighbours not agree on which side of the border
// their common side lies.
template <class T> struct Place {
  T b, c, gap;
  T a = T(0.0);
};

// Where a point lies along the normal of the triangle (0, e1, e2).
template <class T> Place<T> project(const Vector<T>& e1, const Vector<T>& e2, const Vector<T>& d) {
  using std::sqrt;
  const Vector<T> N = cross(e1, e2);
  const T square = dot(N, N), inverse = T(1.0) / square;
  return {dot(cross(d, e2), N) * inverse, dot(cross(e1, d), N) * inverse, dot(d, N) / sqrt(square)};
}

constexpr int border = -1;

template <class T> struct Polygon {
  std::array<Place<T>, 10> place;
  std::array<int, 10>
      side{}; // of the primary triangle, on which the polygon goes on from the place; or `border`
  std::size_t count = 0;
  void add(const Place<T>& p, int goes_on) {
    side[count] = goes_on;
    place[count++] = p;
  }
};

// The part of the polygon where `inside`, linear in the place, is not negative.
template <class T, class Inside> Polygon<T> cut(const Polygon<T>& polygon, Inside&& inside) {
  Polygon<T> kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Place<T>&from = polygon.place[i], &to = polygon.place[(i + 1) % polygon.count];
    const T at_from = inside(from), at_to = inside(to);
    const bool leaves = real_part(at_from) >= 0;
    if (leaves) kept.add(from, polygon.side[i]);
    if (leaves == (real_part(at_to) >= 0)) continue;
    const T part = at_from / (at_from - at_to);
    kept.add({from.b + part * (to.b - from.b), from.c + part * (to.c - from.c),
              from.gap + part * (to.gap - from.gap), from.a + part * (to.a - from.a)},
             leaves ? border : polygon.side[i]);
  }
  return kept;
}

// Corners of a primary triangle in the order in which it runs around with the secondary one; side s from the
// s-th.
constexpr std::array<std::size_t, 3> around = {0, 2, 1};

// The part of the secondary triangle that a projected primary triangle covers. It runs against the secondary:
// its corners come the other way round.
template <class T> Polygon<T> covered_polygon(const std::array<Place<T>, 3>& primary) {
  Polygon<T> polygon;
  for (std::size_t i = 0; i < 3; ++i) {
    Place<T> corner = primary[around[i]];
    corner.a = T(1.0) - corner.b - corner.c;
    polygon.add(corner, static_cast<int>(i));
  }
  polygon = cut(polygon, [](const Place<T>& p) { return p.b; });
  polygon = cut(polygon, [](const Place<T>& p) { return p.c; });
  return cut(polygon, [](const Place<T>& p) { return p.a; });
}

// Twice the signed area in the plane of (b, c): 1 for the whole triangle.
template <class T> T twice_area(const Place<T>& p, const Place<T>& q, const Place<T>& r) {
  return (q.b - p.b) * (r.c - p.c) - (q.c - p.c) * (r.b - p.b);
}

double part_of(const Polygon<double>& polygon) {
  double part = 0;
  for (std::size_t i = 1; i + 1 < polygon.count; ++i)
    part += twice_area(polygon.place[0], polygon.place[i], polygon.place[i + 1]);
  return part;
}

// int L_v g and int L_v over the polygon, over the area of the triangle: exact for products of linear
// functions.
template <class T> struct TriangleGaps {
  std::array<T, 3> gap{T(0.0), T(0.0), T(0.0)};
  std::array<T, 3> cover{T(0.0), T(0.0), T(0.0)};
};

template <class T> TriangleGaps<T> integrate(const Polygon<T>& polygon) {
  TriangleGaps<T> sum;
  for (std::size_t i = 1; i + 1 < polygon.count; ++i) {
    const std::array<Place<T>, 3> p = {polygon.place[0], polygon.place[i], polygon.place[i + 1]};
    const T area = twice_area(p[0], p[1], p[2]);
    const T total = p[0].gap + p[1].gap + p[2].gap;
    // Of the second and third function; the three of them sum to one.
    for (std::size_t v = 1; v < 3; ++v) {
      const auto L = [&](std::size_t j) -> const T& { return v == 1 ? p[j].b : p[j].c; };
      const T both = L(0) * p[0].gap + L(1) * p[1].gap + L(2) * p[2].gap;
      const T shape = L(0) + L(1) + L(2);
      sum.gap[v] += (1.0 / 12) * (area * (both + shape * total));
      sum.cover[v] += (1.0 / 3) * (area * shape);
    }
    sum.gap[0] += (1.0 / 3) * (area * total);
    sum.cover[0] += area;
  }
  for (auto* part : {&sum.gap, &sum.cover}) (*part)[0] -= (*part)[1] + (*part)[2];
  return sum;
}

// The derivatives of int L_v g by (b, c, gap) of the primary's corners, [v][3 corner + component], by the
// transport theorem: what the gap changes at fixed places, and what the primary's sides sweep over, of which
// the borders of the secondary triangle, that stand still, have no part. No place where sides cross is
// derived: along a side that lies on a border it moves without bound. There two neighbours sweep one against
// the other, whichever covers the strip.
template <class T>
std::array<std::array<T, 9>, 3> gap_derivatives(const std::array<Place<T>, 3>& q, const Polygon<T>& polygon) {
  const T b1 = q[1].b - q[0].b, c1 = q[1].c - q[0].c, b2 = q[2].b - q[0].b, c2 = q[2].c - q[0].c;
  const T inverse = T(1.0) / (b1 * c2 - c1 * b2);
  const T rise1 = q[1].gap - q[0].gap, rise2 = q[2].gap - q[0].gap;
  const T slope_b = (rise1 * c2 - rise2 * c1) * inverse, slope_c = (b1 * rise2 - b2 * rise1) * inverse;
  const auto shares = [&](const T& b, const T& c) -> std::array<T, 3> {
    const T x = b - q[0].b, y = c - q[0].c;
    const T first = (x * c2 - y * b2) * inverse, second = (b1 * y - c1 * x) * inverse;
    return {T(1.0) - first - second, first, second};
  };
  std::array<std::array<T, 9>, 3> D;
  for (auto& row : D) row.fill(T(0.0));
  for (std::size_t j = 0; j < 3; ++j) {
    Polygon<T> weighted = polygon;
    for (std::size_t i = 0; i < polygon.count; ++i)
      weighted.place[i].gap = shares(polygon.place[i].b, polygon.place[i].c)[j];
    const std::array<T, 3> share = integrate(weighted).gap;
    for (std::size_t v = 0; v < 3; ++v) {
      D[v][3 * j] -= slope_b * share[v];
      D[v][3 * j + 1] -= slope_c * share[v];
      D[v][3 * j + 2] += share[v];
    }
  }
  for (std::size_t i = 0; i < polygon.count; ++i) {
    if (polygon.side[i] == border) continue;
    const auto s = static_cast<std::size_t>(polygon.side[i]);
    const Place<T>&from = polygon.place[i], &to = polygon.place[(i + 1) % polygon.count];
    const T along_b = to.b - from.b, along_c = to.c - from.c;
    // Two Gauss points: L_v, g and the motion are linear. Twice, as in integrate, and half for each point.
    for (const double x : {0.5 - std::sqrt(1.0 / 12), 0.5 + std::sqrt(1.0 / 12)}) {
      const T b = from.b + x * along_b, c = from.c + x * along_c, gap = from.gap + x * (to.gap - from.gap);
      const std::array<T, 3> share = shares(b, c), L = {T(1.0) - b - c, b, c};
      for (std::size_t v = 0; v < 3; ++v)
        for (const std::size_t j : {around[s], around[(s + 1) % 3]}) {
          const T swept = L[v] * gap * share[j];
          D[v][3 * j] += swept * along_c;
          D[v][3 * j + 1] -= swept * along_b;
        }
    }
  }
  return D;
}

std::array<Place<double>, 3> places_of(const Triangle& s, const Triangle& p) {
  const Point3 e1 = minus(s[1], s[0]), e2 = minus(s[2], s[0]);
  return {project(e1, e2, minus(p[0], s[0])), project(e1, e2, minus(p[1], s[0])),
          project(e1, e2, minus(p[2], s[0]))};
}

// False where the projections certainly do not meet, or the primary does not run against the secondary.
bool may_cover(const std::array<Place<double>, 3>& p) {
  const auto all = [&](auto&& outside) { return outside(p[0]) && outside(p[1]) && outside(p[2]); };
  return !all([](const Place<double>& q) { return q.b < 0; }) &&
         !all([](const Place<double>& q) { return q.c < 0; }) &&
         !all([](const Place<double>& q) { return 1 - q.b - q.c < 0; }) && twice_area(p[0], p[2], p[1]) > 0;
}

// Barycentric coordinates of a place in a projected primary triangle.
std::array<double, 3> barycentric(const std::array<Place<double>, 3>& q, const Place<double>& here) {
  const double whole = twice_area(q[0], q[2], q[1]);
  return {twice_area(here, q[2], q[1]) / whole, twice_area(q[0], q[2], here) / whole,
          twice_area(q[0], here, q[1]) / whole};
}

// Visits the pairs of triangles that may cover something: visitor(secondary index, weights of both, corners
// of both, places).
template <class Visitor>
void visit_triangles(int corners, const FaceCorners& x, int primary_corners, const FaceCorners& p,
                     Visitor&& visitor) {
  const int count = corners == 3 ? 1 : 4, primary_count = primary_corners == 3 ? 1 : 4;
  for (int i = 0; i < count; ++i) {
    const Weights ws = triangle_weights(corners, i);
    const Triangle s = triangle_of(x, ws);
    for (int j = 0; j < primary_count; ++j) {
      const Weights wp = triangle_weights(primary_corners, j);
      const Triangle t = triangle_of(p, wp);
      const std::array<Place<double>, 3> places = places_of(s, t);
      if (may_cover(places)) visitor(static_cast<std::size_t>(i), ws, wp, s, t, places);
    }
  }
}

// Phi_a at the corners of a triangle of the face.
double function_at(const MortarFace& face, const Weights& w, std::size_t a, std::size_t v) {
  double value = 0;
  for (std::size_t b = 0; b < static_cast<std::size_t>(face.corners); ++b) value += face.phi[a][b] * w[v][b];
  return value;
}

// Projections of the primary's corners with derivatives by (e1, e2, d), and what they make of the integrals:
// two short chains of nine variables instead of one of eighteen.
constexpr int stage = 9;
using First = Dual<double, stage>;
using Second = Dual<First, stage>;

template <class T, class Seed>
Place<T> seeded_projection(const Point3& e1, const Point3& e2, const Point3& d, Seed&& seed_of) {
  Vector<T> E1, E2, D;
  for (std::size_t k = 0; k < 3; ++k) {
    E1[k] = seed_of(e1[k], static_cast<int>(k));
    E2[k] = seed_of(e2[k], static_cast<int>(3 + k));
    D[k] = seed_of(d[k], static_cast<int>(6 + k));
  }
  return project(E1, E2, D);
}

template <class T, class Seed>
std::array<Place<T>, 3> seeded_places(const std::array<Place<double>, 3>& places, Seed&& seed_of) {
  std::array<Place<T>, 3> p;
  for (std::size_t b = 0; b < 3; ++b) {
    const int first = static_cast<int>(3 * b);
    p[b] = {seed_of(places[b].b, first), seed_of(places[b].c, first + 1), seed_of(places[b].gap, first + 2)};
  }
  return p;
}

First first_seed(double value, int i) { return seed<double, stage>(value, i); }
Second second_seed(double value, int i) {
  Second y(seed<double, stage>(value, i));
  y.d[i] = First(1.0);
  return y;
}

// d places / d (s0 s1 s2 p0 p1 p2), [place][18].
using PlaceGradient = std::array<std::array<double, 18>, stage>;

// Puts a row over (e1, e2, d) of primary corner b on the dofs of the six corners.
void spread(const std::array<double, stage>& row, std::size_t b, std::array<double, 18>& out) {
  for (std::size_t k = 0; k < 3; ++k) {
    out[3 + k] += row[k];
    out[6 + k] += row[3 + k];
    out[9 + 3 * b + k] += row[6 + k];
    out[k] -= row[k] + row[3 + k] + row[6 + k];
  }
}

PlaceGradient place_gradient(const Triangle& s, const Triangle& t) {
  PlaceGradient J{};
  const Point3 e1 = minus(s[1], s[0]), e2 = minus(s[2], s[0]);
  for (std::size_t b = 0; b < 3; ++b) {
    const Place<First> p = seeded_projection<First>(e1, e2, minus(t[b], s[0]), first_seed);
    std::size_t row = 3 * b;
    for (const First* value : {&p.b, &p.c, &p.gap}) {
      std::array<double, stage> d;
      std::copy_n(value->d, stage, d.begin());
      spread(d, b, J[row++]);
    }
  }
  return J;
}

// Adds an 18 x 18 block over the corners of two triangles to the 24 x 24 of the two faces.
void add_to_faces(const std::array<double, 324>& block, const Weights& ws, const Weights& wp,
                  std::array<double, 576>& hessian) {
  const auto weights = [&](std::size_t vertex) -> const std::array<double, 4>& {
    return vertex < 3 ? ws[vertex] : wp[vertex - 3];
  };
  for (std::size_t v = 0; v < 6; ++v)
    for (std::size_t a = 0; a < 4; ++a) {
      if (weights(v)[a] == 0) continue;
      const std::size_t row = 3 * (a + (v < 3 ? 0 : 4));
      for (std::size_t w = 0; w < 6; ++w)
        for (std::size_t b = 0; b < 4; ++b) {
          const double factor = weights(v)[a] * weights(w)[b];
          if (factor == 0) continue;
          const std::size_t column = 3 * (b + (w < 3 ? 0 : 4));
          for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j)
              hessian[24 * (row + i) + column + j] += factor * block[18 * (3 * v + i) + 3 * w + j];
        }
    }
}

} // namespace

std::array<std::array<double, 4>, 3> triangle_weights(int corners, int triangle) {
  if (corners == 3) return {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  std::array<std::array<double, 4>, 3> w{};
  w[0][static_cast<std::size_t>(triangle)] = 1;
  w[1][static_cast<std::size_t>((triangle + 1) % 4)] = 1;
  w[2] = {0.25, 0.25, 0.25, 0.25};
  return w;
}

Point3 face_normal(const FaceCorners& x) {
  // A triangle repeats its third corner: the diagonals of the quadrilateral are then two of its sides.
  const Point3 n = cross(minus(x[2], x[0]), minus(x[3], x[1]));
  const double length = std::sqrt(dot(n, n));
  return {n[0] / length, n[1] / length, n[2] / length};
}

std::array<double, 4> nodal_areas(int corners, const FaceCorners& x) {
  std::array<double, 4> area{};
  for (int i = 0; i < (corners == 3 ? 1 : 4); ++i) {
    const Weights w = triangle_weights(corners, i);
    const double third = area_of(triangle_of(x, w)) / 3;
    for (std::size_t v = 0; v < 3; ++v)
      for (std::size_t a = 0; a < 4; ++a) area[a] += third * w[v][a];
  }
  return area;
}

MortarFace make_mortar_face(int corners, const FaceCorners& X, bool dual) {
  MortarFace face;
  face.corners = corners;
  const auto n = static_cast<std::size_t>(corners);
  std::array<std::array<double, 4>, 4> mass{};
  for (int i = 0; i < face.triangles(); ++i) {
    const Weights w = triangle_weights(corners, i);
    const double area = area_of(triangle_of(X, w));
    face.area[static_cast<std::size_t>(i)] = area;
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

FaceView view_face(int corners, const FaceCorners& x, int primary_corners, const FaceCorners& p) {
  double smallest = std::numeric_limits<double>::infinity(), largest = -smallest, sum = 0, part = 0;
  visit_triangles(corners, x, primary_corners, p,
                  [&](std::size_t, const Weights&, const Weights&, const Triangle& s, const Triangle&,
                      const std::array<Place<double>, 3>& places) {
                    const Polygon<double> polygon = covered_polygon(places);
                    const double mine = part_of(polygon), area = area_of(s);
                    if (!(mine > 0)) return;
                    const TriangleGaps<double> sums = integrate(polygon);
                    sum += area * (sums.gap[0] + sums.gap[1] + sums.gap[2]);
                    part += area * mine;
                    for (std::size_t v = 0; v < polygon.count; ++v) {
                      smallest = std::min(smallest, polygon.place[v].gap);
                      largest = std::max(largest, polygon.place[v].gap);
                    }
                  });
  if (part > 0) return {part / area_of(corners, x), smallest, largest, sum / part};
  const Point3 n = face_normal(x);
  for (std::size_t a = 0; a < static_cast<std::size_t>(primary_corners); ++a) {
    const double gap = dot(minus(p[a], x[0]), n);
    smallest = std::min(smallest, gap);
    largest = std::max(largest, gap);
  }
  return {0, smallest, largest, (smallest + largest) / 2};
}

double common_part(int corners, const FaceCorners& x, int a_corners, const FaceCorners& a, int b_corners,
                   const FaceCorners& b) {
  double common = 0;
  visit_triangles(corners, x, a_corners, a,
                  [&](std::size_t, const Weights&, const Weights&, const Triangle& s, const Triangle&,
                      const std::array<Place<double>, 3>& places) {
                    const Polygon<double> first = covered_polygon(places);
                    if (!(part_of(first) > 0)) return;
                    for (int j = 0; j < (b_corners == 3 ? 1 : 4); ++j) {
                      const auto other = places_of(s, triangle_of(b, triangle_weights(b_corners, j)));
                      if (!may_cover(other)) continue;
                      Polygon<double> both = first;
                      for (std::size_t e : {0, 2, 1}) {
                        const Place<double>&from = other[e], &to = other[(e + 2) % 3];
                        both = cut(both, [&](const Place<double>& q) { return twice_area(from, to, q); });
                      }
                      common += area_of(s) * part_of(both);
                    }
                  });
  return common / area_of(corners, x);
}

FaceWeights mortar_face_weights(const FaceCorners& x, int primary_corners, const FaceCorners& p,
                                const MortarFace& face) {
  FaceWeights weights;
  const auto n = static_cast<std::size_t>(face.corners);
  visit_triangles(
      face.corners, x, primary_corners, p,
      [&](std::size_t i, const Weights& ws, const Weights& wp, const Triangle&, const Triangle&,
          const std::array<Place<double>, 3>& places) {
        Polygon<double> polygon = covered_polygon(places);
        if (!(part_of(polygon) > 0)) return;
        weights.covered = true;
        // int L_v f for the six functions f: in the place of the gap.
        for (std::size_t u = 0; u < 6; ++u) {
          for (std::size_t k = 0; k < polygon.count; ++k) {
            Place<double>& q = polygon.place[k];
            q.gap = u == 0 ? 1 - q.b - q.c : u == 1 ? q.b : u == 2 ? q.c : barycentric(places, q)[u - 3];
          }
          const std::array<double, 3> sums = integrate(polygon).gap;
          for (std::size_t a = 0; a < n; ++a)
            for (std::size_t v = 0; v < 3; ++v) {
              const double phi = face.area[i] * function_at(face, ws, a, v) * sums[v];
              for (std::size_t b = 0; b < 4; ++b)
                if (u < 3)
                  weights.D[a][b] += phi * ws[u][b];
                else
                  weights.M[a][b] += phi * wp[u - 3][b];
            }
        }
      });
  return weights;
}

bool corner_gap(int corners, const FaceCorners& x, int corner, int primary_corners, const FaceCorners& p,
                double& gap) {
  // The corner is the first one of the triangle with its number, or a corner of the only one.
  const Triangle s = triangle_of(x, triangle_weights(corners, corners == 3 ? 0 : corner));
  const std::size_t v = corners == 3 ? static_cast<std::size_t>(corner) : 0;
  const Place<double> here = {v == 1 ? 1.0 : 0.0, v == 2 ? 1.0 : 0.0, 0};
  for (int j = 0; j < (primary_corners == 3 ? 1 : 4); ++j) {
    const auto q = places_of(s, triangle_of(p, triangle_weights(primary_corners, j)));
    if (!(twice_area(q[0], q[2], q[1]) > 0)) continue;
    const std::array<double, 3> L = barycentric(q, here);
    if (std::min({L[0], L[1], L[2]}) < -1e-9) continue;
    gap = L[0] * q[0].gap + L[1] * q[1].gap + L[2] * q[2].gap;
    return true;
  }
  return false;
}

MortarFacePair mortar_face_pair(const FaceCorners& x, int primary_corners, const FaceCorners& p,
                                const MortarFace& face, bool with_gradient) {
  MortarFacePair pair;
  const auto n = static_cast<std::size_t>(face.corners);
  visit_triangles(face.corners, x, primary_corners, p,
                  [&](std::size_t i, const Weights& ws, const Weights& wp, const Triangle& s,
                      const Triangle& t, const std::array<Place<double>, 3>& places) {
                    const Polygon<double> polygon = covered_polygon(places);
                    if (polygon.count < 3) return;
                    pair.touched = true;
                    pair.covered = pair.covered || part_of(polygon) > 0;
                    const TriangleGaps<double> sums = integrate(polygon);
                    for (std::size_t a = 0; a < n; ++a)
                      for (std::size_t v = 0; v < 3; ++v) {
                        const double phi = face.area[i] * function_at(face, ws, a, v);
                        pair.gap[a] += phi * sums.gap[v];
                        pair.cover[a] += phi * sums.cover[v];
                      }
                    if (!with_gradient) return;
                    const auto by_place = gap_derivatives(places, polygon);
                    const PlaceGradient J = place_gradient(s, t);
                    std::array<std::array<double, 18>, 3> gradient{};
                    for (std::size_t v = 0; v < 3; ++v)
                      for (std::size_t q = 0; q < stage; ++q)
                        for (std::size_t k = 0; k < 18; ++k) gradient[v][k] += by_place[v][q] * J[q][k];
                    for (std::size_t a = 0; a < n; ++a) {
                      std::array<double, 18> row{};
                      for (std::size_t v = 0; v < 3; ++v) {
                        const double phi = face.area[i] * function_at(face, ws, a, v);
                        for (std::size_t k = 0; k < 18; ++k) row[k] += phi * gradient[v][k];
                      }
                      for (std::size_t v = 0; v < 6; ++v)
                        for (std::size_t b = 0; b < 4; ++b) {
                          const double weight = v < 3 ? ws[v][b] : wp[v - 3][b];
                          for (std::size_t k = 0; k < 3; ++k)
                            pair.gradient[a][3 * (b + (v < 3 ? 0 : 4)) + k] += weight * row[3 * v + k];
                        }
                    }
                  });
  return pair;
}

bool add_mortar_face_hessian(const FaceCorners& x, int primary_corners, const FaceCorners& p,
                             const MortarFace& face, const std::array<double, 4>& factor,
                             std::array<double, 576>& hessian) {
  bool touched = false;
  visit_triangles(face.corners, x, primary_corners, p,
                  [&](std::size_t i, const Weights& ws, const Weights& wp, const Triangle& s,
                      const Triangle& t, const std::array<Place<double>, 3>& places) {
                    if (covered_polygon(places).count < 3) return;
                    touched = true;
                    std::array<double, 3> f{};
                    for (std::size_t a = 0; a < static_cast<std::size_t>(face.corners); ++a)
                      for (std::size_t v = 0; v < 3; ++v)
                        f[v] += face.area[i] * factor[a] * function_at(face, ws, a, v);
                    const std::array<Place<First>, 3> seeded = seeded_places<First>(places, first_seed);
                    const auto by_place = gap_derivatives(seeded, covered_polygon(seeded));
                    std::array<First, stage> sum; // first derivatives, and of those the second ones
                    for (std::size_t q = 0; q < stage; ++q)
                      sum[q] = f[0] * by_place[0][q] + f[1] * by_place[1][q] + f[2] * by_place[2][q];
                    const PlaceGradient J = place_gradient(s, t);
                    // J^T G'' J
                    std::array<std::array<double, 18>, stage> GJ{};
                    for (std::size_t q = 0; q < stage; ++q)
                      for (std::size_t r = 0; r < stage; ++r)
                        for (std::size_t k = 0; k < 18; ++k) GJ[q][k] += sum[q].d[r] * J[r][k];
                    std::array<double, 324> block{};
                    for (std::size_t q = 0; q < stage; ++q)
                      for (std::size_t k = 0; k < 18; ++k)
                        for (std::size_t m = 0; m < 18; ++m) block[18 * k + m] += J[q][k] * GJ[q][m];
                    // sum_q G'_q q''
                    const Point3 e1 = minus(s[1], s[0]), e2 = minus(s[2], s[0]);
                    for (std::size_t b = 0; b < 3; ++b) {
                      const Place<Second> place =
                          seeded_projection<Second>(e1, e2, minus(t[b], s[0]), second_seed);
                      const Second weighted = First(sum[3 * b].v) * place.b +
                                              First(sum[3 * b + 1].v) * place.c +
                                              First(sum[3 * b + 2].v) * place.gap;
                      std::array<std::array<double, 18>, stage> half{};
                      for (std::size_t q = 0; q < stage; ++q) {
                        std::array<double, stage> row;
                        std::copy_n(weighted.d[q].d, stage, row.begin());
                        spread(row, b, half[q]);
                      }
                      for (std::size_t k = 0; k < 18; ++k) {
                        std::array<double, stage> column;
                        for (std::size_t q = 0; q < stage; ++q) column[q] = half[q][k];
                        std::array<double, 18> whole{};
                        spread(column, b, whole);
                        for (std::size_t m = 0; m < 18; ++m) block[18 * m + k] += whole[m];
                      }
                    }
                    add_to_faces(block, ws, wp, hessian);
                  });
  return touched;
}

} // namespace impact
