#pragma once
#include <algorithm>
#include <impact/contact/node_exchange.hpp>
#include <impact/contact/search.hpp>
#include <impact/contact/surface.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/mesh.hpp>
#include <utility>
#include <vector>

/// Which primary facets the secondary facets of this rank may meet, kept while nothing moves more than half a
/// skin, and the nodes that evaluations of these pairs need, fetched from whichever ranks own them.
namespace impact {

/// The nodes of a contact on this rank, on compact numbers.
struct ContactNodes {
  int dim = 2;
  int corners = 2; ///< per facet: 2 in the plane; 4 in space, where a triangle repeats its third corner
  NodeExchange exchange;
  std::vector<PetscInt> global; ///< sorted
  std::vector<double> X;        ///< [node][dim] reference coordinates
  std::vector<double> start;    ///< [node][dim] at the start of the step; empty: unknown
  std::vector<int> secondary;   ///< [secondary facet][corner]
  std::vector<int> primary;     ///< [candidate primary][corner]
  std::vector<int> neighbour;   ///< [candidate primary][2]: far nodes of an edge's neighbours, -1: none
  std::vector<double> built_at; ///< [node][dim] when the list was made

  /// Place of a global node, -1: not there.
  int slot(PetscInt node) const;
  /// [node][dim] of the displacement u. Collective.
  std::vector<double> displacement(Vec u) const { return exchange.gather(u); }
  /// [node][dim] at a displacement [node][dim].
  std::vector<double> current(const std::vector<double>& u) const;
  std::vector<double> current(Vec u) const { return current(displacement(u)); }
  /// Where a node stands seen from another one: differences of X and of u, which keep the digits that those
  /// of X + u lose where displacements are small beside coordinates.
  template <std::size_t d = 2>
  std::array<double, d> place(int node, int origin, const std::vector<double>& u) const {
    const std::size_t i = d * static_cast<std::size_t>(node), o = d * static_cast<std::size_t>(origin);
    std::array<double, d> difference;
    for (std::size_t k = 0; k < d; ++k) difference[k] = (X[i + k] - X[o + k]) + (u[i + k] - u[o + k]);
    return difference;
  }
};

using NodePairs = std::vector<std::pair<PetscInt, PetscInt>>;
/// Appends every pair of different nodes among these, which may be named several times.
void add_pairs_among(std::vector<PetscInt> nodes, NodePairs& pairs);

template <class T> void sort_unique(std::vector<T>& v) {
  std::sort(v.begin(), v.end());
  v.erase(std::unique(v.begin(), v.end()), v.end());
}

class PairSearch {
public:
  enum class Outcome { kept, rebuilt, other_pairs };

  PairSearch() = default;
  /// `secondary`: global nodes [facet][corner] of the facets that this rank evaluates, whoever owns their
  /// cells, and `secondary_X` [facet][corner][dim]; `primary`: the facets of this rank's cells, empty where
  /// the primary is no surface of the mesh. Mesh and layout must outlive the search. Collective.
  PairSearch(const Mesh& mesh, const FieldLayout& layout, const std::vector<PetscInt>& secondary,
             const std::vector<double>& secondary_X, const ContactSurface& primary, double radius,
             bool has_primary);

  /// Where the bodies stand at the start of a step; the list then reaches as far as they move. Collective.
  void set_start(Vec u_n);
  /// Makes the list anew when a node moved more than half the skin, or farther since the start of the step
  /// than the list reaches. The same on all ranks. Collective: one reduction when nothing moved that far.
  Outcome update(Vec u);
  /// The next update makes the list anew, as a restarted run does.
  void forget() { outdated_ = true; }

  const Candidates& candidates() const { return candidates_; }
  /// Global nodes of the candidates of a secondary facet, some several times.
  std::vector<PetscInt> primary_nodes(int secondary_facet) const;
  const ContactNodes& nodes() const { return nodes_; }
  double radius() const { return radius_; }
  /// False: something moved so far that the list may miss a facet. x: [node][dim] of nodes().
  bool holds_for(const std::vector<double>& x) const;

private:
  Candidates search(const std::vector<double>& x) const;
  void fetch_nodes(Vec u);
  void fetch_start();

  const Mesh* mesh_ = nullptr;
  const FieldLayout* layout_ = nullptr;
  int dim_ = 2, corners_ = 2;
  std::vector<PetscInt> secondary_, primary_;          // [facet][corner]
  std::vector<PetscInt> neighbour_;                    // [facet][2]
  std::vector<int> secondary_slot_, primary_slot_;     // [facet][corner] into the static nodes
  NodeExchange static_;                                // nodes of this rank's facets of both surfaces
  std::vector<double> static_X_;                       // [node][dim]
  std::vector<double> static_built_at_, static_start_; // [node][dim]; start empty: unknown
  Handle<Vec> u_n_;                                    // at the start of the step; absent: unknown
  bool has_primary_ = false, outdated_ = true;
  double radius_ = 0, skin_ = 0;
  double reach_ = 0; // the list holds every facet so near: the radius, or the motion of the step if larger
  Candidates candidates_;
  ContactNodes nodes_;
};

} // namespace impact
