#include <algorithm>
#include <array>
#include <cmath>
#include <impact/input/spelling.hpp>
#include <impact/input/units.hpp>
#include <impact/math/index.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/surface_load.hpp>
#include <map>
#include <set>

namespace impact {

namespace {

constexpr const char* axis_name[3] = {"x", "y", "z"};

// Gauss-Legendre on [0,1], 5 points.
constexpr std::array<double, 5> gauss_x = {0.04691007703066800, 0.23076534494715845, 0.5, 0.76923465505284155,
                                           0.95308992296933200};
constexpr std::array<double, 5> gauss_w = {0.11846344252809454, 0.23931433524968324, 0.28444444444444444,
                                           0.23931433524968324, 0.11846344252809454};

const Group& require_group(const Mesh& mesh, const BoundaryCondition& bc, const std::string& name) {
  const Group* group = mesh.find_group(name);
  if (group == nullptr)
    throw UserError(ExitCode::data,
                    "-bc_" + bc.id + "_on \"" + name +
                        "\": no such physical group; mesh has: " + groups_text(mesh.groups()));
  return *group;
}

} // namespace

std::string groups_text(const std::vector<Group>& groups) {
  std::vector<std::string> text;
  for (int dim = 3; dim >= 0; --dim) {
    std::vector<std::string> names;
    for (const Group& group : groups)
      if (group.dim == dim) names.push_back(group.name);
    if (!names.empty()) text.push_back(join(names) + " (" + std::to_string(dim) + "D)");
  }
  return text.empty() ? "none" : join(text, "; ");
}

int plane_axis(const Mesh& mesh, const std::vector<int>& nodes) {
  const int dim = mesh.dim();
  std::array<double, 3> low, high;
  low.fill(1e300);
  high.fill(-1e300);
  for (int node : nodes)
    for (int k = 0; k < dim; ++k) {
      const double x = mesh.coordinates()[at(node * dim + k)];
      low[at(k)] = std::min(low[at(k)], x);
      high[at(k)] = std::max(high[at(k)], x);
    }
  min_over_ranks(mesh.comm(), low);
  max_over_ranks(mesh.comm(), high);
  const double tolerance = 1e-8 * mesh.smallest_edge();
  for (int k = 0; k < dim; ++k)
    if (high[at(k)] - low[at(k)] <= tolerance) return k;
  return -1;
}

double integral(const Expression& rate, const double* x, int dim, double t0, double t1) {
  double sum = 0;
  for (std::size_t q = 0; q < gauss_x.size(); ++q)
    sum += gauss_w[q] * (t1 - t0) * rate(x, dim, t0 + gauss_x[q] * (t1 - t0));
  return sum;
}

// body(number, condition, group) for all groups of the conditions whose type is wanted.
template <class Wanted, class Body>
void BoundaryData::visit_groups(const Mesh& mesh, Wanted&& wanted, Body&& body) const {
  for (std::size_t c = 0; c < conditions_.size(); ++c)
    if (const BoundaryCondition& bc = conditions_[c]; wanted(bc.type))
      for (const std::string& name : bc.on) body(static_cast<int>(c), bc, require_group(mesh, bc, name));
}

BoundaryData::BoundaryData(const Mesh& mesh, std::vector<BoundaryCondition> conditions, double t_end,
                           std::span<const int> body_of_node, PlaneBody plane)
    : dim_(mesh.dim()), node_count_(mesh.node_count()), smallest_edge_(mesh.smallest_edge()),
      x_(mesh.coordinates().begin(), mesh.coordinates().end()), conditions_(std::move(conditions)),
      fixed_mask_(at(node_count_ * dim_), 0), force_area_(conditions_.size(), 0.0) {
  resolve_fixed(mesh, body_of_node);
  resolve_loads(mesh, plane);
  damage_condition_ = resolve_held(mesh, BcType::damage);
  temperature_condition_ = resolve_held(mesh, BcType::temperature);
  agree_on_errors(mesh.comm(), [&] {
    for (double t : {0.0, t_end}) require_agreement(0, t, {}, {});
  });
}

void BoundaryData::require_agreement(double t0, double t1, const std::vector<double>& u_n,
                                     const std::vector<double>& v_n) const {
  // Rounding is no conflict: of sums over many steps, and of values that pass through zero.
  const auto compare = [&](int first, int second, const std::string& what, int node, double a, double b,
                           double scale) {
    if (std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b)) + 1e-12 * scale) return;
    std::string place;
    for (int k = 0; k < dim_; ++k) place += (k ? ", " : "") + number_text(x_[at(node * dim_ + k)]);
    throw UserError(ExitCode::data, "-bc_" + conditions_[at(first)].id + " and -bc_" +
                                        conditions_[at(second)].id + " prescribe different " + what + " (" +
                                        number_text(a) + ", " + number_text(b) + " at t=" + number_text(t1) +
                                        ") on a common node at (" + place + "); leave it out of one of them");
  };
  for (const auto& [one, other] : shared_dofs_) {
    const auto i = at(one.dof);
    const double u = u_n.empty() ? 0 : u_n[i], v = v_n.empty() ? 0 : v_n[i];
    compare(one.condition, other.condition, std::string("u") + axis_name[one.component], one.dof / dim_,
            prescribed(one, t0, t1, u, v), prescribed(other, t0, t1, u, v), smallest_edge_);
  }
  for (const SharedValue& shared : shared_values_) {
    const double* x = &x_[at(shared.node * dim_)];
    compare(shared.first, shared.second,
            conditions_[at(shared.first)].type == BcType::damage ? "phi" : "temperatures", shared.node,
            scalar_value(shared.first, x, t1), scalar_value(shared.second, x, t1), 1);
  }
}

