# Laws of damage: AT1 (profile, strength), the spectral split, degradation of plastic bodies (E1): plastic energy as a
# drive, with a threshold, and the ductile degradation. References are closed forms and a return map written out here.
# labels: run
# timeout: 120
import math

import numpy

import _runs as runs

BLOCK = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid"}
CELL = {**BLOCK, "mesh_set_n": 1, "bcs": "hold", "bc_hold_on": "solid", "coupling_snes_atol": 1e-13,
        "damage_snes_rtol": 1e-13, "damage_ksp_rtol": 1e-13}


def bisect(f, low, high):
    """Root of a function that is positive at low and negative at high."""
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if f(middle) > 0 else (low, middle)
    return (low + high) / 2


# AT1: phi = 1 at one end of a bar: phi = (1 - x/2l)^2 and nothing beyond 2l, energy Gc/2 on this side.
GC, WIDTH = 2.7, 0.1
energies = []
for n in (40, 80, 160):
    run = runs.run(f"at1_{n}", {
        **BLOCK, "mesh_set_n": n, "mesh_set_ny": 1, "mesh_set_lx": 0.5, "mesh_set_ly": 0.1, "material_solid_E": 210e3,
        "material_solid_nu": 0.3, "material_solid_damage": "at1", "material_solid_split": "volumetric", "material_solid_Gc": GC,
        "material_solid_gamma": WIDTH, "bcs": "hold,crack", "bc_hold_on": "solid", "bc_hold_type": "fix",
        "bc_crack_on": "left", "bc_crack_type": "damage", "bc_crack_value": 1, "ts_dt": 1, "ts_max_time": 1, "damage_snes_rtol": 1e-13,
        "probes": "near,far", "probe_near_at": "0.1,0.05", "probe_near_fields": "phi", "probe_far_at": "0.25,0.05",
        "probe_far_fields": "phi"})
    energies.append(abs(run["energy_fracture"][-1] / 0.1 - GC / 2))
    runs.check(f"AT1 n = {n}: phi at 2.5 l", run["probe_far_phi"][-1], 0, 0, relative=False)
    # the parabola is followed at the nodes exactly, as linear cells do in one dimension
    runs.check(f"AT1 n = {n}: phi at l", run["probe_near_phi"][-1], 0.25, 1e-12, relative=False)
runs.check("AT1 energy of a crack, h = l/32", energies[2] / (GC / 2), 0, 2e-3, relative=False)
for i in (0, 1):
    runs.check(f"AT1 energy, order of the error from n = {(40, 80)[i]} on", math.log2(energies[i] / energies[i + 1]), 2, 0.1,
               relative=False)

# One cell held at diag(1 + strain sin(pi t), 1): tension, back, compression. Elastic laws, rate-independent.
E, NU, L, STEPS = 210e3, 0.3, 0.015, 40
K, G = E / 3 / (1 - 2 * NU), E / 2 / (1 + NU)


def held(strain):
    """Energy and nominal stress of the undamaged law at diag(1 + strain, 1, 1)."""
    s = 1 + strain
    W = G / 2 * (s ** (-2 / 3) * (s * s + 2) - 3) + 1e-300
    U = K / 2 * ((s * s - 1) / 2 - math.log(s))
    return W + U, (G * s ** (-2 / 3) * (s * s - 1) * 2 / 3 + K / 2 * (s * s - 1)) / s


def cycle(name, strain, **more):
    return runs.run(name, {
        **CELL, "material_solid_E": E, "material_solid_nu": NU, "material_solid_Gc": GC, "material_solid_gamma": L,
        "material_solid_residual_stiffness": 0, "bc_hold_ux": f"{strain}*sin(pi*t)*x", "bc_hold_uy": 0,
        "ts_dt": 1 / STEPS, "ts_max_time": 1.5, **more})


