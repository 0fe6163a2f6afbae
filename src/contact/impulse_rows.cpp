#include <algorithm>
#include <impact/contact/impulse_rows.hpp>
#include <impact/element/facets.hpp>
#include <impact/math/index.hpp>

namespace impact {

namespace {

std::array<double, 3> obstacle_velocity(const ContactInterface& contact, int dim, double t, double dt) {
  const auto from = rigid_displacement(contact.settings(), dim, t),
             to = rigid_displacement(contact.settings(), dim, t + dt);
  return {(to[0] - from[0]) / dt, (to[1] - from[1]) / dt, (to[2] - from[2]) / dt};
}

// Shares of a facet of second order become those of its corners under shape functions of first order, whose
// pressures are positive where nodal ones are and whose areas are: functions of second order hold those of
// first order, by the values of these at their nodes.
template <std::size_t corners, std::size_t edges>
void lower(double* share, const CellEdge (&edge)[edges], int n) {
  double corner[corners];
  std::copy_n(share, corners, corner);
  for (std::size_t e = 0; e < edges; ++e)
    for (const int end : edge[e]) corner[end] += share[corners + e] / 2;
  if (n > static_cast<int>(corners + edges))
    for (double& c : corner) c += share[corners + edges] / corners; // that of the middle
  std::fill_n(std::copy_n(corner, corners, share), n - static_cast<int>(corners), 0.0);
}

void lower(std::size_t dim, double* share, int n) {
  if (dim == 2 && n == 3) return lower<2>(share, Line3::edges, n);
  if (n == 6) return lower<3>(share, Tri6::edges, n);
  if (n > 6) lower<4>(share, quadrilateral_edges, n);
}

} // namespace

void ImpulseRows::collect(ContactInterface& of, const ImpulseStep& step) {
  contact = &of;
  dim = of.constraints().dim();
  friction = of.settings().friction;
  tangents = friction > 0 ? of.constraints().tangents() : 0;
  for (auto* values :
       {&weight, &gap, &drift, &drift_before, &slip_drift, &gradient, &slip_gradient, &share, &direction})
    values->clear();
  index.clear();
  node.clear();
  first.assign(1, 0);
  first_share.assign(1, 0);
  const Constraints& constraints = of.constraints();
  const ContactNodes& nodes = of.nodes();
  const int d = static_cast<int>(dim);
  const std::array<double, 3> before = obstacle_velocity(of, d, step.t - step.dt, step.dt),
                              after = obstacle_velocity(of, d, step.t, step.dt);
  constraints.visit(step.u, Derivatives::first, [&](const Constraint& c) {
    index.push_back(c.index);
    weight.push_back(c.weight);
    gap.push_back(c.gap);
    node.insert(node.end(), c.node.begin(), c.node.end());
    first.push_back(node.size());
    gradient.insert(gradient.end(), c.gradient.begin(), c.gradient.end());
    gradient.resize(dim * node.size(), 0.0); // nodes of the slip alone come last
    share.insert(share.end(), c.share.begin(), c.share.end());
    lower(dim, share.data() + first_share.back(), static_cast<int>(c.share.size()));
    first_share.push_back(share.size());
    // Gaps do not change where the obstacle and the secondary side move alike, and neither do slips.
    double later = 0, earlier = 0;
    if (of.settings().rigid())
      for (std::size_t i = 0; i < dim * c.share.size(); ++i) {
        later -= c.gradient[i] * after[i % dim];
        earlier -= c.gradient[i] * before[i % dim];
      }
    drift.push_back(later);
    drift_before.push_back(earlier);
    const std::size_t n = dim * c.node.size();
    for (std::size_t a = 0; a < tangents; ++a) {
      double along[3] = {};
      for (std::size_t i = 0; c.slides && i < dim * c.share.size(); ++i)
        along[i % dim] += c.slip_gradient[n * a + i];
      direction.insert(direction.end(), along, along + dim);
      slip_drift.push_back(of.settings().rigid() ? -inner(along, after.data(), dim) : 0);
    }
    for (std::size_t b = 0; b < c.node.size(); ++b)
      for (std::size_t a = 0; a < tangents; ++a)
        for (std::size_t k = 0; k < dim; ++k)
          slip_gradient.push_back(c.slides ? c.slip_gradient[n * a + dim * b + k] : 0);
  });
  near.assign(points(), 1);
  free = nodes.exchange.gather(step.free);
  velocity = nodes.exchange.gather(step.before);
  inverse_mass = nodes.exchange.gather(step.inverse_mass);
  gain.assign(free.size(), 0.0);
}

double ImpulseRows::rate(std::size_t point, const std::vector<double>& at_nodes) const {
  double sum = 0;
  for (std::size_t i = first[point]; i < first[point + 1]; ++i)
    sum += inner(&gradient[dim * i], &at_nodes[dim * at(node[i])], dim);
  return sum;
}

void ImpulseRows::keep() const {
  std::vector<double>&pressure = contact->given_pressures(), &traction = contact->given_tractions();
  std::fill(pressure.begin(), pressure.end(), 0.0);
  std::fill(traction.begin(), traction.end(), 0.0);
  if (x.empty()) return;
  for (std::size_t q = 0; q < points(); ++q) {
    if (!near[q]) continue;
    double t[3] = {};
    for (std::size_t a = first_share[q]; a < first_share[q + 1]; ++a) {
      const double* mine = &x[(1 + dim) * node_of(q, a)];
      pressure[at(index[q])] += share[a] * mine[0];
      for (std::size_t k = 0; k < dim; ++k) t[k] += share[a] * mine[1 + k];
    }
    for (std::size_t a = 0; a < tangents; ++a)
      traction[tangents * at(index[q]) + a] = inner(&direction[dim * (tangents * q + a)], t, dim);
  }
}

} // namespace impact
