#include <algorithm>
#include <cmath>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/crack_tips.hpp>
#include <impact/run/observers.hpp>
#include <impact/scenario/columns.hpp>
#include <tuple>

namespace impact {

namespace {

constexpr const char* axis[3] = {"x", "y", "z"};

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

// Columns for the components of a vector from `first` on.
void add_axes(HistoryFile::Row& row, const std::string& name, const double* values, std::size_t end,
              std::size_t first = 0) {
  for (std::size_t k = first; k < end; ++k) row.emplace_back(name + axis[k], values[k]);
}

} // namespace

bool marks_cycle(double time, double period, int every) {
  const double halves = std::round(2 * time / period);
  if (std::abs(2 * time / period - halves) > 1e-9 * std::max(1.0, halves)) return false;
  return std::llround(std::ceil(halves / 2)) % every == 0;
}

std::string history_file_name(const Scenario& scenario) {
  for (const OutputScenario& output : scenario.outputs)
    if (output.type == OutputScenario::Type::csv) return output.file;
  return "history.csv";
}

HistoryObserver::HistoryObserver(const Scenario& scenario, MotionProblem& motion, const Ledger& ledger,
                                 StateTable& state, const FieldSource& source)
    : scenario_(scenario), motion_(motion), ledger_(ledger), v_(state.row("v")), phi_(state.find("phi")),
      source_(source) {
  for (const OutputScenario& output : scenario_.outputs)
    if (output.type == OutputScenario::Type::csv) cycles_ = std::max(cycles_, output.cycles);
  const Discretisation& d = motion_.discretisation();
  for (std::size_t m = 0; m < d.materials.size(); ++m) {
    const auto& [law, regions, id, points] = d.materials[m];
    if (law.parameters.damage == Damage::none) continue;
    const int numbers = 4 * scenario_.crack_tips;
    cracks_.push_back({m, {}, state.add({"crack_" + id, Support::global, numbers}, at(numbers))});
    for (const std::string& region : regions) {
      const std::vector<int> more = d.mesh.nodes(region);
      cracks_.back().nodes.insert(cracks_.back().nodes.end(), more.begin(), more.end());
    }
  }
  for (const ProbeScenario& probe : scenario_.probes)
    for (const std::string& field : probe.fields) source_.require("-probe_" + probe.id + "_fields", field);
  for (const MeasureScenario& measure : scenario_.measures)
    for (const std::string& field : measure.fields)
      source_.require("-measure_" + measure.id + "_fields", field, true);
  locate_probes();
}

void HistoryObserver::open(std::optional<long> resume_after) {
  file_.emplace(motion_.discretisation().mesh.comm(),
                scenario_.output_dir + "/" + history_file_name(scenario_), resume_after,
                [units = scenario_.units, plane = motion_.discretisation().dim() == 2 &&
                                                  motion_.discretisation().frame != Frame::axisymmetric](
                    const std::string& column) { return column_unit(column, units, plane); });
}

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
    const bool anywhere = probe.region.empty();
    const std::vector<PetscInt> listed = anywhere ? obstacles : d.mesh.region_cells(probe.region);
    for (const CellTable& table : d.mesh.cells())
      for (std::size_t c = 0; c < table.point.size() && found.count == 0; ++c) {
        if ((std::ranges::find(listed, table.point[c]) == listed.end()) != anywhere) continue;
        const int nodes = table.shape->nodes, dim = d.dim();
        const int* const node = &table.connectivity[c * at(nodes)];
        double X[3 * max_nodes];
        for (int a = 0; a < nodes; ++a)
          std::copy_n(&d.mesh.coordinates()[at(node[a] * dim)], dim, X + a * dim);
        if (!locate(table.shape, X, probe.at, found.N)) continue;
        found.count = nodes;
        std::copy_n(node, nodes, found.nodes);
        std::tie(found.batch, found.lane) = find_lane(d.groups, table.point[c]);
      }
    // The lowest rank that holds the point keeps it.
    const int owner = min_over_ranks(d.mesh.comm(), found.count > 0 ? rank : size);
    if (owner == size)
      throw UserError(ExitCode::data, "-probe_" + probe.id + "_at: the point is in no cell of the mesh" +
                                          (anywhere ? "" : " region '" + probe.region + "'") +
                                          "; give reference coordinates inside a body");
    if (owner != rank) found.count = 0;
    probes_.push_back(found);
  }
}

void HistoryObserver::append_contacts(HistoryFile::Row& row, const Snapshot& snapshot) const {
  for (ContactInterface& contact : motion_.contacts()) {
    const ContactMeasures m = contact.measures(snapshot.u);
    const std::string id = "contact_" + contact.id() + "_";
    const std::size_t dim = at(motion_.discretisation().dim());
    add_axes(row, id + "force_", m.force.data(), dim);
    row.emplace_back(id + "gap_min", m.gap_min);
    row.emplace_back(id + "pressure_max", m.pressure_max);
    row.emplace_back(id + "pressure_min", m.pressure_min);
    row.emplace_back(id + "active", m.active);
    row.emplace_back(id + "length", m.length);
    row.emplace_back(id + "work", m.work);
    if (contact.frictional()) {
      row.emplace_back(id + "sliding", m.sliding);
      row.emplace_back(id + "dissipated", m.dissipated);
    }
    add_axes(row, "impulse_" + contact.id() + "_", m.impulse.data(), dim);
  }
}

