#include <algorithm>
#include <cmath>
#include <cstdio>
#include <impact/input/units.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/shifted_mesh.hpp>
#include <impact/problem/deep_overlap.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <impact/run/obstacle_body.hpp>
#include <impact/run/setup.hpp>
#include <impact/run/stop_requests.hpp>

namespace impact {

namespace {

// Left of the axis a ring would have a negative volume.
void check_radii(const Mesh& mesh) {
  const auto dim = static_cast<std::size_t>(mesh.dim());
  const auto X = mesh.coordinates();
  std::string trouble;
  for (std::size_t i = 0; i < X.size() && trouble.empty(); i += dim)
    if (X[i] < -1e-8 * mesh.smallest_edge())
      trouble = "-plane \"axisymmetric\": x is the radius, and the mesh has a node at (" + number_text(X[i]) +
                ", " + number_text(X[i + 1]) + "); allowed: x >= 0; move or mirror the mesh";
  throw_first(mesh.comm(), ExitCode::data, trouble);
}

// `obstacles`: becomes the bodies of rigid obstacles with mass. `file`: filled where it was not kept.
Mesh make_mesh(MPI_Comm comm, const Scenario& s, std::vector<ObstacleBody>& obstacles, GmshFile& file,
               bool kept) {
  MeshRequest request;
  if (s.has_motion())
    request.add = [&](int dim, const std::array<double, 6>& box) {
      std::vector<AddedCell> cells;
      for (const ContactScenario& contact : s.contacts) {
        if (contact.carrier.empty()) continue;
        obstacles.push_back(obstacle_body(contact, dim, s.plane, s.thickness, box));
        cells.push_back(obstacles.back().cell);
      }
      return cells;
    };
  request.file = s.mesh.file;
  request.parameters = s.mesh.set;
  request.scale = s.mesh.scale;
  request.refine = s.mesh.refine;
  request.most_cells = s.mesh.most_cells;
  request.patience = s.mesh.patience;
  request.work_dir = s.output_dir;
  request.reason_to_stop = [&] { return reason_to_stop({s.checkpoint.walltime, s.checkpoint.margin()}); };
  // A contact facet costs about as much as a few cells: they are spread over the ranks from the start.
  for (const ContactSettings& contact : s.contacts)
    for (const std::string& side : {contact.secondary, contact.primary})
      if (!ContactSettings::rigid_name(side)) request.weights.boundary[side] = 4;
  if (!kept) file = read_mesh_file(comm, request);
  Mesh mesh = build_mesh(comm, request, file);
  check_groups(s, mesh.groups(), mesh.dim());
  if (s.plane == PlaneMode::axisymmetric) check_radii(mesh);
  return mesh;
}

std::vector<MaterialAssignment> assign_materials(const Scenario& s,
                                                 const std::vector<ObstacleBody>& obstacles) {
  std::vector<MaterialAssignment> materials;
  for (const MaterialScenario& m : s.materials) {
    MaterialParameters p = m.law;
    // Physics that is switched off leaves no trace in the law. A body that is not moved expands freely.
    if (!s.has_damage()) p.damage = Damage::none;
    if (!s.has_motion() || p.damage == Damage::none) p.fatigue_a = 0;
    if (!s.has_heat()) p.c_v = 0;
    if (!s.has_motion()) {
      p.model = Model::elastic;
      p.b_d = p.alpha_t = 0;
      p.locking = Locking::none;
    }
    materials.push_back({PointLaw{p}, m.regions});
  }
  for (const ObstacleBody& body : obstacles) {
    MaterialParameters p;
    p.id = body.cell.region;
    p.model = Model::rigid;
    p.rho = body.density;
    materials.push_back({PointLaw{p}, {body.cell.region}});
  }
  return materials;
}

double softer_modulus(const Discretisation& d) {
  double softest = HUGE_VAL;
  for (const MaterialAssignment& m : d.materials) {
    const MaterialParameters& p = m.law.parameters;
    if (m.law.rigid()) continue;
    softest = std::min(softest, 9 * p.K * p.G / (3 * p.K + p.G));
  }
  return std::isinf(softest) ? 0 : softest;
}

ContactSet make_contacts(const Scenario& s, const Discretisation& d, StateTable& state) {
  ContactSet contacts;
  for (const ContactScenario& contact : s.contacts) {
    ContactSettings settings = contact;
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto& u = contact.rigid_u[k]; u && contact.carrier.empty())
        settings.rigid_motion[k] = [u = *u, dim = d.dim()](double t) {
          const std::array<double, 3> origin{};
          return u(origin.data(), dim, t);
        };
    if (const auto& theta = contact.temperature)
      settings.rigid_temperature = [theta = *theta, dim = d.dim()](double t) {
        const std::array<double, 3> origin{};
        return theta(origin.data(), dim, t);
      };
    ContactEnvironment environment;
    environment.frame = d.frame;
    environment.thickness = d.thickness;
    environment.modulus = softer_modulus(d);
    // The mass of cells counts beside their stiffness; where all is rigid, that there is inertia at all.
    for (const bool rigid : {false, true})
      for (const MaterialAssignment& m : d.materials)
        if (s.has_inertia() && m.law.rigid() == rigid && (!rigid || environment.density == 0))
          environment.density = std::max(environment.density, m.law.parameters.rho);
    contacts.emplace_back(d.mesh, d.displacement, settings, environment, state);
  }
  return contacts;
}

// Conditions of physics that is switched off are passed over.
std::vector<BoundaryCondition> conditions_at_work(const Scenario& s, int dim) {
  std::vector<BoundaryCondition> conditions;
  for (const BoundaryCondition& bc : s.bcs)
    if (is_thermal(bc.type)         ? s.has_heat()
        : bc.type == BcType::damage ? s.has_damage() || s.has_motion()
                                    : s.has_motion())
      conditions.push_back(bc);
  if (s.has_motion())
    for (BoundaryCondition& bc : obstacle_conditions(s, dim)) conditions.push_back(std::move(bc));
  return conditions;
}

Frame frame_of(PlaneMode plane) {
  return plane == PlaneMode::axisymmetric ? Frame::axisymmetric
         : plane == PlaneMode::stress     ? Frame::plane_stress
                                          : Frame::plane_strain;
}

std::unique_ptr<Setup> build_on(Mesh mesh, const Scenario& s, const std::vector<ObstacleBody>& obstacles) {
  Discretisation d =
      discretise(std::move(mesh), assign_materials(s, obstacles), frame_of(s.plane), s.thickness);
  std::vector<BoundaryCondition> conditions = conditions_at_work(s, d.dim());
  RigidBodies rigid(d, conditions, s.time.max_time);
  BoundaryData boundary(d.mesh, std::move(conditions), s.time.max_time, rigid.body_of_node());
  auto setup =
      std::make_unique<Setup>(Setup{std::move(d), {}, std::move(rigid), std::move(boundary), {}, {}});
  declare_state(setup->discretisation, setup->state);
  setup->rigid.declare_state(setup->state);
  if (s.has_motion()) setup->contacts = make_contacts(s, setup->discretisation, setup->state);
  return setup;
}

// What the overlap at the start of one contact has moved so far, [local node][dim].
struct Adjusted {
  std::vector<double> total;

