#include <algorithm>
#include <cmath>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/boundary_data.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/rigid_bodies.hpp>
#include <limits>
#include <numeric>

/// Set-up of RigidBodies: which nodes, their mass, what is prescribed.
namespace impact {

namespace {

bool is_rigid(const Discretisation& d, const CellGroup& group) { return d.law(group).rigid(); }

// int N_a N_b rho over the cells of rigid materials, to a visitor (node a, node b, value).
template <class Visitor> void visit_masses(const Discretisation& d, Visitor&& visitor) {
  const auto rigid = [](const PointLaw& law) { return law.rigid(); };
  CellMatrix m;
  for_each_batch(d, rigid, [&](const CellBatch& batch) {
    const int nodes = batch.nodes();
    PointLaw law = batch.law;
    if (!(law.parameters.rho > 0)) law.parameters.rho = 1; // the volume then weighs
    batch.kernels.mass_matrix(law, batch.vectors(d.mesh.coordinates()).data(), m.zeroed(nodes));
    const int* node = batch_nodes(batch.group, batch.number);
    for (int l = 0; l < batch.used(); ++l)
      for (int i = 0; i < nodes; ++i)
        for (int j = 0; j < nodes; ++j) visitor(node[i * lanes + l], node[j * lanes + l], m(i, j)[l]);
  });
}

// Puts bodies into an order that does not depend on the partition, and numbers behind names that several
// have; answers with the new place of each.
std::vector<int> sort_bodies(std::vector<RigidBody>& bodies) {
  std::vector<int> order(bodies.size()), place(bodies.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const RigidBody &p = bodies[at(a)], &q = bodies[at(b)];
    if (p.name != q.name) return p.name < q.name;
    const double close = 1e-9 * (p.length + q.length);
    for (std::size_t k = 0; k < 3; ++k)
      if (std::abs(p.centre[k] - q.centre[k]) > close) return p.centre[k] < q.centre[k];
    return false;
  });
  std::vector<RigidBody> sorted;
  for (int b : order) {
    const std::string& name = bodies[at(b)].name;
    const auto same = [&](int other) { return bodies[at(other)].name == name; };
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(sorted.size()) + 1;
    place[at(b)] = static_cast<int>(sorted.size());
    sorted.push_back(bodies[at(b)]);
    if (std::count_if(order.begin(), order.end(), same) > 1)
      sorted.back().name += "_" + std::to_string(std::count_if(order.begin(), end, same));
  }
  bodies = std::move(sorted);
  return place;
}

} // namespace

RigidBodies::RigidBodies(const Discretisation& d, const std::vector<BoundaryCondition>& conditions,
                         double t_end)
    : comm_(d.mesh.comm()), dim_(d.dim()), frame_(d.frame), conditions_(conditions),
      body_of_node_(at(d.mesh.node_count()), -1), reduction_(d.dim()) {
  find_nodes(d);
  if (!empty()) {
    weigh(d);
    choose_slots(d);
  }
  resolve(d, t_end);
  if (empty()) return;
  // Rows that no unknown uses.
  std::vector<int> used;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    visit_unknowns(b, [&](int row, int, std::size_t component) {
      if (!reduction_.bodies()[b].held[component]) used.push_back(row);
    });
  std::sort(used.begin(), used.end());
  for (std::size_t i = 0; i < owned_; ++i)
    for (int k = 0; k < dim_; ++k)
      if (!std::binary_search(used.begin(), used.end(), row_[i] + k)) idle_.push_back(dim_ * node_[i] + k);
}

