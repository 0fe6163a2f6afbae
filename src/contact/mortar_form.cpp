#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>
#include <numbers>

namespace impact {

namespace {

// Where less of a weight than this part is covered, sides do not meet.
constexpr double least_covered = 1e-6;

} // namespace

void MortarForm::release() {
  std::fill(switches_.begin(), switches_.end(), Switches());
  for (Facet& facet : facets_) facet.changes = {};
  for (Node& node : owned_) node.bulged = false;
}

NodePairs MortarForm::couplings() const {
  NodePairs pairs;
  for (const Node& node : owned_) {
    std::vector<PetscInt> together;
    for (const Incident& i : node.facets) {
      const std::vector<PetscInt> primary = search_.primary_nodes(i.facet / parts_);
      const GlobalFacet& mine = facets_[at(i.facet)].node;
      together.insert(together.end(), mine.begin(), mine.end());
      together.insert(together.end(), primary.begin(), primary.end());
    }
    add_pairs_among(std::move(together), pairs);
  }
  sort_unique(pairs);
  return pairs;
}

MortarPair MortarForm::pair_at(int facet, int candidate, const ContactValues& u, bool with_gradient) const {
  return from_pair(facet, candidate, u, [&](const auto& s, const auto& p) {
    return mortar_pair(s, p, facets_[at(facet)].reference(s), with_gradient);
  });
}

Point3 MortarForm::place_of(const Facet& facet, const FacetPoint& point, const int* slot,
                            const ContactValues& u) const {
  Point3 x{};
  for (std::size_t a = 0; a < at(facet.corners); ++a)
    for (std::size_t k = 0; k < at(dim_); ++k) {
      const std::size_t i = at(dim_ * slot[a]) + k;
      x[k] += point.shape[a] * (vertices().X[i] + u[i]);
    }
  return x;
}

MortarPair MortarForm::obstacle_gaps(int f, const RigidObstacle& obstacle, const ContactValues& u) const {
  const Facet& facet = facets_[at(f)];
  MortarPair pair;
  pair.covered = pair.touched = true;
  for (const FacetPoint& point : facet.points) {
    const Point3 x = place_of(facet, point, secondary_slots(f), u);
    const CarriedFunction gap = obstacle_.gap(obstacle, x);
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      pair.gap[a] += point.weight[a] * gap.value;
      pair.cover[a] += point.weight[a];
      obstacle_.add_gradient(gap, {point.shape.data(), corners_}, obstacle_.shares(), point.weight[a],
                             pair.gradient[a].data());
    }
  }
  return pair;
}

std::array<double, 4> MortarForm::areas_at(int f, const ContactValues& u) const {
  const int* slot = secondary_slots(f);
  if (dim_ == 3) return of_functions(f, nodal_areas(corners_from<FaceCorners>(slot[0], slot, u)));
  const double length = longest_side(corners_from<EdgeCorners>(slot[0], slot, u)[0].data(), 2, 2);
  std::array<double, 2> ring = {1, 1};
  if (frame_ == Frame::axisymmetric)
    for (std::size_t a = 0; a < 2; ++a)
      ring[a] = 2 * std::numbers::pi * (vertices().X[2 * at(slot[a])] + u[2 * at(slot[a])]);
  return of_functions(f, {length * (2 * ring[0] + ring[1]) / 6, length * (2 * ring[1] + ring[0]) / 6});
}

// Each pair once, for all corners of its secondary facet.
MortarForm::Pieces MortarForm::pieces_at(const ContactValues& u, bool with_gradient) const {
  Pieces pieces(facets_.size());
  const RigidObstacle obstacle = obstacle_.at(u);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    std::vector<Piece>& mine = pieces[at(f)];
    if (*std::max_element(facets_[at(f)].owned.begin(), facets_[at(f)].owned.end()) < 0) continue;
    if (rigid()) mine.push_back({-1, obstacle_gaps(f, obstacle, u)});
    mine.reserve(facing_[at(f)].size());
    for (int candidate : facing_[at(f)]) {
      mine.push_back({candidate, pair_at(f, candidate, u, with_gradient)});
      if (!mine.back().pair.touched) mine.pop_back();
    }
  }
  return pieces;
}

