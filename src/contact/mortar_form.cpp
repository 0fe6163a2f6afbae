#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/petsc/error.hpp>
#include <limits>
#include <map>
#include <numbers>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Facets face each other when their normals oppose and the primary is not farther away than this part of the
// secondary's longest side: a step behind the surface must not count as an open gap beside the closed one.
constexpr double farthest = 0.5;
// Two facets over the same place count as layers, one behind the other, from this common part on.
constexpr double least_common_part = 1e-6;
// A facet whose pairs or functions change more often within an attempt keeps those that it has.
constexpr int switch_limit = 4;
// Least covered part of a weight that the linear solves make up for.
constexpr double least_cover = 1e-3;
// Dual functions are negative somewhere: over a part of a facet they may turn a gap into an overlap. Covered
// parts that sum to more than this are the whole facet.
constexpr double whole_facet = 1 - 1e-6;

Point2<double> point_at(const std::vector<double>& x, int node) {
  return {x[at(2 * node)], x[at(2 * node + 1)]};
}

Point3 point3_at(const std::vector<double>& x, int node) {
  return {x[at(3 * node)], x[at(3 * node + 1)], x[at(3 * node + 2)]};
}

template <std::size_t n> double distance(const std::array<double, n>& a, const std::array<double, n>& b) {
  double square = 0;
  for (std::size_t k = 0; k < n; ++k) square += (a[k] - b[k]) * (a[k] - b[k]);
  return std::sqrt(square);
}

double length_of(const std::array<Point2<double>, 2>& edge) { return distance(edge[0], edge[1]); }

} // namespace

MortarForm::MortarForm(const Mesh& mesh, const FieldLayout& layout, const ContactSettings& settings,
                       Frame frame, const ContactSurface& secondary, const ContactSurface& primary)
    : dim_(mesh.dim()), corners_(at(secondary.corners)), settings_(settings), frame_(frame),
      node_count_(at(mesh.node_count())) {
  find_facets(mesh, secondary);
  std::vector<PetscInt> nodes;
  for (const Facet& facet : facets_)
    nodes.insert(nodes.end(), facet.node.begin(), facet.node.begin() + secondary.corners);
  std::vector<PetscInt> wanted = nodes;
  sort_unique(wanted);
  const Handle<Vec> coordinates = layout.make_global();
  layout.to_global(std::vector<double>(mesh.coordinates().begin(), mesh.coordinates().end()), coordinates);
  const std::vector<double> all =
      NodeExchange(mesh.comm(), mesh.owned_node_count(), dim_, wanted).gather(coordinates);
  std::vector<double> X;
  for (PetscInt node : nodes) {
    const auto place = dim_ * (std::lower_bound(wanted.begin(), wanted.end(), node) - wanted.begin());
    X.insert(X.end(), all.begin() + place, all.begin() + place + dim_);
  }
  const bool dual = settings.multipliers == MultiplierSpace::dual;
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    Facet& facet = facets_[at(f)];
    std::array<double, 4> area{}; // both kinds of functions have the integrals of N
    if (dim_ == 2) {
      const Point2<double> a = point_at(X, 2 * f), b = point_at(X, 2 * f + 1);
      MortarEdge& edge = facet.edge;
      edge.length = distance(a, b);
      if (frame == Frame::axisymmetric)
        edge.ring = {2 * std::numbers::pi * a[0], 2 * std::numbers::pi * b[0]};
      const auto phi = dual_functions(edge);
      for (std::size_t i = 0; i < 2; ++i) std::copy(phi[i].begin(), phi[i].end(), facet.dual[i].begin());
      for (std::size_t i = 0; i < 2; ++i) area[i] = edge.length * (2 * edge.ring[i] + edge.ring[1 - i]) / 6;
    } else {
      FaceCorners corner;
      for (int a = 0; a < 4; ++a) corner[at(a)] = point3_at(X, 4 * f + a);
      facet.face = make_mortar_face(facet.corners, corner, false);
      facet.dual = make_mortar_face(facet.corners, corner, true).phi;
      area = nodal_areas(facet.corners, corner);
    }
    if (settings.rigid()) { // which covers everything
      // To a round obstacle a node counts nearer than it is, by h^2/12R in each direction of the surface: the
      // dual functions of a facet of the side h take the integral of x^2 for -h^2/6.
      if (dual) set_functions(facet, facet.dual);
      facet.points = dim_ == 2 ? points_of(facet.edge) : points_of(facet.face);
      for (const FacetPoint& point : facet.points)
        for (std::size_t a = 0; a < 4; ++a)
          for (std::size_t b = 0; b < 4; ++b) facet.onto.D[a][b] += point.weight[a] * point.shape[b];
      facet.onto.M = facet.onto.D;
    }
    for (int a = 0; a < facet.corners; ++a)
      if (facet.owned[at(a)] >= 0) owned_[at(facet.owned[at(a)])].weight += area[at(a)];
  }
  std::vector<double> area = layout.make_local();
  for (const Node& node : owned_) area[at(dim_ * node.local)] = node.weight;
  const Handle<Vec> owned_area = layout.make_global();
  layout.to_global(area, owned_area);
  layout.to_local(owned_area, area);
  for (std::size_t node = 0; node < node_count_; ++node) nodal_area_.push_back(area[at(dim_) * node]);
  if (dim_ == 3 && settings.friction > 0) find_tangents(X);
  search_ = PairSearch(mesh, layout, nodes, X, primary, {settings.search_radius, settings.local_search},
                       what_it_meets(settings));
  facing_.resize(facets_.size());
  switches_.assign(facets_.size(), 0);
}

