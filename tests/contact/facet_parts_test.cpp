#include <cmath>
#include <gtest/gtest.h>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/surface.hpp>
#include <impact/element/facets.hpp>
#include <numeric>

using namespace impact;

namespace {

using Numbers = std::vector<double>;
using Place = std::array<double, 2>;

// Nodes of a facet that lies flat, its middles where straight sides have them; quadrilaterals are no
// parallelograms.
std::vector<Place> flat(int stored) {
  const int corners = stored_corners(stored);
  std::vector<Place> x = {{0.1, 0.2}, {2.3, -0.4}};
  if (corners == 2) x[0][1] = x[1][1] = 0;
  if (corners > 2) x.push_back({1.9, 1.7});
  if (corners > 3) x.push_back({-0.3, 1.1});
  for (int e = 0; corners + e < stored && e < (corners == 2 ? 1 : corners); ++e) {
    const Place &a = x[static_cast<std::size_t>(e)], &b = x[static_cast<std::size_t>((e + 1) % corners)];
    x.push_back({(a[0] + b[0]) / 2, (a[1] + b[1]) / 2});
  }
  if (stored == 9)
    x.push_back({(x[0][0] + x[1][0] + x[2][0] + x[3][0]) / 4, (x[0][1] + x[1][1] + x[2][1] + x[3][1]) / 4});
  return x;
}

// int f N_a over the facet, by its own shape functions and rule.
template <class Facet, class Function> Numbers by_shape(const std::vector<Place>& x, Function&& f) {
  Numbers sum(Facet::nodes, 0.0);
  for (int q = 0; q < Facet::points; ++q) {
    const auto N = Facet::N(Facet::point(q));
    const auto dN = Facet::dN(Facet::point(q));
    Place y{};
    double J[2][2] = {};
    for (std::size_t a = 0; a < Facet::nodes; ++a)
      for (std::size_t k = 0; k < 2; ++k) {
        y[k] += N[a] * x[a][k];
        for (std::size_t i = 0; i < Facet::dim; ++i) J[k][i] += dN[a][i] * x[a][k];
      }
    const double size =
        Facet::dim == 1 ? std::hypot(J[0][0], J[1][0]) : J[0][0] * J[1][1] - J[0][1] * J[1][0];
    for (std::size_t a = 0; a < Facet::nodes; ++a) sum[a] += Facet::weight(q) * size * f(y) * N[a];
  }
  return sum;
}

// The same of the piecewise linear displacement between the vertices of triangles, or edges: for f that is
// linear on each.
struct Piece {
  std::vector<Numbers> corner; // as sums over the nodes
};

std::vector<Piece> pieces(const FacetParts& cut, int corners) {
  std::vector<Piece> list;
  for (const FacetParts::Part& part : cut.parts) {
    const auto at = [&](int c) {
      return cut.vertex[static_cast<std::size_t>(part.vertex[static_cast<std::size_t>(c)])];
    };
    if (corners < 4) {
      Piece& piece = list.emplace_back();
      for (int c = 0; c < corners; ++c) piece.corner.push_back(at(c));
      continue;
    }
    Numbers middle(at(0).size(), 0.0); // a quadrilateral is four triangles about the mean of its corners
    for (int c = 0; c < 4; ++c)
      for (std::size_t a = 0; a < middle.size(); ++a) middle[a] += at(c)[a] / 4;
    for (int c = 0; c < 4; ++c) list.push_back({{at(c), at((c + 1) % 4), middle}});
  }
  return list;
}

template <class Function>
Numbers by_parts(const FacetParts& cut, int corners, const std::vector<Place>& x, Function&& f) {
  Numbers sum(x.size(), 0.0);
  for (const Piece& piece : pieces(cut, corners)) {
    const std::size_t n = piece.corner.size();
    std::vector<Place> y(n);
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t a = 0; a < x.size(); ++a)
        for (std::size_t k = 0; k < 2; ++k) y[c][k] += piece.corner[c][a] * x[a][k];
    const double size =
        n == 2 ? std::hypot(y[1][0] - y[0][0], y[1][1] - y[0][1])
               : ((y[1][0] - y[0][0]) * (y[2][1] - y[0][1]) - (y[1][1] - y[0][1]) * (y[2][0] - y[0][0])) / 2;
    const double same = n == 2 ? 1.0 / 3 : 1.0 / 6, other = same / 2; // int N_c N_d over the size
    for (std::size_t c = 0; c < n; ++c)
      for (std::size_t d = 0; d < n; ++d)
        for (std::size_t a = 0; a < x.size(); ++a)
          sum[a] += size * (c == d ? same : other) * f(y[c]) * piece.corner[d][a];
  }
  return sum;
}

// `slope`: of the function.
template <class Facet> void is_exact(int stored, double slope) {
  const FacetParts cut = cut_facet(stored);
  const std::vector<Place> x = flat(stored);
  const auto linear = [&](const Place& y) { return 0.7 + slope * (0.3 * y[0] - 1.1 * y[1]); };
  const Numbers shape = by_shape<Facet>(x, linear), parts = by_parts(cut, stored_corners(stored), x, linear);
  for (std::size_t a = 0; a < x.size(); ++a) EXPECT_NEAR(parts[a], shape[a], 1e-13) << stored << " " << a;
}

} // namespace

