#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>
#include <numbers>

namespace impact {

namespace {

// Where less of a weight than this part is covered, sides do not meet.
constexpr double least_common_part = 1e-6;
// Least covered part of a weight that the linear solves make up for.
constexpr double least_cover = 1e-3;

} // namespace

void MortarForm::release() {
  std::fill(switches_.begin(), switches_.end(), Switches());
  for (Facet& facet : facets_) facet.changes = {};
}

NodePairs MortarForm::couplings() const {
  NodePairs pairs;
  for (const Node& node : owned_) {
    std::vector<PetscInt> together;
    for (const Incident& i : node.facets) {
      const std::vector<PetscInt> primary = search_.primary_nodes(i.facet);
      together.insert(together.end(), facets_[at(i.facet)].node.begin(), facets_[at(i.facet)].node.end());
      together.insert(together.end(), primary.begin(), primary.end());
    }
    add_pairs_among(std::move(together), pairs);
  }
  sort_unique(pairs);
  return pairs;
}

MortarFacePair MortarForm::pair_at(int facet, int candidate, const std::vector<double>& u,
                                   bool with_gradient) const {
  const int *mine = secondary_slots(facet), *other = primary_slots(candidate);
  if (dim_ == 3) {
    const FaceCorners s = corners_from<4, 3>(mine[0], mine, u), p = corners_from<4, 3>(mine[0], other, u);
    return mortar_face_pair(s, primary_corners(candidate), p, facets_[at(facet)].face, with_gradient);
  }
  const auto s = corners_from<2, 2>(mine[0], mine, u), p = corners_from<2, 2>(mine[0], other, u);
  const MortarEdge& edge = facets_[at(facet)].edge;
  MortarFacePair pair;
  CoveredPart<double> part = covered_part(s, p);
  pair.covered = pair.touched = part.end > part.begin;
  if (!pair.covered) return pair;
  const std::array<double, 2> gap = weighted_gaps(part, edge);
  std::copy(gap.begin(), gap.end(), pair.gap.begin());
  part.gap_begin = part.gap_end = 1;
  const std::array<double, 2> cover = weighted_gaps(part, edge);
  std::copy(cover.begin(), cover.end(), pair.cover.begin());
  if (!with_gradient) return pair;
  const MortarPair with = mortar_pair(s, p, edge);
  for (std::size_t a = 0; a < 2; ++a)
    std::copy(with.gradient[a].begin(), with.gradient[a].end(), pair.gradient[a].begin());
  return pair;
}

Point3 MortarForm::place_of(const Facet& facet, const FacetPoint& point, const int* slot,
                            const std::vector<double>& u) const {
  Point3 x{};
  for (std::size_t a = 0; a < at(facet.corners); ++a)
    for (std::size_t k = 0; k < at(dim_); ++k) {
      const std::size_t i = at(dim_ * slot[a]) + k;
      x[k] += point.shape[a] * (nodes().X[i] + u[i]);
    }
  return x;
}

MortarFacePair MortarForm::obstacle_gaps(int f, const RigidObstacle& obstacle,
                                         const std::vector<double>& u) const {
  const Facet& facet = facets_[at(f)];
  MortarFacePair pair;
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

std::array<double, 4> MortarForm::areas_at(int facet, const std::vector<double>& u) const {
  const int* slot = secondary_slots(facet);
  if (dim_ == 3) return nodal_areas(facets_[at(facet)].corners, corners_from<4, 3>(slot[0], slot, u));
  const double length = distance(Point2<double>{0, 0}, nodes().place<2>(slot[1], slot[0], u));
  std::array<double, 2> ring = {1, 1};
  if (frame_ == Frame::axisymmetric)
    for (std::size_t a = 0; a < 2; ++a)
      ring[a] = 2 * std::numbers::pi * (nodes().X[2 * at(slot[a])] + u[2 * at(slot[a])]);
  return {length * (2 * ring[0] + ring[1]) / 6, length * (2 * ring[1] + ring[0]) / 6, 0, 0};
}

// Each pair once, for all corners of its secondary facet.
std::vector<MortarForm::Piece> MortarForm::pieces_at(const std::vector<double>& u, bool with_gradient,
                                                     std::vector<std::size_t>& first) const {
  std::vector<Piece> pieces;
  first.assign(1, 0);
  const RigidObstacle obstacle = obstacle_.at(u);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    if (rigid()) pieces.push_back({f, -1, obstacle_gaps(f, obstacle, u)});
    for (int candidate : facing_[at(f)]) {
      pieces.push_back({f, candidate, pair_at(f, candidate, u, with_gradient)});
      if (!pieces.back().pair.touched) pieces.pop_back();
    }
    first.push_back(pieces.size());
  }
  return pieces;
}

void MortarForm::visit(const std::vector<double>& u, Derivatives derivatives,
                       const ConstraintVisitor& visitor) const {
  const bool with_gradient = derivatives != Derivatives::none;
  const auto d = at(dim_);
  std::vector<std::size_t> first;
  const std::vector<Piece> pieces = pieces_at(u, with_gradient, first);
  std::vector<double> share, gradient;
  SlipRows slip_rows;
  visit_face_slips(u, with_gradient, slip_rows);
  NodePlaces place_of;
  std::vector<int>& node = place_of.node;
  for (std::size_t number = 0; number < owned_.size(); ++number) {
    const Node& owner = owned_[number];
    const bool covered = std::any_of(owner.facets.begin(), owner.facets.end(), [&](const Incident& i) {
      const auto begin = pieces.begin() + static_cast<std::ptrdiff_t>(first[at(i.facet)]),
                 end = pieces.begin() + static_cast<std::ptrdiff_t>(first[at(i.facet) + 1]);
      return std::any_of(begin, end, [](const Piece& piece) { return piece.pair.covered; });
    });
    if (!covered) continue;
    node.clear();
    Constraint c;
    c.index = owner.local;
    c.weight = owner.weight;
    double cover = 0, area = 0;
    // Secondary nodes first.
    for (const Incident& i : owner.facets)
      for (std::size_t a = 0; a < corners_; ++a) place_of(secondary_slots(i.facet)[a]);
    share.assign(node.size(), 0.0);
    gradient.assign(d * node.size(), 0.0);
    for (const Incident& i : owner.facets) {
      const std::size_t a = at(i.corner);
      const int* secondary = secondary_slots(i.facet);
      share[place_of(secondary[a])] = 1;
      area += areas_at(i.facet, u)[a];
      for (std::size_t k = first[at(i.facet)]; k < first[at(i.facet) + 1]; ++k) {
        const Piece& piece = pieces[k];
        c.gap += piece.pair.gap[a];
        cover += piece.pair.cover[a];
        if (!with_gradient) continue;
        const std::span<const int> primary = opposite_slots(piece.candidate);
        for (std::size_t b = 0; b < corners_ + primary.size(); ++b) {
          const std::size_t place = d * place_of(b < corners_ ? secondary[b] : primary[b - corners_]);
          gradient.resize(d * node.size(), 0.0);
          for (std::size_t m = 0; m < d; ++m)
            gradient[place + m] += piece.pair.gradient[a][d * b + m] / owner.weight;
        }
      }
    }
    c.slides = slip_nodes(number, place_of);
    gradient.resize(d * node.size(), 0.0);
    c.gap /= owner.weight;
    c.stretch = area / owner.weight;
    c.cover = std::max(std::abs(cover) / owner.weight, least_cover);
    c.node = node;
    c.share = share;
    if (with_gradient) c.gradient = gradient;
    if (c.slides) add_slip(number, u, place_of, slip_rows, c);
    visitor(c);
  }
}

void MortarForm::visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                 const BlockVisitor& visitor) const {
  std::array<int, 8> node{};
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
    std::copy_n(secondary_slots(f), corners_, node.begin());
    if (rigid()) {
      std::array<double, 576> block{};
      for (const FacetPoint& point : facet.points) {
        double weight = 0;
        for (std::size_t a = 0; a < 4; ++a) weight += factor[a] * point.weight[a];
        obstacle_.add_hessian(obstacle_.gap(obstacle, place_of(facet, point, node.data(), u)),
                              {point.shape.data(), corners_}, obstacle_.shares(), weight, block.data());
      }
      const std::size_t count = corners_ + obstacle_.slots().size(), n = at(dim_) * count;
      std::copy(obstacle_.slots().begin(), obstacle_.slots().end(),
                node.begin() + static_cast<std::ptrdiff_t>(corners_));
      visitor({node.data(), count}, {block.data(), n * n});
      continue;
    }
    for (int candidate : facing_[at(f)]) {
      std::copy_n(primary_slots(candidate), corners_, node.begin() + static_cast<std::ptrdiff_t>(corners_));
      const int *mine = node.data(), *other = mine + corners_;
      if (dim_ == 2) {
        const auto s = corners_from<2, 2>(mine[0], mine, u), p = corners_from<2, 2>(mine[0], other, u);
        visitor({node.data(), 4}, mortar_pair_hessian(s, p, facet.edge, {factor[0], factor[1]}));
        continue;
      }
      const FaceCorners s = corners_from<4, 3>(mine[0], mine, u), p = corners_from<4, 3>(mine[0], other, u);
      std::array<double, 576> block{};
      if (add_mortar_face_hessian(s, primary_corners(candidate), p, facet.face, factor, block))
        visitor(node, block);
    }
  }
  visit_slip_curvature(u, factors, visitor);
}

