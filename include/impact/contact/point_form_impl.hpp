#pragma once
#include <algorithm>
#include <impact/contact/point_form_slip.hpp>

/// What PointForm does with the points of any geometry; included where a geometry stands.
namespace impact {

template <class G>
PointForm<G>::PointForm(const FormRequest& request)
    : ContactForm(request), secondary_(request.secondary), frame_(request.frame),
      points_(G::make_points(secondary_, request.settings, request.frame)), hold_gap_(request.hold_gap) {
  const FieldLayout& layout = request.layout;
  if constexpr (!G::curved)
    if (settings_.at_nodes) points_.move_to_corners();
  holds_.resize(points_.weight.size());
  if (frictional()) {
    anchors_.resize(points_.weight.size());
    for (int f = 0; f < secondary_.count(); ++f)
      for (int q = 0; q < (G::curved ? points_.per_facet : 1); ++q)
        tangents_.push_back(G::tangents(secondary_, f, points_.shape[points_.index(f, q)]));
  }
  search_ = PairSearch(request.mesh, layout, secondary_.node, secondary_.X, request.primary,
                       {settings_.search_radius, settings_.local_search}, what_it_meets(settings_));
  std::vector<double> area = layout.make_local();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int q = 0; q < points_.per_facet; ++q) {
      const std::size_t number = points_.index(f, q);
      const auto& spread = G::spread(points_.shape[number]);
      for (std::size_t a = 0; a < width; ++a)
        area[dim * at(secondary_.local[width * at(f) + a])] += points_.weight[number] * spread[a];
    }
  const Handle<Vec> sum = layout.make_global();
  layout.add_to_global(area, sum);
  layout.to_local(sum, area);
  for (int node = 0; node < request.mesh.node_count(); ++node) nodal_area_.push_back(area[dim * at(node)]);
}

template <class G>
std::pair<StateRow, std::size_t> PointForm<G>::constraint_row(const std::string& name, int components) const {
  StateRow row{name, Support::facet_point, components};
  row.surface = settings_.secondary;
  return {row, at(components) * points_.weight.size()};
}

template <class G> void PointForm<G>::locate_holds() {
  const Candidates& list = search_.candidates();
  for (int f = 0; f < secondary_.count(); ++f)
    for (int q = 0; q < points_.per_facet; ++q) {
      Hold& hold = holds_[points_.index(f, q)];
      hold.candidate = -1;
      if (hold.node[0] < 0) continue;
      for (int c : list.of(at(f)))
        if (primary_nodes(c) == hold.node) hold.candidate = c;
    }
}

template <class G> PairSearch::Outcome PointForm<G>::update(Vec u, const ConstraintFilter& presses) {
  views_.at.clear();
  const PairSearch::Outcome outcome = update_pairs(u);
  if (outcome != PairSearch::Outcome::kept) {
    locate_anchors();
    anchored_at_.clear();
    if (!rigid()) locate_holds();
  }
  if (!rigid() && settings_.iterated) tie(nodes().current(u), presses);
  return outcome;
}

template <class G> NodePairs PointForm<G>::couplings() const {
  NodePairs pairs;
  for (int f = 0; f < secondary_.count(); ++f) {
    const std::vector<PetscInt> primary = search_.primary_nodes(f);
    for (PetscInt p : primary)
      for (std::size_t a = 0; a < at(points_.nodes[at(f)]); ++a)
        pairs.emplace_back(secondary_.node[width * at(f) + a], p);
    // Friction couples the facet that a point lay on at the start of the step with the one that it is on now.
    if (!anchors_.empty()) add_pairs_among(primary, pairs);
  }
  sort_unique(pairs);
  return pairs;
}

