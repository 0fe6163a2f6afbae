#include <cmath>
#include <impact/contact/form.hpp>
#include <impact/contact/vertices.hpp>
#include <impact/math/index.hpp>

namespace impact {

namespace {

using Numbers = std::vector<double>;

// Turns rows over the vertices of a constraint, or of a meeting, into rows over their nodes.
class NodalRows {
public:
  explicit NodalRows(const Vertices& vertices) : vertices_(&vertices) {}

  // The first `secondary` vertices are those of the secondary side, whose nodes come first.
  void take(std::span<const int> vertex, std::size_t secondary) {
    vertex_ = vertex;
    place_of_.node.clear();
    for (std::size_t v = 0; v < vertex.size(); ++v) {
      if (v == secondary) secondary_ = place_of_.node.size();
      vertices_->visit_sum(vertex[v], [&](int node, double) { place_of_(node); });
    }
    if (secondary >= vertex.size()) secondary_ = place_of_.node.size();
  }
  std::span<const int> node() const { return place_of_.node; }

  // [row][vertex][component] to [row][node][component].
  std::span<const double> rows(std::span<const double> of_vertices, std::size_t components,
                               Numbers& of_nodes) {
    const std::size_t width = components * vertex_.size(), wide = components * place_of_.node.size();
    const std::size_t count = width == 0 ? 0 : of_vertices.size() / width;
    of_nodes.assign(count * wide, 0.0);
    for (std::size_t v = 0; v < vertex_.size(); ++v)
      vertices_->visit_sum(vertex_[v], [&](int node, double weight) {
        const std::size_t place = place_of_(node);
        for (std::size_t r = 0; r < count; ++r)
          for (std::size_t k = 0; k < components; ++k)
            of_nodes[wide * r + components * place + k] +=
                weight * of_vertices[width * r + components * v + k];
      });
    return of_nodes;
  }
  // What stands at vertices stands at the nodes with their numbers.
  std::span<const double> moved(std::span<const double> at_vertices, Numbers& at_nodes) {
    at_nodes.assign(secondary_, 0.0);
    for (std::size_t v = 0; v < at_vertices.size(); ++v)
      if (at_vertices[v] != 0) at_nodes[place_of_(vertex_[v])] += at_vertices[v];
    return at_nodes;
  }

private:
  const Vertices* vertices_;
  std::span<const int> vertex_;
  NodePlaces place_of_;
  std::size_t secondary_ = 0;
};

std::size_t components_of(std::size_t numbers, std::size_t vertices) {
  return vertices == 0 ? 0 : numbers / vertices;
}

} // namespace

void Vertices::add(const int* node, std::vector<int>& corners) {
  const FacetParts& cut = cuts_->of(node);
  const std::size_t first = facet_node_.size(), count = sums_.size(), own = at(cut.nodes);
  facet_node_.insert(facet_node_.end(), node, node + own);
  for (std::size_t v = own; v < cut.vertex.size(); ++v) sums_.push_back({&cut.vertex[v], first});
  for (const FacetParts::Part& part : cut.parts)
    for (std::size_t c = 0; c < at(cut.corners); ++c) {
      const std::size_t v = at(part.vertex[c]);
      corners.push_back(v < own ? node[v] : static_cast<int>(nodes_ + count + v - own));
    }
}

const std::vector<double>& Vertices::from(const std::vector<double>& values, std::size_t components,
                                          std::vector<double>& store) const {
  if (empty()) return values;
  store = values;
  store.resize(components * (nodes_ + sums_.size()), 0.0);
  for (std::size_t v = nodes_; v < nodes_ + sums_.size(); ++v)
    visit_sum(static_cast<int>(v), [&](int node, double weight) {
      for (std::size_t k = 0; k < components; ++k)
        store[components * v + k] += weight * values[components * at(node) + k];
    });
  return store;
}

ConstraintVisitor over_nodes(const Vertices& vertices, const ConstraintVisitor& visitor) {
  if (vertices.empty()) return visitor;
  return [nodal = NodalRows(vertices), share = Numbers(), gradient = Numbers(), slips = Numbers(),
          &visitor](Constraint& c) mutable {
    const std::size_t dim = components_of(c.gradient.size(), c.node.size());
    nodal.take(c.node, c.share.size());
    c.share = nodal.moved(c.share, share);
    c.gradient = nodal.rows(c.gradient, dim, gradient);
    c.slip_gradient = nodal.rows(c.slip_gradient, dim, slips);
    c.node = nodal.node();
    visitor(c);
  };
}

MeetingVisitor over_nodes(const Vertices& vertices, const MeetingVisitor& visitor) {
  if (vertices.empty()) return visitor;
  return [nodal = NodalRows(vertices), mine = Numbers(), share = Numbers(), node = std::vector<int>(),
          &visitor](const Meeting& of_vertices) mutable {
    Meeting m = of_vertices;
    // Side by side: a node may come on both.
    node.clear();
    share.clear();
    for (const bool primary : {false, true}) {
      const std::size_t first = primary ? of_vertices.secondary : 0,
                        count = primary ? of_vertices.node.size() - first : of_vertices.secondary;
      nodal.take(of_vertices.node.subspan(first, count), count);
      const std::span<const double> part = nodal.rows(of_vertices.share.subspan(first, count), 1, mine);
      node.insert(node.end(), nodal.node().begin(), nodal.node().end());
      share.insert(share.end(), part.begin(), part.end());
      if (!primary) m.secondary = node.size();
    }
    m.node = node;
    m.share = share;
    visitor(m);
  };
}

BlockVisitor over_nodes(const Vertices& vertices, const BlockVisitor& visitor) {
  if (vertices.empty()) return visitor;
  return [&vertices, &visitor, place_of = NodePlaces(),
          of_nodes = Numbers()](std::span<const int> vertex, std::span<const double> block) mutable {
    struct Term {
      std::size_t place;
      double weight;
    };
    std::vector<std::vector<Term>> sum(vertex.size());
    place_of.node.clear();
    for (std::size_t v = 0; v < vertex.size(); ++v)
      vertices.visit_sum(vertex[v], [&](int node, double weight) {
        sum[v].push_back({place_of(node), weight});
      });
    const auto from = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(block.size()))));
    const std::size_t d = components_of(from, vertex.size()), to = d * place_of.node.size();
    of_nodes.assign(to * to, 0.0);
    for (std::size_t v = 0; v < vertex.size(); ++v)
      for (std::size_t w = 0; w < vertex.size(); ++w)
        for (const Term& row : sum[v])
          for (const Term& column : sum[w])
            for (std::size_t i = 0; i < d; ++i)
              for (std::size_t j = 0; j < d; ++j)
                of_nodes[to * (d * row.place + i) + d * column.place + j] +=
                    row.weight * column.weight * block[from * (d * v + i) + d * w + j];
    visitor(place_of.node, of_nodes);
  };
}

} // namespace impact
