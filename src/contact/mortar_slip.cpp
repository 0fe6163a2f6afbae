#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>

/// Slip of a MortarForm: what lay opposite at the start of a step, and the tangential motion since.
namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

} // namespace

void MortarForm::visit_slip_block(int facet, bool carried_along, std::span<const int> slots,
                                  std::span<const double> block, const BlockVisitor& visitor) const {
  if (!carried_along) return visitor(slots, block);
  if (carried()) {
    std::vector<int> node(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(corners_));
    node.insert(node.end(), carrier_.slots().begin(), carrier_.slots().end());
    std::vector<double> chained;
    carrier_.chain_block(facet, block, chained);
    return visitor(node, chained);
  }
  // The part that belongs to the secondary.
  const std::size_t half = at(dim_) * corners_;
  std::array<double, 144> part;
  for (std::size_t i = 0; i < half; ++i) std::copy_n(&block[2 * half * i], half, &part[half * i]);
  visitor(slots.first(corners_), {part.data(), half * half});
}

void MortarForm::find_tangents(const std::vector<double>& X) {
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    FaceCorners corner;
    for (int a = 0; a < 4; ++a) std::copy_n(&X[at(3 * (4 * f + a))], 3, corner[at(a)].begin());
    facets_[at(f)].map = make_face_map(facets_[at(f)].corners, corner);
  }
  for (Node& node : owned_) {
    Point3 n{};
    for (const Incident& incident : node.facets) {
      const Facet& facet = facets_[at(incident.facet)];
      double area = 0;
      for (double part : facet.face.area) area += part;
      for (std::size_t k = 0; k < 3; ++k) n[k] += area * facet.map.normal[k];
    }
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(length > 0)) n = facets_[at(node.facets[0].facet)].map.normal; // both sides of a sheet
    if (length > 0)
      for (double& component : n) component /= length;
    const std::array<Point3, 2> tangents = tangents_of(n);
    for (Incident& incident : node.facets)
      incident.turn = turned_into(facets_[at(incident.facet)].map, n, tangents);
  }
}

void MortarForm::anchor(Vec u) {
  pose_.moved = {};
  search_.set_start(u);
  const bool rubs = settings_.friction > 0, restored = search_.restored() && !settings_.rigid();
  if (carried() && rubs) carrier_.anchor(nodes(), nodes().start);
  if (!restored && (!rubs || on_plane())) return;
  const std::vector<double>& x = nodes().start;
  if (settings_.rigid()) return anchor_on_round(x);
  const Facing facing = facing_at(x);
  if (restored) facing_ = facing; // which bore the numbers of another list
  choose_functions(facing, x);
  release(); // what was chosen for the start does not count as a change
  if (!rubs) return;
  if (dim_ == 2)
    anchor_edges(facing, x);
  else
    anchor_faces(facing, x);
  locate_anchors();
}