for damage, split in (("at1", "volumetric"), ("at1", "spectral"), ("at2", "spectral")):
    strain = 0.03
    run = cycle(f"{damage}_{split}", strain, material_solid_damage=damage, material_solid_split=split)
    phi, worst_phi, onset = 0.0, 0.0, 0
    for i in range(1, STEPS + 1):
        psi, P = held(strain * math.sin(math.pi * run["time"][i]))
        drive = 1 - 3 * GC / (16 * L * psi) if damage == "at1" else 2 * psi / (2 * psi + GC / L)
        phi = max(phi, drive)
        if damage == "at1" and onset == 0 and phi > 0:
            onset = i
        worst_phi = max(worst_phi, abs(run["phi_max"][i] - phi))
    claim = f"{damage}, {split} split"
    runs.check(f"{claim}: largest error of phi in tension and back", worst_phi, 0, 1e-10, relative=False)
    runs.require(f"{claim}: phi never falls and stays within 0 and 1",
                 (numpy.diff(run["phi_max"]) >= 0).all() and run["phi_max"].max() <= 1)
    if damage == "at1":
        threshold = 3 * GC / (16 * L)
        runs.require(f"at1: no damage before the strength, from step {onset} on damage",
                     held(strain * math.sin(math.pi * run["time"][onset - 1]))[0] < threshold and
                     run["phi_max"][onset - 1] == 0 < run["phi_max"][onset])
    if split == "spectral":
        runs.check(f"{claim}: growth of phi in compression after tension", run["phi_max"][-1] - phi, 0, 1e-12,
                   relative=False)
strength = math.sqrt(3 * E * GC / (8 * L))
small = runs.run("at1_strength", {
    **BLOCK, "mesh_set_n": 1, "material_solid_E": E, "material_solid_nu": 0, "material_solid_damage": "at1", "material_solid_split": "volumetric",
    "material_solid_Gc": GC / 1e4, "material_solid_gamma": L, "material_solid_residual_stiffness": 0, "bcs": "x,y,pull",
    "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0, "bc_pull_on": "right",
    "bc_pull_ux": f"{2 * strength / E / 100}*t", "ts_dt": 0.01, "ts_max_time": 1})
runs.check("AT1 strength / 100", small["reaction_pull_x"].max() * 100, strength, 1e-3)
compressed = {split: cycle(f"compression_{split}", -0.03, material_solid_damage="at2", material_solid_split=split,
                           ts_max_time=0.5)["phi_max"][-1] for split in ("spectral", "volumetric")}
runs.check("compression with the spectral split: phi", compressed["spectral"], 0, 0, relative=False)
runs.check_between("compression with the volumetric split: phi", compressed["volumetric"], 0.1, 1)

# E1: a cell drawn to diag(s, 1/s): J = 1. Return map in principal axes: with g_p = g_e it does not know of damage.
SIGMA_Y, VOCE_R, VOCE_S, END = 345.0, 60.0, 10.0, 0.25
Q = math.sqrt(2 / 3)


def stress_k(a):
    return SIGMA_Y + VOCE_R * (1 - math.exp(-VOCE_S * a))


def potential(a):
    return SIGMA_Y * a + VOCE_R * (a + (math.exp(-VOCE_S * a) - 1) / VOCE_S)


def flow(steps):
    """alpha, W and the first principal dev b at the steps of the path."""
    A, alpha, rows = numpy.ones(3), 0.0, [(0.0, 0.0, 0.0, 1.0)]
    for i in range(1, steps + 1):
        s = 1 + END * i / steps
        F = numpy.array([s, 1 / s, 1.0])
        b = F * F * A
        d, mu = b - b.mean(), G * b.mean()
        norm = G * math.sqrt((d * d).sum())
        if norm > Q * stress_k(alpha):
            beta = bisect(lambda x: norm - 2 * mu * x - Q * stress_k(alpha + Q * x), 0, norm / (2 * mu))
            d, alpha = (1 - 2 * mu * beta / norm) * d, alpha + Q * beta
            mean = bisect(lambda y: 1 - numpy.prod(d + y), 0.9, 1.5)
            b = d + mean
            A = b / (F * F)
        rows.append((alpha, G / 2 * (b.sum() - 3), d[0], s))
    return rows


