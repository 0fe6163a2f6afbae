#include <algorithm>
#include <cmath>
#include <impact/input/spelling.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/foundations.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <petscblaslapack.h>
#include <stdexcept>

namespace impact {

namespace {

int mode_count(Frame frame) { return frame == Frame::solid ? 6 : frame == Frame::axisymmetric ? 1 : 3; }

// Component k of each rigid motion at a place x from the centre of the body, rotations over its size.
void rigid_modes(Frame frame, const double* x, int k, double* mode) {
  std::fill(mode, mode + mode_count(frame), 0.0);
  if (frame == Frame::axisymmetric) {
    mode[0] = k == 1 ? 1 : 0;
    return;
  }
  mode[k] = 1;
  if (is_flat(frame)) {
    mode[2] = k == 0 ? -x[1] : x[0];
    return;
  }
  // Rotation about axis j: e_j x x.
  const int next = (k + 1) % 3, last = (k + 2) % 3;
  mode[3 + next] = x[last];
  mode[3 + last] = -x[next];
}

std::string rounded(double value, double scale) {
  return text_of("%.4g", std::abs(value) < 1e-9 * scale ? 0.0 : value);
}

// Eigenvalues by rising size with their unit vectors, of a small symmetric matrix [n][n].
struct Eigen {
  double value;
  std::vector<double> vector;
};

std::vector<Eigen> eigen_of(std::vector<double> A, int size) {
  const auto n = at(size);
  std::vector<double> values(n), work(34 * n);
  const auto order = static_cast<PetscBLASInt>(size), room = static_cast<PetscBLASInt>(work.size());
  PetscBLASInt failed = 0;
  LAPACKsyev_("V", "U", &order, A.data(), &order, values.data(), work.data(), &room, &failed);
  if (failed != 0) throw std::runtime_error("LAPACK finds no eigenvalues of the motions of a body");
  std::vector<Eigen> pairs;
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<double> vector(A.begin() + static_cast<std::ptrdiff_t>(i * n),
                               A.begin() + static_cast<std::ptrdiff_t>((i + 1) * n));
    // Of the two directions the one whose largest component is positive.
    const auto largest = *std::max_element(
        vector.begin(), vector.end(), [](double x, double y) { return std::abs(x) < std::abs(y) - 1e-9; });
    if (largest < 0)
      for (double& component : vector) component = -component;
    pairs.push_back({values[i], std::move(vector)});
  }
  return pairs;
}

// Vectors that span the null space of a symmetric, positive semidefinite matrix [n][n].
std::vector<std::vector<double>> null_space(const std::vector<double>& matrix, int n) {
  const std::vector<Eigen> pairs = eigen_of(matrix, n);
  std::vector<std::vector<double>> vectors;
  // Two held nodes at a distance h in a body of size L give the eigenvalue (h/L)^2; rounding gives 1e-16.
  for (const Eigen& pair : pairs)
    if (pair.value <= 1e-13 * pairs.back().value) vectors.push_back(pair.vector);
  return vectors;
}

constexpr const char* axis_name[3] = {"x", "y", "z"};

// Rotations among the null vectors in space. A null vector whose rotation is zero is a translation; the
// rotations' span is that of the vectors' last three entries.
void name_rotations(const std::vector<std::vector<double>>& null, std::size_t rotations,
                    std::vector<std::string>& motions) {
  std::vector<double> product(9, 0.0); // sum of r r^T over the null vectors
  for (const std::vector<double>& v : null)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) product[3 * i + j] += v[3 + i] * v[3 + j];
  const std::vector<Eigen> pairs = eigen_of(product, 3);
  std::size_t named = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    double share = 0; // of the axis in the span of the last vectors
    for (std::size_t r = 3 - rotations; r < 3; ++r) share += pairs[r].vector[k] * pairs[r].vector[k];
    if (share < 1 - 1e-9) continue;
    motions.push_back(std::string("rotation about ") + axis_name[k]);
    ++named;
  }
  if (named == rotations) return;
  const std::vector<double>& axis = pairs.back().vector;
  if (rotations == 1)
    motions.push_back("rotation about the direction (" + rounded(axis[0], 1) + ", " + rounded(axis[1], 1) +
                      ", " + rounded(axis[2], 1) + ")");
  else
    motions.push_back(std::to_string(rotations - named) + " more rotation" +
                      (rotations - named > 1 ? "s" : "") + " about oblique axes");
}