TEST(FacetParts, IntegrateDisplacementsAsTheShapeFunctionsDo) {
  is_exact<Line3>(3, 1);
  is_exact<Tri6>(6, 0);
  is_exact<Quad8>(8, 0);
  is_exact<Quad9>(9, 0);
}

TEST(FacetParts, TheFacetOfSecondOrderLiesBeforeItsPartsByTheBulge) {
  // Nodes on a paraboloid, at the places of the reference facet: a parabola along each side.
  const auto height = [](const Place& x) {
    return 0.3 * x[0] * x[0] - 0.2 * x[0] * x[1] + 0.7 * x[1] * x[1];
  };
  const std::vector<Place> triangle = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}},
                           square = {{-1, -1}, {1, -1}, {1, 1},  {-1, 1}, {0, -1},
                                     {1, 0},   {0, 1},  {-1, 0}, {0, 0}},
                           edge = {{-1, 0}, {1, 0}, {0, 0}};
  for (const std::vector<Place>* nodes : {&edge, &triangle, &square}) {
    const FacetParts cut = cut_facet(static_cast<int>(nodes->size()));
    for (const FacetParts::Part& part : cut.parts)
      for (const std::array<double, 4>& weight :
           {std::array<double, 4>{1, 0, 0, 0}, {0.3, 0.7, 0, 0}, {0.2, 0.5, 0.3, 0}}) {
        if (cut.corners == 2 && weight[2] > 0) continue;
        Place x{};
        double straight = 0, bulge = 0;
        for (std::size_t c = 0; c < 4; ++c) {
          for (std::size_t k = 0; k < 2; ++k) x[k] += weight[c] * part.place[c][k];
          const Numbers& vertex = cut.vertex[static_cast<std::size_t>(part.vertex[c])];
          for (std::size_t a = 0; a < nodes->size(); ++a)
            straight += weight[c] * vertex[a] * height((*nodes)[a]);
        }
        const std::array<double, 9> of_nodes = cut.bulge(part, weight);
        for (std::size_t a = 0; a < nodes->size(); ++a) bulge += of_nodes[a] * height((*nodes)[a]);
        EXPECT_NEAR(bulge, height(x) - straight, 1e-14) << nodes->size();
        EXPECT_NEAR(std::accumulate(of_nodes.begin(), of_nodes.end(), 0.0), 0, 1e-14);
      }
  }
}

TEST(FacetParts, VerticesAndFunctionsSumToOne) {
  for (const int stored : {2, 3, 4, 6, 8, 9}) {
    const FacetParts cut = cut_facet(stored);
    for (const Numbers& weight : cut.vertex)
      EXPECT_NEAR(std::accumulate(weight.begin(), weight.end(), 0.0), 1, 1e-14);
    for (const FacetParts::Part& part : cut.parts) {
      for (std::size_t c = 0; c < static_cast<std::size_t>(stored_corners(stored)); ++c) {
        double sum = 0;
        for (std::size_t r = 0; r < 4; ++r) sum += part.function[r][c];
        EXPECT_NEAR(sum, 1, 1e-14);
      }
      for (std::size_t r = 0; r < 4; ++r)
        for (const double value : part.function[r]) EXPECT_TRUE(part.node[r] >= 0 || value == 0);
    }
  }
}

TEST(FacetParts, ThoseOfFirstOrderAreThemselves) {
  for (const int stored : {2, 4}) {
    const FacetParts cut = cut_facet(stored);
    ASSERT_EQ(cut.parts.size(), 1);
    for (int a = 0; a < stored; ++a) {
      EXPECT_EQ(cut.parts[0].vertex[static_cast<std::size_t>(a)], a);
      EXPECT_EQ(cut.parts[0].node[static_cast<std::size_t>(a)], a);
    }
  }
}

// In the plane functions that are linear on half an edge are integrated as exactly.
TEST(FacetParts, HalvesOfAnEdgeAreExactAlone) {
  const FacetParts cut = cut_facet(3);
  ASSERT_EQ(cut.parts.size(), 4);
  const auto hat = [](double xi) { return 1 - std::abs(xi); };
  const double place[] = {-1, 1, 0};
  Numbers parts(3, 0.0), shape(3, 0.0);
  for (const FacetParts::Part& part : cut.parts) {
    double x[2] = {};
    for (std::size_t c = 0; c < 2; ++c)
      for (std::size_t a = 0; a < 3; ++a)
        x[c] += cut.vertex[static_cast<std::size_t>(part.vertex[c])][a] * place[a];
    for (std::size_t c = 0; c < 2; ++c)
      for (std::size_t d = 0; d < 2; ++d)
        for (std::size_t a = 0; a < 3; ++a)
          parts[a] += (x[1] - x[0]) * (c == d ? 2 : 1) / 6 * hat(x[c]) *
                      cut.vertex[static_cast<std::size_t>(part.vertex[d])][a];
  }
  constexpr int steps = 20000; // middle points
  for (int i = 0; i < steps; ++i) {
    const double xi = -1 + (2 * i + 1.0) / steps;
    const auto N = Line3::N({xi});
    for (std::size_t a = 0; a < 3; ++a) shape[a] += 2.0 / steps * hat(xi) * N[a];
  }
  for (std::size_t a = 0; a < 3; ++a) EXPECT_NEAR(parts[a], shape[a], 1e-8);
}
