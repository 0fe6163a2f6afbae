#pragma once
#include <algorithm>
#include <impact/contact/search.hpp>
#include <impact/contact/self_contact.hpp>
#include <impact/contact/surface.hpp>
#include <impact/mesh/field_layout.hpp>
#include <impact/mesh/mesh.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/tally.hpp>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

/// Which primary facets the secondary facets of this rank may meet, kept while nothing moves more than half a
/// skin, and the nodes that evaluations of these pairs need, fetched from whichever ranks own them.
namespace impact {

/// Values of chosen nodes, wherever they live, on this rank and back: one message per partner each way.
class NodeExchange {
public:
  NodeExchange() = default;
  /// `nodes`: global nodes wanted here, each once; `owned`: nodes owned by this rank; node-blocked global
  /// vectors of `components` per node. Collective.
  NodeExchange(MPI_Comm comm, PetscInt owned, int components, const std::vector<PetscInt>& nodes);

  /// [node][component] of the wanted nodes, current values of `global`. Collective.
  std::vector<double> gather(Vec global) const;
  /// Adds [node][component] into the owners' entries of `global`. Collective.
  void add(const std::vector<double>& values, Vec global) const;

private:
  Handle<PetscSF> sf_;
  std::size_t size_ = 0;
};

/// Numbers [node][dim] at the nodes of a contact: displacements u, coordinates x.
using ContactValues = std::vector<double>;

/// The nodes of a contact on this rank, on compact numbers.
struct ContactNodes {
  int dim = 2;
  int per_facet = 2; ///< stored_nodes of a facet (surface.hpp)
  NodeExchange exchange;
  std::vector<PetscInt> global; ///< sorted
  std::vector<double> X;        ///< [node][dim] reference coordinates
  std::vector<double> start;    ///< [node][dim] at the start of the step; empty: unknown
  std::vector<int> secondary;   ///< [secondary facet][node]
  std::vector<int> primary;     ///< [candidate primary][node]
  std::vector<int> neighbour;   ///< [candidate primary][2]: far nodes of an edge's neighbours, -1: none

