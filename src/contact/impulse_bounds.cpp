#include <algorithm>
#include <cmath>
#include <impact/contact/impulses.hpp>
#include <impact/math/index.hpp>

/// How long a step of the projected gradient of ContactImpulses may be at each node.
namespace impact {

// Bounds of the row sums of dt sum w N_A J M^-1 J^T w N_B, J the gradients of gap and slips at a point, which
// stand across each other.
void ContactImpulses::find_bounds(const ImpulseStep& step) {
  const auto size = [](const ImpulseRows& rows, std::size_t i) {
    const auto square = [dim = rows.dim](const std::vector<double>& gradient, std::size_t row) {
      return inner(&gradient[dim * row], &gradient[dim * row], dim);
    };
    double most = square(rows.gradient, i);
    for (std::size_t a = 0; a < rows.tangents; ++a)
      most = std::max(most, square(rows.slip_gradient, rows.tangents * i + a));
    return std::sqrt(most);
  };
  for (ImpulseRows& rows : rows_) {
    rows.force.assign(rows.free.size(), 0.0);
    for (std::size_t q = 0; q < rows.points(); ++q)
      for (std::size_t i = rows.first[q]; rows.near[q] && i < rows.first[q + 1]; ++i)
        rows.force[rows.dim * at(rows.node[i])] += rows.weight[q] * size(rows, i);
  }
  sum_all(&ImpulseRows::force);
  if (step.bodies != nullptr) {
    step.bodies->bound(sum_, gain_);
    gather_gain();
  }
  for (ImpulseRows& rows : rows_) {
    std::vector<double> bound(rows.free.size(), 0.0);
    for (std::size_t q = 0; q < rows.points(); ++q) {
      if (!rows.near[q]) continue;
      double row = 0;
      for (std::size_t i = rows.first[q]; i < rows.first[q + 1]; ++i) {
        const std::size_t node = rows.dim * at(rows.node[i]);
        const double* inverse = &rows.inverse_mass[node];
        row += size(rows, i) *
               (*std::max_element(inverse, inverse + rows.dim) * rows.force[node] + rows.gain[node]);
      }
      for (std::size_t a = rows.first_share[q]; a < rows.first_share[q + 1]; ++a)
        bound[rows.dim * rows.node_of(q, a)] += step.dt * rows.weight[q] * rows.share[a] * row;
    }
    sum(rows, bound);
    rows.bound.resize(rows.area.size());
    for (std::size_t node = 0; node < rows.bound.size(); ++node)
      rows.bound[node] = rows.near_node[node] != 0 ? bound[rows.dim * node] : 0;
  }
}

} // namespace impact