template <class G> void PointForm<G>::tie(const ContactValues& x, const ConstraintFilter& presses) {
  switched_ = false;
  Surroundings around;
  for (int f = 0; f < secondary_.count(); ++f) {
    const Facet facet = facet_at(f, x, &around);
    for (int q = 0; q < points_.per_facet; ++q) {
      const std::size_t number = points_.index(f, q);
      if (points_.weight[number] == 0) continue;
      const Point& point = points_.shape[number];
      Hold& hold = holds_[number];
      const Seen before = face(facet, point, x, hold);
      Hold next;
      next.switches = hold.switches;
      const auto stays = [&](const Seen& seen, const Seen& near) {
        return G::within(seen, G::hold.overlap) && std::abs(seen.foot.gap - near.foot.gap) <= hold_gap_;
      };
      if (const Seen near = hold.switches.exhausted() ? Seen{} : nearest(facet, point, x);
          near.candidate >= 0 &&
          std::abs(near.foot.gap) <= hold_range * G::size_of(near, secondary_.length[at(f)])) {
        Seen still;
        if (hold.candidate >= 0 && held(facet, point, x, hold, still) && stays(still, near)) {
          next = hold;
        } else if (stays(look(facet, point, near.candidate, x), near)) {
          next.candidate = near.candidate;
          next.node = primary_nodes(near.candidate);
        }
      }
      const Seen after = face(facet, point, x, next);
      const auto pressing = [&](const Seen& seen) {
        return seen.candidate >= 0 && presses(static_cast<int>(number), seen.foot.gap);
      };
      if (pressing(before) || pressing(after)) {
        double turn = 0;
        for (std::size_t k = 0; k < dim; ++k) turn += std::abs(after.foot.normal[k] - before.foot.normal[k]);
        if ((before.candidate >= 0) != (after.candidate >= 0) || turn > 1e-10 ||
            std::abs(after.foot.gap - before.foot.gap) > 1e-9 * hold_gap_) {
          switched_ = true;
          next.switches.note();
        }
      }
      hold = next;
    }
  }
}

// Whether none of its points is wanted, nor was at the least gap that one can have: that of a node less the
// way to the others.
template <class G>
bool PointForm<G>::is_far_off(int facet, const Nodes& node, const RigidObstacle& obstacle,
                              const ConstraintFilter& wanted) const {
  double farthest = 0;
  for (const Place& other : node) {
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) square += (other[k] - node[0][k]) * (other[k] - node[0][k]);
    farthest = std::max(farthest, square);
  }
  const double least = obstacle_.gap(obstacle, in_space(node[0])).value - G::weight_sum * std::sqrt(farthest);
  for (int q = 0; q < points_.per_facet; ++q)
    if (const std::size_t number = points_.index(facet, q);
        points_.weight[number] != 0 && wanted(static_cast<int>(number), least))
      return false;
  return true;
}

template <class G>
template <class Visitor>
void PointForm<G>::visit_points(const ContactValues& u, Visitor&& visitor,
                                const ConstraintFilter& wanted) const {
  const std::vector<double> x = nodes().current(u);
  const RigidObstacle obstacle = obstacle_.at(u);
  Surroundings around;
  const bool keeps = !settings_.iterated && !rigid(), known = keeps && views_.at == x;
  if (keeps && !known) {
    views_.at.clear();
    views_.seen.assign(points_.weight.size(), Seen());
  }
  for (int f = 0; f < secondary_.count(); ++f) {
    if (rigid() && wanted && is_far_off(f, corners_at<Nodes>(secondary_slots(f), x), obstacle, wanted))
      continue;
    const Facet facet = facet_at(f, x, &around, &u);
    double stretch = 0; // of facets that face something
    for (int q = 0; q < points_.per_facet; ++q) {
      const std::size_t number = points_.index(f, q);
      if (points_.weight[number] == 0) continue;
      const Point& point = points_.shape[number];
      const Place here = place_on(facet.node, point);
      Seen seen;
      CarriedFunction to_obstacle;
      if (rigid()) {
        to_obstacle = obstacle_.gap(obstacle, in_space(here));
        if (!G::faces(to_obstacle, normal_at(facet, point))) continue;
        seen.foot.gap = to_obstacle.value;
      } else {
        seen = known ? views_.seen[number] : face(facet, point, x, holds_[number]);
        if (seen.candidate < 0) continue;
        if (!known) sharpen(f, number, u, seen);
        if (keeps && !known) views_.seen[number] = seen;
      }
      if (wanted && !wanted(static_cast<int>(number), seen.foot.gap)) continue;
      if (G::curved || stretch == 0)
        stretch = G::size(facet.node, facet.from, point) / points_.size[own_place(f, number)];
      Constraint c;
      c.index = static_cast<int>(number);
      c.weight = points_.weight[number];
      c.stretch = stretch;
      if (frame_ == Frame::axisymmetric)
        c.stretch *= here[0] / place_on(corners_at<Nodes>(secondary_slots(f), nodes().X), point)[0];
      c.gap = seen.foot.gap;
      c.share = share_of(number, f);
      const auto& spread = G::spread(point);
      c.spread = {spread.data(), c.share.size()};
      visitor(c, facet, seen, to_obstacle);
    }
  }
  if (keeps && !known) views_.at = x;
}