  /// Place of a global node, -1: not there.
  int slot(PetscInt node) const;
  /// [node][dim] of the displacement u. Collective.
  std::vector<double> displacement(Vec u) const { return exchange.gather(u); }
  /// [node][dim] at a displacement [node][dim].
  std::vector<double> current(const ContactValues& u) const;
  std::vector<double> current(Vec u) const { return current(displacement(u)); }
  /// Where a node stands seen from another one: differences of X and of u, which keep the digits that those
  /// of X + u lose where displacements are small beside coordinates.
  template <std::size_t d = 2>
  std::array<double, d> place(int node, int origin, const ContactValues& u) const {
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

/// How near facets are a pair. With `local`: by the sizes of both and what moves in a step, so that coarse
/// facets elsewhere cost nothing; else, and on a surface that may meet itself: the radius, everywhere.
struct SearchRange {
  double radius = 0; ///< how deep behind the primary a facet is seen
  bool local = false;
};

/// More functions and members than usual: what a step and what a visit ask for; the facets that never
/// change, the list that one search found, what the attempt at a step began with, and what a surface that may
/// meet itself needs beside.
class PairSearch {
public:
  enum class Outcome { kept, rebuilt, other_pairs };
  /// What the secondary surface may meet: no surface of the mesh, another one, or itself.
  enum class Primary { rigid, other, itself };

  PairSearch() = default;
  /// `secondary`: global nodes [facet][node] of the facets that this rank evaluates, whoever owns their
  /// cells, and `secondary_X` [facet][node][dim]; `primary`: the facets of this rank's cells, empty where
  /// the primary is no surface of the mesh. Sides of one body, or one that may meet itself, keep of their
  /// pairs those that SelfContact lets touch. Mesh and layout must outlive the search. Collective.
  PairSearch(const Mesh& mesh, const FieldLayout& layout, const std::vector<PetscInt>& secondary,
             const std::vector<double>& secondary_X, const ContactSurface& primary, SearchRange range,
             Primary kind);

  /// Beginning of an attempt at a step from u_n. One that starts where the last one did finds the list that
  /// that one found, whatever was searched in it: an attempt that was refused leaves no trace. Collective:
  /// one reduction after an attempt that has searched.
  void begin_attempt(Vec u_n);
  /// True from a begin_attempt that brought an earlier list back until the next update.
  bool restored() const { return restored_ != Outcome::kept; }
  /// Nodes that every rank has among nodes() from the next update on, beside those of the facets; they are
  /// what a secondary facet meets where the primary is no surface of the mesh.
  void add_nodes(const std::vector<PetscInt>& nodes) {
    added_ = nodes;
    list_.outdated = true;
  }
  /// Where the bodies stand at the start of a step; the list then reaches as far as they move. Collective.
  void set_start(Vec u_n);
  /// What the next update, which is to come at the same u, asks of all ranks goes along with `tally`.
  void look(Vec u, Tally& tally);
  /// Makes the list anew when a node moved more than half the skin, or farther since the start of the step
  /// than the list reaches. The same on all ranks. Collective: one reduction when nothing moved that far,
  /// none after a look.
  Outcome update(Vec u);
  /// The next update makes the list anew, as a restarted run does.
  void forget() {
    list_.outdated = true;
    found_.reset();
  }

  const Candidates& candidates() const { return list_.candidates; }
  /// Pairs per secondary facet that has one, of all ranks. Collective.
  double pairs_per_facet() const;
  /// Global nodes of the candidates of a secondary facet, some several times.
  std::vector<PetscInt> primary_nodes(int secondary_facet) const;
  const ContactNodes& nodes() const { return list_.nodes; }
  double radius() const { return radius_; }
  /// Most that both sides together moved since the start of the step, at the last update.
  double motion() const { return motion_; }
  /// How deep any facet is seen that did not move within the step: the radius; by local sizes, that of the
  /// smallest facets on both sides.
  double range() const;
  /// Gap below which a place lies deeper than the search can judge, in this step or the next; -infinity where
  /// it always can.
  double deepest() const {
    return kind_ == Primary::rigid ? -std::numeric_limits<double>::infinity() : -range();
  }
  bool meets_itself() const { return kind_ == Primary::itself; }
  /// Whether this facet is the secondary one of its pair with the candidate (a place in candidates().facet):
  /// always, unless the surface may meet itself.
  bool counts(int candidate) const {
    return list_.counts.empty() || list_.counts[static_cast<std::size_t>(candidate)] != 0;
  }
  /// How deep behind the primary a secondary facet is still seen: the radius. Where the surface may meet
  /// itself: half the facet, or the thickness of its own body if that is less; what is deeper must have
  /// crossed the primary within the step.
  double depth(int secondary_facet) const {
    return depth_.empty() ? radius_ : depth_[static_cast<std::size_t>(secondary_facet)];
  }
  /// Distance of the nearest nodes of two facets of a pair at the displacement u of nodes(); infinite without
  /// pairs.
  double nearest_nodes(const ContactValues& u) const;

private:
  // What a search finds, and where.
  struct List {
    Candidates candidates;
    ContactNodes nodes;
    std::vector<char> counts;     // [candidate] of a surface that may meet itself, else empty
    std::vector<double> built_at; // [static node][dim]
    double reach = 0;             // most motion within a step for which the list holds every facet
    bool outdated = true;
  };
  // The corners of a facet with these nodes, at coordinates x [node][dim], in the form of the search, and how
  // far it leaves their box.
  std::array<double, 12> in_space(const int* slot, const ContactValues& x) const;
  double bulge(const int* slot, const ContactValues& x) const;
  // Lets the nodes of facets move by no more than their facets allow; the smallest of these. X: [node][dim].
  double tighten(const std::vector<int>& slot, const std::vector<double>& X,
                 std::vector<double>& slack) const;
  // Facets at the coordinates x of the static nodes.
  SearchSecondary secondary_at(const ContactValues& x) const;
  std::vector<SearchFacet> primary_at(const ContactValues& x) const;
  Candidates search(const ContactValues& x) const;
  // Whether a body has facets of both sides; then their shapes and bodies. Collective.
  bool find_shapes(const SearchSecondary& secondary, const std::vector<SearchFacet>& primary);
  void prepare_self_contact(const SearchSecondary& secondary, const std::vector<SearchFacet>& primary);
  // Leaves of the candidates those that may touch; needs nodes_ of them all.
  void drop_neighbours(Vec u);
  void fetch_nodes();
  void look(Vec u);
  bool stays() const { return kind_ == Primary::rigid && !list_.outdated; }
  double skin() const { return radius_ / 2; }
  void fetch_start();

  const Mesh* mesh_ = nullptr;
  const FieldLayout* layout_ = nullptr;
  int dim_ = 2, per_facet_ = 2;
  std::vector<PetscInt> secondary_, primary_;      // [facet][node]
  std::vector<PetscInt> neighbour_;                // [facet][2]
  std::vector<PetscInt> added_;                    // nodes of no facet
  std::vector<int> secondary_slot_, primary_slot_; // [facet][node] into the static nodes
  NodeExchange static_;                            // nodes of this rank's facets of both surfaces
  std::vector<double> static_X_, static_start_;    // [node][dim]; start empty: unknown
  std::vector<double> static_slack_;               // [node] what it may move by until the list is made anew
  Handle<Vec> u_n_;                                // at the start of the step; absent: unknown
  Primary kind_ = Primary::rigid;
  double radius_ = 0, smallest_ = 0; // smallest_: side of all facets, of both sides
  bool local_ = false;
  double motion_ = 0;
  List list_;
  /// Of an update: where the static nodes are; whether that is no number, how far they moved since the list
  /// was built, in what they may, and since the start of the step, by side.
  struct Look {
    std::vector<double> x;
    std::array<double, 4> moves{};
    bool of_all_ranks = false;
  } look_;
  std::optional<List> found_;        // by the attempt, where it has searched since
  Handle<Vec> attempt_from_;         // where it started; absent: none yet
  Outcome restored_ = Outcome::kept; // what the next update owes to the return of an earlier list
  SelfContact self_;                 // of a surface that may meet itself, else empty
  Handle<Vec> body_;                 // of a node, in its first component; absent: no body has both sides
  std::vector<FacetShape> shapes_;   // [secondary facet] reference, with body_
  std::vector<double> depth_;        // [secondary facet] of a surface that may meet itself, else empty
};

} // namespace impact