void MortarForm::find_facets(const Mesh& mesh, const ContactSurface& secondary) {
  std::map<PetscInt, int> mine; // global node: local node, where owned
  for (int local = 0; local < mesh.node_count(); ++local)
    if (mesh.owned(local)) mine.emplace(mesh.global_node()[at(local)], local);
  std::map<PetscInt, int> number; // global node: place in owned_
  bool branches = false;
  for (const std::array<PetscInt, 4>& nodes : facets_at_owned_nodes(mesh, secondary)) {
    Facet facet;
    facet.node = nodes;
    facet.corners = secondary.corners == 2 ? 2 : nodes[3] == nodes[2] ? 3 : 4;
    for (int a = 0; a < facet.corners; ++a) {
      const auto found = mine.find(nodes[at(a)]);
      if (found == mine.end()) continue;
      const auto [place, is_new] = number.try_emplace(nodes[at(a)], static_cast<int>(owned_.size()));
      if (is_new) owned_.push_back({found->second, {}, 0});
      std::vector<Incident>& incident = owned_[at(place->second)].facets;
      // Two edges that leave a node, or arrive there, are a branch.
      for (const Incident& other : incident) branches = branches || (dim_ == 2 && other.corner == a);
      incident.push_back({static_cast<int>(facets_.size()), a});
      facet.owned[at(a)] = place->second;
    }
    facets_.push_back(facet);
  }
  if (!all_ranks_agree(mesh.comm(), !branches))
    throw UserError(ExitCode::data,
                    "contact " + settings_.id + ": more than two edges of `" + settings_.secondary +
                        "` meet in a node; name a surface without branches, or use -contact_" + settings_.id +
                        "_method gpts");
}

std::pair<StateRow, std::size_t> MortarForm::constraint_row(const std::string& name, int components) const {
  return {StateRow{name, Support::vertex, components}, at(components) * node_count_};
}

void MortarForm::release() {
  std::fill(switches_.begin(), switches_.end(), 0);
  for (Facet& facet : facets_) facet.changes = 0;
}

void MortarForm::set_functions(Facet& facet, const std::array<std::array<double, 4>, 4>& phi) {
  facet.face.phi = phi;
  for (std::size_t a = 0; a < 2; ++a) std::copy_n(phi[a].begin(), 2, facet.edge.phi[a].begin());
}

