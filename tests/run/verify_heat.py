# The heat equation: bar with an oscillating end (G1), half space (G2), ring with convection, heat across a crack (G8),
# balance of the heat that conditions supply, ranks, restart.
# labels: run
# timeout: 120
# long: 200
import math

import numpy

import _runs as runs

BAR = {"physics": "heat", "mesh": runs.mesh("block.geo"), "mesh_set_ny": 1, "materials": "solid"}

# G1, NAFEMS T3: 36.60 C at x = 0.08 m after 32 s; fine finite differences give 36.603. (Linear cells with the consistent
# capacity and the trapezoidal rule, worked out separately: 37.444, 36.793, 36.647 with 10, 20, 40 cells.) Errors of both
# capacities are equal and opposite in the leading order.
for n, tolerance in ((20, 1e-2), (40, 2e-3)):
    run = runs.run(f"g1_{n}", {
        **BAR, "mesh_set_n": n, "mesh_set_lx": 0.1, "mesh_set_ly": 0.01, "material_solid_conductivity": 35,
        "material_solid_rho": "7200 kg/m^3", "material_solid_c_v": "440.5 J/(kg.K)", "material_solid_theta0": 273.15,
        "bcs": "cold,hot", "bc_cold_on": "left", "bc_cold_type": "temperature", "bc_cold_value": 273.15,
        "bc_hot_on": "right", "bc_hot_type": "temperature", "bc_hot_value": "273.15+100*sin(pi*t/40)",
        "ts_dt": 0.5, "ts_max_time": 32, "heat_theta": 0.5, "probes": "p", "probe_p_at": "0.08,0.005",
        "probe_p_fields": "theta"})
    runs.check(f"G1 {n} cells: temperature in C", run["probe_p_theta"][-1] - 273.15, 36.603, tolerance)
    runs.require(f"G1 {n} cells: no column of motion", not {"energy_kinetic", "work_external", "balance"} & set(run.history))

# G2: the end of a half space jumps by 100 K: erfc(x/(2 sqrt(a t))) with a = 1e-4 m^2/s.
HALF = {
    **BAR, "mesh_set_n": 120, "mesh_set_lx": 0.06, "mesh_set_ly": 0.001, "material_solid_conductivity": 100,
    "material_solid_c_v": 1e6, "material_solid_theta0": 300, "bcs": "hot", "bc_hot_on": "left",
    "bc_hot_type": "temperature", "bc_hot_value": 400, "ts_dt": 4e-3, "ts_max_time": 1, "probes": "p",
    "probe_p_at": "0.01,0.0005", "probe_p_fields": "theta"}
run = runs.run("g2", HALF)
runs.check("G2 temperature at x = 10 mm, t = 1 s", (run["probe_p_theta"][-1] - 300) / 100, math.erfc(0.5), 5e-3)
# k dT sqrt(4 t/(pi a)) per area, with what the half cell at the end holds from the jump on.
runs.check("G2 heat in the half space", run["energy_thermal"][-1] / 0.001, 100 * 100 * math.sqrt(4 / (math.pi * 1e-4)), 1e-2)

runs.check("G2: what came in is stored, by default where bodies only conduct", numpy.ptp(run["energy_thermal"]), run["heat_hot"][-1], 1e-9)
left = runs.run("g2_entropy", {**HALF, "heat_form": "entropy"})
runs.check_between("G2: what the entropy form misses, over what came in", abs(numpy.ptp(left["energy_thermal"]) / left["heat_hot"][-1] - 1), 1e-4, 1e-2)

# The same in steps far below c_V h^2/6k: with the capacity at the nodes, as without an option, no node leaves the range of the
# temperatures that there are. Heat that comes in at one side of a cell for a moment leaves the nodes beyond it as they were.
SUDDEN = {**BAR, "mesh_set_n": 40, "material_solid_conductivity": 1, "material_solid_c_v": 1, "material_solid_theta0": 300,
          "bcs": "hot", "bc_hot_on": "left", "bc_hot_type": "temperature", "bc_hot_value": 400, "ts_dt": 1e-5, "ts_max_time": 2e-4}
