#include <algorithm>
#include <cmath>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <impact/solve/loose_bodies.hpp>
#include <span>

namespace impact {

namespace {

// Gaps of less than this part of a facet are closed.
constexpr double closed = 1e-6;
// What a body may approach by beyond its gap, in units of the shortest facet of its contacts' sides.
constexpr double bite = 0.25;
// How much deeper than force over E and width bodies with flat sides may be squeezed.
constexpr double squeeze = 3;
// A body counts as balanced when its resultant has fallen to this part of the largest one of the solve.
constexpr double balanced = 0.05;
// Least stiffness of the hold over E times the size of the body: motions that nothing feels get a pivot.
constexpr double least_stiffness = 1e-7;
// Of small loads it is no more than this part of what the largest resultant asks for.
constexpr double least_weight = 1e-3;

// [local node] reference volume (area in the plane, of the full ring with its symmetry), all ranks' shares.
std::vector<double> nodal_volumes(const Discretisation& d) {
  std::vector<double> volume(d.node_values(1));
  CellMatrix m;
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    const int nodes = batch.nodes();
    PointLaw unit = batch.law;
    unit.parameters.rho = 1;
    batch.kernels.mass_matrix(unit, batch.vectors(d.mesh.coordinates()).data(), m.zeroed(nodes));
    auto sum = batch.zero(1);
    for (int i = 0; i < nodes; ++i)
      for (int j = 0; j < nodes; ++j) sum.value[i] += m(i, j);
    batch.scatter(sum, volume);
  });
  add_up(d.scalar, volume);
  return volume;
}

} // namespace

LooseBodies::LooseBodies(const Discretisation& d, const BoundaryData& boundary, const ContactSet& contacts,
                         const RigidBodies& rigid)
    : d_(&d), contacts_(&contacts), rigid_(&rigid), fixed_(boundary.fixed_mask()) {
  if (contacts.empty()) return;
  const Bodies bodies = find_bodies(d.mesh);
  std::vector<int> place(at(bodies.count), -1);
  for (const FreeBody& free : find_free_bodies(d, boundary, contacts, rigid)) {
    place[at(free.number)] = static_cast<int>(bodies_.size());
    Body body;
    body.name = describe(free, d.dim());
    body.centre = free.centre;
    body.size = free.size;
    for (std::size_t r = 0; r < rigid.bodies().size(); ++r)
      if (rigid.bodies()[r].component == free.number) {
        body.rigid = static_cast<int>(r);
        body.centre = rigid.bodies()[r].centre;
      }
    bodies_.push_back(std::move(body));
  }
  if (bodies_.empty()) return;
  std::vector<int> loose;
  for (int body : bodies.of_node) loose.push_back(place[at(body)]);
  measure(loose);
}

void LooseBodies::measure(const std::vector<int>& loose) {
  const Mesh& mesh = d_->mesh;
  const auto dim = at(d_->dim());
  const std::vector<double> volume = nodal_volumes(*d_);
  std::vector<char> surface(loose.size(), 0);
  for (std::size_t c = 0; c < contacts_->size(); ++c) {
    const ContactSettings& settings = (*contacts_)[c].settings();
    // [body] by its secondary, its primary side; the last one stands for all that is held
    std::vector<std::array<int, 2>> meets(bodies_.size() + 1, {0, 0});
    double shortest = HUGE_VAL;
    if (settings.carrier.empty() && settings.rigid()) meets.back()[1] = 1;
    for (const std::string& side : {settings.secondary, settings.primary}) {
      if (ContactSettings::rigid_name(side)) continue;
      const ContactSurface facets = make_surface(mesh, settings.id, side);
      for (std::size_t i = 0; i < facets.local.size(); ++i) {
        const auto node = at(facets.local[i]);
        surface[node] = 1;
        shortest = std::min(shortest, facets.length[i / at(facets.per_facet)]);
        const auto b = loose[node] < 0 ? bodies_.size() : at(loose[node]);
        meets[b][side == settings.secondary ? 0 : 1] = 1;
      }
    }
    if (!settings.carrier.empty())
      for (int node : mesh.nodes(settings.carrier)) {
        surface[at(node)] = 1;
        meets[loose[at(node)] < 0 ? bodies_.size() : at(loose[at(node)])][1] = 1;
      }
    shortest = min_over_ranks(mesh.comm(), shortest);
    const std::span<int> all(meets.front().data(), 2 * meets.size());
    max_over_ranks(mesh.comm(), all);
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (const auto [secondary, primary] = meets[b]; secondary + primary > 0) {
        const bool held = (secondary > 0 && meets.back()[1] > 0) || (primary > 0 && meets.back()[0] > 0);
        bodies_[b].sides.push_back({c, double(secondary - primary), held});
        bodies_[b].facet = std::min(bodies_[b].facet, shortest);
      }
  }
  std::vector<double> sums(2 * bodies_.size(), 0.0);
  for (std::size_t node = 0; node < loose.size(); ++node) {
    if (loose[node] < 0 || !mesh.owned(static_cast<int>(node))) continue;
    const auto b = at(loose[node]);
    nodes_.push_back({static_cast<int>(node), loose[node], volume[node], surface[node] != 0});
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) {
      const double arm = mesh.coordinates()[dim * node + k] - bodies_[b].centre[k];
      square += arm * arm;
    }
    sums[2 * b] += volume[node];
    sums[2 * b + 1] += volume[node] * square;
  }
  sum_over_ranks(mesh.comm(), sums);
  const double modulus = d_->softest_modulus();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    body.volume = sums[2 * b];
    body.inertia = sums[2 * b + 1];
    body.floor = std::isfinite(modulus) ? least_stiffness * modulus / (body.size * body.size) : 0;
  }
}

