#include <algorithm>
#include <cmath>
#include <impact/math/rotation.hpp>
#include <impact/petsc/error.hpp>
#include <impact/petsc/log.hpp>
#include <impact/problem/cell_loop.hpp>
#include <impact/run/crack_tips.hpp>
#include <impact/run/observers.hpp>
#include <impact/scenario/columns.hpp>

namespace impact {

namespace {

constexpr const char* axis[3] = {"x", "y", "z"};

// Where cell fields, [group][batch][component][lane], have the cell of a mesh point.
void find_lane(const std::vector<CellGroup>& groups, PetscInt point, std::size_t& batch, std::size_t& lane) {
  std::size_t first = 0;
  for (const CellGroup& group : groups) {
    const auto at = std::find(group.cell_point.begin(), group.cell_point.end(), point);
    if (at != group.cell_point.end()) {
      const auto index = static_cast<std::size_t>(at - group.cell_point.begin());
      batch = first + index / lanes;
      lane = index % lanes;
      return;
    }
    first += static_cast<std::size_t>(group.batch_count);
  }
}

} // namespace

bool marks_cycle(double time, double period, int every) {
  const double halves = std::round(2 * time / period);
  if (std::abs(2 * time / period - halves) > 1e-9 * std::max(1.0, halves)) return false;
  return std::llround(std::ceil(halves / 2)) % every == 0;
}

std::string history_file_name(const Scenario& scenario) {
  for (const OutputScenario& output : scenario.outputs)
    if (output.type == OutputScenario::Type::csv && !output.file.empty()) return output.file;
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
    cracks_.push_back(
        {m, {}, state.add({"crack_" + id, Support::global, numbers}, static_cast<std::size_t>(numbers))});
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
  for (const ProbeScenario& probe : scenario_.probes) {
    Located found;
    std::vector<PetscInt> region =
        probe.region.empty() ? std::vector<PetscInt>() : d.mesh.region_cells(probe.region);
    for (const CellTable& table : d.mesh.cells())
      for (std::size_t c = 0; c < table.point.size() && found.count == 0; ++c) {
        if (!probe.region.empty() && std::find(region.begin(), region.end(), table.point[c]) == region.end())
          continue;
        if (probe.region.empty() &&
            std::find(obstacles.begin(), obstacles.end(), table.point[c]) != obstacles.end())
          continue;
        const int nodes = table.shape->nodes, dim = d.dim();
        const int* node = &table.connectivity[c * static_cast<std::size_t>(nodes)];
        double X[3 * max_nodes], N[max_nodes];
        for (int i = 0; i < nodes * dim; ++i)
          X[i] = d.mesh.coordinates()[static_cast<std::size_t>(node[i / dim] * dim + i % dim)];
        if (!locate(table.shape, X, probe.at, N)) continue;
        found.count = nodes;
        find_lane(d.groups, table.point[c], found.batch, found.lane);
        std::copy_n(node, nodes, found.nodes);
        std::copy_n(N, nodes, found.N);
      }
    // The lowest rank that holds the point keeps it.
    int rank = 0, size = 1;
    MPI_Comm_rank(d.mesh.comm(), &rank);
    MPI_Comm_size(d.mesh.comm(), &size);
    int owner = found.count > 0 ? rank : size;
    MPI_Allreduce(MPI_IN_PLACE, &owner, 1, MPI_INT, MPI_MIN, d.mesh.comm());
    if (owner == size)
      throw UserError(ExitCode::data, "-probe_" + probe.id + "_at: the point is in no cell of the mesh" +
                                          (probe.region.empty() ? "" : " region '" + probe.region + "'") +
                                          "; give reference coordinates inside a body");
    if (owner != rank) found.count = 0;
    probes_.push_back(found);
  }
}

void HistoryObserver::append_contacts(HistoryFile::Row& row, const Snapshot& snapshot) const {
  for (ContactInterface& contact : motion_.contacts()) {
    const ContactMeasures m = contact.measures(snapshot.u);
    const std::string id = "contact_" + contact.id() + "_";
    const auto dim = static_cast<std::size_t>(motion_.discretisation().dim());
    for (std::size_t k = 0; k < dim; ++k) row.emplace_back(id + "force_" + axis[k], m.force[k]);
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
    for (std::size_t k = 0; k < dim; ++k)
      row.emplace_back("impulse_" + contact.id() + "_" + axis[k], m.impulse[k]);
  }
}

void HistoryObserver::append_rigid_bodies(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const RigidBodies& rigid = motion_.rigid();
  if (rigid.empty()) return;
  const Discretisation& d = motion_.discretisation();
  const auto dim = static_cast<std::size_t>(d.dim());
  const Handle<Vec> v = d.displacement.make_global();
  d.displacement.to_global(v_.committed, v);
  const std::vector<RigidMotionState> motion = rigid.motion(snapshot.u, v);
  for (std::size_t b = 0; b < motion.size(); ++b) {
    const std::string id = "rigid_" + rigid.bodies()[b].name + "_";
    Vector3 turned = rotation_vector(motion[b].pose.turned);
    if (dim == 2) turned[2] = rigid.angle(static_cast<int>(b));
    const RigidVector& rate = motion[b].velocity;
    for (std::size_t k = 0; k < dim; ++k) row.emplace_back(id + "u" + axis[k], motion[b].pose.moved[k]);
    for (std::size_t k = dim == 2 ? 2 : 0; k < 3; ++k) row.emplace_back(id + "r" + axis[k], turned[k]);
    for (std::size_t k = 0; k < dim; ++k) row.emplace_back(id + "v" + axis[k], rate[k]);
    for (std::size_t k = dim == 2 ? 2 : 0; k < 3; ++k) row.emplace_back(id + "w" + axis[k], rate[3 + k]);
    for (std::size_t k = dim == 2 ? 2 : 0; k < 3; ++k)
      row.emplace_back(id + "l" + axis[k], d.thickness * motion[b].spin[k]);
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
    for (int node : nodes)
      cracked[static_cast<std::size_t>(node)] =
          phi_->committed[static_cast<std::size_t>(node)] > scenario_.crack_level;
    const int count = follow_cracks(d.mesh, d.scalar, cracked, phi_before_, cracks);
    row.emplace_back("crack_" + d.materials[m].id + "_count", count);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      const Crack& crack = cracks[i];
      kept.committed[4 * i] = crack.there;
      std::copy_n(crack.origin.begin(), 3, &kept.committed[4 * i + 1]);
      const std::string id = "crack_" + d.materials[m].id + (i > 0 ? "_" + std::to_string(i + 1) : "");
      for (std::size_t k = 0; k < static_cast<std::size_t>(d.dim()); ++k)
        row.emplace_back(id + "_origin_" + axis[k], crack.there ? crack.origin[k] : NAN);
      for (std::size_t k = 0; k < static_cast<std::size_t>(d.dim()); ++k)
        row.emplace_back(id + "_tip_" + axis[k], crack.there && !crack.joined ? crack.tip[k] : NAN);
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
      int components = 1;
      const bool nodal = FieldSource::is_nodal(field);
      const std::vector<double> values =
          nodal ? source_.nodal(field, snapshot, components) : source_.cellwise(field, snapshot, components);
      const Located& probe = probes_[i];
      for (int k = 0; k < components; ++k) {
        double sum = 0;
        // Contact fields have no value off their surface.
        if (nodal) {
          for (int a = 0; a < probe.count; ++a)
            if (const double value = values[static_cast<std::size_t>(probe.nodes[a] * components + k)];
                std::isfinite(value) || std::abs(probe.N[a]) > 1e-9)
              sum += probe.N[a] * value;
        } else if (probe.count > 0)
          sum = values[(probe.batch * static_cast<std::size_t>(components) + static_cast<std::size_t>(k)) *
                           lanes +
                       probe.lane];
        MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, d.mesh.comm());
        row.emplace_back("probe_" + scenario_.probes[i].id + "_" + component_name(field, k, components), sum);
      }
    }
}