for form in ("entropy", "energy") if runs.long() else ("energy",):
    for name, more in (("quadrilaterals", {}), ("triangles", {"mesh_set_simplex": 1}), ("hexahedra", {"mesh_set_dim": 3})):
        run = runs.run("sudden", {**SUDDEN, **more, "heat_form": form})
        runs.check_between(f"sudden heat, {form} form, {name}: coldest node", run["theta_min"].min(), 300 - 1e-9, 300)
        runs.check_between(f"sudden heat, {form} form, {name}: hottest node", run["theta_max"].max(), 300, 400 + 1e-9)
        runs.require("and entropy is produced", (numpy.diff(run["entropy_produced"]) > 0).all())
    swings = runs.run("sudden", {**SUDDEN, "heat_form": form, "heat_capacity": "consistent"})
    runs.check_between("which the consistent capacity does not hold", swings["theta_min"].min(), 270, 299)

# A ring, hot inside, in air: q = 2 pi k h_z (T_i - T_air)/(ln(b/a) + k/(h b)), steady.
with open("ring.geo", "w") as file:
    file.write("""n = 40;
Point(1) = {1, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 0.1, 0}; Point(4) = {1, 0.1, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n + 1; Transfinite Curve {2, 4} = 2; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("solid") = {1}; Physical Curve("inner") = {4}; Physical Curve("outer") = {2};
""")
RING = {"physics": "heat", "mesh": "ring.geo", "plane": "axisymmetric", "materials": "solid",
        "material_solid_conductivity": 3, "material_solid_c_v": 1, "material_solid_theta0": 300, "bcs": "hot,air",
        "bc_hot_on": "inner", "bc_hot_type": "temperature", "bc_hot_value": 400, "bc_air_on": "outer",
        "bc_air_type": "convection", "bc_air_value": 300, "bc_air_h": 2.5}
run = runs.run("ring", {**RING, "ts_dt": 1e6, "ts_max_time": 2e6, "heat_form": "energy"})
power = 2 * math.pi * 3 * 0.1 * 100 / (math.log(2) + 3 / (2.5 * 2))
runs.check("ring: power in at the inner side", numpy.diff(run["heat_hot"])[-1] / 1e6, power, 2e-4)
runs.check("ring: power out at the outer side", -numpy.diff(run["heat_air"])[-1] / 1e6, power, 2e-4)
runs.check("ring: temperature of the outer side", run["mean_air_theta"][-1], 300 + power / (2.5 * 2 * math.pi * 2 * 0.1), 1e-5)

# G8: steady flux through a bar across a crack, dT/int dx/(k g(phi)).
profile = "0.8*exp(-abs(x-0.5)/0.1)"
x = (numpy.arange(20000) + 0.5) / 20000
degraded = (1 - 1e-6) * (1 - 0.8 * numpy.exp(-abs(x - 0.5) / 0.1)) ** 2 + 1e-6
for gtheta, resistance in (("ge", (1 / degraded).mean()), ("one", 1.0)):
    run = runs.run(f"g8_{gtheta}", {
        **BAR, "physics": "damage,heat", "mesh_set_n": 100, "mesh_set_ly": 0.1, "material_solid_E": 1,
        "material_solid_nu": 0, "material_solid_damage": "at2", "material_solid_Gc": 1, "material_solid_gamma": 0.1,
        "material_solid_conductivity": 2, "material_solid_c_v": 1, "material_solid_gtheta": gtheta,
        "bcs": "crack,cold,hot", "bc_crack_on": "solid", "bc_crack_type": "damage", "bc_crack_value": profile,
        "ics": "crack", "ic_crack_on": "solid", "ic_crack_phi": profile, "bc_cold_on": "left",
        "bc_cold_type": "temperature", "bc_cold_value": 300, "bc_hot_on": "right", "bc_hot_type": "temperature",
        "bc_hot_value": 350, "ts_dt": 1e5, "ts_max_time": 2e5})
    runs.check(f"G8 g_theta {gtheta}: flux across the crack", numpy.diff(run["heat_hot"])[-1] / 1e5 / 0.1,
               2 * 50 / resistance, 1e-2)

