#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>

/// Slip of a MortarForm (81'), (81''): what lay opposite at the start of a step, and the tangential motion
/// since.
namespace impact {

namespace {

template <std::size_t nodes>
void add_opening(double factor, const MortarWeights& weights, std::size_t a, Opening<nodes>& opening) {
  for (std::size_t b = 0; b < nodes; ++b) {
    opening.D[b] += factor * weights.D[a][b];
    opening.M[b] += factor * weights.M[a][b];
  }
}

Point3 normal_of(const FaceCorners& x) { return facet_normal(x); }
Point3 normal_of(const EdgeCorners& x) {
  const double dx = x[1][0] - x[0][0], dy = x[1][1] - x[0][1], length = std::hypot(dx, dy);
  return {dy / length, -dx / length, 0};
}

// Components of the openings of all functions.
template <std::size_t dim, std::size_t width>
std::array<std::array<double, 3>, 4>
openings(const FacetNodes<dim, width>& s, const FacetNodes<dim, width>& p,
         const TangentRows<dim, width>& tangents, const MortarWeights& weights) {
  std::array<std::array<double, 3>, 4> start{};
  const SlipDirections<dim, width> directions(s, tangents, false);
  for (std::size_t a = 0; a < width; ++a) {
    Opening<width> opening;
    add_opening(1, weights, a, opening);
    const std::array<double, dim> v = directions.opened(p, opening);
    std::copy(v.begin(), v.end(), start[a].begin());
    if (dim == 2) start[a][0] = 0; // of edges it is along the normal
  }
  return start;
}

} // namespace

template <std::size_t dim, std::size_t width>
MortarForm::FacetSlips
MortarForm::facet_slips(const FacetNodes<dim, width>& s, const FacetNodes<dim, width>& p,
                        const TangentRows<dim, width>& tangents, const std::array<Lean, 4>& lean,
                        const Anchor& anchor, bool with_gradient) {
  FacetSlips slips;
  const SlipDirections<dim, width> directions(s, tangents, with_gradient);
  for (std::size_t a = 0; a < width; ++a) {
    Opening<width> opening;
    add_opening(1, anchor.weights, a, opening);
    const FacetSlip<dim, width> slip = directions.slip(p, opening, lean[a]);
    for (std::size_t i = 0; i < dim - 1; ++i) {
      slips.value[a][i] = slip.value[i];
      for (std::size_t k = 0; k < dim; ++k) slips.value[a][i] -= lean[a][i][k] * anchor.start[a][k];
      std::copy(slip.gradient[i].begin(), slip.gradient[i].end(), slips.gradient[a][i].begin());
    }
  }
  return slips;
}

void MortarForm::anchor(Vec u) {
  search_.set_start(u);
  anchors_.clear();
  find_vertices();
  const ContactValues& x = vertices().start;
  const bool restored = search_.restored() && !rigid();
  if (rigid() && frictional()) obstacle_.anchor(vertices(), x);
  if (!restored && (!frictional() || on_plane())) return;
  Facing facing(facets_.size());
  if (!rigid()) {
    facing = facing_at(x);
    if (restored) facing_ = facing; // which bore the numbers of another list
    choose_functions(facing, x);
    release(); // what was chosen for the start does not count as a change
  }
  if (!frictional()) return;
  anchors_.assign(facets_.size(), {});
  FacetNormals normals(facets_.size());
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) anchor_facet(f, facing, x, normals);
  find_vertices();
  if (!leans_at_anchor()) return;
  if (rigid())
    turn_slip(nodes().displacement(u));
  else
    lean(x, normals);
}

void MortarForm::add_normal(int f, int candidate, const ContactValues& x, const std::array<double, 4>& cover,
                            FacetNormals& normals) const {
  at_pair(f, candidate, x, [&](const auto& s, const auto& p) {
    const Point3 n = normal_of(s), m = normal_of(p);
    for (std::size_t a = 0; a < cover.size(); ++a) {
      normals[at(f)][a].cover += cover[a];
      for (std::size_t k = 0; k < 3; ++k) normals[at(f)][a].force[k] += cover[a] / dot(n, m) * m[k];
    }
  });
}

