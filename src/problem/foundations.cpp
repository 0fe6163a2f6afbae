#include "facet_loop.hpp"
#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/entries.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/foundations.hpp>
#include <utility>

namespace impact {

namespace {

// [DMPlex cell point minus the first one] the group it is in.
std::vector<int> groups_of_cells(const Discretisation& d) {
  std::vector<int> group_of(at(d.mesh.cell_count()), -1);
  for (std::size_t g = 0; g < d.groups.size(); ++g)
    for (const PetscInt cell : d.groups[g].cell_point)
      group_of[at(cell - d.mesh.cell_start())] = static_cast<int>(g);
  return group_of;
}

// N dA_0 of a point: the force of a unit tension, by all shape functions together.
Vector3 area_vector(const FacetPlaces& n, const FacetPoint& p, Frame frame) {
  const int dim = dimension(frame);
  FacetVector force{};
  add_follower_pressure(p, n.count, frame, n.X.data(), -1, force.data(), nullptr);
  Vector3 sum{};
  for (int i = 0; i < n.count * dim; ++i) sum[at(i % dim)] += force[at(i)];
  return sum;
}

Vector3 value_at(const FacetPlaces& n, const FacetPoint& p, int dim, const std::vector<double>& nodal) {
  Vector3 value{};
  for (int a = 0; a < n.count; ++a)
    for (int k = 0; k < dim; ++k) value[at(k)] += p.N[a] * nodal[at(n.node[at(a)] * dim + k)];
  return value;
}

void add_to_nodes(const FacetPlaces& n, const FacetPoint& p, int dim, double factor, const Vector3& traction,
                  FacetVector& load) {
  for (int i = 0; i < n.count * dim; ++i) load[at(i)] += factor * p.N[i / dim] * traction[at(i % dim)];
}

// The area of a facet over the trace of its mass.
double area_by_diagonal(const FacetPlaces& n, Frame frame) {
  double area = 0, trace = 0;
  for (int q = 0; q < facet_points(dimension(frame), n.count); ++q) {
    const FacetPoint p = facet_point(dimension(frame), n.count, q);
    const double here = reference_area(p, n.count, frame, n.X.data());
    area += here;
    for (int a = 0; a < n.count; ++a) trace += here * p.N[a] * p.N[a];
  }
  return area / trace;
}

} // namespace

Foundations::Foundations(const Discretisation& discretisation, const BoundaryData& boundary)
    : d_(discretisation), X_(d_.mesh.coordinates().begin(), d_.mesh.coordinates().end()) {
  if (!boundary.has(BcType::foundation) && !boundary.has(BcType::absorbing)) return;
  empty_ = false;
  const std::vector<int> group_of_cell = groups_of_cells(d_);
  int damps = 0;
  agree_on_errors(d_.mesh.comm(), [&] {
    for (const LoadedFacets& load : boundary.foundations())
      surfaces_.push_back(make_surface(load, boundary, group_of_cell));
  });
  for (const Surface& surface : surfaces_)
    for (const Point& point : surface.points) {
      damps = damps != 0 || point.dashpot.any() ? 1 : 0;
      for (const double k : {point.spring.normal, point.spring.across})
        if (k > 0) softest_ = std::min(softest_, k);
    }
  softest_ = min_over_ranks(d_.mesh.comm(), softest_);
  damps_ = max_over_ranks(d_.mesh.comm(), damps) > 0;
  if (damps_ && d_.lumped_mass) make_dampers();
}

Foundations::Surface Foundations::make_surface(const LoadedFacets& load, const BoundaryData& boundary,
                                               std::span<const int> group_of_cell) const {
  const BoundaryCondition& bc = boundary.conditions()[at(load.condition)];
  Surface surface{load.condition, load.facets, std::vector<Point>(at(load.facets.count()) * max_facet_nodes)};
  const auto value = [&](const std::optional<Expression>& of, const double* x) {
    return of ? (*of)(x, d_.dim(), 0) : 0.0;
  };
  visit_facets(
      load.facets, d_.dim(), X_, nullptr,
      [&](const FacetPlaces& n, const FacetPoint& p, std::size_t i, const double* x) {
        const PetscInt cell = load.facets.cell_point[i / max_facet_nodes];
        const CellGroup& group = d_.groups[at(group_of_cell[at(cell - d_.mesh.cell_start())])];
        const MaterialAssignment& material = d_.materials[at(group.material)];
        if (material.law.rigid() || material.erosion.on)
          throw UserError(ExitCode::data,
                          "-bc_" + bc.id + "_on: springs and dashpots hold surfaces of bodies that deform; " +
                              (material.law.rigid()
                                   ? "the material " + material.id + " is rigid; hold it by other types"
                                   : "cells of the material " + material.id +
                                         " may leave their body (-material_" + material.id +
                                         "_erosion); choose a surface of other cells"));
        Point& point = surface.points[i];
        point.area = reference_area(p, n.count, d_.frame, n.X.data());
        const Vector3 along = area_vector(n, p, d_.frame);
        if (length(along) > 0) point.normal = unit(along); // else on the axis, where there is no area
        if (bc.type == BcType::absorbing) {
          point.dashpot = impedance(d_.law(group));
          return;
        }
        point.spring = {value(bc.stiffness[0], x), value(bc.stiffness[1], x)};
        point.dashpot = {value(bc.damping[0], x), value(bc.damping[1], x)};
      },
      [](const FacetPlaces&) {});
  return surface;
}

// rho c of the waves of the law at rest; those of sheets are free to change their thickness.
Foundations::Stiffness Foundations::impedance(const PointLaw& law) const {
  const MaterialParameters& m = law.parameters;
  const double modulus =
      d_.frame == Frame::plane_stress ? 4 * m.G * (3 * m.K + m.G) / (3 * m.K + 4 * m.G) : m.K + 4 * m.G / 3;
  return {std::sqrt(m.rho * modulus), std::sqrt(m.rho * m.G)};
}

Vector3 Foundations::resist(const Stiffness& by, const Vector3& normal, const Vector3& w) {
  const double along = (by.normal - by.across) * dot(normal, w);
  return {by.across * w[0] + along * normal[0], by.across * w[1] + along * normal[1],
          by.across * w[2] + along * normal[2]};
}

template <class Body, class Done> void Foundations::visit(Body&& body, Done&& done) const {
  for (const Surface& surface : surfaces_)
    visit_facets(
        surface.facets, d_.dim(), X_, nullptr,
        [&](const FacetPlaces& n, const FacetPoint& p, std::size_t i, const double* x) {
          body(surface, n, p, surface.points[i], x);
        },
        [&](const FacetPlaces& n) { done(n); });
}

double Foundations::add_springs(const std::vector<double>& u, double sign, std::vector<double>& force) const {
  if (!springs()) return 0;
  FacetVector load{};
  double energy = 0;
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint& p, const Point& point, const double*) {
        if (!point.spring.any()) return;
        const Vector3 moved = value_at(n, p, d_.dim(), u),
                      traction = resist(point.spring, point.normal, moved);
        energy += point.area * dot(moved, traction) / 2;
        add_to_nodes(n, p, d_.dim(), -sign * point.area, traction, load);
      },
      [&](const FacetPlaces& n) { scatter(n, d_.dim(), load, force); });
  return energy;
}