void MortarForm::choose_functions(const Facing& facing, const std::vector<double>& x) {
  if (settings_.multipliers != MultiplierSpace::dual) return;
  const std::array<std::array<double, 4>, 4> standard = {
      {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    double part = 0;
    for (int candidate : facing[at(f)]) part += view(f, candidate, x).part;
    Facet& facet = facets_[at(f)];
    const bool whole = part > whole_facet;
    if (whole == facet.whole || facet.changes >= switch_limit) continue;
    facet.whole = whole;
    ++facet.changes;
    set_functions(facet, whole ? facet.dual : standard);
  }
}

const int* MortarForm::secondary_slots(int facet) const { return &nodes().secondary[corners_ * at(facet)]; }

const int* MortarForm::primary_slots(int candidate) const {
  return &nodes().primary[corners_ * at(search_.candidates().facet[at(candidate)])];
}

int MortarForm::primary_corners(int candidate) const {
  const int* slot = primary_slots(candidate);
  return dim_ == 2 ? 2 : slot[3] == slot[2] ? 3 : 4;
}

std::array<Point2<double>, 2> MortarForm::secondary_edge(int facet, const std::vector<double>& x) const {
  const int* slot = secondary_slots(facet);
  return {point_at(x, slot[0]), point_at(x, slot[1])};
}

std::array<Point2<double>, 2> MortarForm::primary_edge(int candidate, const std::vector<double>& x) const {
  const int* slot = primary_slots(candidate);
  return {point_at(x, slot[0]), point_at(x, slot[1])};
}

FaceCorners MortarForm::secondary_face(int facet, const std::vector<double>& x) const {
  const int* slot = secondary_slots(facet);
  return {point3_at(x, slot[0]), point3_at(x, slot[1]), point3_at(x, slot[2]), point3_at(x, slot[3])};
}

FaceCorners MortarForm::primary_face(int candidate, const std::vector<double>& x) const {
  const int* slot = primary_slots(candidate);
  return {point3_at(x, slot[0]), point3_at(x, slot[1]), point3_at(x, slot[2]), point3_at(x, slot[3])};
}

void MortarForm::place_edges(int facet, int candidate, const std::vector<double>& u,
                             std::array<Point2<double>, 2>& s, std::array<Point2<double>, 2>& p) const {
  const int *mine = secondary_slots(facet), *other = primary_slots(candidate);
  for (std::size_t a = 0; a < 2; ++a) {
    s[a] = nodes().place<2>(mine[a], mine[0], u);
    p[a] = nodes().place<2>(other[a], mine[0], u);
  }
}

void MortarForm::place_faces(int facet, int candidate, const std::vector<double>& u, FaceCorners& s,
                             FaceCorners& p) const {
  const int *mine = secondary_slots(facet), *other = primary_slots(candidate);
  for (std::size_t a = 0; a < 4; ++a) {
    s[a] = nodes().place<3>(mine[a], mine[0], u);
    p[a] = nodes().place<3>(other[a], mine[0], u);
  }
}

double MortarForm::size_of(int facet, const std::vector<double>& x) const {
  if (dim_ == 2) return length_of(secondary_edge(facet, x));
  const FaceCorners corner = secondary_face(facet, x);
  double longest = 0;
  for (std::size_t a = 0; a < 4; ++a) longest = std::max(longest, distance(corner[a], corner[(a + 1) % 4]));
  return longest;
}

bool MortarForm::opposed(int facet, int candidate, const std::vector<double>& x) const {
  if (dim_ == 2) {
    const auto s = secondary_edge(facet, x), p = primary_edge(candidate, x);
    return detail::dot(detail::right_normal(s[0], s[1]), detail::right_normal(p[0], p[1])) <
           -least_opposition;
  }
  const Point3 n = face_normal(secondary_face(facet, x)), m = face_normal(primary_face(candidate, x));
  return n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < -least_opposition;
}

FaceView MortarForm::view(int facet, int candidate, const std::vector<double>& x) const {
  if (dim_ == 3)
    return view_face(facets_[at(facet)].corners, secondary_face(facet, x), primary_corners(candidate),
                     primary_face(candidate, x));
  const CoveredPart<double> part = covered_part(secondary_edge(facet, x), primary_edge(candidate, x));
  const double mean = (part.gap_begin + part.gap_end) / 2;
  if (part.end > part.begin)
    return {(part.end - part.begin) / 2, std::min(part.gap_begin, part.gap_end),
            std::max(part.gap_begin, part.gap_end), mean};
  // Judged by the nearest end.
  const double end = part.end < -1 ? part.gap_end : part.gap_begin;
  return {0, end, end, mean};
}

bool MortarForm::share_a_node(int candidate, int other) const {
  const int *a = primary_slots(candidate), *b = primary_slots(other);
  return std::any_of(a, a + corners_,
                     [&](int slot) { return std::find(b, b + corners_, slot) != b + corners_; });
}

bool MortarForm::hidden(int facet, int candidate, const std::vector<int>& accepted,
                        const std::vector<double>& x) const {
  return std::any_of(accepted.begin(), accepted.end(), [&](int other) {
    if (dim_ == 2) {
      const auto s = secondary_edge(facet, x);
      const CoveredPart<double> a = covered_part(s, primary_edge(candidate, x)),
                                b = covered_part(s, primary_edge(other, x));
      return std::min(a.end, b.end) - std::max(a.begin, b.begin) > least_common_part;
    }
    // Neighbours on the same surface do not hide each other.
    return !share_a_node(candidate, other) &&
           common_part(facets_[at(facet)].corners, secondary_face(facet, x), primary_corners(candidate),
                       primary_face(candidate, x), primary_corners(other),
                       primary_face(other, x)) > least_common_part;
  });
}

bool MortarForm::came_through(int facet, int candidate) const {
  return !nodes().start.empty() && opposed(facet, candidate, nodes().start) &&
         view(facet, candidate, nodes().start).largest > -search_.depth(facet);
}

MortarForm::Facing MortarForm::facing_at(const std::vector<double>& x) const {
  Facing facing(facets_.size());
  const Candidates& list = search_.candidates();
  std::vector<std::pair<double, int>> pairs; // distance, candidate
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const double size = size_of(f, x);
    pairs.clear();
    for (int c = list.offset[at(f)]; c < list.offset[at(f + 1)]; ++c) {
      if (!opposed(f, c, x)) continue;
      const FaceView seen = view(f, c, x);
      if (seen.smallest < farthest * size && (seen.largest > -search_.depth(f) || came_through(f, c)))
        pairs.emplace_back(std::abs(seen.mean), c);
    }
    // Of two layers over the same part the nearer one counts.
    std::sort(pairs.begin(), pairs.end());
    for (const auto& [distance, candidate] : pairs)
      if (!hidden(f, candidate, facing[at(f)], x)) facing[at(f)].push_back(candidate);
    std::erase_if(facing[at(f)], [&](int candidate) { return !search_.counts(candidate); });
    std::sort(facing[at(f)].begin(), facing[at(f)].end());
  }
  return facing;
}

