# labels: run
# timeout: 120
"""Sub-steps of the damage equation (-damage_ts_dt). Without a rate they change nothing. With one, in a body whose
strain is held, they are the same as steps of that length, and the error against a reference with short steps is of
first order in the length of the sub-steps; in a body that is pulled, too."""
import math

import _runs as runs

E, NU, GC, WIDTH, TIME = 72e9, 0.33, 4950.6, 0.5e-3, 8e-5
BASE = {"ts_type": "static", "units": "SI", "mesh": runs.mesh("block.geo"), "materials": "solid", "material_solid_E": E,
        "material_solid_nu": NU, "material_solid_damage": "at2", "material_solid_Gc": GC,
        "material_solid_gamma": WIDTH, "mesh_set_lx": 4 * WIDTH, "mesh_set_ly": WIDTH, "mesh_set_n": 8, "mesh_set_ny": 2,
        "motion_snes_rtol": 1e-12, "damage_snes_rtol": 1e-13, "damage_ksp_rtol": 1e-13, "coupling_snes_max_it": 1,
        "ts_max_time": TIME}
STRAIN = 0.012
# All nodes are held: a stretch that rises along the bar.
HELD = {**BASE, "bcs": "hold", "bc_hold_on": "solid", "bc_hold_ux": f"{STRAIN / 3}*x*(1+x/{4 * WIDTH})", "bc_hold_uy": 0}
PULLED = {**BASE, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
          "bc_pull_on": "right", "bc_pull_ux": f"{STRAIN * 4 * WIDTH}*t/{TIME}"}
RATE = {"material_solid_c": 1e-3}


def final(name, options, steps, substeps=None):
    """Largest phi and energy of the crack at the end of `steps` steps, each in `substeps` of damage."""
    options = {**options, "ts_dt": TIME / steps}
    if substeps:
        options["damage_ts_dt"] = TIME / steps / substeps
    run = runs.run(name, options)
    runs.require(f"{name}: {steps} steps", len(run["time"]) == steps + 1)
    return run


def same(claim, a, b, tolerance):
    for column in ("phi_max", "energy_fracture", "energy_elastic"):
        scale = abs(b[column]).max()
        runs.check(f"{claim}: {column}", abs(a[column][-1] - b[column][-1]) / scale, 0, tolerance, relative=False)


plain, split = final("independent", PULLED, 4), final("independent_substeps", PULLED, 4, 7)
runs.check_between("without a rate: largest phi at the end", plain["phi_max"][-1], 0.2, 0.9)
for step in range(1, 5):
    runs.check(f"without a rate, step {step}: phi_max with 7 sub-steps and none", split["phi_max"][step],
               plain["phi_max"][step], 1e-10)
same("without a rate, sub-steps and none", split, plain, 1e-10)
held = {n: final(f"held_{n}", {**HELD, **RATE}, 1, n) for n in (20, 40, 80)}
whole = final("held_whole", {**HELD, **RATE}, 1)
runs.check_between("held strain, what 80 sub-steps change of phi", held[80]["phi_max"][-1] - whole["phi_max"][-1],
                   0.01, 0.5)
same("held strain, 1 step in 40 sub-steps and 40 steps", held[40], final("held_steps", {**HELD, **RATE}, 40), 1e-10)
fine = final("held_reference", {**HELD, **RATE}, 1, 1280)
runs.check_between("held strain, reference: largest phi, far from rest and from start", fine["phi_max"][-1], 0.2, 0.9)
for a, b in ((20, 40), (40, 80)):
    error = [abs(held[n]["phi_max"][-1] - fine["phi_max"][-1]) for n in (a, b)]
    # The reference has an error of its own: 1/16 of that of 80 sub-steps.
    runs.check(f"held strain, order of the error from {a} to {b} sub-steps", math.log2(error[0] / error[1]), 1, 0.12,
               relative=False)

# Pulled: motion and damage take turns, so that steps and sub-steps are shortened together.
pulled = {n: final(f"pulled_{n}", {**PULLED, **RATE}, n, 4) for n in (20, 40, 80)}
fine = final("pulled_reference", {**PULLED, **RATE}, 640)
for a, b in ((20, 40), (40, 80)):
    error = [abs(pulled[n]["phi_max"][-1] - fine["phi_max"][-1]) for n in (a, b)]
    runs.check(f"pulled, order of the error from {a} to {b} steps of 4 sub-steps", math.log2(error[0] / error[1]), 1,
               0.2, relative=False)
runs.finish()
