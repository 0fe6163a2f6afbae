# Temperature and motion together: free and held expansion (G4, G5), stresses of a hot ring (G3), heat at constant entropy,
# plastic heating (G6), the first law with flow, damage and viscosity (G7), one and several passes, restart, ranks.
# labels: run
# timeout: 120
# long: 200
import math

import numpy

import _runs as runs

BLOCK = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid",
         "material_solid_alpha_t": 1e-5, "material_solid_c_v": 2.43}
HEATED = {"bc_heat_on": "solid", "bc_heat_type": "temperature", "bc_heat_value": "298.15+t"}

# G4: a free body expands by F = exp(alpha dT) 1, without stress.
for extra in ({"mesh_set_dim": 3, "mesh_set_n": 2, "mesh_set_simplex": 1},
              {"mesh_set_dim": 3, "mesh_set_n": 2, "material_solid_locking": "mean"}):
    run = runs.run("g4", {
        **BLOCK, **HEATED, **extra, "material_solid_E": 70e3, "material_solid_nu": 0.33, "bcs": "x,y,z,heat",
        "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_z_on": "back", "bc_z_uz": 0,
        "ts_dt": 50, "ts_max_time": 100, "coupling_snes_atol": 1e-13, "motion_snes_rtol": 1e-13, "probes": "p",
        "probe_p_at": "1,1,1", "probe_p_fields": "u,stress"})
    name = f"G4 {list(extra.items())[-1]}"
    for k in "xyz":
        runs.check(f"{name}: u{k} of the corner", run["probe_p_u" + k][-1], math.expm1(1e-3), 1e-12, relative=False)
    runs.check(f"{name}: stress / E", max(abs(run["probe_p_stress_" + k][-1]) for k in ("xx", "yy", "zz", "xy")) / 70e3, 0,
               1e-12, relative=False)

# G5: held on all sides, tau = K/2 (exp(-6 alpha dT) - 1): compression.
for rise, reference in ((100, -205.266), (1000, -1998.28)):
    run = runs.run("g5", {
        **BLOCK, **HEATED, "mesh_set_dim": 3, "mesh_set_n": 2, "material_solid_E": 70e3, "material_solid_nu": 0.33,
        "bcs": "hold,heat", "bc_hold_on": "solid", "bc_hold_type": "fix", "ts_dt": rise, "ts_max_time": rise,
        "probes": "p", "probe_p_at": "0.3,0.3,0.3", "probe_p_fields": "stress"})
    exact = 70e3 / 3 / 0.34 / 2 * math.expm1(-6e-5 * rise)
    runs.check(f"G5 closed form at alpha dT = {1e-5 * rise}", exact, reference, 1e-5)
    for k in ("xx", "yy", "zz"):
        runs.check(f"G5 alpha dT = {1e-5 * rise}: stress {k}", run["probe_p_stress_" + k][-1], exact, 1e-10)

# Energy form: a plate that is sheared without expansion and flow keeps its temperature at every node, under each cure of locking. The
# pressure that points share would warm one and cool another (294 to 321 K) where it worked on the volume of the point alone.
PLATE = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_lx": 10, "mesh_set_ly": 4, "mesh_set_n": 20,
         "mesh_set_ny": 8, "materials": "solid", "material_solid_E": 2e5, "material_solid_nu": 0.3, "material_solid_c_v": 3.6,
         "material_solid_theta0": 300, "heat_form": "energy", "bcs": "l,r", "bc_l_on": "left", "bc_l_type": "fix", "bc_r_on": "right", "bc_r_ux": 0,
         "bc_r_uy": "0.5*t", "ts_max_time": 1}
SPACE = {"mesh_set_dim": 3, "mesh_set_n": 5, "mesh_set_ny": 2, "mesh_set_nz": 1, "bc_r_uz": 0}
for name, extra, most in (
        ("quadrilaterals", {"material_solid_locking": "mean"}, 0.1), ("F-bar", {"material_solid_locking": "fbar"}, 0.5),
        ("triangles", {"mesh_set_simplex": 1, "material_solid_locking": "mean"}, 0.1),
        ("triangles in rings", {"mesh_set_simplex": 1, "material_solid_locking": "mean", "plane": "axisymmetric", "mesh_set_n": 6,
                                "mesh_set_ny": 3}, 0.1),
        ("second order", {"order": 2, "mesh_set_n": 6, "mesh_set_ny": 3, "material_solid_locking": "mean"}, 0.1),
        ("triangles of second order", {"order": 2, "mesh_set_simplex": 1, "mesh_set_n": 6, "mesh_set_ny": 3, "material_solid_locking": "mean"}, 0.1),
        ("tetrahedra", {**SPACE, "mesh_set_simplex": 1, "material_solid_locking": "mean"}, 0.1),
        ("hexahedra", {**SPACE, "material_solid_locking": "mean"}, 0.1)):
    run = runs.run("plate", {**PLATE, **extra, "ts_dt": 0.1})
    for end in ("theta_min", "theta_max"):
        runs.check(f"sheared plate of {name}: {end}", run[end][-1], 300, most, relative=False)
    runs.check(f"sheared plate of {name}: first law", abs(run["balance_first_law"]).max(), 0, 1e-9, relative=False)

