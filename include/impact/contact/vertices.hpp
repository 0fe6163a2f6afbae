#pragma once
#include <impact/contact/constraint.hpp>
#include <impact/contact/facet_parts.hpp>

/// Vertices of the parts of facets (facet_parts.hpp) among the nodes of a contact: the nodes, under their
/// numbers, then sums over the nodes of their facet. What is a function of vertices is visited as one of
/// nodes.
namespace impact {

class Vertices {
public:
  Vertices() = default;
  /// So many nodes; the cuts must outlive the object.
  Vertices(std::size_t nodes, const FacetCuts& cuts) : nodes_(nodes), cuts_(&cuts) {}

  /// All are nodes.
  bool empty() const { return sums_.empty(); }
  /// A facet by the numbers of its nodes; appends those of the corners of its parts, [part][corner].
  void add(const int* node, std::vector<int>& corners);
  /// Values at the vertices from those at the nodes, [node][component]; a reference to `values` where all
  /// are nodes, else to `store`.
  const std::vector<double>& from(const std::vector<double>& values, std::size_t components,
                                  std::vector<double>& store) const;
  /// call(node, weight) for what a vertex is a sum of.
  template <class Call> void visit_sum(int vertex, Call&& call) const {
    const auto number = static_cast<std::size_t>(vertex);
    if (number < nodes_ || empty()) return call(vertex, 1.0);
    const Sum& sum = sums_[number - nodes_];
    const std::vector<double>& weight = *sum.weight;
    for (std::size_t a = 0; a < weight.size(); ++a)
      if (weight[a] != 0) call(facet_node_[sum.first + a], weight[a]);
  }

private:
  struct Sum {
    const std::vector<double>* weight; // of the cut
    std::size_t first;                 // of the facet in facet_node_
  };
  std::size_t nodes_ = 0;
  const FacetCuts* cuts_ = nullptr;
  std::vector<int> facet_node_; // [facet][node] of facets that were cut
  std::vector<Sum> sums_;
};

/// Visits of what is a function of vertices as visits of what is one of nodes; the visitor itself where all
/// vertices are nodes. `vertices` and `visitor` must outlive what is returned.
ConstraintVisitor over_nodes(const Vertices& vertices, const ConstraintVisitor& visitor);
MeetingVisitor over_nodes(const Vertices& vertices, const MeetingVisitor& visitor);
BlockVisitor over_nodes(const Vertices& vertices, const BlockVisitor& visitor);

} // namespace impact
