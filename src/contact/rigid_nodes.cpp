#include <impact/contact/rigid_nodes.hpp>

namespace impact {

void RigidNodes::set(const FieldLayout& layout, const RigidReduction& reduction,
                     const std::vector<int>& body) {
  reduction_ = &reduction;
  body_ = layout.make_global();
  std::vector<double> numbers = layout.make_local();
  const auto dim = static_cast<std::size_t>(reduction.dim());
  for (std::size_t node = 0; node < body.size(); ++node) numbers[dim * node] = body[node] + 1;
  layout.to_global(numbers, body_);
}

void RigidNodes::fetch(const ContactNodes& nodes) {
  body_here_.clear();
  if (!body_) return;
  const std::vector<double> numbers = nodes.exchange.gather(body_);
  for (std::size_t i = 0; i < numbers.size(); i += static_cast<std::size_t>(nodes.dim))
    body_here_.push_back(static_cast<int>(numbers[i] + 0.5) - 1);
}

NodePairs RigidNodes::reduced(const NodePairs& pairs, const ContactNodes& nodes) const {
  if (empty()) return pairs;
  // The unknowns of a body stand at two of its nodes.
  const auto places = [&](PetscInt node, std::array<PetscInt, 2>& place) -> std::size_t {
    const int slot = nodes.slot(node), of = slot < 0 ? -1 : body(slot);
    place = of < 0 ? std::array<PetscInt, 2>{node, node}
                   : reduction_->bodies()[static_cast<std::size_t>(of)].slot;
    return of < 0 ? 1 : 2;
  };
  NodePairs reduced;
  for (const auto& [i, j] : pairs) {
    std::array<PetscInt, 2> a{}, b{};
    const std::size_t of_a = places(i, a), of_b = places(j, b);
    for (std::size_t p = 0; p < of_a; ++p)
      for (std::size_t q = 0; q < of_b; ++q)
        if (a[p] != b[q]) reduced.emplace_back(std::min(a[p], b[q]), std::max(a[p], b[q]));
  }
  sort_unique(reduced);
  return reduced;
}

} // namespace impact
