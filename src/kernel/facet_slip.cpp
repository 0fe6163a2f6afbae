#include <algorithm>
#include <cmath>
#include <impact/kernel/facet_slip.hpp>
#include <impact/math/dual.hpp>
#include <impact/math/index.hpp>

namespace impact {

namespace {

template <class T, std::size_t dim> using Vectors = std::array<std::array<T, dim>, dim - 1>;
template <class T, std::size_t dim> using FrameOf = std::array<std::array<T, dim>, dim>; // tangents, normal

// The rotation of (g_1 g_2) = R U. With J = |g_1 x g_2| and n across both, U is ((g_1 g_2)^T (g_1 g_2) +
// J)/s, s^2 = |g_1|^2 + |g_2|^2 + 2 J, from which r_1 = (g_1 + g_2 x n)/s, r_2 = n x r_1.
template <class T> FrameOf<T, 3> frame_of(const Vectors<T, 3>& g) {
  using std::sqrt;
  Vector3Of<T> n = cross(g[0], g[1]);
  const T J = sqrt(dot(n, n)), inverse_J = T(1.0) / J;
  for (T& component : n) component *= inverse_J;
  const T inverse_s = T(1.0) / sqrt(dot(g[0], g[0]) + dot(g[1], g[1]) + 2.0 * J);
  Vector3Of<T> r1 = cross(g[1], n);
  for (std::size_t k = 0; k < 3; ++k) r1[k] = (g[0][k] + r1[k]) * inverse_s;
  return {r1, cross(n, r1), n};
}
template <class T> FrameOf<T, 2> frame_of(const Vectors<T, 2>& g) {
  using std::sqrt;
  const T inverse = T(1.0) / sqrt(g[0][0] * g[0][0] + g[0][1] * g[0][1]);
  const T x = g[0][0] * inverse, y = g[0][1] * inverse;
  return {{{x, y}, {y, -1.0 * x}}};
}

template <std::size_t dim> constexpr int variables = static_cast<int>(dim*(dim - 1));
template <std::size_t dim> using First = Dual<double, variables<dim>>;
template <std::size_t dim> using Second = Dual<First<dim>, variables<dim>>;

template <class T, std::size_t dim, class Seed>
FrameOf<T, dim> seeded_frame(const Vectors<double, dim>& g, Seed&& seed_of) {
  Vectors<T, dim> y;
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t k = 0; k < dim; ++k) y[i][k] = seed_of(g[i][k], static_cast<int>(dim * i + k));
  return frame_of(y);
}

// Both sums are differences from the first node: their weights add to zero, and rounding is that of
// distances.
template <std::size_t dim, std::size_t nodes>
Vectors<double, dim> tangents_at(const TangentRows<dim, nodes>& row, const FacetNodes<dim, nodes>& x) {
  Vectors<double, dim> g{};
  for (std::size_t i = 0; i < g.size(); ++i)
    for (std::size_t a = 1; a < nodes; ++a)
      for (std::size_t k = 0; k < dim; ++k) g[i][k] += row[i][a] * (x[a][k] - x[0][k]);
  return g;
}
template <std::size_t dim, std::size_t nodes>
std::array<double, dim> vector_of(const Opening<nodes>& opening, const FacetNodes<dim, nodes>& x,
                                  const FacetNodes<dim, nodes>& p) {
  std::array<double, dim> v{};
  for (std::size_t b = 0; b < nodes; ++b)
    for (std::size_t k = 0; k < dim; ++k)
      v[k] += opening.D[b] * (x[b][k] - x[0][k]) - opening.M[b] * (p[b][k] - x[0][k]);
  return v;
}

} // namespace

template <std::size_t dim, std::size_t nodes>
TangentRows<dim, nodes> tangent_rows(const FacetNodes<dim, nodes>& X,
                                     const TangentRows<dim, nodes>& natural) {
  // Gram and Schmidt: tangents at X = axes ((a b), (0 d)).
  Vectors<double, dim> G = tangents_at<dim, nodes>(natural, X);
  TangentRows<dim, nodes> row = natural;
  const auto product = [](const auto& u, const auto& v) {
    double sum = 0;
    for (std::size_t k = 0; k < dim; ++k) sum += u[k] * v[k];
    return sum;
  };
  const auto combine = [&](std::size_t i, double factor, std::size_t j, double scale) {
    for (std::size_t k = 0; k < dim; ++k) G[i][k] = (G[i][k] - factor * G[j][k]) * scale;
    for (std::size_t a = 0; a < nodes; ++a) row[i][a] = (row[i][a] - factor * row[j][a]) * scale;
  };
  combine(0, 0, 0, 1 / std::sqrt(product(G[0], G[0])));
  if constexpr (dim == 3) {
    combine(1, product(G[1], G[0]), 0, 1);
    combine(1, 0, 0, 1 / std::sqrt(product(G[1], G[1])));
  }
  return row;
}