E, NU = 71.48e3, 0.3
K, G = E / 3 / (1 - 2 * NU), E / 2 / (1 + NU)
GC, L = 40.0, 0.5
for name, threshold, alpha_c in (("ge", 0, 0), ("ge_threshold", 30, 0), ("ductile", 0, 0.12)):
    laws = {}
    if threshold:
        laws["material_solid_plastic_threshold"] = threshold
    if alpha_c:
        laws.update({"material_solid_ge": "ductile", "material_solid_alpha_c": alpha_c})

    def bar(steps):
        return runs.run(f"e1_{name}_{steps}", {
            **CELL, "material_solid_E": E, "material_solid_nu": NU, "material_solid_model": "j2",
            "material_solid_sigma_y": SIGMA_Y, "material_solid_voce_r": VOCE_R, "material_solid_voce_s": VOCE_S,
            "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_gp": "ge", "material_solid_Gc": GC,
            "material_solid_gamma": L, "material_solid_residual_stiffness": 0,
            "bc_hold_ux": f"{END}*t*x", "bc_hold_uy": f"(1/(1+{END}*t)-1)*y", "ts_dt": 1 / steps, "ts_max_time": 1,
            "probes": "p", "probe_p_at": "0.5,0.5", "probe_p_fields": "stress", **laws}, takes_back=not alpha_c)

    first_law = []
    flow_stress = lambda a: SIGMA_Y + VOCE_R * (1 - math.exp(-VOCE_S * a))
    for steps in (100, 200):
        run, rows = bar(steps), flow(steps)
        phi = worst_phi = worst_alpha = worst_stress = 0.0
        for i in range(1, steps + 1):
            alpha, W, dev, s = rows[i]
            p2 = 2 * rows[i - 1][0] / alpha_c if alpha_c else 2
            drive = W + max(0.0, potential(alpha) - threshold)
            slope = lambda x: p2 * (1 - x) ** (p2 - 1) * drive - GC / L * x
            # the smallest root above phi_n: the first of a fine grid where the slope has turned
            grid = numpy.linspace(phi, 1 - 1e-9, 20001)
            first = next((j for j, x in enumerate(grid) if slope(x) <= 0), len(grid) - 1)
            phi = phi if first == 0 else bisect(slope, grid[first - 1], grid[first])
            worst_phi = max(worst_phi, abs(run["phi_max"][i] - phi))
            worst_alpha = max(worst_alpha, abs(run["alpha_max"][i] - alpha))
            stress = (1 - phi) ** (2 * alpha / alpha_c if alpha_c else 2) * G * dev  # of the new alpha; J = 1
            worst_stress = max(worst_stress, abs(run["probe_p_stress_xx"][i] - stress))
        runs.check(f"E1 {name}, {steps} steps: largest error of phi (end {phi:.4f})", worst_phi, 0, 1e-8, relative=False)
        runs.check(f"E1 {name}, {steps} steps: largest error of alpha (end {alpha:.4f})", worst_alpha, 0, 1e-9,
                   relative=False)
        runs.check(f"E1 {name}, {steps} steps: largest error of the stress / sigma_y", worst_stress / SIGMA_Y, 0, 1e-7,
                   relative=False)
        if not alpha_c:
            # chi g k dalpha, and what the crack takes back: (g(phi) - g(phi_n)) (D_p - H_s).
            a, p = run["alpha_max"], run["phi_max"]
            least = min(0.9 * (1 - p[i])**2 * flow_stress(a[i]) * (a[i] - a[i - 1])
                        + ((1 - p[i])**2 - (1 - p[i - 1])**2) * (max(0.0, potential(a[i]) - threshold) - 0.1 * potential(a[i]))
                        for i in range(1, steps + 1))
            runs.check(f"E1 {name}, {steps} steps: smallest dissipation at a point, with what the crack takes back",
                       runs.smallest_dissipation(run.log), least, 1e-4)
        first_law.append(abs(run["balance_first_law"][-1]))
        if steps == 200:
            runs.check_between(f"E1 {name}: dissipated by flow, of the work",
                               run["dissipated_plastic"][-1] / run["work_external"][-1], -1, 1)
    runs.check_between(f"E1 {name}: first law at 200 steps", first_law[1], 0, 0.02)
    runs.check(f"E1 {name}: order of the first law's error in the step", math.log2(first_law[0] / first_law[1]), 1, 0.25,
               relative=False)

# The first steps of the gallery's notched bar: flow begins at the notch, damage waits for it.
run = runs.run("bar", {"ts_max_time": 0.02, "output_vis_times": 0.02}, files=[runs.option_file("ductile_bar.opts")])
runs.require("notched bar: no damage before flow, then at the notch first",
             all(phi == 0 for phi, alpha in zip(run["phi_max"][1:], run["alpha_max"]) if alpha == 0) and
             run["probe_root_phi"][-1] > run["probe_centre_phi"][-1] >= 0 and run["alpha_max"][-1] > 0)
runs.finish()
