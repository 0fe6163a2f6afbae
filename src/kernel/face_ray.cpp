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

// Of the secondary nodes.
SpanWeights<3, 4> weights_of_secondary(const FaceRay& ray) {
  SpanWeights<3, 4> w{};
  for (std::size_t a = 0; a < 4; ++a) w[0][a] = -ray.shape[a];
  // Two sides of a triangle, the diagonals of a quadrilateral.
  const bool triangle = corners_of(ray.x) == 3;
  w[1][0] = w[2][triangle ? 0 : 1] = -1;
  w[1][triangle ? 1 : 2] = w[2][triangle ? 2 : 3] = 1;
  return w;
}
template <class Facet>
SpanWeights<CurvedRay<Facet>::dim, Facet::nodes> weights_of_secondary(const CurvedRay<Facet>& ray) {
  SpanWeights<CurvedRay<Facet>::dim, Facet::nodes> w{};
  for (std::size_t a = 0; a < Facet::nodes; ++a) {
    w[0][a] = -ray.at.N[a];
    for (std::size_t i = 0; i < Facet::dim; ++i) w[1 + i][a] = ray.at.dN[a][i];
  }
  return w;
}
// Of all nodes, those of the primary for the plane that touches their facet at a place.
template <class Ray>
SpanWeights<Ray::dim, Ray::nodes> weights_of(const Ray& ray, const typename Ray::Place& place) {
  auto w = weights_of_secondary(ray);
  for (std::size_t a = 0; a < Ray::nodes; ++a) {
    w[0][Ray::nodes + a] = place.N[a];
    for (std::size_t i = 0; i + 1 < Ray::dim; ++i) w[Ray::dim + i][Ray::nodes + a] = place.dN[a][i];
  }
  return w;
}

bool on_triangle(const FaceRay& ray) { return corners_of(ray.p) == 3; }

// What a step of Newton's method misses of a facet, as a part of the square of its length, about.
double bend_of(const FaceRay& ray) {
  if (on_triangle(ray)) return 0;
  double bend = 0, first = 0, second = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double one = ray.p[1][k] - ray.p[0][k], other = ray.p[3][k] - ray.p[0][k],
                 both = ray.p[2][k] - ray.p[1][k] - other;
    bend += both * both;
    first += one * one;
    second += other * other;
  }
  return std::sqrt(bend / std::min(first, second));
}
template <class Facet> double bend_of(const CurvedRay<Facet>&) { return 1; }

FaceRay::Place place_at(const FaceRay& ray, const FaceRay::Point& xi) {
  if (!on_triangle(ray)) return FaceRay::Place::at(xi);
  const auto of = FacetPlace<Tri3>::at(xi);
  FaceRay::Place place;
  std::copy(of.N.begin(), of.N.end(), place.N.begin());
  std::copy(of.dN.begin(), of.dN.end(), place.dN.begin());
  return place;
}
template <class Facet> FacetPlace<Facet> place_at(const CurvedRay<Facet>&, const typename Facet::Point& xi) {
  return FacetPlace<Facet>::at(xi);
}

std::array<double, 4> parts_at(const FaceRay& ray, const RayFoot<FaceRay>& foot) {
  const auto& [xi, eta] = foot.xi;
  if (on_triangle(ray)) return {1 - xi - eta, xi, eta, 1};
  return {1 - xi, 1 + xi, 1 - eta, 1 + eta};
}
template <class Facet> auto parts_at(const CurvedRay<Facet>&, const RayFoot<CurvedRay<Facet>>& foot) {
  return Facet::Corners::N(foot.xi);
}

std::array<std::array<FaceRay::Point, 2>, 4> bends_at(const FaceRay& ray, const FaceRay::Point& xi) {
  if (on_triangle(ray)) return {};
  return second_derivatives<Quad4>(xi);
}
template <class Facet> auto bends_at(const CurvedRay<Facet>&, const typename Facet::Point& xi) {
  return second_derivatives<Facet>(xi);
}

