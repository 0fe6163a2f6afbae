#pragma once
#include <impact/kernel/extra_stress.hpp>

#include <impact/material/modulus.hpp>

/// Plane stress: the stretch across the sheet, F_33, is the root of tau_33 = 0 at every point, tau the whole
/// Kirchhoff stress with its viscous part (theory.md, plane stress). It is part of the history.
namespace impact {

/// Smallest and largest F_33 - 1 that are looked at.
inline constexpr double thinnest = -0.99, thickest = 9;

/// What a state knows of its F_33.
template <class Cell, Frame frame>
inline void read_thickness(const Batch* history, CellState<Cell, frame>& s) {
  if constexpr (frame == Frame::plane_stress)
    for (int q = 0; q < Cell::points; ++q)
      s.start_33[q] = s.H[q][4] = history ? history_at<frame>(history, q).stretch : Batch(0.0);
}

/// tau_33 of a point, and d tau_33/dln F_33.
struct AcrossSheet {
  Batch stress, slope;
};

inline AcrossSheet across_sheet(const PointLaw& law, const PointEvaluation<2>& e) {
  const ModulusParts<Batch, 2> a =
      law_modulus<5>(law.parameters, e.flow, e.g.e1.g, e.g.p.g / e.g.e1.g, Batch(e.p * e.k.J),
                     Batch(e.dp * (e.k.J * e.k.J)), e.zeta, false, true);
  Batch modulus = a.volume + 2.0 * a.shear - a.exchange + a.B[2] + a.Bt[2];
  if (a.flow) modulus -= a.n[2] * a.M[2] + a.Mt[2] * a.n[2];
  // of whose a the pressure's part has its geometric one inside
  return {e.tau[2], modulus + 2.0 * e.tau[2] - e.p * e.k.J};
}
inline AcrossSheet across_sheet(const PointLaw& law, const SplitEvaluation<2>& e) {
  SplitState<Dual<Batch, 1>, 2> s = lifted<1>(e.state);
  s.left[2].d[0] = 2.0 * (Batch(1.0) + e.state.left[2]);
  s.J_minus_1.d[0] = e.k.J;
  s.volume = s.J_minus_1;
  const Dual<Batch, 1> tau = split_stress(s, split_response(law, s).of)[2];
  return {tau.v + e.warmth, tau.d[0]};
}

/// The same of a point under the spectral split that does not flow, whose stretches in the plane are found
/// once.
template <class Cell, Frame frame> class ElasticSheet {
public:
  static bool is(const PointLaw& law) {
    return law.parameters.split == Split::spectral && law.parameters.sheet &&
           law.parameters.locking == Locking::none && !law.flows();
  }
  ElasticSheet(const PointLaw& law, const MotionInput& in, const CellState<Cell, frame>& s, int q)
      : m_(law.parameters) {
    Tensor<Batch, 2> H = s.H[q];
    H[4] = Batch(0.0);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history, in.unilateral);
    opened_ = g.e1.g;
    pressed_ = g.e2.g;
    J_minus_1_ = detm1(H);
    J_th_ = point_thermal_volume<Cell>(law, in.theta, q);
    Symmetric<Batch, 2> e =
        elastic_strain(m_, split_state<frame>(law, H, J_minus_1_, J_th_, g, in.history, q, {}));
    thermal_ = e[2];
    e[2] = Batch(0.0);
    flat_ = TensileMap<Batch, 2>(m_, e).at();
  }
  AcrossSheet at(const Batch& x) const {
    using D = Dual<Batch, 1>;
    const D F_less_1 = seed<Batch, 1>(x, 0);
    const D e_33 = D(Batch(1.0) + thermal_) * (F_less_1 * (D(2.0) + F_less_1)) + D(thermal_);
    const D dJ = (D(J_minus_1_ - (J_th_ - Batch(1.0))) + D(Batch(1.0) + J_minus_1_) * F_less_1) / D(J_th_);
    const D tau = sheet_stress(m_, flat_, e_33, dJ, opened_, pressed_);
    return {tau.v, (Batch(1.0) + x) * tau.d[0]};
  }

private:
  const MaterialParameters& m_;
  Batch opened_, pressed_; // g_1, g_2
  Batch J_minus_1_, J_th_; // with F_33 = 1
  Batch thermal_;          // e_33 there
  PrincipalParts<Batch, 2> flat_;
};

/// Sets F_33 of all points, from that at t_n. Returns the lanes in which there is no root in the range.
template <class Cell, Frame frame, bool principal = false>
inline int find_thickness(const PointLaw& law, const MotionInput& in, CellState<Cell, frame>& s) {
  int failed = 0;
  if constexpr (frame == Frame::plane_stress) {
    const MaterialParameters& m = law.parameters;
    read_thickness<Cell, frame>(in.history, s);
    const auto solve = [&](int q, auto&& across) {
      const Batch C_n = s.start_33[q] * (Batch(2.0) + s.start_33[q]);
      const bool viscous = law.viscous() && in.u_n;
      const Batch f =
          viscous ? (2 / in.dt) * viscosity(m, point_degradations<Cell, frame>(law, in.phi, q, in.history))
                  : Batch(0.0);
      const auto minus_stress = [&](const Batch& x, Batch& slope) {
        const Batch F = Batch(1.0) + x, B = F * F;
        AcrossSheet now = across(x);
        if (viscous) {
          const Batch more = f * (B * (x * (Batch(2.0) + x) - C_n));
          now.stress += more;
          now.slope += 2.0 * (more + f * (B * B));
        }
        slope = -(now.slope / F);
        return -now.stress;
      };
      const auto root = scalar_root(s.start_33[q], Batch(thinnest), Batch(thickest), Batch(1.0) > Batch(0.0),
                                    1e-7, minus_stress);
      s.H[q][4] = root.x;
      failed |= root.failed | bits((root.x < Batch(0.99 * thinnest)) | (root.x > Batch(0.99 * thickest)));
    };
    for (int q = 0; q < Cell::points; ++q) {
      if constexpr (principal)
        if (ElasticSheet<Cell, frame>::is(law) && in.warming == nullptr) {
          const ElasticSheet<Cell, frame> sheet(law, in, s, q);
          solve(q, [&](const Batch& x) { return sheet.at(x); });
          continue;
        }
      solve(q, [&](const Batch& x) {
        s.H[q][4] = x;
        return across_sheet(law, evaluate_point<Cell, frame, principal>(law, in, s, q));
      });
    }
  }
  return failed;
}

/// What the points are to know before the law is evaluated: the shared pressure of a split by principal
/// stretches, and F_33. Returns the lanes that failed.
template <class Cell, Frame frame, bool principal>
inline int share_unknowns(const PointLaw& law, const MotionInput& in, CellState<Cell, frame>& s) {
  if constexpr (principal) share_split_pressure<Cell, frame>(law, in, s);
  return find_thickness<Cell, frame, principal>(law, in, s);
}

/// The modulus that is left for the components in the plane when grad u_33 follows from tau_33 = 0.
inline Modulus<Batch, 4> condensed(const Modulus<Batch, 5>& a) {
  Modulus<Batch, 4> c;
  const Batch compliance = Batch(1.0) / a.c[4][4];
  for (int I = 0; I < 4; ++I) {
    const Batch factor = a.c[I][4] * compliance;
    for (int K = 0; K < 4; ++K) c.c[I][K] = a.c[I][K] - factor * a.c[4][K];
  }
  return c;
}

} // namespace impact