// [node] the first condition of this type on it; others must agree.
std::vector<int> BoundaryData::resolve_held(const Mesh& mesh, BcType type) {
  std::vector<int> holder(at(node_count_), -1);
  visit_groups(
      mesh, [type](BcType other) { return other == type; },
      [&](int c, const BoundaryCondition&, const Group& group) {
        for (int node : mesh.nodes(group.name)) {
          int& first = holder[at(node)];
          if (first < 0) first = c;
          if (first != c) shared_values_.push_back({node, first, c});
        }
      });
  return holder;
}

void BoundaryData::resolve_fixed(const Mesh& mesh, std::span<const int> body_of_node) {
  std::map<int, FixedDof> chosen;
  visit_groups(mesh, prescribes_motion, [&](int c, const BoundaryCondition& bc, const Group& group) {
    const std::vector<int> nodes = mesh.nodes(group.name);
    const int axis = bc.type == BcType::symmetry ? plane_axis(mesh, nodes) : -1;
    if (bc.type == BcType::symmetry && axis < 0)
      throw UserError(ExitCode::data,
                      "-bc_" + bc.id + "_type symmetry: group \"" + group.name +
                          "\" is not one plane normal to a coordinate axis; two such planes are held by a "
                          "condition each, and an inclined one by type foundation with a large stiffness");
    for (int node : nodes) {
      if (!body_of_node.empty() && body_of_node[at(node)] >= 0) continue;
      for (int k = 0; k < dim_; ++k) {
        if (bc.type != BcType::fix && k != axis && !bc.component[k]) continue;
        const FixedDof mine{node * dim_ + k, c, k};
        const auto [where, inserted] = chosen.emplace(mine.dof, mine);
        if (!inserted && where->second.condition != c) shared_dofs_.emplace_back(where->second, mine);
      }
    }
  });
  for (const auto& [dof, fixed] : chosen) {
    fixed_.push_back(fixed);
    fixed_mask_[at(dof)] = 1;
  }
}

void BoundaryData::resolve_loads(const Mesh& mesh, PlaneBody plane) {
  const auto loads = [](BcType type) {
    return type == BcType::body_force || type == BcType::traction || type == BcType::pressure ||
           type == BcType::force || type == BcType::heat_flux || type == BcType::convection ||
           gives_way(type);
  };
  std::map<int, std::set<PetscInt>> loaded; // [condition] facets
  visit_groups(mesh, loads, [&](int c, const BoundaryCondition& bc, const Group& group) {
    if (bc.type == BcType::body_force) {
      std::vector<int>& mine = body_nodes_[c];
      const std::vector<int> before = std::move(mine), more = mesh.nodes(group.name);
      mine.clear();
      std::ranges::set_union(before, more, std::back_inserter(mine));
      return;
    }
    if (bc.type == BcType::force && group.dim < dim_ - 1) {
      if (require_group(mesh, bc, bc.on.front()).dim != group.dim)
        throw UserError(ExitCode::data, "-bc_" + bc.id + "_on \"" + bc.on.front() + "," + group.name +
                                            "\": points, lines and boundaries share no force; "
                                            "give each a condition of its own");
      if (group.name != bc.on.front()) return; // all at once
      const std::vector<double> shares = mesh.node_shares(bc.on);
      for (int node = 0; node < node_count_; ++node)
        if (const double share = shares[at(node)]; share > 0) {
          nodal_forces_.push_back({node, c, share});
          force_area_[at(c)] += share;
        }
      return;
    }
    if (group.dim != dim_ - 1)
      throw UserError(ExitCode::data, "-bc_" + bc.id + "_on \"" + group.name +
                                          "\": a load acts on a boundary (" + std::to_string(dim_ - 1) +
                                          "D), this group is " + std::to_string(group.dim) +
                                          "D; mesh has: " + groups_text(mesh.groups()));
    if (bc.type == BcType::pressure || gives_way(bc.type))
      mesh.require_outside("-bc_" + bc.id + "_on", group.name);
    // What lies in several groups of a condition is loaded once.
    std::set<PetscInt>& before = loaded[c];
    const FacetTable all = mesh.facets(group.name);
    LoadedFacets load{c, all.without([&](std::size_t f) { return before.contains(all.point[f]); })};
    before.insert(all.point.begin(), all.point.end());
    force_area_[at(c)] += area_of(load.facets, dim_ == 3 ? Frame::solid : plane.frame, x_);
    (is_thermal(bc.type)           ? heat_fluxes_
     : bc.type == BcType::pressure ? pressures_
     : gives_way(bc.type)          ? foundations_
                                   : tractions_)
        .push_back(std::move(load));
  });
  if (!force_area_.empty()) sum_over_ranks(mesh.comm(), force_area_);
  for (std::size_t c = 0; c < conditions_.size(); ++c)
    if (conditions_[c].type == BcType::force && !(force_area_[c] > 0))
      throw UserError(ExitCode::data, "-bc_" + conditions_[c].id +
                                          "_on: has no area to carry a force, as what lies on the axis; give "
                                          "the force to points of it");
  if (dim_ == 2 && is_flat(plane.frame))
    for (double& area : force_area_) area *= plane.thickness;
}