template <class G>
void PointForm<G>::visit(const ContactValues& u, Derivatives derivatives, const ConstraintVisitor& visitor,
                         const ConstraintFilter& wanted) const {
  const bool with_gradient = derivatives != Derivatives::none;
  Workspace w;
  const auto complete = [&](Constraint& c, const Facet& facet, const Seen& seen,
                            const CarriedFunction& to_obstacle) {
    const int f = facet.number;
    NodePlaces& place = w.place;
    place.node.clear();
    const auto add = [&](const int* slot, std::size_t first) {
      for (std::size_t a = 0; a < width; ++a) w.of_facets[first + a] = place(slot[a]);
    };
    add(secondary_slots(f), 0);
    if (seen.candidate >= 0) add(primary_slots(seen.candidate), width);
    for (int slot : obstacle_.slots()) place.node.push_back(slot);
    SlipPlaces places;
    c.slides = slip_places(f, at(c.index), u, places);
    for (std::size_t b = 0; c.slides && !rigid() && b < width; ++b)
      place(anchors_[at(c.index)].opposite.slot[b]);
    if (with_gradient) add_gap_gradient(facet, seen, to_obstacle, w, c);
    if (c.slides) add_slip(f, places, u, with_gradient, w, c);
    c.node = place.node;
    visitor(c);
  };
  visit_points(u, complete, wanted);
}

template <class G>
void PointForm<G>::add_gap_gradient(const Facet& facet, const Seen& seen, const CarriedFunction& to_obstacle,
                                    Workspace& w, Constraint& c) const {
  w.gradient.assign(dim * w.place.node.size(), 0.0);
  if (rigid()) {
    obstacle_.add_gradient(to_obstacle, c.share, obstacle_.shares(), 1, w.gradient.data());
  } else {
    const Row of_facets = gap_gradient(facet, at(c.index), seen);
    for (std::size_t a = 0; a < 2 * width; ++a)
      for (std::size_t k = 0; k < dim; ++k) w.gradient[dim * w.of_facets[a] + k] += of_facets[dim * a + k];
  }
  c.gradient = w.gradient;
}