void LooseBodies::start_solve() {
  stride_ = 1;
  limited_ = false;
  norm_ = HUGE_VAL;
  for (Body& body : bodies_) body.blind = 0;
}

void LooseBodies::start_attempt() {
  for (Body& body : bodies_) body.weight = body.largest = body.now = 0;
  load_ = 0;
}

bool LooseBodies::touches(const Body& body, const ContactReach& seen) {
  return seen.presses || seen.gap < closed * body.facet;
}

LooseBodies::Way LooseBodies::open_way(const Body& body, const Vector3& along,
                                       const std::vector<ContactReach>& reach) {
  Way nearest;
  // What does not face anything yet may go half the way to what the search sees.
  for (const Body::Side& side : body.sides) {
    const ContactReach& seen = reach[side.contact];
    if (touches(body, seen) || side.sign * dot(seen.opens, along) > 0) continue;
    const bool guessed = std::isinf(seen.gap);
    const double length = guessed ? seen.distance / 2 : std::max(0.0, seen.gap);
    if (length < nearest.length) nearest = {length, guessed};
  }
  return nearest;
}

LooseBodies::Way LooseBodies::pushed_way(const Body& body, const Vector3& along,
                                         const std::vector<ContactReach>& reach,
                                         std::vector<char>& passed) const {
  passed[static_cast<std::size_t>(&body - bodies_.data())] = 1;
  Way nearest;
  for (const Body::Side& side : body.sides) {
    const ContactReach& seen = reach[side.contact];
    if (!touches(body, seen) || side.sign * dot(seen.opens, along) > 0) continue;
    if (side.held) return {0, false};
    for (std::size_t other = 0; other < bodies_.size(); ++other) {
      const Body& next = bodies_[other];
      const bool opposite = std::any_of(next.sides.begin(), next.sides.end(), [&](const Body::Side& its) {
        return its.contact == side.contact && its.sign != side.sign;
      });
      if (!opposite || passed[other]) continue;
      Way way = open_way(next, along, reach);
      if (way.length == HUGE_VAL) way = pushed_way(next, along, reach, passed);
      if (way.length < nearest.length) nearest = way;
    }
  }
  return nearest;
}

void LooseBodies::find_approach(Body& body, const std::vector<ContactReach>& reach) const {
  // What presses already is not enough: the nearest of the other contacts that the body moves towards is to
  // come, or that of a body that it pushes.
  Way way = open_way(body, body.force, reach);
  double stiffness = 0, area = 0;
  body.pressed = false;
  for (const Body::Side& side : body.sides) {
    const ContactReach& seen = reach[side.contact];
    body.pressed = body.pressed || touches(body, seen);
    if (!touches(body, seen) && side.sign * dot(seen.opens, body.force) > 0) continue;
    stiffness += seen.stiffness;
    area += seen.touches;
  }
  if (way.length == HUGE_VAL && body.pressed) {
    std::vector<char> passed(bodies_.size(), 0);
    way = pushed_way(body, body.force, reach, passed);
    if (way.length == HUGE_VAL) way = {0, false};
  }
  const double nearest = way.length, least = bite * body.facet;
  body.guesses = body.pressed && way.guessed;
  body.strides = body.guesses ? 1 : body.pressed && nearest > 0 ? 2 : 2 * stride_;
  if (nearest == HUGE_VAL) { // nothing lies opposite as far as the search sees: longer strides
    body.approach = body.limit = least * std::exp2(body.blind++);
    return;
  }
  body.blind = 0;
  body.approach = body.limit = nearest + least;
  // Flat sides close at once: as deep as the force presses them.
  const double force = body.now * body.volume, width = is_flat(d_->frame) ? 1 : std::sqrt(area);
  if (stiffness > 0 && force > 0)
    body.approach =
        nearest + std::min(least, force / stiffness + squeeze * force / (d_->softest_modulus() * width));
}

// A body thrown at one that lay free passes on many times its load, by which nothing is to be measured.
void LooseBodies::note_load(Body& body) {
  const double force = body.now * body.volume;
  if (!body.pressed || (body.largest == 0 && load_ == 0)) {
    body.largest = std::max(body.largest, body.now);
    load_ = std::max(load_, force);
  } else if (body.largest == 0)
    body.largest = std::min(force, load_) / body.volume;
}