double BoundaryData::prescribed(const FixedDof& fixed, double t0, double t1, double u_n, double v_n) const {
  const BoundaryCondition& bc = conditions_[at(fixed.condition)];
  if (!bc.component[fixed.component]) return 0; // fix, symmetry
  const Expression& data = *bc.component[fixed.component];
  const double* x = &x_[at(fixed.dof / dim_ * dim_)];
  if (bc.type == BcType::displacement) return data(x, dim_, t1);
  const double dt = t1 - t0;
  double sum = 0;
  for (std::size_t q = 0; q < gauss_x.size(); ++q) {
    const double s = t0 + gauss_x[q] * dt;
    const double weight = gauss_w[q] * dt * (bc.type == BcType::acceleration ? t1 - s : 1.0);
    sum += weight * data(x, dim_, s);
  }
  return u_n + (bc.type == BcType::acceleration ? v_n * dt : 0.0) + sum;
}

void BoundaryData::set_displacement(double t0, double t1, const std::vector<double>& u_n,
                                    const std::vector<double>& v_n, std::vector<double>& u) const {
  for (const FixedDof& fixed : fixed_) {
    const auto i = at(fixed.dof);
    u[i] = prescribed(fixed, t0, t1, u_n[i], v_n[i]);
  }
}

void BoundaryData::set_exact_velocity(double t0, double t1, const std::vector<double>& v_n,
                                      std::vector<double>& v) const {
  for (const FixedDof& fixed : fixed_)
    if (const auto i = at(fixed.dof); has_acceleration(fixed)) v[i] = exact_velocity(fixed, t0, t1, v_n[i]);
}

double BoundaryData::exact_velocity(const FixedDof& fixed, double t0, double t1, double v_n) const {
  if (!has_acceleration(fixed)) return v_n;
  const Expression& data = *conditions_[at(fixed.condition)].component[fixed.component];
  return v_n + integral(data, &x_[at(fixed.dof / dim_ * dim_)], dim_, t0, t1);
}

void BoundaryData::set_initial_rates(double start, double dt, std::vector<double>& v,
                                     std::vector<double>& a) const {
  for (const FixedDof& fixed : fixed_) {
    const BoundaryCondition& bc = conditions_[at(fixed.condition)];
    const auto i = at(fixed.dof);
    const bool given = static_cast<bool>(bc.component[fixed.component]);
    a[i] = 0;
    if (!given || bc.type != BcType::acceleration) v[i] = 0;
    if (!given) continue;
    const Expression& data = *bc.component[fixed.component];
    const double* x = &x_[at(fixed.dof / dim_ * dim_)];
    auto value = [&](double t) { return data(x, dim_, start + t); };
    // One-sided second-order differences over a small part of the step: data may begin at the start.
    const double h = 1e-3 * dt;
    if (bc.type == BcType::displacement) {
      const double f0 = value(0), f1 = value(h), f2 = value(2 * h), f3 = value(3 * h);
      v[i] = (-3 * f0 + 4 * f1 - f2) / (2 * h);
      a[i] = (2 * f0 - 5 * f1 + 4 * f2 - f3) / (h * h);
      // Below the round-off of the second difference the data are straight.
      const double noise = 64 * 2.3e-16 * std::max({std::abs(f0), std::abs(f1), std::abs(f2), std::abs(f3)});
      if (std::abs(a[i]) * h * h <= noise) a[i] = 0;
    } else if (bc.type == BcType::velocity) {
      v[i] = value(0);
      a[i] = (-3 * value(0) + 4 * value(h) - value(2 * h)) / (2 * h);
    } else {
      a[i] = value(0);
    }
  }
}

