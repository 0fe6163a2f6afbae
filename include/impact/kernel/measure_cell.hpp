#pragma once
#include <impact/kernel/lumped_mass.hpp>
#include <impact/kernel/measure_input.hpp>
#include <impact/kernel/plane_stress.hpp>
#include <impact/kernel/point_geometry.hpp>
#include <impact/material/crack.hpp>
#include <impact/math/index.hpp>

/// The integrals of cell_kernels.hpp over one batch of cells.
namespace impact {

/// x cross v, of plane vectors its third component alone.
template <int d> void add_cross(const Batch& mass, const Batch* x, const Batch* v, Batch* sum) {
  if constexpr (d == 3)
    for (int i = 0; i < 2; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sum[i] += mass * (x[j] * v[k] - x[k] * v[j]);
    }
  sum[2] += mass * (x[0] * v[1] - x[1] * v[0]);
}

/// The place of a node.
template <int d> std::array<Batch, d> node_place(const EnergyInput& in, int a) {
  const Batch* const moved = in.moved ? in.moved : in.u;
  std::array<Batch, d> x;
  for (int i = 0; i < d; ++i) x[at(i)] = moved ? in.X[a * d + i] + moved[a * d + i] : in.X[a * d + i];
  return x;
}

/// Kinetic energy and momenta of a mass that stands at the nodes of a second-order cell.
template <class Cell, Frame frame>
inline void add_nodal_motion(const LumpedMass<Cell>& mass, const EnergyInput& in, EnergySums& sums) {
  constexpr int d = Cell::dim;
  for (int a = 0; a < Cell::nodes; ++a) {
    const Batch m = in.mass_factor * mass.at[a];
    for (int i = 0; i < d; ++i) {
      const Batch p = m * in.v[a * d + i];
      sums.kinetic += 0.5 * (p * in.v[a * d + i]);
      sums.momentum[i] += p;
    }
    if constexpr (frame != Frame::axisymmetric)
      add_cross<d>(m, node_place<d>(in, a).data(), &in.v[a * d], sums.spin);
  }
}

/// Of a point with the mass m, or of its parts at the nodes of a cell of first order.
template <class Cell> inline void add_spin(const EnergyInput& in, int q, const Batch& m, EnergySums& sums) {
  constexpr int d = Cell::dim;
  const auto& N = shape_table<Cell>.N[q];
  std::array<Batch, d> x{}, v{};
  for (int i = 0; i < d; ++i) x[at(i)] = v[at(i)] = Batch(0.0);
  for (int a = 0; a < Cell::nodes; ++a) {
    const std::array<Batch, d> place = node_place<d>(in, a);
    if (in.lumped) add_cross<d>(N[a] * m, place.data(), &in.v[a * d], sums.spin);
    for (int i = 0; i < d; ++i) {
      x[at(i)] += N[a] * place[at(i)];
      v[at(i)] += N[a] * in.v[a * d + i];
    }
  }
  if (!in.lumped) add_cross<d>(m, x.data(), v.data(), sums.spin);
}

/// N_a v_ai v_ai: v_i^2 of a mass that stands at the nodes.
template <class Cell> inline Batch nodal_square(const Batch* v, int q, int i) {
  return sum<Cell::nodes>(
      [&](int a) { return shape_table<Cell>.N[q][a] * (v[a * Cell::dim + i] * v[a * Cell::dim + i]); });
}

template <class Cell, Frame frame>
inline void add_motion(double rho, const EnergyInput& in, int q, const Batch& w, EnergySums& sums) {
  constexpr int d = Cell::dim;
  for (int i = 0; i < d; ++i) {
    const Batch v = interpolate<Cell, d>(in.v, q, i);
    sums.kinetic += (0.5 * rho) * in.mass_factor * (w * (in.lumped ? nodal_square<Cell>(in.v, q, i) : v * v));
    sums.momentum[i] += rho * in.mass_factor * (w * v);
  }
  if constexpr (frame != Frame::axisymmetric) add_spin<Cell>(in, q, rho * in.mass_factor * w, sums);
}

template <class Cell, Frame frame>
[[gnu::flatten]] void stored_energy(const PointLaw& law, const EnergyInput& in, EnergySums& sums) {
  constexpr int d = Cell::dim;
  const MaterialParameters& m = law.parameters;
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, in.history, 1, {in.patch, in.patch_pressure});
  read_thickness<Cell, frame>(in.history, s);
  const bool at_nodes = is_second_order<Cell> && in.v && in.lumped;
  LumpedMass<Cell> mass;
  for (int q = 0; q < Cell::points; ++q) {
    const Batch w = s.map[q].weight;
    const Kinematics<Batch, d> k = kinematics(s.H[q]);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history);
    const PointHistory<Batch, d> history = read_history<frame>(law, in.history, q);
    Symmetric<Batch, d> e = left_strain(s.H[q]);
    if (law.flows()) e = e + push(k.F, history.A - identity<Batch, d>());
    const Batch start = k.J23 * (Batch(1.0) + (1.0 / 3) * trace(e)) - Batch(1.0);
    const Batch z = trace_excess(k.J23 * dev(e), start);
    const Batch J_minus_1 = m.locking == Locking::none ? k.J_minus_1 : s.shared_volume(q);
    const Batch Je = law.pressure(J_minus_1, point_thermal_volume<Cell>(law, in.theta, q), g).Je_minus_1;
    PointEnergies<Batch> energy = point_energies<Cell>(law, z, Je, history.alpha, in.theta, q);
    if (law.principal()) {
      const auto state =
          held_state<Cell, frame>(law, s, point_thermal_volume<Cell>(law, in.theta, q), g, in.history, q);
      const SplitEnergies<Batch, d> split = split_response(law, state).of;
      energy.plus = split.plus;
      energy.minus = split.minus;
    }
    if (law.softens() && in.drive) energy.plastic = drive_at(in.drive, q).plastic;
    sums.elastic += w * (g.e1.g * energy.plus + g.e2.g * energy.minus);
    sums.plastic += w * (g.p.g * ((1 - m.taylor_quinney) * energy.plastic));
    if (m.damage != Damage::none && in.phi)
      sums.fracture += w * crack_energy(m, interpolate<Cell>(in.phi, q), k.inverse_F,
                                        gradient_of_scalar<Cell, frame>(s.map[q], in.phi, q));
    if (in.fatigue && in.phi)
      sums.fatigue += w * fatigue_energy(m, interpolate<Cell>(in.phi, q), in.fatigue[q]);
    sums.mass += m.rho * w;
    if (at_nodes)
      mass.add(q, m.rho, w);
    else if (in.v)
      add_motion<Cell, frame>(m.rho, in, q, w, sums);
  }
  if (!at_nodes) return;
  mass.finish();
  add_nodal_motion<Cell, frame>(mass, in, sums);
}

