#pragma once
#include <array>
#include <petscsys.h>
#include <ranges>
#include <vector>

/// Which primary facets a secondary facet may meet: boxes grown by a reach, on any ranks. The answer depends
/// on the geometry alone, not on the number of ranks. O(n log n) in the number of facets of this rank and its
/// neighbours.
namespace impact {

/// Global nodes of a facet, its corners first; one with fewer repeats the last.
using GlobalFacet = std::array<PetscInt, 9>;

/// A primary facet as it travels between ranks: its nodes; far nodes of an edge's neighbours (-1: none);
/// coordinates of its corners [4][3], of which one with fewer repeats the last, the third zero in the plane;
/// how far it leaves the box of these where it is curved.
struct SearchFacet {
  GlobalFacet node;
  std::array<PetscInt, 2> neighbour;
  std::array<double, 12> x;
  double bulge = 0;
};

/// Secondary facets of this rank in the same form: global nodes [facet][4], of which two facets that touch
/// share one, coordinates [facet][4][3] and, unless all are straight, [facet] bulges.
struct SearchSecondary {
  std::vector<PetscInt> node;
  std::vector<double> x, bulge;
};

/// Pairs sorted by secondary facet, then by the global nodes of the primary.
struct Candidates {
  std::vector<SearchFacet> primary; ///< sorted by global nodes, each at least once a candidate
  std::vector<int> offset;          ///< [secondary facet + 1]
  std::vector<int> facet;           ///< index into primary, ascending within a secondary facet

  /// Places in `facet` of the pairs of a secondary facet.
  auto of(std::size_t secondary) const { return std::views::iota(offset[secondary], offset[secondary + 1]); }
  bool same_pairs(const Candidates& other) const;
};

/// All pairs whose boxes come closer than `reach` and `part` of the longest sides of both; facets that share
/// a node are no pair. Boxes of the ranks are gathered, facets travel only to ranks whose secondary box they
/// reach. Collective.
Candidates find_candidates(MPI_Comm comm, const SearchSecondary& secondary,
                           const std::vector<SearchFacet>& own_primary, double reach, double part = 0);

/// The part of find_candidates that needs no messages: `primary` may come in any order.
Candidates match_boxes(const SearchSecondary& secondary, std::vector<SearchFacet> primary, double reach,
                       double part = 0);

} // namespace impact