# G3: a ring with a hot bore, small strains: radial and hoop stress of Timoshenko and Goodier.
with open("ring.geo", "w") as file:
    file.write("""n = 48;
Point(1) = {1, 0, 0}; Point(2) = {2, 0, 0}; Point(3) = {2, 0.05, 0}; Point(4) = {1, 0.05, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = n + 1; Transfinite Curve {2, 4} = 2; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("solid") = {1}; Physical Curve("inner") = {4}; Physical Curve("outer") = {2};
""")
at = (1 + 0.5 / 48, 1.5 + 0.5 / 48, 2 - 0.5 / 48)
run = runs.run("g3", {
    **BLOCK, "mesh": "ring.geo", "plane": "axisymmetric", "material_solid_E": 70e3, "material_solid_nu": 0.3,
    "material_solid_conductivity": 100, "material_solid_theta0": 300, "bcs": "flat,hot,cold", "bc_flat_on": "solid",
    "bc_flat_uy": 0, "bc_hot_on": "inner", "bc_hot_type": "temperature", "bc_hot_value": 310, "bc_cold_on": "outer",
    "bc_cold_type": "temperature", "bc_cold_value": 300, "ts_dt": 1e6, "ts_max_time": 1e6, "probes": "a,b,c",
    **{f"probe_{p}_at": f"{r},0.02" for p, r in zip("abc", at)}, **{f"probe_{p}_fields": "stress" for p in "abc"}})
factor = 70e3 * 1e-5 * 10 / (2 * 0.7 * math.log(2))
for p, r in zip("abc", at):
    radial = factor * (-math.log(2 / r) - (1 - 4 / r**2) / 3 * math.log(2))
    hoop = factor * (1 - math.log(2 / r) - (1 + 4 / r**2) / 3 * math.log(2))
    runs.check(f"G3 radial stress at R = {r:.4f} / largest stress", run[f"probe_{p}_stress_xx"][-1] / factor, radial / factor,
               2e-3, relative=False)
    runs.check(f"G3 hoop stress at R = {r:.4f} / largest stress", run[f"probe_{p}_stress_zz"][-1] / factor, hoop / factor,
               2e-3, relative=False)

# Entropy form without conduction: a stretch by J = 1.002 cools by the closed form (oracle), whatever the steps.
ALUMINIUM = {**BLOCK, "material_solid_E": 72e3, "material_solid_nu": 0.33, "material_solid_alpha_t": 2.3e-5,
             "mesh_set_n": 1}
run = runs.run("isentropic", {**ALUMINIUM, "bcs": "hold", "bc_hold_on": "solid", "bc_hold_ux": "0.002*t*x",
                              "bc_hold_uy": 0, "ts_dt": 0.25, "ts_max_time": 1, "coupling_snes_atol": 1e-14})
runs.check("constant entropy, 4 steps: temperature", run["theta_max"][-1], 296.9046535838, 1e-11)

# G6: a bar of the paper's aluminium in tension, alpha_t = 0: dT = chi int k d alpha / c_V at alpha = 0.05, 0.1, 0.2.
PLASTIC = {"material_solid_model": "j2", "material_solid_sigma_y": 368, "material_solid_hardening": "voce",
           "material_solid_voce_r": 78, "material_solid_voce_s": 32}


def heating(steps):
    run = runs.run(f"g6_{steps}", {
        **ALUMINIUM, **PLASTIC, "mesh_set_dim": 3, "material_solid_alpha_t": 0, "bcs": "x,y,z,pull",
        "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_z_on": "back", "bc_z_uz": 0,
        "bc_pull_on": "right", "bc_pull_ux": "0.1118*t", "ts_dt": 1 / steps, "ts_max_time": 1})
    return run["alpha_max"][-1], run["theta_max"][-1] - 298.15


def closed_form(alpha):
    return 0.9 * (446 * alpha + 78 * math.expm1(-32 * alpha) / 32) / 2.43


