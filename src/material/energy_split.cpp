#include <impact/material/energy_split.hpp>

namespace impact {

template SplitResponse<Batch, 2> split_response(const PointLaw&, const SplitState<Batch, 2>&);
template SplitResponse<Batch, 3> split_response(const PointLaw&, const SplitState<Batch, 3>&);
template SplitResponse<Dual<Batch, 1>, 2> split_response(const PointLaw&,
                                                         const SplitState<Dual<Batch, 1>, 2>&);
template SplitResponse<Dual<Batch, 1>, 3> split_response(const PointLaw&,
                                                         const SplitState<Dual<Batch, 1>, 3>&);

template <int d>
SplitFlow split_work(const PointLaw& law, const SplitState<Batch, d>& s, const Return<Batch, d>& flow) {
  const MaterialParameters& m = law.parameters;
  if (!any(flow.plastic)) return {Batch(0.0), s.g.p.g};
  const Batch dJ = elastic_volume(s);
  const auto at = [&](const Symmetric<Batch, d>& dev_b) {
    return split_energies(m, elastic_strain(dev_b, trace_excess(dev_b, flow.y - Batch(1.0)), dJ), dJ);
  };
  const SplitEnergies<Batch, d> trial = at(flow.trial), end = at(flow.dev_b);
  const Batch released = s.g.e1.g * (trial.plus - end.plus) + s.g.e2.g * (trial.minus - end.minus);
  const Batch undamaged = m.G * dot(flow.dev_b, flow.dev_b);
  const Symmetric<Batch, d> tau = s.g.e1.g * end.tau_plus + s.g.e2.g * end.tau_minus;
  const Batch power = m.gp == PlasticDegradation::ge ? dot(tau, flow.dev_b) / undamaged : s.g.p.g;
  return {select(flow.plastic, released, Batch(0.0)), select(flow.plastic, power, s.g.p.g)};
}
template SplitFlow split_work(const PointLaw&, const SplitState<Batch, 2>&, const Return<Batch, 2>&);
template SplitFlow split_work(const PointLaw&, const SplitState<Batch, 3>&, const Return<Batch, 3>&);

template <int d> SplitHeat split_heat(const PointLaw& law, const SplitState<Batch, d>& state) {
  const double alpha = law.parameters.alpha_t;
  SplitState<Dual<Batch, 1>, d> s = lifted<1>(state);
  s.J_th.d[0] = (3 * alpha) * state.J_th; // (46)
  const SplitEnergies<Dual<Batch, 1>, d> of = split_response(law, s).of;
  const Dual<Batch, 1> entropy = alpha * trace(split_stress(s, of));
  return {state.g.e1.g * of.plus.v + state.g.e2.g * of.minus.v, entropy.v, entropy.d[0]};
}
template SplitHeat split_heat(const PointLaw&, const SplitState<Batch, 2>&);
template SplitHeat split_heat(const PointLaw&, const SplitState<Batch, 3>&);

namespace {

/// The state along each direction L of the velocity gradient, where b changes by L b + b L^T and J by J tr L;
/// the volume of a cure stays.
template <int n, int d> SplitState<Dual<Batch, n>, d> moving(const SplitState<Batch, d>& state, bool cured) {
  const auto b = [&](int i, int j) {
    const int ij = symmetric_index(d, i, j);
    return ij < 0 ? Batch(0.0) : i == j ? Batch(1.0) + state.left[ij] : state.left[ij];
  };
  SplitState<Dual<Batch, n>, d> s = lifted<n>(state);
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      const int ij = symmetric_index(d, i, j);
      if (ij < 0) continue;
      for (int K = 0; K < n; ++K) {
        const int k = row_of<n>(K), l = column_of<n>(K);
        if (i == k) s.left[ij].d[K] += b(l, j);
        if (j == k) s.left[ij].d[K] += b(i, l);
      }
    }
  for (int K = 0; K < n; ++K)
    if (row_of<n>(K) == column_of<n>(K)) s.J_minus_1.d[K] = Batch(1.0) + state.J_minus_1;
  if (!cured) s.volume = s.J_minus_1;
  return s;
}

/// The stress; of a body that has not flowed no return is differentiated, and the degradation is a number.
template <int n, int d>
Symmetric<Dual<Batch, n>, d> carried_stress(const PointLaw& law, const SplitState<Dual<Batch, n>, d>& s) {
  if (law.flows()) return split_stress(s, split_response(law, s).of);
  const SplitEnergies<Dual<Batch, n>, d> of =
      split_energies(law.parameters, elastic_strain(law.parameters, s), elastic_volume(s));
  return s.g.e1.g.v * of.tau_plus + s.pressed.v * of.tau_minus;
}

/// dtau along direction K, and for K < 0 tau itself.
template <int n, int d> Symmetric<Batch, d> of_stress(const Symmetric<Dual<Batch, n>, d>& tau, int K) {
  Symmetric<Batch, d> r;
  for (int i = 0; i < symmetric_size(d); ++i) r[i] = K < 0 ? tau[i].v : tau[i].d[K];
  return r;
}

template <int d> Symmetric<Batch, d> plus_pressure(Symmetric<Batch, d> a, const Batch& p) {
  for (int i = 0; i < 3; ++i) a[i] += p;
  return a;
}

/// How stress and pressure move with the volume of the cure.
template <int n, int d>
void couple(const PointLaw& law, const SplitState<Batch, d>& state, const Batch& zeta, SplitModulus<n>& r) {
  SplitState<Dual<Batch, 1>, d> s = lifted<1>(state);
  s.volume.d[0] = Batch(1.0);
  const auto carried = carried_stress(law, s);
  const Symmetric<Batch, d> tau = of_stress(carried, -1), dtau = of_stress(carried, 0);
  const Batch inverse_J = Batch(1.0) / (Batch(1.0) + state.volume);
  if (law.parameters.locking == Locking::fbar) {
    r.dtau = zeta * (dtau - inverse_J * tau);
    return;
  }
  r.dtau = dev(dtau);
  r.dp = (1.0 / 3) * (inverse_J * (trace(dtau) - inverse_J * trace(tau)));
}

template <int n> void take_symmetric_part(SplitModulus<n>& r) {
  for (int I = 0; I < n; ++I)
    for (int K = 0; K < I; ++K) r.a.c[I][K] = r.a.c[K][I] = 0.5 * (r.a.c[I][K] + r.a.c[K][I]);
  r.dtau = r.dp_along = Batch(0.5) * (r.dtau + r.dp_along); // of `mean`
}

} // namespace

