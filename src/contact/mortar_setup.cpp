#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <numbers>
#include <set>

/// Construction of a MortarForm: its facets, their functions and tangents, points against a rigid body.
namespace impact {

namespace {

// X: [corner][dim]
FaceCorners face_of(const std::vector<double>& X, const std::array<int, 4>& corner) {
  FaceCorners face;
  for (std::size_t a = 0; a < 4; ++a) std::copy_n(&X[at(3 * corner[a])], 3, face[a].begin());
  return face;
}

MortarEdge edge_of(const std::vector<double>& X, const std::array<int, 4>& corner, Frame frame) {
  MortarEdge edge;
  const double *x = &X[at(2 * corner[0])], *y = &X[at(2 * corner[1])];
  double square = 0;
  for (std::size_t k = 0; k < 2; ++k) square += (x[k] - y[k]) * (x[k] - y[k]);
  edge.length = std::sqrt(square);
  if (frame == Frame::axisymmetric) edge.ring = {2 * std::numbers::pi * x[0], 2 * std::numbers::pi * y[0]};
  return edge;
}

std::array<int, 4> consecutive(int first) { return {first, first + 1, first + 2, first + 3}; }

} // namespace

MortarForm::MortarForm(const FormRequest& request)
    : ContactForm(request), dim_(request.mesh.dim()), cuts_(request.secondary.per_facet),
      corners_(at(cuts_.corners())), frame_(request.frame) {
  const Mesh& mesh = request.mesh;
  const FieldLayout& layout = request.layout;
  parts_ = cuts_.parts();
  find_facets(mesh, request.secondary);
  std::vector<PetscInt> nodes;
  for (std::size_t f = 0; f < facets_.size(); f += at(parts_))
    nodes.insert(nodes.end(), facets_[f].node.begin(), facets_[f].node.begin() + cuts_.width());
  std::vector<PetscInt> wanted = nodes;
  sort_unique(wanted);
  const Handle<Vec> coordinates = layout.make_global();
  layout.to_global(std::vector<double>(mesh.coordinates().begin(), mesh.coordinates().end()), coordinates);
  const std::vector<double> all =
      NodeExchange(mesh.comm(), mesh.owned_node_count(), dim_, wanted).gather(coordinates);
  std::vector<double> X, of_corners; // of_corners: [facet][corner][dim]
  for (PetscInt node : nodes) {
    const auto place = dim_ * (std::lower_bound(wanted.begin(), wanted.end(), node) - wanted.begin());
    X.insert(X.end(), all.begin() + place, all.begin() + place + dim_);
  }
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const Facet& facet = facets_[at(f)];
    const std::vector<double> vertex = vertices_of(f, &X[at(dim_ * cuts_.width() * (f / parts_))]);
    const std::array<double, 4> area = measure(f, vertex);
    for (int a = 0; a < facet.corners; ++a)
      if (facet.owned[at(a)] >= 0) owned_[at(facet.owned[at(a)])].weight += area[at(a)];
    for (std::size_t c = 0; c < corners_; ++c) {
      const double* place = &vertex[at(dim_ * part_of(f).vertex[c])];
      of_corners.insert(of_corners.end(), place, place + dim_);
    }
  }
  std::vector<double> area = layout.make_local();
  for (const Node& node : owned_) area[at(dim_ * node.local)] = node.weight;
  const Handle<Vec> owned_area = layout.make_global();
  layout.to_global(area, owned_area);
  layout.to_local(owned_area, area);
  for (std::size_t i = 0; i < area.size(); i += at(dim_)) nodal_area_.push_back(area[i]);
  if (dim_ == 3 && frictional()) find_tangents(of_corners);
  search_ = PairSearch(mesh, layout, nodes, X, request.primary,
                       {settings_.search_radius, settings_.local_search}, what_it_meets(settings_));
  facing_.resize(facets_.size());
  switches_.resize(facets_.size());
}

std::vector<double> MortarForm::vertices_of(int f, const double* X) const {
  std::vector<double> vertex;
  for (const std::vector<double>& weight : cut_of(f).vertex)
    for (int k = 0; k < dim_; ++k) {
      double& x = vertex.emplace_back();
      for (std::size_t a = 0; a < weight.size(); ++a)
        if (weight[a] != 0) x += weight[a] * X[at(dim_) * a + at(k)];
    }
  return vertex;
}

