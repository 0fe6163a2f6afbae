#include <impact/mesh/agreed_error.hpp>
#include <impact/run/setup.hpp>

namespace impact {

void set_initial_state(const Scenario& s, Setup& setup) {
  const Discretisation& d = setup.discretisation;
  StateTable& state = setup.state;
  const std::size_t dim = at(d.dim());
  std::vector<double>&u = state.row("u").trial, &v = state.row("v").trial, &a = state.row("a").trial;
  const auto X = d.mesh.coordinates();
  // Unless told otherwise bodies start at their reference temperature, the first material's where they meet.
  if (s.has_heat())
    for (std::size_t m = s.materials.size(); m-- > 0;)
      for (const std::string& region : s.materials[m].regions)
        for (int node : d.mesh.nodes(region)) state.row("theta").trial[at(node)] = s.materials[m].law.theta0;
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
          const double* x = &X[at(node) * dim];
          for (std::size_t k = 0; k < dim; ++k) {
            const std::size_t i = at(node) * dim + k;
            if (ic.u[k]) u[i] = (*ic.u[k])(x, d.dim(), 0);
            if (ic.v[k]) v[i] = (*ic.v[k])(x, d.dim(), 0);
          }
          if (ic.phi && state.find("phi")) state.row("phi").trial[at(node)] = (*ic.phi)(x, d.dim(), 0);
          if (ic.theta && state.find("theta"))
            state.row("theta").trial[at(node)] = (*ic.theta)(x, d.dim(), 0);
        }
      });
    }
  // What the first guess extrapolates by: prescribed nodes do not run ahead of their neighbours.
  std::vector<double> rate = v;
  agree_on_errors(d.mesh.comm(), [&] {
    setup.boundary.set_displacement(0, 0, u, v, u);
    setup.boundary.set_initial_rates(s.time.scale(), v, a);
    if (state.find("phi")) setup.boundary.set_damage(0, state.row("phi").trial);
    if (state.find("theta")) setup.boundary.set_temperature(0, state.row("theta").trial);
  });
  setup.rigid.set_initial(s.time.scale(), u, v);
  state.row("prescribed_velocity").trial = v;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!setup.boundary.fixed_mask()[i]) rate[i] = v[i];
  state.row("mean_rate").trial = std::move(rate);
  state.commit();
}

} // namespace impact
