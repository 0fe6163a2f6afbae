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
/// diagonal). Cells of second order have the nodes of a grid twice as fine, those of serendipity not the ones
/// amid squares. `move` gives a node's place from its place in the regular grid.
inline std::string box_mesh(Shape shape, int n, const Move& move = {}) {
  const bool solid = dimension(shape) == 3, boxes = !shape->simplex();
  const int step = shape->order(), last = n * step, width = last + 1, layers = solid ? last : 0;
  std::string nodes, elements;
  int node_count = 0, element_count = 0;
  const auto on_grid = [&](int i, int j, int k) { return (k * width + j) * width + i + 1; };
  const auto at = [&](int i, int j, int k) { return on_grid(i * step, j * step, k * step); };
  for (int k = 0; k <= layers; ++k)
    for (int j = 0; j <= last; ++j)
      for (int i = 0; i <= last; ++i) {
        if (boxes && step == 2 && shape->faces.empty() && i % 2 + j % 2 + k % 2 > 1) continue;
        ++node_count;
        const auto within = [last](int index) { return index > 0 && index < last; };
        std::array<double, 3> x = {double(i) / last, double(j) / last, double(k) / last};
        if (move) x = move(x, within(i) && within(j) && (!solid || within(k)));
        char line[120];
        std::snprintf(line, sizeof(line), "%d %.17g %.17g %.17g\n", on_grid(i, j, k), x[0], x[1], x[2]);
        nodes += line;
      }
  const auto write = [&](int type, int group, const std::vector<int>& list) {
    elements += std::to_string(++element_count) + " " + std::to_string(type) + " 2 " + std::to_string(group) +
                " " + std::to_string(group);
    for (const int node : list) elements += " " + std::to_string(node);
    elements += "\n";
  };
  const auto cell = [&](const std::vector<int>& corners) {
    std::vector<int> list(unsigned(shape->nodes));
    for (int a = 0; a < shape->nodes; ++a) {
      const std::vector<int> around = corners_around(shape, a);
      const auto mean = [&](int divisor) {
        int sum = 0;
        for (const int corner : around) sum += (corners[unsigned(corner)] - 1) / divisor % width;
        return sum / int(around.size());
      };
      const int place = shape->from_gmsh.empty() ? a : shape->from_gmsh[unsigned(a)];
      list[unsigned(place)] = on_grid(mean(1), mean(width), mean(width * width));
    }
    write(shape->names.gmsh, 1, list);
  };
  // A side of the box, and for tetrahedra the diagonal that the cells behind it have: from corner a to c.
  const auto side = [&](int a, int b, int c, int d) {
    if (boxes) return write(3, 2, {a, b, c, d});
    write(2, 2, {a, b, c});
    write(2, 2, {a, c, d});
  };
  for (int k = 0; k < (solid ? n : 1); ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = at(i, j, k), b = at(i + 1, j, k), c = at(i + 1, j + 1, k), d = at(i, j + 1, k);
        if (!solid) {
          if (boxes) {
            cell({a, b, c, d});
          } else {
            cell({a, b, c});
            cell({a, c, d});
          }
          continue;
        }
        const int e = at(i, j, k + 1), f = at(i + 1, j, k + 1), g = at(i + 1, j + 1, k + 1),
                  h = at(i, j + 1, k + 1);
        if (boxes)
          cell({a, b, c, d, e, f, g, h});
        else
          for (const auto& [p, q] : {std::pair{b, c}, {c, d}, {d, h}, {h, e}, {e, f}, {f, b}})
            cell({a, p, q, g});
      }
  for (int p = 0; p < n; ++p) {
    if (!solid) {
      write(1, 2, {at(p, 0, 0), at(p + 1, 0, 0)});
      write(1, 2, {at(n, p, 0), at(n, p + 1, 0)});
      write(1, 2, {at(p, n, 0), at(p + 1, n, 0)});
      write(1, 2, {at(0, p, 0), at(0, p + 1, 0)});
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
         " 2 \"boundary\"\n$EndPhysicalNames\n$Nodes\n" + std::to_string(node_count) + "\n" + nodes +
         "$EndNodes\n$Elements\n" + std::to_string(element_count) + "\n" + elements + "$EndElements\n";
}

} // namespace impact::run_test
