#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>

/// Slip of a MortarForm (81'), (81''): what lay opposite at the start of a step, and the tangential motion
/// since.
namespace impact {

void MortarForm::visit_slip_block(int facet, std::span<const int> slots, std::span<const double> block,
                                  const BlockVisitor& visitor) const {
  if (!rigid()) return visitor(slots, block);
  std::vector<int> node(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(corners_));
  node.insert(node.end(), obstacle_.slots().begin(), obstacle_.slots().end());
  std::vector<double> chained;
  obstacle_.chain_block(facet, block, chained);
  visitor(node, chained);
}

void MortarForm::anchor(Vec u) {
  search_.set_start(u);
  const std::vector<double>& x = nodes().start;
  const bool restored = search_.restored() && !rigid();
  if (rigid() && frictional()) obstacle_.anchor(nodes(), x);
  if (!restored && (!frictional() || on_plane())) return;
  if (rigid()) return anchor_on_round();
  const Facing facing = facing_at(x);
  if (restored) facing_ = facing; // which bore the numbers of another list
  choose_functions(facing, x);
  release(); // what was chosen for the start does not count as a change
  if (!frictional()) return;
  if (dim_ == 2)
    anchor_edges(facing, x);
  else
    anchor_faces(facing, x);
  locate_anchors();
}

// What lies opposite is the place of the facet itself: no matter where on the body that is.
void MortarForm::anchor_on_round() {
  if (dim_ == 2) anchors_.assign(owned_.size(), {});
  for (std::size_t i = 0; dim_ == 2 && i < owned_.size(); ++i)
    for (const Incident& incident : owned_[i].facets) {
      const std::array<double, 4> weight = weights_of(incident, owned_[i]);
      anchors_[i].push_back({incident.facet, {}, {{weight[0], weight[1]}, {weight[0], weight[1]}}});
    }
  if (dim_ == 3) facet_anchors_.assign(facets_.size(), {});
  for (std::size_t f = 0; f < facet_anchors_.size(); ++f)
    facet_anchors_[f].push_back({{}, {facets_[f].onto, {}}});
}

std::array<double, 4> MortarForm::weights_of(const Incident& incident, const Node& owner) const {
  std::array<double, 4> weight = facets_[at(incident.facet)].onto.D[at(incident.corner)];
  for (double& part : weight) part /= owner.weight;
  return weight;
}

void MortarForm::anchor_faces(const Facing& facing, const std::vector<double>& x) {
  facet_anchors_.resize(facets_.size());
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    std::vector<FacetAnchor>& anchors = facet_anchors_[at(f)];
    anchors.clear();
    FaceCorners s = secondary_face(f, x);
    for (int c : facing[at(f)]) {
      FaceCorners p = primary_face(c, x);
      FacetAnchor anchor;
      anchor.pair.weights = mortar_face_weights(s, primary_corners(c), p, facets_[at(f)].face);
      if (!anchor.pair.weights.covered) continue;
      anchor.pair.start = face_slips(s, p, facets_[at(f)].map, anchor.pair, false).value;
      anchor.opposite.node = primary_nodes(c);
      anchors.push_back(anchor);
    }
  }
}

void MortarForm::anchor_edges(const Facing& facing, const std::vector<double>& x) {
  anchors_.assign(owned_.size(), {});
  for (std::size_t i = 0; i < owned_.size(); ++i)
    for (const Incident& incident : owned_[i].facets)
      for (int c : facing[at(incident.facet)]) {
        const auto edge = secondary_edge(incident.facet, x), primary = primary_edge(c, x);
        const CoveredPart<double> part = covered_part(edge, primary);
        if (!(part.end > part.begin)) continue;
        const MortarWeights w = mortar_weights(edge, primary, facets_[at(incident.facet)].edge);
        Anchor anchor;
        anchor.facet = incident.facet;
        anchor.opposite.node = {primary_nodes(c)[0], primary_nodes(c)[1]};
        for (std::size_t b = 0; b < 2; ++b) {
          anchor.pair.c[b] = w.D[at(incident.corner)][b] / owned_[i].weight;
          anchor.pair.m[b] = w.M[at(incident.corner)][b] / owned_[i].weight;
        }
        anchors_[i].push_back(anchor);
      }
}

void MortarForm::locate_anchors() {
  for (std::vector<Anchor>& anchors : anchors_)
    for (Anchor& anchor : anchors) anchor.opposite.locate(nodes());
  for (std::vector<FacetAnchor>& anchors : facet_anchors_)
    for (FacetAnchor& anchor : anchors) anchor.opposite.locate(nodes());
}

