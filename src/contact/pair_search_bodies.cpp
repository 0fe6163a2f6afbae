#include <impact/contact/pair_search.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/ranks.hpp>

/// Pairs of a PairSearch whose facets belong to one body: which of them may touch (self_contact.hpp).
namespace impact {

namespace {

// What lies deeper behind a facet of a surface that may meet itself, in units of the facet, is another part
// of a body, unless it came there within the step.
constexpr double self_depth = 0.5;

} // namespace

bool PairSearch::find_shapes(const SearchSecondary& secondary, const std::vector<SearchFacet>& primary) {
  const Bodies bodies = find_bodies(*mesh_);
  std::vector<double> number = layout_->make_local();
  for (std::size_t i = 0; i < bodies.of_node.size(); ++i) number[at(dim_) * i] = bodies.of_node[i];
  Handle<Vec> of_node = layout_->make_global();
  layout_->to_global(number, of_node);
  const std::vector<double> body = static_.gather(of_node);
  std::vector<int> has(at(2 * bodies.count), 0); // [body][side]
  const auto body_at = [&](int slot, int side) {
    const auto b = static_cast<int>(body[at(dim_ * slot)]);
    has[at(2 * b + side)] = 1;
    return b;
  };
  for (std::size_t f = 0; f < primary.size(); ++f) body_at(primary_slot_[at(per_facet_) * f], 1);
  for (std::size_t f = 0; f < secondary.node.size() / 4; ++f) {
    const int* slot = &secondary_slot_[at(per_facet_) * f];
    shapes_.push_back(facet_shape(dim_, in_space(slot, static_X_), body_at(*slot, 0)));
  }
  max_over_ranks(mesh_->comm(), has);
  bool both = false;
  for (std::size_t b = 0; b < has.size(); b += 2) both = both || (has[b] != 0 && has[b + 1] != 0);
  if (both)
    body_ = std::move(of_node);
  else
    shapes_.clear();
  return both;
}

void PairSearch::prepare_self_contact(const SearchSecondary& secondary,
                                      const std::vector<SearchFacet>& primary) {
  std::vector<FacetShape> own;
  for (const SearchFacet& facet : primary) own.push_back(facet_shape(dim_, facet.x, 0));
  self_ = SelfContact(mesh_->comm(), dim_, own);
  // The body's other side, as far as it can matter.
  list_.candidates = find_candidates(mesh_->comm(), secondary, primary, 2 * radius_);
  fetch_nodes();
  const std::vector<double> node_body = list_.nodes.exchange.gather(body_);
  for (std::size_t f = 0; f < shapes_.size(); ++f) {
    depth_.push_back(self_depth * shapes_[f].size);
    for (int c : list_.candidates.of(f)) {
      const int* slot = &list_.nodes.primary[at(per_facet_ * list_.candidates.facet[at(c)])];
      const FacetShape other =
          facet_shape(dim_, in_space(slot, list_.nodes.X), static_cast<int>(node_body[at(dim_ * *slot)]));
      depth_[f] = std::min(depth_[f], SelfContact::thickness(shapes_[f], other));
    }
  }
}

void PairSearch::drop_neighbours(Vec u) {
  // Facets of one body whose normals enclose less than 60 degrees must turn by as much as that before they
  // can oppose each other, which moves their nodes by a large part of the skin.
  constexpr double alike = 0.5;
  const std::vector<double> body = list_.nodes.exchange.gather(body_), now = list_.nodes.current(u);
  const auto primaries = static_cast<int>(list_.candidates.primary.size());
  std::vector<FacetShape> reference, current;
  for (int p = 0; p < primaries; ++p) {
    const int* slot = &list_.nodes.primary[at(per_facet_ * p)];
    reference.push_back(
        facet_shape(dim_, in_space(slot, list_.nodes.X), static_cast<int>(body[at(dim_ * *slot)])));
    current.push_back(facet_shape(dim_, in_space(slot, now), 0));
  }
  Candidates kept;
  kept.offset.push_back(0);
  list_.counts.clear();
  for (std::size_t f = 0; f < shapes_.size(); ++f) {
    const std::array<double, 3> n =
        facet_shape(dim_, in_space(&list_.nodes.secondary[at(per_facet_) * f], now), 0).normal;
    for (int c : list_.candidates.of(f)) {
      const int p = list_.candidates.facet[at(c)];
      const FacetShape& other = reference[at(p)];
      const std::array<double, 3>& m = current[at(p)].normal;
      const bool turned = n[0] * m[0] + n[1] * m[1] + n[2] * m[2] > alike;
      if ((turned && other.body == shapes_[f].body) ||
          !SelfContact::may_touch(shapes_[f], other, 2 * radius_))
        continue;
      kept.facet.push_back(p);
      if (kind_ == Primary::itself) list_.counts.push_back(self_.is_secondary(shapes_[f], other) ? 1 : 0);
    }
    kept.offset.push_back(static_cast<int>(kept.facet.size()));
  }
  // The numbers of the primaries, and the nodes that were fetched for them, stay.
  kept.primary = std::move(list_.candidates.primary);
  list_.candidates = std::move(kept);
}

} // namespace impact
