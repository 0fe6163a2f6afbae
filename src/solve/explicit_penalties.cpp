#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/surface_load.hpp>
#include <impact/solve/explicit_contact.hpp>
#include <numbers>

/// How stiff the penalties of explicit steps may be, and how long steps may be for them.
namespace impact {

namespace {

// Where an automatic penalty is twice as stiff, if the sides close by the part `way` of what they see within
// a step. Obstacles are seen at any depth.
double soft_depth(const ContactInterface& contact, int order, double way) {
  constexpr double part = 0.1; // of the distance of nodes
  if (contact.settings().rigid()) return 0;
  return std::max(part * contact.constraints().mean_length() / order, way * contact.search().range());
}

} // namespace

void ExplicitContact::Loads::add(const Loads& other, double factor) {
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] += factor * other.nodes[i];
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b] += factor * other.bodies[b];
}

double ExplicitContact::Loads::largest() const {
  double most = 0;
  for (const double load : nodes) most = std::max(most, load);
  for (const double load : bodies) most = std::max(most, load);
  return most;
}

ExplicitContact::Loads ExplicitContact::no_loads() const {
  return {motion_.discretisation().displacement.make_local(),
          std::vector<double>(motion_.rigid().bodies().size())};
}

// The stiffness of a penalty eps that acts on the area A of a node of mass m is felt as 2 eps A/m at most:
// the gap is a mean over either side, and the square of a difference at most twice the sum of the squares.
// Nodes of a rigid body give way as a whole: |v + w x r|^2 <= (1/m + r.r/J) (m v.v + w . J w), J the least
// moment of inertia.
ExplicitContact::Loads ExplicitContact::loads(const ContactInterface& contact) {
  const Discretisation& d = motion_.discretisation();
  const std::vector<double> X(d.mesh.coordinates().begin(), d.mesh.coordinates().end()),
      mass = d.local_of(motion_.lumped_mass());
  Loads loads = no_loads();
  const auto add_side = [&](const std::string& side) {
    std::vector<double> area = d.displacement.make_local();
    if (ContactSettings::rigid_name(side)) return area;
    add_felt_area(contact.facets(side), d.frame, X, area);
    add_up(d.displacement, area);
    for (std::size_t i = 0; i < area.size(); ++i)
      if (area[i] > 0) loads.nodes[i] += 2 * area[i] / mass[i];
    return area;
  };
  const std::vector<double> secondary = add_side(contact.settings().secondary);
  std::vector<double> area = secondary;
  if (contact.settings().primary != contact.settings().secondary) {
    const std::vector<double> primary = add_side(contact.settings().primary);
    for (std::size_t i = 0; i < area.size(); ++i) area[i] += primary[i];
  }
  if (motion_.rigid().empty()) return loads;
  const int dim = d.dim();
  for (std::size_t i = 0; i < area.size(); ++i) {
    const int node = static_cast<int>(i) / dim, body = motion_.rigid().body_of_node()[at(node)];
    if (body < 0) continue;
    loads.nodes[i] = 0;
    if (static_cast<int>(i) % dim == 0 && d.mesh.owned(node))
      loads.bodies[at(body)] += 2 * area[i] * motion_.rigid().give(at(body), &X[i]);
  }
  add_load_on_obstacle(contact, secondary, loads.bodies);
  sum_over_ranks(d.mesh.comm(), loads.bodies);
  return loads;
}

// All of the surface may press on a plane, on a round body as much as its shadow. Pressure there has no arm
// about the centre; friction has the radius.
void ExplicitContact::add_load_on_obstacle(const ContactInterface& contact, const std::vector<double>& area,
                                           std::vector<double>& of_bodies) const {
  const ContactSettings& settings = contact.settings();
  const Discretisation& d = motion_.discretisation();
  if (settings.carrier.empty()) return;
  const auto& bodies = motion_.rigid().bodies();
  const auto found = std::find_if(bodies.begin(), bodies.end(),
                                  [&](const RigidBody& body) { return body.name == settings.carrier; });
  if (found == bodies.end()) return;
  const auto b = static_cast<std::size_t>(found - bodies.begin());
  const int dim = d.dim();
  const bool plane = settings.primary == "plane";
  double whole = 0, load = 0;
  for (int node = 0; node < d.mesh.node_count(); ++node) {
    if (!d.mesh.owned(node)) continue;
    const double mine = area[at(dim * node)];
    whole += mine;
    load += 2 * mine * motion_.rigid().give(b, &d.mesh.coordinates()[at(dim * node)]);
  }
  if (plane) {
    of_bodies[b] += load;
    return;
  }
  Vector3 rim = found->centre;
  if (settings.friction > 0) rim[0] += settings.radius;
  const double shadow = d.frame == Frame::solid && settings.primary == "rigid_sphere"
                            ? std::numbers::pi * settings.radius * settings.radius
                        : d.frame == Frame::plane_strain || d.frame == Frame::plane_stress
                            ? 2 * settings.radius
                            : HUGE_VAL;
  int ranks = 0;
  MPI_Comm_size(d.mesh.comm(), &ranks);
  of_bodies[b] += 2 * std::min(whole, shadow / ranks) * motion_.rigid().give(b, rim.data());
}