std::vector<int> MortarForm::covering(int facet, const std::vector<double>& x, const Facing& facing) const {
  std::vector<int> list;
  for (int c : facing[at(facet)])
    if (view(facet, c, x).part > 1e-12) list.push_back(c);
  return list;
}

PairSearch::Outcome MortarForm::update(Vec u, const Presses& presses) {
  const PairSearch::Outcome outcome = update_pairs(u);
  if (settings_.rigid()) return outcome;
  const std::vector<double> moved = nodes().displacement(u), x = nodes().current(moved);
  switched_ = false;
  Facing next = facing_at(x);
  if (outcome != PairSearch::Outcome::kept) {
    locate_anchors();
    // Candidates have other numbers now: what faced is forgotten, and the caller solves again anyway.
    facing_ = std::move(next);
    choose_functions(facing_, x);
    return outcome;
  }
  for (std::size_t f = 0; f < facets_.size(); ++f)
    if (switches_[f] >= switch_limit) next[f] = facing_[f];
  for (const Node& node : owned_) {
    const bool changed = std::any_of(node.facets.begin(), node.facets.end(), [&](const Incident& i) {
      return next[at(i.facet)] != facing_[at(i.facet)];
    });
    if (!changed || !(active(node, moved, presses, facing_) || active(node, moved, presses, next))) continue;
    // Only pairs that cover something now make a difference.
    for (const Incident& i : node.facets)
      if (next[at(i.facet)] != facing_[at(i.facet)] &&
          covering(i.facet, x, next) != covering(i.facet, x, facing_)) {
        switched_ = true;
        ++switches_[at(i.facet)];
      }
  }
  facing_ = std::move(next);
  choose_functions(facing_, x);
  return outcome;
}

bool MortarForm::active(const Node& node, const std::vector<double>& u, const Presses& presses,
                        const Facing& facing) const {
  double gap = 0;
  bool covered = false;
  for (const Incident& incident : node.facets)
    for (int c : facing[at(incident.facet)]) {
      const MortarFacePair pair = pair_at(incident.facet, c, u, false);
      covered = covered || pair.covered;
      gap += pair.gap[at(incident.corner)];
    }
  return covered && presses(node.local, gap / node.weight);
}