template <int n>
SplitModulus<n> split_modulus(const PointLaw& law, const SplitState<Batch, layout_of<n>>& state,
                              const Batch& pJ, const Batch& zeta, bool symmetric) {
  constexpr int d = layout_of<n>;
  const Locking locking = law.parameters.locking;
  const SplitState<Dual<Batch, n>, d> s = moving<n>(state, locking != Locking::none);
  const auto carried = carried_stress(law, s);
  SplitModulus<n> r;
  r.dtau = r.dp_along = Batch(0.0) * state.left;
  r.dp = Batch(0.0);
  Symmetric<Batch, d> tau = of_stress(carried, -1);
  if (locking == Locking::mean) tau = plus_pressure(dev(tau), pJ);
  if (locking == Locking::fbar) tau = zeta * tau;
  for (int K = 0; K < n; ++K) {
    const int k = row_of<n>(K), l = column_of<n>(K);
    Symmetric<Batch, d> dtau = of_stress(carried, K);
    if (locking == Locking::mean) {
      const int kl = symmetric_index(d, k, l);
      r.dp_along[kl] = (1.0 / 3) * (trace(dtau) / (Batch(1.0) + state.volume));
      dtau = k == l ? plus_pressure(dev(dtau), pJ) : dev(dtau);
    }
    if (locking == Locking::fbar) dtau = k == l ? zeta * dtau + tau : zeta * dtau;
    for (int I = 0; I < n; ++I) { // dtau - tau L^T
      const int i = row_of<n>(I), j = column_of<n>(I), il = symmetric_index(d, i, l);
      r.a.c[I][K] = dtau[symmetric_index(d, i, j)];
      if (j == k && il >= 0) r.a.c[I][K] -= tau[il];
    }
  }
  if (locking != Locking::none) couple(law, state, zeta, r);
  if (symmetric && law.flows()) take_symmetric_part(r);
  return r;
}
template SplitModulus<4> split_modulus<4>(const PointLaw&, const SplitState<Batch, 2>&, const Batch&,
                                          const Batch&, bool);
template SplitModulus<5> split_modulus<5>(const PointLaw&, const SplitState<Batch, 2>&, const Batch&,
                                          const Batch&, bool);
template SplitModulus<9> split_modulus<9>(const PointLaw&, const SplitState<Batch, 3>&, const Batch&,
                                          const Batch&, bool);

} // namespace impact
