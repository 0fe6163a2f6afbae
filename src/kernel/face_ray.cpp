#include <algorithm>
#include <cmath>
#include <impact/kernel/face_ray.hpp>
#include <impact/math/dual.hpp>
#include <impact/math/vector3.hpp>
#include <limits>

namespace impact {

namespace {

// The gap is a function of 2 dim - 1 vectors, each a sum over the nodes of both facets: from the point to a
// place of the primary's plane, dim - 1 that span the secondary facet, dim - 1 that span the primary.
template <std::size_t dim> constexpr std::size_t vectors = 2 * dim - 1;
template <std::size_t dim> constexpr std::size_t variables = dim* vectors<dim>;
template <class T, std::size_t dim> using Spans = std::array<std::array<T, dim>, vectors<dim>>;
// [vector][secondary nodes, primary nodes]
template <std::size_t dim, std::size_t nodes>
using SpanWeights = std::array<std::array<double, 2 * nodes>, vectors<dim>>;

using impact::dot;
template <class T> T dot(const std::array<T, 2>& a, const std::array<T, 2>& b) {
  return a[0] * b[0] + a[1] * b[1];
}

SpanWeights<3, 4> weights_of(const FaceRay& ray) {
  SpanWeights<3, 4> w{};
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

// The plane that touches the primary facet at a place.
template <class Facet>
SpanWeights<CurvedRay<Facet>::dim, Facet::nodes> weights_of(const CurvedRay<Facet>& ray,
                                                            const FacetPlace<Facet>& place) {
  constexpr std::size_t nodes = Facet::nodes, sides = Facet::dim;
  SpanWeights<CurvedRay<Facet>::dim, nodes> w{};
  for (std::size_t a = 0; a < nodes; ++a) {
    w[0][a] = -ray.at.N[a];
    w[0][nodes + a] = place.N[a];
    for (std::size_t i = 0; i < sides; ++i) {
      w[1 + i][a] = ray.at.dN[a][i];
      w[1 + sides + i][nodes + a] = place.dN[a][i];
    }
  }
  return w;
}

// Seen from the first node: the weights of each vector add to zero.
template <std::size_t dim, std::size_t nodes>
Spans<double, dim> spans_of(const SpanWeights<dim, nodes>& w,
                            const std::array<std::array<double, dim>, nodes>& x,
                            const std::array<std::array<double, dim>, nodes>& p) {
  Spans<double, dim> y{};
  for (std::size_t k = 0; k < vectors<dim>; ++k)
    for (std::size_t a = 0; a < 2 * nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i)
        y[k][i] += w[k][a] * ((a < nodes ? x[a] : p[a - nodes])[i] - x[0][i]);
  return y;
}

// Outward, of the sides that begin there: to the right of the way along an edge.
template <class T, std::size_t dim> std::array<T, dim> area_vector(const std::array<T, dim>* side) {
  if constexpr (dim == 3)
    return cross(side[0], side[1]);
  else
    return {side[0][1], -side[0][0]};
}
// Adds the derivative of w.area_vector by the sides.
template <class T, std::size_t dim>
void add_by_sides(const std::array<T, dim>* side, const std::array<T, dim>& w, std::array<T, dim>* sum) {
  if constexpr (dim == 3) {
    const std::array<T, 3> first = cross(side[1], w), second = cross(w, side[0]);
    for (std::size_t k = 0; k < 3; ++k) {
      sum[0][k] += first[k];
      sum[1][k] += second[k];
    }
  } else {
    sum[0][0] -= w[1];
    sum[0][1] += w[0];
  }
}

template <class T, std::size_t dim> struct Ray {
  T gap, along; // along: n.m
  std::array<T, dim> n, m;
  T area; // of n before it was a unit vector
};
template <class T, std::size_t dim> Ray<T, dim> ray_of(const Spans<T, dim>& y) {
  using std::sqrt;
  Ray<T, dim> ray;
  ray.n = area_vector(&y[1]);
  ray.area = sqrt(dot(ray.n, ray.n));
  const T inverse = T(1.0) / ray.area;
  for (T& component : ray.n) component = component * inverse;
  ray.m = area_vector(&y[dim]);
  ray.along = dot(ray.n, ray.m);
  ray.gap = dot(y[0], ray.m) / ray.along;
  return ray;
}

// dg by the vectors.
template <class T, std::size_t dim> Spans<T, dim> gradient_of(const Spans<T, dim>& y) {
  const Ray<T, dim> ray = ray_of<T, dim>(y);
  const T inverse = T(1.0) / ray.along;
  Spans<T, dim> g;
  for (auto& vector : g) vector.fill(T(0.0));
  std::array<T, dim> of_m, of_d; // d: the area vector of the secondary facet
  const T turn = -(ray.gap * inverse) / ray.area;
  for (std::size_t i = 0; i < dim; ++i) {
    g[0][i] = inverse * ray.m[i];
    of_m[i] = inverse * (y[0][i] - ray.gap * ray.n[i]);
    of_d[i] = turn * (ray.m[i] - ray.along * ray.n[i]);
  }
  add_by_sides(&y[1], of_d, &g[1]);
  add_by_sides(&y[dim], of_m, &g[dim]);
  return g;
}

template <std::size_t dim, std::size_t nodes>
std::array<double, 2 * dim * nodes> row_of(const SpanWeights<dim, nodes>& w, const Spans<double, dim>& g) {
  std::array<double, 2 * dim * nodes> row{};
  for (std::size_t k = 0; k < vectors<dim>; ++k)
    for (std::size_t a = 0; a < 2 * nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i) row[dim * a + i] += w[k][a] * g[k][i];
  return row;
}

template <std::size_t dim, std::size_t nodes>
void add_hessian(const SpanWeights<dim, nodes>& w, const Spans<double, dim>& at, double factor,
                 std::span<double> hessian) {
  constexpr std::size_t n = variables<dim>, dofs = 2 * dim * nodes;
  using D = Dual<double, static_cast<int>(n)>;
  Spans<D, dim> y;
  for (std::size_t i = 0; i < n; ++i)
    y[i / dim][i % dim] = seed<double, static_cast<int>(n)>(at[i / dim][i % dim], static_cast<int>(i));
  const Spans<D, dim> g = gradient_of<D, dim>(y);
  // H = sum_kl w_k (x) w_l (x) H_kl: first over l, then over k.
  std::array<std::array<double, dofs>, n> half{};
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t l = 0; l < vectors<dim>; ++l)
      for (std::size_t b = 0; b < 2 * nodes; ++b)
        for (std::size_t j = 0; j < dim; ++j)
          half[i][dim * b + j] += w[l][b] * g[i / dim][i % dim].d[dim * l + j];
  for (std::size_t k = 0; k < vectors<dim>; ++k)
    for (std::size_t a = 0; a < 2 * nodes; ++a) {
      const double weight = factor * w[k][a];
      if (weight == 0) continue;
      for (std::size_t i = 0; i < dim; ++i)
        for (std::size_t j = 0; j < dofs; ++j)
          hessian[dofs * (dim * a + i) + j] += weight * half[dim * k + i][j];
    }
}

// Vectors in the primary's plane that are dual to its sides y.
template <std::size_t dim>
std::array<std::array<double, dim>, dim - 1> dual_sides(const Spans<double, dim>& y,
                                                        const std::array<double, dim>& m) {
  const double square = dot(m, m);
  std::array<std::array<double, dim>, dim - 1> dual;
  if constexpr (dim == 3)
    dual = {cross(y[4], m), cross(m, y[3])};
  else
    dual = {y[2]};
  for (auto& vector : dual)
    for (double& component : vector) component /= square;
  return dual;
}

} // namespace

RayFoot cast_ray(const FaceRay& cast) {
  const Spans<double, 3> y = spans_of(weights_of(cast), cast.x, cast.p);
  const Ray<double, 3> ray = ray_of<double, 3>(y);
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
  const SpanWeights<3, 4> w = weights_of(ray);
  return row_of<3, 4>(w, gradient_of<double, 3>(spans_of(w, ray.x, ray.p)));
}

void add_ray_hessian(const FaceRay& ray, double factor, std::span<double> hessian) {
  const SpanWeights<3, 4> w = weights_of(ray);
  add_hessian<3, 4>(w, spans_of(w, ray.x, ray.p), factor, hessian);
}

template <class Facet>
CurvedFoot<Facet> cast_ray(const CurvedRay<Facet>& cast, const typename Facet::Point& start) {
  constexpr std::size_t dim = CurvedRay<Facet>::dim;
  // Steps that are quadratically smaller than the last one are rounding after one that was below `small`.
  constexpr double small = 1e-7, farthest = 3;
  constexpr int most_steps = 15;
  CurvedFoot<Facet> foot;
  foot.xi = start;
  bool found = false;
  for (int i = 0; i < most_steps; ++i) {
    foot.place = FacetPlace<Facet>::at(foot.xi);
    const auto y = spans_of(weights_of(cast, foot.place), cast.x, cast.p);
    const Ray<double, dim> ray = ray_of<double, dim>(y);
    foot.gap = ray.gap;
    const double length = std::sqrt(dot(ray.m, ray.m));
    foot.opposition = ray.along / length;
    for (std::size_t k = 0; k < dim; ++k) foot.normal[k] = ray.m[k] / length;
    const auto part = Facet::Corners::N(foot.xi);
    std::copy(part.begin(), part.end(), foot.part.begin());
    if (found) return foot;
    std::array<double, dim> r; // to where the ray meets the plane
    for (std::size_t k = 0; k < dim; ++k) r[k] = ray.gap * ray.n[k] - y[0][k];
    const auto dual = dual_sides<dim>(y, ray.m);
    found = true;
    for (std::size_t s = 0; s < dual.size(); ++s) {
      const double step = dot(r, dual[s]);
      foot.xi[s] += step;
      found = found && std::abs(step) < small;
      if (!(std::abs(foot.xi[s]) < farthest)) i = most_steps;
    }
  }
  foot.part.fill(-std::numeric_limits<double>::infinity());
  return foot;
}

template <class Facet>
std::array<double, CurvedRay<Facet>::dofs> ray_gradient(const CurvedRay<Facet>& ray,
                                                        const CurvedFoot<Facet>& foot) {
  // The foot moves in the plane that touches the facet there, to first order.
  constexpr std::size_t dim = CurvedRay<Facet>::dim;
  const auto w = weights_of(ray, foot.place);
  return row_of<dim, Facet::nodes>(w, gradient_of<double, dim>(spans_of(w, ray.x, ray.p)));
}

template <class Facet>
void add_ray_hessian(const CurvedRay<Facet>& ray, const CurvedFoot<Facet>& foot, double factor,
                     std::span<double> hessian) {
  // To second order the facet leaves that plane by half of y_ij xi_i xi_j: d2g is that of the plane and
  // m.y_ij/(n.m) dxi_i (x) dxi_j.
  constexpr std::size_t dim = CurvedRay<Facet>::dim, nodes = Facet::nodes, dofs = CurvedRay<Facet>::dofs;
  const auto d2N = second_derivatives<Facet>(foot.xi);
  const auto w = weights_of(ray, foot.place);
  const Spans<double, dim> y = spans_of(w, ray.x, ray.p), dg = gradient_of<double, dim>(y);
  add_hessian<dim, nodes>(w, y, factor, hessian);
  const Ray<double, dim> at = ray_of<double, dim>(y);
  const auto dual = dual_sides<dim>(y, at.m);
  std::array<std::array<double, dofs>, dim - 1> dxi;
  for (std::size_t s = 0; s < dual.size(); ++s) {
    const double along = dot(at.n, dual[s]);
    Spans<double, dim> by_spans;
    std::array<double, dim> turn;
    for (std::size_t k = 0; k < dim; ++k) {
      for (std::size_t v = 0; v < by_spans.size(); ++v) by_spans[v][k] = along * dg[v][k];
      by_spans[0][k] -= dual[s][k];
      turn[k] = at.gap / at.area * (dual[s][k] - along * at.n[k]);
    }
    add_by_sides(&y[1], turn, &by_spans[1]);
    dxi[s] = row_of<dim, nodes>(w, by_spans);
  }
  for (std::size_t s = 0; s < dual.size(); ++s)
    for (std::size_t t = 0; t < dual.size(); ++t) {
      double bend = 0;
      for (std::size_t b = 0; b < nodes; ++b)
        for (std::size_t k = 0; k < dim; ++k) bend += d2N[b][s][t] * at.m[k] * (ray.p[b][k] - ray.p[0][k]);
      bend *= factor / at.along;
      for (std::size_t i = 0; i < dofs; ++i)
        for (std::size_t j = 0; j < dofs; ++j) hessian[dofs * i + j] += bend * dxi[s][i] * dxi[t][j];
    }
}

template <class Facet>
std::array<double, Facet::dim + 1> facet_area(const typename CurvedRay<Facet>::Nodes& x,
                                              const FacetPlace<Facet>& place) {
  std::array<std::array<double, Facet::dim + 1>, Facet::dim> side{};
  for (std::size_t a = 0; a < x.size(); ++a)
    for (std::size_t i = 0; i < side.size(); ++i)
      for (std::size_t k = 0; k < side[i].size(); ++k) side[i][k] += place.dN[a][i] * (x[a][k] - x[0][k]);
  return area_vector(side.data());
}

template CurvedFoot<Line3> cast_ray(const CurvedRay<Line3>&, const Line3::Point&);
template std::array<double, 12> ray_gradient(const CurvedRay<Line3>&, const CurvedFoot<Line3>&);
template void add_ray_hessian(const CurvedRay<Line3>&, const CurvedFoot<Line3>&, double, std::span<double>);
template std::array<double, 2> facet_area<Line3>(const CurvedRay<Line3>::Nodes&, const FacetPlace<Line3>&);
template CurvedFoot<Tri6> cast_ray(const CurvedRay<Tri6>&, const Tri6::Point&);
template std::array<double, 36> ray_gradient(const CurvedRay<Tri6>&, const CurvedFoot<Tri6>&);
template void add_ray_hessian(const CurvedRay<Tri6>&, const CurvedFoot<Tri6>&, double, std::span<double>);
template std::array<double, 3> facet_area<Tri6>(const CurvedRay<Tri6>::Nodes&, const FacetPlace<Tri6>&);
template CurvedFoot<Quad8> cast_ray(const CurvedRay<Quad8>&, const Quad8::Point&);
template std::array<double, 48> ray_gradient(const CurvedRay<Quad8>&, const CurvedFoot<Quad8>&);
template void add_ray_hessian(const CurvedRay<Quad8>&, const CurvedFoot<Quad8>&, double, std::span<double>);
template std::array<double, 3> facet_area<Quad8>(const CurvedRay<Quad8>::Nodes&, const FacetPlace<Quad8>&);
template CurvedFoot<Quad9> cast_ray(const CurvedRay<Quad9>&, const Quad9::Point&);
template std::array<double, 54> ray_gradient(const CurvedRay<Quad9>&, const CurvedFoot<Quad9>&);
template void add_ray_hessian(const CurvedRay<Quad9>&, const CurvedFoot<Quad9>&, double, std::span<double>);
template std::array<double, 3> facet_area<Quad9>(const CurvedRay<Quad9>::Nodes&, const FacetPlace<Quad9>&);

} // namespace impact