NodePairs MortarForm::couplings() const {
  NodePairs pairs;
  for (const Node& node : owned_) {
    std::vector<PetscInt> together;
    for (const Incident& i : node.facets) {
      const std::vector<PetscInt> primary = search_.primary_nodes(i.facet);
      together.insert(together.end(), facets_[at(i.facet)].node.begin(), facets_[at(i.facet)].node.end());
      together.insert(together.end(), primary.begin(), primary.end());
    }
    add_pairs_among(std::move(together), pairs);
  }
  sort_unique(pairs);
  return pairs;
}

MortarFacePair MortarForm::pair_at(int facet, int candidate, const std::vector<double>& u,
                                   bool with_gradient) const {
  if (dim_ == 3) {
    FaceCorners s, p;
    place_faces(facet, candidate, u, s, p);
    return mortar_face_pair(s, primary_corners(candidate), p, facets_[at(facet)].face, with_gradient);
  }
  std::array<Point2<double>, 2> s, p;
  place_edges(facet, candidate, u, s, p);
  const MortarEdge& edge = facets_[at(facet)].edge;
  MortarFacePair pair;
  CoveredPart<double> part = covered_part(s, p);
  pair.covered = pair.touched = part.end > part.begin;
  if (!pair.covered) return pair;
  const std::array<double, 2> gap = weighted_gaps(part, edge);
  std::copy(gap.begin(), gap.end(), pair.gap.begin());
  part.gap_begin = part.gap_end = 1;
  const std::array<double, 2> cover = weighted_gaps(part, edge);
  std::copy(cover.begin(), cover.end(), pair.cover.begin());
  if (!with_gradient) return pair;
  const MortarPair with = mortar_pair(s, p, edge);
  for (std::size_t a = 0; a < 2; ++a)
    std::copy(with.gradient[a].begin(), with.gradient[a].end(), pair.gradient[a].begin());
  return pair;
}

std::vector<MortarForm::FacetPoint> MortarForm::points_of(const MortarEdge& edge) {
  // Three Gauss points: exact up to degree five, and for a plane whatever the ring.
  std::vector<FacetPoint> points;
  for (const auto& [xi, weight] : std::array<std::array<double, 2>, 3>{
           {{-std::sqrt(0.6), 5.0 / 9}, {0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}}}) {
    FacetPoint point;
    const std::array<double, 2> N = {(1 - xi) / 2, (1 + xi) / 2};
    const double area = weight * edge.length / 2 * (edge.ring[0] * N[0] + edge.ring[1] * N[1]);
    for (std::size_t a = 0; a < 2; ++a) {
      point.shape[a] = N[a];
      point.weight[a] = area * (edge.phi[a][0] * N[0] + edge.phi[a][1] * N[1]);
    }
    points.push_back(point);
  }
  return points;
}

std::vector<MortarForm::FacetPoint> MortarForm::points_of(const MortarFace& face) {
  // Exact up to degree four.
  const TriangleRule rule = triangle_rule(3);
  std::vector<FacetPoint> points;
  for (int t = 0; t < face.triangles(); ++t) {
    const auto corner = triangle_weights(face.corners, t);
    for (std::size_t q = 0; q < rule.part.size(); ++q) {
      FacetPoint point;
      for (std::size_t u = 0; u < 3; ++u)
        for (std::size_t a = 0; a < 4; ++a) point.shape[a] += rule.part[q][u] * corner[u][a];
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b)
          point.weight[a] += rule.weight[q] * face.area[at(t)] * face.phi[a][b] * point.shape[b];
      points.push_back(point);
    }
  }
  return points;
}

Point3 MortarForm::place_of(const Facet& facet, const FacetPoint& point, const int* slot,
                            const std::vector<double>& u) const {
  Point3 x{};
  for (std::size_t a = 0; a < at(facet.corners); ++a)
    for (std::size_t k = 0; k < at(dim_); ++k) {
      const std::size_t i = at(dim_ * slot[a]) + k;
      x[k] += point.shape[a] * (nodes().X[i] + u[i]);
    }
  return x;
}