// Integrals of functions from those of the piecewise linear functions of the corners.
std::array<double, 4> MortarForm::of_functions(int f, const std::array<double, 4>& of_corners) const {
  const auto corners = at(facets_[at(f)].corners);
  std::array<double, 4> sum{};
  for (std::size_t r = 0; r < corners; ++r)
    for (std::size_t c = 0; c < corners; ++c) sum[r] += part_of(f).function[r][c] * of_corners[c];
  return sum;
}

// Reference sizes and functions of a facet; their integrals, the same of both kinds.
std::array<double, 4> MortarForm::measure(int f, const std::vector<double>& X) {
  Facet& facet = facets_[at(f)];
  const std::array<int, 4>&corner = part_of(f).vertex,
                        &half = cut_of(f).half[at(f % parts_ / cuts_.parts_of_half())];
  std::array<std::array<double, 4>, 4> dual{};
  std::array<double, 4> area{};
  if (dim_ == 2) {
    facet.edge = edge_of(X, corner, frame_);
    const auto phi = dual_functions(edge_of(X, half, frame_));
    for (std::size_t i = 0; i < 2; ++i) std::copy(phi[i].begin(), phi[i].end(), dual[i].begin());
    const std::array<double, 2>& ring = facet.edge.ring;
    for (std::size_t i = 0; i < 2; ++i) area[i] = facet.edge.length * (2 * ring[i] + ring[1 - i]) / 6;
  } else {
    facet.face = make_mortar_face(face_of(X, corner), false);
    dual = make_mortar_face(face_of(X, half), true).phi;
    area = nodal_areas(face_of(X, corner));
  }
  facet.dual = functions_of_part(cut_of(f), f % parts_, dual);
  set_functions(facet, part_of(f).function);
  if (rigid()) set_obstacle_points(facet);
  return of_functions(f, area);
}

// A rigid body covers everything.
void MortarForm::set_obstacle_points(Facet& facet) const {
  // To a round obstacle a node counts nearer than it is, by h^2/12R in each direction of the surface: the
  // dual functions of a facet of the side h take the integral of x^2 for -h^2/6.
  if (settings_.multipliers == MultiplierSpace::dual) set_functions(facet, facet.dual);
  facet.points = points_of(facet);
  for (const FacetPoint& point : facet.points)
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < 4; ++b) facet.onto.D[a][b] += point.weight[a] * point.shape[b];
  facet.onto.M = facet.onto.D;
}

void MortarForm::find_facets(const Mesh& mesh, const ContactSurface& secondary) {
  std::map<PetscInt, int> mine; // global node: local node, where owned
  for (int local = 0; local < mesh.node_count(); ++local)
    if (mesh.owned(local)) mine.emplace(mesh.global_node()[at(local)], local);
  std::map<PetscInt, int> number;                  // global node: place in owned_
  std::set<std::pair<PetscInt, std::size_t>> ends; // node, which end of an edge it is
  bool branches = false;
  for (const GlobalFacet& nodes : facets_at_owned_nodes(mesh, secondary)) {
    // Two edges that leave a node, or arrive there, are a branch.
    for (std::size_t a = 0; dim_ == 2 && a < 2; ++a)
      if (mine.contains(nodes[a])) branches = !ends.emplace(nodes[a], a).second || branches;
    for (const FacetParts::Part& part : cuts_.of(nodes.data()).parts) {
      Facet facet;
      facet.node = nodes;
      const bool triangle = part.vertex[3] == part.vertex[2] || (cuts_.width() == 4 && nodes[3] == nodes[2]);
      facet.corners = dim_ == 2 ? 2 : triangle ? 3 : 4;
      for (int a = 0; a < facet.corners; ++a) {
        if (part.node[at(a)] < 0) continue;
        const auto found = mine.find(nodes[at(part.node[at(a)])]);
        if (found == mine.end()) continue;
        const auto [place, is_new] = number.try_emplace(found->first, static_cast<int>(owned_.size()));
        if (is_new) owned_.push_back({found->second, found->first, 0, {}, 0, 0, {}, false});
        owned_[at(place->second)].facets.push_back({static_cast<int>(facets_.size()), a});
        facet.owned[at(a)] = place->second;
      }
      facet.lean.fill(dim_ == 2 ? upright<2>() : upright<3>());
      facets_.push_back(facet);
    }
  }
  if (!all_ranks_agree(mesh.comm(), !branches))
    throw UserError(ExitCode::data,
                    "contact " + settings_.id + ": more than two edges of `" + settings_.secondary +
                        "` meet in a node; name a surface without branches, or use -contact_" + settings_.id +
                        "_method gpts");
}