void RigidBodies::find_nodes(const Discretisation& d) {
  const bool any = std::any_of(d.materials.begin(), d.materials.end(),
                               [](const MaterialAssignment& m) { return m.law.rigid(); });
  if (!any) return;
  const Bodies parts = find_bodies(d.mesh);
  // Of each part: has rigid cells, has others, minus the first rigid material.
  const auto count = at(parts.count);
  std::vector<int> rigid(count, 0), other(count, 0), material(count, -std::numeric_limits<int>::max());
  std::vector<int> joined(count, -1); // a deformable material that a rigid one shares nodes with
  for (const CellGroup& group : d.groups)
    for (int node : group.node) {
      const auto part = at(parts.of_node[at(node)]);
      (is_rigid(d, group) ? rigid : other)[part] = 1;
      if (is_rigid(d, group))
        material[part] = std::max(material[part], -group.material);
      else
        joined[part] = std::max(joined[part], group.material);
    }
  for (std::vector<int>* flags : {&rigid, &other, &material, &joined}) max_over_ranks(comm_, *flags);
  const auto id = [&](int m) { return d.materials[at(m)].id; };
  for (std::size_t part = 0; part < count; ++part)
    if (rigid[part] && other[part])
      throw UserError(ExitCode::data, "-material_" + id(-material[part]) +
                                          "_model rigid: its cells share nodes with those of material " +
                                          id(joined[part]) +
                                          "; a rigid body stands by itself: give the two regions nodes of "
                                          "their own and let them meet in a contact");
  std::vector<int> body_of_part(count, -1);
  for (std::size_t part = 0; part < count; ++part) {
    if (!rigid[part]) continue;
    body_of_part[part] = static_cast<int>(bodies_.size());
    RigidBody& body = bodies_.emplace_back();
    body.component = static_cast<int>(part);
    body.name = id(-material[part]);
    body.held.fill(RigidBody::free_motion);
  }
  const PetscInt first_row = [&] {
    PetscInt start = 0;
    const Handle<Vec> any_vector = d.displacement.make_global();
    check(VecGetOwnershipRange(any_vector, &start, nullptr));
    return start;
  }();
  const auto X = d.mesh.coordinates();
  for (const bool owned : {true, false}) {
    for (int node = 0; node < d.mesh.node_count(); ++node) {
      const int body = body_of_part[at(parts.of_node[at(node)])];
      if (body < 0 || d.mesh.owned(node) != owned) continue;
      body_of_node_[at(node)] = body;
      node_.push_back(node);
      body_.push_back(body);
      row_.push_back(owned ? static_cast<int>(d.mesh.global_node()[at(node)] * dim_ - first_row) : -1);
      for (int k = 0; k < dim_; ++k) X_.push_back(X[at(node * dim_ + k)]);
    }
    if (owned) owned_ = node_.size();
  }
}

void RigidBodies::weigh(const Discretisation& d) {
  const auto dims = at(dim_);
  std::vector<double> mass = d.displacement.make_local();
  visit_masses(d, [&](int a, int, double m) { mass[dims * at(a)] += m; });
  add_up(d.displacement, mass);
  std::vector<double> sums(4 * bodies_.size(), 0.0);
  for (std::size_t i = 0; i < owned_; ++i) {
    mass_.push_back(mass[dims * at(node_[i])]);
    double* of_body = &sums[4 * at(body_[i])];
    for (std::size_t k = 0; k < dims; ++k) of_body[k] += mass_[i] * X_[dims * i + k];
    of_body[3] += mass_[i];
  }
  sum_over_ranks(comm_, sums);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].mass = sums[4 * b + 3];
    for (std::size_t k = 0; k < dims; ++k) bodies_[b].centre[k] = sums[4 * b + k] / bodies_[b].mass;
  }
  std::vector<double> first = d.displacement.make_local();
  const auto X = d.mesh.coordinates();
  visit_masses(d, [&](int a, int c, double m) {
    const Vector3& centre = bodies_[at(body_of_node_[at(a)])].centre;
    for (std::size_t k = 0; k < dims; ++k) first[dims * at(a) + k] += m * (X[dims * at(c) + k] - centre[k]);
  });
  add_up(d.displacement, first);
  std::vector<double> second(9 * bodies_.size(), 0.0);
  for (std::size_t i = 0; i < owned_; ++i) {
    const Vector3 Y = arm(i);
    for (std::size_t k = 0; k < dims; ++k) {
      first_.push_back(first[dims * at(node_[i]) + k]);
      for (std::size_t j = 0; j < dims; ++j) second[9 * at(body_[i]) + 3 * j + k] += Y[j] * first_.back();
    }
  }
  sum_over_ranks(comm_, second);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    RigidBody& body = bodies_[b];
    Matrix3& E = body.second;
    std::copy_n(&second[9 * b], 9, E.begin());
    for (std::size_t i = 0; i < 3; ++i) // symmetric but for rounding
      for (std::size_t j = 0; j < i; ++j) E[3 * i + j] = E[3 * j + i] = (E[3 * i + j] + E[3 * j + i]) / 2;
    const double size = trace(E);
    if (dim_ == 2) E[8] = size; // any number as large as the others
    if (!(determinant(E) / (size * size * size) > 1e-18))
      throw UserError(ExitCode::data, "-material_" + body.name + "_model rigid: the body around " +
                                          place_text(body.centre.data(), dim_) +
                                          " has no inertia against a rotation; mesh it with more cells");
    body.length = std::sqrt(size / body.mass);
  }
  const std::vector<int> place = sort_bodies(bodies_);
  for (int& body : body_) body = place[at(body)];
  for (int& body : body_of_node_)
    if (body >= 0) body = place[at(body)];
}

