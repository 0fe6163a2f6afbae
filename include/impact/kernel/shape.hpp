#pragma once
#include <compare>
#include <impact/element/cells.hpp>
#include <impact/kernel/frame.hpp>
#include <impact/math/batch.hpp>
#include <span>
#include <string_view>
#include <vector>

/// The shapes of cells that a run knows, as data: everything that the reader, the mesh, the assembly, the
/// problems and the writers ask of a cell stands in its CellShape, so that none of them names a shape. A new
/// one is a struct like Tri3 (element/cells.hpp) and, in a file of its own,
///   const CellShape wedge = cell_shape<Wedge6>();   // kernel/shape_of.hpp
/// which joins the list in src/kernel/shape.cpp or, from outside, by a KnownShape.
namespace impact {

struct CellKernels; // kernel/cell_kernels.hpp

struct CellShape {
  CellNames names;
  int dim, nodes, points, volume_modes; ///< the last one of kernel/volume_modes.hpp
  std::span<const CellFacet> facets;
  std::span<const int> from_plex; ///< place of each node in the order of DMPlex
  /// Of second order: the edges in whose middle the nodes after the corners stand, then the quadrilateral
  /// faces (of the plane the cell itself); last the node in the middle of the cell, where there is one.
  std::span<const CellEdge> edges;
  std::span<const CellFacet> faces;
  bool middle;
  std::span<const int> from_gmsh;            ///< place of each node in the order of gmsh; empty: the same
  const double *N, *dN, *weight;             ///< [point][node], [point][node][dim], [point]
  std::array<double, 3> centroid;            ///< in reference coordinates
  std::array<const CellKernels*, 4> kernels; ///< by Frame; null where the cell has no place
  /// Shape functions [node] and their reference derivatives [node][dim] at a reference place [dim].
  void (*basis)(const double* xi, double* N, double* dN);
  /// Smallest height of each cell, per lane: over the opposite side in simplices, between opposite sides at
  /// the centroid in quads and hexes. X [node][dim].
  Batch (*size)(const Batch* X);

  int corners() const { return nodes - static_cast<int>(edges.size() + faces.size() + middle); }
  int order() const { return edges.empty() ? 1 : 2; }
  bool simplex() const { return corners() == dim + 1; }
};

/// Which shape: the name of an entry of the list.
class Shape {
public:
  static const Shape tri3, quad4, tet4, hex8, tri6, tet10, quad9, hex27, quad8, hex20;

  Shape() = default;
  constexpr explicit Shape(const CellShape& cell) : cell_(&cell) {}
  const CellShape* operator->() const { return cell_; }
  const CellKernels& kernels(Frame frame) const { return *cell_->kernels[static_cast<std::size_t>(frame)]; }
  friend auto operator<=>(Shape, Shape) = default;

private:
  const CellShape* cell_ = nullptr;
};

inline int dimension(Shape s) { return s->dim; }
inline int node_count(Shape s) { return s->nodes; }
inline int point_count(Shape s) { return s->points; }

/// All shapes; a mesh takes for each of its cells the last one with the right polytope and number of nodes.
std::span<const Shape> known_shapes();
/// That one, whose names.polytope this is; none where there is no such cell.
Shape find_shape(int dim, std::string_view polytope, int nodes);
/// The cell of first order with the same corners.
Shape linear(Shape);
/// The corners amid which a node stands: its own, those of its edge, of its face or of the cell; rising.
std::vector<int> corners_around(Shape, int node);
/// Nodes of a facet of the cell: its corners, then the middles of its edges and its own.
std::vector<int> facet_nodes(Shape, const CellFacet&);
/// Place in that list.
int index_of(Shape);

/// A shape from outside joins the list for the lifetime of this.
class KnownShape {
public:
  explicit KnownShape(const CellShape& cell);
  KnownShape(const KnownShape&) = delete;
  KnownShape& operator=(const KnownShape&) = delete;
  ~KnownShape();
};

/// Reference place and shape functions [node] of a point of the undeformed cell, by Newton's method; false
/// where it lies outside. X [node][dim], at [dim].
bool locate(Shape shape, const double* X, const double* at, double* N);

} // namespace impact