# Everything that supplies heat at once, on hexahedra: the energy form balances to rounding, the entropy form to first order.
BLOCK = {"physics": "heat", "mesh": runs.mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 4 if runs.long() else 2, "materials": "solid",
         "material_solid_conductivity": 0.7, "material_solid_c_v": 1.3, "material_solid_theta0": 300,
         "bcs": "cold,flux,air,source", "bc_cold_on": "left", "bc_cold_type": "temperature", "bc_cold_value": "300-20*t",
         "bc_flux_on": "right,top", "bc_flux_type": "heat_flux", "bc_flux_value": "30*(1+y)*t", "bc_air_on": "front",
         "bc_air_type": "convection", "bc_air_value": "310+5*x", "bc_air_h": "2+z", "bc_source_on": "solid",
         "bc_source_type": "heat_source", "bc_source_value": "40*x*sin(3*t)", "ics": "warm", "ic_warm_on": "solid",
         "ic_warm_theta": "300+10*x*(1-x)", "ts_max_time": 1, "heat_snes_rtol": 1e-13, "heat_ksp_rtol": 1e-12,
         "material_solid_alpha_t": 1e-3}  # which a body that does not move has no use for
conditions = ("cold", "flux", "air", "source")


def gap(run):
    stored = run["energy_thermal"] - run["energy_thermal"][0]
    return (stored - run["heat_supplied"])[-1] / abs(run["heat_air"][-1])


gaps = {}
for form, rule in (("energy", 1), ("energy", 0.5), ("entropy", 1), ("entropy", 0.5)):
    for steps in (40,) if form == "energy" else (20, 40):
        run = runs.run(f"all_{form}_{rule}_{steps}", {**BLOCK, "heat_form": form, "heat_theta": rule, "ts_dt": 1 / steps})
        gaps[form, rule, steps] = gap(run)
        runs.check(f"{form}, theta {rule}, {steps} steps: heat of the conditions is the heat supplied",
                   sum(run["heat_" + c] for c in conditions)[-1], run["heat_supplied"][-1], 1e-13)
    if form == "energy":
        runs.check(f"energy, theta {rule}: stored heat less heat supplied", gaps[form, rule, 40], 0, 1e-11, relative=False)
    else:
        order = math.log2(gaps[form, rule, 20] / gaps[form, rule, 40])
        runs.check(f"entropy, theta {rule}: order of the heat that is missing", order, 1 if rule == 1 else 2, 0.1)
# int 40 x sin(3 t) dV dt
runs.check("source: supplied heat", run["heat_source"][-1], 20 * (1 - math.cos(3)) / 3, 1e-3)

# Of a steady flux between two temperatures in the ring.
still = {key: value for key, value in RING.items() if key != "bc_air_h"}
run = runs.run("ring_entropy", {**still, "bc_air_type": "temperature", "bc_air_value": 350, "ts_dt": 1e7, "ts_max_time": 2e7})
power = 2 * math.pi * 3 * 0.1 * 50 / math.log(2)
runs.check("ring: entropy produced per time", numpy.diff(run["entropy_produced"])[-1] / 1e7, power * (1 / 350 - 1 / 400), 1e-3)

# Ranks and restart.
one = runs.run("ranks_1", {**BLOCK, "ts_dt": 0.1, "checkpoint_every": 5})
for ranks in (2, 4) if runs.long() else (2,):
    more = runs.run(f"ranks_{ranks}", {**BLOCK, "ts_dt": 0.1}, ranks=ranks)
    for column in ("energy_thermal", "heat_cold", "heat_air", "theta_max"):
        runs.check(f"{ranks} ranks: {column}", abs(more[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-11,
                   relative=False)
again = runs.run("ranks_1", {**BLOCK, "ts_dt": 0.1, "checkpoint_every": 5, "restart": "ranks_1/checkpoints/checkpoint_000001.h5"})
runs.require("restart: resumed at half, and the same to the last digit", "resumed from" in again.log and all(
    (again[column] == one[column]).all() for column in one.history))
runs.finish()