// Nodes that are vertices keep their numbers.
void MortarForm::find_vertices() {
  for (Node& node : owned_) node.slot = nodes().slot(node.global);
  for (std::vector<Anchor>& anchors : anchors_)
    for (Anchor& anchor : anchors) anchor.opposite.locate(nodes());
  if (parts_ == 1) return;
  const ContactNodes& from = nodes();
  const std::size_t width = at(from.per_facet);
  vertices_ = Vertices(from.global.size(), cuts_);
  places_ = {};
  places_.dim = dim_;
  places_.per_facet = static_cast<int>(corners_);
  for (std::size_t f = 0; f < from.secondary.size(); f += width)
    vertices_.add(&from.secondary[f], places_.secondary);
  for (std::size_t f = 0; f < from.primary.size(); f += width)
    vertices_.add(&from.primary[f], places_.primary);
  std::vector<int> corner;
  for (std::vector<Anchor>& anchors : anchors_)
    for (Anchor& anchor : anchors) {
      if (rigid() || !anchor.opposite.found()) continue;
      corner.clear();
      vertices_.add(anchor.opposite.slot.data(), corner);
      std::copy_n(&corner[corners_ * at(anchor.opposite.part)], corners_, anchor.opposite.slot.begin());
    }
  ContactValues store;
  places_.X = at_vertices(from.X, store);
  if (!from.start.empty()) places_.start = at_vertices(from.start, store);
}

void MortarForm::find_tangents(const std::vector<double>& X) {
  for (std::size_t f = 0; f < facets_.size(); ++f)
    facets_[f].map = make_face_map(face_of(X, consecutive(static_cast<int>(4 * f))));
  for (Node& node : owned_) {
    Point3 n{};
    for (const Incident& incident : node.facets) {
      const Facet& facet = facets_[at(incident.facet)];
      double area = 0;
      for (double part : facet.face.area) area += part;
      for (std::size_t k = 0; k < 3; ++k) n[k] += area * facet.map.normal[k];
    }
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(length > 0)) n = facets_[at(node.facets[0].facet)].map.normal; // both sides of a sheet
    if (length > 0)
      for (double& component : n) component /= length;
    const std::array<Point3, 2> tangents = tangents_of(n);
    for (Incident& incident : node.facets)
      incident.turn = turned_into(facets_[at(incident.facet)].map, n, tangents);
  }
}

std::pair<StateRow, std::size_t> MortarForm::constraint_row(const std::string& name, int components) const {
  return {StateRow{name, Support::vertex, components}, at(components) * nodal_area_.size()};
}

std::vector<MortarForm::FacetPoint> MortarForm::points_of(const Facet& facet) const {
  std::vector<FacetPoint> points;
  if (dim_ == 2) {
    // Three Gauss points: exact up to degree five, and for a plane whatever the ring.
    const MortarEdge& edge = facet.edge;
    for (const auto& [xi, weight] : std::array<std::array<double, 2>, 3>{
             {{-std::sqrt(0.6), 5.0 / 9}, {0, 8.0 / 9}, {std::sqrt(0.6), 5.0 / 9}}}) {
      FacetPoint& point = points.emplace_back();
      const std::array<double, 2> N = {(1 - xi) / 2, (1 + xi) / 2};
      const double area = weight * edge.length / 2 * (edge.ring[0] * N[0] + edge.ring[1] * N[1]);
      for (std::size_t a = 0; a < 2; ++a) {
        point.shape[a] = N[a];
        point.weight[a] = area * (edge.phi[a][0] * N[0] + edge.phi[a][1] * N[1]);
      }
    }
    return points;
  }
  // Exact up to degree four.
  const TriangleRule rule = triangle_rule(3);
  const MortarFace& face = facet.face;
  for (int t = 0; t < face.triangles(); ++t) {
    const TriangleWeights corner = triangle_weights(face.corners, t);
    for (std::size_t q = 0; q < rule.part.size(); ++q) {
      FacetPoint& point = points.emplace_back();
      for (std::size_t u = 0; u < 3; ++u)
        for (std::size_t a = 0; a < 4; ++a) point.shape[a] += rule.part[q][u] * corner[u][a];
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b)
          point.weight[a] += rule.weight[q] * face.area[at(t)] * face.phi[a][b] * point.shape[b];
    }
  }
  return points;
}

} // namespace impact