MortarFacePair MortarForm::obstacle_gaps(int f, const RigidObstacle& obstacle,
                                         const std::vector<double>& u) const {
  const Facet& facet = facets_[at(f)];
  MortarFacePair pair;
  pair.covered = pair.touched = true;
  const auto d = at(dim_);
  for (const FacetPoint& point : facet.points) {
    const Point3 x = place_of(facet, point, secondary_slots(f), u);
    if (carried()) {
      const CarriedFunction gap = carried_gap(obstacle, x);
      for (std::size_t a = 0; a < at(facet.corners); ++a) {
        pair.gap[a] += point.weight[a] * gap.value;
        pair.cover[a] += point.weight[a];
        carrier_.add_gradient(gap, {point.shape.data(), corners_}, carrier_.shares(), point.weight[a],
                              pair.gradient[a].data());
      }
      continue;
    }
    const ObstacleGap gap = gap_to(obstacle, x);
    for (std::size_t a = 0; a < at(facet.corners); ++a) {
      pair.gap[a] += point.weight[a] * gap.gap;
      pair.cover[a] += point.weight[a];
      for (std::size_t b = 0; b < at(facet.corners); ++b)
        for (std::size_t k = 0; k < d; ++k)
          pair.gradient[a][d * b + k] += point.weight[a] * point.shape[b] * gap.normal[k];
    }
  }
  return pair;
}

std::array<double, 4> MortarForm::areas_at(int facet, const std::vector<double>& u) const {
  const int* slot = secondary_slots(facet);
  if (dim_ == 3) {
    FaceCorners corner;
    for (std::size_t a = 0; a < 4; ++a) corner[a] = nodes().place<3>(slot[a], slot[0], u);
    return nodal_areas(facets_[at(facet)].corners, corner);
  }
  const double length = distance(Point2<double>{0, 0}, nodes().place<2>(slot[1], slot[0], u));
  std::array<double, 2> ring = {1, 1};
  if (frame_ == Frame::axisymmetric)
    for (std::size_t a = 0; a < 2; ++a)
      ring[a] = 2 * std::numbers::pi * (nodes().X[2 * at(slot[a])] + u[2 * at(slot[a])]);
  return {length * (2 * ring[0] + ring[1]) / 6, length * (2 * ring[1] + ring[0]) / 6, 0, 0};
}

void MortarForm::visit(const std::vector<double>& u, Derivatives derivatives,
                       const ConstraintVisitor& visitor) const {
  const bool with_gradient = derivatives != Derivatives::none;
  const auto d = at(dim_);
  // Each pair once, for all corners of its secondary facet.
  std::vector<Piece> pieces;
  std::vector<std::size_t> first = {0};
  const RigidObstacle obstacle = obstacle_at(u);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    if (settings_.rigid()) pieces.push_back({f, -1, obstacle_gaps(f, obstacle, u)});
    for (int candidate : facing_[at(f)]) {
      pieces.push_back({f, candidate, pair_at(f, candidate, u, with_gradient)});
      if (!pieces.back().pair.touched) pieces.pop_back();
    }
    first.push_back(pieces.size());
  }
  std::vector<double> share, gradient;
  SlipRows slip_rows;
  visit_face_slips(u, with_gradient, slip_rows);
  NodePlaces place_of;
  std::vector<int>& node = place_of.node;
  for (std::size_t number = 0; number < owned_.size(); ++number) {
    const Node& owner = owned_[number];
    const bool covered = std::any_of(owner.facets.begin(), owner.facets.end(), [&](const Incident& i) {
      const auto begin = pieces.begin() + static_cast<std::ptrdiff_t>(first[at(i.facet)]),
                 end = pieces.begin() + static_cast<std::ptrdiff_t>(first[at(i.facet) + 1]);
      return std::any_of(begin, end, [](const Piece& piece) { return piece.pair.covered; });
    });
    if (!covered) continue;
    node.clear();
    Constraint c;
    c.index = owner.local;
    c.weight = owner.weight;
    double cover = 0, area = 0;
    // Secondary nodes first.
    for (const Incident& i : owner.facets)
      for (std::size_t a = 0; a < corners_; ++a) place_of(secondary_slots(i.facet)[a]);
    share.assign(node.size(), 0.0);
    gradient.assign(d * node.size(), 0.0);
    for (const Incident& i : owner.facets) {
      const std::size_t a = at(i.corner);
      const int* secondary = secondary_slots(i.facet);
      share[place_of(secondary[a])] = 1;
      area += areas_at(i.facet, u)[a];
      for (std::size_t k = first[at(i.facet)]; k < first[at(i.facet) + 1]; ++k) {
        const Piece& piece = pieces[k];
        c.gap += piece.pair.gap[a];
        cover += piece.pair.cover[a];
        if (!with_gradient) continue;
        const std::span<const int> primary = opposite_slots(piece.candidate);
        for (std::size_t b = 0; b < corners_ + primary.size(); ++b) {
          const std::size_t place = d * place_of(b < corners_ ? secondary[b] : primary[b - corners_]);
          gradient.resize(d * node.size(), 0.0);
          for (std::size_t m = 0; m < d; ++m)
            gradient[place + m] += piece.pair.gradient[a][d * b + m] / owner.weight;
        }
      }
    }
    c.slides = slip_nodes(number, place_of);
    gradient.resize(d * node.size(), 0.0);
    c.gap /= owner.weight;
    c.stretch = area / owner.weight;
    c.cover = std::max(std::abs(cover) / owner.weight, least_cover);
    c.node = node;
    c.share = share;
    if (with_gradient) c.gradient = gradient;
    if (c.slides) add_slip(number, u, place_of, slip_rows, c);
    visitor(c);
  }
}

