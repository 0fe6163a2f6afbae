#include <array>
#include <cmath>
#include <impact/math/dual.hpp>
#include <impact/petsc/error.hpp>
#include <impact/problem/surface_load.hpp>
#include <numbers>

namespace impact {

namespace {

// One integration point of a facet: shape functions, their reference derivatives, weight.
struct FacetPoint {
  std::array<double, 4> N{};
  std::array<std::array<double, 2>, 4> dN{};
  double weight = 0;
};

constexpr double gauss = 0.57735026918962576451;

std::vector<FacetPoint> facet_rule(int dim, int nodes) {
  std::vector<FacetPoint> points;
  if (dim == 2) {
    for (double s : {-gauss, gauss}) {
      FacetPoint p;
      p.N = {(1 - s) / 2, (1 + s) / 2};
      p.dN[0][0] = -0.5;
      p.dN[1][0] = 0.5;
      p.weight = 1;
      points.push_back(p);
    }
  } else if (nodes == 3) {
    for (int q = 0; q < 3; ++q) {
      const double r = q == 1 ? 2.0 / 3 : 1.0 / 6, s = q == 2 ? 2.0 / 3 : 1.0 / 6;
      FacetPoint p;
      p.N = {1 - r - s, r, s};
      p.dN[0] = {-1, -1};
      p.dN[1] = {1, 0};
      p.dN[2] = {0, 1};
      p.weight = 1.0 / 6;
      points.push_back(p);
    }
  } else {
    constexpr double sign[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (const auto& at : sign) {
      FacetPoint p;
      const double r = gauss * at[0], s = gauss * at[1];
      for (std::size_t a = 0; a < 4; ++a) {
        p.N[a] = (1 + sign[a][0] * r) * (1 + sign[a][1] * s) / 4;
        p.dN[a] = {sign[a][0] * (1 + sign[a][1] * s) / 4, sign[a][1] * (1 + sign[a][0] * r) / 4};
      }
      p.weight = 1;
      points.push_back(p);
    }
  }
  return points;
}

// A mixed 3D table repeats the last node of its triangles.
int corners(const FacetTable& facets, int f) {
  const int n = facets.nodes_per_facet;
  const auto base = static_cast<std::size_t>(f * n);
  return n == 4 && facets.connectivity[base + 3] == facets.connectivity[base + 2] ? 3 : n;
}

// n da/(dxi deta) at a point, with the radius in the axisymmetric frame; x [node][dim].
template <class T>
void area_vector(const FacetPoint& p, int dim, int nodes, Frame frame, const T* x, T* normal) {
  T t[2][3] = {{T(0.0), T(0.0), T(0.0)}, {T(0.0), T(0.0), T(0.0)}};
  T radius(0.0);
  for (int a = 0; a < nodes; ++a) {
    const auto n = static_cast<std::size_t>(a);
    for (int k = 0; k < dim; ++k)
      for (std::size_t j = 0; j + 1 < static_cast<std::size_t>(dim); ++j)
        t[j][k] += p.dN[n][j] * x[a * dim + k];
    radius += p.N[n] * x[a * dim];
  }
  if (dim == 2) {
    const T scale = frame == Frame::axisymmetric ? (2 * std::numbers::pi) * radius : T(1.0);
    normal[0] = scale * t[0][1];
    normal[1] = -(scale * t[0][0]);
    return;
  }
  normal[0] = t[0][1] * t[1][2] - t[0][2] * t[1][1];
  normal[1] = t[0][2] * t[1][0] - t[0][0] * t[1][2];
  normal[2] = t[0][0] * t[1][1] - t[0][1] * t[1][0];
}

struct FacetNodes {
  int count;
  std::array<int, 4> node;
  std::array<double, 12> X, x;
};

FacetNodes facet_nodes(const FacetTable& facets, int f, int dim, const std::vector<double>& X,
                       const std::vector<double>* u) {
  FacetNodes n{corners(facets, f), {}, {}, {}};
  for (int a = 0; a < n.count; ++a) {
    const int node = facets.connectivity[static_cast<std::size_t>(f * facets.nodes_per_facet + a)];
    n.node[static_cast<std::size_t>(a)] = node;
    for (int k = 0; k < dim; ++k) {
      const auto i = static_cast<std::size_t>(node * dim + k), j = static_cast<std::size_t>(a * dim + k);
      n.X[j] = X[i];
      n.x[j] = X[i] + (u ? (*u)[i] : 0.0);
    }
  }
  return n;
}

void reference_point(const FacetPoint& p, const FacetNodes& n, int dim, double* at) {
  for (int k = 0; k < dim; ++k) {
    at[k] = 0;
    for (int a = 0; a < n.count; ++a)
      at[k] += p.N[static_cast<std::size_t>(a)] * n.X[static_cast<std::size_t>(a * dim + k)];
  }
}

} // namespace

void add_dead_traction(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                       const std::function<void(const double* x, double* value)>& traction,
                       std::vector<double>& force) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, nullptr);
    for (const FacetPoint& p : facet_rule(dim, n.count)) {
      double at[3] = {0, 0, 0}, t[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
      reference_point(p, n, dim, at);
      traction(at, t);
      area_vector(p, dim, n.count, frame, n.X.data(), normal);
      const double area = p.weight * std::hypot(normal[0], normal[1], normal[2]);
      for (int a = 0; a < n.count; ++a)
        for (int k = 0; k < dim; ++k)
          force[static_cast<std::size_t>(n.node[static_cast<std::size_t>(a)] * dim + k)] +=
              p.N[static_cast<std::size_t>(a)] * t[k] * area;
    }
  }
}

