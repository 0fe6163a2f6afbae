#pragma once
#include <impact/material/drucker_prager.hpp>
#include <impact/material/modulus.hpp>
#include <impact/material/no_tension.hpp>
#include <impact/material/point_law.hpp>

/// The law of a point whose E+ and E- are functions of the principal elastic stretches (PointLaw::principal).
/// Its Kirchhoff stress is g_1 tau+ + g_2 tau-; flow is a radial return in the deviator of b, driven by the
/// part of the real stress in its direction (64''), or by the stress of the undamaged body.
///
/// Under a cure of locking the volume ratio is another one than that of F: b keeps its shape alone. Of `mean`
/// the energy is that of F scaled to the mean volume, so that dev tau acts at the point and p = tr tau/(3 J)
/// is shared; of F-bar all of tau is.
namespace impact {

template <class T, int d> struct SplitState {
  Symmetric<T, d> left; ///< F A_n F^T - 1
  T J_minus_1;          ///< of F
  T volume;             ///< J - 1 that the law sees
  T J_th;
  T alpha; ///< at t_n
  Degradations<T> g;
  T pressed; ///< factor on tau-: g_2, or less or more of it where the integrator takes its stress apart
  FlowConditions<T> at;
};

template <class T, int d> struct SplitResponse {
  Return<T, d> flow;
  SplitEnergies<T, d> of;
};

template <class T, int d>
SplitEnergies<T, d> split_energies(const MaterialParameters& m, const Symmetric<T, d>& e, const T& dJ) {
  if (m.split == Split::drucker_prager) return drucker_prager_energies(m, e, dJ);
  return m.split == Split::no_tension ? no_tension_energies(m, e, dJ) : spectral_energies(m, e, dJ);
}

/// (1 + x)^(2/3) - 1, accurate for small x.
template <class T> T two_thirds_power(const T& x) {
  const T k = T(1.0) / inverse_cbrt(T(T(1.0) + x));
  return x / (k * k + k + T(1.0)) * (k + T(1.0));
}

/// J_e - 1.
template <class T, int d> T elastic_volume(const SplitState<T, d>& s) {
  return (s.volume - (s.J_th - T(1.0))) / s.J_th;
}

/// b_e - 1 of the unimodular b = dev_b + (1 + z) 1.
template <class T, int d>
Symmetric<T, d> elastic_strain(const Symmetric<T, d>& dev_b, const T& z, const T& Je_minus_1) {
  const T more = two_thirds_power(Je_minus_1), factor = T(1.0) + more;
  Symmetric<T, d> e = factor * dev_b;
  for (int i = 0; i < 3; ++i) e[i] = e[i] + (factor * z + more);
  return e;
}

/// b_e - 1 of a body that has not flowed: that of F but for the volumes of heat and of the cure.
template <class T, int d>
Symmetric<T, d> elastic_strain(const MaterialParameters& m, const SplitState<T, d>& s) {
  const T r = inverse_cbrt(s.J_th), inverse_th = r * r;
  Symmetric<T, d> e = inverse_th * s.left;
  for (int i = 0; i < 3; ++i) e[i] = e[i] + (inverse_th - T(1.0));
  if (m.locking == Locking::none) return e;
  const T more = two_thirds_power(T((s.volume - s.J_minus_1) / (T(1.0) + s.J_minus_1)));
  e = (T(1.0) + more) * e;
  for (int i = 0; i < 3; ++i) e[i] = e[i] + more;
  return e;
}

/// tau : n of the state dev b = (1 - 2 mu x / N) trial, n = trial/|trial|, against the multiplier x: what
/// drives the flow of a body in whose yield function the degraded stress stands (64'').
template <class T, int d> struct ProjectedStress {
  using V = Value<T>;
  const MaterialParameters& m;
  const Return<T, d>& trial;
  T N, mu, Je_minus_1, tension, compression; ///< g_1, g_2
  V principal[3];                            ///< of the trial deviator

  ProjectedStress(const MaterialParameters& parameters, const Return<T, d>& of, const SplitState<T, d>& s)
      : m(parameters), trial(of), N(m.G * sqrt(dot(of.trial, of.trial))), mu(m.G * of.y),
        Je_minus_1(elastic_volume(s)), tension(s.g.e1.g), compression(s.g.e2.g) {
    Symmetric<V, d> values;
    for (int k = 0; k < symmetric_size(d); ++k) values[k] = value(of.trial[k]);
    const EigenSystem<V> eigen = eigen_system(values);
    for (int i = 0; i < 3; ++i) principal[i] = eigen.value[i];
  }
  V start() const {
    V slope;
    return at(V(0.0), slope);
  }
  V stiffness() const { // at the start
    V slope;
    at(V(0.0), slope);
    return -slope;
  }
  /// On values, along the axes of the trial state, which the return keeps.
  V at(const V& x, V& slope) const {
    using S = Dual<V, 1>;
    const S scale = S(1.0) - S(V(2.0) * value(mu) / value(N)) * seed<V, 1>(x, 0);
    Symmetric<S, 2> dev_b;
    for (int i = 0; i < 3; ++i) dev_b[i] = scale * S(principal[i]);
    dev_b[3] = S(0.0);
    const S z = trace_excess(dev_b, V(value(trial.y) - V(1.0)));
    const Symmetric<S, 2> e = elastic_strain(dev_b, z, S(value(Je_minus_1)));
    S sum = S(0.0);
    for (int i = 0; i < 3; ++i)
      sum += S(select((value(e[i]) > V(0.0)) & (V(i == 2 && m.sheet ? 0.0 : 1.0) > V(0.0)), value(tension),
                      value(compression)) *
               principal[i]) *
             e[i];
    const S of = S(m.G * (scaled(value(Je_minus_1)) * (m.G / value(N)))) * sum;
    slope = of.d[0];
    return of.v;
  }
  T at(const T& x) const {
    const T scale = T(1.0) - 2.0 * (mu * x) / N;
    const Symmetric<T, d> dev_b = scale * trial.trial;
    const T z = trace_excess(dev_b, V(value(trial.y) - V(1.0)));
    const Symmetric<T, d> e = elastic_strain(dev_b, z, Je_minus_1);
    const Symmetric<T, d> part = Mapped<TensileMap, T, d>::at(m, e).tensor;
    return (m.G * (scaled(Je_minus_1) * (m.G / N))) *
           (tension * dot(part, trial.trial) + compression * dot(e - part, trial.trial));
  }

private:
  template <class S> static S scaled(const S& Je_minus_1) { // J_e^(-2/3)
    const S c = inverse_cbrt(S(S(1.0) + Je_minus_1));
    return c * c;
  }
};

/// The same state in dual numbers without derivatives.
template <int n, int d> SplitState<Dual<Batch, n>, d> lifted(const SplitState<Batch, d>& s) {
  using D = Dual<Batch, n>;
  const auto g = [](const Degraded<Batch>& x) { return Degraded<D>{D(x.g), D(x.dg), D(x.d2g)}; };
  SplitState<D, d> r;
  for (int i = 0; i < symmetric_size(d); ++i) r.left[i] = D(s.left[i]);
  r.J_minus_1 = D(s.J_minus_1);
  r.volume = D(s.volume);
  r.J_th = D(s.J_th);
  r.alpha = D(s.alpha);
  r.g = {g(s.g.e1), g(s.g.e2), g(s.g.p)};
  r.pressed = D(s.pressed);
  r.at = {D(s.at.softening), s.at.dt, s.at.held};
  return r;
}

/// The return: in the stress of the undamaged body where g_p = g_1, or where the history is that of the end.
template <class T, int d> Return<T, d> split_flow(const PointLaw& law, const SplitState<T, d>& s) {
  const MaterialParameters& m = law.parameters;
  const T r = inverse_cbrt(T(T(1.0) + s.J_minus_1));
  if (!law.flows()) return predictor(s.left, T(r * r), s.alpha, s.at);
  if (s.at.held || m.gp == PlasticDegradation::ge)
    return return_map(m, s.left, T(r * r), s.alpha, T(1.0), s.at);
  Return<T, d> out = predictor(s.left, T(r * r), s.alpha, s.at);
  const ProjectedStress<T, d> stress(m, out, s);
  flow_back_of_any(m, out, stress, s.g.p.g);
  return out;
}

template <class T, int d> T split_excess(const Return<T, d>& flow) {
  return trace_excess(flow.dev_b, value(flow.y) - Value<T>(1.0));
}

template <class T, int d> SplitResponse<T, d> split_response(const PointLaw& law, const SplitState<T, d>& s) {
  const MaterialParameters& m = law.parameters;
  SplitResponse<T, d> r{split_flow(law, s), {}};
  const T dJ = elastic_volume(s);
  r.of = split_energies(
      m, law.flows() ? elastic_strain(r.flow.dev_b, split_excess(r.flow), dJ) : elastic_strain(m, s), dJ);
  return r;
}

/// g_1 tau+ + g_2 tau-, for the forces.
template <class T, int d>
Symmetric<T, d> split_stress(const SplitState<T, d>& s, const SplitEnergies<T, d>& of) {
  return s.g.e1.g * of.tau_plus + s.pressed * of.tau_minus;
}

/// What the flow of a step releases, g_1 E+ + g_2 E- of the trial state less that of the end, and how much of
/// k dalpha is the work of the degraded stress.
struct SplitFlow {
  Batch released, power;
};

/// Modulus and what couples the points of a cell under a cure of locking: how tau and p = tr tau/(3 J) move
/// with the volume ratio of the cure, and p with the gradient of the velocity.
template <int n> struct SplitModulus {
  Modulus<Batch, n> a;
  Symmetric<Batch, layout_of<n>> dtau, dp_along;
  Batch dp;
};

/// What of the free energy hangs on the temperature at fixed strain and history: the elastic energy, s =
/// alpha_t tr tau, because J_e^(1/3) = (J/J_th)^(1/3) is in every stretch, and its slope with theta.
struct SplitHeat {
  Batch elastic, entropy, entropy_slope;
};

// What the kernels ask for is compiled once, in src/material/energy_split.cpp.
template <int d> SplitFlow split_work(const PointLaw&, const SplitState<Batch, d>&, const Return<Batch, d>&);
template <int d> SplitHeat split_heat(const PointLaw&, const SplitState<Batch, d>&);
/// Of a body that does not flow.
template <int d>
SplitEnergies<Batch, d> elastic_split(const MaterialParameters&, const SplitState<Batch, d>&);
/// pJ = p J of `mean`, zeta = J/J_0 of F-bar.
template <int n>
SplitModulus<n> split_modulus(const PointLaw&, const SplitState<Batch, layout_of<n>>&, const Batch& pJ,
                              const Batch& zeta, bool symmetric);

extern template SplitResponse<Batch, 2> split_response(const PointLaw&, const SplitState<Batch, 2>&);
extern template SplitResponse<Batch, 3> split_response(const PointLaw&, const SplitState<Batch, 3>&);
extern template SplitResponse<Dual<Batch, 1>, 2> split_response(const PointLaw&,
                                                                const SplitState<Dual<Batch, 1>, 2>&);
extern template SplitResponse<Dual<Batch, 1>, 3> split_response(const PointLaw&,
                                                                const SplitState<Dual<Batch, 1>, 3>&);

} // namespace impact