void LooseBodies::weigh(Vec u, Vec r) {
  // A step that was cut and did good may be longer the next time.
  const PetscReal norm = Get(VecNorm)(r, NORM_2);
  stride_ = limited_ && norm <= norm_ ? 2 * stride_ : 1;
  norm_ = norm;
  const std::vector<ContactReach> reach = contacts_->reach(u);
  const auto dim = at(d_->dim());
  // Force and moment about the centre, of each body.
  std::vector<double> sums(6 * bodies_.size(), 0.0);
  const std::vector<double> local = d_->local_of(r);
  for (const Node& node : nodes_) {
    const auto first = dim * at(node.local);
    double* of = &sums[6 * at(node.body)];
    Vector3 f{}, x{};
    for (std::size_t k = 0; k < dim; ++k) {
      f[k] = local[first + k];
      x[k] = d_->mesh.coordinates()[first + k] - bodies_[at(node.body)].centre[k];
      of[k] += f[k];
    }
    const Vector3 moment = cross(x, f);
    for (std::size_t k = 0; k < 3; ++k) of[3 + k] += moment[k];
  }
  sum_over_ranks(d_->mesh.comm(), sums);
  const std::vector<RigidVector> of_rigid = rigid_->resultants(r);
  must_look_ = false;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = bodies_[b];
    const double* of = body.rigid < 0 ? &sums[6 * b] : of_rigid[at(body.rigid)].data();
    const double force = std::hypot(of[0], of[1], of[2]) / body.volume,
                 moment = d_->frame == Frame::axisymmetric
                              ? 0
                              : body.size * std::hypot(of[3], of[4], of[5]) / body.inertia;
    body.now = std::max(force, moment);
    for (std::size_t k = 0; k < 3; ++k) body.force[k] = force < moment ? 0 : -of[k]; // R is inner less outer
    find_approach(body, reach);
    note_load(body);
    must_look_ = must_look_ || (body.now > balanced * body.largest && body.guesses);
    body.weight = body.floor;
    if (body.largest <= 0) continue;
    body.weight = std::min(body.floor, least_weight * body.largest / body.approach);
    if (const double part = body.now / body.largest; part > balanced) // (H2)
      body.weight = std::max(body.weight, body.now / body.approach * std::min(1.0, part));
  }
}

void LooseBodies::add_to(Mat K) const {
  const int dim = d_->dim();
  for (const Node& node : nodes_) {
    if (bodies_[at(node.body)].rigid >= 0) continue;
    for (int k = 0; k < dim; ++k) {
      if (fixed_[at(dim * node.local + k)]) continue;
      const PetscInt row = dim * d_->mesh.global_node()[at(node.local)] + k;
      check(MatSetValue(K, row, row, bodies_[at(node.body)].weight * node.volume, ADD_VALUES));
    }
  }
  for (const Body& body : bodies_)
    if (body.rigid >= 0)
      rigid_->add_mass(at(body.rigid), body.weight * body.volume / rigid_->bodies()[at(body.rigid)].mass, K);
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

bool LooseBodies::sees_only(Vec u) const {
  const std::vector<ContactReach> reach = contacts_->reach(u);
  return std::any_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
    const auto& sides = body.sides;
    return std::all_of(sides.begin(), sides.end(),
                       [&](const auto& side) { return std::isinf(reach[side.contact].gap); }) &&
           std::any_of(sides.begin(), sides.end(),
                       [&](const auto& side) { return std::isfinite(reach[side.contact].distance); });
  });
}

bool LooseBodies::rest(Vec u) const {
  const std::vector<ContactReach> reach = contacts_->reach(u);
  return std::all_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
    return std::any_of(body.sides.begin(), body.sides.end(),
                       [&](const auto& side) { return reach[side.contact].presses; });
  });
}

double LooseBodies::part_of(Vec du) { // (H3)
  const std::vector<double> local = d_->local_of(du);
  const auto dim = at(d_->dim());
  double most = 0; // over what is allowed
  for (const Node& node : nodes_) {
    const Body& body = bodies_[at(node.body)];
    if (!node.on_surface) continue;
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) square += std::pow(local[dim * at(node.local) + k], 2);
    most = std::max(most, std::sqrt(square) / (body.strides * body.limit));
  }
  most = max_over_ranks(d_->mesh.comm(), most);
  limited_ = most > 1;
  return limited_ ? 1 / most : 1;
}

bool LooseBodies::unbalanced() const {
  return std::any_of(bodies_.begin(), bodies_.end(),
                     [](const Body& body) { return body.now > balanced * body.largest; });
}

std::string LooseBodies::adrift() const {
  std::string text;
  for (const Body& body : bodies_)
    if (!body.pressed && body.now > balanced * body.largest)
      text += (text.empty() ? "" : "; ") + body.name + " meets nothing that holds it against its load";
  return text;
}

} // namespace impact
