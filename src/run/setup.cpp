#include <algorithm>
#include <cmath>
#include <impact/mesh/agreed_error.hpp>
#include <impact/problem/rigid_motion.hpp>
#include <impact/run/setup.hpp>

namespace impact {

namespace {

Mesh make_mesh(MPI_Comm comm, const Scenario& s) {
  MeshRequest request;
  request.file = s.mesh.file;
  request.parameters = s.mesh.set;
  request.scale = s.mesh.scale;
  request.refine = s.mesh.refine;
  request.work_dir = s.output_dir;
  // A contact facet costs about as much as a few cells: they are spread over the ranks from the start.
  for (const ContactSettings& contact : s.contacts)
    for (const std::string& side : {contact.secondary, contact.primary})
      if (!ContactSettings::rigid_name(side)) request.weights.boundary[side] = 4;
  Mesh mesh = read_mesh(comm, request);
  check_groups(s, mesh.groups(), mesh.dim());
  return mesh;
}

std::vector<MaterialAssignment> assign_materials(const Scenario& s) {
  std::vector<MaterialAssignment> materials;
  for (const MaterialScenario& m : s.materials) {
    MaterialParameters p = m.law;
    if (m.locking_automatic) p.locking = p.model == Model::j2 ? Locking::mean : Locking::none;
    materials.push_back({PointLaw{p}, m.regions});
  }
  return materials;
}

double softer_modulus(const Discretisation& d) {
  double softest = HUGE_VAL;
  for (const MaterialAssignment& m : d.materials) {
    const MaterialParameters& p = m.law.parameters;
    softest = std::min(softest, 9 * p.K * p.G / (3 * p.K + p.G));
  }
  return softest;
}

std::vector<ContactInterface> make_contacts(const Scenario& s, const Discretisation& d, StateTable& state) {
  std::vector<ContactInterface> contacts;
  for (const ContactScenario& contact : s.contacts) {
    ContactSettings settings = contact;
    for (std::size_t k = 0; k < 3; ++k)
      if (const auto& u = contact.rigid_u[k])
        settings.rigid_motion[k] = [u = *u, dim = d.dim()](double t) {
          const std::array<double, 3> origin{};
          return u(origin.data(), dim, t);
        };
    ContactEnvironment environment;
    environment.frame = d.frame;
    environment.thickness = d.thickness;
    environment.modulus = softer_modulus(d);
    if (s.has_inertia())
      for (const MaterialAssignment& m : d.materials)
        environment.density = std::max(environment.density, m.law.parameters.rho);
    contacts.emplace_back(d.mesh, d.displacement, settings, environment, state);
    for (const std::string& warning : contacts.back().warnings())
      PetscPrintf(d.mesh.comm(), "impact: %s\n", warning.c_str());
    const InitialOverlapReport overlap = contacts.back().initial_overlap();
    if (overlap.nodes > 0)
      throw UserError(ExitCode::data, "-contact_" + settings.id +
                                          "_initial adjust: " + std::to_string(overlap.nodes) +
                                          " nodes overlap by up to " + std::to_string(overlap.deepest) +
                                          "; adjusting is not available, separate the surfaces in the mesh");
  }
  return contacts;
}

} // namespace

std::unique_ptr<Setup> build_setup(MPI_Comm comm, const Scenario& s) {
  Discretisation d =
      discretise(make_mesh(comm, s), assign_materials(s), s.plane == PlaneMode::axisymmetric, s.thickness);
  BoundaryData boundary(d.mesh, s.bcs, s.time.max_time);
  auto setup = std::make_unique<Setup>(Setup{std::move(d), {}, std::move(boundary), {}});
  declare_state(setup->discretisation, setup->state);
  setup->contacts = make_contacts(s, setup->discretisation, setup->state);
  if (!s.has_inertia())
    for (const std::string& warning :
         require_held_bodies(setup->discretisation, setup->boundary, setup->contacts))
      PetscPrintf(comm, "impact: %s\n", warning.c_str());
  return setup;
}

void set_initial_state(const Scenario& s, Setup& setup) {
  const Discretisation& d = setup.discretisation;
  StateTable& state = setup.state;
  const auto dim = static_cast<std::size_t>(d.dim());
  std::vector<double>&u = state.row("u").trial, &v = state.row("v").trial, &a = state.row("a").trial;
  const auto X = d.mesh.coordinates();
  for (const InitialCondition& ic : s.ics)
    for (const std::string& name : ic.on) {
      if (ic.phi && !state.find("phi"))
        throw UserError(ExitCode::data, "-ic_" + ic.id + "_phi: no material has damage");
      const std::vector<int> nodes = d.mesh.nodes(name);
      agree_on_errors(d.mesh.comm(), [&] {
        for (int node : nodes) {
          const double* x = &X[static_cast<std::size_t>(node) * dim];
          for (std::size_t k = 0; k < dim; ++k) {
            const std::size_t i = static_cast<std::size_t>(node) * dim + k;
            if (ic.u[k]) u[i] = (*ic.u[k])(x, d.dim(), 0);
            if (ic.v[k]) v[i] = (*ic.v[k])(x, d.dim(), 0);
          }
          if (ic.phi) state.row("phi").trial[static_cast<std::size_t>(node)] = (*ic.phi)(x, d.dim(), 0);
        }
      });
    }
  agree_on_errors(d.mesh.comm(), [&] {
    setup.boundary.set_displacement(0, 0, u, v, u);
    setup.boundary.set_initial_rates(s.time.dt, v, a);
    if (state.find("phi")) setup.boundary.set_damage(0, state.row("phi").trial);
  });
  state.row("prescribed_velocity").trial = v;
  state.row("mean_rate").trial = v;
  state.commit();
}

} // namespace impact