void add_follower_pressure(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                           const std::vector<double>& u,
                           const std::function<double(const double* x)>& pressure,
                           std::vector<double>& force) {
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, &u);
    for (const FacetPoint& p : facet_rule(dim, n.count)) {
      double at[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
      reference_point(p, n, dim, at);
      area_vector(p, dim, n.count, frame, n.x.data(), normal);
      const double load = p.weight * pressure(at);
      for (int a = 0; a < n.count; ++a)
        for (int k = 0; k < dim; ++k)
          force[static_cast<std::size_t>(n.node[static_cast<std::size_t>(a)] * dim + k)] -=
              p.N[static_cast<std::size_t>(a)] * load * normal[k];
    }
  }
}

void add_follower_pressure_tangent(const FacetTable& facets, Frame frame, const std::vector<double>& X,
                                   const std::vector<double>& u,
                                   const std::function<double(const double* x)>& pressure,
                                   const std::vector<char>& fixed, std::span<const PetscInt> global_node,
                                   Mat matrix) {
  using Seeded = Dual<double, 12>;
  const int dim = dimension(frame);
  for (int f = 0; f < facets.count(); ++f) {
    const FacetNodes n = facet_nodes(facets, f, dim, X, &u);
    const int dofs = n.count * dim;
    std::array<Seeded, 12> x;
    std::array<PetscInt, 12> index;
    for (int i = 0; i < dofs; ++i) {
      const auto j = static_cast<std::size_t>(i);
      x[j] = Seeded(n.x[j]);
      x[j].d[i] = 1;
      const int node = n.node[static_cast<std::size_t>(i / dim)];
      const bool held = fixed[static_cast<std::size_t>(node * dim + i % dim)] != 0;
      index[j] =
          held ? -1 : global_node[static_cast<std::size_t>(node)] * dim + i % dim; // negative: left out
    }
    std::array<double, 144> K{};
    for (const FacetPoint& p : facet_rule(dim, n.count)) {
      double at[3] = {0, 0, 0};
      Seeded normal[3];
      reference_point(p, n, dim, at);
      area_vector(p, dim, n.count, frame, x.data(), normal);
      const double load = p.weight * pressure(at);
      for (int i = 0; i < dofs; ++i)
        for (int j = 0; j < dofs; ++j)
          K[static_cast<std::size_t>(i * dofs + j)] -=
              p.N[static_cast<std::size_t>(i / dim)] * load * normal[i % dim].d[j];
    }
    check(MatSetValues(matrix, dofs, index.data(), dofs, index.data(), K.data(), ADD_VALUES));
  }
}

} // namespace impact