template <class G>
void PointForm<G>::visit_curvature(const ContactValues& u, const CurvatureFactors& factors,
                                   const BlockVisitor& visitor) const {
  std::vector<int> node;
  std::vector<double> block;
  const auto add = [&](const Constraint& c, const Facet& facet, const Seen& seen,
                       const CarriedFunction& to_obstacle) {
    const int f = facet.number;
    const double of_gap = factors.of_gap(c.index);
    const Tangential of_slip = factors.of_slip(c.index);
    const int* secondary = secondary_slots(f);
    SlipPlaces places;
    const bool slips = of_slip != Tangential{} && slip_places(f, at(c.index), u, places);
    if (rigid() && (of_gap != 0 || slips)) {
      node = with_carrier(f, c.share.size());
      const std::size_t n = dim * node.size();
      block.assign(n * n, 0.0);
      obstacle_.add_hessian(to_obstacle, c.share, obstacle_.shares(), of_gap, block.data());
      for (std::size_t e = 0; slips && on_plane() && e < dim - 1; ++e) {
        Obstacle::PlaneSlip slip;
        double value = 0;
        obstacle_.add_slip(nodes(), f, c.share, obstacle_.tangents()[e], u, value, slip);
        obstacle_.add_hessian(slip.function, c.share, slip.shares, of_slip[e], block.data());
      }
      visitor(node, block);
    } else if (of_gap != 0) {
      Matrix hessian{};
      add_gap_hessian(facet, at(c.index), seen, of_gap, hessian);
      node.assign(secondary, secondary + width);
      node.insert(node.end(), primary_slots(seen.candidate), primary_slots(seen.candidate) + width);
      visitor(node, hessian);
    }
    if (!slips || on_plane()) return;
    const Anchor& anchor = anchors_[at(c.index)];
    std::array<Opening<width>, dim> opening;
    for (std::size_t k = 0; k < dim; ++k) {
      const double factor = of_slip[0] * anchor.lean[0][k] + of_slip[1] * anchor.lean[1][k];
      for (std::size_t b = 0; b < width; ++b) {
        opening[k].D[b] = factor * anchor.opening.D[b];
        opening[k].M[b] = factor * anchor.opening.M[b];
      }
    }
    Matrix hessian{};
    add_slip_hessian(places.s, places.p, tangents(f, at(c.index)), opening, hessian);
    visit_slip_block(f, anchor.opposite, hessian, visitor);
  };
  visit_points(u, add, [&](int index, double) {
    return factors.of_gap(index) != 0 || factors.of_slip(index) != Tangential{};
  });
}

template <class G>
void PointForm<G>::visit_meetings(const ContactValues& u, const MeetingVisitor& visitor) const {
  std::vector<int> node;
  std::vector<double> share;
  visit_points(u, [&](const Constraint& c, const Facet& facet, const Seen& seen, const CarriedFunction&) {
    const int* secondary = secondary_slots(facet.number);
    node.assign(secondary, secondary + c.share.size());
    share.assign(c.share.begin(), c.share.end());
    if (seen.candidate >= 0) {
      const auto opposite = G::shares_of(seen);
      node.insert(node.end(), primary_slots(seen.candidate), primary_slots(seen.candidate) + width);
      share.insert(share.end(), opposite.begin(), opposite.begin() + width);
    }
    Meeting meeting;
    meeting.index = c.index;
    meeting.area = c.weight;
    meeting.secondary = c.share.size();
    meeting.node = node;
    meeting.share = share;
    visitor(meeting);
  });
}

template <class G>
void PointForm<G>::visit_overlaps(const ContactValues& x, const OverlapVisitor& visitor) const {
  Surroundings around;
  for (int f = 0; f < secondary_.count(); ++f) {
    const Facet facet = facet_at(f, x, &around);
    for (std::size_t a = 0; a < at(points_.nodes[at(f)]); ++a) {
      const Place& place = facet.node[a];
      const Point point = G::node(a);
      CarriedFunction gap;
      if (rigid()) {
        gap = obstacle_.gap(obstacle_.reference(), in_space(place));
      } else {
        const Seen seen = nearest(facet, point, x);
        if (seen.candidate < 0) continue;
        gap.value = seen.foot.gap;
        gap.by_place = G::way_out(seen, normal_at(facet, point));
      }
      // Coordinates that were meant to touch differ by rounding of their own size.
      double size = secondary_.length[at(f)];
      for (double component : place) size += std::abs(component);
      if (-gap.value > 1e-9 * size) visitor(secondary_slots(f)[a], -gap.value, gap.by_place);
    }
  }
}

} // namespace impact