FaceWeights MortarForm::weights_at(int facet, int candidate, const std::vector<double>& u) const {
  const int *mine = secondary_slots(facet), *other = primary_slots(candidate);
  if (dim_ == 3)
    return mortar_face_weights(corners_from<4, 3>(mine[0], mine, u), primary_corners(candidate),
                               corners_from<4, 3>(mine[0], other, u), facets_[at(facet)].face);
  const MortarWeights edge = mortar_weights(corners_from<2, 2>(mine[0], mine, u),
                                            corners_from<2, 2>(mine[0], other, u), facets_[at(facet)].edge);
  FaceWeights weights;
  for (std::size_t a = 0; a < 2; ++a) {
    std::copy(edge.D[a].begin(), edge.D[a].end(), weights.D[a].begin());
    std::copy(edge.M[a].begin(), edge.M[a].end(), weights.M[a].begin());
  }
  return weights;
}

void MortarForm::visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const {
  // Each pair once, for all corners of its secondary facet.
  struct Part {
    int candidate; // -1: the rigid body
    FaceWeights weights;
  };
  std::vector<Part> parts;
  std::vector<std::size_t> first = {0};
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    if (rigid()) parts.push_back({-1, facets_[at(f)].onto});
    for (int candidate : facing_[at(f)]) parts.push_back({candidate, weights_at(f, candidate, u)});
    first.push_back(parts.size());
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
      for (std::size_t k = first[at(i.facet)]; k < first[at(i.facet) + 1]; ++k) {
        const Part& part = parts[k];
        for (std::size_t b = 0; b < corners_; ++b) {
          const double D = part.weights.D[at(i.corner)][b], M = part.weights.M[at(i.corner)][b];
          area += D;
          if (D != 0) add(mine, share, secondary_slots(i.facet)[b], D);
          if (M != 0 && part.candidate >= 0) add(opposite, other, primary_slots(part.candidate)[b], M);
        }
      }
    Meeting meeting;
    meeting.index = owner.local;
    if (!(area > least_common_part * owner.weight)) {
      if (owner.facets.empty()) continue;
      const Incident& i = owner.facets.front();
      share = {1};
      mine.node = {secondary_slots(i.facet)[i.corner]};
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
