#pragma once
#include <impact/kernel/motion_point.hpp>

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

/// tau_33 of a point and its modulus, d tau_33 = (modulus + 2 tau_33) dF_33/F_33 less what p J has of it.
struct AcrossSheet {
  Batch stress, modulus;
};

template <class Law> inline AcrossSheet across_sheet(const Law& law, const PointEvaluation<2>& e) {
  const ModulusParts<Batch, 2> a =
      law_modulus<5>(law.parameters, e.flow, e.g.e1.g, e.g.p.g / e.g.e1.g, Batch(e.p * e.k.J),
                     Batch(e.dp * (e.k.J * e.k.J)), e.zeta, false, true);
  Batch modulus = a.volume + 2.0 * a.shear - a.exchange + a.B[2] + a.Bt[2];
  if (a.flow) modulus -= a.n[2] * a.M[2] + a.Mt[2] * a.n[2];
  return {e.tau[2], modulus};
}
inline AcrossSheet across_sheet(const PointLaw& law, const SplitEvaluation<2>& e) {
  SplitState<Dual<Batch, 1>, 2> s = lifted<1>(e.state);
  s.left[2].d[0] = 2.0 * (Batch(1.0) + e.state.left[2]);
  s.J_minus_1.d[0] = e.k.J;
  s.volume = s.J_minus_1;
  const Dual<Batch, 1> tau = split_stress(s, split_response(law, s).of)[2];
  return {tau.v, tau.d[0] - 2.0 * tau.v + e.p * e.k.J};
}

/// Sets F_33 of all points, from that at t_n. Returns the lanes in which there is no root in the range.
template <class Cell, Frame frame, bool principal = false>
inline int find_thickness(const PointLaw& law, const MotionInput& in, CellState<Cell, frame>& s) {
  int failed = 0;
  if constexpr (frame == Frame::plane_stress) {
    const MaterialParameters& m = law.parameters;
    read_thickness<Cell, frame>(in.history, s);
    for (int q = 0; q < Cell::points; ++q) {
      const Batch C_n = s.start_33[q] * (Batch(2.0) + s.start_33[q]);
      const auto minus_stress = [&](const Batch& x, Batch& slope) {
        s.H[q][4] = x;
        const auto e = evaluate_point<Cell, frame, principal>(law, in, s, q);
        const Batch F = Batch(1.0) + x, B = F * F;
        auto [stress, modulus] = across_sheet(law, e);
        if (law.viscous() && in.u_n) {
          const Batch f = (2 / in.dt) * viscosity(m, e.g);
          stress += f * (B * (x * (Batch(2.0) + x) - C_n));
          modulus += 2.0 * (f * (B * B));
        }
        // d tau_33 = (a_3333 + tau_33) dF_33/F_33, of whose a the pressure's part has its geometric one
        // inside
        slope = -((modulus + 2.0 * stress - e.p * e.k.J) / F);
        return -stress;
      };
      const auto root = scalar_root(s.start_33[q], Batch(thinnest), Batch(thickest), Batch(1.0) > Batch(0.0),
                                    1e-7, minus_stress);
      s.H[q][4] = root.x;
      failed |= root.failed | bits((root.x < Batch(0.99 * thinnest)) | (root.x > Batch(0.99 * thickest)));
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