void MortarForm::anchor_on_round(const std::vector<double>& x) {
  // What lies opposite is the place of the facet itself: no matter where on the body that is.
  if (dim_ == 2) anchors_.assign(owned_.size(), {});
  if (dim_ == 3) facet_anchors_.assign(facets_.size(), {});
  for (std::size_t i = 0; dim_ == 2 && i < owned_.size(); ++i)
    for (const Incident& incident : owned_[i].facets) {
      Anchor anchor;
      anchor.facet = incident.facet;
      anchor.opposite.carried = true;
      anchor.opposite.place = secondary_edge(incident.facet, x);
      for (std::size_t b = 0; b < 2; ++b)
        anchor.pair.c[b] = anchor.pair.m[b] =
            facets_[at(incident.facet)].onto.D[at(incident.corner)][b] / owned_[i].weight;
      anchors_[i].push_back(anchor);
    }
  for (int f = 0; dim_ == 3 && f < static_cast<int>(facets_.size()); ++f) {
    FacetAnchor anchor;
    anchor.opposite.carried = true;
    anchor.opposite.place = secondary_face(f, x);
    anchor.pair.weights = facets_[at(f)].onto;
    facet_anchors_[at(f)].push_back(anchor);
  }
  locate_anchors();
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
      anchor.opposite.node = search_.candidates().primary[at(search_.candidates().facet[at(c)])].node;
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
        const SearchFacet& on = search_.candidates().primary[at(search_.candidates().facet[at(c)])];
        anchor.opposite.node = {on.node[0], on.node[1]};
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
  if (!(settings_.friction > 0)) return false;
  for (int slot : carrier_.slots()) place_of(slot);
  if (on_plane()) return !nodes().start.empty();
  bool slides = false;
  const auto add = [&](const auto& opposite) {
    slides = slides || opposite.found();
    if (!opposite.carried && opposite.found())
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
      if (!anchor.opposite.found()) {
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
  if (on_plane() && carried()) {
    add_plane_slip(owner, u, place_of, rows, c);
  } else if (on_plane()) {
    const std::array<Point3, 2> t = plane_tangents();
    for (const Incident& i : owner.facets) {
      const int* slot = secondary_slots(i.facet);
      for (std::size_t b = 0; b < at(facets_[at(i.facet)].corners); ++b) {
        const double weight = facets_[at(i.facet)].onto.D[at(i.corner)][b] / owner.weight;
        for (std::size_t k = 0; k < d; ++k) {
          const std::size_t dof = d * at(slot[b]) + k;
          const double moved = this->nodes().X[dof] + u[dof] - this->nodes().start[dof] - pose_.moved[k];
          for (std::size_t a = 0; a < d - 1; ++a) {
            c.slip[a] += weight * t[a][k] * moved;
            gradient[n * a + d * place_of(slot[b]) + k] += weight * t[a][k];
          }
        }
      }
    }
  } else if (d == 2) {
    for (const Anchor& anchor : anchors_[number]) {
      if (!anchor.opposite.found()) continue;
      std::array<int, 4> slots;
      const Slip slip = slip_at(anchor, u, slots);
      c.slip[0] += slip.value;
      for (std::size_t i = 0; i < (anchor.opposite.carried ? 4 : 8); ++i)
        gradient[2 * place_of(slots[i / 2]) + i % 2] += slip.gradient[i];
      if (!carried()) continue;
      std::array<double, 6> by_carrier;
      carrier_.chain(anchor.facet, &slip.gradient[4], by_carrier.data());
      for (std::size_t i = 0; i < 6; ++i)
        gradient[2 * place_of(carrier_.slots()[i / 2]) + i % 2] += by_carrier[i];
    }
  } else {
    for (const Incident& i : owner.facets) {
      const int* secondary = secondary_slots(i.facet);
      const std::vector<FacetAnchor>& anchors = facet_anchors_[at(i.facet)];
      for (std::size_t k = 0; k < anchors.size(); ++k) {
        const Opposite<4, 3>& opposite = anchors[k].opposite;
        if (!opposite.found()) continue;
        const FaceSlips& slips = rows.face[rows.first[at(i.facet)] + k];
        for (std::size_t a = 0; a < 2; ++a)
          for (std::size_t e = 0; e < 2; ++e) {
            const double factor = i.turn[a][e] / owner.weight;
            c.slip[a] += factor * slips.value[at(i.corner)][e];
            std::array<double, 24> row = slips.gradient[at(i.corner)][e];
            if (carried()) carrier_.chain(i.facet, &slips.gradient[at(i.corner)][e][12], &row[12]);
            const int* other = carried() ? carrier_.slots().data() : opposite.slot.data();
            for (std::size_t b = 0; b < (opposite.carried && !carried() ? 4 : 8); ++b) {
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
  const std::array<Point3, 2> t = plane_tangents();
  const std::size_t d = at(dim_), n = d * place_of.node.size();
  std::array<double, 24> local;
  std::array<double, 4> weight;
  for (const Incident& i : owner.facets) {
    for (std::size_t b = 0; b < corners_; ++b)
      weight[b] = facets_[at(i.facet)].onto.D[at(i.corner)][b] / owner.weight;
    for (std::size_t a = 0; a < d - 1; ++a) {
      const ObstacleCarrier::PlaneSlip slip =
          carrier_.slip(nodes(), i.facet, {weight.data(), corners_}, t[a], u);
      c.slip[a] += slip.function.value;
      local.fill(0);
      carrier_.add_gradient(slip.function, {weight.data(), corners_}, slip.shares, 1, local.data());
      for (std::size_t b = 0; b < corners_ + carrier_.slots().size(); ++b) {
        const int slot = b < corners_ ? secondary_slots(i.facet)[b] : carrier_.slots()[b - corners_];
        for (std::size_t k = 0; k < d; ++k) rows.gradient[n * a + d * place_of(slot) + k] += local[d * b + k];
      }
    }
  }
}

std::array<Point3, 2> MortarForm::plane_tangents() const {
  const Point3& n = pose_.obstacle.direction;
  if (dim_ == 2) return {Point3{-n[1], n[0], 0}, Point3{}};
  return tangents_of(n);
}

void MortarForm::place_anchor(int facet, const FacetAnchor& anchor, const std::vector<double>& u,
                              std::array<int, 8>& slots, FaceCorners& s, FaceCorners& p) const {
  const int* secondary = secondary_slots(facet);
  for (std::size_t a = 0; a < 4; ++a) {
    slots[a] = secondary[a];
    slots[4 + a] = anchor.opposite.slot[a];
    s[a] = nodes().place<3>(secondary[a], secondary[0], u);
  }
  p = place_opposite(anchor.opposite, facet, secondary[0], u);
}

void MortarForm::place_anchor(const Anchor& anchor, const std::vector<double>& u, std::array<int, 4>& slots,
                              std::array<Point2<double>, 2>& s, std::array<Point2<double>, 2>& p) const {
  const int* secondary = secondary_slots(anchor.facet);
  slots = {secondary[0], secondary[1], anchor.opposite.slot[0], anchor.opposite.slot[1]};
  for (std::size_t a = 0; a < 2; ++a) s[a] = nodes().place<2>(slots[a], slots[0], u);
  p = place_opposite(anchor.opposite, anchor.facet, slots[0], u);
}

Slip MortarForm::slip_at(const Anchor& anchor, const std::vector<double>& u,
                         std::array<int, 4>& slots) const {
  std::array<Point2<double>, 2> s, p;
  place_anchor(anchor, u, slots, s, p);
  return slip_of(s, p, anchor.pair);
}

void MortarForm::visit_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                      const BlockVisitor& visitor) const {
  if (on_plane() && carried()) return visit_plane_slip_curvature(u, factors, visitor);
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
      if (!anchor.opposite.found()) continue;
      std::array<int, 8> slots;
      FaceCorners s, p;
      place_anchor(f, anchor, u, slots, s, p);
      std::array<double, 576> block{};
      add_face_slip_hessian(s, p, facet.map, anchor.pair, factor, block);
      visit_slip_block(f, anchor.opposite.carried, slots, block, visitor);
    }
  }
  for (std::size_t number = 0; number < anchors_.size(); ++number) {
    const double factor = factors.of_slip(owned_[number].local)[0];
    if (factor == 0) continue;
    for (const Anchor& anchor : anchors_[number]) {
      if (!anchor.opposite.found()) continue;
      std::array<int, 4> slots;
      std::array<Point2<double>, 2> s, p;
      place_anchor(anchor, u, slots, s, p);
      std::array<double, 64> block = slip_hessian(s, p, anchor.pair);
      for (double& value : block) value *= factor;
      visit_slip_block(anchor.facet, anchor.opposite.carried, slots, block, visitor);
    }
  }
}

void MortarForm::visit_plane_slip_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                            const BlockVisitor& visitor) const {
  const std::array<Point3, 2> t = plane_tangents();
  const std::size_t count = corners_ + carrier_.slots().size(), n = at(dim_) * count;
  std::array<double, 4> weight;
  std::array<double, 576> block;
  std::vector<int> node;
  for (const Node& owner : owned_) {
    const Tangential factor = factors.of_slip(owner.local);
    if (factor == Tangential{}) continue;
    for (const Incident& i : owner.facets) {
      for (std::size_t b = 0; b < corners_; ++b)
        weight[b] = facets_[at(i.facet)].onto.D[at(i.corner)][b] / owner.weight;
      block.fill(0);
      for (std::size_t a = 0; a < at(dim_) - 1; ++a) {
        const ObstacleCarrier::PlaneSlip slip =
            carrier_.slip(nodes(), i.facet, {weight.data(), corners_}, t[a], u);
        carrier_.add_hessian(slip.function, {weight.data(), corners_}, slip.shares, factor[a], block.data());
      }
      node.assign(secondary_slots(i.facet), secondary_slots(i.facet) + corners_);
      node.insert(node.end(), carrier_.slots().begin(), carrier_.slots().end());
      visitor(node, {block.data(), n * n});
    }
  }
}

} // namespace impact
