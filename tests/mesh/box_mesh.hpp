#pragma once
#include "small_mesh.hpp"
#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <impact/kernel/shape.hpp>

/// The unit square or cube of one shape of cell, with its nodes moved: text of a mesh file with the region
/// "solid" and the boundary "boundary" (all of it).
namespace impact::run_test {

using Move = std::function<std::array<double, 3>(std::array<double, 3> x, bool inside)>;

/// n cells along each edge. Triangles: two in each square, tetrahedra: six in each cube (all share one
/// diagonal). Cells of second order have the nodes of a grid twice as fine. `move` gives a node's place from
/// its place in the regular grid.
inline std::string box_mesh(Shape shape, int n, const Move& move = {}) {
  const bool solid = dimension(shape) == 3;
  const int step = shape->order(), last = n * step, width = last + 1, layers = solid ? last : 0;
  std::string nodes, elements;
  int element_count = 0;
  const auto on_grid = [&](int i, int j, int k) { return (k * width + j) * width + i + 1; };
  const auto at = [&](int i, int j, int k) { return on_grid(i * step, j * step, k * step); };
  for (int k = 0; k <= layers; ++k)
    for (int j = 0; j <= last; ++j)
      for (int i = 0; i <= last; ++i) {
        const auto within = [last](int index) { return index > 0 && index < last; };
        std::array<double, 3> x = {double(i) / last, double(j) / last, double(k) / last};
        if (move) x = move(x, within(i) && within(j) && (!solid || within(k)));
        char line[120];
        std::snprintf(line, sizeof(line), "%d %.17g %.17g %.17g\n", on_grid(i, j, k), x[0], x[1], x[2]);
        nodes += line;
      }
  const auto middle = [&](int a, int b) {
    const auto mean = [&](int divisor, int modulus) {
      return ((a - 1) / divisor % modulus + (b - 1) / divisor % modulus) / 2;
    };
    return on_grid(mean(1, width), mean(width, width), mean(width * width, width));
  };
  const auto element = [&](int type, int group, std::vector<int> list) {
    if (step == 2) { // lines, triangles and tetrahedra, their edges in the order of gmsh
      static constexpr CellEdge edges[] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}};
      const std::vector<int> corners = list;
      for (int e = 0; e < (type == 1 ? 1 : type == 2 ? 3 : 6); ++e)
        list.push_back(middle(corners[unsigned(edges[e][0])], corners[unsigned(edges[e][1])]));
      type = type == 1 ? 8 : type == 2 ? 9 : 11;
    }
    elements += std::to_string(++element_count) + " " + std::to_string(type) + " 2 " + std::to_string(group) +
                " " + std::to_string(group);
    for (const int node : list) elements += " " + std::to_string(node);
    elements += "\n";
  };
  // A side of the box, and for tetrahedra the diagonal that the cells behind it have: from corner a to c.
  const auto side = [&](int a, int b, int c, int d) {
    if (shape == Shape::hex8) {
      element(3, 2, {a, b, c, d});
    } else {
      element(2, 2, {a, b, c});
      element(2, 2, {a, c, d});
    }
  };
  for (int k = 0; k < (solid ? n : 1); ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = at(i, j, k), b = at(i + 1, j, k), c = at(i + 1, j + 1, k), d = at(i, j + 1, k);
        if (!solid) {
          if (shape == Shape::quad4) {
            element(3, 1, {a, b, c, d});
          } else {
            element(2, 1, {a, b, c});
            element(2, 1, {a, c, d});
          }
          continue;
        }
        const int e = at(i, j, k + 1), f = at(i + 1, j, k + 1), g = at(i + 1, j + 1, k + 1),
                  h = at(i, j + 1, k + 1);
        if (shape == Shape::hex8)
          element(5, 1, {a, b, c, d, e, f, g, h});
        else
          for (const auto& [p, q] : {std::pair{b, c}, {c, d}, {d, h}, {h, e}, {e, f}, {f, b}})
            element(4, 1, {a, p, q, g});
      }
  for (int p = 0; p < n; ++p) {
    if (!solid) {
      element(1, 2, {at(p, 0, 0), at(p + 1, 0, 0)});
      element(1, 2, {at(n, p, 0), at(n, p + 1, 0)});
      element(1, 2, {at(p, n, 0), at(p + 1, n, 0)});
      element(1, 2, {at(0, p, 0), at(0, p + 1, 0)});
      continue;
    }
    for (int q = 0; q < n; ++q)
      for (const int end : {0, n}) {
        side(at(end, p, q), at(end, p + 1, q), at(end, p + 1, q + 1), at(end, p, q + 1));
        side(at(p, end, q), at(p + 1, end, q), at(p + 1, end, q + 1), at(p, end, q + 1));
        side(at(p, q, end), at(p + 1, q, end), at(p + 1, q + 1, end), at(p, q + 1, end));
      }
  }
  const std::string dim = std::to_string(dimension(shape)), below = std::to_string(dimension(shape) - 1);
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n" + dim + " 1 \"solid\"\n" + below +
         " 2 \"boundary\"\n$EndPhysicalNames\n$Nodes\n" + std::to_string(width * width * (layers + 1)) +
         "\n" + nodes + "$EndNodes\n$Elements\n" + std::to_string(element_count) + "\n" + elements +
         "$EndElements\n";
}

} // namespace impact::run_test
