#include "mortar_triangles.hpp"

/// Weighted gaps of two faces and their derivatives.
namespace impact {

using namespace mortar;

namespace {

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
