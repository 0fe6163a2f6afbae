#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <numbers>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Edges face each other when their normals enclose more than this angle's complement (cos < -0.17: 100
// degrees),
constexpr double least_opposition = 0.17;
// and when the primary is not farther away than this part of the secondary edge: a step behind the surface
// must not count as an open gap beside the closed one.
constexpr double farthest = 0.5;
// A facet whose pairs change more often within an attempt keeps those that it has.
constexpr int switch_limit = 4;
// Least covered part of a weight that the linear solves make up for.
constexpr double least_cover = 1e-3;

Point2<double> point_at(const std::vector<double>& x, int node) {
  return {x[at(2 * node)], x[at(2 * node + 1)]};
}

double length_of(const std::array<Point2<double>, 2>& edge) {
  return std::hypot(edge[1][0] - edge[0][0], edge[1][1] - edge[0][1]);
}

} // namespace

MortarForm::MortarForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings,
                       Frame frame, const ContactSurface& secondary, const ContactSurface& primary)
    : settings_(settings), frame_(frame), node_count_(at(mesh.node_count())) {
  find_facets(mesh, layout, secondary);
  std::vector<PetscInt> nodes;
  for (const Facet& facet : facets_) nodes.insert(nodes.end(), facet.node.begin(), facet.node.end());
  std::vector<PetscInt> wanted = nodes;
  sort_unique(wanted);
  const Handle<Vec> coordinates = layout.make_global();
  layout.to_global(std::vector<double>(mesh.coordinates().begin(), mesh.coordinates().end()), coordinates);
  const std::vector<double> all =
      NodeExchange(mesh.comm(), mesh.owned_node_count(), 2, wanted).gather(coordinates);
  std::vector<double> X;
  for (PetscInt node : nodes) {
    const auto place = std::lower_bound(wanted.begin(), wanted.end(), node) - wanted.begin();
    X.insert(X.end(), all.begin() + 2 * place, all.begin() + 2 * place + 2);
  }
  for (std::size_t f = 0; f < facets_.size(); ++f) {
    MortarEdge& edge = facets_[f].edge;
    edge.length = std::hypot(X[4 * f + 2] - X[4 * f], X[4 * f + 3] - X[4 * f + 1]);
    if (frame == Frame::axisymmetric)
      edge.ring = {2 * std::numbers::pi * X[4 * f], 2 * std::numbers::pi * X[4 * f + 2]};
    if (settings.multipliers == MultiplierSpace::dual) edge.phi = dual_functions(edge);
  }
  std::vector<double> area = layout.make_local();
  for (Node& node : owned_) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (node.facet[side] < 0) continue;
      // The node is the second one of the edge before it. Both kinds of functions have the integral of N.
      const MortarEdge& edge = facets_[at(node.facet[side])].edge;
      const std::size_t a = 1 - side;
      node.weight += edge.length * (2 * edge.ring[a] + edge.ring[1 - a]) / 6;
    }
    area[at(2 * node.local)] = node.weight;
  }
  const Handle<Vec> owned_area = layout.make_global();
  layout.to_global(area, owned_area);
  layout.to_local(owned_area, area);
  for (std::size_t node = 0; node < node_count_; ++node) nodal_area_.push_back(area[2 * node]);
  search_ = PairSearch(mesh, layout, nodes, X, primary, settings.search_radius, true);
  facing_.resize(facets_.size());
  switches_.assign(facets_.size(), 0);
}

