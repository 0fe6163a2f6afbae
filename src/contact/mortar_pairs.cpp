#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>

/// Which primary facets a secondary facet of a MortarForm faces, and which functions it takes.
namespace impact {

namespace {

// Facets face each other when their normals oppose and the primary is not farther away than this part of the
// secondary's longest side: a step behind the surface must not count as an open gap beside the closed one.
constexpr double farthest = 0.5;
// Of a facet that was cut, the parts of others count that lie within this part of its side.
constexpr double half_of_facet = 0.5;
// Two facets over the same place count as layers, one behind the other, from this common part on.
constexpr double least_common_part = 1e-6;
// Dual functions are negative somewhere: over a part of a facet they may turn a gap into an overlap. Covered
// parts that sum to more than this are the whole facet: sides that lie flush pass each other by a little.
constexpr double whole_facet = 0.95;
// So does a gap that opens steeply along a facet, beside an edge, say, which its node bears alone. What lies
// more steeply (26 degrees) does not count as covered: its far end may be beyond `farthest`.
constexpr double parallel_enough = 0.9;

} // namespace

void MortarForm::set_functions(Facet& facet, const std::array<std::array<double, 4>, 4>& phi) {
  facet.face.phi = phi;
  for (std::size_t a = 0; a < 2; ++a) std::copy_n(phi[a].begin(), 2, facet.edge.phi[a].begin());
}

std::vector<int> MortarForm::choose_functions(const Facing& facing, const ContactValues& x) {
  std::vector<int> changed;
  if (settings_.multipliers != MultiplierSpace::dual) return changed;
  const int together = cuts_.parts_of_half();
  for (int first = 0; first < static_cast<int>(facets_.size()); first += together) {
    bool whole = true;
    for (int f = first; whole && f < first + together; ++f) {
      double part = 0;
      for (int candidate : facing[at(f)])
        if (opposition(f, candidate, x) > parallel_enough) part += view(f, candidate, x).part;
      whole = part > whole_facet;
    }
    Facet& chosen = facets_[at(first)];
    if (whole == chosen.whole || chosen.changes.exhausted()) continue;
    chosen.whole = whole;
    chosen.changes.note();
    for (int f = first; f < first + together; ++f) {
      Facet& facet = facets_[at(f)];
      set_functions(facet, whole ? facet.dual : part_of(f).function);
      changed.push_back(f);
    }
  }
  return changed;
}

double MortarForm::size_of(int facet, const ContactValues& x) const {
  return by_dimension([&]<class Corners>(const Corners& corners) {
    return longest_side(corners_at<Corners>(secondary_slots(facet), x)[0].data(),
                        static_cast<int>(corners.size()), dim_);
  });
}

double MortarForm::opposition(int facet, int candidate, const ContactValues& x) const {
  return at_pair(facet, candidate, x,
                 [](const auto& s, const auto& p) { return -dot(facet_normal(s), facet_normal(p)); });
}

FacetView MortarForm::view(int facet, int candidate, const ContactValues& x) const {
  return at_pair(facet, candidate, x, [](const auto& s, const auto& p) { return view_facet(s, p); });
}

// Whether a part lies so far beside that the iterates of a solve do not bring it before the facet; one that
// they do is found by the next update.
bool MortarForm::is_beside(int facet, int candidate, const ContactValues& x) const {
  if (dim_ == 2 || parts_ == 1) return false;
  const FaceCorners s = corners_at<FaceCorners>(secondary_slots(facet), x),
                    p = corners_at<FaceCorners>(primary_slots(candidate), x);
  return clearance(s, p) > half_of_facet * std::sqrt(parts_) * longest_side(s[0].data(), 4, 3);
}

bool MortarForm::adjoin(int candidate, int other) const {
  const auto slots = [&](int c) { return &nodes().primary[at(cuts_.width() * primary_facet(c))]; };
  const int *a = slots(candidate), *b = slots(other);
  return std::any_of(a, a + cuts_.width(),
                     [&](int slot) { return std::find(b, b + cuts_.width(), slot) != b + cuts_.width(); });
}

bool MortarForm::hidden(int facet, int candidate, const std::vector<int>& accepted,
                        const ContactValues& x) const {
  return at_pair(facet, candidate, x, [&](const auto& s, const auto& p) {
    using Corners = std::decay_t<decltype(s)>;
    return std::any_of(accepted.begin(), accepted.end(), [&](int other) {
      // Neighbours on the same surface do not hide each other.
      return (dim_ == 2 || !adjoin(candidate, other)) &&
             common_part(s, p, corners_at<Corners>(primary_slots(other), x)) > least_common_part;
    });
  });
}

bool MortarForm::came_through(int facet, int candidate) const {
  const ContactValues& start = vertices().start;
  return !start.empty() && opposition(facet, candidate, start) > least_opposition &&
         view(facet, candidate, start).largest > -search_.depth(facet / parts_);
}

MortarForm::Facing MortarForm::facing_at(const ContactValues& x) const {
  Facing facing(facets_.size());
  const Candidates& list = search_.candidates();
  std::vector<std::pair<double, int>> pairs; // distance, candidate
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const double size = size_of(f, x);
    pairs.clear();
    for (int pair : list.of(at(f / parts_)))
      for (int c = parts_ * pair; c < parts_ * (pair + 1); ++c) {
        if (is_beside(f, c, x) || opposition(f, c, x) <= least_opposition) continue;
        const FacetView seen = view(f, c, x);
        if (seen.smallest < farthest * size &&
            (seen.largest > -search_.depth(f / parts_) || came_through(f, c)))
          pairs.emplace_back(std::abs(seen.mean), c);
      }
    // Of two layers over the same part the nearer one counts.
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [distance, candidate] : pairs)
      if (!hidden(f, candidate, facing[at(f)], x)) facing[at(f)].push_back(candidate);
    std::erase_if(facing[at(f)], [&](int candidate) { return !search_.counts(candidate / parts_); });
    std::sort(facing[at(f)].begin(), facing[at(f)].end());
  }
  return facing;
}

