#include <algorithm>
#include <impact/mesh/agreed_error.hpp>
#include <impact/mesh/middle_values.hpp>
#include <impact/problem/scalar_field.hpp>
#include <impact/problem/toughness.hpp>
#include <impact/run/setup.hpp>

namespace impact {

namespace {

// The rows that steps extrapolate by, from v with the rates of prescribed dofs; `rate`: v without them.
void set_rates(const Scenario& s, Setup& setup, double start, std::vector<double> rate) {
  StateTable& state = setup.state;
  std::vector<double>& v = state.row("v").trial;
  state.row("prescribed_velocity").trial = v;
  // What the first guess extrapolates by: prescribed nodes do not run ahead of their neighbours.
  for (std::size_t i = 0; i < v.size(); ++i)
    if (!setup.boundary.fixed_mask()[i]) rate[i] = v[i];
  state.row("mean_rate").trial = std::move(rate);
  if (s.has_inertia() && !s.explicit_steps())
    agree_on_errors(setup.discretisation.mesh.comm(),
                    [&] { setup.boundary.smooth_velocity(start, s.time.scale(), v); });
}

} // namespace

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
  std::vector<double> rate = v;
  agree_on_errors(d.mesh.comm(), [&] {
    setup.boundary.set_displacement(0, 0, u, v, u);
    setup.boundary.set_initial_rates(0, s.time.scale(), v, a);
    if (state.find("phi")) setup.boundary.set_damage(0, state.row("phi").trial);
    if (state.find("theta")) setup.boundary.set_temperature(0, state.row("theta").trial);
  });
  setup.rigid.set_initial(s.time.scale(), u, v);
  set_rates(s, setup, 0, std::move(rate));
  if (const bool linear_damage = has_linear_damage(s.damage, d.mesh);
      d.mesh.order() == 2 && (linear_damage || s.heat.order == 1)) {
    const MiddleValues middles(d.mesh);
    if (linear_damage && state.find("phi")) middles.fill(state.row("phi").trial);
    if (s.heat.order == 1 && state.find("theta")) middles.fill(state.row("theta").trial);
  }
  if (d.has_toughness()) start_toughness(d, state);
  state.commit();
}

void set_state_of_other_scheme(const Scenario& s, Setup& setup, double start, bool from_rest) {
  const Discretisation& d = setup.discretisation;
  if (!setup.rigid.empty())
    throw UserError(ExitCode::usage, "-ts_type: a run with rigid bodies (_model rigid) cannot go on from a "
                                     "checkpoint of another one; take that of the checkpoint");
  StateTable& state = setup.state;
  std::vector<double>&v = state.row("v").trial, &a = state.row("a").trial;
  std::ranges::fill(a, 0);
  if (from_rest || !s.has_inertia()) std::ranges::fill(v, 0);
  const auto X = d.mesh.coordinates();
  const auto dim = at(d.dim());
  std::vector<double> rate;
  agree_on_errors(d.mesh.comm(), [&] {
    for (const InitialCondition& ic : s.ics)
      for (const std::string& name : ic.on)
        for (const int node : d.mesh.nodes(name))
          for (std::size_t k = 0; k < dim && from_rest && s.has_inertia(); ++k)
            if (ic.v[k]) v[at(node) * dim + k] = (*ic.v[k])(&X[at(node) * dim], d.dim(), 0);
    rate = v;
    setup.boundary.set_initial_rates(start, s.time.scale(), v, a);
  });
  if (!s.has_inertia()) std::ranges::fill(a, 0);
  set_rates(s, setup, start, std::move(rate));
  for (const char* name : {"v", "a", "prescribed_velocity", "mean_rate"})
    state.row(name).committed = state.row(name).trial;
}

} // namespace impact