  void add(const std::vector<double>& shift) {
    total.resize(shift.size(), 0.0);
    for (std::size_t i = 0; i < shift.size(); ++i) total[i] += shift[i];
  }
};

// A restart on other ranks must find the same coordinates: sums of shifts agree but for rounding, so that the
// last digits are left away.
void round_off(std::vector<double>& shift, double tolerance) {
  const double quantum = std::exp2(std::floor(std::log2(1e-7 * tolerance)));
  for (double& value : shift) value = quantum * std::round(value / quantum);
}

void report(const ContactSettings& contact, const Adjusted& adjusted, const Mesh& mesh) {
  if (adjusted.total.empty()) return;
  const auto dim = static_cast<std::size_t>(mesh.dim());
  int count = 0;
  double farthest = 0;
  for (int node = 0; node < mesh.node_count(); ++node) {
    double square = 0;
    for (std::size_t k = 0; k < dim; ++k) {
      const double way = adjusted.total[static_cast<std::size_t>(node) * dim + k];
      square += way * way;
    }
    if (square > 0 && mesh.owned(node)) ++count;
    farthest = std::max(farthest, std::sqrt(square));
  }
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, mesh.comm());
  MPI_Allreduce(MPI_IN_PLACE, &farthest, 1, MPI_DOUBLE, MPI_MAX, mesh.comm());
  PetscPrintf(mesh.comm(),
              "impact: contact %s: %d nodes of `%s` overlapped `%s` and were moved out, by up to %.4g; "
              "no stress comes of it\n",
              contact.id.c_str(), count, contact.secondary.c_str(), contact.primary.c_str(), farthest);
}

