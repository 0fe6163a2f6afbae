#include <algorithm>
#include <cmath>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/surface.hpp>
#include <impact/element/facets.hpp>
#include <impact/math/index.hpp>

namespace impact {

namespace {

using Place = std::array<double, 2>;
using Numbers = std::vector<double>;
using Functions = std::array<std::array<double, 4>, 4>;

// A part in numbers of corners, then of the middles of sides, then of the middle; a triangle repeats its
// third.
using Cut = std::vector<std::array<int, 4>>;
const Cut edge_cut = {{0, 2}, {2, 1}},
          triangle_cut = {{0, 3, 5, 5}, {3, 1, 4, 4}, {5, 4, 2, 2}, {3, 4, 5, 5}},
          quadrilateral_cut = {{0, 4, 8, 7}, {4, 1, 5, 8}, {8, 5, 2, 6}, {7, 8, 6, 3}};

template <class Facet> Numbers shape_at(const Place& x) {
  typename Facet::Point point{};
  std::copy_n(x.begin(), point.size(), point.begin());
  const auto N = Facet::N(point);
  return {N.begin(), N.end()};
}

Numbers shape_at(int stored, const Place& x) {
  switch (stored) {
  case 3:
    return shape_at<Line3>(x);
  case 6:
    return shape_at<Tri6>(x);
  case 8:
    return shape_at<Quad8>(x);
  default:
    return shape_at<Quad9>(x);
  }
}

// sum factor[i] row[i]
Numbers combined(const std::vector<Numbers>& row, const Numbers& factor) {
  Numbers sum(row.front().size(), 0.0);
  for (std::size_t i = 0; i < row.size(); ++i)
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += factor[i] * row[i][k];
  return sum;
}

// Corners, middles of the sides and the middle of a straight facet.
struct Lattice {
  std::vector<Place> place;
  std::vector<Numbers> of_corners; // each as a sum over the corners

  explicit Lattice(const std::vector<Place>& corner) {
    const std::size_t n = corner.size();
    const auto add = [&](const Numbers& weight) {
      Place& x = place.emplace_back();
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t k = 0; k < 2; ++k) x[k] += weight[a] * corner[a][k];
      of_corners.push_back(weight);
    };
    for (std::size_t a = 0; a < n; ++a) {
      Numbers one(n, 0.0);
      one[a] = 1;
      add(one);
    }
    for (std::size_t a = 0; a < (n == 2 ? 1 : n); ++a) {
      Numbers half(n, 0.0);
      half[a] = half[(a + 1) % n] = 0.5;
      add(half);
    }
    if (n == 4) add(Numbers(4, 0.25));
  }
};

// What stands at the places of a lattice, sums over nodes: the corners' as given, the others' by (80''').
std::vector<Numbers> vertices_of(const Lattice& lattice, std::size_t corners, int stored,
                                 const std::vector<Numbers>& corner) {
  std::vector<Numbers> vertex = corner;
  const std::size_t sides = corners == 2 ? 1 : corners;
  std::vector<Numbers> side; // as shape functions have it
  for (std::size_t e = 0; e < sides; ++e) {
    side.push_back(shape_at(stored, lattice.place[corners + e]));
    vertex.push_back(
        combined({side[e], corner[e], corner[(e + 1) % corners]}, {4.0 / 3, -1.0 / 6, -1.0 / 6}));
  }
  if (corners < 4) return vertex;
  std::vector<Numbers> all = {shape_at(stored, lattice.place[8])};
  all.insert(all.end(), side.begin(), side.end());
  all.insert(all.end(), corner.begin(), corner.end());
  constexpr double s = -2.0 / 9, c = 1.0 / 36;
  vertex.push_back(combined(all, {16.0 / 9, s, s, s, s, c, c, c, c}));
  return vertex;
}

class Cutter {
public:
  explicit Cutter(int stored) {
    const int corners = stored_corners(stored);
    const bool once = corners > 2;
    cut_.nodes = stored;
    cut_.sides = corners;
    cut_.corners = corners == 2 ? 2 : 4;
    for (int a = 0; a < stored; ++a) {
      cut_.vertex.emplace_back(at(stored), 0.0);
      cut_.vertex.back()[at(a)] = 1;
    }
    const Lattice lattice(corners == 2   ? std::vector<Place>{{-1, 0}, {1, 0}}
                          : corners == 3 ? std::vector<Place>{{0, 0}, {1, 0}, {0, 1}}
                                         : std::vector<Place>{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});
    const Cut& pattern = corners == 2 ? edge_cut : corners == 3 ? triangle_cut : quadrilateral_cut;
    const std::vector<Numbers> coarse =
        vertices_of(lattice, at(corners), stored, {cut_.vertex.begin(), cut_.vertex.begin() + corners});
    for (const std::array<int, 4>& half : pattern) {
      std::vector<Place> place;
      std::vector<Numbers> vertex;
      std::array<int, 4> node{};
      for (int a = 0; a < corners; ++a) {
        const std::size_t i = at(half[at(a)]);
        place.push_back(lattice.place[i]);
        vertex.push_back(once ? coarse[i] : shape_at(stored, lattice.place[i]));
        node[at(a)] = half[at(a)] < stored ? half[at(a)] : -1;
      }
      for (int a = corners; a < 4; ++a) node[at(a)] = -1;
      const Lattice fine(place);
      const std::vector<Numbers> vertices = vertices_of(fine, at(corners), stored, vertex);
      std::array<int, 4> whole{};
      for (int a = 0; a < 4; ++a) whole[at(a)] = std::min(a, corners - 1);
      add_half(fine, vertices, whole, node, once ? Cut{whole} : pattern);
    }
  }
  FacetParts take() { return std::move(cut_); }

private:
  void add_half(const Lattice& fine, const std::vector<Numbers>& vertices, const std::array<int, 4>& whole,
                const std::array<int, 4>& node, const Cut& pattern) {
    std::array<int, 4>& half = cut_.half.emplace_back();
    for (std::size_t a = 0; a < 4; ++a) half[a] = number(vertices[at(whole[a])]);
    for (const std::array<int, 4>& corners : pattern) {
      FacetParts::Part part;
      part.node = node;
      Functions of_half{};
      for (std::size_t a = 0; a < 4; ++a) of_half[a][a] = 1;
      for (std::size_t c = 0; c < at(cut_.corners); ++c) {
        part.vertex[c] = number(vertices[at(corners[c])]);
        part.place[c] = fine.place[at(corners[c])];
        if (c >= fine.of_corners.front().size()) continue; // a triangle
        const Numbers& weight = fine.of_corners[at(corners[c])];
        std::copy(weight.begin(), weight.end(), part.of_half[c].begin());
      }
      cut_.parts.push_back(part);
      cut_.parts.back().function = functions_of_part(cut_, static_cast<int>(cut_.parts.size()) - 1, of_half);
    }
  }
  int number(const Numbers& weight) {
    const auto same = [&](const Numbers& other) {
      return std::equal(weight.begin(), weight.end(), other.begin(),
                        [](double a, double b) { return std::abs(a - b) < 1e-12; });
    };
    const auto found = std::find_if(cut_.vertex.begin(), cut_.vertex.end(), same);
    const auto place = static_cast<int>(found - cut_.vertex.begin());
    if (found == cut_.vertex.end()) cut_.vertex.push_back(weight);
    return place;
  }