// With dt = s dt_e, dt_e the stable step of the cells, dt^2 (4/dt_e^2 + w^2) <= 4 leaves w^2 = 4 (1 -
// s^2)/dt^2 to the contacts. Shorter steps than 0.8 dt_e resolve that one better, and do not make it stiffer.
// Where what meets compresses by much, at velocities V not far below that of sound, a penalty as stiff as the
// cells would give way by more than the depth d that is seen: by V dt_e s^2/2(1 - s^2) (1 + V dt_e/d) under
// the pressure of a shock whose speed grows by 1.5 V/2. `part_of_depth` is what it may. It stiffens at a
// tenth of the distance of nodes, but no earlier than in what closes within a step.
void ExplicitContact::set_penalties(double longest_of_cells, double cfl, const std::vector<double>& v) {
  ContactSet& contacts = motion_.contacts();
  const MPI_Comm comm = motion_.discretisation().mesh.comm();
  std::vector<Loads> each;
  Loads total = no_loads();
  for (const ContactInterface& contact : contacts) {
    each.push_back(loads(contact));
    if (contact.settings().automatic_penalty && !contact.by_impulse()) total.add(each.back(), 1);
  }
  const double s = std::clamp(cfl, 0.8, 0.9), dt = s * longest_of_cells, budget = 4 * (1 - s * s) / (dt * dt);
  const int order = motion_.discretisation().mesh.order();
  std::size_t c = 0;
  for (ContactInterface& contact : contacts) {
    double largest = 0;
    for (std::size_t i = 0; i < total.nodes.size(); ++i)
      if (each[c].nodes[i] > 0) largest = std::max(largest, total.nodes[i]);
    for (std::size_t b = 0; b < total.bodies.size(); ++b)
      if (each[c].bodies[b] > 0) largest = std::max(largest, total.bodies[b]);
    largest = max_over_ranks(comm, largest);
    if (contact.settings().automatic_penalty && !contact.by_impulse() && largest > 0 &&
        !contact.rests_on_penalty()) {
      const double way = closing(contact, v) * longest_of_cells; // in depths
      const double give = way * s * s / (2 * (1 - s * s)) * (1 + way);
      contact.set_penalty(budget / largest * std::max(1.0, give / part_of_depth),
                          soft_depth(contact, order, way));
    }
    ++c;
  }
}

void ExplicitContact::report_multipliers(Vec u) const {
  const Discretisation& d = motion_.discretisation();
  for (const ContactInterface& contact : motion_.contacts()) {
    const double energy = contact.by_impulse() ? 0 : d.thickness * contact.held_by_multipliers(u);
    if (energy > 0)
      check(
          PetscPrintf(d.mesh.comm(),
                      "impact: contact %s presses by multipliers of the scheme before, which explicit steps "
                      "let go of where it has opened by pressure over penalty: that gives up to %.3g of "
                      "energy, at any length of the steps; -contact_%s_enforce impulse (with _method gpts) "
                      "gives none\n",
                      contact.id().c_str(), energy, contact.id().c_str()));
  }
}

// By how far velocities lie from the middle of the means of both sides: what flies with both does not count,
// and bodies that turn close as fast whatever the axes.
double ExplicitContact::closing(const ContactInterface& contact, const std::vector<double>& v) const {
  const Mesh& mesh = motion_.discretisation().mesh;
  if (contact.settings().rigid()) return 0; // seen at any depth
  const auto dim = at(mesh.dim());
  const std::array<std::string, 2> sides = {contact.settings().secondary, contact.settings().primary};
  std::array<double, 8> sums{}; // of the velocities of each side, and how many there are
  for (std::size_t s = 0; s < 2; ++s)
    for (int node : mesh.nodes(sides[s])) {
      if (!mesh.owned(node)) continue;
      for (std::size_t k = 0; k < dim; ++k) sums[4 * s + k] += v[dim * at(node) + k];
      sums[4 * s + 3] += 1;
    }
  sum_over_ranks(mesh.comm(), sums);
  double most = 0;
  for (const std::string& side : sides)
    for (int node : mesh.nodes(side)) {
      double square = 0;
      for (std::size_t k = 0; k < dim; ++k) {
        const double middle = (sums[k] / sums[3] + sums[4 + k] / sums[7]) / 2,
                     apart = v[dim * at(node) + k] - middle;
        square += apart * apart;
      }
      most = std::max(most, square);
    }
  return 2 * std::sqrt(max_over_ranks(mesh.comm(), most)) / contact.search().range();
}

double ExplicitContact::closing(const std::vector<double>& v) const {
  double most = 0;
  for (const ContactInterface& contact : motion_.contacts()) most = std::max(most, closing(contact, v));
  return most;
}

double ExplicitContact::closing_in(double dt) const {
  double most = 0;
  for (const ContactInterface& contact : motion_.contacts())
    if (!contact.settings().rigid())
      most = std::max(most, contact.search().motion() / contact.search().range());
  return most / dt;
}

double ExplicitContact::frequency() {
  if (frequency_ >= 0) return frequency_;
  Loads sum = no_loads();
  for (const ContactInterface& contact : motion_.contacts())
    if (!contact.by_impulse()) sum.add(loads(contact), contact.penalty());
  return frequency_ = max_over_ranks(motion_.discretisation().mesh.comm(), sum.largest());
}

} // namespace impact