template <std::size_t dim, std::size_t nodes>
SlipDirections<dim, nodes>::SlipDirections(const FacetNodes<dim, nodes>& x,
                                           const TangentRows<dim, nodes>& rows, bool with_gradient)
    : x_(x), rows_(rows), with_gradient_(with_gradient) {
  const Vectors<double, dim> g = tangents_at<dim, nodes>(rows, x);
  if (!with_gradient) {
    frame_ = frame_of(g);
    return;
  }
  const FrameOf<First<dim>, dim> r = seeded_frame<First<dim>, dim>(
      g, [](double value, int i) { return seed<double, impact::variables<dim>>(value, i); });
  for (std::size_t i = 0; i < r.size(); ++i)
    for (std::size_t k = 0; k < dim; ++k) {
      frame_[i][k] = r[i][k].v;
      std::copy_n(r[i][k].d, variables, by_tangents_[i][k].begin());
    }
}

template <std::size_t dim, std::size_t nodes>
std::array<double, dim> SlipDirections<dim, nodes>::components(const std::array<double, dim>& vector) const {
  std::array<double, dim> part{};
  for (std::size_t e = 0; e < dim; ++e)
    for (std::size_t k = 0; k < dim; ++k) part[e] += frame_[e][k] * vector[k];
  return part;
}

template <std::size_t dim, std::size_t nodes>
std::array<double, dim> SlipDirections<dim, nodes>::opened(const FacetNodes<dim, nodes>& p,
                                                           const Opening<nodes>& opening) const {
  return components(vector_of<dim, nodes>(opening, x_, p));
}

template <std::size_t dim, std::size_t nodes>
FacetSlip<dim, nodes> SlipDirections<dim, nodes>::slip(const FacetNodes<dim, nodes>& p,
                                                       const Opening<nodes>& opening,
                                                       const Lean& lean) const {
  FacetSlip<dim, nodes> slip;
  const std::array<double, dim> v = vector_of<dim, nodes>(opening, x_, p);
  for (std::size_t i = 0; i < dim - 1; ++i) {
    std::array<double, dim> r{};
    for (std::size_t e = 0; e < dim; ++e)
      for (std::size_t k = 0; k < dim; ++k) r[k] += lean[i][e] * frame_[e][k];
    for (std::size_t k = 0; k < dim; ++k) slip.value[i] += r[k] * v[k];
    for (std::size_t k = 0; with_gradient_ && k < dim; ++k) {
      std::array<double, dim - 1> turn{}; // of the direction, by the tangents
      for (std::size_t j = 0; j < dim - 1; ++j)
        for (std::size_t e = 0; e < dim; ++e)
          for (std::size_t m = 0; m < dim; ++m)
            turn[j] += lean[i][e] * v[m] * by_tangents_[e][m][dim * j + k];
      for (std::size_t b = 0; b < nodes; ++b) {
        double by_secondary = opening.D[b] * r[k];
        for (std::size_t j = 0; j < dim - 1; ++j) by_secondary += rows_[j][b] * turn[j];
        slip.gradient[i][dim * b + k] = by_secondary;
        slip.gradient[i][dim * (nodes + b) + k] = -opening.M[b] * r[k];
      }
    }
  }
  return slip;
}

template <std::size_t dim> Lean lean_to(const std::array<double, dim>& n, double length) {
  double square = 0;
  for (double component : n) square += component * component;
  const double scale = std::copysign(1 / std::sqrt(square), n[dim - 1]), up = n[dim - 1] * scale;
  Lean lean = upright<dim>();
  for (std::size_t i = 0; i + 1 < dim; ++i) {
    const double a = n[i] * scale;
    for (std::size_t j = 0; j + 1 < dim; ++j)
      lean[i][j] = length * (lean[i][j] - a * n[j] * scale / (1 + up));
    lean[i][dim - 1] = -a * length;
  }
  return lean;
}
template Lean lean_to<2>(const std::array<double, 2>&, double);
template Lean lean_to<3>(const std::array<double, 3>&, double);