bool MortarForm::slip_nodes(std::size_t number, NodePlaces& place_of) const {
  if (!frictional()) return false;
  for (int slot : obstacle_.slots()) place_of(slot);
  if (on_plane()) return !nodes().start.empty();
  bool slides = false;
  const auto add = [&](const auto& opposite) {
    slides = slides || found(opposite);
    if (!rigid() && found(opposite))
      for (int slot : opposite.slot) place_of(slot);
  };
  if (dim_ == 2 && !anchors_.empty())
    for (const Anchor& anchor : anchors_[number]) add(anchor.opposite);
  if (dim_ == 3 && !facet_anchors_.empty())
    for (const Incident& i : owned_[number].facets)
      for (const FacetAnchor& anchor : facet_anchors_[at(i.facet)]) add(anchor.opposite);
  return slides;
}

void MortarForm::visit_face_slips(const std::vector<double>& u, bool with_gradient, SlipRows& rows) const {
  std::array<int, 8> slots;
  FaceCorners s, p;
  for (int f = 0; f < static_cast<int>(facet_anchors_.size()); ++f) {
    rows.first.push_back(rows.face.size());
    for (const FacetAnchor& anchor : facet_anchors_[at(f)]) {
      if (!found(anchor.opposite)) {
        rows.face.emplace_back();
        continue;
      }
      place_anchor(f, anchor, u, slots, s, p);
      rows.face.push_back(face_slips(s, p, facets_[at(f)].map, anchor.pair, with_gradient));
    }
  }
}

void MortarForm::add_slip(std::size_t number, const std::vector<double>& u, NodePlaces& place_of,
                          SlipRows& rows, Constraint& c) const {
  const Node& owner = owned_[number];
  const std::size_t d = at(dim_), n = d * place_of.node.size();
  std::vector<double>& gradient = rows.gradient;
  gradient.assign((d - 1) * n, 0.0);
  if (on_plane()) {
    add_plane_slip(owner, u, place_of, rows, c);
  } else if (d == 2) {
    for (const Anchor& anchor : anchors_[number]) {
      if (!found(anchor.opposite)) continue;
      std::array<int, 4> slots;
      const Slip slip = slip_at(anchor, u, slots);
      c.slip[0] += slip.value;
      for (std::size_t i = 0; i < (rigid() ? 4 : 8); ++i)
        gradient[2 * place_of(slots[i / 2]) + i % 2] += slip.gradient[i];
      std::array<double, 6> by_carrier;
      obstacle_.chain(anchor.facet, &slip.gradient[4], by_carrier.data());
      for (std::size_t i = 0; i < 2 * obstacle_.slots().size(); ++i)
        gradient[2 * place_of(obstacle_.slots()[i / 2]) + i % 2] += by_carrier[i];
    }
  } else {
    for (const Incident& i : owner.facets) {
      const int* secondary = secondary_slots(i.facet);
      const std::vector<FacetAnchor>& anchors = facet_anchors_[at(i.facet)];
      for (std::size_t k = 0; k < anchors.size(); ++k) {
        if (!found(anchors[k].opposite)) continue;
        const std::span<const int> other =
            rigid() ? std::span<const int>(obstacle_.slots()) : anchors[k].opposite.slot;
        const FaceSlips& slips = rows.face[rows.first[at(i.facet)] + k];
        for (std::size_t a = 0; a < 2; ++a)
          for (std::size_t e = 0; e < 2; ++e) {
            const double factor = i.turn[a][e] / owner.weight;
            c.slip[a] += factor * slips.value[at(i.corner)][e];
            std::array<double, 24> row = slips.gradient[at(i.corner)][e];
            if (rigid()) obstacle_.chain(i.facet, &slips.gradient[at(i.corner)][e][12], &row[12]);
            for (std::size_t b = 0; b < 4 + other.size(); ++b) {
              const std::size_t place = n * a + 3 * place_of(b < 4 ? secondary[b] : other[b - 4]);
              for (std::size_t m = 0; m < 3; ++m) gradient[place + m] += factor * row[3 * b + m];
            }
          }
      }
    }
  }
  c.slip_gradient = gradient;
}

void MortarForm::add_plane_slip(const Node& owner, const std::vector<double>& u, NodePlaces& place_of,
                                SlipRows& rows, Constraint& c) const {
  const std::array<Point3, 2> t = obstacle_.tangents();
  const std::size_t d = at(dim_), n = d * place_of.node.size();
  std::array<double, 24> local;
  Obstacle::PlaneSlip slip;
  for (const Incident& i : owner.facets) {
    const std::array<double, 4> weight = weights_of(i, owner);
    for (std::size_t a = 0; a < d - 1; ++a) {
      obstacle_.add_slip(nodes(), i.facet, {weight.data(), corners_}, t[a], u, c.slip[a], slip);
      local.fill(0);
      obstacle_.add_gradient(slip.function, {weight.data(), corners_}, slip.shares, 1, local.data());
      for (std::size_t b = 0; b < corners_ + obstacle_.slots().size(); ++b) {
        const int slot = b < corners_ ? secondary_slots(i.facet)[b] : obstacle_.slots()[b - corners_];
        for (std::size_t k = 0; k < d; ++k) rows.gradient[n * a + d * place_of(slot) + k] += local[d * b + k];
      }
    }
  }
}

