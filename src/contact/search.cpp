#include <algorithm>
#include <cmath>
#include <impact/contact/box_tree.hpp>
#include <impact/contact/search.hpp>
#include <impact/contact/surface.hpp>
#include <numeric>
#include <utility>

namespace impact {

namespace {

// So many secondary facets in a row ask the tree together, unless they lie apart.
constexpr std::size_t together = 8;
constexpr double spread_limit = 10; // of their common box over that of the first

Box box_of(const double* facet) {
  Box box;
  for (std::size_t a = 0; a < 4; ++a) box.include(facet + 3 * a);
  return box;
}

Box grown_box_of(const double* facet, double part, double bulge) {
  const Box box = box_of(facet);
  const double by = part > 0 ? part * longest_side(facet, 4, 3) + bulge : bulge;
  return by > 0 ? box.grown(by) : box;
}
Box grown_box_of(const SearchFacet& facet, double part) {
  return grown_box_of(facet.x.data(), part, facet.bulge);
}
Box grown_box_of(const SearchSecondary& facets, std::size_t f, double part) {
  return grown_box_of(&facets.x[12 * f], part, facets.bulge.empty() ? 0 : facets.bulge[f]);
}

// The boxes of both surfaces of every rank; an empty surface has an inverted box that meets nothing.
struct RankBoxes {
  Box secondary, primary;
};

std::vector<RankBoxes> gather_boxes(MPI_Comm comm, const RankBoxes& mine) {
  int size = 1;
  MPI_Comm_size(comm, &size);
  std::vector<RankBoxes> all(static_cast<std::size_t>(size));
  constexpr int doubles = sizeof(RankBoxes) / sizeof(double);
  static_assert(doubles == 12);
  MPI_Allgather(&mine, doubles, MPI_DOUBLE, all.data(), doubles, MPI_DOUBLE, comm);
  return all;
}

// Sends each rank the primary facets that its secondary box reaches. Both sides know from the boxes who talks
// to whom.
std::vector<SearchFacet> exchange(MPI_Comm comm, const std::vector<RankBoxes>& boxes,
                                  const std::vector<SearchFacet>& own, double reach, double part) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const int size = static_cast<int>(boxes.size());
  const RankBoxes& mine = boxes[static_cast<std::size_t>(rank)];
  constexpr int tag = 731;
  std::vector<std::vector<SearchFacet>> outbox(boxes.size());
  std::vector<MPI_Request> requests;
  for (int other = 0; other < size; ++other) {
    const Box target = boxes[static_cast<std::size_t>(other)].secondary.grown(reach);
    if (other == rank || !target.meets(mine.primary)) continue;
    auto& message = outbox[static_cast<std::size_t>(other)];
    for (const SearchFacet& facet : own)
      if (target.meets(grown_box_of(facet, part))) message.push_back(facet);
    MPI_Isend(message.data(), static_cast<int>(message.size() * sizeof(SearchFacet)), MPI_BYTE, other, tag,
              comm, &requests.emplace_back());
  }
  std::vector<SearchFacet> all = own;
  for (int other = 0; other < size; ++other) {
    if (other == rank || !mine.secondary.grown(reach).meets(boxes[static_cast<std::size_t>(other)].primary))
      continue;
    MPI_Status status;
    int bytes = 0;
    MPI_Probe(other, tag, comm, &status);
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    const std::size_t before = all.size();
    all.resize(before + static_cast<std::size_t>(bytes) / sizeof(SearchFacet));
    MPI_Recv(all.data() + before, bytes, MPI_BYTE, other, tag, comm, MPI_STATUS_IGNORE);
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return all;
}

bool share_node(const PetscInt* a, const GlobalFacet& b) {
  int shared = 0; // without a branch: nearly always none
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) shared |= a[i] == b[j] ? 1 : 0;
  return shared != 0;
}

// Drops primary facets that are nobody's candidate, so that only nodes that may couple travel afterwards.
void keep_used(Candidates& candidates) {
  std::vector<int> position(candidates.primary.size(), -1);
  for (int p : candidates.facet) position[static_cast<std::size_t>(p)] = 0;
  int used = 0;
  for (std::size_t p = 0; p < position.size(); ++p)
    if (position[p] == 0) {
      position[p] = used;
      if (static_cast<int>(p) != used)
        candidates.primary[static_cast<std::size_t>(used)] = candidates.primary[p];
      ++used;
    }
  if (used == static_cast<int>(position.size())) return;
  candidates.primary.resize(static_cast<std::size_t>(used));
  for (int& p : candidates.facet) p = position[static_cast<std::size_t>(p)];
}

// By global nodes. Facets in the order of their mesh mostly are, and are large to move.
void sort_by_nodes(std::vector<SearchFacet>& facets) {
  const auto before = [](const SearchFacet& a, const SearchFacet& b) { return a.node < b.node; };
  if (std::is_sorted(facets.begin(), facets.end(), before)) return;
  std::vector<std::size_t> order(facets.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return before(facets[a], facets[b]); });
  std::vector<SearchFacet> sorted;
  sorted.reserve(facets.size());
  for (std::size_t i : order) sorted.push_back(facets[i]);
  facets = std::move(sorted);
}

} // namespace

