#include <algorithm>
#include <array>
#include <cmath>
#include <impact/math/vector3.hpp>
#include <impact/mesh/gmsh.hpp>
#include <sstream>

namespace impact {

namespace {

std::string place(const GmshFile& file, int node) {
  std::ostringstream text;
  text << "(" << file.x[static_cast<std::size_t>(3 * node)] << ", "
       << file.x[static_cast<std::size_t>(3 * node + 1)] << ", "
       << file.x[static_cast<std::size_t>(3 * node + 2)] << ")";
  return text.str();
}

[[noreturn]] void unusable(const std::string& what) { throw UserError(ExitCode::data, what); }

template <class Body> void for_each_cell(GmshFile& file, Body&& body) {
  for (GmshBlock& block : file.blocks) {
    const std::size_t n = static_cast<std::size_t>(block.nodes);
    for (std::size_t k = 0; block.dim == file.dim && k < block.node.size(); k += n)
      body(&block.node[k], block.nodes);
  }
}

void check_nodes(GmshFile& file) {
  for (std::size_t k = 0; k < file.x.size(); ++k)
    if (!std::isfinite(file.x[k]))
      unusable("the coordinates of node number " + std::to_string(k / 3 + 1) + " are not finite");
  std::vector<char> used(file.x.size() / 3, 0);
  for_each_cell(file, [&](const int* node, int n) {
    for (int a = 0; a < n; ++a) {
      if (std::count(node, node + n, node[a]) > 1)
        unusable("degenerate cell: a node occurs twice in it, near " + place(file, node[a]));
      used[static_cast<std::size_t>(node[a])] = 1;
    }
  });
  const auto loose = std::count(used.begin(), used.end(), char{0});
  if (loose > 0)
    unusable(std::to_string(loose) + " nodes belong to no cell, the first at " +
             place(file, static_cast<int>(std::find(used.begin(), used.end(), char{0}) - used.begin())) +
             "; save only the physical groups (Mesh.SaveAll = 0) and put all bodies into one");
  if (file.dim == 3) return;
  double low = file.x[2], high = low, extent = 0;
  for (std::size_t k = 0; k < file.x.size(); k += 3) {
    low = std::min(low, file.x[k + 2]);
    high = std::max(high, file.x[k + 2]);
    extent = std::max({extent, std::abs(file.x[k] - file.x[0]), std::abs(file.x[k + 1] - file.x[1])});
  }
  if (high - low > 1e-10 * extent)
    unusable("a surface mesh that is not in a plane z = constant; give volumes or a plane mesh");
}

void check_duplicates(GmshFile& file, bool version4) {
  std::vector<std::array<int, 8>> cells;
  for_each_cell(file, [&](const int* node, int n) {
    auto& key = cells.emplace_back();
    key.fill(-1);
    std::copy(node, node + n, key.begin());
    std::sort(key.begin(), key.begin() + n);
  });
  std::sort(cells.begin(), cells.end());
  const auto twin = std::adjacent_find(cells.begin(), cells.end());
  if (twin == cells.end()) return;
  unusable("two cells with the same nodes near " + place(file, (*twin)[0]) +
           (version4 ? "; remove the duplicated surface or volume"
                     : "; version 2.2 repeats a cell for each of its physical groups: write version 4.1 "
                       "(gmsh -format msh41)"));
}

// det J summed over the corners: positive for the usual orientation.
double orientation(const GmshFile& file, const int* node, int n) {
  const auto x = [&](int a, int i) { return file.x[static_cast<std::size_t>(3 * node[a] + i)]; };
  if (file.dim == 2) {
    double area = 0;
    for (int a = 0; a < n; ++a) {
      const int b = (a + 1) % n;
      area += (x(a, 0) - x(0, 0)) * (x(b, 1) - x(0, 1)) - (x(b, 0) - x(0, 0)) * (x(a, 1) - x(0, 1));
    }
    return area;
  }
  static constexpr int tet[1][4] = {{0, 1, 2, 3}};
  static constexpr int hex[8][4] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                    {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};
  double volume = 0;
  for (int corner = 0; corner < (n == 4 ? 1 : 8); ++corner) {
    const int* c = n == 4 ? tet[0] : hex[corner];
    const auto side = [&](int k) {
      return Vector3{x(c[k], 0) - x(c[0], 0), x(c[k], 1) - x(c[0], 1), x(c[k], 2) - x(c[0], 2)};
    };
    volume += determinant(side(1), side(2), side(3));
  }
  return volume;
}

void turn(int* node, int dim, int n) {
  if (dim == 2 || n == 4) {
    std::reverse(node + 1, node + (dim == 2 ? n : 3));
    return;
  }
  std::swap(node[1], node[3]);
  std::swap(node[5], node[7]);
}

// A facet seen from a cell: cyclic order kept, smallest node first. Two cells on the two sides of a facet see
// it in opposite orders; the same order twice means that one lies on top of the other.
using FacetKey = std::array<int, 4>;

FacetKey facet_key(const int* node, const int* local, int n) {
  FacetKey key{-1, -1, -1, -1};
  for (int a = 0; a < n; ++a) key[static_cast<std::size_t>(a)] = node[local[a]];
  if (n > 2) std::rotate(key.begin(), std::min_element(key.begin(), key.begin() + n), key.begin() + n);
  return key;
}

double length_of(const GmshFile& file, int a, int b) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double d =
        file.x[static_cast<std::size_t>(3 * a + i)] - file.x[static_cast<std::size_t>(3 * b + i)];
    sum += d * d;
  }
  return std::sqrt(sum);
}

