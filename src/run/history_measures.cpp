#include <algorithm>
#include <cmath>
#include <impact/balance/release.hpp>
#include <impact/kernel/cell_kernels.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/history_observer.hpp>
#include <impact/scenario/columns.hpp>
#include <numbers>

/// Columns of the history that stand for fields on groups, and for what a ring of cells would release.
namespace impact {

namespace {

// 1 inside of the ring, 0 outside, even between: what a node advances by.
double advance(const ReleaseScenario& ring, std::span<const double> x) {
  double square = 0;
  for (std::size_t k = 0; k < x.size(); ++k) square += (x[k] - ring.at[k]) * (x[k] - ring.at[k]);
  return std::clamp((ring.outer - std::sqrt(square)) / (ring.outer - ring.inner), 0.0, 1.0);
}

// The area that an advance by 1 adds to the crack: of a ball, the integral of `advance` along its diameter.
double area(const ReleaseScenario& ring, Frame frame) {
  if (frame == Frame::axisymmetric) return 2 * std::numbers::pi * ring.at[0];
  if (frame != Frame::solid) return 1;
  return ring.length > 0 ? ring.length : ring.inner + ring.outer;
}

// What a value of the group counts in its mean, by the place of its first component in a field of so many.
struct Share {
  std::size_t place;
  double weight;
};

std::vector<Share> of_nodes(const Mesh& mesh, const std::string& group, int components) {
  std::vector<Share> shares;
  for (int node : mesh.nodes(group))
    if (mesh.owned(node)) shares.push_back({at(node * components), 1});
  return shares;
}

// Cells count by their reference volume.
std::vector<Share> of_cells(const Discretisation& d, const std::string& region, int components) {
  std::vector<PetscInt> cells = d.mesh.region_cells(region);
  std::ranges::sort(cells);
  std::vector<Share> shares;
  std::size_t first = 0;
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    auto ones = batch.points<1>();
    std::fill_n(ones.value, ones.size, Batch(1.0));
    const Batch volume = batch.kernels.cell_integral(batch.vectors(d.mesh.coordinates()).data(), ones.data());
    for (int l = 0; l < batch.used(); ++l)
      if (std::ranges::binary_search(cells, batch.group.cell_point[at(batch.number * lanes + l)]))
        shares.push_back({first + at(l), volume[l]});
    first += at(components * lanes);
  });
  return shares;
}

} // namespace

void HistoryObserver::append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const Discretisation& d = motion_.discretisation();
  using Of = MeasureScenario::Of;
  for (const MeasureScenario& measure : scenario_.measures) {
    for (const std::string& field : measure.fields) {
      const FieldValues of = source_.values(field, snapshot.u);
      const std::vector<Share> shares =
          of.nodal ? of_nodes(d.mesh, measure.on, of.components) : of_cells(d, measure.on, of.components);
      for (int k = 0; k < of.components; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL, sums[2] = {0, 0};
        for (const auto& [place, weight] : shares) {
          const double value = of.values[place + at(of.nodal ? k : k * lanes)];
          if (std::isnan(value)) continue; // a gap to nothing
          low = std::min(low, value);
          high = std::max(high, value);
          sums[0] += weight * value;
          sums[1] += weight;
        }
        low = min_over_ranks(d.mesh.comm(), low);
        high = max_over_ranks(d.mesh.comm(), high);
        sum_over_ranks(d.mesh.comm(), sums);
        const double value = measure.of == Of::min   ? low
                             : measure.of == Of::max ? high
                             : measure.of == Of::sum ? sums[0]
                                                     : sums[0] / (sums[1] > 0 ? sums[1] : 1);
        row.emplace_back("measure_" + measure.id + "_" + component_name(field, k, of.components), value);
      }
    }
  }
}

void HistoryObserver::find_ways() {
  ways_.clear();
  const Discretisation& d = motion_.discretisation();
  const auto X = d.mesh.coordinates();
  const std::size_t dim = at(d.dim());
  for (const ReleaseScenario& ring : scenario_.releases) {
    std::vector<double> part, moved(X.size(), 0.0);
    for (std::size_t i = 0; i < X.size(); i += dim) {
      part.push_back(advance(ring, X.subspan(i, dim)));
      for (std::size_t k = 0; k < dim; ++k) moved[i + k] = part.back() * ring.direction[k];
    }
    keep_sides(d, part, phi_ ? std::span<const double>(phi_->committed) : std::span<const double>(),
               scenario_.crack_level, moved);
    ways_.push_back(std::move(moved));
  }
}

void HistoryObserver::append_releases(HistoryFile::Row& row, const Snapshot& snapshot) {
  if (scenario_.releases.empty()) return;
  if (ways_.empty() || phi_) find_ways(); // cracks begin at sides
  const Discretisation& d = motion_.discretisation();
  const std::size_t size = d.mesh.coordinates().size();
  std::vector<double> lag, body; // acceleration, less the force by mass
  const bool falls = motion_.boundary().body_force(motion_.step().t, body),
             accelerates = falls || scenario_.has_inertia();
  if (accelerates) lag.assign(size, 0.0);
  if (scenario_.has_inertia()) std::copy(a_.committed.begin(), a_.committed.end(), lag.begin());
  for (std::size_t i = 0; i < body.size(); ++i) lag[i] -= body[i];
  auto way = ways_.begin();
  for (const ReleaseScenario& ring : scenario_.releases) {
    const std::vector<double>& moved = *way++;
    double released = find_release(d, bodies_, snapshot.u, moved) +
                      find_load_release(d, motion_.boundary(), motion_.step().t, snapshot.u, moved);
    if (accelerates) released += find_inertial_release(d, snapshot.u, lag, moved);
    row.emplace_back("release_" + ring.id, released / area(ring, d.frame));
  }
}

} // namespace impact