bool MortarForm::is_covered(const Node& owner, const Pieces& pieces) {
  return std::any_of(owner.facets.begin(), owner.facets.end(), [&](const Incident& i) {
    return std::any_of(pieces[at(i.facet)].begin(), pieces[at(i.facet)].end(),
                       [](const Piece& piece) { return piece.pair.covered; });
  });
}

void MortarForm::visit(const ContactValues& of_nodes, Derivatives derivatives,
                       const ConstraintVisitor& of_constraints, const ConstraintFilter& /*wanted*/) const {
  ContactValues store;
  const ContactValues& u = at_vertices(of_nodes, store);
  const ConstraintVisitor visitor = over_nodes(vertices_, of_constraints);
  const bool with_gradient = derivatives != Derivatives::none;
  const auto d = at(dim_);
  const Pieces pieces = pieces_at(u, with_gradient);
  SlipRows slip_rows = slips_at(u, with_gradient);
  NodePlaces place_of;
  std::vector<int>& node = place_of.node;
  std::vector<double> share, gradient;
  for (const Node& owner : owned_) {
    if (!is_covered(owner, pieces)) continue;
    node.clear();
    Constraint c;
    c.index = owner.local;
    c.weight = owner.weight;
    double cover = 0, area = 0;
    // Secondary nodes first.
    for (const Incident& i : owner.facets)
      for (std::size_t a = 0; a < corners_; ++a) place_of(secondary_slots(i.facet)[a]);
    const std::size_t own = place_of(owner.slot);
    share.assign(node.size(), 0.0);
    share[own] = 1;
    gradient.assign(d * node.size(), 0.0);
    for (const Incident& i : owner.facets) {
      const std::size_t a = at(i.corner);
      const int* secondary = secondary_slots(i.facet);
      area += areas_at(i.facet, u)[a];
      for (const Piece& piece : pieces[at(i.facet)]) {
        c.gap += piece.pair.gap[a];
        cover += piece.pair.cover[a];
        if (!with_gradient) continue;
        const std::span<const int> primary =
            piece.candidate < 0 ? std::span<const int>(obstacle_.slots())
                                : std::span<const int>(primary_slots(piece.candidate), corners_);
        for (std::size_t b = 0; b < corners_ + primary.size(); ++b) {
          const std::size_t place = d * place_of(b < corners_ ? secondary[b] : primary[b - corners_]);
          gradient.resize(d * node.size(), 0.0);
          for (std::size_t m = 0; m < d; ++m)
            gradient[place + m] += piece.pair.gradient[a][d * b + m] / owner.weight;
        }
      }
    }
    if (std::abs(cover) <= least_cover * owner.weight) continue;
    c.slides = slip_nodes(owner, place_of);
    gradient.resize(d * node.size(), 0.0);
    c.gap = c.gap / c.weight + owner.bulge;
    c.stretch = area / c.weight;
    c.cover = std::abs(cover) / owner.weight;
    c.node = node;
    c.share = share;
    if (with_gradient) c.gradient = gradient;
    if (c.slides) add_slip(owner, u, place_of, slip_rows, c);
    visitor(c);
  }
}