void BoundaryData::smooth_velocity(double start, double dt, std::vector<double>& v) const {
  for (const FixedDof& fixed : fixed_) {
    const BoundaryCondition& bc = conditions_[at(fixed.condition)];
    if (!bc.component[fixed.component]) continue;
    const double* x = &x_[at(fixed.dof / dim_ * dim_)];
    const auto value = [&](double part) {
      return (*bc.component[fixed.component])(x, dim_, start + part * dt);
    };
    // the third derivative of the displacement, times dt^2
    const double jerk = bc.type == BcType::displacement
                            ? 27 * (value(1) - 3 * value(2. / 3) + 3 * value(1. / 3) - value(0)) / dt
                        : bc.type == BcType::velocity ? 4 * (value(1) - 2 * value(0.5) + value(0))
                                                      : (4 * value(0.5) - 3 * value(0) - value(1)) * dt;
    v[at(fixed.dof)] -= jerk / 12;
  }
}

void BoundaryData::set_held(const std::vector<int>& holder, double t, std::vector<double>& field) const {
  for (std::size_t node = 0; node < field.size(); ++node)
    if (const int c = holder[node]; c >= 0) field[node] = scalar_value(c, &x_[node * at(dim_)], t);
}

std::vector<int> BoundaryData::heat_sources() const {
  std::vector<int> sources;
  for (std::size_t c = 0; c < conditions_.size(); ++c)
    if (conditions_[c].type == BcType::heat_source) sources.push_back(static_cast<int>(c));
  return sources;
}

double BoundaryData::scalar_value(int condition, const double* x, double t) const {
  return (*conditions_[at(condition)].value)(x, dim_, t);
}

double BoundaryData::ambient_temperature(int condition, const double* x, double t) const {
  const double value = scalar_value(condition, x, t);
  if (value > 0) return value;
  throw UserError(ExitCode::data, "-bc_" + conditions_[at(condition)].id + "_value: " +
                                      std::to_string(value) + " K around the body at t=" + std::to_string(t) +
                                      "; temperatures are absolute and positive");
}

double BoundaryData::heat_coefficient(int condition, const double* x, double t) const {
  const BoundaryCondition& bc = conditions_[at(condition)];
  const double h = bc.coefficient ? (*bc.coefficient)(x, dim_, t) : 0.0;
  if (h >= 0) return h;
  throw UserError(ExitCode::data, "-bc_" + bc.id + "_h: is " + std::to_string(h) +
                                      " at t=" + std::to_string(t) +
                                      "; allowed: >= 0; heat flows from the warmer side to the colder");
}

bool BoundaryData::has_data() const {
  return std::any_of(conditions_.begin(), conditions_.end(), [](const BoundaryCondition& bc) {
    return bc.type != BcType::fix && bc.type != BcType::symmetry && !gives_way(bc.type);
  });
}

bool BoundaryData::has(BcType type) const {
  return std::any_of(conditions_.begin(), conditions_.end(),
                     [=](const BoundaryCondition& bc) { return bc.type == type; });
}

bool BoundaryData::body_force(double t, std::vector<double>& f) const {
  if (!has(BcType::body_force)) return false;
  f.assign(at(node_count_ * dim_), 0.0);
  for (const auto& [condition, nodes] : body_nodes_) add_body_force(condition, t, f);
  return true;
}

void BoundaryData::add_body_force(int condition, double t, std::vector<double>& f) const {
  for (int k = 0; k < dim_; ++k)
    if (const auto& data = conditions_[at(condition)].component[k])
      for (int node : body_nodes_.at(condition))
        f[at(node * dim_ + k)] += (*data)(&x_[at(node * dim_)], dim_, t);
}

void BoundaryData::add_nodal_forces(double t, std::vector<double>& f) const {
  for (const NodalForce& load : nodal_forces_) {
    const auto c = at(load.condition);
    for (int k = 0; k < dim_; ++k)
      if (const auto& data = conditions_[c].component[k])
        f[at(load.node * dim_ + k)] +=
            load.share / force_area_[c] * (*data)(&x_[at(load.node * dim_)], dim_, t);
  }
}

void BoundaryData::traction(const LoadedFacets& load, const double* x, double t, double* value) const {
  const auto c = at(load.condition);
  const BoundaryCondition& bc = conditions_[c];
  const double share = bc.type == BcType::force ? 1 / force_area_[c] : 1;
  for (int k = 0; k < dim_; ++k) value[k] = bc.component[k] ? share * (*bc.component[k])(x, dim_, t) : 0.0;
}

} // namespace impact