for alpha, reference in ((0.05, 7.5387), (0.1, 15.6525), (0.2, 32.1358)):
    runs.check(f"G6 closed form at alpha = {alpha}", closed_form(alpha), reference, 1e-5)
(alpha_1, rise_1), (alpha_2, rise_2) = heating(60), heating(120)
gap_1, gap_2 = rise_1 / closed_form(alpha_1) - 1, rise_2 / closed_form(alpha_2) - 1
runs.check("G6 heating of a bar, 120 steps", rise_2, closed_form(alpha_2), 3e-3)
runs.check("G6 order of its error", math.log2(gap_1 / gap_2), 1, 0.1)
runs.check("G6 heating, extrapolated", 2 * gap_2 - gap_1, 0, 1e-4, relative=False)

# G7: a notched, insulated plate that flows and cracks under viscous stresses, with inertia. First law of the energy form to
# rounding in every step; of the entropy form to first order.
PLATE = {**BLOCK, **PLASTIC, "ts_type": "newmark", "mesh_set_n": 8, "mesh_set_ny": 4, "mesh_set_ly": 0.5,
         "material_solid_E": 72e3, "material_solid_nu": 0.33, "material_solid_rho": 2.81e-9,
         "material_solid_alpha_t": 2.3e-5, "material_solid_conductivity": 150, "material_solid_b_d": 1e-6,
         "material_solid_damage": "at2", "material_solid_Gc": 5, "material_solid_gamma": 0.25, "material_solid_c": 5e3,
         "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right",
         "bc_pull_ux": "2500*t*t/(t+5e-6)", "bc_pull_uy": 0, "ics": "hot", "ic_hot_on": "bottom",
         "ic_hot_theta": "320", "ts_max_time": 6e-5, "motion_snes_rtol": 1e-11,
         "damage_snes_rtol": 1e-12, "damage_ksp_rtol": 1e-13, "heat_snes_rtol": 1e-12, "heat_ksp_rtol": 1e-13}


def missing_of(run):
    """What the first law misses at each time, over the largest work."""
    energies = ("energy_kinetic", "energy_elastic", "energy_plastic", "energy_fracture", "energy_thermal",
                "dissipated_numerical", "energy_numerical")
    stored = sum(run[column] for column in energies if column in run.history)
    return (stored - stored[0] - run["work_external"] - run["heat_supplied"]) / run["work_external"].max()


def audit(name, **more):
    run = runs.run(name, {**PLATE, **more}, refused=5)  # once it cracks steps are cut
    return run, missing_of(run)


for passes in (1, 20):
    run, missing = audit(f"g7_{passes}", heat_form="energy", ts_dt=1e-6, coupling_snes_max_it=passes)
    runs.check(f"G7 energy form, {passes} passes: what the first law misses / work", abs(missing).max(), 0, 1e-8,
               relative=False)
runs.require("G7 the plate flows, cracks, and warms in every way", run["alpha_max"][-1] > 0.05 and run["phi_max"][-1] > 0.5
             and min(run["dissipated_" + kind][-1] for kind in ("viscous", "damage", "plastic"))
             > 1e-3 * run["work_external"].max() and run["energy_thermal"][-1] > 1.2 * run["energy_thermal"][0])
print(f"     work {run['work_external'][-1]:.4g}, plastic {run['dissipated_plastic'][-1]:.3g}, viscous "
      f"{run['dissipated_viscous'][-1]:.3g}, damage {run['dissipated_damage'][-1]:.3g}, theta {run['theta_max'][-1]:.5g}")
# Flow apart, whose law keeps an error of the size of the elastic strain (E10 in theory.md): here 1e-3.
ELASTIC = {"material_solid_model": "elastic", "material_solid_c": 1e3, "material_solid_b_d": 1e-5, "ic_hot_theta": 298.15,
           "ts_max_time": 1.5e-5, "coupling_snes_max_it": 20}
misses = [abs(audit(f"entropy_{n}", **ELASTIC, ts_dt=1.5e-5 / n)[1]).max() for n in ((15, 30, 60) if runs.long() else (30, 60))]
runs.check_between("entropy form: what the first law misses / work, 60 steps", misses[-1], 1e-4, 1e-2)
for before, after in zip(misses, misses[1:]):
    runs.check("entropy form: order of what the first law misses", math.log2(before / after), 1, 0.1)