void MortarForm::visit_curvature(const std::vector<double>& u, const CurvatureFactors& factors,
                                 const BlockVisitor& visitor) const {
  std::array<int, 8> node{};
  const RigidObstacle obstacle = obstacle_at(u);
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const Facet& facet = facets_[at(f)];
    std::array<double, 4> factor{};
    for (std::size_t a = 0; a < at(facet.corners); ++a)
      if (facet.owned[a] >= 0) {
        const Node& owner = owned_[at(facet.owned[a])];
        factor[a] = factors.of_gap(owner.local) / owner.weight;
      }
    if (std::all_of(factor.begin(), factor.end(), [](double value) { return value == 0; })) continue;
    std::copy_n(secondary_slots(f), corners_, node.begin());
    if (carried()) {
      std::array<double, 576> block{};
      for (const FacetPoint& point : facet.points) {
        double weight = 0;
        for (std::size_t a = 0; a < 4; ++a) weight += factor[a] * point.weight[a];
        carrier_.add_hessian(carried_gap(obstacle, place_of(facet, point, node.data(), u)),
                             {point.shape.data(), corners_}, carrier_.shares(), weight, block.data());
      }
      const std::size_t count = corners_ + carrier_.slots().size(), n = at(dim_) * count;
      std::copy(carrier_.slots().begin(), carrier_.slots().end(),
                node.begin() + static_cast<std::ptrdiff_t>(corners_));
      visitor({node.data(), count}, {block.data(), n * n});
      continue;
    }
    if (settings_.rigid()) {
      const auto d = at(dim_), n = d * corners_;
      std::array<double, 144> block{};
      for (const FacetPoint& point : facet.points) {
        const std::array<double, 9> H =
            gap_to(pose_.obstacle, place_of(facet, point, node.data(), u)).curvature;
        double weight = 0;
        for (std::size_t a = 0; a < 4; ++a) weight += factor[a] * point.weight[a];
        for (std::size_t i = 0; i < n; ++i)
          for (std::size_t j = 0; j < n; ++j)
            block[n * i + j] += weight * point.shape[i / d] * point.shape[j / d] * H[3 * (i % d) + j % d];
      }
      visitor({node.data(), corners_}, {block.data(), n * n});
      continue;
    }
    for (int candidate : facing_[at(f)]) {
      std::copy_n(primary_slots(candidate), corners_, node.begin() + static_cast<std::ptrdiff_t>(corners_));
      if (dim_ == 2) {
        std::array<Point2<double>, 2> s, p;
        place_edges(f, candidate, u, s, p);
        visitor({node.data(), 4}, mortar_pair_hessian(s, p, facet.edge, {factor[0], factor[1]}));
        continue;
      }
      FaceCorners s, p;
      place_faces(f, candidate, u, s, p);
      std::array<double, 576> block{};
      if (add_mortar_face_hessian(s, primary_corners(candidate), p, facet.face, factor, block))
        visitor(node, block);
    }
  }
  visit_slip_curvature(u, factors, visitor);
}

