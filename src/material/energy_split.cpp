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

/// How b = left + 1 changes along the direction K of the velocity gradient L: L b + b L^T.
template <int n, int d> Symmetric<Batch, d> carried_left(const Symmetric<Batch, d>& left, int K) {
  const int k = row_of<n>(K), l = column_of<n>(K);
  Symmetric<Batch, d> db = Batch(0.0) * left;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) {
      const int ij = symmetric_index(d, i, j);
      if (ij < 0) continue;
      const auto b = [&](int a) {
        const int al = symmetric_index(d, a, l);
        return al < 0 ? Batch(0.0) : a == l ? Batch(1.0) + left[al] : left[al];
      };
      if (i == k) db[ij] += b(j);
      if (j == k) db[ij] += b(i);
    }
  return db;
}

/// The state along each direction of the velocity gradient, where J changes by J tr L; the volume of a cure
/// stays.
template <int n, int d> SplitState<Dual<Batch, n>, d> moving(const SplitState<Batch, d>& state, bool cured) {
  SplitState<Dual<Batch, n>, d> s = lifted<n>(state);
  for (int K = 0; K < n; ++K) {
    const Symmetric<Batch, d> db = carried_left<n>(state.left, K);
    for (int i = 0; i < symmetric_size(d); ++i) s.left[i].d[K] = db[i];
    if (row_of<n>(K) == column_of<n>(K)) s.J_minus_1.d[K] = Batch(1.0) + state.J_minus_1;
  }
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

/// a_iK = dtau - tau L^T along the direction K.
template <int n, int d>
void set_column(Modulus<Batch, n>& a, int K, const Symmetric<Batch, d>& dtau,
                const Symmetric<Batch, d>& tau) {
  const int k = row_of<n>(K), l = column_of<n>(K);
  for (int I = 0; I < n; ++I) {
    const int i = row_of<n>(I), j = column_of<n>(I), il = symmetric_index(d, i, l);
    a.c[I][K] = dtau[symmetric_index(d, i, j)];
    if (j == k && il >= 0) a.c[I][K] -= tau[il];
  }
}

/// Of an elastic body under the spectral split: only the tensile part of e is differentiated along each
/// direction, and the functions of J_e once.
template <int n, int d>
[[gnu::flatten, gnu::noinline]] Modulus<Batch, n> elastic_modulus(const MaterialParameters& m,
                                                                  const SplitState<Batch, d>& s) {
  const Batch dJ = elastic_volume(s), r = inverse_cbrt(s.J_th), inverse_th = r * r;
  const Symmetric<Batch, d> e = elastic_strain(m, s);
  const LameVolume<Dual<Batch, 1>> volume = lame_volume(m, seed<Batch, 1>(dJ, 0));
  const TensileMap<Batch, d> map(m, e);
  const Batch g_up = s.g.e1.g, g_down = s.pressed, g_v = select(dJ >= Batch(0.0), g_up, g_down);
  const auto of = [&](const PrincipalParts<Batch, d>& part, const Symmetric<Batch, d>& all) {
    return plus_pressure(g_up * part.tensor + g_down * (all - part.tensor),
                         (-1.0 / 3) * (g_up * part.first + g_down * part.second));
  };
  const Symmetric<Batch, d> shape = of(map.at(), e);
  const Batch Gw = m.G * volume.w.v;
  const Symmetric<Batch, d> tau = plus_pressure(Gw * shape, g_v * volume.slope.v);
  const Batch dJe = (Batch(1.0) + s.J_minus_1) / s.J_th; // along tr L
  const Symmetric<Batch, d> dilation =
      plus_pressure((m.G * (volume.w.d[0] * dJe)) * shape, g_v * (volume.slope.d[0] * dJe));
  Modulus<Batch, n> a;
  for (int K = 0; K < n; ++K) {
    const Symmetric<Batch, d> de = inverse_th * carried_left<n>(s.left, K);
    Symmetric<Batch, d> dtau = Gw * of(map.derivative(de), de);
    if (row_of<n>(K) == column_of<n>(K)) dtau = dtau + dilation;
    set_column(a, K, dtau, tau);
  }
  return a;
}

} // namespace

template <int d>
[[gnu::flatten]] SplitEnergies<Batch, d> elastic_split(const MaterialParameters& m,
                                                       const SplitState<Batch, d>& s) {
  return split_energies(m, elastic_strain(m, s), elastic_volume(s));
}
template SplitEnergies<Batch, 2> elastic_split(const MaterialParameters&, const SplitState<Batch, 2>&);
template SplitEnergies<Batch, 3> elastic_split(const MaterialParameters&, const SplitState<Batch, 3>&);

template <int n>
SplitModulus<n> split_modulus(const PointLaw& law, const SplitState<Batch, layout_of<n>>& state,
                              const Batch& pJ, const Batch& zeta, bool symmetric) {
  constexpr int d = layout_of<n>;
  const Locking locking = law.parameters.locking;
  SplitModulus<n> r;
  r.dtau = r.dp_along = Batch(0.0) * state.left;
  r.dp = Batch(0.0);
  if (!law.flows() && locking == Locking::none && law.parameters.split == Split::spectral) {
    r.a = elastic_modulus<n>(law.parameters, state);
    return r;
  }
  const SplitState<Dual<Batch, n>, d> s = moving<n>(state, locking != Locking::none);
  const auto carried = carried_stress(law, s);
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
    set_column(r.a, K, dtau, tau);
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
