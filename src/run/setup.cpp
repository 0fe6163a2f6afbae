#include <algorithm>
#include <cmath>
#include <impact/io/mesh_file.hpp>
#include <impact/material/cohesive.hpp>
#include <impact/mesh/agreed_error.hpp>
#include <impact/petsc/ranks.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <impact/problem/scalar_field.hpp>
#include <impact/run/setup.hpp>
#include <impact/run/stop_requests.hpp>

namespace impact {

namespace {

// Left of the axis a ring would have a negative volume.
void check_radii(const Mesh& mesh) {
  const std::size_t dim = at(mesh.dim());
  const auto X = mesh.coordinates();
  std::string trouble;
  for (std::size_t i = 0; i < X.size() && trouble.empty(); i += dim)
    if (X[i] < -1e-8 * mesh.smallest_edge())
      trouble = "-plane \"axisymmetric\": x is the radius, and the mesh has a node at (" + number_text(X[i]) +
                ", " + number_text(X[i + 1]) + "); allowed: x >= 0; move or mirror the mesh";
  throw_first(mesh.comm(), ExitCode::data, trouble);
}

MeshRequest request_of(const Scenario& s) {
  MeshRequest request;
  request.file = s.mesh.file;
  request.parameters = s.mesh.set;
  request.order = s.mesh.order;
  request.middles = s.mesh.serendipity ? Middles::edges : Middles::all;
  request.scale = s.mesh.scale;
  request.refine = s.mesh.refine;
  request.most_cells = s.mesh.most_cells;
  request.patience = s.mesh.patience;
  request.work_dir = s.output_dir;
  request.reason_to_stop = [&s] { return reason_to_stop({s.checkpoint.walltime, s.checkpoint.margin()}); };
  for (const MaterialScenario& m : s.materials)
    // A patch knows the mean pressure of its cells, but not how their dev tau moves with the mean volume.
    if (s.has_motion() && m.law.locking == Locking::mean && !PointLaw{m.law}.principal())
      request.patched.push_back(m.regions);
  // A contact facet costs about as much as a few cells: they are spread over the ranks from the start. It is
  // the rank of the secondary one that looks for pairs and finds their forces.
  for (const ContactSettings& contact : s.contacts) request.weights.boundary[contact.secondary] += 4;
  return request;
}

GmshFile read_file(MPI_Comm comm, const MeshRequest& request) {
  if (!request.file.ends_with(".h5")) return read_mesh_file(comm, request);
  check_request(request);
  return read_stored_mesh(comm, request.file);
}

// What wants int N_a dV_0 > 0; and contact by Newton's method on faces that come free while they bend
// sharply, whose pairs do not come to rest.
void refuse_second_order(const Scenario& s, const Mesh& mesh) {
  if (mesh.order() == 1) return;
  const std::string remedy =
      ": cells of second order do not know it yet; allowed: cells of first order (-order 1, gmsh -order 1)";
  if (s.damage.explicit_substeps > 0) throw UserError(ExitCode::data, "-damage_substeps" + remedy);
  if (!s.has_motion() || s.explicit_steps()) return;
  for (const MaterialScenario& m : s.materials)
    if (m.erosion.on)
      throw UserError(ExitCode::data,
                      "-material_" + m.id + "_erosion" + remedy + ", or -ts_type central_difference");
}

// `obstacles`: becomes the bodies of rigid obstacles with mass.
Mesh make_mesh(MPI_Comm comm, const Scenario& s, MeshRequest request, std::vector<ObstacleBody>& obstacles,
               const GmshFile& file) {
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
  Mesh mesh = build_mesh(comm, request, file);
  check_groups(s, mesh.groups(), mesh.dim());
  if (s.plane == PlaneMode::axisymmetric) check_radii(mesh);
  refuse_second_order(s, mesh);
  return mesh;
}

// The factors of a cell, of expressions and of chance; empty where nothing differs from place to place.
std::function<PlaceFactors(const double*)> factors_of(const MaterialScenario& m) {
  if (!m.place.given()) return {};
  return [m](const double* centre) {
    const PlaceScenario& place = m.place;
    const auto value = [&](const PlaceScenario::Factor& factor, std::uint64_t stream) {
      double product = factor.expression ? (*factor.expression)(centre, 3, 0) : 1;
      if (factor.weibull > 0)
        product *=
            weibull_at(static_cast<std::uint64_t>(place.seed), stream, centre, place.length, factor.weibull);
      return to_three_digits(product);
    };
    const PlaceFactors factors{value(place.E, 0), value(place.Gc, 1), value(place.strength, 2)};
    const MaterialParameters local = law_at(PointLaw{m.law}, factors).parameters;
    if (is_cohesive(local.ge) && local.cohesive.a1 < least_cohesive_slope(local))
      throw UserError(ExitCode::data, "-material_" + m.id +
                                          "_gamma: is too long for the strength of the cell at " +
                                          place_text(centre, 3) + ", " + text_of("%.4g", factors.strength) +
                                          " times that of the material: it would break at once; remedy: a "
                                          "shorter gamma, or factors that differ less");
    return factors;
  };
}

// Of second order quadrilaterals and hexahedra want a cure; of simplices the cure leaves too little, but for
// what all but keeps its volume.
bool has_cure(const Mesh& mesh) {
  return mesh.order() == 1 || std::ranges::any_of(known_shapes(), [&](Shape shape) {
           return mesh.has_shape(shape) && !shape->simplex();
         });
}

std::vector<MaterialAssignment>
assign_materials(const Scenario& s, const std::vector<ObstacleBody>& obstacles, const Mesh& mesh) {
  const bool curable = has_cure(mesh);
  std::vector<MaterialAssignment> materials;
  for (const MaterialScenario& m : s.materials) {
    MaterialParameters p = m.law;
    // Physics that is switched off leaves no trace in the law. A body that is not moved expands freely.
    if (!s.has_damage()) p.damage = Damage::none;
    if (!s.has_motion() || p.damage == Damage::none) p.fatigue_a = 0;
    if (!s.has_heat()) p.c_v = p.eos_gamma = 0;
    if (!curable && !m.locking && !(p.K > 100 * p.G)) p.locking = Locking::none;
    if (!s.has_motion()) {
      p.jc_failure = false;
      p.model = Model::elastic;
      p.b_d = p.alpha_t = 0;
      p.equation_of_state = EquationOfState::none;
      p.locking = Locking::none;
    }
    const bool tires = s.has_motion() && p.damage != Damage::none;
    materials.push_back({PointLaw{p}, m.regions, m.id, m.points, s.has_motion() ? m.erosion : ErosionRule{},
                         tires ? m.fatigue : ToughnessFatigue{}, tires ? m.toughness : ToughnessByState{},
                         factors_of(m)});
    if (m.place.E.expression)
      materials.back().E_of_place = [E = m.place.E.expression](const double* place) {
        return (*E)(place, 3, 0);
      };
  }
  for (const ObstacleBody& body : obstacles) {
    MaterialParameters p;
    p.model = Model::rigid;
    p.rho = body.density;
    materials.push_back({PointLaw{p}, {body.cell.region}, body.cell.region});
  }
  return materials;
}

// Modulus and density of the cells at both surfaces: bodies elsewhere have no part in a contact. Where the
// surfaces are rigid the penalty is by the softest body that may hold them.
ContactEnvironment environment_of(const ContactSettings& contact, const Discretisation& d, bool inertia) {
  std::vector<char> beside(at(d.mesh.cell_count()), 0);
  for (const std::string& side : {contact.secondary, contact.primary})
    if (const Group* group = d.mesh.find_group(side); group && group->dim == d.dim() - 1)
      for (const PetscInt cell : d.mesh.facets(side).cell_point) beside[at(cell - d.mesh.cell_start())] = 1;
  enum : std::size_t { minus_softest, heaviest, heaviest_rigid, flowing };
  std::array<double, 4> most = {-HUGE_VAL, 0, 0, 0};
  for (const CellGroup& group : d.groups) {
    const PointLaw& law = d.law(group);
    if (!std::any_of(group.cell_point.begin(), group.cell_point.end(),
                     [&](PetscInt cell) { return beside[at(cell - d.mesh.cell_start())] != 0; }))
      continue;
    double& density = most[law.rigid() ? heaviest_rigid : heaviest];
    density = std::max(density, law.parameters.rho);
    if (law.flows()) most[flowing] = 1;
    if (!law.rigid()) most[minus_softest] = std::max(most[minus_softest], -young_modulus(law.parameters));
  }
  max_over_ranks(d.mesh.comm(), most);
  ContactEnvironment environment;
  environment.frame = d.frame;
  environment.thickness = d.thickness;
  environment.flows = most[flowing] > 0;
  environment.modulus = std::isinf(most[minus_softest]) ? d.softest_modulus() : -most[minus_softest];
  if (std::isinf(environment.modulus)) environment.modulus = 0;
  // The mass of cells counts beside their stiffness; where all is rigid, that there is inertia at all.
  if (inertia) environment.density = most[heaviest] > 0 ? most[heaviest] : most[heaviest_rigid];
  return environment;
}

// A number that depends on time alone.
std::function<double(double)> over_time(const Expression& expression, int dim) {
  return [=](double t) {
    const std::array<double, 3> origin{};
    return expression(origin.data(), dim, t);
  };
}

ContactSet make_contacts(const Scenario& s, const Discretisation& d, StateTable& state) {
  ContactSet contacts;
  for (const ContactScenario& contact : s.contacts) {
    ContactSettings settings = contact;
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto& u = contact.rigid_u[k]; u && contact.carrier.empty())
        settings.rigid_motion[k] = over_time(*u, d.dim());
    settings.changing = std::any_of(s.materials.begin(), s.materials.end(),
                                    [](const MaterialScenario& m) { return m.erosion.on; });
    if (s.explicit_steps()) { // what the rows let through
      if (settings.enforce != Enforcement::impulse) settings.enforce = Enforcement::penalty;
      settings.impact = ImpactUpdate::none;
      settings.iterated = false;
      // Forces of a mean gap change at once where a facet comes into reach of it, which no iteration smooths.
      if (settings.method == ContactMethod::automatic) settings.method = ContactMethod::gauss_points;
      // Impulses on their own nodes alone know little of each other, and are found in a few iterations.
      settings.at_nodes = settings.enforce == Enforcement::impulse && settings.points == 0;
    }
    if (contact.temperature) settings.rigid_temperature = over_time(*contact.temperature, d.dim());
    contacts.emplace_back(d.mesh, d.displacement, settings, environment_of(settings, d, s.has_inertia()),
                          state);
  }
  return contacts;
}

// Contacts of bodies that stay where they are, and pass heat.
ContactSet make_joints(Scenario s, const Discretisation& d, StateTable& state) {
  std::erase_if(s.contacts, [](const ContactScenario& c) { return !(c.conductance > 0); });
  for (ContactScenario& contact : s.contacts) { // nothing presses, and no modulus need be known
    contact.friction = 0;
    contact.penalty = contact.penalty_increment = contact.penalty_max = 1;
  }
  ContactSet joints = make_contacts(s, d, state);
  const Handle<Vec> u = d.displacement.make_global();
  for (ContactInterface& contact : joints) {
    contact.set_time(0, 0, false, {});
    contact.update_search(u);
    const std::string& id = contact.id();
    const double gap = contact.measures(u).gap_min;
    const MPI_Comm comm = d.mesh.comm();
    if (max_over_ranks(comm, static_cast<int>(contact.heat_paths(u).size())) > 0)
      check(PetscPrintf(comm, "contact %s: smallest gap %.4g, heat passes\n", id.c_str(), gap));
    else
      check(PetscPrintf(
          comm,
          "impact: contact %s: no heat passes, since no place is within -contact_%s_conductance_gap "
          "of the other side; the smallest gap is %.4g\n",
          id.c_str(), id.c_str(), gap));
  }
  return joints;
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

// Every pair is looked at in each residual and couples its nodes in the matrix. In space some forty are in
// reach of facets of one size.
void report_pairs(const ContactInterface& contact, int dim, MPI_Comm comm) {
  const double many = dim == 2 ? 30 : 100;
  const double pairs = contact.search().pairs_per_facet();
  if (contact.settings().rigid() || pairs == 0) return;
  const std::string& id = contact.id();
  check(PetscPrintf(comm, "contact %s: %.3g candidate pairs per secondary facet\n", id.c_str(), pairs));
  if (pairs > many)
    check(PetscPrintf(
        comm,
        "impact: contact %s: more than %g pairs per facet make steps slow: the facets of one side are "
        "far larger than those of the other, or -contact_%s_search_radius is (%.3g)\n",
        id.c_str(), many, id.c_str(), contact.settings().search_radius));
}

// Whether heat comes in at surfaces: suddenly, as a rule. Of the heat of flow and cracks lumping takes the
// peaks off (45'').
bool heat_enters(const Scenario& s) {
  return std::any_of(s.bcs.begin(), s.bcs.end(), [](const auto& bc) { return is_thermal(bc.type); }) ||
         std::any_of(s.ics.begin(), s.ics.end(), [](const auto& ic) { return ic.theta.has_value(); }) ||
         std::any_of(s.contacts.begin(), s.contacts.end(),
                     [](const auto& c) { return c.friction > 0 || c.temperature.has_value(); });
}

} // namespace

std::unique_ptr<Setup> build_on(Mesh mesh, const Scenario& s, const std::vector<ObstacleBody>& obstacles) {
  std::vector<MaterialAssignment> materials = assign_materials(s, obstacles, mesh);
  const bool linear_cells = mesh.order() == 1;
  if (linear_cells && (s.damage.order == 2 || s.heat.order == 2))
    throw UserError(ExitCode::data,
                    std::string(s.damage.order == 2 ? "-damage_order" : "-heat_order") +
                        " 2: the cells of the mesh are of first order; allowed: 1, or -order 2");
  Discretisation d = discretise(std::move(mesh), std::move(materials), frame_of(s.plane), s.thickness);
  if (s.damage.order == 2 && d.has_damage() && bounds_fail(s.damage, d.mesh))
    throw UserError(
        ExitCode::data,
        "-damage_order 2: shape functions of corners integrate to less than nothing on tetrahedra and "
        "serendipity cells of second order, and damage with bounds would grow where nothing drives it; "
        "allowed: 1, cells without -mesh_serendipity, or -damage_bounds history");
  std::vector<BoundaryCondition> conditions = conditions_at_work(s, d.dim());
  RigidBodies rigid(d, conditions, s.time.max_time);
  BoundaryData boundary(d.mesh, std::move(conditions), s.time.max_time, rigid.body_of_node(),
                        {frame_of(s.plane), s.thickness});
  auto setup =
      std::make_unique<Setup>(Setup{std::move(d), {}, std::move(rigid), std::move(boundary), {}, {}, {}});
  declare_state(setup->discretisation, setup->state);
  setup->discretisation.lumped_mass = s.explicit_steps();
  setup->discretisation.lumped_capacity =
      s.heat.lumped.value_or(linear_cells && setup->discretisation.conducts() && heat_enters(s));
  if (s.time.scaled_step > 0) {
    StateRow row{"mass_factor", Support::cell_point, 1};
    row.has_trial = false;
    setup->discretisation.mass_factor =
        &setup->state.add(std::move(row), setup->discretisation.point_values(1), 1).committed;
  }
  setup->rigid.declare_state(setup->state);
  if (s.has_motion())
    setup->contacts = make_contacts(s, setup->discretisation, setup->state);
  else if (s.has_heat())
    setup->joints = make_joints(s, setup->discretisation, setup->state);
  return setup;
}

std::unique_ptr<Setup> build_setup(MPI_Comm comm, const Scenario& s, std::optional<GmshFile> kept) {
  std::vector<ObstacleBody> obstacles;
  const MeshRequest request = request_of(s);
  GmshFile file = kept ? std::move(*kept) : read_file(comm, request);
  Mesh mesh = make_mesh(comm, s, request, obstacles, file);
  std::unique_ptr<Setup> setup = build_on(std::move(mesh), s, obstacles);
  for (const ContactInterface& contact : setup->contacts)
    for (const std::string& warning : contact.warnings())
      check(PetscPrintf(comm, "impact: %s\n", warning.c_str()));
  adjust_initial_overlaps(s, obstacles, setup);
  if (s.has_motion()) refuse_deep_overlaps(setup->discretisation, setup->contacts);
  for (const ContactInterface& contact : setup->contacts)
    report_pairs(contact, setup->discretisation.dim(), comm);
  if (s.has_motion())
    if (const std::string warning = free_axis(setup->discretisation, setup->boundary, setup->rigid);
        !warning.empty())
      check(PetscPrintf(comm, "impact: %s\n", warning.c_str()));
  if (s.has_motion() && !s.has_inertia())
    for (const std::string& warning :
         require_held_bodies(setup->discretisation, setup->boundary, setup->contacts, setup->rigid))
      check(PetscPrintf(comm, "impact: %s\n", warning.c_str()));
  setup->file = std::move(file);
  return setup;
}

void convert_mesh(MPI_Comm comm, const Scenario& s) {
  const GmshFile file = read_file(comm, request_of(s));
  std::vector<Group> groups;
  for (const GmshGroup& g : file.groups) groups.push_back({g.name, g.dim});
  for (const ContactScenario& contact : s.contacts)
    if (!contact.carrier.empty())
      groups.push_back({contact.carrier, file.dim}); // of the run, not of its mesh
  check_groups(s, groups, file.dim);
  const auto cells = static_cast<unsigned long long>(write_mesh_file(comm, s.mesh.convert, file));
  check(PetscPrintf(comm, "mesh of %llu cells written; -mesh %s reads it\n", cells, s.mesh.convert.c_str()));
}

bool between_rigid_sides(const Setup& setup, const ContactSettings& contact) {
  int deforming = 0;
  for (const std::string& side : {contact.secondary, contact.primary}) {
    if (ContactSettings::rigid_name(side)) continue;
    for (int node : setup.discretisation.mesh.nodes(side))
      if (setup.rigid.body_of_node()[at(node)] < 0) deforming = 1;
  }
  return max_over_ranks(setup.discretisation.mesh.comm(), deforming) == 0;
}

} // namespace impact
