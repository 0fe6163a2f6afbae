#include <algorithm>
#include <cmath>
#include <impact/contact/mortar_form.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <numbers>

/// Construction of a MortarForm: its facets, their functions and tangents, points against a rigid body.
namespace impact {

namespace {

FaceCorners face_of(const std::vector<double>& X, int facet) { // [facet][corner][3]
  FaceCorners corner;
  for (std::size_t a = 0; a < 4; ++a) std::copy_n(&X[3 * (at(4 * facet) + a)], 3, corner[a].begin());
  return corner;
}

} // namespace

MortarForm::MortarForm(const FormRequest& request)
    : ContactForm(request), dim_(request.mesh.dim()), corners_(at(request.secondary.per_facet)),
      frame_(request.frame), node_count_(at(request.mesh.node_count())) {
  const Mesh& mesh = request.mesh;
  const FieldLayout& layout = request.layout;
  const ContactSurface& secondary = request.secondary;
  find_facets(mesh, secondary);
  std::vector<PetscInt> nodes;
  for (const Facet& facet : facets_)
    nodes.insert(nodes.end(), facet.node.begin(), facet.node.begin() + secondary.per_facet);
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
  for (int f = 0; f < static_cast<int>(facets_.size()); ++f) {
    const Facet& facet = facets_[at(f)];
    const std::array<double, 4> area = measure(f, X);
    for (int a = 0; a < facet.corners; ++a)
      if (facet.owned[at(a)] >= 0) owned_[at(facet.owned[at(a)])].weight += area[at(a)];
  }
  std::vector<double> area = layout.make_local();
  for (const Node& node : owned_) area[at(dim_ * node.local)] = node.weight;
  const Handle<Vec> owned_area = layout.make_global();
  layout.to_global(area, owned_area);
  layout.to_local(owned_area, area);
  for (std::size_t node = 0; node < node_count_; ++node) nodal_area_.push_back(area[at(dim_) * node]);
  if (dim_ == 3 && frictional()) find_tangents(X);
  search_ = PairSearch(mesh, layout, nodes, X, request.primary,
                       {settings_.search_radius, settings_.local_search}, what_it_meets(settings_));
  facing_.resize(facets_.size());
  switches_.resize(facets_.size());
}

// Reference sizes and functions of a facet whose corners are in X [facet][corner][dim]; its nodal areas.
std::array<double, 4> MortarForm::measure(int f, const std::vector<double>& X) {
  Facet& facet = facets_[at(f)];
  std::array<double, 4> area{}; // both kinds of functions have the integrals of N
  if (dim_ == 2) {
    const double* x = &X[at(4 * f)];
    MortarEdge& edge = facet.edge;
    double square = 0;
    for (std::size_t k = 0; k < 2; ++k) square += (x[k] - x[2 + k]) * (x[k] - x[2 + k]);
    edge.length = std::sqrt(square);
    if (frame_ == Frame::axisymmetric) edge.ring = {2 * std::numbers::pi * x[0], 2 * std::numbers::pi * x[2]};
    const auto phi = dual_functions(edge);
    for (std::size_t i = 0; i < 2; ++i) std::copy(phi[i].begin(), phi[i].end(), facet.dual[i].begin());
    for (std::size_t i = 0; i < 2; ++i) area[i] = edge.length * (2 * edge.ring[i] + edge.ring[1 - i]) / 6;
  } else {
    const FaceCorners corner = face_of(X, f);
    facet.face = make_mortar_face(corner, false);
    facet.dual = make_mortar_face(corner, true).phi;
    area = nodal_areas(corner);
  }
  if (rigid()) { // which covers everything
    // To a round obstacle a node counts nearer than it is, by h^2/12R in each direction of the surface: the
    // dual functions of a facet of the side h take the integral of x^2 for -h^2/6.
    if (settings_.multipliers == MultiplierSpace::dual) set_functions(facet, facet.dual);
    facet.points = points_of(facet);
    for (const FacetPoint& point : facet.points)
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) facet.onto.D[a][b] += point.weight[a] * point.shape[b];
    facet.onto.M = facet.onto.D;
  }
  return area;
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
    facet.corners = secondary.per_facet == 2 ? 2 : nodes[3] == nodes[2] ? 3 : 4;
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

void MortarForm::find_tangents(const std::vector<double>& X) {
  for (std::size_t f = 0; f < facets_.size(); ++f)
    facets_[f].map = make_face_map(face_of(X, static_cast<int>(f)));
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
  return {StateRow{name, Support::vertex, components}, at(components) * node_count_};
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
