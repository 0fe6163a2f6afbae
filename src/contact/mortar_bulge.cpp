#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/contact/surface.hpp>
#include <impact/math/index.hpp>

/// Curved facets (80*): a facet of second order lies before its straight parts, or behind them, by some of
/// h^2/8R, which is more than what bodies that fit into each other overlap by. The gap of a node gets the
/// mean of that difference over its function, of both sides along the normal of the part, as it is when a
/// step begins, and again where a solve has changed it. Facets that are flat at the start leave the straight
/// parts to it, to which uniform pressures are exact.
namespace impact {

namespace {

// Of the tolerance for gaps, by which they may change without another solve.
constexpr double least_change = 0.1;
// Of the size of a facet, to which one is flat with its middles in the middle of sides.
constexpr double flat = 1e-9;

// Places in a piece and weights of sum 1, exact to degree four at least.
TriangleRule rule_of(int dim) {
  if (dim == 3) return triangle_rule(3);
  TriangleRule rule;
  const GaussRule line = gauss_rule(3);
  for (std::size_t i = 0; i < line.xi.size(); ++i) {
    rule.part.push_back({(1 - line.xi[i]) / 2, (1 + line.xi[i]) / 2, 0});
    rule.weight.push_back(line.weight[i] / 2);
  }
  return rule;
}

// sum_v part[v] w[v]
std::array<double, 4> mean(const std::array<double, 3>& part, const TriangleWeights& w) {
  std::array<double, 4> sum{};
  for (std::size_t v = 0; v < 3; ++v)
    for (std::size_t a = 0; a < 4; ++a) sum[a] += part[v] * w[v][a];
  return sum;
}

} // namespace

void MortarForm::add_bulge(int f, int candidate, const ContactValues& x, std::array<double, 4>& sum) const {
  static const std::array<TriangleRule, 2> rules = {rule_of(2), rule_of(3)};
  const TriangleRule& rule = rules[at(dim_ - 2)];
  const std::size_t width = at(cuts_.width()), d = at(dim_);
  const int *mine = &nodes().secondary[width * at(f / parts_)],
            *other = &nodes().primary[width * at(primary_facet(candidate))];
  const FacetParts &own = cut_of(f), &primary = cuts_.of(primary_nodes(candidate).data());
  const FacetParts::Part &here = part_of(f), &there = primary.parts[at(candidate % parts_)];
  const double least = flat * size_of(f, x);
  const auto sum_of = [&](const std::array<double, 9>& weight, const int* slot, const ContactValues& places) {
    Point3 s{};
    for (std::size_t a = 0; a < width; ++a)
      for (std::size_t k = 0; k < d && weight[a] != 0; ++k) s[k] += weight[a] * places[d * at(slot[a]) + k];
    return s;
  };
  const auto add = [&](const CoveredPiece& piece) {
    const auto along = [&](const std::array<double, 9>& weight, const int* slot) {
      const Point3 at_start = sum_of(weight, slot, nodes().X);
      return dot(at_start, at_start) > least * least ? dot(sum_of(weight, slot, x), piece.normal) : 0;
    };
    for (std::size_t q = 0; q < rule.part.size(); ++q) {
      const std::array<double, 3>& part = rule.part[q];
      const std::array<double, 4> phi = mean(part, piece.phi);
      const double ring = part[0] * piece.ring[0] + part[1] * piece.ring[1] + part[2] * piece.ring[2],
                   gap = along(primary.bulge(there, mean(part, piece.primary)), other) -
                         along(own.bulge(here, mean(part, piece.secondary)), mine);
      for (std::size_t a = 0; a < 4; ++a) sum[a] += rule.weight[q] * piece.area * ring * phi[a] * gap;
    }
  };
  at_pair(f, candidate, x, [&](const auto& s, const auto& p) {
    visit_covered(s, p, facets_[at(f)].reference(s), add);
    return true;
  });
}

void MortarForm::bulge(const ContactValues& u, const ContactValues& x, const ConstraintFilter& presses) {
  if (parts_ == 1) return;
  std::vector<std::array<double, 4>> sums(facets_.size());
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    if (*std::max_element(facets_[f].owned.begin(), facets_[f].owned.end()) < 0) continue;
    for (const int candidate : facing_[f]) add_bulge(static_cast<int>(f), candidate, x, sums[f]);
  }
  for (Node& node : owned_) {
    double now = 0;
    for (const Incident& incident : node.facets) now += sums[at(incident.facet)][at(incident.corner)];
    now /= node.weight;
    if (!node.bulged) {
      node.bulges = {};
    } else {
      // Forces are those of the last solve, and a change asks for another one.
      if (node.bulges.exhausted() || std::abs(now - node.bulge) <= least_change * settings_.gap_tol ||
          !active(node, u, presses, facing_))
        continue;
      node.bulges.note();
      switched_ = true;
    }
    node.bulge = now;
    node.bulged = true;
  }
}

} // namespace impact
