#include <algorithm>
#include <impact/math/index.hpp>
#include <impact/math/vector3.hpp>
#include <impact/mesh/gmsh.hpp>
#include <numeric>
#include <sstream>

namespace impact {

namespace {

Vector3 X(const GmshFile& file, int node) {
  const double* x = &file.x[at(3 * node)];
  return {x[0], x[1], x[2]};
}

std::string place(const GmshFile& file, int node) {
  const auto [x, y, z] = X(file, node);
  std::ostringstream text;
  text << "(" << x << ", " << y << ", " << z << ")";
  return text.str();
}

[[noreturn]] void unusable(const std::string& what) { throw UserError(ExitCode::data, what); }

template <class Body> void for_each_cell(GmshFile& file, Body&& body) {
  for (GmshBlock& block : file.blocks) {
    if (block.dim != file.dim) continue;
    const Shape shape = block.shape();
    for (std::size_t k = 0; k < block.node.size(); k += at(block.nodes)) body(&block.node[k], shape);
  }
}

// From gmsh's order of nodes to ours; boundaries keep the corners of their elements.
void order_nodes(GmshFile& file) {
  for (GmshBlock& block : file.blocks) {
    const auto nodes = at(block.nodes);
    if (block.dim == file.dim) {
      const auto from_gmsh = block.shape()->from_gmsh;
      std::vector<int> before(nodes);
      for (std::size_t k = 0; !from_gmsh.empty() && k < block.node.size(); k += nodes) {
        std::copy_n(&block.node[k], nodes, before.begin());
        for (std::size_t a = 0; a < nodes; ++a) block.node[k + a] = before[at(from_gmsh[a])];
      }
    } else if (const int corners = block.dim < 2 ? block.dim + 1 : block.shape()->corners();
               corners < block.nodes) {
      std::vector<int> kept;
      for (std::size_t k = 0; k < block.node.size(); ++k)
        if (k % nodes < at(corners)) kept.push_back(block.node[k]);
      block.node = std::move(kept);
      block.nodes = corners;
    }
  }
}

// Cells of one order, which have the nodes on their common edges and faces in common.
void check_middles(GmshFile& file) {
  struct Middle {
    CellFacet around; // corners, rising
    int node;
    auto operator<=>(const Middle&) const = default;
  };
  std::vector<Middle> middles;
  bool first_order = false, complete = false, incomplete = false;
  for_each_cell(file, [&](const int* node, Shape shape) {
    first_order = first_order || shape->order() == 1;
    if (!shape->simplex()) (shape->faces.empty() ? incomplete : complete) = true;
    for (int a = shape->corners(); a < shape->nodes - (shape->middle ? 1 : 0); ++a) {
      Middle& middle = middles.emplace_back(Middle{{-1, -1, -1, -1}, node[a]});
      std::ranges::transform(corners_around(shape, a), middle.around.begin(), [&](int b) { return node[b]; });
      std::ranges::sort(middle.around);
    }
  });
  if (middles.empty()) return;
  if (first_order) unusable("cells of first and of second order; give all cells the same order");
  if (complete && incomplete)
    unusable("quadrilaterals or hexahedra of second order with and without nodes in their middle; mesh all "
             "with the same Mesh.SecondOrderIncomplete of gmsh");
  std::ranges::sort(middles);
  const auto twin = std::ranges::adjacent_find(
      middles, [](const Middle& a, const Middle& b) { return a.around == b.around && a.node != b.node; });
  if (twin != middles.end())
    unusable("two nodes in the middle of one edge or face, near " + place(file, twin->node) +
             "; cells must share all nodes of their common sides");
}

void check_nodes(GmshFile& file) {
  for (std::size_t k = 0; k < file.x.size(); ++k)
    if (!std::isfinite(file.x[k]))
      unusable("the coordinates of node number " + std::to_string(k / 3 + 1) + " are not finite");
  std::vector<char> used(file.x.size() / 3, 0);
  for_each_cell(file, [&](const int* node, Shape shape) {
    for (int a = 0; a < shape->nodes; ++a) {
      if (std::count(node, node + shape->nodes, node[a]) > 1)
        unusable("degenerate cell: a node occurs twice in it, near " + place(file, node[a]));
      used[at(node[a])] = 1;
    }
  });
  if (const auto loose = std::count(used.begin(), used.end(), char{0}); loose > 0)
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
  std::size_t count = 0;
  for_each_cell(file, [&](const int*, Shape) { ++count; });
  cells.reserve(count);
  for_each_cell(file, [&](const int* node, Shape shape) {
    auto& key = cells.emplace_back();
    key.fill(-1);
    std::sort(key.begin(), std::copy(node, node + shape->corners(), key.begin()));
  });
  std::sort(cells.begin(), cells.end());
  const auto twin = std::adjacent_find(cells.begin(), cells.end());
  if (twin == cells.end()) return;
  unusable("two cells with the same nodes near " + place(file, (*twin)[0]) +
           (version4 ? "; remove the duplicated surface or volume"
                     : "; version 2.2 repeats a cell for each of its physical groups: write version 4.1 "
                       "(gmsh -format msh41)"));
}

// The other ends of the edges that leave each corner of a cell, in the order of a right-handed frame.
const std::vector<std::vector<int>>& corner_edges(Shape shape) {
  static std::map<Shape, std::vector<std::vector<int>>> known;
  auto& edges = known[shape];
  if (!edges.empty()) return edges;
  edges.resize(at(shape->corners()));
  std::map<std::pair<int, int>, int>
      next; // {corner, other end}: seen from outside, a facet turns to the first
  for (const CellFacet& facet : shape->facets) {
    const int n = node_count(facet);
    for (int a = 0; n > 2 && a < n; ++a)
      next[{facet[at(a)], facet[at((a + n - 1) % n)]}] = facet[at((a + 1) % n)];
    if (n > 2) continue;
    edges[at(facet[0])].insert(edges[at(facet[0])].begin(), facet[1]);
    edges[at(facet[1])].push_back(facet[0]);
  }
  for (const auto& [edge, follower] : next)
    if (auto& ends = edges[at(edge.first)]; ends.empty())
      for (int end = edge.second; ends.size() < 3; end = next.at({edge.first, end})) ends.push_back(end);
  return edges;
}

// det J at a corner; in the plane with the third direction out of it.
double corner_determinant(const GmshFile& file, const int* node, std::size_t corner,
                          const std::vector<int>& ends) {
  std::array<Vector3, 3> e{{{}, {}, {0, 0, 1}}};
  for (std::size_t k = 0; k < ends.size(); ++k) e[k] = minus(X(file, node[ends[k]]), X(file, node[corner]));
  if (file.dim == 2) e[0][2] = e[1][2] = 0;
  return determinant(e[0], e[1], e[2]);
}

// Where each node of a cell goes when it is turned.
std::vector<int> mirrored(Shape shape) {
  std::vector<int> place(at(shape->corners()));
  std::iota(place.begin(), place.end(), 0);
  if (shape->dim == 2 || shape->simplex()) {
    std::reverse(place.begin() + 1, shape->dim == 2 ? place.end() : place.begin() + 3);
  } else {
    std::swap(place[1], place[3]);
    std::swap(place[5], place[7]);
  }
  for (int node = shape->corners(); node < shape->nodes; ++node) {
    std::vector<int> around = corners_around(shape, node);
    for (int& corner : around) corner = place[at(corner)];
    std::ranges::sort(around);
    place.push_back(node);
    for (int other = shape->corners(); other < shape->nodes; ++other)
      if (corners_around(shape, other) == around) place.back() = other;
  }
  return place;
}

// Cells whose nodes run the other way round are turned.
void orient(GmshFile& file) {
  std::map<Shape, std::vector<int>> places;
  for_each_cell(file, [&](int* node, Shape shape) {
    const auto& edges = corner_edges(shape);
    double sum = 0;
    for (std::size_t a = 0; a < edges.size(); ++a) sum += corner_determinant(file, node, a, edges[a]);
    if (sum >= 0) return;
    ++file.turned_cells;
    const std::vector<int> before(node, node + shape->nodes);
    std::vector<int>& place = places[shape];
    if (place.empty()) place = mirrored(shape);
    for (const int from : place) *node++ = before[at(from)];
  });
}

// Two nodes of a cell in one place, and corners turned inside out: the sides of a bow-tie cross, an arrow
// points inwards. The map of such a cell folds, though its points of integration may not see it.
void check_corners(GmshFile& file) {
  for_each_cell(file, [&](const int* node, Shape shape) {
    const auto& edges = corner_edges(shape);
    double longest = 0;
    const auto edge = [&](std::size_t a, int b) { return length(minus(X(file, node[b]), X(file, node[a]))); };
    for (std::size_t a = 0; a < edges.size(); ++a)
      for (int b : edges[a]) longest = std::max(longest, edge(a, b));
    for (std::size_t a = 0; a < edges.size(); ++a) {
      for (int b : edges[a])
        if (edge(a, b) <= 1e-9 * longest)
          unusable("collapsed cell: two of its nodes stand at " + place(file, node[b]) +
                   "; make them one, or the cell one of fewer corners");
      if (corner_determinant(file, node, a, edges[a]) < -1e-9 * std::pow(longest, file.dim))
        unusable("folded cell: its sides cross, or its corner at " + place(file, node[a]) +
                 " points inwards; mend the mesh there");
    }
  });
}

// A facet seen from a cell: cyclic order kept, smallest node first. Two cells on the two sides of a facet see
// it in opposite orders; the same order twice means that one lies on top of the other.
using FacetKey = CellFacet;

FacetKey facet_key(const int* node, CellFacet key) {
  const auto end = key.begin() + node_count(key);
  std::transform(key.begin(), end, key.begin(), [&](int a) { return node[a]; });
  if (end > key.begin() + 2) std::rotate(key.begin(), std::min_element(key.begin(), end), end);
  return key;
}

// Edges of facets that belong to one cell alone, in both directions.
std::vector<std::pair<int, int>> boundary_edges(std::vector<FacetKey> facets) {
  for (FacetKey& facet : facets) std::sort(facet.begin(), facet.end());
  std::sort(facets.begin(), facets.end());
  std::vector<std::pair<int, int>> edges;
  for (auto at = facets.begin(), next = at; at != facets.end(); at = next) {
    next = std::upper_bound(at, facets.end(), *at);
    if (next - at == 1)
      for (int a : *at)
        for (int b : *at)
          if (a >= 0 && b >= 0 && a != b) edges.emplace_back(a, b);
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Where cells of different size meet without sharing their nodes, an edge on the boundary lies on part of
// another that leaves the same node in the same direction. The sides of a slit do so too, with edges of the
// same length.
void check_hanging_nodes(const GmshFile& file, const std::vector<std::pair<int, int>>& edges) {
  for (std::size_t p = 0, first = 0; p < edges.size(); ++p) {
    const auto [a, b] = edges[p];
    if (edges[first].first != a) first = p;
    for (std::size_t q = first; q < p; ++q) {
      const int c = edges[q].second;
      const Vector3 to_b = minus(X(file, b), X(file, a)), to_c = minus(X(file, c), X(file, a));
      const double lb = length(to_b), lc = length(to_c);
      if (std::abs(lb - lc) <= 1e-6 * std::max(lb, lc) || dot(to_b, to_c) < (1 - 1e-12) * lb * lc) continue;
      unusable("hanging node at " + place(file, lb < lc ? b : c) + ": it lies on the edge from " +
               place(file, a) + " to " + place(file, lb < lc ? c : b) +
               ", whose cell does not have it; cells must share all nodes of their common sides");
    }
  }
}

void check_facets(GmshFile& file) {
  std::vector<FacetKey> facets;
  std::size_t count = 0;
  for_each_cell(file, [&](const int*, Shape shape) { count += shape->facets.size(); });
  facets.reserve(count);
  for_each_cell(file, [&](const int* node, Shape shape) {
    for (const CellFacet& local : shape->facets) facets.push_back(facet_key(node, local));
  });
  std::sort(facets.begin(), facets.end());
  const auto fold = std::adjacent_find(facets.begin(), facets.end());
  if (fold != facets.end())
    unusable("inverted or overlapping cells: two cells lie on the same side of their common facet near " +
             place(file, (*fold)[0]) + "; mend the mesh there");
  check_hanging_nodes(file, boundary_edges(std::move(facets)));
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
  order_nodes(file);
  check_nodes(file);
  check_middles(file);
  check_duplicates(file, version4);
  orient(file);
  check_corners(file);
  check_facets(file);
}

} // namespace impact