void MortarForm::visit_curvature(const ContactValues& of_nodes, const CurvatureFactors& factors,
                                 const BlockVisitor& of_blocks) const {
  ContactValues store;
  const ContactValues& u = at_vertices(of_nodes, store);
  const BlockVisitor visitor = over_nodes(vertices_, of_blocks);
  const RigidObstacle obstacle = obstacle_.at(u);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const Facet& facet = facets_[at(f)];
    std::array<double, 4> factor{};
    for (std::size_t a = 0; a < at(facet.corners); ++a)
      if (facet.owned[a] >= 0) {
        const Node& owner = owned_[at(facet.owned[a])];
        factor[a] = factors.of_gap(owner.local) / owner.weight;
      }
    if (std::all_of(factor.begin(), factor.end(), [](double value) { return value == 0; })) continue;
    std::vector<int> node = with_carrier(f, corners_);
    std::array<double, 576> block{};
    if (rigid()) {
      for (const FacetPoint& point : facet.points) {
        double weight = 0;
        for (std::size_t a = 0; a < 4; ++a) weight += factor[a] * point.weight[a];
        obstacle_.add_hessian(obstacle_.gap(obstacle, place_of(facet, point, node.data(), u)),
                              {point.shape.data(), corners_}, obstacle_.shares(), weight, block.data());
      }
      const std::size_t n = at(dim_) * node.size();
      visitor(node, {block.data(), n * n});
      continue;
    }
    node.resize(2 * corners_);
    const std::size_t n = at(dim_) * node.size();
    for (int candidate : facing_[at(f)]) {
      std::copy_n(primary_slots(candidate), corners_, &node[corners_]);
      std::fill_n(block.begin(), n * n, 0.0);
      if (from_pair(f, candidate, u, [&](const auto& s, const auto& p) {
            return add_mortar_hessian(s, p, facet.reference(s), factor, block);
          }))
        visitor(node, {block.data(), n * n});
    }
  }
  if (frictional()) visit_slip_curvature(u, factors, visitor);
}

void MortarForm::visit_meetings(const ContactValues& of_nodes, const MeetingVisitor& of_meetings) const {
  ContactValues store;
  const ContactValues& u = at_vertices(of_nodes, store);
  const MeetingVisitor visitor = over_nodes(vertices_, of_meetings);
  // [facet] candidates, -1 the rigid body: each pair once, for all corners of its secondary facet.
  std::vector<std::vector<std::pair<int, MortarWeights>>> parts(facets_.size());
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const Facet& facet = facets_[at(f)];
    if (rigid()) parts[at(f)].emplace_back(-1, facet.onto);
    for (int candidate : facing_[at(f)])
      parts[at(f)].emplace_back(candidate, from_pair(f, candidate, u, [&](const auto& s, const auto& p) {
                                  return mortar_weights(s, p, facet.reference(s));
                                }));
  }
  NodePlaces mine, opposite;
  std::vector<double> share, other;
  for (const Node& owner : owned_) {
    mine.node.clear();
    opposite.node.clear();
    share.clear();
    other.clear();
    const auto add = [](NodePlaces& place_of, std::vector<double>& to, int slot, double value) {
      const std::size_t place = place_of(slot);
      to.resize(place_of.node.size(), 0.0);
      to[place] += value;
    };
    double area = 0;
    for (const Incident& i : owner.facets)
      for (const auto& [candidate, weights] : parts[at(i.facet)])
        for (std::size_t b = 0; b < corners_; ++b) {
          const double D = weights.D[at(i.corner)][b], M = weights.M[at(i.corner)][b];
          area += D;
          if (D != 0) add(mine, share, secondary_slots(i.facet)[b], D);
          if (M != 0 && candidate >= 0) add(opposite, other, primary_slots(candidate)[b], M);
        }
    Meeting meeting;
    meeting.index = owner.local;
    if (!(area > least_covered * owner.weight)) {
      if (owner.facets.empty()) continue;
      share = {1};
      mine.node = {owner.slot};
      other.clear();
      opposite.node.clear();
      area = 1;
    } else {
      meeting.area = area;
    }
    meeting.secondary = share.size();
    share.insert(share.end(), other.begin(), other.end());
    mine.node.insert(mine.node.end(), opposite.node.begin(), opposite.node.end());
    for (double& part : share) part /= area;
    meeting.node = mine.node;
    meeting.share = share;
    visitor(meeting);
  }
}

} // namespace impact
