# The phase field: crack profile (D1), strength of a homogeneous bar (D2), rate law (D3), broken plastic points (E6).
# labels: run
# timeout: 120
import math
import xml.etree.ElementTree as ElementTree

import h5py
import numpy

import _runs as runs

TWO_THIRDS = numpy.longdouble(2) / 3
BLOCK = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid"}


def field_at(run, name, k=-1):
    """Coordinates and values of a nodal field at the k-th written time."""
    grid = [g for g in ElementTree.parse(run.dir + "/vis.xdmf").getroot().iter("Grid") if g.get("GridType") == "Uniform"][k]

    def data(part):
        file, path = part.find("DataItem").text.strip().split(":", 1)
        with h5py.File(run.dir + "/" + file) as h5:
            return h5[path][()]

    points = data(grid.find("Geometry"))
    values = data([part for part in grid.iter("Attribute") if part.get("Name") == name][0])
    return points, values.ravel()


# D1: phi = 1 at one end of a bar of 10 l: phi = cosh((B - x)/l)/cosh(B/l), energy Gc/2 tanh(B/l) on this side.
GC, WIDTH, B = 2.7, 0.1, 1.0
errors, energies = [], []
for n in (50, 100, 200):
    run = runs.run(f"d1_{n}", {
        **BLOCK, "mesh_set_n": n, "mesh_set_ny": 1, "mesh_set_lx": B, "mesh_set_ly": 0.1, "material_solid_E": 210e3,
        "material_solid_nu": 0.3, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": GC,
        "material_solid_gamma": WIDTH, "bcs": "hold,crack", "bc_hold_on": "solid", "bc_hold_type": "fix",
        "bc_crack_on": "left", "bc_crack_type": "damage", "bc_crack_value": 1, "ts_dt": 1, "ts_max_time": 1,
        "outputs": "vis", "output_vis_fields": "phi"})
    x, phi = field_at(run, "phi")
    exact = numpy.cosh((B - x[:, 0]) / WIDTH) / math.cosh(B / WIDTH)
    runs.require(f"D1 n = {n}: {phi.size} nodal values read", phi.size == 2 * (n + 1))
    errors.append(abs(phi - exact).max())
    energies.append(run["energy_fracture"][-1] / 0.1)
runs.check("D1 profile, h = l/10: largest error of phi", errors[1], 0, 1e-3, relative=False)
runs.check("D1 energy, h = l/10", energies[1], GC / 2 * math.tanh(B / WIDTH), 1e-3)
for i in (0, 1):
    runs.check(f"D1 profile, order of the error from n = {(50, 100)[i]} on",
               math.log2(errors[i] / errors[i + 1]), 2, 0.1, relative=False)
    differences = [abs(e - GC / 2 * math.tanh(B / WIDTH)) for e in energies]
    runs.check(f"D1 energy, order of the error from n = {(50, 100)[i]} on",
               math.log2(differences[i] / differences[i + 1]), 2, 0.1, relative=False)


def response(K, G, lateral, stretch):
    """Energy, nominal stress along x and stress across of the undamaged law at diag(stretch, lateral, 1).
    In long double, because small strains cancel."""
    stretch, lateral = numpy.longdouble(stretch), numpy.longdouble(lateral)
    J = stretch * lateral
    trace = stretch**2 + lateral**2 + 1
    W = G / 2 * (J ** (-TWO_THIRDS) * trace - 3)
    U = K / 2 * ((J * J - 1) / 2 - numpy.log(J))
    side = [G * J ** (-TWO_THIRDS) * (s * s - trace / 3) + K / 2 * (J * J - 1) for s in (stretch, lateral)]
    return W + U, side[0] / stretch, side[1]


def root(f, low, high):
    low, high = numpy.longdouble(low), numpy.longdouble(high)
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) * f(low) > 0 else (low, middle)
    return (low + high) / 2


