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

// The part of a ball, weighted by `advance`, that lies in the bodies.
double part_in_bodies(const Discretisation& d, const ReleaseScenario& ring) {
  const auto X = d.mesh.coordinates();
  std::vector<double> part;
  for (std::size_t i = 0; i < X.size(); i += 3) part.push_back(advance(ring, X.subspan(i, 3)));
  double sum = 0;
  for_each_batch(d, all_laws, [&](const CellBatch& batch) {
    const NodalValues of = batch.scalars(part);
    const Batch volume = batch.volume(batch.vectors(X));
    for (int l = 0; l < batch.used(); ++l)
      for (int i = 0; i < of.size; ++i) sum += of.value[i][l] * volume[l] / of.size;
  });
  const double a = ring.inner, b = ring.outer;
  return sum_over_ranks(d.mesh.comm(), sum) * 3 / (std::numbers::pi * (a + b) * (a * a + b * b));
}

// What a ring cannot know of its crack.
void report_releases(const Discretisation& d, const std::vector<ReleaseScenario>& rings) {
  if (rings.empty()) return;
  const MPI_Comm comm = d.mesh.comm();
  for (const MaterialAssignment& material : d.materials)
    if (material.law.flows())
      check(
          PetscPrintf(comm,
                      "impact: -releases: material %s flows: the rates are of elastic energy, which is no J "
                      "where a ring or what it encloses has yielded by more than a small zone\n",
                      material.id.c_str()));
  for (const ReleaseScenario& ring : rings) {
    if (d.frame != Frame::solid || ring.length > 0) continue;
    constexpr double alike = 0.05; // of cells that cross its surface
    const double part = part_in_bodies(d, ring);
    if (std::ranges::any_of(std::array{1.0, 0.5, 0.25},
                            [&](double whole) { return std::abs(part / whole - 1) < alike; }))
      continue;
    check(PetscPrintf(comm,
                      "impact: -release_%s: %.0f %% of the ball lie in the bodies, not all, a half or a "
                      "quarter: where a side cuts the front, -release_%s_length is less than its default, "
                      "_inner + _outer: the thickness, of a plate within _inner of the point\n",
                      ring.id.c_str(), 100 * part, ring.id.c_str()));
  }
}

} // namespace

void HistoryObserver::find_shares() {
  const Discretisation& d = motion_.discretisation();
  report_releases(d, scenario_.releases);
  for (const MeasureScenario& measure : scenario_.measures) {
    auto& [of_nodes, of_cells] = shares_.emplace_back();
    for (int node : d.mesh.nodes(measure.on))
      if (d.mesh.owned(node)) of_nodes.push_back({at(node), 0, 1});
    if (d.mesh.group(measure.on).dim < d.dim()) continue;
    const std::vector<PetscInt> cells = d.mesh.region_cells(measure.on);
    std::size_t batches = 0;
    for_each_batch(d, all_laws, [&](const CellBatch& batch) {
      const Batch volume = batch.volume(batch.vectors(d.mesh.coordinates()));
      for (int l = 0; l < batch.used(); ++l)
        if (std::ranges::binary_search(cells, batch.group.cell_point[at(batch.number * lanes + l)]))
          of_cells.push_back({batches, at(l), d.thickness * volume[l]});
      ++batches;
    });
  }
}

void HistoryObserver::append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const Discretisation& d = motion_.discretisation();
  using Of = MeasureScenario::Of;
  auto shares = shares_.begin();
  for (const MeasureScenario& measure : scenario_.measures) {
    const auto& [of_nodes, of_cells] = *shares++;
    for (const std::string& field : measure.fields) {
      const FieldValues of = source_.values(field, snapshot.u);
      const std::size_t width = of.nodal ? 1 : lanes;
      for (int k = 0; k < of.components; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL, sums[2] = {0, 0};
        for (const auto& [row_of, lane, weight] : of.nodal ? of_nodes : of_cells) {
          const double value = of.values[(row_of * at(of.components) + at(k)) * width + lane];
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
