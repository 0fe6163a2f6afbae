#pragma once
#include <array>
#include <vector>

/// How a facet is cut into straight ones, edges, triangles or quadrilaterals, for what integrates over
/// straight facets alone (theory.md, contact). One of first order is its only part. One of second order falls
/// into halves, the facets of first order between its nodes, by a vertex for the middle m of each side with
/// ends a, b, and of a quadrilateral for its own middle c, at
///   (8 m - a - b) / 6,   (64 c - 8 sum m + sum a) / 36                                          (80''')
/// Over a straight-sided facet the integral of a displacement is then that of its shape functions, over an
/// edge that of a displacement times a linear function too: a uniform pressure is passed on exactly, and an
/// arc has the area under it. In the plane the halves stand at the nodes and are cut once more by the same
/// rule, which then holds for functions that are linear on the halves: pressures of neighbouring nodes
/// scatter less (Hertz's by 0.2 % for 3 %). In space there would be 16 parts, and contact three times as
/// dear.
namespace impact {

struct FacetParts {
  /// Of a part: its corners, a triangle repeating its third one; and what a node's function of (80') is
  /// there, the piecewise linear one over the halves about it, Phi_r = sum_c function[r][c] N_c.
  struct Part {
    std::array<int, 4> vertex{};
    std::array<int, 4> node = {-1, -1, -1, -1}; ///< [r], -1: none
    std::array<std::array<double, 4>, 4> function{};
    std::array<std::array<double, 4>, 4> of_half{}; ///< its corners as sums over those of the half
    std::array<std::array<double, 2>, 4> place{};   ///< of its corners in the facet of second order
  };
  int nodes = 0;   ///< stored per facet
  int corners = 0; ///< stored per part: 2 or 4
  int sides = 0;   ///< corners of the facet, which of first order may repeat the third
  /// Sums over the nodes: the first vertices are the nodes themselves. [vertex][node]
  std::vector<std::vector<double>> vertex;
  std::vector<Part> parts;              ///< half by half
  std::vector<std::array<int, 4>> half; ///< vertices

  /// Where the facet of second order is at the part's place sum_c weight[c] corner_c, less where the part is,
  /// as a sum over the nodes.
  std::array<double, 9> bulge(const Part& part, const std::array<double, 4>& weight) const;

  int parts_of_half() const { return static_cast<int>(parts.size() / half.size()); }
};

/// `stored`: nodes that are stored per facet, in the plane or in space (surface.hpp).
FacetParts cut_facet(int stored);

/// Whether a facet of `stored` nodes, under any numbers, is a triangle of second order that is stored as wide
/// as a quadrilateral: its third corner comes twice.
template <class Number> bool is_wide_triangle(int stored, const Number* node) {
  return stored > 6 && node[3] == node[2];
}

/// The cuts of the facets of a surface: where quadrilaterals of second order may be, that of triangles too,
/// which are stored like quadrilaterals whose third corner comes twice.
class FacetCuts {
public:
  explicit FacetCuts(int stored);

  int width() const { return cuts_[0].nodes; }     ///< nodes that are stored per facet
  int corners() const { return cuts_[0].corners; } ///< stored per part
  int parts() const { return static_cast<int>(cuts_[0].parts.size()); }
  int parts_of_half() const { return cuts_[0].parts_of_half(); }
  /// Of a facet with these nodes, under any numbers.
  template <class Number> const FacetParts& of(const Number* node) const {
    return cuts_[is_wide_triangle(width(), node) ? 1 : 0];
  }

private:
  std::array<FacetParts, 2> cuts_;
};

/// In the place of a triangle of second order, stored as wide as a quadrilateral: where its nodes stand.
inline constexpr std::array<int, 6> slot_of_triangle = {0, 1, 2, 4, 5, 7};
/// And which node stands in each place.
inline constexpr std::array<int, 9> triangle_in_slot = {0, 1, 2, 2, 3, 4, 2, 5, 2};

/// Turns functions of the corners of a half, [r][corner], into those of its part `p` for the nodes of rows r:
/// the middle of eight nodes has no function of its own, and gives it to the sides beside it.
std::array<std::array<double, 4>, 4> functions_of_part(const FacetParts& cut, int p,
                                                       const std::array<std::array<double, 4>, 4>& of_half);

} // namespace impact