void MortarForm::place_anchor(int facet, const FacetAnchor& anchor, const std::vector<double>& u,
                              std::array<int, 8>& slots, FaceCorners& s, FaceCorners& p) const {
  const int* secondary = secondary_slots(facet);
  for (std::size_t a = 0; a < 4; ++a) {
    slots[a] = secondary[a];
    slots[4 + a] = anchor.opposite.slot[a];
    s[a] = nodes().place<3>(secondary[a], secondary[0], u);
  }
  p = place_opposite<4, 3>(anchor.opposite, facet, secondary[0], u);
}

void MortarForm::place_anchor(const Anchor& anchor, const std::vector<double>& u, std::array<int, 4>& slots,
                              std::array<Point2<double>, 2>& s, std::array<Point2<double>, 2>& p) const {
  const int* secondary = secondary_slots(anchor.facet);
  slots = {secondary[0], secondary[1], anchor.opposite.slot[0], anchor.opposite.slot[1]};
  for (std::size_t a = 0; a < 2; ++a) s[a] = nodes().place<2>(slots[a], slots[0], u);
  p = place_opposite<2, 2>(anchor.opposite, anchor.facet, slots[0], u);
}

Slip MortarForm::slip_at(const Anchor& anchor, const std::vector<double>& u,
                         std::array<int, 4>& slots) const {
  std::array<Point2<double>, 2> s, p;
  place_anchor(anchor, u, slots, s, p);
  return slip_of(s, p, anchor.pair);
}

void MortarForm::visit_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                      const BlockVisitor& visitor) const {
  if (on_plane()) return visit_plane_slip_curvature(u, factors, visitor);
  for (int f = 0; f < static_cast<int>(facet_anchors_.size()); ++f) {
    std::array<std::array<double, 2>, 4> factor{};
    bool any = false;
    const Facet& facet = facets_[at(f)];
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      if (facet.owned[a] < 0) continue;
      const Node& owner = owned_[at(facet.owned[a])];
      const Tangential of_slip = factors.of_slip(owner.local);
      if (of_slip == Tangential{}) continue;
      any = true;
      const auto here = std::find_if(owner.facets.begin(), owner.facets.end(),
                                     [&](const Incident& i) { return i.facet == f && at(i.corner) == a; });
      for (std::size_t e = 0; e < 2; ++e)
        factor[a][e] = (of_slip[0] * here->turn[0][e] + of_slip[1] * here->turn[1][e]) / owner.weight;
    }
    if (!any) continue;
    for (const FacetAnchor& anchor : facet_anchors_[at(f)]) {
      if (!found(anchor.opposite)) continue;
      std::array<int, 8> slots;
      FaceCorners s, p;
      place_anchor(f, anchor, u, slots, s, p);
      std::array<double, 576> block{};
      add_face_slip_hessian(s, p, facet.map, anchor.pair, factor, block);
      visit_slip_block(f, slots, block, visitor);
    }
  }
  for (std::size_t number = 0; number < anchors_.size(); ++number) {
    const double factor = factors.of_slip(owned_[number].local)[0];
    if (factor == 0) continue;
    for (const Anchor& anchor : anchors_[number]) {
      if (!found(anchor.opposite)) continue;
      std::array<int, 4> slots;
      std::array<Point2<double>, 2> s, p;
      place_anchor(anchor, u, slots, s, p);
      std::array<double, 64> block = slip_hessian(s, p, anchor.pair);
      for (double& value : block) value *= factor;
      visit_slip_block(anchor.facet, slots, block, visitor);
    }
  }
}

void MortarForm::visit_plane_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                            const BlockVisitor& visitor) const {
  if (!obstacle_.carried()) return; // a linear function
  const std::array<Point3, 2> t = obstacle_.tangents();
  const std::size_t count = corners_ + obstacle_.slots().size(), n = at(dim_) * count;
  std::array<double, 576> block;
  std::vector<int> node;
  Obstacle::PlaneSlip slip;
  for (const Node& owner : owned_) {
    const Tangential factor = factors.of_slip(owner.local);
    if (factor == Tangential{}) continue;
    for (const Incident& i : owner.facets) {
      const std::array<double, 4> weight = weights_of(i, owner);
      block.fill(0);
      for (std::size_t a = 0; a < at(dim_) - 1; ++a) {
        double value = 0;
        obstacle_.add_slip(nodes(), i.facet, {weight.data(), corners_}, t[a], u, value, slip);
        obstacle_.add_hessian(slip.function, {weight.data(), corners_}, slip.shares, factor[a], block.data());
      }
      node.assign(secondary_slots(i.facet), secondary_slots(i.facet) + corners_);
      node.insert(node.end(), obstacle_.slots().begin(), obstacle_.slots().end());
      visitor(node, {block.data(), n * n});
    }
  }
}

} // namespace impact