// Where nodes stand seen from the secondary's first one: the weights of each vector add to zero.
template <std::size_t dim, std::size_t nodes>
std::array<std::array<double, dim>, nodes> seen_from(const std::array<double, dim>& origin,
                                                     std::array<std::array<double, dim>, nodes> node) {
  for (auto& place : node)
    for (std::size_t k = 0; k < dim; ++k) place[k] -= origin[k];
  return node;
}
// What the secondary nodes make of the vectors, and what the primary ones add, so seen, at a place.
template <std::size_t dim, std::size_t nodes>
Spans<double, dim> secondary_spans(const SpanWeights<dim, nodes>& w,
                                   const std::array<std::array<double, dim>, nodes>& x) {
  Spans<double, dim> y{};
  for (std::size_t v = 0; v < dim; ++v)
    for (std::size_t a = 1; a < nodes; ++a)
      for (std::size_t k = 0; k < dim; ++k) y[v][k] += w[v][a] * (x[a][k] - x[0][k]);
  return y;
}
template <class Place, std::size_t dim, std::size_t nodes>
void add_primary(const Place& place, const std::array<std::array<double, dim>, nodes>& p,
                 Spans<double, dim>& y) {
  for (std::size_t a = 0; a < nodes; ++a)
    for (std::size_t k = 0; k < dim; ++k) {
      y[0][k] += place.N[a] * p[a][k];
      for (std::size_t i = 0; i + 1 < dim; ++i) y[dim + i][k] += place.dN[a][i] * p[a][k];
    }
}
template <class Ray>
Spans<double, Ray::dim> spans_of(const Ray& ray, const SpanWeights<Ray::dim, Ray::nodes>& w,
                                 const typename Ray::Place& place) {
  Spans<double, Ray::dim> y = secondary_spans(w, ray.x);
  add_primary(place, seen_from(ray.x[0], ray.p), y);
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

template <class T, std::size_t dim> struct Gap {
  T gap, along; // along: n.m
  std::array<T, dim> n, m;
  T area; // of n before it was a unit vector
};
// Where the secondary facet looks, and what stands in the way.
template <class T, std::size_t dim> void aim(const Spans<T, dim>& y, Gap<T, dim>& ray) {
  using std::sqrt;
  ray.n = area_vector(&y[1]);
  ray.area = sqrt(dot(ray.n, ray.n));
  const T inverse = T(1.0) / ray.area;
  for (T& component : ray.n) component = component * inverse;
}
template <class T, std::size_t dim> void meet(const Spans<T, dim>& y, Gap<T, dim>& ray) {
  ray.m = area_vector(&y[dim]);
  ray.along = dot(ray.n, ray.m);
  ray.gap = dot(y[0], ray.m) / ray.along;
}
template <class T, std::size_t dim> Gap<T, dim> gap_of(const Spans<T, dim>& y) {
  Gap<T, dim> ray;
  aim<T, dim>(y, ray);
  meet<T, dim>(y, ray);
  return ray;
}

// dg by the vectors.
template <class T, std::size_t dim> Spans<T, dim> gradient_of(const Spans<T, dim>& y) {
  const Gap<T, dim> ray = gap_of<T, dim>(y);
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
  // The spans of either facet have nodes of their own.
  std::array<double, 2 * dim * nodes> row{};
  for (std::size_t k = 0; k < vectors<dim>; ++k)
    for (std::size_t a = k < dim ? 0 : nodes; a < (k == 0 || k >= dim ? 2 * nodes : nodes); ++a)
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
  const double inverse = 1 / dot(m, m);
  std::array<std::array<double, dim>, dim - 1> dual;
  if constexpr (dim == 3)
    dual = {cross(y[4], m), cross(m, y[3])};
  else
    dual = {y[2]};
  for (auto& vector : dual)
    for (double& component : vector) component *= inverse;
  return dual;
}

} // namespace