void MortarForm::add_normal(int f, const RigidObstacle& obstacle, const ContactValues& u,
                            FacetNormals& normals) const {
  const Facet& facet = facets_[at(f)];
  for (const FacetPoint& point : facet.points) {
    const CarriedFunction gap = obstacle_.gap(obstacle, place_of(facet, point, secondary_slots(f), u));
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      normals[at(f)][a].cover += point.weight[a];
      for (std::size_t k = 0; k < 3; ++k) normals[at(f)][a].force[k] += point.weight[a] * gap.by_place[k];
    }
  }
}

void MortarForm::lean(const ContactValues& x, const FacetNormals& normals) {
  // Of a face at 60 degrees; it would be more where functions of both signs leave little of a cover.
  constexpr double longest = 2;
  for (const Node& owner : owned_) {
    Seen all;
    for (const Incident& i : owner.facets) {
      const Seen& seen = normals[at(i.facet)][at(i.corner)];
      all.cover += seen.cover;
      for (std::size_t k = 0; k < 3; ++k) all.force[k] += seen.force[k];
    }
    const double force = std::sqrt(dot(all.force, all.force));
    for (const Incident& i : owner.facets) {
      Facet& facet = facets_[at(i.facet)];
      facet.lean[at(i.corner)] = dim_ == 2 ? upright<2>() : upright<3>();
      if (!(all.cover > rounded_part * owner.weight && force > 0)) continue; // it faces nothing
      by_dimension([&]<class Corners>(const Corners&) {
        constexpr std::size_t dim = std::tuple_size_v<typename Corners::value_type>;
        const Corners s = corners_at<Corners>(secondary_slots(i.facet), x);
        std::array<double, dim> n;
        std::copy_n(all.force.begin(), dim, n.begin());
        const SlipDirections<dim, std::tuple_size_v<Corners>> directions(s, facet.tangents(s), false);
        facet.lean[at(i.corner)] =
            lean_to<dim>(directions.components(n), std::min(force / all.cover, longest));
      });
    }
  }
}

void MortarForm::anchor_facet(int f, const Facing& facing, const ContactValues& x, FacetNormals& normals) {
  Facet& facet = facets_[at(f)];
  facet.slid = {};
  facet.growth = {1, 1, 1, 1};
  std::vector<Anchor>& anchors = anchors_[at(f)];
  // What lies opposite on a round body is the place of the facet itself: no matter where on the body that is.
  if (rigid()) anchors.push_back({{}, facet.onto});
  for (int c : facing[at(f)]) {
    Anchor anchor;
    at_pair(f, c, x, [&](const auto& s, const auto& p) {
      anchor.weights = mortar_weights(s, p, facet.reference(s));
      anchor.start = openings(s, p, facet.tangents(s), anchor.weights);
    });
    if (!anchor.weights.covered) continue;
    anchor.opposite.node = primary_nodes(c);
    anchor.opposite.part = c % parts_;
    anchors.push_back(anchor);
    std::array<double, 4> cover{};
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      for (std::size_t b = 0; b < corners_; ++b) cover[a] += anchor.weights.D[a][b];
      facet.slid[a] += cover[a];
    }
    if (leans_at_anchor()) add_normal(f, c, x, cover, normals);
  }
  for (Anchor& anchor : anchors)
    for (std::size_t a = 0; dim_ == 2 && a < 2; ++a)
      for (std::size_t b = 0; facet.owned[a] >= 0 && b < 2; ++b)
        for (double* part : {&anchor.weights.D[a][b], &anchor.weights.M[a][b], &anchor.start[a][b]})
          *part /= owned_[at(facet.owned[a])].weight;
}

std::array<double, 4> MortarForm::weights_of(const Incident& incident, const Node& owner) const {
  std::array<double, 4> weight = facets_[at(incident.facet)].onto.D[at(incident.corner)];
  for (double& part : weight) part /= owner.weight;
  return weight;
}

bool MortarForm::slip_nodes(const Node& owner, NodePlaces& place_of) const {
  if (!frictional()) return false;
  for (int slot : obstacle_.slots()) place_of(slot);
  if (on_plane()) return !nodes().start.empty();
  bool slides = false;
  for (const Incident& i : owner.facets)
    for (std::size_t k = 0; !anchors_.empty() && k < anchors_[at(i.facet)].size(); ++k) {
      const Anchor& anchor = anchors_[at(i.facet)][k];
      slides = slides || found(anchor);
      for (std::size_t b = 0; !rigid() && found(anchor) && b < corners_; ++b)
        place_of(anchor.opposite.slot[b]);
    }
  return slides;
}