void HistoryObserver::append_rigid_bodies(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const RigidBodies& rigid = motion_.rigid();
  if (rigid.empty()) return;
  const Discretisation& d = motion_.discretisation();
  const std::size_t dim = at(d.dim()), first_turn = dim == 2 ? 2 : 0;
  const Handle<Vec> v = d.displacement.make_global();
  d.displacement.to_global(v_.committed, v);
  const std::vector<RigidMotionState> motion = rigid.motion(snapshot.u, v);
  for (std::size_t b = 0; b < motion.size(); ++b) {
    const std::string id = "rigid_" + rigid.bodies()[b].name + "_";
    Vector3 turned = rotation_vector(motion[b].pose.turned), spin = motion[b].spin;
    if (dim == 2) turned[2] = rigid.angle(static_cast<int>(b));
    for (double& component : spin) component = d.thickness * component;
    add_axes(row, id + "u", motion[b].pose.moved.data(), dim);
    add_axes(row, id + "r", turned.data(), 3, first_turn);
    add_axes(row, id + "v", motion[b].velocity.data(), dim);
    add_axes(row, id + "w", motion[b].velocity.data() + 3, 3, first_turn);
    add_axes(row, id + "l", spin.data(), 3, first_turn);
  }
}

void HistoryObserver::append_cracks(HistoryFile::Row& row) {
  const Discretisation& d = motion_.discretisation();
  if (!phi_) return;
  if (phi_before_.empty()) phi_before_ = phi_->committed;
  for (const auto& [m, nodes, kept] : cracks_) {
    const MaterialParameters& p = d.materials[m].law.parameters;
    std::vector<Crack> cracks(kept.committed.size() / 4);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      cracks[i].there = kept.committed[4 * i] != 0;
      std::copy_n(&kept.committed[4 * i + 1], 3, cracks[i].origin.begin());
    }
    std::vector<char> cracked(d.node_values(1), 0);
    for (int node : nodes) cracked[at(node)] = phi_->committed[at(node)] > scenario_.crack_level;
    const int count = follow_cracks(d.mesh, cracked, phi_before_, cracks);
    row.emplace_back("crack_" + d.materials[m].id + "_count", count);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      const Crack& crack = cracks[i];
      kept.committed[4 * i] = crack.there;
      std::copy_n(crack.origin.begin(), 3, &kept.committed[4 * i + 1]);
      const std::string id = "crack_" + d.materials[m].id + (i > 0 ? "_" + std::to_string(i + 1) : "");
      const Vector3 nowhere{NAN, NAN, NAN};
      add_axes(row, id + "_origin_", (crack.there ? crack.origin : nowhere).data(), at(d.dim()));
      add_axes(row, id + "_tip_", (crack.there && !crack.joined ? crack.tip : nowhere).data(), at(d.dim()));
    }
    kept.trial = kept.committed;
    row.emplace_back("crack_" + d.materials[m].id + "_measure",
                     ledger_.energies().of[m].fracture / (p.Gc * d.thickness));
  }
  phi_before_ = phi_->committed;
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

void HistoryObserver::append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const Discretisation& d = motion_.discretisation();
  using Of = MeasureScenario::Of;
  for (const MeasureScenario& measure : scenario_.measures) {
    const std::vector<int> nodes = d.mesh.nodes(measure.on);
    for (const std::string& field : measure.fields) {
      const FieldValues of = source_.values(field, snapshot.u);
      for (int k = 0; k < of.components; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL, sums[2] = {0, 0};
        for (int node : nodes) {
          const double value = of.values[at(node * of.components + k)];
          if (!d.mesh.owned(node) || std::isnan(value)) continue; // a gap to nothing
          low = std::min(low, value);
          high = std::max(high, value);
          sums[0] += value;
          sums[1] += 1;
        }
        low = min_over_ranks(d.mesh.comm(), low);
        high = max_over_ranks(d.mesh.comm(), high);
        sum_over_ranks(d.mesh.comm(), sums);
        const double value = measure.of == Of::min   ? low
                             : measure.of == Of::max ? high
                             : measure.of == Of::sum ? sums[0]
                                                     : sums[0] / std::max(sums[1], 1.0);
        row.emplace_back("measure_" + measure.id + "_" + component_name(field, k, of.components), value);
      }
    }
  }
}

HistoryFile::Row HistoryObserver::row(const Snapshot& snapshot, const StepCounts& counts) {
  HistoryFile::Row row{{"step", static_cast<double>(snapshot.step)},
                       {"time", snapshot.time},
                       {"dt", snapshot.dt},
                       {"tries", snapshot.tries},
                       {"newton", counts.newton},
                       {"linear", counts.linear}};
  if (!motion_.contacts().empty()) {
    row.emplace_back("uzawa", counts.uzawa);
    row.emplace_back("newton_most", counts.longest);
  }
  if (motion_.discretisation().has_damage()) row.emplace_back("damage_its", counts.damage);
  if (motion_.discretisation().has_heat()) row.emplace_back("heat_its", counts.heat);
  ledger_.append(row);
  append_contacts(row, snapshot);
  ledger_.append_contact_heat(row);
  append_rigid_bodies(row, snapshot);
  ledger_.append_materials(row);
  append_cracks(row);
  append_probes(row, snapshot);
  append_measures(row, snapshot);
  return row;
}

HistoryFile::Row HistoryObserver::watch(const Snapshot& snapshot, const StepCounts& counts) {
  const InStage stage(Stage::output);
  const Timed timed(Event::history);
  HistoryFile::Row now = row(snapshot, counts);
  if (every_step() || marks_cycle(snapshot.time, scenario_.time.period, cycles_)) file_->write(now);
  return now;
}

} // namespace impact