template <class Ray> RayFoot<Ray> cast_ray(const Ray& cast, const typename Ray::Point& start) {
  constexpr std::size_t dim = Ray::dim;
  constexpr double rounding = 1e-14, farthest = 3; // of the step that would follow; of a foot
  constexpr int most_steps = 15;
  const double bend = bend_of(cast);
  RayFoot<Ray> foot;
  foot.xi = start;
  bool found = false;
  const Spans<double, dim> of_secondary = secondary_spans(weights_of_secondary(cast), cast.x);
  const auto p = seen_from(cast.x[0], cast.p);
  Gap<double, dim> ray;
  aim<double, dim>(of_secondary, ray);
  for (int i = 0; i < most_steps; ++i) {
    foot.place = place_at(cast, foot.xi);
    Spans<double, dim> y = of_secondary;
    add_primary(foot.place, p, y);
    meet<double, dim>(y, ray);
    foot.gap = ray.gap;
    if (found) {
      const double length = std::sqrt(dot(ray.m, ray.m));
      foot.opposition = ray.along / length;
      for (std::size_t k = 0; k < dim; ++k) foot.normal[k] = ray.m[k] / length;
      foot.part = parts_at(cast, foot);
      return foot;
    }
    std::array<double, dim> r; // to where the ray meets the plane
    for (std::size_t k = 0; k < dim; ++k) r[k] = ray.gap * ray.n[k] - y[0][k];
    const auto dual = dual_sides<dim>(y, ray.m);
    found = true;
    for (std::size_t s = 0; s < dual.size(); ++s) {
      const double step = dot(r, dual[s]);
      foot.xi[s] += step;
      found = found && bend * step * step < rounding;
      if (!(std::abs(foot.xi[s]) < farthest)) i = most_steps;
    }
  }
  foot.part.fill(-std::numeric_limits<double>::infinity());
  return foot;
}

template <class Ray> std::array<double, Ray::dofs> ray_gradient(const Ray& ray, const RayFoot<Ray>& foot) {
  // The foot moves in the plane that touches the facet there, to first order.
  constexpr std::size_t dim = Ray::dim;
  const auto w = weights_of(ray, foot.place);
  return row_of<dim, Ray::nodes>(w, gradient_of<double, dim>(spans_of(ray, w, foot.place)));
}

template <class Ray>
void add_ray_hessian(const Ray& ray, const RayFoot<Ray>& foot, double factor, std::span<double> hessian) {
  // To second order the facet leaves that plane by half of y_ij xi_i xi_j: d2g is that of the plane and
  // m.y_ij/(n.m) dxi_i (x) dxi_j.
  constexpr std::size_t dim = Ray::dim, nodes = Ray::nodes, dofs = Ray::dofs;
  const auto d2N = bends_at(ray, foot.xi);
  const auto w = weights_of(ray, foot.place);
  const Spans<double, dim> y = spans_of(ray, w, foot.place), dg = gradient_of<double, dim>(y);
  add_hessian<dim, nodes>(w, y, factor, hessian);
  const Gap<double, dim> at = gap_of<double, dim>(y);
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

#define IMPACT_RAY(Ray)                                                                                      \
  template RayFoot<Ray> cast_ray(const Ray&, const Ray::Point&);                                             \
  template std::array<double, Ray::dofs> ray_gradient(const Ray&, const RayFoot<Ray>&);                      \
  template void add_ray_hessian(const Ray&, const RayFoot<Ray>&, double, std::span<double>);
#define IMPACT_CURVED_RAY(Facet)                                                                             \
  IMPACT_RAY(CurvedRay<Facet>)                                                                               \
  template std::array<double, Facet::dim + 1> facet_area<Facet>(const CurvedRay<Facet>::Nodes&,              \
                                                                const FacetPlace<Facet>&);
IMPACT_RAY(FaceRay)
IMPACT_CURVED_RAY(Line3)
IMPACT_CURVED_RAY(Tri6)
IMPACT_CURVED_RAY(Quad8)
IMPACT_CURVED_RAY(Quad9)

} // namespace impact
