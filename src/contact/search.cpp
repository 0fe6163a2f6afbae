#include <algorithm>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <impact/contact/search.hpp>
#include <limits>
#include <utility>

namespace impact {

namespace {

namespace bg = boost::geometry;
using Corner = bg::model::point<double, 3, bg::cs::cartesian>;
using TreeBox = bg::model::box<Corner>;
using Entry = std::pair<TreeBox, int>;

constexpr double far_away = std::numeric_limits<double>::infinity();

struct Box {
  std::array<double, 3> low = {far_away, far_away, far_away}, high = {-far_away, -far_away, -far_away};

  void include(const double* x) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  }
  Box grown(double by) const {
    Box box = *this;
    for (std::size_t k = 0; k < 3; ++k) {
      box.low[k] -= by;
      box.high[k] += by;
    }
    return box;
  }
  bool meets(const Box& o) const {
    bool apart = false;
    for (std::size_t k = 0; k < 3; ++k) apart = apart || !(low[k] <= o.high[k] && o.low[k] <= high[k]);
    return !apart;
  }
};

Box box_of(const double* facet) {
  Box box;
  for (std::size_t a = 0; a < 4; ++a) box.include(facet + 3 * a);
  return box;
}

TreeBox tree_box(const Box& box) {
  return {Corner(box.low[0], box.low[1], box.low[2]), Corner(box.high[0], box.high[1], box.high[2])};
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
                                  const std::vector<SearchFacet>& own, double reach) {
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
      if (target.meets(box_of(facet.x.data()))) message.push_back(facet);
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

bool share_node(const PetscInt* a, const std::array<PetscInt, 4>& b) {
  return std::any_of(a, a + 4, [&](PetscInt n) { return std::find(b.begin(), b.end(), n) != b.end(); });
}

// Drops primary facets that are nobody's candidate, so that only nodes that may couple travel afterwards.
void keep_used(Candidates& candidates) {
  std::vector<int> position(candidates.primary.size(), -1);
  for (int p : candidates.facet) position[static_cast<std::size_t>(p)] = 0;
  std::vector<SearchFacet> used;
  for (std::size_t p = 0; p < position.size(); ++p)
    if (position[p] == 0) {
      position[p] = static_cast<int>(used.size());
      used.push_back(candidates.primary[p]);
    }
  for (int& p : candidates.facet) p = position[static_cast<std::size_t>(p)];
  candidates.primary = std::move(used);
}

} // namespace

bool Candidates::same_pairs(const Candidates& other) const {
  return offset == other.offset && facet == other.facet &&
         std::equal(primary.begin(), primary.end(), other.primary.begin(), other.primary.end(),
                    [](const SearchFacet& a, const SearchFacet& b) { return a.node == b.node; });
}

Candidates match_boxes(const SearchSecondary& secondary, std::vector<SearchFacet> primary, double reach) {
  Candidates found;
  std::sort(primary.begin(), primary.end(),
            [](const SearchFacet& a, const SearchFacet& b) { return a.node < b.node; });
  found.primary = std::move(primary);
  std::vector<Entry> entries;
  entries.reserve(found.primary.size());
  for (std::size_t p = 0; p < found.primary.size(); ++p)
    entries.emplace_back(tree_box(box_of(found.primary[p].x.data())), static_cast<int>(p));
  const bg::index::rtree<Entry, bg::index::rstar<16>> tree(entries.begin(),
                                                           entries.end()); // packed: O(n log n)
  const std::size_t count = secondary.node.size() / 4;
  found.offset.assign(1, 0);
  std::vector<Entry> hits;
  for (std::size_t s = 0; s < count; ++s) {
    hits.clear();
    tree.query(bg::index::intersects(tree_box(box_of(&secondary.x[12 * s]).grown(reach))),
               std::back_inserter(hits));
    const auto first = static_cast<std::ptrdiff_t>(found.facet.size());
    for (const Entry& hit : hits)
      if (!share_node(&secondary.node[4 * s], found.primary[static_cast<std::size_t>(hit.second)].node))
        found.facet.push_back(hit.second);
    std::sort(found.facet.begin() + first, found.facet.end());
    found.offset.push_back(static_cast<int>(found.facet.size()));
  }
  keep_used(found);
  return found;
}

Candidates find_candidates(MPI_Comm comm, const SearchSecondary& secondary,
                           const std::vector<SearchFacet>& own_primary, double reach) {
  RankBoxes mine;
  for (std::size_t i = 0; i < secondary.x.size(); i += 3) mine.secondary.include(&secondary.x[i]);
  for (const SearchFacet& facet : own_primary)
    for (std::size_t a = 0; a < 4; ++a) mine.primary.include(&facet.x[3 * a]);
  return match_boxes(secondary, exchange(comm, gather_boxes(comm, mine), own_primary, reach), reach);
}

} // namespace impact
