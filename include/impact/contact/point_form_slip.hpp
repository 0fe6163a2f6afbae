#pragma once
#include <algorithm>
#include <impact/contact/point_form.hpp>

/// How the points of PointForm slip along what they lay opposite of at the start of the step; included by
/// point_form_impl.hpp.
namespace impact {

template <class G> void PointForm<G>::anchor(Vec u) {
  search_.set_start(u);
  if (frictional()) anchor_slip(u); // all ranks agree on that, not on whether they have points
  views_.at.clear();                // what a point came through is seen by the start of the step
}

template <class G> void PointForm<G>::anchor_slip(Vec u) {
  if (rigid()) obstacle_.anchor(nodes(), nodes().start);
  if (on_plane()) return;
  // The next step starts where the last one ended.
  std::vector<double> moved = nodes().displacement(u);
  if (search_.restored() || anchored_at_ != moved) find_anchors(moved);
  anchored_at_ = std::move(moved);
}

template <class G>
template <class Call>
void PointForm<G>::for_each_anchor(const ContactValues& x, const ContactValues& u, Call&& call) {
  Surroundings around;
  for (int f = 0; f < secondary_.count(); ++f) {
    const Facet facet = facet_at(f, x, &around, &u);
    for (int q = 0; q < points_.per_facet; ++q)
      if (const std::size_t number = points_.index(f, q); points_.weight[number] != 0)
        call(facet, number, anchors_[number]);
  }
}

template <class G> void PointForm<G>::find_anchors(const ContactValues& moved) {
  const ContactValues& x = nodes().start;
  const RigidObstacle obstacle = obstacle_.at(moved);
  const bool known = !settings_.exposed && views_.at == x; // others see as deep as before
  anchoring_ = true;
  for_each_anchor(x, moved, [&](const Facet& facet, std::size_t number, Anchor& anchor) {
    anchor = Anchor{.lean = anchor.lean};
    // Opposite a round rigid body is the place of the facet itself: no matter where on the body that is.
    Seen seen;
    if (known) seen = views_.seen[number];
    // What came through a surface within the last step is as deep in the next one, which starts there.
    if (!rigid() && (!known || (seen.candidate >= 0 && seen.foot.gap <= -depth(facet.number))))
      seen = nearest(facet, points_.shape[number], x);
    anchor.valid = rigid() || seen.candidate >= 0;
    if (!anchor.valid) return;
    if (!known && !rigid() && !settings_.iterated) sharpen(facet.number, number, moved, seen); // as visits do
    const auto share = [](const auto& weights, std::array<double, width>& out) {
      std::copy_n(weights.begin(), width, out.begin());
    };
    share(G::weights(points_.shape[number]), anchor.opening.D);
    if (rigid()) {
      anchor.opening.M = anchor.opening.D;
      if (leans_at_anchor()) anchor.lean = lean_on(facet, number, obstacle);
      return;
    }
    share(G::shares_of(seen), anchor.opening.M);
    anchor.opposite.node = primary_nodes(seen.candidate);
    const int* other = primary_slots(seen.candidate);
    anchor.opposite.stand({other, width});
    const Nodes p = corners_from<Nodes>(secondary_slots(facet.number)[0], other, moved);
    const SlipDirections<dim, width> directions(facet.from, tangents(facet.number, number), false);
    anchor.start = directions.opened(p, anchor.opening);
    if (leans_at_anchor())
      anchor.lean = lean_to<dim>(directions.components(seen.foot.normal), G::force_of(seen));
  });
  anchoring_ = false;
}

template <class G> void PointForm<G>::locate_anchors() {
  for (Anchor& anchor : anchors_) anchor.opposite.locate(nodes());
}

template <class G>
Lean PointForm<G>::lean_on(const Facet& facet, std::size_t number, const RigidObstacle& obstacle) const {
  const CarriedFunction gap = obstacle_.gap(obstacle, in_space(place_on(facet.node, points_.shape[number])));
  Place n;
  std::copy_n(gap.by_place.begin(), dim, n.begin());
  const SlipDirections<dim, width> directions(facet.node, tangents(facet.number, number), false);
  return lean_to<dim>(directions.components(n), 1);
}

// Fixed within a Newton solve, as its tangent takes them.
template <class G> void PointForm<G>::turn_slip(const ContactValues& u) {
  if (anchors_.empty() || on_plane() || !leans()) return;
  const ContactValues x = nodes().current(u);
  const RigidObstacle obstacle = obstacle_.at(u);
  for_each_anchor(x, u, [&](const Facet& facet, std::size_t number, Anchor& anchor) {
    if (!anchor.valid) return;
    if (rigid()) {
      anchor.lean = lean_on(facet, number, obstacle);
      return;
    }
    const Seen seen = face(facet, points_.shape[number], x, holds_[number]);
    const SlipDirections<dim, width> directions(facet.node, tangents(facet.number, number), false);
    anchor.lean = seen.candidate < 0
                      ? upright<dim>()
                      : lean_to<dim>(directions.components(seen.foot.normal), G::force_of(seen));
  });
}

// False without friction or where nothing lay opposite. A plane has directions of its own and needs no
// places.
template <class G>
bool PointForm<G>::slip_places(int facet, std::size_t number, const ContactValues& u,
                               SlipPlaces& places) const {
  if (anchors_.empty() || nodes().start.empty()) return false;
  if (on_plane()) return true;
  const Anchor& anchor = anchors_[number];
  if (!anchor.valid) return false;
  if (!rigid() && !anchor.opposite.found()) return false;
  const int* slot = secondary_slots(facet);
  places.s = corners_from<Nodes>(slot[0], slot, u);
  places.p = opposite<Nodes>(anchor.opposite, facet, u);
  return true;
}

template <class G>
void PointForm<G>::add_slip(int facet, const SlipPlaces& places, const ContactValues& u, bool with_gradient,
                            Workspace& w, Constraint& c) const {
  const std::size_t n = dim * w.place.node.size();
  w.slip_gradient.assign((dim - 1) * n, 0.0);
  c.slip_gradient = w.slip_gradient;
  for (std::size_t e = 0; on_plane() && e < dim - 1; ++e) {
    Obstacle::PlaneSlip slip;
    obstacle_.add_slip(nodes(), facet, c.share, obstacle_.tangents()[e], u, c.slip[e], slip);
    obstacle_.add_gradient(slip.function, c.share, slip.shares, 1, &w.slip_gradient[n * e]);
  }
  if (!on_plane()) add_facet_slip(facet, places, with_gradient, w, c);
}

template <class G>
void PointForm<G>::add_facet_slip(int facet, const SlipPlaces& places, bool with_gradient, Workspace& w,
                                  Constraint& c) const {
  const std::size_t n = dim * w.place.node.size(), half = dim * width;
  const Anchor& anchor = anchors_[at(c.index)];
  if (const auto* const own = &tangents(facet, at(c.index)); w.tangents != own) {
    w.tangents = own;
    w.secondary = places.s;
    w.directions.emplace(w.secondary, *own, with_gradient);
  }
  const FacetSlip<dim, width> slip = w.directions->slip(places.p, anchor.opening, anchor.lean);
  for (std::size_t e = 0; e < dim - 1; ++e) {
    c.slip[e] = slip.value[e];
    for (std::size_t k = 0; k < dim; ++k) c.slip[e] -= anchor.lean[e][k] * anchor.start[k];
  }
  for (std::size_t e = 0; with_gradient && e < dim - 1; ++e) {
    const auto add = [&](std::size_t node, const double* value) {
      const std::size_t place = n * e + dim * node;
      for (std::size_t k = 0; k < dim; ++k) w.slip_gradient[place + k] += value[k];
    };
    const Row& row = slip.gradient[e];
    for (std::size_t a = 0; a < width; ++a) add(w.of_facets[a], &row[dim * a]);
    for (std::size_t b = 0; !rigid() && b < width; ++b)
      add(w.place(anchor.opposite.slot[b]), &row[half + dim * b]);
    std::array<double, dim*(dim + 1)> by_carrier;
    obstacle_.chain(facet, &row[half], by_carrier.data());
    for (std::size_t b = 0; b < obstacle_.slots().size(); ++b)
      add(w.place(obstacle_.slots()[b]), &by_carrier[dim * b]);
  }
}

} // namespace impact