void Foundations::add_dashpots(const std::vector<double>& v, double sign, std::vector<double>& force) const {
  const auto dim = at(d_.dim());
  for (const auto& [node, C] : dampers_)
    for (std::size_t i = 0; i < dim; ++i)
      for (std::size_t j = 0; j < dim; ++j)
        force[at(node) * dim + i] -= sign * C[3 * i + j] * v[at(node) * dim + j];
  if (d_.lumped_mass) return;
  FacetVector load{};
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint& p, const Point& point, const double*) {
        if (!point.dashpot.any()) return;
        add_to_nodes(n, p, d_.dim(), -sign * point.area,
                     resist(point.dashpot, point.normal, value_at(n, p, d_.dim(), v)), load);
      },
      [&](const FacetPlaces& n) { scatter(n, d_.dim(), load, force); });
}

void Foundations::add_tangent(double slope, const std::vector<char>& held, Mat matrix) const {
  const int dim = d_.dim();
  std::array<double, 9 * max_facet_nodes * max_facet_nodes> K{};
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint& p, const Point& point, const double*) {
        const Stiffness all{point.spring.normal + slope * point.dashpot.normal,
                            point.spring.across + slope * point.dashpot.across};
        const int rows = n.count * dim;
        for (int j = 0; j < dim; ++j) {
          Vector3 way{};
          way[at(j)] = point.area;
          const Vector3 traction = resist(all, point.normal, way);
          for (int i = 0; i < rows; ++i)
            for (int b = 0; b < n.count; ++b)
              K[at(i * rows + b * dim + j)] += p.N[i / dim] * p.N[b] * traction[at(i % dim)];
        }
      },
      [&](const FacetPlaces& n) { add_block(n, dim, held, d_.mesh.global_node(), K, matrix); });
}