void RigidBodies::choose_slots(const Discretisation& d) {
  // The two lowest global nodes of each body.
  std::array<std::vector<double>, 2> lowest;
  slot_row_.assign(bodies_.size(), {-1, -1});
  for (std::size_t slot = 0; slot < 2; ++slot) {
    const auto global = [&](std::size_t i) { return double(d.mesh.global_node()[at(node_[i])]); };
    std::vector<double>& low = lowest[slot];
    low.assign(bodies_.size(), HUGE_VAL);
    for (std::size_t i = 0; i < owned_; ++i)
      if (const auto b = at(body_[i]); slot == 0 || global(i) > lowest[0][b])
        low[b] = std::min(low[b], global(i));
    min_over_ranks(comm_, low);
    for (std::size_t i = 0; i < owned_; ++i)
      if (global(i) == low[at(body_[i])]) slot_row_[at(body_[i])][slot] = row_[i];
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    RigidPlace& place = reduction_.bodies().emplace_back();
    place.slot = {static_cast<PetscInt>(lowest[0][b]), static_cast<PetscInt>(lowest[1][b])};
    place.length = bodies_[b].length;
    place.centre = bodies_[b].centre;
    Matrix3 J = bodies_[b].second;
    const double t = trace(J);
    for (std::size_t i = 0; i < 9; ++i) J[i] = ((i % 4 == 0 ? t : 0) - J[i]) / bodies_[b].mass;
    place.readiness = inverse(J);
  }
}

void RigidBodies::resolve(const Discretisation& d, double t_end) {
  if (frame_ == Frame::axisymmetric)
    for (RigidBody& body : bodies_) body.held[0] = body.held[5] = RigidBody::not_possible;
  for (std::size_t c = 0; c < conditions_.size(); ++c) {
    const BoundaryCondition& bc = conditions_[c];
    if (!prescribes_motion(bc.type)) continue;
    const bool turns = bc.rotation[0] || bc.rotation[1] || bc.rotation[2];
    if (bodies_.empty() && !turns) continue;
    std::vector<int> on(bodies_.size() + 1, 0);
    for (const std::string& name : bc.on) {
      if (d.mesh.find_group(name) == nullptr) continue; // BoundaryData has the message
      const std::vector<int> nodes = d.mesh.nodes(name);
      std::vector<int> here(bodies_.size(), 0);
      for (int node : nodes)
        if (const int body = body_of_node_[at(node)]; body >= 0) here[at(body)] = on.back() = 1;
      if (!bodies_.empty()) max_over_ranks(comm_, here);
      const int axis = bc.type == BcType::symmetry ? plane_axis(d.mesh, nodes) : -1;
      for (std::size_t b = 0; b < bodies_.size(); ++b) {
        if (!here[b]) continue;
        if (bc.type == BcType::acceleration)
          throw UserError(ExitCode::data, "-bc_" + bc.id + "_type acceleration: not for the rigid body " +
                                              bodies_[b].name + "; prescribe its displacement or velocity");
        for (std::size_t k = 0; k < 6; ++k) {
          bool holds = false;
          if (dim_ == 2 && k != 0 && k != 1 && k != 5) continue;
          const auto normal = at(std::max(axis, 0));
          if (bc.type == BcType::fix)
            holds = true;
          else if (bc.type == BcType::symmetry && axis >= 0)
            holds = k < 3 ? k == normal : k - 3 != normal;
          else
            holds = k < 3 ? bc.component[k].has_value() : bc.rotation[k - 3].has_value();
          int& held = bodies_[b].held[k];
          if (!holds || held == RigidBody::not_possible) continue;
          if (held >= 0)
            shared_.push_back({b, k, held, static_cast<int>(c)});
          else
            held = static_cast<int>(c);
        }
      }
    }
    on.back() = max_over_ranks(comm_, on.back());
    if (turns && on.back() == 0)
      throw UserError(ExitCode::data, "-bc_" + bc.id +
                                          "_rz: rotations are for rigid bodies, and no node of " +
                                          bc.on.front() +
                                          " belongs to one; give a material "
                                          "-material_<id>_model rigid, or prescribe displacements");
  }
  for (const double t : {0.0, t_end}) require_agreement(t, t);
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for (std::size_t k = 0; k < 6; ++k)
      reduction_.bodies()[b].held[k] = bodies_[b].held[k] != RigidBody::free_motion;
}

void RigidBodies::declare_state(StateTable& table) {
  if (empty()) return;
  const auto size = static_cast<int>(7 * bodies_.size());
  row_state_ = &table.add(StateRow{"rigid", Support::global, size}, at(size));
}

std::vector<std::pair<PetscInt, PetscInt>> RigidBodies::couplings() const {
  std::vector<std::pair<PetscInt, PetscInt>> pairs;
  for (const RigidPlace& place : reduction_.bodies()) pairs.emplace_back(place.slot[0], place.slot[1]);
  return pairs;
}

} // namespace impact
