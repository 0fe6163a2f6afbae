#pragma once
#include <array>
#include <impact/contact/form.hpp>
#include <impact/contact/settings.hpp>
#include <impact/kernel/mortar_segment.hpp>
#include <limits>

/// Mortar contact in the plane (theory.md, contact): one constraint per secondary node j,
///   g_j = (1/w_j) sum over its two edges of int Phi_j g dA_0,  w_j = int Phi_j dA_0,
/// integrated exactly over every part that a primary edge covers. The owner of a node evaluates both of its
/// edges, whoever owns their cells, so that a constraint lives on one rank. Which primary edges face a
/// secondary one is fixed by `update`; how far they cover it is followed exactly.
namespace impact {

class MortarForm : public ContactForm {
public:
  /// Settings without automatic values. Throws UserError(data) where more than two edges of the secondary
  /// surface meet. Collective.
  MortarForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings, Frame frame,
             const ContactSurface& secondary, const ContactSurface& primary);

  std::pair<StateRow, std::size_t> multiplier_row(const std::string& name) const override;
  void begin_attempt(double t, Vec u_n) override;
  void anchor(Vec u) override;
  PairSearch::Outcome update(Vec u, const PressureLaw& law) override;
  NodePairs couplings() const override;
  double deepest() const override { return -search_.radius(); }
  void visit(const std::vector<double>& u, Derivatives derivatives, const PressureLaw& law,
             const ConstraintVisitor& visitor) const override;
  const std::vector<double>& nodal_area() const override { return nodal_area_; }
  void visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const override;

private:
  struct Facet {
    std::array<PetscInt, 2> node;
    MortarEdge edge;
  };
  struct Node {
    int local = 0;                       // in the mesh
    std::array<int, 2> facet = {-1, -1}; // before and after the node, -1 at an end of the surface
    double weight = 0;
  };
  // A primary edge that lay opposite an edge of the node at the start of the step.
  struct Anchor {
    int facet = -1;
    std::array<PetscInt, 2> node = {-1, -1}; // global
    std::array<int, 2> slot = {-1, -1};      // in nodes(), -1: not there
    SlipAnchor pair;
  };
  using Facing = std::vector<std::vector<int>>; // [facet]: candidates that face it, ascending

  void locate_anchors();
  void find_facets(const Mesh& mesh, const FieldLayout& layout, const ContactSurface& secondary);
  std::array<Point2<double>, 2> secondary_edge(int facet, const std::vector<double>& x) const;
  std::array<Point2<double>, 2> primary_edge(int candidate, const std::vector<double>& x) const;
  Facing facing_at(const std::vector<double>& x) const;
  // Whether the node is active with these pairs.
  bool active(const Node& node, const std::vector<double>& x, const PressureLaw& law,
              const Facing& facing) const;

  ContactSettings settings_;
  Frame frame_;
  std::vector<Facet> facets_; // of the nodes owned by this rank
  std::vector<Node> owned_;
  std::size_t node_count_ = 0; // of the mesh on this rank
  std::vector<double> nodal_area_;
  Facing facing_;
  std::vector<std::vector<Anchor>> anchors_; // [owned node], empty without friction
  std::vector<int> switches_;                // [facet] in this attempt
};

} // namespace impact