void MortarForm::find_facets(const Mesh& mesh, const FieldLayout& layout, const ContactSurface& secondary) {
  // Each edge leaves its far node at both of its nodes, as a sum with a count beside it; node numbers are
  // exact in a double.
  const Handle<Vec> sum = layout.make_global(), count = layout.make_global();
  std::vector<double> far = layout.make_local(), edges = layout.make_local();
  for (int f = 0; f < secondary.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const std::size_t slot = at(2 * secondary.local[at(2 * f + a)] + 1 - a); // 0: edge before the node
      far[slot] += static_cast<double>(secondary.node[at(2 * f + 1 - a)]);
      edges[slot] += 1;
    }
  layout.add_to_global(far, sum);
  layout.add_to_global(edges, count);
  layout.to_local(sum, far);
  layout.to_local(count, edges);
  bool branches = false;
  std::map<std::array<PetscInt, 2>, int> number;
  for (int local = 0; local < mesh.node_count(); ++local) {
    const double before = edges[at(2 * local)], after = edges[at(2 * local + 1)];
    branches = branches || before > 1 || after > 1;
    if (!mesh.owned(local) || before + after == 0) continue;
    Node node;
    node.local = local;
    const PetscInt mine = mesh.global_node()[at(local)];
    for (std::size_t side = 0; side < 2; ++side) {
      const std::size_t slot = at(2 * local) + side;
      if (edges[slot] != 1) continue;
      const auto other = static_cast<PetscInt>(far[slot]);
      const std::array<PetscInt, 2> ends =
          side == 0 ? std::array<PetscInt, 2>{other, mine} : std::array<PetscInt, 2>{mine, other};
      const auto [place, is_new] = number.try_emplace(ends, static_cast<int>(facets_.size()));
      if (is_new) facets_.push_back({ends, {}});
      node.facet[side] = place->second;
    }
    owned_.push_back(node);
  }
  if (!all_ranks_agree(mesh.comm(), !branches))
    throw UserError(ExitCode::data,
                    "contact " + settings_.id + ": more than two edges of `" + settings_.secondary +
                        "` meet in a node; name a surface without branches, or use -contact_" + settings_.id +
                        "_method gpts");
}

std::pair<StateRow, std::size_t> MortarForm::multiplier_row(const std::string& name) const {
  return {StateRow{name, Support::vertex, 1}, node_count_};
}

void MortarForm::begin_attempt(double, Vec u_n) {
  std::fill(switches_.begin(), switches_.end(), 0);
  switched_ = false;
  if (u_n) anchor(u_n);
}

void MortarForm::anchor(Vec u) {
  search_.set_start(u);
  if (!(settings_.friction > 0)) return;
  const std::vector<double>& x = nodes().start;
  const Facing facing = facing_at(x);
  anchors_.assign(owned_.size(), {});
  for (std::size_t i = 0; i < owned_.size(); ++i)
    for (std::size_t side = 0; side < 2; ++side) {
      const int f = owned_[i].facet[side];
      if (f < 0) continue;
      const std::size_t a = 1 - side;
      for (int c : facing[at(f)]) {
        const auto edge = secondary_edge(f, x), primary = primary_edge(c, x);
        const CoveredPart<double> part = covered_part(edge, primary);
        if (!(part.end > part.begin)) continue;
        const MortarWeights w = mortar_weights(edge, primary, facets_[at(f)].edge);
        Anchor anchor;
        anchor.facet = f;
        anchor.node = search_.candidates().primary[at(search_.candidates().facet[at(c)])].node;
        for (std::size_t b = 0; b < 2; ++b) {
          anchor.pair.c[b] = w.D[a][b] / owned_[i].weight;
          anchor.pair.m[b] = w.M[a][b] / owned_[i].weight;
        }
        anchors_[i].push_back(anchor);
      }
    }
  locate_anchors();
}

void MortarForm::locate_anchors() {
  for (std::vector<Anchor>& anchors : anchors_)
    for (Anchor& anchor : anchors)
      for (std::size_t b = 0; b < 2; ++b) anchor.slot[b] = nodes().slot(anchor.node[b]);
}

std::array<Point2<double>, 2> MortarForm::secondary_edge(int facet, const std::vector<double>& x) const {
  const int* node = &nodes().secondary[at(2 * facet)];
  return {point_at(x, node[0]), point_at(x, node[1])};
}

std::array<Point2<double>, 2> MortarForm::primary_edge(int candidate, const std::vector<double>& x) const {
  const int* node = &nodes().primary[at(4 * search_.candidates().facet[at(candidate)])];
  return {point_at(x, node[0]), point_at(x, node[1])};
}