std::vector<std::string> name_motions(Frame frame, const std::vector<double>& gram,
                                      const std::array<double, 3>& centre, double size) {
  const int modes = mode_count(frame);
  const std::vector<std::vector<double>> null = null_space(gram, modes);
  std::vector<std::string> motions;
  if (null.empty()) return motions;
  if (frame == Frame::axisymmetric) return {"translation in y, along the axis"};
  // Prescribed dofs lie along the axes: a translation is free exactly where its component is prescribed
  // nowhere.
  const int dim = frame == Frame::solid ? 3 : 2;
  for (int k = 0; k < dim; ++k)
    if (gram[at(k * modes + k)] == 0) motions.push_back(std::string("translation in ") + axis_name[k]);
  const std::size_t translations = motions.size();
  if (null.size() == translations) return motions;
  if (dim == 3) {
    name_rotations(null, null.size() - translations, motions);
  } else if (translations == 0) {
    const std::vector<double>& v = null.front(); // vanishes at x - centre = size (-v_1, v_0) / v_2
    motions.push_back("rotation about (" + rounded(centre[0] - size * v[1] / v[2], size) + ", " +
                      rounded(centre[1] + size * v[0] / v[2], size) + ")");
  } else {
    motions.push_back("rotation");
  }
  return motions;
}

struct Geometry {
  std::vector<std::array<double, 3>> centre; // [body]
  std::vector<double> size;                  // [body] largest distance of a node from the centre
};

Geometry measure(const Mesh& mesh, const Bodies& bodies) {
  const auto dim = at(mesh.dim()), count = at(bodies.count);
  std::vector<double> sum(4 * count, 0.0);
  const auto X = mesh.coordinates();
  for (int i = 0; i < mesh.node_count(); ++i) {
    if (!mesh.owned(i)) continue;
    const auto node = at(i);
    double* of_body = &sum[4 * at(bodies.of_node[node])];
    for (std::size_t k = 0; k < dim; ++k) of_body[k] += X[node * dim + k];
    of_body[3] += 1;
  }
  sum_over_ranks(mesh.comm(), sum);
  Geometry g{std::vector<std::array<double, 3>>(count), std::vector<double>(count, 0.0)};
  for (std::size_t b = 0; b < count; ++b)
    for (std::size_t k = 0; k < 3; ++k) g.centre[b][k] = sum[4 * b + k] / sum[4 * b + 3];
  for (std::size_t node = 0; node < at(mesh.node_count()); ++node) {
    const auto b = at(bodies.of_node[node]);
    double distance = 0;
    for (std::size_t k = 0; k < dim; ++k) distance = std::hypot(distance, X[node * dim + k] - g.centre[b][k]);
    g.size[b] = std::max(g.size[b], distance);
  }
  max_over_ranks(mesh.comm(), g.size);
  return g;
}

// [body][mode][mode]: sum over the prescribed dofs and the places on foundations of the modes' products
// there. Its null space are the rigid motions that nothing of it feels.
std::vector<double> gram_matrices(const Discretisation& d, const BoundaryData& boundary, const Bodies& bodies,
                                  const Geometry& geometry, const RigidBodies& rigid) {
  const int modes = mode_count(d.frame), dim = d.dim();
  const auto n = at(modes);
  std::vector<double> gram(at(bodies.count) * n * n, 0.0);
  const auto add = [&](std::size_t b, const double* mode) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) gram[(b * n + i) * n + j] += mode[i] * mode[j];
  };
  const auto hold = [&](int node, const double* place, const double* direction) {
    const auto b = at(bodies.of_node[at(node)]);
    double x[3] = {0, 0, 0}, mode[6], along[6] = {};
    for (int k = 0; k < dim; ++k) x[k] = (place[k] - geometry.centre[b][at(k)]) / geometry.size[b];
    for (int k = 0; k < dim; ++k) {
      rigid_modes(d.frame, x, k, mode);
      for (int i = 0; i < modes; ++i) along[i] += direction[k] * mode[i];
    }
    add(b, along);
  };
  for (const FixedDof& fixed : boundary.fixed()) {
    const int node = fixed.dof / dim;
    Vector3 direction{};
    direction[at(fixed.component)] = 1;
    if (d.mesh.owned(node)) hold(node, &d.mesh.coordinates()[at(node * dim)], direction.data());
  }
  Foundations(d, boundary).visit_held(hold);
  sum_over_ranks(d.mesh.comm(), gram);
  // What is prescribed of a rigid body belongs to its centre of mass.
  for (const RigidBody& body : rigid.bodies()) {
    const auto b = at(body.component);
    double x[3], mode[6] = {};
    for (std::size_t k = 0; k < 3; ++k) x[k] = (body.centre[k] - geometry.centre[b][k]) / geometry.size[b];
    for (std::size_t c = 0; c < 6; ++c) {
      if (body.held[c] < 0 || (c < 3 && c >= at(dim))) continue;
      std::fill(mode, mode + 6, 0.0);
      if (c < 3)
        rigid_modes(d.frame, x, static_cast<int>(c), mode);
      else
        mode[dim == 3 ? c : 2] = 1;
      add(b, mode);
    }
  }
  return gram;
}

