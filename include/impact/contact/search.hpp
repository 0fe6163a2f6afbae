#pragma once
#include <array>
#include <petscsys.h>
#include <vector>

/// Which primary facets a secondary facet may meet: boxes grown by a reach, on any ranks. The answer depends
/// on the geometry alone, not on the number of ranks. O(n log n) in the number of facets of this rank and its
/// neighbours.
namespace impact {

/// A primary edge as it travels between ranks: global nodes, neighbours (-1 at an end), coordinates
/// [node][2].
struct SearchFacet {
  std::array<PetscInt, 2> node;
  std::array<PetscInt, 2> neighbour;
  std::array<double, 4> x;
};

/// Secondary edges of this rank: global nodes [facet][2] and coordinates [facet][2][2].
struct SearchSecondary {
  std::vector<PetscInt> node;
  std::vector<double> x;
};

/// Pairs sorted by secondary facet, then by the global nodes of the primary.
struct Candidates {
  std::vector<SearchFacet> primary; ///< sorted by global nodes, each at least once a candidate
  std::vector<int> offset;          ///< [secondary facet + 1]
  std::vector<int> facet;           ///< index into primary, ascending within a secondary facet

  bool same_pairs(const Candidates& other) const;
};

/// All pairs whose boxes come closer than `reach`; edges that share a node are no pair. Boxes of the ranks
/// are gathered, facets travel only to ranks whose secondary box they reach. Collective.
Candidates find_candidates(MPI_Comm comm, const SearchSecondary& secondary,
                           const std::vector<SearchFacet>& own_primary, double reach);

/// The part of find_candidates that needs no messages: `primary` may come in any order.
Candidates match_boxes(const SearchSecondary& secondary, std::vector<SearchFacet> primary, double reach);

} // namespace impact
