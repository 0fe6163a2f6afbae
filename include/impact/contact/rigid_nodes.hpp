#pragma once
#include <impact/contact/pair_search.hpp>
#include <impact/mesh/rigid_reduction.hpp>

/// Which nodes of a contact belong to rigid bodies, whose part of the tangent goes to the unknowns of their
/// bodies.
namespace impact {

class RigidNodes {
public:
  bool empty() const { return body_here_.empty(); }
  /// [local node] a body of `reduction`, which is kept, or -1. Collective.
  void set(const FieldLayout& layout, const RigidReduction& reduction, const std::vector<int>& body);
  /// The contact has other nodes. Collective.
  void fetch(const ContactNodes& nodes);
  /// Pairs of nodes become pairs of the nodes at which the unknowns stand.
  NodePairs reduced(const NodePairs& pairs, const ContactNodes& nodes) const;
  const RigidReduction& reduction() const { return *reduction_; }
  int body(int node) const { return body_here_[static_cast<std::size_t>(node)]; }

private:
  const RigidReduction* reduction_ = nullptr;
  Handle<Vec> body_;           // 1 + rigid body of a node, in its first component; absent: none
  std::vector<int> body_here_; // [node] of the contact, -1: none; empty without rigid bodies
};

} // namespace impact