MortarForm::Facing MortarForm::facing_at(const std::vector<double>& x) const {
  Facing facing(facets_.size());
  const Candidates& list = search_.candidates();
  struct Pair {
    int candidate;
    double begin, end, distance;
  };
  std::vector<Pair> pairs;
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const auto edge = secondary_edge(f, x);
    const Point2<double> n = detail::right_normal(edge[0], edge[1]);
    const double length = length_of(edge);
    pairs.clear();
    for (int c = list.offset[at(f)]; c < list.offset[at(f + 1)]; ++c) {
      const auto primary = primary_edge(c, x);
      if (!(detail::dot(n, detail::right_normal(primary[0], primary[1])) < -least_opposition)) continue;
      const CoveredPart<double> part = covered_part(edge, primary);
      // Judged by the part that is covered, or by the nearest end where none is.
      const bool covered = part.end > part.begin;
      const double nearest = covered         ? std::min(part.gap_begin, part.gap_end)
                             : part.end < -1 ? part.gap_end
                                             : part.gap_begin;
      const double deepest = covered ? std::max(part.gap_begin, part.gap_end) : nearest;
      if (!(nearest < farthest * length) || !(deepest > -search_.radius())) continue;
      pairs.push_back({c, part.begin, part.end, std::abs(part.gap_begin + part.gap_end) / 2});
    }
    // Of two layers over the same part the nearer one counts.
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
      return a.distance != b.distance ? a.distance < b.distance : a.candidate < b.candidate;
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const Pair& pair = pairs[i];
      const bool hidden =
          std::any_of(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(i), [&](const Pair& o) {
            const double common = std::min(pair.end, o.end) - std::max(pair.begin, o.begin);
            return common > 1e-6 &&
                   std::find(facing[at(f)].begin(), facing[at(f)].end(), o.candidate) != facing[at(f)].end();
          });
      if (!hidden) facing[at(f)].push_back(pair.candidate);
    }
    std::sort(facing[at(f)].begin(), facing[at(f)].end());
  }
  return facing;
}

PairSearch::Outcome MortarForm::update(Vec u, const PressureLaw& law) {
  const PairSearch::Outcome outcome = search_.update(u);
  const std::vector<double> x = nodes().current(u);
  switched_ = false;
  Facing next = facing_at(x);
  if (outcome != PairSearch::Outcome::kept) {
    locate_anchors();
    // Candidates have other numbers now: what faced is forgotten, and the caller solves again anyway.
    facing_ = std::move(next);
    return outcome;
  }
  for (std::size_t f = 0; f < facets_.size(); ++f)
    if (switches_[f] >= switch_limit) next[f] = facing_[f];
  for (const Node& node : owned_) {
    const bool changed = std::any_of(node.facet.begin(), node.facet.end(),
                                     [&](int f) { return f >= 0 && next[at(f)] != facing_[at(f)]; });
    if (!changed || !(active(node, x, law, facing_) || active(node, x, law, next))) continue;
    // Only pairs that cover something now make a difference.
    const auto covering = [&](int f, const Facing& facing) {
      std::vector<int> list;
      for (int c : facing[at(f)]) {
        const auto part = covered_part(secondary_edge(f, x), primary_edge(c, x));
        if (part.end > part.begin + 1e-12) list.push_back(c);
      }
      return list;
    };
    for (int f : node.facet)
      if (f >= 0 && covering(f, next) != covering(f, facing_)) {
        switched_ = true;
        ++switches_[at(f)];
      }
  }
  facing_ = std::move(next);
  return outcome;
}

bool MortarForm::active(const Node& node, const std::vector<double>& x, const PressureLaw& law,
                        const Facing& facing) const {
  double gap = 0;
  bool covered = false;
  for (std::size_t side = 0; side < 2; ++side) {
    const int f = node.facet[side];
    if (f < 0) continue;
    for (int c : facing[at(f)]) {
      const auto part = covered_part(secondary_edge(f, x), primary_edge(c, x));
      if (!(part.end > part.begin)) continue;
      covered = true;
      gap += weighted_gaps(part, facets_[at(f)].edge)[1 - side];
    }
  }
  return covered && law.active(node.local, gap / node.weight);
}

NodePairs MortarForm::couplings() const {
  NodePairs pairs;
  for (const Node& node : owned_) {
    std::vector<PetscInt> together;
    for (int f : node.facet) {
      if (f < 0) continue;
      const std::vector<PetscInt> primary = search_.primary_nodes(f);
      together.insert(together.end(), facets_[at(f)].node.begin(), facets_[at(f)].node.end());
      together.insert(together.end(), primary.begin(), primary.end());
    }
    add_pairs_among(std::move(together), pairs);
  }
  sort_unique(pairs);
  return pairs;
}