std::vector<int> MortarForm::covering(int facet, const ContactValues& x, const Facing& facing) const {
  std::vector<int> list;
  for (int c : facing[at(facet)])
    if (view(facet, c, x).part > 1e-12) list.push_back(c);
  return list;
}

PairSearch::Outcome MortarForm::update(Vec u, const ConstraintFilter& presses) {
  const PairSearch::Outcome outcome = update_pairs(u);
  if (outcome != PairSearch::Outcome::kept) find_vertices();
  if (rigid()) return outcome;
  ContactValues store;
  const ContactValues of_nodes = nodes().displacement(u), &moved = at_vertices(of_nodes, store),
                      x = vertices().current(moved);
  switched_ = false;
  Facing next = facing_at(x);
  if (outcome != PairSearch::Outcome::kept) {
    // Candidates have other numbers now: what faced is forgotten, and the caller solves again anyway.
    facing_ = std::move(next);
    choose_functions(facing_, x);
    for (Node& node : owned_) node.bulged = false;
    bulge(moved, x, presses);
    return outcome;
  }
  for (std::size_t f = 0; f < facets_.size(); ++f)
    if (switches_[f].exhausted()) next[f] = facing_[f];
  for (const Node& node : owned_) {
    const bool changed = std::any_of(node.facets.begin(), node.facets.end(), [&](const Incident& i) {
      return next[at(i.facet)] != facing_[at(i.facet)];
    });
    if (!changed || !(active(node, moved, presses, facing_) || active(node, moved, presses, next))) continue;
    // Only pairs that cover something now make a difference.
    for (const Incident& i : node.facets)
      if (next[at(i.facet)] != facing_[at(i.facet)] &&
          covering(i.facet, x, next) != covering(i.facet, x, facing_)) {
        switched_ = true;
        switches_[at(i.facet)].note();
      }
  }
  facing_ = std::move(next);
  // Other functions of nodes that press are other forces.
  for (int f : choose_functions(facing_, x))
    for (int owned : facets_[at(f)].owned)
      switched_ = switched_ || (owned >= 0 && active(owned_[at(owned)], moved, presses, facing_));
  bulge(moved, x, presses);
  return outcome;
}

bool MortarForm::active(const Node& node, const ContactValues& u, const ConstraintFilter& presses,
                        const Facing& facing) const {
  double gap = 0;
  bool covered = false;
  for (const Incident& incident : node.facets)
    for (int c : facing[at(incident.facet)]) {
      const MortarPair pair = pair_at(incident.facet, c, u, false);
      covered = covered || pair.covered;
      gap += pair.gap[at(incident.corner)];
    }
  return covered && presses(node.local, gap / node.weight + node.bulge);
}

void MortarForm::visit_overlaps(const ContactValues& of_nodes, const OverlapVisitor& visitor) const {
  ContactValues store;
  const ContactValues& x = at_vertices(of_nodes, store);
  for (const Node& owner : owned_)
    for (const Incident& incident : owner.facets) {
      const int f = incident.facet, *mine = secondary_slots(f), slot = owner.slot;
      const auto corner = static_cast<int>(std::find(mine, mine + corners_, slot) - mine);
      if (corner == static_cast<int>(corners_)) continue; // another part has the node
      Point3 here{};
      std::copy_n(&x[at(dim_ * slot)], at(dim_), here.begin());
      const double size = size_of(f, x) + std::abs(here[0]) + std::abs(here[1]) + std::abs(here[2]);
      if (rigid()) {
        const ObstacleGap seen = gap_to(obstacle_.reference(), here);
        if (-seen.gap > 1e-9 * size) visitor(slot, -seen.gap, seen.normal);
        continue;
      }
      for (int candidate : facing_[at(f)])
        at_pair(f, candidate, x, [&](const auto& s, const auto& p) {
          double gap = 0;
          if (!corner_gap(s, corner, p, gap)) return;
          const Point3 n = facet_normal(s);
          // Coordinates that were meant to touch differ by rounding of their own size.
          if (-gap > 1e-9 * size) visitor(slot, -gap, {-n[0], -n[1], -n[2]});
        });
    }
}

} // namespace impact