void Foundations::add_resultants(const std::vector<double>& u, const std::vector<double>& v,
                                 std::vector<Vector3>& sums) const {
  visit(
      [&](const Surface& surface, const FacetPlaces& n, const FacetPoint& p, const Point& point,
          const double*) {
        Vector3& sum = sums[at(surface.condition)];
        const auto add = [&](const Stiffness& by, const std::vector<double>& nodal) {
          const Vector3 traction = resist(by, point.normal, value_at(n, p, d_.dim(), nodal));
          for (std::size_t k = 0; k < 3; ++k) sum[k] -= point.area * traction[k];
        };
        add(point.spring, u);
        if (!v.empty()) add(point.dashpot, v);
      },
      [](const FacetPlaces&) {});
}

// x . K x = sum of k dA (sum_a N_a x_a)^2, at most that of k dA sum_b |N_b| sum_a |N_a| |x_a|^2.
double Foundations::frequency(Vec lumped_mass) const {
  if (!springs()) return 0;
  std::vector<double> felt = d_.scalar.make_local();
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint& p, const Point& point, const double*) {
        double sum = 0;
        for (int a = 0; a < n.count; ++a) sum += std::abs(p.N[a]);
        sum *= point.area * std::max(point.spring.normal, point.spring.across);
        for (int a = 0; a < n.count; ++a) felt[at(n.node[at(a)])] += std::abs(p.N[a]) * sum;
      },
      [](const FacetPlaces&) {});
  add_up(d_.scalar, felt);
  const std::vector<double> mass = d_.local_of(lumped_mass);
  double largest = 0;
  for (int node = 0; node < d_.mesh.node_count(); ++node)
    if (const double stiffness = felt[at(node)]; stiffness > 0 && d_.mesh.owned(node))
      largest = std::max(largest, stiffness / mass[at(node * d_.dim())]);
  return max_over_ranks(d_.mesh.comm(), largest);
}