void MortarForm::visit_meetings(const std::vector<double>& u, const MeetingVisitor& visitor) const {
  // Each pair once, for all corners of its secondary facet.
  struct Part {
    int candidate; // -1: the rigid body
    FaceWeights weights;
  };
  std::vector<Part> parts;
  std::vector<std::size_t> first = {0};
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    if (settings_.rigid()) parts.push_back({-1, facets_[at(f)].onto});
    for (int candidate : facing_[at(f)]) {
      FaceWeights weights;
      if (dim_ == 3) {
        FaceCorners s, p;
        place_faces(f, candidate, u, s, p);
        weights = mortar_face_weights(s, primary_corners(candidate), p, facets_[at(f)].face);
      } else {
        std::array<Point2<double>, 2> s, p;
        place_edges(f, candidate, u, s, p);
        const MortarWeights edge = mortar_weights(s, p, facets_[at(f)].edge);
        for (std::size_t a = 0; a < 2; ++a) {
          std::copy(edge.D[a].begin(), edge.D[a].end(), weights.D[a].begin());
          std::copy(edge.M[a].begin(), edge.M[a].end(), weights.M[a].begin());
        }
      }
      parts.push_back({candidate, weights});
    }
    first.push_back(parts.size());
  }
  NodePlaces mine, opposite;
  std::vector<double> share, other;
  for (const Node& owner : owned_) {
    mine.node.clear();
    opposite.node.clear();
    share.clear();
    other.clear();
    const auto add = [](NodePlaces& place_of, std::vector<double>& to, int slot, double value) {
      const std::size_t place = place_of(slot);
      to.resize(place_of.node.size(), 0.0);
      to[place] += value;
    };
    double area = 0;
    for (const Incident& i : owner.facets)
      for (std::size_t k = first[at(i.facet)]; k < first[at(i.facet) + 1]; ++k) {
        const Part& part = parts[k];
        for (std::size_t b = 0; b < corners_; ++b) {
          const double D = part.weights.D[at(i.corner)][b], M = part.weights.M[at(i.corner)][b];
          area += D;
          if (D != 0) add(mine, share, secondary_slots(i.facet)[b], D);
          if (M != 0 && part.candidate >= 0) add(opposite, other, primary_slots(part.candidate)[b], M);
        }
      }
    Meeting meeting;
    meeting.index = owner.local;
    if (!(area > least_common_part * owner.weight)) {
      if (owner.facets.empty()) continue;
      const Incident& i = owner.facets.front();
      share = {1};
      mine.node = {secondary_slots(i.facet)[i.corner]};
      other.clear();
      opposite.node.clear();
      area = 1;
    } else {
      meeting.area = area;
    }
    meeting.secondary = share.size();
    share.insert(share.end(), other.begin(), other.end());
    mine.node.insert(mine.node.end(), opposite.node.begin(), opposite.node.end());
    for (double& part : share) part /= area;
    meeting.node = mine.node;
    meeting.share = share;
    visitor(meeting);
  }
}

void MortarForm::visit_overlaps(const std::vector<double>& x, const OverlapVisitor& visitor) const {
  for (const Node& owner : owned_)
    for (const Incident& incident : owner.facets) {
      const int f = incident.facet, corner = incident.corner;
      const int slot = secondary_slots(f)[corner];
      Point3 here{};
      std::copy_n(&x[at(dim_ * slot)], at(dim_), here.begin());
      const double size = size_of(f, x) + std::abs(here[0]) + std::abs(here[1]) + std::abs(here[2]);
      if (settings_.rigid()) {
        const ObstacleGap seen = gap_to(pose_.obstacle, here);
        if (-seen.gap > 1e-9 * size) visitor(slot, -seen.gap, seen.normal);
        continue;
      }
      for (int candidate : facing_[at(f)]) {
        double gap = 0;
        std::array<double, 3> n{};
        if (dim_ == 2) {
          const auto s = secondary_edge(f, x);
          const CoveredPart<double> part = covered_part(s, primary_edge(candidate, x));
          // The node is an end of the edge; the primary edge that reaches it speaks for it.
          if (!(part.end > part.begin) || !(corner == 0 ? part.begin <= -1 : part.end >= 1)) continue;
          gap = corner == 0 ? part.gap_begin : part.gap_end;
          const Point2<double> normal = detail::right_normal(s[0], s[1]);
          n = {normal[0], normal[1], 0};
        } else {
          const FaceCorners s = secondary_face(f, x);
          if (!corner_gap(facets_[at(f)].corners, s, corner, primary_corners(candidate),
                          primary_face(candidate, x), gap))
            continue;
          n = face_normal(s);
        }
        // Coordinates that were meant to touch differ by rounding of their own size.
        if (-gap > 1e-9 * size) visitor(slot, -gap, {-n[0], -n[1], -n[2]});
      }
    }
}

} // namespace impact