MortarForm::SlipRows MortarForm::slips_at(const ContactValues& u, bool with_gradient) const {
  SlipRows rows;
  rows.facet.resize(anchors_.size());
  for (int f = 0; f < static_cast<int>(anchors_.size()); ++f)
    for (const Anchor& anchor : anchors_[at(f)]) {
      FacetSlips& slips = rows.facet[at(f)].emplace_back();
      if (found(anchor))
        slips = from_anchor(f, anchor, u, [&](const auto& s, const auto& p) {
          return facet_slips(s, p, facets_[at(f)].tangents(s), facets_[at(f)].lean, anchor, with_gradient);
        });
    }
  return rows;
}

// Within a linear solve and its line search what a facet sees is fixed: the tangent stays exact.
void MortarForm::follow_slip(const ContactValues& of_nodes) {
  if (anchors_.empty() || rigid()) return;
  ContactValues store;
  const Pieces pieces = pieces_at(at_vertices(of_nodes, store), false);
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    Facet& facet = facets_[f];
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      facet.growth[a] = 1;
      if (facet.owned[a] < 0 || !(facet.slid[a] > rounded_part * owned_[at(facet.owned[a])].weight)) continue;
      double now = 0;
      for (const Piece& piece : pieces[f]) now += piece.pair.cover[a];
      facet.growth[a] = std::max(0.0, now / facet.slid[a]);
    }
  }
}

// Fixed within a Newton solve, as its tangent takes them.
void MortarForm::turn_slip(const ContactValues& of_nodes) {
  if (anchors_.empty() || on_plane() || !leans()) return;
  ContactValues store;
  const ContactValues& u = at_vertices(of_nodes, store);
  const ContactValues x = vertices().current(u);
  FacetNormals normals(facets_.size());
  const RigidObstacle obstacle = obstacle_.at(u);
  const Pieces pieces = rigid() ? Pieces(facets_.size()) : pieces_at(u, false);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    if (rigid()) add_normal(f, obstacle, u, normals);
    for (const Piece& piece : pieces[at(f)]) add_normal(f, piece.candidate, x, piece.pair.cover, normals);
  }
  lean(x, normals);
}

void MortarForm::add_slip(const Node& owner, const ContactValues& u, NodePlaces& place_of, SlipRows& rows,
                          Constraint& c) const {
  const std::size_t d = at(dim_), n = d * place_of.node.size(), half = d * corners_;
  rows.gradient.assign((d - 1) * n, 0.0);
  // A row over the corners of a facet and over what lies opposite it.
  const auto add = [&](std::size_t direction, const Incident& i, std::span<const int> opposite, double factor,
                       const std::array<double, 24>& row) {
    for (std::size_t b = 0; b < corners_ + opposite.size(); ++b) {
      const int slot = b < corners_ ? secondary_slots(i.facet)[b] : opposite[b - corners_];
      const std::size_t place = n * direction + d * place_of(slot);
      for (std::size_t m = 0; m < d; ++m) rows.gradient[place + m] += factor * row[d * b + m];
    }
  };
  for (const Incident& i : owner.facets) {
    const std::array<double, 4> weight = weights_of(i, owner);
    const double growth = facets_[at(i.facet)].growth[at(i.corner)];
    for (std::size_t a = 0; on_plane() && a < d - 1; ++a) {
      Obstacle::PlaneSlip slip;
      std::array<double, 24> row{};
      obstacle_.add_slip(vertices(), i.facet, {weight.data(), corners_}, obstacle_.tangents()[a], u,
                         c.slip[a], slip);
      obstacle_.add_gradient(slip.function, {weight.data(), corners_}, slip.shares, 1, row.data());
      add(a, i, obstacle_.slots(), 1, row);
    }
    for (std::size_t k = 0; !on_plane() && k < anchors_[at(i.facet)].size(); ++k) {
      const Anchor& anchor = anchors_[at(i.facet)][k];
      if (!found(anchor)) continue;
      const FacetSlips& slips = rows.facet[at(i.facet)][k];
      for (std::size_t a = 0; a < d - 1; ++a)
        for (std::size_t e = 0; e < d - 1; ++e) {
          const double factor = growth * slip_part(i, owner, a, e);
          c.slip[a] += factor * slips.value[at(i.corner)][e];
          std::array<double, 24> row = slips.gradient[at(i.corner)][e];
          if (!rigid()) {
            add(a, i, {anchor.opposite.slot.data(), corners_}, factor, row);
          } else {
            obstacle_.chain(i.facet, &slips.gradient[at(i.corner)][e][half], &row[half]);
            add(a, i, obstacle_.slots(), factor, row);
          }
        }
    }
  }
  c.slip_gradient = rows.gradient;
}

