#include <cmath>
#include <impact/kernel/face_ray.hpp>
#include <impact/math/dual.hpp>
#include <impact/math/vector3.hpp>

namespace impact {

namespace {

// The gap is a function of five vectors, each a sum over the corners of both faces: from the point to the
// triangle's first corner, two that span the secondary face, two sides of the triangle.
constexpr int vectors = 5, variables = 3 * vectors;
template <class T> using Spans = std::array<Vector3Of<T>, vectors>;

// [vector][secondary corners, primary corners]
std::array<std::array<double, 8>, vectors> weights_of(const FaceRay& ray) {
  std::array<std::array<double, 8>, vectors> w{};
  for (std::size_t a = 0; a < 4; ++a) {
    w[0][a] = -ray.shape[a];
    w[0][4 + a] = ray.triangle[0][a];
    w[3][4 + a] = ray.triangle[1][a] - ray.triangle[0][a];
    w[4][4 + a] = ray.triangle[2][a] - ray.triangle[0][a];
  }
  // Two sides of a triangle, the diagonals of a quadrilateral.
  const bool triangle = corners_of(ray.x) == 3;
  w[1][0] = w[2][triangle ? 0 : 1] = -1;
  w[1][triangle ? 1 : 2] = w[2][triangle ? 2 : 3] = 1;
  return w;
}

// Seen from the first corner: the weights of each vector add to zero.
Spans<double> spans_of(const FaceRay& ray) {
  const auto w = weights_of(ray);
  Spans<double> y{};
  for (std::size_t k = 0; k < vectors; ++k)
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        y[k][i] += w[k][a] * ((a < 4 ? ray.x[a] : ray.p[a - 4])[i] - ray.x[0][i]);
  return y;
}

template <class T> struct Ray {
  T gap, along; // along: n.m
  Vector3Of<T> n, m;
  T area; // |t1 x t2|
};
template <class T> Ray<T> ray_of(const Spans<T>& y) {
  using std::sqrt;
  Ray<T> ray;
  ray.n = cross(y[1], y[2]);
  ray.area = sqrt(dot(ray.n, ray.n));
  const T inverse = T(1.0) / ray.area;
  for (T& component : ray.n) component = component * inverse;
  ray.m = cross(y[3], y[4]);
  ray.along = dot(ray.n, ray.m);
  ray.gap = dot(y[0], ray.m) / ray.along;
  return ray;
}

// dg by the five vectors.
template <class T> Spans<T> gradient_of(const Spans<T>& y) {
  const Ray<T> ray = ray_of(y);
  const T inverse = T(1.0) / ray.along;
  Spans<T> g;
  Vector3Of<T> of_m, of_d; // d = t1 x t2
  const T turn = -(ray.gap * inverse) / ray.area;
  for (std::size_t i = 0; i < 3; ++i) {
    g[0][i] = inverse * ray.m[i];
    of_m[i] = inverse * (y[0][i] - ray.gap * ray.n[i]);
    of_d[i] = turn * (ray.m[i] - ray.along * ray.n[i]);
  }
  g[1] = cross(y[2], of_d);
  g[2] = cross(of_d, y[1]);
  g[3] = cross(y[4], of_m);
  g[4] = cross(of_m, y[3]);
  return g;
}

} // namespace

RayFoot cast_ray(const FaceRay& cast) {
  const Spans<double> y = spans_of(cast);
  const Ray<double> ray = ray_of(y);
  RayFoot foot;
  foot.gap = ray.gap;
  const double square = dot(ray.m, ray.m), length = std::sqrt(square);
  foot.opposition = ray.along / length;
  Vector3 r; // from the triangle's first corner
  for (std::size_t i = 0; i < 3; ++i) {
    foot.normal[i] = ray.m[i] / length;
    r[i] = ray.gap * ray.n[i] - y[0][i];
  }
  foot.part[1] = dot(cross(r, y[4]), ray.m) / square;
  foot.part[2] = dot(cross(y[3], r), ray.m) / square;
  foot.part[0] = 1 - foot.part[1] - foot.part[2];
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t b = 0; b < 4; ++b) foot.weights[b] += foot.part[v] * cast.triangle[v][b];
  return foot;
}

std::array<double, 24> ray_gradient(const FaceRay& ray) {
  const auto w = weights_of(ray);
  const Spans<double> g = gradient_of(spans_of(ray));
  std::array<double, 24> row{};
  for (std::size_t k = 0; k < vectors; ++k)
    for (std::size_t a = 0; a < 8; ++a)
      for (std::size_t i = 0; i < 3; ++i) row[3 * a + i] += w[k][a] * g[k][i];
  return row;
}

void add_ray_hessian(const FaceRay& ray, double factor, std::span<double> hessian) {
  using D = Dual<double, variables>;
  const auto w = weights_of(ray);
  const Spans<double> at = spans_of(ray);
  Spans<D> y;
  for (std::size_t i = 0; i < variables; ++i)
    y[i / 3][i % 3] = seed<double, variables>(at[i / 3][i % 3], static_cast<int>(i));
  const Spans<D> g = gradient_of(y);
  // H = sum_kl w_k (x) w_l (x) H_kl: first over l, then over k.
  std::array<std::array<double, 24>, variables> half{};
  for (std::size_t i = 0; i < variables; ++i)
    for (std::size_t l = 0; l < vectors; ++l)
      for (std::size_t b = 0; b < 8; ++b)
        for (std::size_t j = 0; j < 3; ++j) half[i][3 * b + j] += w[l][b] * g[i / 3][i % 3].d[3 * l + j];
  for (std::size_t k = 0; k < vectors; ++k)
    for (std::size_t a = 0; a < 8; ++a) {
      const double weight = factor * w[k][a];
      if (weight == 0) continue;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 24; ++j) hessian[24 * (3 * a + i) + j] += weight * half[3 * k + i][j];
    }
}

} // namespace impact