// The edges of a cell that leave each of its corners, in the order of a right-handed frame.
const std::vector<std::vector<int>>& corner_edges(int dim, int n) {
  static const std::vector<std::vector<int>> tri = {{1, 2}, {2, 0}, {0, 1}},
                                             quad = {{1, 3}, {2, 0}, {3, 1}, {0, 2}},
                                             tet = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}},
                                             hex = {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7},
                                                    {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}};
  return dim == 2 ? (n == 3 ? tri : quad) : (n == 4 ? tet : hex);
}

// Two nodes of a cell in one place, and corners turned inside out: the sides of a bow-tie cross, an arrow
// points inwards. The map of such a cell folds, though its points of integration may not see it.
void check_corners(GmshFile& file) {
  for_each_cell(file, [&](const int* node, int n) {
    const auto& edges = corner_edges(file.dim, n);
    double longest = 0;
    for (std::size_t a = 0; a < edges.size(); ++a)
      for (int b : edges[a]) longest = std::max(longest, length_of(file, node[a], node[b]));
    for (std::size_t a = 0; a < edges.size(); ++a) {
      std::array<Vector3, 3> e{{{}, {}, {0, 0, 1}}};
      for (std::size_t k = 0; k < edges[a].size(); ++k) {
        const int b = node[edges[a][k]];
        if (length_of(file, node[a], b) <= 1e-9 * longest)
          unusable("collapsed cell: two of its nodes stand at " + place(file, b) +
                   "; make them one, or the cell one of fewer corners");
        for (int i = 0; i < file.dim; ++i)
          e[k][static_cast<std::size_t>(i)] = (file.x[static_cast<std::size_t>(3 * b + i)] -
                                               file.x[static_cast<std::size_t>(3 * node[a] + i)]) /
                                              longest;
      }
      if (determinant(e[0], e[1], e[2]) < -1e-9)
        unusable("folded cell: its sides cross, or its corner at " + place(file, node[a]) +
                 " points inwards; mend the mesh there");
    }
  });
}

// Where cells of different size meet without sharing their nodes, an edge on the boundary lies on part of
// another that leaves the same node in the same direction. The sides of a slit do so too, with edges of the
// same length.
void check_hanging_nodes(GmshFile& file, std::vector<FacetKey> facets) {
  for (FacetKey& facet : facets) std::sort(facet.begin(), facet.end());
  std::sort(facets.begin(), facets.end());
  std::vector<std::pair<int, int>> edges;
  for (auto at = facets.begin(); at != facets.end();) {
    const auto next = std::upper_bound(at, facets.end(), *at);
    if (next - at == 1)
      for (int a : *at)
        for (int b : *at)
          if (a >= 0 && b >= 0 && a != b) edges.emplace_back(a, b);
    at = next;
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  const auto X = [&](int node, int i) { return file.x[static_cast<std::size_t>(3 * node + i)]; };
  for (std::size_t first = 0, end = 0; first < edges.size(); first = end) {
    const int a = edges[first].first;
    while (end < edges.size() && edges[end].first == a) ++end;
    for (std::size_t p = first; p < end; ++p)
      for (std::size_t q = first; q < p; ++q) {
        const int b = edges[p].second, c = edges[q].second;
        const double lb = length_of(file, a, b), lc = length_of(file, a, c);
        double along = 0;
        for (int i = 0; i < 3; ++i) along += (X(b, i) - X(a, i)) * (X(c, i) - X(a, i));
        if (std::abs(lb - lc) <= 1e-6 * std::max(lb, lc) || along < (1 - 1e-12) * lb * lc) continue;
        unusable("hanging node at " + place(file, lb < lc ? b : c) + ": it lies on the edge from " +
                 place(file, a) + " to " + place(file, lb < lc ? c : b) +
                 ", whose cell does not have it; cells must share all nodes of their common sides");
      }
  }
}

void check_folds(GmshFile& file) {
  static constexpr int tet[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  static constexpr int hex[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                    {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<FacetKey> facets;
  for_each_cell(file, [&](const int* node, int n) {
    if (file.dim == 2) {
      for (int a = 0; a < n; ++a) facets.push_back({node[a], node[(a + 1) % n], -1, -1});
    } else if (n == 4) {
      for (const auto& f : tet) facets.push_back(facet_key(node, f, 3));
    } else {
      for (const auto& f : hex) facets.push_back(facet_key(node, f, 4));
    }
  });
  std::sort(facets.begin(), facets.end());
  const auto fold = std::adjacent_find(facets.begin(), facets.end());
  if (fold != facets.end())
    unusable("inverted or overlapping cells: two cells lie on the same side of their common facet near " +
             place(file, (*fold)[0]) + "; mend the mesh there");
  check_hanging_nodes(file, std::move(facets));
}

} // namespace

void check_gmsh(GmshFile& file, bool version4) {
  for (const GmshBlock& block : file.blocks) file.dim = std::max(file.dim, block.dim);
  if (file.dim < 2) unusable("no cells; give surfaces (2D) or volumes (3D) in physical groups");
  if (file.groups.empty())
    unusable("no physical groups; name the regions and boundaries (Physical Surface(\"body\") = ...)");
  if (std::none_of(file.groups.begin(), file.groups.end(),
                   [&](const GmshGroup& g) { return g.dim == file.dim; }))
    unusable("no physical group of cells; name the regions (Physical Surface or Volume)");
  check_nodes(file);
  check_duplicates(file, version4);
  for_each_cell(file, [&](int* node, int n) {
    if (orientation(file, node, n) >= 0) return;
    turn(node, file.dim, n);
    ++file.turned_cells;
  });
  check_corners(file);
  check_folds(file);
}

} // namespace impact