template <class Cell, Frame frame>
void stored_heat(const PointLaw& law, const EnergyInput& in, HeatSums& sums) {
  const MaterialParameters& m = law.parameters;
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, nullptr, 1, {in.patch, in.patch_pressure});
  read_thickness<Cell, frame>(in.history, s);
  LumpedMass<Cell> capacity;
  const auto add_heat = [&](const Batch& c, const Batch& theta) {
    sums.energy += c * (theta - Batch(m.theta0));
    sums.entropy += c * log_ratio(theta, Batch(m.theta0));
  };
  for (int q = 0; q < Cell::points; ++q) {
    const Batch w = s.map[q].weight, theta = interpolate<Cell>(in.theta, q);
    const Degradations<Batch> g = point_degradations<Cell, frame>(law, in.phi, q, in.history);
    const Batch J_th = point_thermal_volume<Cell>(law, in.theta, q);
    if (in.lumped_capacity)
      capacity.add(q, m.c_v, w);
    else
      add_heat(m.c_v * w, theta);
    if (law.principal()) {
      const Batch s_q = split_heat(law, held_state<Cell, frame>(law, s, J_th, g, in.history, q)).entropy;
      sums.energy += w * (theta * s_q);
      sums.entropy += w * s_q;
      continue;
    }
    const Batch J_minus_1 = m.locking == Locking::none ? detm1(s.H[q]) : s.shared_volume(q);
    const Batch Je = law.pressure(J_minus_1, J_th, g).Je_minus_1;
    const Batch g_v = select(Je >= Batch(0.0), g.e1.g, g.e2.g);
    const ElasticVolume<Batch> v{Je, J_th};
    sums.energy += w * thermoelastic_energy(law, v, g_v, theta);
    sums.entropy += w * thermoelastic_entropy(law, v, g_v);
  }
  if (!in.lumped_capacity) return;
  capacity.finish();
  for (int a = 0; a < Cell::nodes; ++a) add_heat(capacity.at[a], in.theta[a]);
}

template <class Cell, Frame frame> Batch cell_integral(const Batch* X, const Batch* values) {
  Batch sum = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const auto g = point_geometry<Cell, frame>(X, q);
    sum += g.weight * values[q];
  }
  return sum;
}

