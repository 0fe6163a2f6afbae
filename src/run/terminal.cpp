#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <impact/input/database.hpp>
#include <impact/material/crack.hpp>
#include <impact/math/vector3.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/petsc/shared_cores.hpp>
#include <impact/problem/scalar_field.hpp>
#include <impact/problem/surface_load.hpp>
#include <impact/run/terminal.hpp>
#include <impact/scenario/columns.hpp>
#include <numbers>

namespace impact {

namespace {

const char* name_of(Split split) {
  switch (split) {
  case Split::spectral:
    return ", spectral split";
  case Split::no_tension:
    return ", no-tension split";
  case Split::drucker_prager:
    return ", Drucker-Prager split";
  case Split::star_convex:
    return ", star-convex split";
  case Split::volumetric:
    return ", volumetric split";
  default:
    return ", no split";
  }
}

// The choice of a locking cure, and a word where there is none: for each material and shape, once.
void report_locking(const Scenario& s, const Discretisation& d) {
  if (!s.has_motion() || s.plane == PlaneMode::stress) return;
  const std::size_t shapes = known_shapes().size();
  std::vector<int> found(d.materials.size() * shapes, 0);
  constexpr int present = 1, in_patches = 2;
  for (std::size_t g = 0; g < d.groups.size(); ++g)
    found[at(d.groups[g].material) * shapes + at(index_of(d.groups[g].shape))] =
        !d.patches.empty() && d.patches.in_group[g] != 0 ? in_patches : present;
  max_over_ranks(d.mesh.comm(), found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto& [law, regions, id, points, erosion, fatigue, toughness, factors, E_of_place] =
        d.materials[i / shapes];
    const MaterialParameters& p = law.parameters;
    const Shape shape = known_shapes()[i % shapes];
    const bool simplex = shape->simplex() && shape->order() == 1; // J is constant in it
    const bool cured = simplex ? found[i] == in_patches : p.locking != Locking::none;
    const bool shocks = simplex && s.has_heat() && s.coupling.by_central_differences.bulk.acts();
    if (!found[i]) continue;
    if (cured)
      check(PetscPrintf(d.mesh.comm(), "material %s: locking cure of its %s: %s\n", id.c_str(),
                        shape->names.plural,
                        shocks    ? "mean volume of patches of cells, which shocks warm unevenly (by a sixth)"
                        : simplex ? "mean volume of patches of cells"
                        : p.locking == Locking::mean && shape->volume_modes > 1 ? "volume linear in a cell"
                        : p.locking == Locking::mean                            ? "mean volume of a cell"
                                                                                : "F-bar"));
    // Other cells than linear simplices lock at the user's will.
    if (!keeps_volume(p) || cured || !simplex) continue;
    check(PetscPrintf(
        d.mesh.comm(),
        "impact: material %s: its %s lock, too stiff, because %s; remedy: %s, or a finer mesh\n", id.c_str(),
        shape->names.plural,
        law.flows() ? "plastic flow (j2) keeps the volume" : "it is nearly incompressible (nu from 0.45 on)",
        law.principal() ? "cells of second order (-order 2), or another -material_<id>_split"
                        : "-material_<id>_locking mean, or cells of second order (-order 2)"));
  }
}

// Cells of the mesh over all ranks, in the reference configuration; of a plane problem times its
// thickness, of an axisymmetric one as rings.
struct Extent {
  double count = 0, size = 0, narrowest = HUGE_VAL, widest = 0; // width: edge of a cell of this size
  double length = 0;                                            // longest side of the box around them
};

// Volume of a cell, or of the ring that it stands for, and its width.
struct Size {
  double volume = 0, width = 0;
};

Size size_of(const Discretisation& d, Shape shape, const int* node, double corners) {
  const std::size_t dim = at(d.dim()), nodes = at(shape->nodes);
  const auto X = d.mesh.coordinates();
  double size = 0, ring = 0;
  for (std::size_t q = 0; q < at(shape->points); ++q) {
    Vector3 x{};
    std::array<Vector3, 3> J{{{}, {}, {0, 0, dim == 2 ? 1.0 : 0.0}}};
    for (std::size_t a = 0; a < nodes; ++a)
      for (std::size_t i = 0; i < dim; ++i) {
        const double place = X[at(node[a]) * dim + i];
        x[i] += shape->N[q * nodes + a] * place;
        for (std::size_t k = 0; k < dim; ++k) J[i][k] += place * shape->dN[(q * nodes + a) * dim + k];
      }
    const double part = shape->weight[q] * determinant(J[0], J[1], J[2]);
    size += part;
    ring += 2 * std::numbers::pi * x[0] * part;
  }
  return {d.frame == Frame::axisymmetric ? ring : size * d.thickness,
          std::pow(corners * size, 1.0 / d.dim())};
}

// `cells` rise.
Extent extent_of(const Discretisation& d, const std::vector<PetscInt>& cells, double corners = 1) {
  double sums[2] = {static_cast<double>(cells.size()), 0};
  double most[8]; // -narrowest, widest, -x and x of the nodes
  std::fill(std::begin(most), std::end(most), -HUGE_VAL);
  for (const CellTable& table : d.mesh.cells())
    for (std::size_t c = 0; c < table.point.size(); ++c) {
      if (!std::ranges::binary_search(cells, table.point[c])) continue;
      const int* const node = &table.connectivity[c * at(table.shape->nodes)];
      const Size size = size_of(d, table.shape, node, corners);
      sums[1] += size.volume;
      most[0] = std::max(most[0], -size.width);
      most[1] = std::max(most[1], size.width);
      for (int a = 0; a < table.shape->nodes; ++a)
        for (int i = 0; i < d.dim(); ++i) {
          const double x = d.mesh.coordinates()[at(node[a] * d.dim() + i)];
          most[2 + i] = std::max(most[2 + i], -x);
          most[5 + i] = std::max(most[5 + i], x);
        }
    }
  sum_over_ranks(d.mesh.comm(), sums);
  max_over_ranks(d.mesh.comm(), most);
  return {sums[0], sums[1], -most[0], most[1],
          std::max({most[2] + most[5], most[3] + most[6], most[4] + most[7]})};
}

// Count and size of the facets of a boundary.
std::array<double, 2> size_of_boundary(const Discretisation& d, const std::string& name) {
  const FacetTable facets = d.mesh.facets(name);
  const auto X = d.mesh.coordinates();
  std::array<double, 2> sums{static_cast<double>(facets.count()),
                             area_of(facets, d.frame, {X.begin(), X.end()}) *
                                 (d.frame == Frame::axisymmetric ? 1 : d.thickness)};
  sum_over_ranks(d.mesh.comm(), sums);
  return sums;
}

// How evenly the ranks share what costs time: the fullest one's cells, and its facets of secondary surfaces,
// over the mean. A facet that several contacts want is work for each.
void report_shares(const Scenario& s, const Discretisation& d) {
  const MPI_Comm comm = d.mesh.comm();
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  if (ranks == 1) return;
  std::array<double, 2> most{static_cast<double>(d.mesh.cell_count()), 0};
  for (const ContactSettings& contact : s.contacts) most[1] += d.mesh.facets(contact.secondary).count();
  std::array<double, 2> mean = most;
  max_over_ranks(comm, most);
  sum_over_ranks(comm, mean);
  for (double& value : mean) value /= ranks;
  char text[80] = "";
  if (mean[1] > 0)
    std::snprintf(text, sizeof text, ", %.3f times the mean of %.4g secondary facets", most[1] / mean[1],
                  mean[1]);
  check(PetscPrintf(comm, "ranks: the fullest has %.3f times the mean of %.4g cells%s\n", most[0] / mean[0],
                    mean[0], text));
}

void report_groups(const Discretisation& d) {
  for (const int dim : {d.dim(), d.dim() - 1}) {
    std::string text;
    char entry[160];
    for (const Group& group : d.mesh.groups()) {
      if (group.dim != dim) continue;
      std::array<double, 2> size{};
      if (dim < d.dim()) {
        size = size_of_boundary(d, group.name);
      } else {
        const Extent extent = extent_of(d, d.mesh.region_cells(group.name));
        size = {extent.count, extent.size};
      }
      std::snprintf(entry, sizeof entry, "%s%.80s %.0f (%.4g)", text.empty() ? "" : ", ", group.name.c_str(),
                    size[0], size[1]);
      text += entry;
    }
    if (!text.empty())
      check(PetscPrintf(d.mesh.comm(), "%s: %s\n",
                        dim == d.dim() ? dim == 3 || d.frame == Frame::axisymmetric
                                             ? "regions, their cells (and volume)"
                                             : "regions, their cells (and area times thickness)"
                                       : "boundaries, their facets (and size)",
                        text.c_str()));
  }
}

// The numbers of a material in the user's words, and in the run's units where these had others.
std::string values_text(const Scenario& s, const std::string& id) {
  std::string text;
  for (const MaterialScenario& material : s.materials)
    for (const auto& [name, value, said] : material.options)
      if (const auto literal = split_literal(said); literal && material.id == id)
        text += ", " + name + " " + said +
                (parse_number(literal->number) == parse_number(value) ? "" : " (" + value + ")");
  return text;
}

void report_material(const Scenario& s, const Discretisation& d, const MaterialAssignment& m) {
  const MPI_Comm comm = d.mesh.comm();
  const MaterialParameters& p = m.law.parameters;
  std::vector<PetscInt> cells;
  for (const std::string& region : m.regions)
    for (const PetscInt cell : d.mesh.region_cells(region)) cells.push_back(cell);
  std::ranges::sort(cells);
  // Half a square, a sixth of a cube.
  const auto shapes = known_shapes();
  const bool simplex = std::all_of(shapes.begin(), shapes.end(),
                                   [&](Shape shape) { return shape->simplex() || !d.mesh.has_shape(shape); });
  const Extent extent = extent_of(d, cells, simplex ? (d.dim() == 2 ? 2 : 6) : 1);
  const std::string damage = p.damage == Damage::none
                                 ? ""
                                 : std::string(p.damage == Damage::at2   ? " with at2 damage"
                                               : p.damage == Damage::at1 ? " with at1 damage"
                                                                         : " with wu damage") +
                                       name_of(p.split);
  check(PetscPrintf(comm, "material %s: %s%s%s%s, mass %.6g; cells %.3g to %.3g wide\n", m.id.c_str(),
                    m.law.rigid()          ? "rigid"
                    : p.model == Model::j2 ? "j2"
                                           : "elastic",
                    damage.c_str(), m.law.fatigues() || m.fatigue.works() ? " and fatigue" : "",
                    values_text(s, m.id).c_str(), p.rho * extent.size, extent.narrowest, extent.widest));
  if (p.damage != Damage::none) {
    // A crack is a row of broken cells, halves of those of second order, and what stands beside it (Bourdin,
    // Francfort, Marigo 2008, 8.1).
    const bool halves = d.mesh.order() == 2;
    const double narrowest = extent.narrowest / d.mesh.order(), widest = extent.widest / d.mesh.order();
    const double row = regularisation(p).broken() * narrowest / p.gamma;
    check(PetscPrintf(comm,
                      "material %s: gamma is %.3g to %.3g %s wide; a crack along the narrowest takes %.3g "
                      "Gc, on a plane of symmetry %.3g Gc\n",
                      m.id.c_str(), p.gamma / widest, p.gamma / narrowest, halves ? "half cells" : "cells",
                      1 + row, 1 + 2 * row)); // there a row is half of what is broken
    // A crack narrower than its cells, or wider than its body, is none: its energy is not Gc.
    if (p.gamma < 2 * (1 - 1e-6) * narrowest)
      check(PetscPrintf(comm,
                        "impact: WARNING: -material_%s_gamma %.4g is %.3g times its narrowest %s %.4g: a "
                        "crack wants at least 2, or it takes more than Gc; refine where it will run\n",
                        m.id.c_str(), p.gamma, p.gamma / narrowest, halves ? "half cell" : "cell",
                        narrowest));
    if (p.gamma > extent.length)
      check(
          PetscPrintf(comm,
                      "impact: WARNING: -material_%s_gamma %.4g is %.3g times the size %.4g of its body: no "
                      "crack has room in it; is the unit right?\n",
                      m.id.c_str(), p.gamma, p.gamma / extent.length, extent.length));
  }
  if (s.has_inertia() && !m.law.rigid() && p.rho > 0) {
    const double speed = longitudinal_speed(p);
    check(PetscPrintf(comm, "material %s: h/c_p from %.3g, c_p %.6g\n", m.id.c_str(),
                      extent.narrowest / speed, speed));
  }
}

// Each law has batches of its own, the last of which is seldom full.
void report_places(const Discretisation& d) {
  for (std::size_t m = 0; m < d.materials.size(); ++m)
    if (d.materials[m].factors)
      check(PetscPrintf(
          d.mesh.comm(), "material %s: numbers that differ from place to place, %d laws of cells\n",
          d.materials[m].id.c_str(),
          static_cast<int>(std::ranges::count(d.groups, static_cast<int>(m), &CellGroup::material))));
}

// An output or a checkpoint behind the end never comes.
void report_late(MPI_Comm comm, const Scenario& s) {
  const double end = s.time.max_time, least = end * (1 + 1e-9);
  const double steps = s.time.steps();
  const auto tell = [&](const std::string& option, double value, double limit) {
    if (limit > 0 && value > limit)
      check(PetscPrintf(
          comm, "impact: WARNING: -%s %.10g lies behind the end, -ts_max_time %.10g, about %.0f steps\n",
          option.c_str(), value, end, steps));
  };
  const auto latest = [](const std::vector<double>& times) {
    return times.empty() ? 0 : *std::ranges::max_element(times);
  };
  for (const OutputScenario& output : s.outputs) {
    const std::string key = "output_" + output.id;
    tell(key + "_times", latest(output.times), least);
    tell(key + "_dt", output.dt, least);
    tell(key + "_every", output.every, steps);
    tell(key + "_cycles", output.cycles, s.time.period > 0 ? end / s.time.period : 0);
  }
  tell("ts_dt", s.time.dt, least);
  tell("ts_period", s.time.period, least);
  tell("ts_times", latest(s.time.table_times), least);
  tell("checkpoint_every", s.checkpoint.every, steps);
}

} // namespace

void report_setup(const Scenario& s, const Discretisation& d) {
  const MPI_Comm comm = d.mesh.comm();
  int ranks = 1;
  const int threads = threads_per_rank();
  MPI_Comm_size(comm, &ranks);
  check(PetscPrintf(comm, "impact: %s\n", s.title.empty() ? "(no title)" : s.title.c_str()));
  check(PetscPrintf(comm,
                    "mesh %s: %lld nodes, %lld cells, shortest edge %.4g; %d rank%s, %d thread%s each\n",
                    s.mesh.file.c_str(), static_cast<long long>(d.mesh.global_node_count()),
                    static_cast<long long>(d.mesh.global_cell_count()), d.mesh.smallest_edge(), ranks,
                    ranks == 1 ? "" : "s", threads, threads == 1 ? "" : "s"));
  report_shares(s, d);
  report_groups(d);
  for (const MaterialAssignment& m : d.materials) report_material(s, d, m);
  report_places(d);
  if (s.has_heat())
    for (const MaterialAssignment& m : d.materials)
      check(PetscPrintf(comm, "heat in %s: c_V %.6g, conductivity %.6g, alpha_t %.6g, theta_0 %.6g\n",
                        m.id.c_str(), m.law.parameters.c_v, m.law.parameters.conductivity,
                        m.law.parameters.alpha_t, m.law.parameters.theta0));
  report_locking(s, d);
  report_late(comm, s);
  if (!s.has_motion()) check(PetscPrintf(comm, "no motion: bodies stay where they are\n"));
}

void report_solvers(RunStage& stage) {
  const Discretisation& d = stage.d;
  const MPI_Comm comm = d.mesh.comm();
  for (ContactInterface& contact : stage.setup->contacts) {
    const ContactMeasures at_start = contact.measures(stage.u);
    check(PetscPrintf(comm,
                      std::isnan(at_start.gap_min)
                          ? "contact %s: no point faces the other side at the start\n"
                          : "contact %s: smallest gap at the start %.4g, %d points press\n",
                      contact.id().c_str(), at_start.gap_min + 0.0, at_start.active)); // no -0
    tell_of_overlap(stage, contact, at_start.gap_min);
    if (const std::string& id = contact.id();
        contact.settings().impact == ImpactUpdate::conserving && !stage.scenario.has_inertia())
      check(
          PetscPrintf(comm,
                      "impact: contact %s presses by a penalty, in these steps without inertia too, because "
                      "of -contact_%s_impact conserving\n",
                      id.c_str(), id.c_str()));
  }
  const bool motion = stage.scenario.has_motion();
  const SolverDefaults& solver = stage.solver;
  SNES snes = stage.coupling.motion_solver().snes();
  if (ExplicitStep* const step = stage.coupling.explicit_step())
    check(PetscPrintf(comm, "%s\n", step->text(stage.scenario.time.dt).c_str()));
  else if (motion)
    check(PetscPrintf(comm, "motion solver: %s (%s); tangent %s%s\n", linear_solver_text(snes).c_str(),
                      solver.reason.c_str(), solver.symmetric ? "symmetric" : "consistent",
                      solver.matrix == MatrixFormat::sbaij ? ", its upper half" : ""));
  if (stage.damage)
    check(PetscPrintf(comm, "damage solver: %s%s\n", linear_solver_text(stage.damage->snes()).c_str(),
                      d.mesh.order() == 2 && has_linear_damage(stage.scenario.damage, d.mesh)
                          ? "; phi of first order"
                          : ""));
  if (stage.heat)
    check(PetscPrintf(comm, "heat solver: %s; capacity %s\n", linear_solver_text(stage.heat->snes()).c_str(),
                      stage.d.lumped_capacity ? "lumped" : "consistent"));
  const bool factors = has_type(Get(KSPGetPC)(Get(SNESGetKSP)(snes)), PCLU, PCCHOLESKY);
  PetscLogDouble bytes = 0;
  check(PetscMemoryGetCurrentUsage(&bytes));
  bytes = max_over_ranks(comm, bytes);
  char text[100] = "";
  if (motion && factors && !stage.scenario.explicit_steps()) {
    // MUMPS on quadrilaterals (5,200 and 46,000 dofs) and hexahedra (2,200 and 15,000): within a quarter.
    const double n = static_cast<double>(d.mesh.global_node_count()) * d.dim();
    const double entries = d.dim() == 2 ? 10 * n * std::log2(n) : 38 * std::pow(n, 4.0 / 3);
    std::snprintf(text, sizeof text, "; the factors of the motion take about %.3g MB in all",
                  12e-6 * entries);
  }
  check(
      PetscPrintf(comm, "memory: %.3g MB on the fullest rank before the first step%s\n", 1e-6 * bytes, text));
}

void Progress::header() const { check(PetscPrintf(comm_, "%s\n", terminal_heads().c_str())); }

void Progress::line(const Snapshot& at, const StepCounts& c, const Ledger& ledger, int active) {
  const double wall = this->wall();
  if (first_time_ < 0) first_time_ = at.time - at.dt;
  const double done = at.time - first_time_;
  const double left = done > 0 ? wall * (t_end_ - at.time) / done : 0;
  check(PetscPrintf(comm_, "%8ld %12.6g %10.3g %3d %4d %6d %4d %3d %4d %8.5f %9.3g %10.2e %8s %8s\n", at.step,
                    at.time, at.dt, at.tries, static_cast<int>(c.newton), static_cast<int>(c.linear),
                    static_cast<int>(c.damage), static_cast<int>(c.uzawa), active, ledger.energies().phi_max,
                    ledger.energies().alpha_max, ledger.balance_first_law(), clock(wall).c_str(),
                    clock(left).c_str()));
}

std::string Progress::clock(double seconds) {
  char text[32];
  const long s = std::lround(seconds);
  if (s < 3600)
    std::snprintf(text, sizeof(text), "%ld:%02ld", s / 60, s % 60);
  else
    std::snprintf(text, sizeof(text), "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  return text;
}

} // namespace impact
