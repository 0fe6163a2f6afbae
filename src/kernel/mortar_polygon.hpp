#pragma once
#include <array>
#include <cmath>
#include <impact/math/dual.hpp>
#include <impact/math/vector3.hpp>

/// The part of a secondary triangle that a projected primary triangle covers: a polygon on which the gap is
/// linear, its integrals, and their derivatives by the places of the primary's corners (mortar_face.hpp).
namespace impact::mortar {

inline double real_part(double x) { return x; }
template <class B, int n> double real_part(const Dual<B, n>& x) { return real_part(x.v); }

// A place on the secondary triangle (its second and third barycentric coordinate) and the gap there. `a`, the
// first coordinate, in polygons alone: carried along like the others, its small values mean as much as
// theirs. Taken from b and c they would be rounding, and two neighbours not agree on which side of the border
// their common side lies.
template <class T> struct Place {
  T b, c, gap;
  T a = T(0.0);
};

// Where a point lies along the normal of the triangle (0, e1, e2).
template <class T> Place<T> project(const Vector3Of<T>& e1, const Vector3Of<T>& e2, const Vector3Of<T>& d) {
  using std::sqrt;
  const Vector3Of<T> N = cross(e1, e2);
  const T square = dot(N, N), inverse = T(1.0) / square;
  return {dot(cross(d, e2), N) * inverse, dot(cross(e1, d), N) * inverse, dot(d, N) / sqrt(square)};
}

inline constexpr int border = -1;

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
inline constexpr std::array<std::size_t, 3> around = {0, 2, 1};

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

inline double part_of(const Polygon<double>& polygon) {
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

} // namespace impact::mortar