// [body] names of the regions that hold cells of it.
std::vector<std::string> name_regions(const Mesh& mesh, const Bodies& bodies) {
  std::vector<std::string> regions(at(bodies.count));
  for (const Group& group : mesh.groups()) {
    if (group.dim != mesh.dim()) continue;
    std::vector<int> holds(at(bodies.count), 0);
    for (int node : mesh.nodes(group.name)) holds[at(bodies.of_node[at(node)])] = 1;
    max_over_ranks(mesh.comm(), holds);
    for (std::size_t b = 0; b < regions.size(); ++b)
      if (holds[b]) regions[b] += (regions[b].empty() ? "" : ", ") + group.name;
  }
  return regions;
}

// [body] 1 where a side of a contact that sees its other side at u = 0 belongs to it.
std::vector<int> touched_bodies(const Discretisation& d, const Bodies& bodies, const ContactSet& contacts) {
  std::vector<int> touched(at(bodies.count), 0);
  const Handle<Vec> undeformed = d.displacement.make_global();
  for (const ContactInterface& contact : contacts) {
    const ContactSettings& settings = contact.settings();
    const ContactReach reach = contact.reach(undeformed);
    if (std::isinf(reach.gap) && std::isinf(reach.distance)) continue;
    for (const std::string& side : {settings.secondary, settings.primary, settings.carrier})
      if (!side.empty() && !ContactSettings::rigid_name(side))
        for (int node : d.mesh.nodes(side)) touched[at(bodies.of_node[at(node)])] = 1;
  }
  max_over_ranks(d.mesh.comm(), touched);
  return touched;
}

} // namespace

std::vector<FreeBody> find_free_bodies(const Discretisation& d, const BoundaryData& boundary,
                                       const ContactSet& contacts, const RigidBodies& rigid) {
  const Bodies bodies = find_bodies(d.mesh);
  const Geometry geometry = measure(d.mesh, bodies);
  const std::vector<double> gram = gram_matrices(d, boundary, bodies, geometry, rigid);
  const auto entries = static_cast<std::ptrdiff_t>(mode_count(d.frame) * mode_count(d.frame));
  std::vector<FreeBody> free;
  for (std::size_t b = 0; b < at(bodies.count); ++b) {
    const auto start = gram.begin() + static_cast<std::ptrdiff_t>(b) * entries;
    std::vector<std::string> motions =
        name_motions(d.frame, {start, start + entries}, geometry.centre[b], geometry.size[b]);
    if (motions.empty()) continue;
    free.push_back(
        {"", geometry.centre[b], std::move(motions), false, static_cast<int>(b), geometry.size[b]});
  }
  if (free.empty()) return free;
  const std::vector<std::string> regions = name_regions(d.mesh, bodies);
  const std::vector<int> touched = touched_bodies(d, bodies, contacts);
  for (FreeBody& body : free) {
    body.regions = regions[at(body.number)];
    body.touched = touched[at(body.number)] != 0;
  }
  return free;
}

std::string describe(const FreeBody& body, int dim) {
  return "the body of region " + body.regions + " around " + place_text(body.centre.data(), dim);
}

std::string free_axis(const Discretisation& d, const BoundaryData& boundary, const RigidBodies& rigid) {
  if (d.frame != Frame::axisymmetric) return "";
  const double on_axis = 1e-6 * d.mesh.smallest_edge();
  double lowest = HUGE_VAL;
  int count = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    const double* x = &d.mesh.coordinates()[at(2 * node)];
    const bool held =
        boundary.fixed_mask()[at(2 * node)] != 0 || (!rigid.empty() && rigid.body_of_node()[at(node)] >= 0);
    if (!d.mesh.owned(node) || x[0] > on_axis || held) continue;
    lowest = std::min(lowest, x[1]);
    ++count;
  }
  count = sum_over_ranks(d.mesh.comm(), count);
  lowest = min_over_ranks(d.mesh.comm(), lowest);
  return count == 0
             ? ""
             : text_of("%d nodes on the axis of symmetry may leave it, the lowest at y=%.4g: no condition "
                       "holds their ux; give -bc_<id>_ux 0 on a group with all of them",
                       count, lowest);
}

std::vector<std::string> require_held_bodies(const Discretisation& d, const BoundaryData& boundary,
                                             const ContactSet& contacts, const RigidBodies& rigid) {
  std::vector<std::string> warnings;
  for (const FreeBody& body : find_free_bodies(d, boundary, contacts, rigid)) {
    const std::string who = describe(body, d.dim()), motions = join(body.motions);
    if (!body.touched)
      throw UserError(ExitCode::data,
                      "-ts_type static: " + who + " is not held against " + motions +
                          "; no contact sees anything near it: prescribe displacements on it "
                          "(-bcs, -bc_<id>_on, -bc_<id>_type), bring what shall hold it within "
                          "-contact_<id>_search_radius, or keep the inertia (-ts_type newmark)");
    warnings.push_back(who + " is held by contact alone against " + motions +
                       "; where that does not hold it, a step fails, or any place of it will do: prescribe "
                       "displacements on it then, or "
                       "keep the inertia (-ts_type newmark)");
  }
  return warnings;
}

} // namespace impact