// A node's share of a facet is by the diagonal of its mass, as cells of second order lump theirs, so that
// none is zero or negative.
void Foundations::make_dampers() {
  const auto dim = at(d_.dim());
  const FieldLayout layout(d_.mesh, "dampers", d_.dim() * d_.dim());
  std::vector<double> C = layout.make_local();
  double factor = 0;
  bool entered = false; // the facet at hand
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint& p, const Point& point, const double*) {
        if (!std::exchange(entered, true)) factor = area_by_diagonal(n, d_.frame);
        for (int a = 0; a < n.count; ++a) {
          double* block = &C[at(n.node[at(a)]) * dim * dim];
          for (std::size_t j = 0; j < dim; ++j) {
            Vector3 way{};
            way[j] = factor * point.area * p.N[a] * p.N[a];
            const Vector3 column = resist(point.dashpot, point.normal, way);
            for (std::size_t k = 0; k < dim; ++k) block[k * dim + j] += column[k];
          }
        }
      },
      [&](const FacetPlaces&) { entered = false; });
  add_up(layout, C);
  for (int node = 0; node < d_.mesh.node_count(); ++node) {
    const double* block = &C[at(node) * dim * dim];
    if (!d_.mesh.owned(node) || std::all_of(block, block + dim * dim, [](double c) { return c == 0; }))
      continue;
    Damper& damper = dampers_.emplace_back(Damper{node, {}});
    for (std::size_t i = 0; i < dim * dim; ++i) damper.C[3 * (i / dim) + i % dim] = block[i];
  }
}

void Foundations::damp(const Rates& rates, Vec lumped_mass, const std::vector<char>& fixed, Vec a,
                       Vec external, Vec damping) const {
  if (dampers_.empty()) return;
  const auto dim = at(d_.dim());
  const double half = rates.dt / 2, of_start = rates.a_n != nullptr ? half : 0;
  PetscInt first = 0;
  double *after = nullptr, *loads = nullptr, *by_dashpots = nullptr;
  check(VecGetOwnershipRange(a, &first, nullptr));
  const Entries mass(lumped_mass), v(rates.v_n), before(rates.a_n != nullptr ? rates.a_n : rates.v_n);
  check(VecGetArray(a, &after));
  check(VecGetArray(external, &loads));
  check(VecGetArray(damping, &by_dashpots));
  for (const auto& [node, C] : dampers_) {
    const auto row = at(d_.mesh.global_node()[at(node)] * d_.dim() - first);
    Vector3 speed{}, push{};
    Matrix3 M = unit_matrix;
    std::array<bool, 3> free{};
    for (std::size_t k = 0; k < dim; ++k) {
      free[k] = fixed[at(node) * dim + k] == 0;
      speed[k] = v[row + k] + of_start * before[row + k] + (free[k] ? 0 : half * after[row + k]);
    }
    const Vector3 drag = C * speed;
    for (std::size_t k = 0; k < dim; ++k) {
      if (!free[k]) continue;
      push[k] = mass[row + k] * after[row + k] - drag[k];
      for (std::size_t j = 0; j < dim; ++j)
        M[3 * k + j] = (j == k ? mass[row + k] : 0) + (free[j] ? half * C[3 * k + j] : 0);
    }
    const Vector3 gained = inverse(M) * push;
    for (std::size_t k = 0; k < dim; ++k) {
      if (!free[k]) continue;
      after[row + k] = gained[k];
      speed[k] += half * gained[k];
    }
    const Vector3 at_end = C * speed;
    for (std::size_t k = 0; k < dim; ++k) {
      loads[row + k] -= at_end[k];
      by_dashpots[row + k] = -at_end[k];
    }
  }
  check(VecRestoreArray(a, &after));
  check(VecRestoreArray(external, &loads));
  check(VecRestoreArray(damping, &by_dashpots));
}

void Foundations::visit_held(
    const std::function<void(int node, const double* x, const double* direction)>& body) const {
  visit(
      [&](const Surface&, const FacetPlaces& n, const FacetPoint&, const Point& point, const double* x) {
        const bool along = point.spring.normal > 0 || point.dashpot.normal > 0,
                   across = point.spring.across > 0 || point.dashpot.across > 0;
        const Vector3& N = point.normal;
        if (along) body(n.node[0], x, N.data());
        if (!across) return;
        const Vector3 other = std::abs(N[2]) < 0.5 ? Vector3{0, 0, 1} : Vector3{1, 0, 0},
                      first = unit(cross(other, N)), second = cross(N, first);
        body(n.node[0], x, first.data());
        if (d_.dim() == 3) body(n.node[0], x, second.data());
      },
      [](const FacetPlaces&) {});
}

} // namespace impact