# D2: one cell, rate-independent, motion and damage iterated: phi = 2 psi/(2 psi + Gc/l), P = (1 - phi)^2 P_0.
def bar(name, E, nu, Gc, width, strain, steps):
    run = runs.run(name, {
        **BLOCK, "mesh_set_n": 1, "material_solid_E": E, "material_solid_nu": nu, "material_solid_damage": "at2", "material_solid_split": "volumetric",
        "material_solid_Gc": Gc, "material_solid_gamma": width, "material_solid_residual_stiffness": 0,
        "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right",
        "bc_pull_ux": f"{strain}*t", "ts_dt": 1 / steps, "ts_max_time": 1, "coupling_snes_atol": 1e-12,
        "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-14 * E, "damage_snes_rtol": 1e-13, "damage_ksp_rtol": 1e-13})
    K, G = E / 3 / (1 - 2 * nu), E / 2 / (1 + nu)
    worst_phi = worst_force = 0
    forces = []
    for i in range(1, len(run["time"])):
        stretch = 1 + strain * run["time"][i]
        lateral = root(lambda s: response(K, G, s, stretch)[2], 0.5, 1.5)
        psi, P, _ = response(K, G, lateral, stretch)
        phi = 2 * psi / (2 * psi + Gc / width)
        forces.append((1 - phi) ** 2 * P)
        worst_phi = max(worst_phi, abs(run["phi_max"][i] - phi))
        worst_force = max(worst_force, abs(run["reaction_pull_x"][i] - forces[-1]))
    runs.check(f"D2 {name}: largest error of phi over {steps} steps", worst_phi, 0, 1e-9, relative=False)
    runs.check(f"D2 {name}: largest error of the force / strength", worst_force / max(forces), 0, 1e-8, relative=False)
    return run


E = 210e3
strength, onset = 9 / 16 * math.sqrt(E * 2.7 / 3 / 0.015), math.sqrt(2.7 / (3 * E * 0.015))
runs.check("D2 closed form of the strength", strength, 1996.68, 1e-5)
bar("finite_strain", E, 0.3, 2.7, 0.015, 0.04, 40)
# Strains a hundred times smaller, no lateral strain: the closed forms of small strain.
run = bar("small_strain", E, 0, 2.7e-4, 0.015, 2 * onset / 100, 200)
force = run["reaction_pull_x"]
runs.check("D2 strength / 100", force.max() * 100, strength, 1e-3)
runs.check("D2 strain at the strength * 100", 2 * onset * run["time"][force.argmax()], onset, 1e-2)
runs.check("D2 phi at the strength", run["phi_max"][force.argmax()], 0.25, 0.01, relative=False)

# D3: a held strain, Table 1 of the paper: the time to 0.9 of the rest value. lambda stays at t_n: first order in time.
E, NU, GC, WIDTH, RATE = 72e9, 0.33, 4950.6, 0.5e-3, 1e-3
K, G = E / 3 / (1 - 2 * NU), E / 2 / (1 + NU)
for psi, rest, time in ((1e6, 0.168050, 1.73670e-4), (5e6, 0.502482, 8.02872e-5), (2e7, 0.801584, 2.36126e-5)):
    strain = root(lambda e: response(K, G, 1, 1 + e)[0] - psi, 0, 0.2)

    def relax(steps, *more):
        return runs.run(f"d3_{psi:.0e}_{steps}", {
            **BLOCK, "units": "SI", "mesh_set_n": 1, "material_solid_E": E, "material_solid_nu": NU,
            "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": GC, "material_solid_gamma": WIDTH,
            "material_solid_c": RATE, "material_solid_residual_stiffness": 0, "bcs": "hold", "bc_hold_on": "solid",
            "bc_hold_ux": f"{float(strain)!r}*x", "bc_hold_uy": 0, "ts_dt": time / steps, "ts_max_time": time,
            "damage_snes_rtol": 1e-12, "damage_ksp_rtol": 1e-12, **dict(more)})["phi_max"][-1]

    coarse, fine = relax(100), relax(200)
    runs.check(f"D3 psi = {psi:.0e}: phi / phi_e at its time, 200 steps", fine / rest, 0.9, 0.01, relative=False)
    runs.check(f"D3 psi = {psi:.0e}: phi / phi_e, extrapolated", (2 * fine - coarse) / rest, 0.9, 2e-4, relative=False)

# E6: sheared by 10 % with phi held: with g_p = 1 the yield stress stays while the elastic stress fades, so that a
# broken point cannot flow and carries no deviator; with g_p = g_e the yield stress fades too.
G, SHEAR, SIGMA_Y = 72e3 / 2 / 1.33, 0.1, 368.0
elastic = G * math.sqrt(3 * SHEAR**2 + SHEAR**4)
for phi, gp in ((0.5, "one"), (0.5, "ge"), (0.95, "one"), (0.95, "ge"), (1, "one")):
    run = runs.run(f"e6_{phi}_{gp}", {
        **BLOCK, "mesh_set_n": 1, "material_solid_E": "72 GPa", "material_solid_nu": 0.33,
        "material_solid_model": "j2", "material_solid_sigma_y": SIGMA_Y, "material_solid_hardening": "none",
        "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 4.9506, "material_solid_gamma": 0.5,
        "material_solid_gp": gp, "bcs": "hold,broken", "bc_hold_on": "solid", "bc_hold_ux": f"{SHEAR}*t*y",
        "bc_hold_uy": 0, "bc_broken_on": "solid", "bc_broken_type": "damage", "bc_broken_value": phi, "ics": "broken",
        "ic_broken_on": "solid", "ic_broken_phi": phi, "ts_dt": 0.02, "ts_max_time": 1, "probes": "p",
        "probe_p_at": "0.5,0.5", "probe_p_fields": "von_mises"})
    g = (1 - 1e-6) * (1 - phi) ** 2 + 1e-6
    yield_stress = SIGMA_Y * (g if gp == "ge" else 1)
    claim = f"E6 phi = {phi}, g_p {gp}"
    runs.check(f"{claim}: von Mises stress", run["probe_p_von_mises"][-1], min(g * elastic, yield_stress), 1e-9)
    if g * elastic < yield_stress:
        runs.check(f"{claim}: plastic strain", run["alpha_max"][-1], 0, 0, relative=False)
    else:
        runs.check_between(f"{claim}: plastic strain", run["alpha_max"][-1], 0.01, SHEAR)
# Unloading and reloading: phi of a cell is the largest of its past; without bounds it heals. AT1 and AT2, quadratic, rate-independent.
K, G = 1000 / 3 / 0.4, 1000 / 2.6
CYCLE = {**BLOCK, "mesh_set_n": 1, "material_solid_E": 1000, "material_solid_nu": 0.3, "material_solid_Gc": 1, "material_solid_gamma": 1,
         "material_solid_residual_stiffness": 0, "damage_snes_rtol": 1e-13, "damage_ksp_rtol": 1e-13, "bcs": "hold", "bc_hold_on": "solid",
         "bc_hold_ux": "0.05*(t<1 ? t : t<2 ? 2-t : t-2)*x", "bc_hold_uy": 0, "ts_dt": 0.1, "ts_max_time": 4}
for model, bounds in (("at2", "vi"), ("at2", "history"), ("at2", "clip"), ("at1", "vi"), ("at2", "none")):
    run = runs.run(f"cycle_{model}_{bounds}", {**CYCLE, "material_solid_damage": model, "damage_bounds": bounds})
    phi = worst = 0.0
    for t, phi_now in zip(run["time"], run["phi_max"]):
        stretch = 1 + 0.05 * (t if t < 1 else 2 - t if t < 2 else t - 2)
        psi = float(response(K, G, 1, stretch)[0])
        free = 2 * psi / (2 * psi + 1) if model == "at2" else 1 - 3 / (16 * psi) if psi > 3 / 16 else 0.0
        phi = free if bounds == "none" else max(phi, free)
        worst = max(worst, abs(phi_now - phi))
    runs.check(f"loading cycle, {model}, {bounds}: largest error of phi, {run['phi_max'].max():.3f} at most", worst, 0, 1e-9, relative=False)
    steps = numpy.diff(run["phi_max"])
    if bounds == "none":
        runs.check_between("loading cycle without bounds: it heals, smallest step of phi", steps.min(), -1, -0.1)
        continue
    runs.check_between(f"loading cycle, {model}, {bounds}: smallest step of phi", steps.min(), 0, 1)
    runs.check_between(f"loading cycle, {model}, {bounds}: smallest step of the crack's energy", numpy.diff(run["energy_fracture"]).min(), 0, 1)

# Without a split compression drives damage too, and plastic energy where it is degraded: "history" keeps the whole drive at its largest.
SQUEEZE = {**CYCLE, "damage_bounds": "history", "bc_hold_ux": "-0.05*(t<1 ? t : t<2 ? 2-t : t-2)*x", "material_solid_damage": "at2"}
for split in ("none", "volumetric", "spectral"):
    run = runs.run(f"squeeze_{split}", {**SQUEEZE, "material_solid_split": split})
    runs.check_between(f"squeezed and let go, history, split {split}: smallest step of phi", numpy.diff(run["phi_max"]).min(), 0, 1)
    if split == "none":
        psi = float(response(K, G, 1, 0.9)[0])  # the last load is the largest
        runs.check("its phi after all is that of the largest energy", run["phi_max"][-1], 2 * psi / (2 * psi + 1), 1e-9)
run = runs.run("squeeze_j2", {**SQUEEZE, "material_solid_split": "none", "material_solid_gp": "ge", "material_solid_model": "j2",
                              "material_solid_sigma_y": 20, "material_solid_linear_h": 50, "coupling_snes_max_it": 100}, takes_back=True)
runs.check_between("squeezed and let go, history, j2 with a degraded yield stress: smallest step of phi", numpy.diff(run["phi_max"]).min(), 0, 1)
runs.check_between("it flowed", run["alpha_max"].max(), 1e-3, 1)

# The same of every node of a plate whose damage is not uniform, with a rate.
run = runs.run("cycle_plate", {
    **CYCLE, "mesh_set_n": 8, "material_solid_damage": "at2", "material_solid_gamma": 0.2, "material_solid_c": 20, "bcs": "hold,pull",
    "bc_hold_on": "left", "bc_hold_ux": 0, "bc_pull_on": "right", "bc_pull_ux": "0.1*(t<1 ? t : t<2 ? 2-t : t-2)*(0.5+y)",
    "bc_pull_uy": 0, "coupling_snes_max_it": 50, "outputs": "vis", "output_vis_fields": "phi"})
fields = []
for step in range(len(run["time"])):
    fields.append(field_at(run, "phi", step)[1])
runs.require("plate: all times were written", len(fields) == len(run["time"]) == 41 and numpy.ptp(fields[-1]) > 0.1)
runs.check_between("plate: smallest step of phi at a node", numpy.diff(fields, axis=0).min(), 0, 1)
runs.check_between("plate: phi at most", numpy.max(fields), 0.3, 1 + 1e-12)
runs.check("plate: phi at least", numpy.min(fields), 0, 1e-12, relative=False)
runs.finish()
