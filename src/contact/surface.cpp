#include <cmath>
#include <impact/contact/surface.hpp>
#include <impact/petsc/error.hpp>
#include <numbers>

namespace impact {

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string boundary_names(const Mesh& mesh) {
  std::string names;
  for (const Group& group : mesh.groups())
    if (group.dim == mesh.dim() - 1) names += (names.empty() ? "" : ", ") + group.name;
  return names.empty() ? "none" : names;
}

} // namespace

ContactSurface make_surface(const Mesh& mesh, const std::string& contact, const std::string& group) {
  if (mesh.dim() != 2)
    throw UserError(ExitCode::data, "contact " + contact +
                                        ": needs a plane or axisymmetric mesh; this one has dimension " +
                                        std::to_string(mesh.dim()));
  const Group* found = mesh.find_group(group);
  if (found == nullptr || found->dim != 1)
    throw UserError(ExitCode::data, "contact " + contact + ": no boundary `" + group +
                                        "` in the mesh; boundaries are: " + boundary_names(mesh));
  const FacetTable facets = mesh.facets(group);
  ContactSurface surface;
  surface.group = group;
  surface.local = facets.connectivity;
  for (int f = 0; f < facets.count(); ++f) {
    const int* nodes = &facets.connectivity[at(2 * f)];
    for (int a = 0; a < 2; ++a) {
      surface.node.push_back(mesh.global_node()[at(nodes[a])]);
      for (int k = 0; k < 2; ++k) surface.X.push_back(mesh.coordinates()[at(2 * nodes[a] + k)]);
    }
    const double* X = &surface.X[at(4 * f)];
    surface.length.push_back(std::hypot(X[2] - X[0], X[3] - X[1]));
    const PetscInt* cone = nullptr;
    check(DMPlexGetCone(mesh.dm(), facets.point[at(f)], &cone));
    surface.reversed.push_back(cone[0] == mesh.vertex_point(nodes[0]) ? 0 : 1);
  }
  int mine = surface.count(), all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_SUM, mesh.comm());
  if (all == 0)
    throw UserError(ExitCode::data, "contact " + contact + ": boundary `" + group + "` has no facets");
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

SurfacePoints make_points(const ContactSurface& surface, const std::string& contact, int per_facet,
                          Frame frame) {
  if (per_facet < 1 || per_facet > 16)
    throw UserError(ExitCode::usage, "-contact_" + contact + "_points " + std::to_string(per_facet) +
                                         ": allowed are 1 to 16 points per facet");
  const GaussRule rule = gauss_rule(per_facet);
  SurfacePoints points;
  points.per_facet = per_facet;
  for (int f = 0; f < surface.count(); ++f)
    for (int q = 0; q < per_facet; ++q) {
      const double xi = surface.reversed[at(f)] ? -rule.xi[at(q)] : rule.xi[at(q)];
      const double N0 = (1 - xi) / 2, N1 = (1 + xi) / 2;
      const double* X = &surface.X[at(4 * f)];
      const double ring = frame == Frame::axisymmetric ? 2 * std::numbers::pi * (N0 * X[0] + N1 * X[2]) : 1;
      points.shape.push_back(N0);
      points.shape.push_back(N1);
      points.weight.push_back(rule.weight[at(q)] * surface.length[at(f)] / 2 * ring);
    }
  return points;
}

std::vector<PetscInt> surface_neighbours(const FieldLayout& layout, const ContactSurface& surface) {
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