void MortarForm::visit(const std::vector<double>& u, Derivatives derivatives, const PressureLaw& law,
                       const ConstraintVisitor& visitor) const {
  // Both edges as seen from the first node of the secondary one.
  const auto edge_at = [&](int facet, int first, int second) {
    const int origin = nodes().secondary[2 * at(facet)];
    return std::array<Point2<double>, 2>{nodes().place(first, origin, u), nodes().place(second, origin, u)};
  };
  const auto secondary_at = [&](int facet) {
    return edge_at(facet, nodes().secondary[2 * at(facet)], nodes().secondary[2 * at(facet) + 1]);
  };
  const auto primary_at = [&](int facet, int candidate) {
    const int* on_primary = &nodes().primary[at(4 * search_.candidates().facet[at(candidate)])];
    return edge_at(facet, on_primary[0], on_primary[1]);
  };
  const auto radius = [&](int n) { return nodes().X[2 * at(n)] + u[2 * at(n)]; };
  std::vector<int> node;
  std::vector<double> share, gradient, hessian, slip_gradient, slip_hessian;
  // A pair's four nodes by their place in `node`.
  struct Piece {
    std::size_t side;
    int facet, candidate;
    std::array<std::size_t, 4> place;
  };
  std::vector<Piece> pieces;
  const auto place_of = [&](int n) {
    const auto found = std::find(node.begin(), node.end(), n);
    if (found == node.end()) {
      node.push_back(n);
      return node.size() - 1;
    }
    return static_cast<std::size_t>(found - node.begin());
  };
  for (std::size_t number = 0; number < owned_.size(); ++number) {
    const Node& owner = owned_[number];
    node.clear();
    pieces.clear();
    Constraint c;
    c.index = owner.local;
    c.weight = owner.weight;
    double covered = 0, area = 0;
    // Secondary nodes first.
    for (std::size_t side = 0; side < 2; ++side)
      if (const int f = owner.facet[side]; f >= 0)
        for (std::size_t a = 0; a < 2; ++a) place_of(nodes().secondary[2 * at(f) + a]);
    const std::size_t secondary = node.size();
    share.assign(secondary, 0.0);
    gradient.assign(2 * node.size(), 0.0);
    for (std::size_t side = 0; side < 2; ++side) {
      const int f = owner.facet[side];
      if (f < 0) continue;
      const MortarEdge& edge = facets_[at(f)].edge;
      const std::size_t a = 1 - side;
      const auto s = secondary_at(f);
      share[place_of(nodes().secondary[2 * at(f) + a])] = 1;
      const std::array<double, 2> ring =
          frame_ == Frame::axisymmetric
              ? std::array<double, 2>{2 * std::numbers::pi * radius(nodes().secondary[2 * at(f)]),
                                      2 * std::numbers::pi * radius(nodes().secondary[2 * at(f) + 1])}
              : std::array<double, 2>{1, 1};
      area += length_of(s) * (2 * ring[a] + ring[1 - a]) / 6;
      for (int candidate : facing_[at(f)]) {
        const auto p = primary_at(f, candidate);
        const CoveredPart<double> part = covered_part(s, p);
        if (!(part.end > part.begin)) continue;
        CoveredPart<double> unit = part;
        unit.gap_begin = unit.gap_end = 1;
        covered += weighted_gaps(unit, edge)[a];
        if (derivatives == Derivatives::none) {
          c.gap += weighted_gaps(part, edge)[a];
          pieces.push_back({side, f, candidate, {}});
          continue;
        }
        const MortarPair pair = mortar_pair(s, p, edge);
        c.gap += pair.gap[a];
        const int* on_primary = &nodes().primary[at(4 * search_.candidates().facet[at(candidate)])];
        Piece piece{side,
                    f,
                    candidate,
                    {place_of(nodes().secondary[2 * at(f)]), place_of(nodes().secondary[2 * at(f) + 1]),
                     place_of(on_primary[0]), place_of(on_primary[1])}};
        gradient.resize(2 * node.size(), 0.0);
        for (std::size_t i = 0; i < 8; ++i)
          gradient[2 * piece.place[i / 2] + i % 2] += pair.gradient[a][i] / owner.weight;
        pieces.push_back(piece);
      }
    }
    if (pieces.empty()) continue;
    if (!anchors_.empty())
      for (const Anchor& anchor : anchors_[number]) {
        if (anchor.slot[0] < 0 || anchor.slot[1] < 0) continue;
        c.slides = true;
        for (int slot : anchor.slot) place_of(slot);
      }
    gradient.resize(2 * node.size(), 0.0);
    c.gap /= owner.weight;
    c.stretch = area / owner.weight;
    const double cover = std::max(std::abs(covered) / owner.weight, least_cover);
    c.scale = 1 / (cover * cover);
    c.lambda = law.multiplier(c.index);
    c.active = law.active(c.index, c.gap);
    c.pressure = law.pressure(c.index, c.gap);
    c.node = node;
    c.share = share;
    c.gradient = gradient;
    if (c.slides) {
      const std::size_t n = 2 * node.size();
      slip_gradient.assign(n, 0.0);
      slip_hessian.assign(derivatives == Derivatives::second ? n * n : 0, 0.0);
      for (const Anchor& anchor : anchors_[number]) {
        if (anchor.slot[0] < 0 || anchor.slot[1] < 0) continue;
        const auto s = secondary_at(anchor.facet);
        const auto p = edge_at(anchor.facet, anchor.slot[0], anchor.slot[1]);
        const Slip slip = slip_of(s, p, anchor.pair);
        c.slip += slip.value;
        const std::array<std::size_t, 4> place = {place_of(nodes().secondary[2 * at(anchor.facet)]),
                                                  place_of(nodes().secondary[2 * at(anchor.facet) + 1]),
                                                  place_of(anchor.slot[0]), place_of(anchor.slot[1])};
        for (std::size_t i = 0; i < 8; ++i) slip_gradient[2 * place[i / 2] + i % 2] += slip.gradient[i];
        if (derivatives != Derivatives::second) continue;
        const std::array<double, 64> H = impact::slip_hessian(s, p, anchor.pair);
        for (std::size_t i = 0; i < 8; ++i)
          for (std::size_t j = 0; j < 8; ++j)
            slip_hessian[n * (2 * place[i / 2] + i % 2) + 2 * place[j / 2] + j % 2] += H[8 * i + j];
      }
      c.slip_gradient = slip_gradient;
      c.slip_hessian = slip_hessian;
    }
    if (derivatives == Derivatives::none) c.gradient = {};
    if (derivatives == Derivatives::second && c.active) {
      const std::size_t n = 2 * node.size();
      hessian.assign(n * n, 0.0);
      for (const Piece& piece : pieces) {
        std::array<double, 2> factor = {0, 0};
        factor[1 - piece.side] = 1 / owner.weight;
        const auto H =
            mortar_pair_hessian(secondary_at(piece.facet), primary_at(piece.facet, piece.candidate),
                                facets_[at(piece.facet)].edge, factor);
        for (std::size_t i = 0; i < 8; ++i)
          for (std::size_t j = 0; j < 8; ++j)
            hessian[n * (2 * piece.place[i / 2] + i % 2) + 2 * piece.place[j / 2] + j % 2] += H[8 * i + j];
      }
      c.hessian = hessian;
    }
    visitor(c);
  }
}

void MortarForm::visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const {
  for (const Node& owner : owned_)
    for (std::size_t side = 0; side < 2; ++side) {
      const int f = owner.facet[side];
      if (f < 0) continue;
      const auto s = secondary_edge(f, x);
      const std::size_t a = 1 - side;
      const Point2<double> n = detail::right_normal(s[0], s[1]);
      for (int candidate : facing_[at(f)]) {
        const CoveredPart<double> part = covered_part(s, primary_edge(candidate, x));
        if (!(part.end > part.begin)) continue;
        // The node is an end of the edge; the primary edge that reaches it speaks for it.
        const bool reaches = a == 0 ? part.begin <= -1 : part.end >= 1;
        const double depth = -(a == 0 ? part.gap_begin : part.gap_end);
        if (reaches && depth > 1e-9 * (facets_[at(f)].edge.length + std::hypot(s[a][0], s[a][1])))
          visitor(nodes().secondary[2 * at(f) + a], depth, {-n[0], -n[1]});
      }
    }
}

} // namespace impact