void MortarForm::visit_facet_slip_curvature(int f, const std::array<Tangential, 4>& factor,
                                            const ContactValues& u, const BlockVisitor& visitor) const {
  const std::size_t n = 2 * at(dim_) * corners_;
  for (const Anchor& anchor : anchors_[at(f)]) {
    if (!found(anchor)) continue;
    std::array<double, 576> block{};
    from_anchor(f, anchor, u,
                [&]<std::size_t dim, std::size_t width>(const FacetNodes<dim, width>& s, const auto& p) {
                  std::array<Opening<width>, dim> sum;
                  const std::array<Lean, 4>& lean = facets_[at(f)].lean;
                  for (std::size_t k = 0; k < dim; ++k)
                    for (std::size_t a = 0; a < width; ++a)
                      add_opening(factor[a][0] * lean[a][0][k] + factor[a][1] * lean[a][1][k], anchor.weights,
                                  a, sum[k]);
                  add_slip_hessian(s, p, facets_[at(f)].tangents(s), sum, block);
                });
    visit_slip_block(f, anchor.opposite, {block.data(), n * n}, visitor);
  }
}

void MortarForm::visit_slip_curvature(const ContactValues& u, const CurvatureFactors& factors,
                                      const BlockVisitor& visitor) const {
  if (on_plane()) return visit_plane_slip_curvature(u, factors, visitor);
  if (anchors_.empty()) return;
  if (dim_ == 2) { // node by node
    for (const Node& owner : owned_)
      for (const Incident& i : owner.facets) {
        std::array<Tangential, 4> factor{};
        factor[at(i.corner)] = factors.of_slip(owner.local);
        factor[at(i.corner)][0] *= facets_[at(i.facet)].growth[at(i.corner)];
        if (factor[at(i.corner)][0] != 0) visit_facet_slip_curvature(i.facet, factor, u, visitor);
      }
    return;
  }
  for (int f = 0; f < static_cast<int>(anchors_.size()); ++f) {
    std::array<Tangential, 4> factor{};
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
      const double part = facet.growth[a] / owner.weight;
      for (std::size_t e = 0; e < 2; ++e)
        factor[a][e] = part * (of_slip[0] * here->turn[0][e] + of_slip[1] * here->turn[1][e]);
    }
    if (any) visit_facet_slip_curvature(f, factor, u, visitor);
  }
}

void MortarForm::visit_plane_slip_curvature(const ContactValues& u, const CurvatureFactors& factors,
                                            const BlockVisitor& visitor) const {
  if (!obstacle_.carried()) return; // a linear function
  const std::array<Point3, 2> t = obstacle_.tangents();
  const std::size_t count = corners_ + obstacle_.slots().size(), n = at(dim_) * count;
  std::array<double, 576> block;
  Obstacle::PlaneSlip slip;
  for (const Node& owner : owned_) {
    const Tangential factor = factors.of_slip(owner.local);
    if (factor == Tangential{}) continue;
    for (const Incident& i : owner.facets) {
      const std::array<double, 4> weight = weights_of(i, owner);
      block.fill(0);
      for (std::size_t a = 0; a < at(dim_) - 1; ++a) {
        double value = 0;
        obstacle_.add_slip(vertices(), i.facet, {weight.data(), corners_}, t[a], u, value, slip);
        obstacle_.add_hessian(slip.function, {weight.data(), corners_}, slip.shares, factor[a], block.data());
      }
      visitor(with_carrier(i.facet, corners_), {block.data(), n * n});
    }
  }
}

} // namespace impact