  FacetParts cut_;
};

} // namespace

std::array<std::array<double, 4>, 4> functions_of_part(const FacetParts& cut, int p,
                                                       const Functions& of_half) {
  const FacetParts::Part& part = cut.parts[at(p)];
  const auto rows = at(cut.sides);
  Functions f{};
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < at(cut.corners); ++c)
      for (std::size_t b = 0; b < rows; ++b) f[r][c] += of_half[r][b] * part.of_half[c][b];
  for (std::size_t r = 0; r < rows; ++r) {
    if (part.node[r] >= 0) continue;
    for (const std::size_t beside : {(r + 1) % rows, (r + rows - 1) % rows})
      for (std::size_t c = 0; c < 4; ++c) f[beside][c] += f[r][c] / 2;
    f[r].fill(0);
  }
  return f;
}

namespace {

FacetParts wide_triangle(int stored) {
  FacetParts cut = cut_facet(6);
  const auto place = [&](int vertex) {
    return vertex < 6 ? slot_of_triangle[at(vertex)] : vertex - 6 + stored;
  };
  std::vector<Numbers> vertex;
  for (int a = 0; a < stored; ++a) vertex.emplace_back(at(stored), 0.0)[at(a)] = 1;
  for (std::size_t v = 6; v < cut.vertex.size(); ++v) {
    Numbers& wide = vertex.emplace_back(at(stored), 0.0);
    for (std::size_t a = 0; a < 6; ++a) wide[at(slot_of_triangle[a])] = cut.vertex[v][a];
  }
  cut.nodes = stored;
  cut.vertex = vertex;
  for (FacetParts::Part& part : cut.parts) {
    for (int& v : part.vertex) v = place(v);
    for (int& node : part.node)
      if (node >= 0) node = place(node);
  }
  for (std::array<int, 4>& half : cut.half)
    for (int& v : half) v = place(v);
  return cut;
}

} // namespace

std::array<double, 9> FacetParts::bulge(const Part& part, const std::array<double, 4>& weight) const {
  Place x{};
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t k = 0; k < 2; ++k) x[k] += weight[c] * part.place[c][k];
  const bool wide_triangle = nodes > 6 && sides == 3;
  const Numbers N = shape_at(wide_triangle ? 6 : nodes, x);
  std::array<double, 9> sum{};
  for (std::size_t a = 0; a < N.size(); ++a) sum[wide_triangle ? at(slot_of_triangle[a]) : a] = N[a];
  for (std::size_t c = 0; c < 4; ++c)
    for (std::size_t a = 0; weight[c] != 0 && a < at(nodes); ++a)
      sum[a] -= weight[c] * vertex[at(part.vertex[c])][a];
  return sum;
}

FacetCuts::FacetCuts(int stored) : cuts_{cut_facet(stored), {}} {
  if (stored > 6) cuts_[1] = wide_triangle(stored);
}

FacetParts cut_facet(int stored) {
  if (stored_corners(stored) < stored) return Cutter(stored).take();
  FacetParts cut;
  cut.nodes = cut.corners = cut.sides = stored;
  FacetParts::Part part;
  for (int a = 0; a < stored; ++a) {
    cut.vertex.emplace_back(at(stored), 0.0);
    cut.vertex.back()[at(a)] = part.function[at(a)][at(a)] = part.of_half[at(a)][at(a)] = 1;
    part.vertex[at(a)] = part.node[at(a)] = a;
  }
  cut.parts.push_back(part);
  cut.half.push_back(part.vertex);
  return cut;
}

} // namespace impact
