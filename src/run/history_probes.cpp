#include <algorithm>
#include <cmath>
#include <impact/petsc/ranks.hpp>
#include <impact/run/history_observer.hpp>
#include <impact/scenario/columns.hpp>
#include <tuple>

/// Columns of the history that stand for fields at places.
namespace impact {

namespace {

// Where cell fields, [group][batch][component][lane], have the cell of a mesh point: batch and lane.
std::pair<std::size_t, std::size_t> find_lane(const std::vector<CellGroup>& groups, PetscInt point) {
  std::size_t first = 0;
  for (const CellGroup& group : groups) {
    const auto found = std::ranges::find(group.cell_point, point);
    const std::size_t index = at(found - group.cell_point.begin());
    if (found != group.cell_point.end()) return {first + index / lanes, index % lanes};
    first += at(group.batch_count);
  }
  return {};
}

// A point on a curved side lies outside of the cells by its last digit: where to go instead.
std::string nearest_node(const Discretisation& d, const double* place) {
  const std::size_t dim = at(d.dim());
  const std::span<const double> X = d.mesh.coordinates();
  double least = HUGE_VAL;
  std::array<double, 3> nearest{};
  for (std::size_t first = 0; first + dim <= X.size(); first += dim) {
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) square += (X[first + k] - place[k]) * (X[first + k] - place[k]);
    if (square >= least) continue;
    least = square;
    std::copy_n(&X[first], dim, nearest.begin());
  }
  nearest = of_least(d.mesh.comm(), least, nearest);
  least = min_over_ranks(d.mesh.comm(), least);
  std::string text;
  for (std::size_t k = 0; k < dim; ++k) text += text_of(k > 0 ? ",%.9g" : "%.9g", nearest[k]);
  return "the nearest node is at " + text + text_of(", %.3g away", std::sqrt(least));
}

} // namespace

void HistoryObserver::locate_probes() {
  const Discretisation& d = motion_.discretisation();
  // Cells that stand for rigid obstacles are in the place of other bodies.
  std::vector<PetscInt> obstacles;
  for (const ContactScenario& contact : scenario_.contacts)
    if (scenario_.has_motion() && !contact.carrier.empty())
      for (PetscInt cell : d.mesh.region_cells(contact.carrier)) obstacles.push_back(cell);
  int rank = 0, size = 1;
  MPI_Comm_rank(d.mesh.comm(), &rank);
  MPI_Comm_size(d.mesh.comm(), &size);
  for (const ProbeScenario& probe : scenario_.probes) {
    Located found;
    std::array<double, 3> middle{}; // of that cell: of several that hold the point the first by its place
    const bool anywhere = probe.region.empty();
    const std::vector<PetscInt> listed = anywhere ? obstacles : d.mesh.region_cells(probe.region);
    for (const CellTable& table : d.mesh.cells())
      for (std::size_t c = 0; c < table.point.size(); ++c) {
        if ((std::ranges::find(listed, table.point[c]) == listed.end()) != anywhere) continue;
        const int nodes = table.shape->nodes, dim = d.dim();
        const int* const node = &table.connectivity[c * at(nodes)];
        double X[3 * max_nodes];
        for (int a = 0; a < nodes; ++a)
          std::copy_n(&d.mesh.coordinates()[at(node[a] * dim)], dim, X + a * dim);
        std::array<double, 3> centre{};
        for (int i = 0; i < nodes * dim; ++i) centre[at(i % dim)] += X[i] / nodes;
        double N[max_nodes];
        if ((found.count > 0 && !(centre < middle)) || !locate(table.shape, X, probe.at, N)) continue;
        middle = centre;
        found.count = nodes;
        std::copy_n(N, nodes, found.N);
        std::copy_n(node, nodes, found.nodes);
        std::tie(found.batch, found.lane) = find_lane(d.groups, table.point[c]);
      }
    // For any number of ranks the same cell.
    bool mine = found.count > 0;
    for (const double component : middle) {
      const double least = min_over_ranks(d.mesh.comm(), mine ? component : HUGE_VAL);
      mine = mine && component == least;
    }
    const int owner = min_over_ranks(d.mesh.comm(), mine ? rank : size);
    if (owner == size)
      throw UserError(ExitCode::data, "-probe_" + probe.id + "_at: the point is in no cell of the mesh" +
                                          (anywhere ? "" : " region '" + probe.region + "'") +
                                          "; give reference coordinates inside a body" +
                                          (anywhere ? ", " + nearest_node(d, probe.at) : ""));
    if (owner != rank) found.count = 0;
    probes_.push_back(found);
  }
}

void HistoryObserver::append_probes(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const Discretisation& d = motion_.discretisation();
  for (std::size_t i = 0; i < probes_.size(); ++i)
    for (const std::string& field : scenario_.probes[i].fields) {
      const auto [nodal, components, values] = source_.values(field, snapshot.u);
      const Located& probe = probes_[i];
      for (int k = 0; k < components; ++k) {
        double sum = 0;
        // Contact fields have no value off their surface.
        for (int a = 0; nodal && a < probe.count; ++a)
          if (const double value = values[at(probe.nodes[a] * components + k)];
              std::isfinite(value) || std::abs(probe.N[a]) > 1e-9)
            sum += probe.N[a] * value;
        if (!nodal && probe.count > 0)
          sum = values[(probe.batch * at(components) + at(k)) * lanes + probe.lane];
        row.emplace_back("probe_" + scenario_.probes[i].id + "_" + component_name(field, k, components),
                         sum_over_ranks(d.mesh.comm(), sum));
      }
    }
}

} // namespace impact