void HistoryObserver::append_measures(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const Discretisation& d = motion_.discretisation();
  using Of = MeasureScenario::Of;
  for (const MeasureScenario& measure : scenario_.measures) {
    const std::vector<int> nodes = d.mesh.nodes(measure.on);
    for (const std::string& field : measure.fields) {
      int components = 1;
      const std::vector<double> values = source_.nodal(field, snapshot, components);
      for (int k = 0; k < components; ++k) {
        double low = HUGE_VAL, high = -HUGE_VAL, sums[2] = {0, 0};
        for (int node : nodes) {
          if (!d.mesh.owned(node)) continue;
          const double value = values[static_cast<std::size_t>(node * components + k)];
          if (std::isnan(value)) continue; // a gap to nothing
          low = std::min(low, value);
          high = std::max(high, value);
          sums[0] += value;
          sums[1] += 1;
        }
        MPI_Allreduce(MPI_IN_PLACE, &low, 1, MPI_DOUBLE, MPI_MIN, d.mesh.comm());
        MPI_Allreduce(MPI_IN_PLACE, &high, 1, MPI_DOUBLE, MPI_MAX, d.mesh.comm());
        MPI_Allreduce(MPI_IN_PLACE, sums, 2, MPI_DOUBLE, MPI_SUM, d.mesh.comm());
        const double value = measure.of == Of::min   ? low
                             : measure.of == Of::max ? high
                             : measure.of == Of::sum ? sums[0]
                                                     : sums[0] / std::max(sums[1], 1.0);
        row.emplace_back("measure_" + measure.id + "_" + component_name(field, k, components), value);
      }
    }
  }
}

HistoryFile::Row HistoryObserver::row(const Snapshot& snapshot, const StepCounts& counts) {
  HistoryFile::Row row;
  row.emplace_back("step", static_cast<double>(snapshot.step));
  row.emplace_back("time", snapshot.time);
  row.emplace_back("dt", snapshot.dt);
  row.emplace_back("tries", snapshot.tries);
  row.emplace_back("newton", counts.newton);
  row.emplace_back("linear", counts.linear);
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
