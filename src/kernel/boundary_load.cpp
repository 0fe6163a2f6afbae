#include <impact/element/facets.hpp>
#include <impact/kernel/boundary_load.hpp>

#include <cmath>
#include <numbers>

namespace impact {

namespace {

// body(facet) with the facet of so many nodes.
template <class Body> auto visit(int dim, int nodes, Body&& body) {
  if (dim == 2) return nodes == 2 ? body(Line2()) : body(Line3());
  return nodes == 3   ? body(Tri3())
         : nodes == 4 ? body(Quad4())
         : nodes == 6 ? body(Tri6())
         : nodes == 8 ? body(Quad8())
                      : body(Quad9());
}

template <class Cell> void fill(int q, FacetPoint& p) {
  const auto& t = shape_table<Cell>;
  p.weight = t.weight[q];
  for (int a = 0; a < Cell::nodes; ++a) {
    p.N[a] = t.N[q][a];
    for (int i = 0; i < Cell::dim; ++i) p.dN[a][i] = t.dN[q][a][i];
  }
}

/// dx/dxi_j at the point, [dim][j].
void tangents(const FacetPoint& p, int nodes, int dim, const double* x, double (&a)[3][2]) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 2; ++j) {
      a[i][j] = 0;
      if (i < dim)
        for (int c = 0; c < nodes; ++c) a[i][j] += p.dN[c][j] * x[c * dim + i];
    }
}

/// n da/dxi: (y', -x') in the plane, x_,1 cross x_,2 in space.
void area_vector(const double (&a)[3][2], int dim, double* n) {
  if (dim == 2) {
    n[0] = a[1][0];
    n[1] = -a[0][0];
    return;
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    n[i] = a[j][0] * a[k][1] - a[k][0] * a[j][1];
  }
}

} // namespace

int facet_points(int dim, int nodes) {
  return visit(dim, nodes, []<class Facet>(Facet) { return Facet::points; });
}

FacetPoint facet_point(int dim, int nodes, int q) {
  FacetPoint p{};
  visit(dim, nodes, [&]<class Facet>(Facet) { fill<Facet>(q, p); });
  return p;
}

void facet_position(const FacetPoint& p, int nodes, int dim, const double* X, double* x) {
  for (int i = 0; i < dim; ++i) {
    x[i] = 0;
    for (int a = 0; a < nodes; ++a) x[i] += p.N[a] * X[a * dim + i];
  }
}

double reference_area(const FacetPoint& p, int nodes, Frame frame, const double* X) {
  const int dim = dimension(frame);
  double a[3][2], n[3], x[3];
  tangents(p, nodes, dim, X, a);
  area_vector(a, dim, n);
  facet_position(p, nodes, dim, X, x);
  double area = p.weight * std::sqrt(n[0] * n[0] + n[1] * n[1] + (dim == 3 ? n[2] * n[2] : 0));
  if (frame == Frame::axisymmetric) area *= 2 * std::numbers::pi * x[0];
  return area;
}

void add_dead_traction(const FacetPoint& p, int nodes, Frame frame, const double* X, const double* t,
                       double* f) {
  const int dim = dimension(frame);
  const double area = reference_area(p, nodes, frame, X);
  for (int c = 0; c < nodes; ++c)
    for (int i = 0; i < dim; ++i) f[c * dim + i] += area * p.N[c] * t[i];
}

void add_follower_pressure(const FacetPoint& p, int nodes, Frame frame, const double* x, double pressure,
                           double* f, double* K) {
  const int dim = dimension(frame);
  const bool ring = frame == Frame::axisymmetric;
  double a[3][2], n[3], at[3];
  tangents(p, nodes, dim, x, a);
  area_vector(a, dim, n);
  facet_position(p, nodes, dim, x, at);
  const double factor = -pressure * p.weight * (ring ? 2 * std::numbers::pi : 1), r = ring ? at[0] : 1;
  for (int c = 0; c < nodes; ++c)
    for (int i = 0; i < dim; ++i) f[c * dim + i] += factor * r * p.N[c] * n[i];
  if (!K) return;
  for (int b = 0; b < nodes; ++b)
    for (int k = 0; k < dim; ++k) {
      double dn[3] = {0, 0, 0}; // derivative of n with respect to x_bk
      if (dim == 2) {
        dn[1 - k] = (k == 1 ? 1 : -1) * p.dN[b][0];
      } else {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        dn[i] = a[j][0] * p.dN[b][1] - p.dN[b][0] * a[j][1];
        dn[j] = p.dN[b][0] * a[i][1] - a[i][0] * p.dN[b][1];
      }
      for (int c = 0; c < nodes; ++c)
        for (int i = 0; i < dim; ++i) {
          double s = r * dn[i];
          if (ring && k == 0) s += p.N[b] * n[i];
          K[((c * dim + i) * nodes + b) * dim + k] += factor * p.N[c] * s;
        }
    }
}

} // namespace impact
