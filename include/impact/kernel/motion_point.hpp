#pragma once
#include <impact/kernel/motion_input.hpp>
#include <impact/kernel/point_map.hpp>
#include <impact/kernel/reference_gradient.hpp>
#include <impact/kernel/volume_modes.hpp>
#include <impact/material/energy_split.hpp>
#include <impact/material/point_law.hpp>

/// The law at the points of one batch of cells with the chosen volumetric locking cure.
namespace impact {

/// Cells in which J is constant, but for that of rings: they share their volume in patches.
template <class Cell> inline constexpr bool is_linear_simplex = Cell::nodes == Cell::dim + 1;

template <int dim> struct SplitEvaluation;

/// What all points of a cell share before the law is evaluated.
template <class Cell, Frame frame> struct CellState {
  PointMap<Cell, frame> map[Cell::points];
  Tensor<Batch, Cell::dim> H[Cell::points]; ///< Grad u
  VolumeModes<Cell> modes;                  ///< of `mean`, and the reference volume
  VolumeField<Cell> volume_J;               ///< J - 1 that p sees under `mean` and `fbar`
  VolumeField<Cell> mean_p;                 ///< p of `mean`
  VolumeProducts<Cell> mean_dp;             ///< int dp/dJ dV_0 of the modes; uniform: its mean
  Batch start_33[frame == Frame::plane_stress ? Cell::points : 1]; ///< F_33 - 1 at t_n in plane stress
  PointMap<Cell, frame> centre;                                    ///< of the centroid, set under `fbar`
  Tensor<Batch, Cell::dim> centre_H;
  /// [point] what share_split_pressure evaluates, to serve again; null: it does not.
  SplitEvaluation<Cell::dim>* split = nullptr;

  /// J - 1 under `mean` and `fbar`, p under `mean` at a point.
  Batch shared_volume(int q) const { return modes.value(volume_J, q); }
  Batch shared_pressure(int q) const { return modes.value(mean_p, q); }
};

/// alpha of the point that a ductile degradation looks at; history [point][history_size] or nullptr.
template <class Cell, Frame frame>
inline Batch point_alpha(const PointLaw& law, const Batch* history, int q) {
  if (!is_ductile(law.parameters) || !history) return Batch(0.0);
  return history_at<frame>(history, q).alpha;
}

template <class Cell, Frame frame>
inline Degradations<Batch> point_degradations(const PointLaw& law, const Batch* phi, int q,
                                              const Batch* history = nullptr, double unilateral = 1) {
  Degradations<Batch> g = degradations(law.parameters, phi ? interpolate<Cell>(phi, q) : Batch(0.0),
                                       point_alpha<Cell, frame>(law, history, q));
  if (law.parameters.damage != Damage::none) g.e2.g += (unilateral - 1) * unilateral_part(g);
  return g;
}

/// PointLaw::plastic_exchange at one point.
template <class Cell, Frame frame>
inline Batch plastic_exchange_at(const PointLaw& law, const CellFields& in, int q) {
  const Batch alpha = history_at<frame>(in.history, q).alpha,
              alpha_n = history_at<frame>(in.history_n, q).alpha;
  const Drive& drive = drive_at(in.drive, q);
  return law.plastic_exchange(
      interpolate<Cell>(in.phi, q), interpolate<Cell>(in.phi_n, q), alpha, alpha_n,
      PointEnergies<Batch>{drive.plus, drive.minus,
                           law.softens() ? drive.plastic : plastic_potential(law.parameters, alpha)});
}

template <class Cell> inline Batch point_thermal_volume(const PointLaw& law, const Batch* theta, int q) {
  if (!theta || law.parameters.alpha_t == 0) return Batch(1.0);
  return thermal_volume(law, interpolate<Cell>(theta, q));
}

/// E+, E- and H_0 at a point.
template <class Cell>
inline PointEnergies<Batch> point_energies(const PointLaw& law, const Batch& z, const Batch& Je_minus_1,
                                           const Batch& alpha, const Batch* theta, int q) {
  const Batch J_th = has_state(law.parameters) ? point_thermal_volume<Cell>(law, theta, q) : Batch(1.0);
  return law.energies(z, ElasticVolume<Batch>{Je_minus_1, J_th}, alpha);
}

/// J - 1 that comes from the patch of a cell, and p and dp/dJ from there or of SoftVolume; null: the cell
/// finds its own. `warming` as in MotionInput.
struct PatchVolume {
  const Batch *J_minus_1 = nullptr, *pressure = nullptr, *warming = nullptr;
};

/// p and dp/dJ of a body that warms as it is pressed since its temperature was found.
inline Volumetric<Batch> warmed(Volumetric<Batch> v, const Batch* warming, const Batch& J_minus_1, int q) {
  if (warming == nullptr) return v;
  const Warming& since = warming_at(warming, q);
  v.p += since.pressure + since.slope * (J_minus_1 - since.volume);
  v.dp += since.slope;
  return v;
}

/// For `mean` p is the projection of g_v U'(J_mean/J_th)/J_th on the modes of the cell, as J_mean is of J,
/// which makes the volumetric force the derivative of int g_v U(J_mean/J_th) dV_0.
template <class Cell, Frame frame>
inline void share_pressure(const PointLaw& law, const Batch* phi, const Batch* theta,
                           CellState<Cell, frame>& s, const Batch* history, double unilateral,
                           const PatchVolume& patch) {
  s.mean_dp.clear();
  for (int q = 0; q < Cell::points; ++q) {
    const Batch J_minus_1 = s.shared_volume(q);
    const Volumetric<Batch> v =
        warmed(law.pressure(J_minus_1, point_thermal_volume<Cell>(law, theta, q),
                            point_degradations<Cell, frame>(law, phi, q, history, unilateral)),
               patch.warming, J_minus_1, q);
    s.modes.add(s.mean_p, q, s.map[q].weight * v.p);
    s.modes.add(s.mean_dp, q, s.map[q].weight * v.dp);
  }
  s.mean_p = s.modes.project(s.mean_p);
  if constexpr (volume_modes<Cell> == 1) s.mean_dp.of[0][0] = s.mean_dp.of[0][0] / s.modes.volume;
}

/// J - 1 of `mean`, of the cell alone.
template <class Cell, Frame frame> inline void share_volume(const Batch* X, CellState<Cell, frame>& s) {
  VolumeField<Cell> grown;
  VolumeProducts<Cell> mass;
  grown.clear();
  mass.clear();
  s.modes.set_places(X);
  for (int q = 0; q < Cell::points; ++q) {
    s.modes.add(grown, q, s.map[q].weight * detm1(s.H[q]));
    s.modes.add(mass, q, s.map[q].weight);
  }
  s.modes.invert(mass);
  s.volume_J = s.modes.project(grown);
}

/// Geometry, Grad u, the volume ratios and what `mean` shares.
template <class Cell, Frame frame>
inline void prepare(const PointLaw& law, const Batch* X, const Batch* u, const Batch* phi, const Batch* theta,
                    CellState<Cell, frame>& s, const Batch* history = nullptr, double unilateral = 1,
                    const PatchVolume& patch = {}) {
  constexpr int d = Cell::dim;
  const auto& t = shape_table<Cell>;
  Batch jacobian[Cell::points][d * d], slope[Cell::points][d * d]; // dX_i/dxi_k, du_i/dxi_k
  reference_gradients<Cell, d>(X, jacobian);
  reference_gradients<Cell, d>(u, slope);
  s.modes.volume = Batch(0.0);
  s.volume_J.clear();
  s.mean_p.clear();
  for (int q = 0; q < Cell::points; ++q) {
    point_map<Cell, frame>(X, jacobian[q], t.N[q], t.weight[q], s.map[q]);
    s.H[q] = mapped_gradient<Cell, frame>(s.map[q], slope[q], t.N[q], u);
    s.modes.volume += s.map[q].weight;
  }
  if (is_linear_simplex<Cell> && patch.J_minus_1) s.volume_J = {*patch.J_minus_1};
  if (law.parameters.locking == Locking::mean) {
    if (!is_linear_simplex<Cell> || !patch.J_minus_1) share_volume(X, s);
    if (patch.pressure) {
      s.mean_p = {patch.pressure[0]};
      s.mean_dp = {{{patch.pressure[1]}}};
    } else
      share_pressure(law, phi, theta, s, history, unilateral, patch);
  } else if (law.parameters.locking == Locking::fbar) {
    reference_gradient<Cell, d>(t.dN0, X, jacobian[0]);
    reference_gradient<Cell, d>(t.dN0, u, slope[0]);
    point_map<Cell, frame>(X, jacobian[0], t.N0, 1, s.centre);
    s.centre_H = mapped_gradient<Cell, frame>(s.centre, slope[0], t.N0, u);
    s.modes.set_places(X);
    s.volume_J.of[0] = detm1(s.centre_H);
  }
}

template <Frame frame>
inline PointHistory<Batch, dimension(frame)> read_history(const PointLaw& law, const Batch* history, int q) {
  constexpr int dim = dimension(frame);
  if (!law.flows() || !history) return virgin_history<Batch, dim>();
  return history_at<frame>(history, q);
}

/// What the flow stress hangs on beside alpha.
template <class Cell>
inline FlowConditions<Batch> point_conditions(const PointLaw& law, const MotionInput& in, int q) {
  if (is_plain(law.parameters)) return {};
  const bool warm = in.theta && law.softens();
  FlowConditions<Batch> at =
      law.conditions(warm ? interpolate<Cell>(in.theta, q) : Batch(law.parameters.theta0), in.dt,
                     in.failure ? in.failure[q] : Batch(0.0));
  at.held = in.held;
  return at;
}

/// The law at one point.
template <int dim> struct PointEvaluation {
  Kinematics<Batch, dim> k;
  Degradations<Batch> g;
  Return<Batch, dim> flow;
  Batch zeta;                ///< J/J_0 of F-bar, else 1
  Batch p, dp;               ///< degraded p and dp/dJ at the volume of the cure
  Batch Je_minus_1;          ///< of that volume
  Symmetric<Batch, dim> tau; ///< zeta s + p J 1
};

/// The law at one point under a split by principal stretches.
template <int dim> struct SplitEvaluation : PointEvaluation<dim> {
  SplitState<Batch, dim> state;
  SplitEnergies<Batch, dim> of;
  Batch warmth = 0; ///< what `warmed` adds to each normal tau, which no tangent knows
};

/// A cell that keeps what share_split_pressure evaluates.
template <class Cell, Frame frame> struct SplitCellState : CellState<Cell, frame> {
  SplitEvaluation<Cell::dim> known[Cell::points];

  SplitCellState() { this->split = known; }
};
template <class Cell, Frame frame, bool principal>
using CellStateOf = std::conditional_t<principal, SplitCellState<Cell, frame>, CellState<Cell, frame>>;

template <int dim, bool principal>
using EvaluationOf = std::conditional_t<principal, SplitEvaluation<dim>, PointEvaluation<dim>>;

/// What the law of a point of such a split is asked; J_minus_1 is that of the cure.
template <Frame frame, int d>
SplitState<Batch, d> split_state(const PointLaw& law, const Tensor<Batch, d>& H, const Batch& J_minus_1,
                                 const Batch& J_th, const Degradations<Batch>& g, const Batch* history, int q,
                                 const FlowConditions<Batch>& at) {
  SplitState<Batch, d> s{left_strain(H), detm1(H), J_minus_1, J_th, Batch(0.0), g, g.e2.g, at};
  if (!law.flows()) return s;
  const PointHistory<Batch, d> old = read_history<frame>(law, history, q);
  s.left = s.left + push(plus_identity(H), old.A - identity<Batch, d>());
  s.alpha = old.alpha;
  return s;
}
/// The same of a history that is that of the displacement: nothing flows.
template <class Cell, Frame frame>
inline SplitState<Batch, Cell::dim> held_state(const PointLaw& law, const CellState<Cell, frame>& s,
                                               const Batch& J_th, const Degradations<Batch>& g,
                                               const Batch* history, int q) {
  const Batch J_minus_1 = law.parameters.locking == Locking::none ? detm1(s.H[q]) : s.shared_volume(q);
  return split_state<frame>(law, s.H[q], J_minus_1, J_th, g, history, q, {Batch(1.0), 0, true});
}

/// The flow of a body that has none.
template <int d> Return<Batch, d> no_flow() {
  Return<Batch, d> r;
  for (int i = 0; i < symmetric_size(d); ++i) r.trial[i] = r.dev_b[i] = Batch(0.0);
  r.y = r.scale = Batch(1.0);
  r.alpha = r.dbeta = Batch(0.0);
  r.plastic = r.y < r.y;
  r.failed = 0;
  return r;
}

/// Not inlined: it is long, and a call costs nothing beside it.
template <class Cell, Frame frame>
[[gnu::noinline, gnu::flatten]] SplitEvaluation<Cell::dim>
split_point(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s, int q) {
  const Locking locking = law.parameters.locking;
  SplitEvaluation<Cell::dim> e;
  e.k = kinematics(s.H[q]);
  e.g = point_degradations<Cell, frame>(law, in.phi, q, in.history); // flow knows the stress as a whole
  const Batch J_minus_1 = locking == Locking::none ? e.k.J_minus_1 : s.shared_volume(q);
  e.state = split_state<frame>(law, s.H[q], J_minus_1, point_thermal_volume<Cell>(law, in.theta, q), e.g,
                               in.history, q, point_conditions<Cell>(law, in, q));
  e.g.e2.g += (in.unilateral - 1) * unilateral_part(e.g);
  e.state.pressed = e.g.e2.g;
  if (law.flows()) {
    const SplitResponse<Batch, Cell::dim> response = split_response(law, e.state);
    e.flow = response.flow;
    e.of = response.of;
  } else {
    e.flow = no_flow<Cell::dim>();
    e.of = elastic_split(law.parameters, e.state);
  }
  e.Je_minus_1 = elastic_volume(e.state);
  e.zeta = locking == Locking::fbar ? e.k.J / (Batch(1.0) + J_minus_1) : Batch(1.0);
  e.tau = split_stress(e.state, e.of);
  if (in.warming != nullptr) {
    e.warmth =
        (Batch(1.0) + J_minus_1) * warmed({Batch(0.0), Batch(0.0), Batch(0.0)}, in.warming, J_minus_1, q).p;
    for (int i = 0; i < 3; ++i) e.tau[i] += e.warmth;
  }
  e.p = (1.0 / 3) * (trace(e.tau) / (Batch(1.0) + J_minus_1));
  e.dp = Batch(0.0);
  return e;
}

/// With the pressure that the cell shares.
template <class Cell, Frame frame>
inline SplitEvaluation<Cell::dim> evaluate_split(const PointLaw& law, const MotionInput& in,
                                                 const CellState<Cell, frame>& s, int q) {
  const Locking locking = law.parameters.locking;
  SplitEvaluation<Cell::dim> e =
      locking == Locking::mean && s.split != nullptr ? s.split[q] : split_point<Cell, frame>(law, in, s, q);
  if (locking == Locking::mean) {
    e.p = s.shared_pressure(q);
    e.tau = dev(e.tau);
    for (int i = 0; i < 3; ++i) e.tau[i] += e.p * e.k.J;
  }
  if (locking == Locking::fbar) e.tau = e.zeta * e.tau;
  return e;
}

/// The p of `mean` under a split by principal stretches, from tr tau/(3 J) of the points.
template <class Cell, Frame frame>
inline void share_split_pressure(const PointLaw& law, const MotionInput& in, CellState<Cell, frame>& s) {
  if (law.parameters.locking != Locking::mean) return;
  VolumeField<Cell> sum;
  sum.clear();
  for (int q = 0; q < Cell::points; ++q) {
    const auto e = split_point<Cell, frame>(law, in, s, q);
    s.modes.add(sum, q, s.map[q].weight * ((1.0 / 3) * trace(e.tau) / (Batch(1.0) + s.shared_volume(q))));
    if (s.split != nullptr) s.split[q] = e;
  }
  s.mean_p = s.modes.project(sum);
}

template <class Cell, Frame frame>
inline PointEvaluation<Cell::dim> evaluate_unsplit(const PointLaw& law, const MotionInput& in,
                                                   const CellState<Cell, frame>& s, int q) {
  const MaterialParameters& m = law.parameters;
  PointEvaluation<Cell::dim> e;
  e.k = kinematics(s.H[q]);
  e.g = point_degradations<Cell, frame>(law, in.phi, q, in.history, in.unilateral);
  e.flow = law.isochoric(s.H[q], e.k, read_history<frame>(law, in.history, q), e.g,
                         point_conditions<Cell>(law, in, q));
  const Batch J_minus_1 = m.locking == Locking::none ? e.k.J_minus_1 : s.shared_volume(q);
  const Volumetric<Batch> v = warmed(
      law.pressure(J_minus_1, point_thermal_volume<Cell>(law, in.theta, q), e.g), in.warming, J_minus_1, q);
  e.p = m.locking == Locking::mean ? s.shared_pressure(q) : v.p;
  e.dp = v.dp;
  e.Je_minus_1 = v.Je_minus_1;
  e.zeta = m.locking == Locking::fbar ? e.k.J / (Batch(1.0) + J_minus_1) : Batch(1.0);
  e.tau = (m.G * (e.zeta * e.g.e1.g)) * e.flow.dev_b;
  for (int i = 0; i < 3; ++i) e.tau[i] += e.p * e.k.J;
  return e;
}

template <class Cell, Frame frame, bool principal = false>
inline EvaluationOf<Cell::dim, principal> evaluate_point(const PointLaw& law, const MotionInput& in,
                                                         const CellState<Cell, frame>& s, int q) {
  if constexpr (principal)
    return evaluate_split<Cell, frame>(law, in, s, q);
  else
    return evaluate_unsplit<Cell, frame>(law, in, s, q);
}

/// Where the cost of the choice does not matter.
template <class Cell, Frame frame>
inline PointEvaluation<Cell::dim> evaluate_any(const PointLaw& law, const MotionInput& in,
                                               const CellState<Cell, frame>& s, int q) {
  if (law.principal()) return evaluate_split<Cell, frame>(law, in, s, q);
  return evaluate_unsplit<Cell, frame>(law, in, s, q);
}

/// Collects the lanes that left the domain of the law.
template <class Cell, Frame frame>
inline void note(CellStatus& status, const PointLaw& law, const CellState<Cell, frame>& s,
                 const PointEvaluation<Cell::dim>& e, int q) {
  if (has_state(law.parameters))
    status.bad |= bits(~within_state(
        law.parameters, law.parameters.locking == Locking::none ? e.k.J_minus_1 : s.shared_volume(q)));
  status.bad |= bits(~(e.k.J > Batch(0.0)) | ~(e.flow.y > Batch(0.0))) | e.flow.failed;
  status.min_J = min(e.k.J, status.min_J);
}

} // namespace impact