// Moves the secondary nodes of contacts that overlap at the start out of their primaries, contact by contact,
// and builds everything on the mesh that this makes. What is moved may overlap something else, a little, or a
// curved surface by the square of the way: more than one round.
void adjust_overlaps(const Scenario& s, const std::vector<ObstacleBody>& obstacles,
                     std::unique_ptr<Setup>& setup) {
  constexpr int rounds = 5;
  std::vector<Adjusted> adjusted(setup->contacts.size());
  for (int round = 1, moved = 1; moved > 0; ++round) {
    moved = 0;
    for (std::size_t i = 0; i < adjusted.size(); ++i) {
      InitialOverlapReport overlap = setup->contacts[i].initial_overlap();
      if (overlap.nodes == 0) continue;
      const ContactSettings& contact = setup->contacts[i].settings();
      if (round > rounds)
        throw UserError(ExitCode::data,
                        "-contact_" + contact.id + "_initial adjust: " + std::to_string(overlap.nodes) +
                            " nodes of `" + contact.secondary + "` still overlap `" + contact.primary +
                            "` after " + std::to_string(rounds) + " moves" +
                            (adjusted.size() > 1 ? ", perhaps those of one contact into the bodies of another"
                                                 : "; the surface of `" + contact.primary +
                                                       "` is too coarse or too sharp there") +
                            "; part the surfaces in the mesh");
      round_off(overlap.shift, contact.initial_tol);
      adjusted[i].add(overlap.shift);
      moved += overlap.nodes;
      try {
        setup = build_on(shifted_mesh(setup->discretisation.mesh, overlap.shift), s, obstacles);
      } catch (const UserError& error) { // of all ranks
        char way[32];
        std::snprintf(way, sizeof way, "%.4g", overlap.deepest);
        throw UserError(error.code(), "-contact_" + contact.id + "_initial adjust: moves " +
                                          std::to_string(overlap.nodes) + " nodes of `" + contact.secondary +
                                          "` by up to " + way + ", more than its cells have room for (" +
                                          error.what() +
                                          "); part the bodies in the mesh, or exchange the two sides");
      }
    }
  }
  for (std::size_t i = 0; i < adjusted.size(); ++i)
    report(setup->contacts[i].settings(), adjusted[i], setup->discretisation.mesh);
}

// Every pair is looked at in each residual and couples its nodes in the matrix.
void report_pairs(const ContactInterface& contact, MPI_Comm comm) {
  constexpr double many = 30;
  const double pairs = contact.pairs_per_facet();
  if (contact.settings().rigid() || pairs == 0) return;
  const std::string& id = contact.id();
  PetscPrintf(comm, "contact %s: %.3g candidate pairs per secondary facet\n", id.c_str(), pairs);
  if (pairs > many)
    PetscPrintf(
        comm,
        "impact: contact %s: more than %g pairs per facet make steps slow: the facets of one side are "
        "far larger than those of the other, or -contact_%s_search_radius is\n",
        id.c_str(), many, id.c_str());
}

} // namespace