bool Candidates::same_pairs(const Candidates& other) const {
  return offset == other.offset && facet == other.facet &&
         std::equal(primary.begin(), primary.end(), other.primary.begin(), other.primary.end(),
                    [](const SearchFacet& a, const SearchFacet& b) { return a.node == b.node; });
}

Candidates match_boxes(const SearchSecondary& secondary, std::vector<SearchFacet> primary, double reach,
                       double part) {
  Candidates found;
  sort_by_nodes(primary);
  found.primary = std::move(primary);
  std::vector<Box> boxes;
  boxes.reserve(found.primary.size());
  for (const SearchFacet& facet : found.primary) boxes.push_back(grown_box_of(facet, part));
  const BoxTree tree(boxes);
  const std::size_t count = secondary.node.size() / 4;
  found.offset.reserve(count + 1);
  found.offset.assign(1, 0);
  std::array<Box, together> group;
  std::vector<std::uint32_t> leaves;
  std::vector<int> hits;
  for (std::size_t first = 0; first < count; first += together) {
    const std::size_t last = std::min(first + together, count);
    Box all;
    for (std::size_t s = first; s < last; ++s) {
      group[s - first] = grown_box_of(secondary, s, part).grown(reach);
      all.include(group[s - first]);
    }
    const bool near = all.longest() <= spread_limit * group[0].longest();
    leaves.clear();
    if (near) tree.find_leaves(all, leaves);
    for (std::size_t s = first; s < last; ++s) {
      const Box& box = group[s - first];
      if (!near) {
        leaves.clear();
        tree.find_leaves(box, leaves);
      }
      hits.clear();
      for (std::uint32_t leaf : leaves) tree.find_boxes(box, leaf, hits);
      std::sort(hits.begin(), hits.end());
      for (int hit : hits)
        if (!share_node(&secondary.node[4 * s], found.primary[static_cast<std::size_t>(hit)].node))
          found.facet.push_back(hit);
      found.offset.push_back(static_cast<int>(found.facet.size()));
    }
  }
  keep_used(found);
  return found;
}

Candidates find_candidates(MPI_Comm comm, const SearchSecondary& secondary,
                           const std::vector<SearchFacet>& own_primary, double reach, double part) {
  RankBoxes mine;
  for (std::size_t f = 0; f < secondary.x.size() / 12; ++f)
    mine.secondary.include(grown_box_of(secondary, f, part));
  for (const SearchFacet& facet : own_primary) mine.primary.include(grown_box_of(facet, part));
  return match_boxes(secondary, exchange(comm, gather_boxes(comm, mine), own_primary, reach, part), reach,
                     part);
}

} // namespace impact