template <std::size_t dim, std::size_t nodes>
void add_slip_hessian(const FacetNodes<dim, nodes>& x, const FacetNodes<dim, nodes>& p,
                      const TangentRows<dim, nodes>& rows, const std::array<Opening<nodes>, dim>& opening,
                      std::span<double> hessian) {
  // f = sum_i e_i.v_i: f'' by the frame alone, and what both change together.
  constexpr std::size_t dofs = 2 * dim * nodes;
  const Vectors<double, dim> g = tangents_at<dim, nodes>(rows, x);
  const auto r = seeded_frame<Second<dim>, dim>(g, [](double value, int i) {
    Second<dim> y(seed<double, variables<dim>>(value, i));
    y.d[i] = First<dim>(1.0);
    return y;
  });
  Second<dim> f(0.0);
  for (std::size_t i = 0; i < r.size(); ++i) {
    const std::array<double, dim> v = vector_of<dim, nodes>(opening[i], x, p);
    for (std::size_t k = 0; k < dim; ++k) f += v[k] * r[i][k];
  }
  const auto weight = [&](std::size_t i, std::size_t node) {
    return node < nodes ? opening[i].D[node] : -opening[i].M[node - nodes];
  };
  for (std::size_t b = 0; b < nodes; ++b)
    for (std::size_t k = 0; k < dim; ++k) {
      const std::size_t row = dim * b + k;
      Vectors<double, dim> by_tangents{};
      for (std::size_t q = 0; q < at(variables<dim>); ++q)
        for (std::size_t j = 0; j < g.size(); ++j)
          by_tangents[q / dim][q % dim] += rows[j][b] * f.d[dim * j + k].d[q];
      for (std::size_t c = 0; c < 2 * nodes; ++c)
        for (std::size_t m = 0; m < dim; ++m) {
          const std::size_t column = dim * c + m;
          double both = 0;
          for (std::size_t i = 0; i < r.size(); ++i)
            for (std::size_t j = 0; j < g.size(); ++j)
              both += rows[j][b] * r[i][m].v.d[dim * j + k] * weight(i, c);
          hessian[dofs * row + column] += both;
          hessian[dofs * column + row] += both;
          for (std::size_t j = 0; c < nodes && j < g.size(); ++j)
            hessian[dofs * row + column] += rows[j][c] * by_tangents[j][m];
        }
    }
}

FaceMap make_face_map(const FacetNodes<3, 4>& X) {
  // Derivatives of the shape functions at the middle, whose differences of corners are natural directions.
  const TangentRows<3, 4> natural =
      X[3] == X[2] ? TangentRows<3, 4>{{{-1, 1, 0, 0}, {-1, 0, 1, 0}}}
                   : TangentRows<3, 4>{{{-0.25, 0.25, 0.25, -0.25}, {-0.25, -0.25, 0.25, 0.25}}};
  FaceMap map;
  map.row = tangent_rows<3, 4>(X, natural);
  map.axis = tangents_at<3, 4>(map.row, X);
  map.normal = cross(map.axis[0], map.axis[1]);
  return map;
}

std::array<Vector3, 2> tangents_of(const Vector3& n) {
  // An odd bound, which the normals of usual bodies are not on: rounding must not choose.
  const std::size_t axis = std::abs(n[0]) < 0.8137 ? 0 : 1;
  Vector3 t{};
  for (std::size_t k = 0; k < 3; ++k) t[k] = (k == axis ? 1 : 0) - n[axis] * n[k];
  t = unit(t);
  return {t, cross(n, t)};
}

std::array<std::array<double, 2>, 2> turned_into(const FaceMap& face, const Vector3& n,
                                                 const std::array<Vector3, 2>& t) {
  // Q t = t + w x t + w x (w x t)/(1 + n.m), w = n x m; of t at right angles to n this is
  // t - (m.t)/(1 + n.m) (n + m).
  const double fold = std::max(1 + dot(n, face.normal), 1e-6); // of opposite normals every way is as short
  std::array<std::array<double, 2>, 2> turn{};
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 2; ++j)
      turn[i][j] = dot(t[i], face.axis[j]) - dot(face.normal, t[i]) / fold * dot(n, face.axis[j]);
  return turn;
}

// Straight edges and faces, and those of second order.
#define IMPACT_SLIP(dim, nodes)                                                                              \
  template TangentRows<dim, nodes> tangent_rows(const FacetNodes<dim, nodes>&,                               \
                                                const TangentRows<dim, nodes>&);                             \
  template class SlipDirections<dim, nodes>;                                                                 \
  template void add_slip_hessian(const FacetNodes<dim, nodes>&, const FacetNodes<dim, nodes>&,               \
                                 const TangentRows<dim, nodes>&, const std::array<Opening<nodes>, dim>&,     \
                                 std::span<double>);
IMPACT_SLIP(2, 2)
IMPACT_SLIP(2, 3)
IMPACT_SLIP(3, 4)
IMPACT_SLIP(3, 6)
IMPACT_SLIP(3, 8)
IMPACT_SLIP(3, 9)
#undef IMPACT_SLIP

} // namespace impact