std::unique_ptr<Setup> build_setup(MPI_Comm comm, const Scenario& s, const GmshFile* kept) {
  std::vector<ObstacleBody> obstacles;
  GmshFile file = kept != nullptr ? *kept : GmshFile{};
  Mesh mesh = make_mesh(comm, s, obstacles, file, kept != nullptr);
  std::unique_ptr<Setup> setup = build_on(std::move(mesh), s, obstacles);
  for (const ContactInterface& contact : setup->contacts)
    for (const std::string& warning : contact.warnings()) PetscPrintf(comm, "impact: %s\n", warning.c_str());
  adjust_overlaps(s, obstacles, setup);
  if (s.has_motion()) refuse_deep_overlaps(setup->discretisation, setup->contacts);
  for (const ContactInterface& contact : setup->contacts) report_pairs(contact, comm);
  if (s.has_motion() && !s.has_inertia())
    for (const std::string& warning :
         require_held_bodies(setup->discretisation, setup->boundary, setup->contacts, setup->rigid))
      PetscPrintf(comm, "impact: %s\n", warning.c_str());
  setup->file = std::move(file);
  return setup;
}

bool between_rigid_sides(const Setup& setup, const ContactSettings& contact) {
  int deformable = 0;
  for (const std::string& side : {contact.secondary, contact.primary}) {
    if (ContactSettings::rigid_name(side)) continue;
    for (int node : setup.discretisation.mesh.nodes(side))
      if (setup.rigid.body_of_node()[static_cast<std::size_t>(node)] < 0) deformable = 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, &deformable, 1, MPI_INT, MPI_MAX, setup.discretisation.mesh.comm());
  return deformable == 0;
}

void set_initial_state(const Scenario& s, Setup& setup) {
  const Discretisation& d = setup.discretisation;
  StateTable& state = setup.state;
  const auto dim = static_cast<std::size_t>(d.dim());
  std::vector<double>&u = state.row("u").trial, &v = state.row("v").trial, &a = state.row("a").trial;
  const auto X = d.mesh.coordinates();
  // Unless told otherwise bodies start at their reference temperature, the first material's where they meet.
  if (s.has_heat())
    for (std::size_t m = s.materials.size(); m-- > 0;)
      for (const std::string& region : s.materials[m].regions)
        for (int node : d.mesh.nodes(region))
          state.row("theta").trial[static_cast<std::size_t>(node)] = s.materials[m].law.theta0;
  for (const InitialCondition& ic : s.ics)
    for (const std::string& name : ic.on) {
      const bool all = s.physics.empty(); // else what belongs to physics left out is passed over
      if (ic.phi && !state.find("phi") && all)
        throw UserError(ExitCode::data, "-ic_" + ic.id + "_phi: no material has damage");
      if (ic.theta && !state.find("theta") && all)
        throw UserError(ExitCode::data, "-ic_" + ic.id + "_theta: no material has a heat capacity (_c_v)");
      const std::vector<int> nodes = d.mesh.nodes(name);
      agree_on_errors(d.mesh.comm(), [&] {
        for (int node : nodes) {
          const double* x = &X[static_cast<std::size_t>(node) * dim];
          for (std::size_t k = 0; k < dim; ++k) {
            const std::size_t i = static_cast<std::size_t>(node) * dim + k;
            if (ic.u[k]) u[i] = (*ic.u[k])(x, d.dim(), 0);
            if (ic.v[k]) v[i] = (*ic.v[k])(x, d.dim(), 0);
          }
          if (ic.phi && state.find("phi"))
            state.row("phi").trial[static_cast<std::size_t>(node)] = (*ic.phi)(x, d.dim(), 0);
          if (ic.theta && state.find("theta"))
            state.row("theta").trial[static_cast<std::size_t>(node)] = (*ic.theta)(x, d.dim(), 0);
        }
      });
    }
  // What the first guess extrapolates by: prescribed nodes do not run ahead of their neighbours.
  std::vector<double> rate = v;
  agree_on_errors(d.mesh.comm(), [&] {
    setup.boundary.set_displacement(0, 0, u, v, u);
    setup.boundary.set_initial_rates(s.time.dt, v, a);
    if (state.find("phi")) setup.boundary.set_damage(0, state.row("phi").trial);
    if (state.find("theta")) setup.boundary.set_temperature(0, state.row("theta").trial);
  });
  setup.rigid.set_initial(s.time.dt, u, v);
  state.row("prescribed_velocity").trial = v;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!setup.boundary.fixed_mask()[i]) rate[i] = v[i];
  state.row("mean_rate").trial = std::move(rate);
  state.commit();
}

} // namespace impact
