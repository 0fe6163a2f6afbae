# labels: run
# timeout: 240
# long: 240
"""Energy splits in whole runs: what a broken cell bears when it is pulled and when it is pressed, against closed forms, and the
first law of plates that flow, break and are turned round under the spectral split with each thing that it meets."""
import math

import _runs as runs

E, NU = 210e3, 0.3
K, G = E / 3 / (1 - 2 * NU), E / 2 / (1 + NU)
BLOCK = {"ts_type": "static", "units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "materials": "solid",
         "material_solid_E": E, "material_solid_nu": NU, "material_solid_damage": "at2", "material_solid_Gc": 2.7,
         "material_solid_gamma": 0.3}
GAMMA = 2.0
SPLITS = {"none": {}, "volumetric": {}, "star_convex": {"material_solid_star_gamma": GAMMA}, "spectral": {}, "no_tension": {},
          "drucker_prager": {"material_solid_strength_ratio": 2.5}}

# One cell, broken from the start, in uniaxial strain: the faces of a crack across the load that opens and closes again.
STRAIN = 0.03


def stresses(s, split):
    """Nominal axial stress and axial shear modulus a broken cell keeps at diag(s, 1, 1)."""
    volume = K / 2 * (s * s - 1)
    shape = G * s ** (-2 / 3) * (s * s - 1) * 2 / 3
    pressed = {"none": 0, "volumetric": volume, "star_convex": (1 + GAMMA) * volume, "spectral": volume + shape,
               "no_tension": volume + shape, "drucker_prager": volume + shape}
    return 0 if s > 1 else pressed[split] / s


for split, more in SPLITS.items():
    run = runs.run(f"faces_{split}", {
        **BLOCK, **more, "mesh_set_n": 1, "material_solid_split": split, "material_solid_residual_stiffness": 1e-9,
        "bcs": "x,y,push,crack", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom,top", "bc_y_uy": 0, "bc_push_on": "right",
        "bc_push_ux": f"{STRAIN}*sin(2*pi*t)", "bc_crack_on": "solid", "bc_crack_type": "damage", "bc_crack_value": 1,
        "ts_dt": 0.125, "ts_max_time": 1})
    for i in range(1, 9):
        s = 1 + STRAIN * math.sin(2 * math.pi * run["time"][i])
        if abs(s - 1) < 1e-9:
            continue
        expected = stresses(s, split)
        runs.check(f"broken cell, {split}: stress at {100 * (s - 1):+.1f} %, over K e", run["reaction_push_x"][i] / (K * STRAIN),
                   expected / (K * STRAIN), 1e-6, relative=False)

# A plate sheared, pulled and pressed while it flows and breaks. The first law holds to the first order of the steps.
FLOW = {"material_solid_model": "j2", "material_solid_sigma_y": 300, "material_solid_linear_h": 2000}
HEAT = {"material_solid_c_v": 3.6, "material_solid_alpha_t": 1.2e-5, "material_solid_conductivity": 45}
SPECTRAL = {"material_solid_split": "spectral"}
OPEN = {"material_solid_split": "no_tension"}
KINDS = {
    "flow": {**SPECTRAL, **FLOW},
    "flow, g_p = g_e": {**SPECTRAL, **FLOW, "material_solid_gp": "ge"},
    "flow, F-bar": {**SPECTRAL, **FLOW, "material_solid_locking": "fbar"},
    "flow in a sheet": {**SPECTRAL, **FLOW, "plane": "stress"},
    "flow with heat": {**SPECTRAL, **FLOW, **HEAT},
    "flow with heat, energy form": {**SPECTRAL, **FLOW, **HEAT, "heat_form": "energy"},
    "mean volume": {**SPECTRAL, "material_solid_nu": 0.49, "material_solid_locking": "mean"},
    "heat": {**SPECTRAL, **HEAT},
    "sheet": {**SPECTRAL, "plane": "stress"},
    "no tension": OPEN,
    "no tension, mean volume": {**OPEN, "material_solid_nu": 0.49, "material_solid_locking": "mean"},
    "no tension, sheet with heat": {**OPEN, **HEAT, "plane": "stress"},
    "cone": {"material_solid_split": "drucker_prager", "material_solid_strength_ratio": 2.5},
    "cone, sheet with heat": {"material_solid_split": "drucker_prager", "material_solid_strength_ratio": 2.5, **HEAT, "plane": "stress"},
    "star-convex, flow with heat": {"material_solid_split": "star_convex", "material_solid_star_gamma": GAMMA, **FLOW, **HEAT},
}


def plate(name, more, steps):
    flows = "material_solid_model" in more
    size = 0.006 if flows else 0.01
    return runs.run(f"{name}_{steps}".replace(" ", "_").replace(",", "").replace("=", ""), {
        **BLOCK, "mesh_set_n": 4, "material_solid_Gc": 1 if flows and "material_solid_gp" not in more else 20, "bcs": "hold,push", "bc_hold_on": "left", "bc_hold_type": "fix",
        "bc_push_on": "right", "bc_push_ux": f"{size}*sin(2*pi*t)", "bc_push_uy": f"{size}*sin(pi*t)", "ts_dt": 1 / steps,
        "ts_max_time": 0.9, "coupling_snes_atol": 1e-8, "energy_stop": 0, **more},
        takes_back="material_solid_gp" in more)


# Each has what others have by one.
TWINS = ("flow", "flow, F-bar", "flow with heat", "heat", "sheet", "no tension", "no tension, mean volume", "cone")
for name, more in KINDS.items():
    if name in TWINS and not runs.long():
        continue
    residual = []
    for steps in (40, 80):
        run = plate(name, more, steps)
        residual.append(abs(run["balance_first_law"]).max())
        runs.require(f"{name}, {steps} steps: damage grows, from 0.05 on, and never falls",
                     run["phi_max"][-1] > 0.05 and (run["phi_max"][1:] - run["phi_max"][:-1] >= -1e-14).all())
    runs.check_between(f"{name}: residual of the first law", residual[1], 0, 0.03)
    if "heat_form" not in more:  # which holds it to rounding
        runs.check_between(f"{name}: that of half the step over it", residual[1] / residual[0], 0, 0.65)
runs.finish()
