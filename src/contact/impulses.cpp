#include <algorithm>
#include <cmath>
#include <impact/contact/impulses.hpp>
#include <impact/math/index.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/ranks.hpp>

namespace impact {

namespace {

constexpr int most_iterations = 500;
constexpr double small_change = 1e-10; // of the pressures in an iteration, over themselves
// A deeper overlap, in mean secondary facets, came in from the side or before the first step. It is pushed
// out by the second number in a step of 0.8 of the stable one.
constexpr double left_in = 5e-2, push = 2e-4;

} // namespace

// Sums over the ranks at the nodes of a contact, which every rank that knows them gets.
void ContactImpulses::sum(const ImpulseRows& rows, std::vector<double>& nodal) {
  double* values = nullptr;
  check(VecGetArray(sum_, &values));
  for (const PetscInt i : touched_) values[i] = 0;
  check(VecRestoreArray(sum_, &values));
  rows.contact->nodes().exchange.add(nodal, sum_);
  nodal = rows.contact->nodes().exchange.gather(sum_);
}

// The same over all contacts: what they do to a node that several of them know.
void ContactImpulses::sum_all(std::vector<double> ImpulseRows::*nodal) {
  double* values = nullptr;
  check(VecGetArray(sum_, &values));
  for (const PetscInt i : touched_) values[i] = 0;
  check(VecRestoreArray(sum_, &values));
  for (const ImpulseRows& rows : rows_) rows.contact->nodes().exchange.add(rows.*nodal, sum_);
  for (ImpulseRows& rows : rows_) rows.*nodal = rows.contact->nodes().exchange.gather(sum_);
}

void ContactImpulses::gather_gain() {
  for (ImpulseRows& rows : rows_) rows.gain = rows.contact->nodes().exchange.gather(gain_);
}

void ContactImpulses::list_touched(const ContactSet& contacts) {
  long searches = 0;
  for (const ContactInterface& contact : contacts) searches += contact.searches();
  if (searches == searches_) return;
  searches_ = searches;
  check(VecSet(sum_, 0));
  for (const ImpulseRows& rows : rows_) {
    const ContactNodes& nodes = rows.contact->nodes();
    nodes.exchange.add(std::vector<double>(rows.dim * nodes.global.size(), 1.0), sum_);
  }
  touched_.clear();
  const double* values = nullptr;
  PetscInt owned = 0;
  check(VecGetLocalSize(sum_, &owned));
  check(VecGetArrayRead(sum_, &values));
  for (PetscInt i = 0; i < owned; ++i)
    if (values[i] != 0) touched_.push_back(i);
  check(VecRestoreArrayRead(sum_, &values));
}

// Whether anything of a contact comes together, on any rank; if so, the areas, the velocities that are
// allowed and the points that may matter.
bool ContactImpulses::meet(ImpulseRows& rows, const ImpulseStep& step) {
  const std::size_t dim = rows.dim, count = rows.contact->nodes().global.size();
  const double h = rows.contact->constraints().mean_length();
  enum { area, gap, before = 0, after };
  std::vector<double> of_gap(dim * count, 0.0), of_rate(dim * count, 0.0);
  for (std::size_t q = 0; q < rows.points(); ++q) {
    const double rate = rows.drift[q] + rows.rate(q, rows.free),
                 rate_before = rows.drift_before[q] + rows.rate(q, rows.velocity);
    for (std::size_t a = rows.first_share[q]; a < rows.first_share[q + 1]; ++a) {
      const std::size_t i = dim * rows.node_of(q, a);
      const double weight = rows.weight[q] * rows.share[a];
      of_gap[i + area] += weight;
      of_gap[i + gap] += weight * rows.gap[q];
      of_rate[i + before] += weight * rate_before;
      of_rate[i + after] += weight * rate;
    }
  }
  sum(rows, of_gap);
  sum(rows, of_rate);
  rows.area.resize(count);
  rows.floor.resize(count);
  rows.near_node.assign(count, 0);
  double closing = 0;
  for (std::size_t node = 0; node < count; ++node) {
    const std::size_t i = dim * node;
    rows.area[node] = of_gap[i + area];
    rows.floor[node] =
        of_gap[i + gap] < -left_in * h * rows.area[node]
            ? -push * h / rows.contact->constraints().form().longest_step() * rows.area[node] / step.dt
            : std::max({of_gap[i + gap] / step.dt, of_rate[i + before], 0.0});
    if (rows.area[node] > 0)
      closing = std::max(closing, -(of_rate[i + after] + rows.floor[node]) / rows.area[node]);
  }
  closing = max_over_ranks(rows.contact->constraints().comm(), closing);
  if (!(closing > 0)) return false;
  // Impulses press sides apart, and change velocities by no more than what comes together.
  for (std::size_t node = 0; node < count; ++node)
    rows.near_node[node] = of_rate[dim * node + after] + rows.floor[node] < 2 * closing * rows.area[node];
  for (std::size_t q = 0; q < rows.points(); ++q) {
    rows.near[q] = 0;
    for (std::size_t a = rows.first[q]; a < rows.first[q] + rows.first_share[q + 1] - rows.first_share[q];
         ++a) {
      if (rows.near_node[at(rows.node[a])] != 0) rows.near[q] = 1;
    }
  }
  for (auto* values : {&rows.x, &rows.x_before, &rows.z, &rows.y}) values->assign((1 + dim) * count, 0.0);
  return true;
}

// v+ of the pressures and tractions z.
void ContactImpulses::find_velocities(const ImpulseStep& step) {
  for (ImpulseRows& rows : rows_) {
    std::fill(rows.force.begin(), rows.force.end(), 0.0);
    const std::size_t dim = rows.dim;
    for (std::size_t q = 0; q < rows.points(); ++q) {
      if (!rows.near[q]) continue;
      double p = 0, t[3] = {}, along[2] = {};
      for (std::size_t a = rows.first_share[q]; a < rows.first_share[q + 1]; ++a) {
        const double* z = &rows.z[(1 + dim) * rows.node_of(q, a)];
        p += rows.share[a] * z[0];
        for (std::size_t k = 0; k < dim; ++k) t[k] += rows.share[a] * z[1 + k];
      }
      for (std::size_t a = 0; a < rows.tangents; ++a)
        along[a] = inner(&rows.direction[dim * (rows.tangents * q + a)], t, dim);
      for (std::size_t i = rows.first[q]; i < rows.first[q + 1]; ++i)
        for (std::size_t k = 0; k < dim; ++k) {
          double f = p * rows.gradient[dim * i + k];
          for (std::size_t a = 0; a < rows.tangents; ++a)
            f -= along[a] * rows.slip_gradient[dim * (rows.tangents * i + a) + k];
          rows.force[dim * at(rows.node[i]) + k] += rows.weight[q] * f;
        }
    }
  }
  sum_all(&ImpulseRows::force);
  if (step.bodies != nullptr) {
    step.bodies->strike(sum_, gain_);
    gather_gain();
  }
  for (ImpulseRows& rows : rows_) {
    rows.velocity.resize(rows.free.size());
    for (std::size_t i = 0; i < rows.velocity.size(); ++i)
      rows.velocity[i] = rows.free[i] + step.dt * (rows.inverse_mass[i] * rows.force[i] + rows.gain[i]);
  }
}

// y: how far gaps open beyond what they must, and how far sides slip, by the velocity.
void ContactImpulses::find_rates(ImpulseRows& rows) {
  const std::size_t dim = rows.dim, count = rows.area.size();
  std::vector<double> opening(dim * count, 0.0), slip(rows.tangents > 0 ? dim * count : 0, 0.0);
  for (std::size_t q = 0; q < rows.points(); ++q) {
    if (!rows.near[q]) continue;
    double rate = rows.drift[q], slips[3] = {};
    for (std::size_t a = 0; a < rows.tangents; ++a)
      for (std::size_t k = 0; k < dim; ++k)
        slips[k] +=
            rows.slip_drift[rows.tangents * q + a] * rows.direction[dim * (rows.tangents * q + a) + k];
    for (std::size_t i = rows.first[q]; i < rows.first[q + 1]; ++i) {
      const double* v = &rows.velocity[dim * at(rows.node[i])];
      rate += inner(&rows.gradient[dim * i], v, dim);
      for (std::size_t a = 0; a < rows.tangents; ++a) {
        const double along = inner(&rows.slip_gradient[dim * (rows.tangents * i + a)], v, dim);
        for (std::size_t k = 0; k < dim; ++k)
          slips[k] += along * rows.direction[dim * (rows.tangents * q + a) + k];
      }
    }
    for (std::size_t a = rows.first_share[q]; a < rows.first_share[q + 1]; ++a) {
      const std::size_t node = dim * rows.node_of(q, a);
      const double weight = rows.weight[q] * rows.share[a];
      opening[node] += weight * rate;
      for (std::size_t k = 0; k < dim && !slip.empty(); ++k) slip[node + k] += weight * slips[k];
    }
  }
  sum(rows, opening);
  if (rows.friction > 0) sum(rows, slip);
  for (std::size_t node = 0; node < count; ++node) {
    double* y = &rows.y[(1 + dim) * node];
    y[0] = opening[dim * node] + rows.floor[node];
    for (std::size_t k = 0; k < dim; ++k) y[1 + k] = slip.empty() ? 0 : -slip[dim * node + k];
  }
}

// One step of the projected gradient, with Nesterov's momentum that starts again where it led uphill (B.
// O'Donoghue, E. Candes, Found. Comput. Math. 15 (2015)). True where pressures have come to rest.
bool ContactImpulses::improve(double& momentum) {
  std::array<double, 3> sums{}; // uphill, change, size
  for (ImpulseRows& rows : rows_) {
    const std::size_t n = 1 + rows.dim;
    rows.x_before.swap(rows.x);
    for (std::size_t node = 0; node < rows.area.size(); ++node) {
      if (!(rows.bound[node] > 0)) continue;
      const double *z = &rows.z[n * node], *y = &rows.y[n * node], *before = &rows.x_before[n * node];
      double* x = &rows.x[n * node];
      for (std::size_t k = 0; k < n; ++k) x[k] = z[k] - y[k] / rows.bound[node];
      x[0] = std::max(x[0], 0.0);
      const double limit = rows.friction * x[0], size = std::sqrt(inner(x + 1, x + 1, n - 1));
      for (std::size_t k = 1; k < n && size > limit; ++k) x[k] *= limit / size;
      for (std::size_t k = 0; k < n; ++k) {
        const double change = x[k] - before[k];
        sums[0] += y[k] * change;
        sums[1] += change * change;
        sums[2] += x[k] * x[k];
      }
    }
  }
  sum_over_ranks(rows_.front().contact->constraints().comm(), sums);
  const double root = std::sqrt(1 + 4 * momentum * momentum), next = (1 + root) / 2;
  const bool again = sums[0] > 0;
  const double keep = again ? 0 : (momentum - 1) / next;
  momentum = again ? 1 : next;
  for (ImpulseRows& rows : rows_)
    for (std::size_t i = 0; i < rows.x.size(); ++i)
      rows.z[i] = rows.x[i] + keep * (rows.x[i] - rows.x_before[i]);
  return sums[1] <= small_change * small_change * sums[2];
}

void ContactImpulses::find(ContactSet& contacts, const ImpulseStep& step) {
  iterations_ = 0;
  std::size_t count = 0;
  for (ContactInterface& contact : contacts)
    if (contact.by_impulse()) {
      if (count == rows_.size()) rows_.emplace_back();
      rows_[count++].collect(contact, step);
    }
  if (count == 0) return;
  list_touched(contacts);
  bool any = false;
  for (ImpulseRows& rows : rows_) {
    if (meet(rows, step)) {
      any = true;
    } else {
      std::fill(rows.near.begin(), rows.near.end(), 0);
      for (auto* values : {&rows.x, &rows.x_before, &rows.z, &rows.y})
        values->assign((1 + rows.dim) * rows.area.size(), 0.0);
    }
  }
  if (any) {
    find_bounds(step);
    double momentum = 1;
    for (bool rest = false; !rest && iterations_ < most_iterations; ++iterations_) {
      find_velocities(step);
      for (ImpulseRows& rows : rows_) find_rates(rows);
      rest = improve(momentum);
    }
  }
  for (const ImpulseRows& rows : rows_) rows.keep();
}

} // namespace impact
