#include <algorithm>
#include <cmath>
#include <impact/contact/facet_parts.hpp>
#include <impact/contact/surface.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/handle.hpp>
#include <impact/petsc/ranks.hpp>
#include <numbers>
#include <numeric>

namespace impact {

namespace {

std::string boundary_names(const Mesh& mesh) {
  std::string names;
  for (const Group& group : mesh.groups())
    if (group.dim == mesh.dim() - 1) names += (names.empty() ? "" : ", ") + group.name;
  return names.empty() ? "none" : names;
}

} // namespace

double longest_side(const double* corner, int corners, int dim) {
  double largest = 0;
  for (int a = 0; a < corners; ++a) {
    const double *x = corner + dim * a, *y = corner + dim * ((a + 1) % corners);
    double square = 0;
    for (int k = 0; k < dim; ++k) square += (x[k] - y[k]) * (x[k] - y[k]);
    largest = std::max(largest, square);
  }
  return std::sqrt(largest);
}

int stored_nodes(const Mesh& mesh) {
  if (mesh.dim() == 2) return mesh.order() + 1;
  return mesh.order() == 1 ? 4 : mesh.has_shape(Shape::hex27) ? 9 : mesh.has_shape(Shape::hex20) ? 8 : 6;
}

ContactSurface make_surface(const Mesh& mesh, const std::string& contact, const std::string& group) {
  const Group* found = mesh.find_group(group);
  if (found == nullptr || found->dim != mesh.dim() - 1)
    throw UserError(ExitCode::data, "contact " + contact + ": no boundary `" + group +
                                        "` in the mesh; boundaries are: " + boundary_names(mesh));
  mesh.require_outside("contact " + contact + ": boundary", group);
  ContactSurface surface = surface_of(mesh, group, mesh.facets(group));
  if (sum_over_ranks(mesh.comm(), surface.count()) == 0)
    throw UserError(ExitCode::data, "contact " + contact + ": boundary `" + group + "` has no facets");
  return surface;
}

ContactSurface surface_of(const Mesh& mesh, const std::string& group, const FacetTable& facets) {
  ContactSurface surface;
  const int dim = mesh.dim();
  surface.group = group;
  surface.per_facet = stored_nodes(mesh);
  for (int f = 0; f < facets.count(); ++f) {
    const int* nodes = &facets.connectivity[at(facets.nodes_per_facet * f)];
    const std::size_t first = surface.X.size();
    const int last = facets.nodes_per_facet - 1;
    const bool wide = surface.per_facet > 6 && (last == 5 || nodes[last] == nodes[last - 1]);
    for (int a = 0; a < surface.per_facet; ++a) {
      const int node = nodes[wide ? triangle_in_slot[at(a)] : std::min(a, last)];
      surface.local.push_back(node);
      surface.node.push_back(mesh.global_node()[at(node)]);
      const auto place = mesh.coordinates().begin() + dim * node;
      surface.X.insert(surface.X.end(), place, place + dim);
    }
    surface.length.push_back(longest_side(&surface.X[first], stored_corners(surface.per_facet), dim));
    const PetscInt* cone = nullptr;
    check(DMPlexGetCone(mesh.dm(), facets.point[at(f)], &cone));
    surface.reversed.push_back(dim != 2 || cone[0] == mesh.point(nodes[0]) ? 0 : 1);
  }
  return surface;
}

GaussRule gauss_rule(int points) {
  GaussRule rule;
  const auto order = static_cast<unsigned>(points);
  for (int i = 0; i < points; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (points + 0.5));
    double slope = 1;
    for (int it = 0; it < 100; ++it) {
      slope = points * (x * std::legendre(order, x) - std::legendre(order - 1, x)) / (x * x - 1);
      const double step = std::legendre(order, x) / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    rule.xi.push_back(x);
    rule.weight.push_back(2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

TriangleRule triangle_rule(int points) {
  TriangleRule rule;
  const auto three = [&](double near, double weight) {
    for (std::size_t v = 0; v < 3; ++v) {
      std::array<double, 3>& part = rule.part.emplace_back();
      part.fill((1 - near) / 2);
      part[v] = near;
      rule.weight.push_back(weight);
    }
  };
  switch (points) {
  case 1:
    rule.part.push_back({1.0 / 3, 1.0 / 3, 1.0 / 3});
    rule.weight.push_back(1);
    return rule;
  case 2: // degree two
    three(2.0 / 3, 1.0 / 3);
    return rule;
  case 3: // degree four (Dunavant 1985)
    three(0.108103018168070, 0.223381589678011);
    three(0.816847572980459, 0.109951743655322);
    return rule;
  }
  // The rule of a quadrilateral of which one side has shrunk to a corner.
  const GaussRule line = gauss_rule(points);
  for (std::size_t i = 0; i < line.xi.size(); ++i)
    for (std::size_t j = 0; j < line.xi.size(); ++j) {
      const double r = (1 + line.xi[i]) / 2, s = (1 + line.xi[j]) / 2;
      rule.part.push_back({(1 - r) * (1 - s), r * (1 - s), s});
      rule.weight.push_back(line.weight[i] * line.weight[j] * (1 - s) / 2);
    }
  return rule;
}

std::vector<GlobalFacet> facets_at_owned_nodes(const Mesh& mesh, const ContactSurface& surface) {
  std::vector<GlobalFacet> mine; // [facet][node] the facet, which travels to the node's owner
  for (int f = 0; f < surface.count(); ++f) {
    GlobalFacet nodes;
    for (int a = 0; a < static_cast<int>(nodes.size()); ++a)
      nodes[at(a)] = surface.node[at(surface.per_facet * f + std::min(a, surface.per_facet - 1))];
    mine.insert(mine.end(), at(surface.per_facet), nodes);
  }
  PetscLayout layout = nullptr;
  check(PetscLayoutCreate(mesh.comm(), &layout));
  check(PetscLayoutSetLocalSize(layout, mesh.owned_node_count()));
  check(PetscLayoutSetUp(layout));
  Handle<PetscSF> sf;
  check(PetscSFCreate(mesh.comm(), sf.out()));
  check(PetscSFSetGraphLayout(sf, layout, static_cast<PetscInt>(mine.size()), nullptr, PETSC_OWN_POINTER,
                              surface.node.data()));
  check(PetscLayoutDestroy(&layout));
  const PetscInt* degree = nullptr; // [owned node] facets that meet there
  check(PetscSFComputeDegreeBegin(sf, &degree));
  check(PetscSFComputeDegreeEnd(sf, &degree));
  std::vector<GlobalFacet> facets(at(std::accumulate(degree, degree + mesh.owned_node_count(), 0)));
  MPI_Datatype whole = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(static_cast<int>(std::tuple_size_v<GlobalFacet>), MPIU_INT, &whole);
  MPI_Type_commit(&whole);
  check(PetscSFGatherBegin(sf, whole, mine.data(), facets.data()));
  check(PetscSFGatherEnd(sf, whole, mine.data(), facets.data()));
  MPI_Type_free(&whole);
  std::sort(facets.begin(), facets.end());
  facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
  return facets;
}

std::vector<PetscInt> surface_neighbours(const FieldLayout& layout, const ContactSurface& surface) {
  if (surface.per_facet != 2) return std::vector<PetscInt>(at(2 * surface.count()), -1);
  // The far node of an edge is left at its other node: as a sum, with a count beside it, so that a node where
  // more than one edge starts or ends is recognised. Node numbers are exact in a double.
  const Handle<Vec> sum = layout.make_global(), count = layout.make_global();
  std::vector<double> far = layout.make_local(), edges = layout.make_local();
  for (int f = 0; f < surface.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const std::size_t slot =
          at(2 * surface.local[at(2 * f + a)] + 1 - a); // 0: edge before the node, 1: edge after
      far[slot] += static_cast<double>(surface.node[at(2 * f + 1 - a)]);
      edges[slot] += 1;
    }
  layout.add_to_global(far, sum);
  layout.add_to_global(edges, count);
  layout.to_local(sum, far);
  layout.to_local(count, edges);
  std::vector<PetscInt> neighbours;
  for (int f = 0; f < surface.count(); ++f)
    for (int a = 0; a < 2; ++a) {
      const std::size_t slot = at(2 * surface.local[at(2 * f + a)] + a);
      neighbours.push_back(edges[slot] == 1 ? static_cast<PetscInt>(far[slot]) : -1);
    }
  return neighbours;
}

} // namespace impact