template <class Cell, Frame frame>
Batch inertial_release(const PointLaw& law, const Batch* X, const Batch* u, const Batch* a,
                       const Batch* moved) {
  constexpr int d = Cell::dim;
  Batch sum = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const auto g = point_geometry<Cell, frame>(X, q);
    const Tensor<Batch, d> H = gradient_of_vector<Cell, frame>(g, u);
    for (int i = 0; i < d; ++i) {
      Batch along = Batch(0.0);
      for (int j = 0; j < d; ++j) along += H[d * i + j] * interpolate<Cell, d>(moved, q, j);
      sum += (law.parameters.rho * g.weight) * (interpolate<Cell, d>(a, q, i) * along);
    }
  }
  return sum;
}

template <class Cell, Frame frame>
void plastic_exchange(const PointLaw& law, const CellFields& in, Batch* points) {
  for (int q = 0; q < Cell::points; ++q) points[q] = plastic_exchange_at<Cell, frame>(law, in, q);
}

template <class Cell, Frame frame>
void unilateral_energy(const PointLaw& law, const Batch* X, const Batch* phi, const Batch* history_n,
                       const Batch* drive, const Batch* drive_n, Batch& sum) {
  for (int q = 0; q < Cell::points; ++q) {
    const auto g = point_geometry<Cell, frame>(X, q);
    const Batch m = unilateral_part(point_degradations<Cell, frame>(law, phi, q, history_n));
    sum += g.weight * (m * (drive_at(drive, q).minus - drive_at(drive_n, q).minus));
  }
}

template <class Cell, Frame frame>
void cell_output(const PointLaw& law, const MotionInput& state, CellOutput& out) {
  constexpr int d = Cell::dim;
  MotionInput in = state;
  in.held = true; // a flow stress that temperature or rate have changed since would let it flow again
  CellState<Cell, frame> s;
  prepare<Cell, frame>(law, in.X, in.u, in.phi, in.theta, s, in.history, 1, {in.patch, in.patch_pressure});
  read_thickness<Cell, frame>(in.history, s);
  if (law.principal()) share_split_pressure<Cell, frame>(law, in, s);
  Symmetric<Batch, d> sigma = Batch(0.0) * identity<Batch, d>();
  out.alpha = out.phi = Batch(0.0);
  for (int q = 0; q < Cell::points; ++q) {
    const PointEvaluation<d> e = evaluate_any<Cell, frame>(law, in, s, q);
    Vector<Batch, d> h;
    const Symmetric<Batch, d> tau = e.tau + extra_stress<Cell, frame>(law, in, s, e, q, h);
    const Batch w = s.map[q].weight / s.modes.volume;
    sigma = sigma + (w / e.k.J) * tau;
    out.alpha += w * e.flow.alpha;
    if (in.phi) out.phi += w * interpolate<Cell>(in.phi, q);
  }
  for (int i = 0; i < 6; ++i) out.stress[i] = i < symmetric_size(d) ? sigma[i] : Batch(0.0);
  const Symmetric<Batch, d> deviator = dev(sigma);
  out.von_mises = sqrt(1.5 * dot(deviator, deviator));
  out.pressure = (-1.0 / 3) * trace(sigma);
}

template <class Cell, Frame frame> void mass_matrix(const PointLaw& law, const Batch* X, Batch* M) {
  const auto& N = shape_table<Cell>.N;
  for (int q = 0; q < Cell::points; ++q) {
    const auto g = point_geometry<Cell, frame>(X, q);
    const Batch w = law.parameters.rho * g.weight;
    for (int a = 0; a < Cell::nodes; ++a)
      for (int b = 0; b < Cell::nodes; ++b) M[a * Cell::nodes + b] += (N[q][a] * N[q][b]) * w;
  }
}

/// The smallest height: 1/max |Grad N_a| of the centroid, and for products of lines the smallest distance of
/// opposite sides there, 2/max |dxi_k/dX| with dxi_k/dX = sum_a sign_ak Grad N_a. Of the linear cell with the
/// same corners.
template <class Cell> Batch cell_size(const Batch* X) {
  if constexpr (is_second_order<Cell>) return cell_size<typename Cell::Corners>(X);
  constexpr int d = Cell::dim;
  constexpr auto& t = shape_table<Cell>;
  constexpr bool product = requires { Cell::sign; };
  PointGeometry<Cell, d == 2 ? Frame::plane_strain : Frame::solid> g;
  point_geometry(X, t.N0, t.dN0, 1, g);
  Batch steepest = Batch(0.0);
  for (int k = 0; k < (product ? d : Cell::nodes); ++k) {
    Vector<Batch, d> row = g.dN[k];
    if constexpr (product)
      for (int i = 0; i < d; ++i)
        row[i] = sum<Cell::nodes>([&](int a) { return Batch(Cell::sign[a][k]) * g.dN[a][i]; });
    steepest = max(dot(row, row), steepest);
  }
  return Batch(product ? 2.0 : 1.0) / sqrt(steepest);
}

} // namespace impact