run, missing = audit("entropy_flow", ts_dt=5e-7, ts_max_time=3e-5, coupling_snes_max_it=20)
flow = abs(missing).max()
runs.require("entropy form: every step produces entropy", numpy.diff(run["entropy_produced"]).min() > 0)
# An insulated body: what was dissipated, at the temperature at which it was.
heat = sum(run["dissipated_" + kind] for kind in ("viscous", "damage", "plastic"))
mean = numpy.sum(numpy.diff(heat)) / run["entropy_produced"][-1]
runs.check_between("entropy form: temperature at which heat was produced", mean, 298, run["theta_max"].max())
runs.check_between("entropy form with flow: what the first law misses / work", flow, 1e-5, 5e-3)

# Damage that is driven by plastic energy (gp = ge), with a threshold, and the ductile degradation exchange energy with the plastic heat
# (theory.md, 11): a bar of one strain, so stiff that the error of flow is small. The exchange is a good part of the work in each. From t = 0.1
# on, because all of the elastic branch lies in the first step.
BAR = {**BLOCK, "mesh_set_n": 1, "material_solid_E": 7.2e6, "material_solid_nu": 0.33, "material_solid_model": "j2",
       "material_solid_sigma_y": 368, "material_solid_hardening": "linear", "material_solid_linear_h": 200,
       "material_solid_alpha_t": 2.3e-6, "material_solid_damage": "at2", "material_solid_Gc": 20, "material_solid_gamma": 0.25,
       "material_solid_c": 0.1, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
       "bc_pull_on": "right", "bc_pull_ux": "0.1*t", "ts_max_time": 1, "coupling_snes_max_it": 50, "coupling_snes_atol": 1e-8,
       "motion_snes_rtol": 1e-11, "damage_snes_rtol": 1e-12}
for name, law in (("gp", {"material_solid_gp": "ge"}),
                  ("threshold", {"material_solid_gp": "ge", "material_solid_plastic_threshold": 10}),
                  ("ductile", {"material_solid_ge": "ductile", "material_solid_gp": "ge", "material_solid_alpha_c": 0.05}))[0 if runs.long() else 1:]:
    misses = []
    for n in (10, 20, 40) if runs.long() else (20, 40):
        run = runs.run(f"{name}_{n}", {**BAR, **law, "ts_dt": 1 / n}, takes_back=name != "threshold")
        missing = missing_of(run)
        misses.append(abs(missing[-1] - missing[n // 10]))
    for before, after in zip(misses, misses[1:]):
        runs.check(f"{name}, entropy form: order of what the first law misses, {after:.2e} of the work", math.log2(before / after), 1, 0.1)
    heat = 2.43 * (run["theta_max"][-1] - 298.15)
    other = runs.run(f"{name}_energy", {**BAR, **law, "ts_dt": 1 / 40, "heat_form": "energy"}, takes_back=name != "threshold")
    runs.check(f"{name}, energy form: what the first law misses / work", abs(other["balance_first_law"]).max(), 0, 1e-8, relative=False)
    runs.check(f"{name}: heat of both forms", heat, 2.43 * (other["theta_max"][-1] - 298.15), 0.03)
    flow = 0.9 * (368 * run["alpha_max"][-1] + 100 * run["alpha_max"][-1]**2)  # without damage
    runs.check_between(f"{name}: damaged, by {run['phi_max'][-1]:.2f}, and other heat than {flow:.3g} of flow alone", abs(heat / flow - 1),
                       0.02, 0.9)

# Ranks and restart of all of it.
one, _ = audit("all_1", heat_form="energy", ts_dt=3e-6, checkpoint_every=10, checkpoint_keep=10, coupling_snes_max_it=5, coupling_snes_atol=1e-3)
if runs.long():
    two = runs.run("all_2", {**PLATE, "heat_form": "energy", "ts_dt": 3e-6, "coupling_snes_max_it": 5, "coupling_snes_atol": 1e-3},
                   ranks=2, refused=5)
    for column in ("energy_thermal", "theta_max", "energy_fracture", "alpha_max"):
        runs.check(f"2 ranks: {column}", abs(two[column] - one[column]).max() / abs(one[column]).max(), 0, 1e-8, relative=False)
again = runs.run("all_1", {**PLATE, "heat_form": "energy", "ts_dt": 3e-6, "checkpoint_every": 10, "checkpoint_keep": 10, "coupling_snes_max_it": 5,
                           "coupling_snes_atol": 1e-3, "restart": "all_1/checkpoints/checkpoint_000001.h5"}, refused=5)
runs.check("restart: largest difference of the temperature", abs(again["theta_max"] - one["theta_max"]).max(), 0, 1e-12,
           relative=False)
runs.check("restart: the first law goes on", abs(again["balance_first_law"]).max(), 0, 1e-8, relative=False)
runs.finish()
