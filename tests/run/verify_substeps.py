# labels: run
# timeout: 120
# long: 200
"""Sub-steps of the damage equation (-damage_ts_dt) and of the heat balance (-heat_ts_dt). Without a rate they change nothing. With one, in a body whose
strain is held, they are the same as steps of that length, and the error against a reference with short steps is of
first order in the length of the sub-steps; in a body that is pulled, too. Heat: one step of even motion in sub-steps
is as many steps, and the energy form keeps the first law with whatever happens in a step."""
import math

import _runs as runs

E, NU, GC, WIDTH, TIME = 72e9, 0.33, 4950.6, 0.5e-3, 8e-5
BASE = {"ts_type": "static", "units": "SI", "mesh": runs.mesh("block.geo"), "materials": "solid", "material_solid_E": E,
        "material_solid_nu": NU, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": GC,
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
held = {n: final(f"held_{n}", {**HELD, **RATE}, 1, n) for n in ((20, 40, 80) if runs.long() else (40, 80))}
whole = final("held_whole", {**HELD, **RATE}, 1)
runs.check_between("held strain, what 80 sub-steps change of phi", held[80]["phi_max"][-1] - whole["phi_max"][-1],
                   0.01, 0.5)
steps = final("held_steps", {**HELD, **RATE}, 40)
same("held strain, 1 step in 40 sub-steps and 40 steps", held[40], steps, 1e-10)
runs.check("held strain, 1 step in 40 sub-steps and 40 steps: dissipated by damage", held[40]["dissipated_damage"][-1],
           steps["dissipated_damage"][-1], 1e-9)
runs.check_between("held strain: what the whole step would book", whole["dissipated_damage"][-1] / steps["dissipated_damage"][-1],
                   0, 0.9)
WARM = {**HELD, **RATE, "material_solid_c_v": 2.4e6}
warm = {n: final(f"warm_{n}", WARM, *n) for n in ((1, 40), (40, None))}
runs.check("held strain with heat, 1 step in 40 sub-steps and 40 steps: energy_thermal", *(r["energy_thermal"][-1] - r["energy_thermal"][0] for r in warm.values()),
           5e-3)
fine = final("held_reference", {**HELD, **RATE}, 1, 1280)
runs.check_between("held strain, reference: largest phi, far from rest and from start", fine["phi_max"][-1], 0.2, 0.9)
PAIRS = ((20, 40), (40, 80)) if runs.long() else ((40, 80),)
for a, b in PAIRS:
    error = [abs(held[n]["phi_max"][-1] - fine["phi_max"][-1]) for n in (a, b)]
    # The reference has an error of its own: 1/16 of that of 80 sub-steps.
    runs.check(f"held strain, order of the error from {a} to {b} sub-steps", math.log2(error[0] / error[1]), 1, 0.12,
               relative=False)

# The rate law explicitly, without an equation. Its capacity is lumped: it has a reference of its own, near that of the equation.
def explicit(name, steps, most=1, **more):
    return final(name, {**HELD, **RATE, "damage_substeps": most, **more}, steps)


SSP = {"damage_ts_type": "ssp"}
exact = explicit("explicit_reference", 640, **SSP)
runs.check("explicit, reference: phi over that of the equation", exact["phi_max"][-1] / fine["phi_max"][-1], 1, 5e-3)
runs.check("explicit, reference: dissipated by damage over that of the equation", exact["dissipated_damage"][-1] / fine["dissipated_damage"][-1], 1, 1e-2)
for name, method, order in (("euler", {}, 1), ("ssp", SSP, 2)):
    errors = {n: abs(explicit(f"explicit_{name}_{n}", n, **method)["phi_max"][-1] - exact["phi_max"][-1]) for n in ((40, 80, 160) if runs.long() else (40, 80))}
    print(f"     {name}: errors of phi", {n: f"{error:.2e}" for n, error in errors.items()})
    for a, b in ((40, 80), (80, 160)) if runs.long() else ((40, 80),):
        runs.check(f"explicit, {name}, order of the error from {a} to {b} steps", math.log2(errors[a] / errors[b]), order, 0.15, relative=False)
one = explicit("explicit_one", 1, 1000)
runs.check("explicit, one step in as many sub-steps as are stable", one["phi_max"][-1] / exact["phi_max"][-1], 1, 0.03)
runs.require("no node is held back by these", "held back" not in one.log)
held_back = explicit("explicit_held_back", 1)
runs.check_between("explicit, a step that is too long: largest phi over that of the law", held_back["phi_max"][-1] / exact["phi_max"][-1], 0.05, 1)
runs.require("the log tells of nodes held back", "held back (-damage_substeps)" in held_back.log)
two = runs.run("explicit_ranks", {**HELD, **RATE, "damage_substeps": 1, "ts_dt": TIME / 20}, ranks=2)
one = explicit("explicit_rank", 20)
for column in ("phi_max", "energy_fracture", "dissipated_damage"):
    runs.check(f"explicit, two ranks over one: {column}", two[column][-1] / one[column][-1], 1, 1e-12)
for more, words in (({"material_solid_c": "inf"}, ["-damage_substeps", "material_<id>_c"]), ({"damage_ts_dt": TIME / 4}, ["-damage_substeps", "-damage_ts_dt"]),
                    ({"damage_ts_type": "beuler"}, ["-damage_ts_type", "euler or ssp"])):
    refused = runs.run("explicit_refused", {**HELD, **RATE, "damage_substeps": 2, "ts_dt": TIME, **more}, code=2)
    line = [line for line in refused.log.splitlines() if line.startswith("impact: ")][-1]
    runs.require(f"{more}: {line}", all(word in line for word in words))

# Pulled: motion and damage take turns, so that steps and sub-steps are shortened together.
pulled = {n: final(f"pulled_{n}", {**PULLED, **RATE}, n, 4) for n in ((20, 40, 80) if runs.long() else (40, 80))}
fine = final("pulled_reference", {**PULLED, **RATE}, 640)
for a, b in PAIRS:
    error = [abs(pulled[n]["phi_max"][-1] - fine["phi_max"][-1]) for n in (a, b)]
    runs.check(f"pulled, order of the error from {a} to {b} steps of 4 sub-steps", math.log2(error[0] / error[1]), 1,
               0.2, relative=False)

# Heat alone, with loads that change in time: sub-steps are steps.
HOT = {"units": "mm_t_s_MPa", "mesh": runs.mesh("block.geo"), "mesh_set_n": 8, "mesh_set_ny": 2, "mesh_set_lx": 8, "mesh_set_ly": 2,
       "materials": "solid", "material_solid_E": 72e3, "material_solid_nu": 0.33, "material_solid_c_v": 2.4,
       "material_solid_conductivity": 50, "ts_max_time": 1, "heat_snes_rtol": 1e-14, "heat_ksp_rtol": 1e-14,
       "probes": "p", "probe_p_at": "5,1", "probe_p_fields": "theta"}
LOADS = {"bcs": "warm,flux,air,source", "bc_warm_on": "left", "bc_warm_type": "temperature", "bc_warm_value": "300+40*sin(3*t)",
         "bc_flux_on": "right", "bc_flux_type": "heat_flux", "bc_flux_value": "30*t", "bc_air_on": "top", "bc_air_type": "convection",
         "bc_air_value": "300+20*t*t", "bc_air_h": 5, "bc_source_on": "solid", "bc_source_type": "heat_source", "bc_source_value": "2*t"}
COLUMNS = ("probe_p_theta", "theta_max", "energy_thermal", "heat_supplied", "heat_warm", "heat_air", "entropy_produced")


def same_heat(claim, options, steps, count, tolerance, columns=COLUMNS):
    """`steps` steps of `count` sub-steps against as many short steps, at the end."""
    whole = runs.run("heat_whole", {**options, "ts_dt": 1 / steps})
    split = runs.run("heat_split", {**options, "ts_dt": 1 / steps, "heat_ts_dt": 1 / steps / count})
    short = runs.run("heat_short", {**options, "ts_dt": 1 / steps / count})
    runs.require(f"{claim}: {steps} steps against {steps * count}", len(split["time"]) == steps + 1 and len(short["time"]) == steps * count + 1)
    for column in columns:
        scale = abs(short[column]).max()
        runs.check(f"{claim}: {column}", abs(split[column][-1] - short[column][-1]) / scale, 0, tolerance, relative=False)
    runs.check_between(f"{claim}: what sub-steps change of the temperature in K", abs(split["probe_p_theta"][-1] - whole["probe_p_theta"][-1]),
                       0.005, 20)


for form, weight in (("entropy", 1), ("energy", 0.5))[0 if runs.long() else 1:]:
    same_heat(f"heat alone, {form} form, weight {weight}", {**HOT, **LOADS, "physics": "heat", "heat_form": form, "heat_theta": weight},
              2, 5, 1e-11)
# An elastic body that is stretched evenly within the step cools as it does in short steps, and conducts meanwhile.
STRETCHED = {**HOT, "ts_type": "static", "material_solid_alpha_t": 2e-5, "bcs": "hold,warm", "bc_hold_on": "solid", "bc_hold_ux": "0.002*t*x*x",
             "bc_hold_uy": 0, "bc_warm_on": "left", "bc_warm_type": "temperature", "bc_warm_value": "298.15+5*t", "coupling_snes_atol": 1e-13}
same_heat("stretched, entropy form", STRETCHED, 1, 8, 1e-10, ("probe_p_theta", "theta_max", "energy_thermal", "heat_supplied"))
# In the energy form the stress is linear in time within a step; in short steps it follows the temperature too: 0.06 of 1.9 K.
if runs.long():
    same_heat("stretched, energy form", {**STRETCHED, "heat_form": "energy"}, 1, 8, 3e-4, ("probe_p_theta",))
# Flow, softening, damage, viscosity, conduction, inertia: sub-steps leave the first law of the energy form.
PLATE = {**HOT, "ts_type": "newmark", "mesh_set_lx": 1, "mesh_set_ly": 0.5, "mesh_set_ny": 4, "material_solid_rho": 2.81e-9,
         "material_solid_model": "j2", "material_solid_sigma_y": 368, "material_solid_voce_r": 78, "material_solid_voce_s": 32,
         "material_solid_softening": "linear", "material_solid_softening_w": 1e-3, "material_solid_alpha_t": 2.3e-5,
         "material_solid_b_d": 1e-6, "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 5, "material_solid_gamma": 0.25,
         "material_solid_c": 5e3, "bcs": "hold,pull", "bc_hold_on": "left", "bc_hold_type": "fix", "bc_pull_on": "right",
         "bc_pull_ux": "2500*t*t/(t+5e-6)", "bc_pull_uy": 0, "ics": "hot", "ic_hot_on": "bottom", "ic_hot_theta": 320, "heat_form": "energy",
         "ts_dt": 3e-6, "heat_ts_dt": 0.7e-6, "ts_max_time": 6e-5, "motion_snes_rtol": 1e-11, "damage_snes_rtol": 1e-12, "probe_p_at": "0.5,0.2",
         "coupling_snes_max_it": 3, "coupling_snes_atol": 1}
run = runs.run("plate", PLATE)
runs.check("plate, energy form, 5 sub-steps: first law", abs(run["balance_first_law"]).max(), 0, 1e-8, relative=False)
runs.check_between("plate: plastic strain, phi", min(run["alpha_max"][-1] / 0.05, run["phi_max"][-1] / 0.3), 1, 100)
two = runs.run("plate_2", PLATE, ranks=2)
runs.check("plate on 2 ranks: temperature", abs(two["theta_max"] - run["theta_max"]).max() / run["theta_max"].max(), 0, 1e-8, relative=False)
refused = runs.run("refused", {**HOT, **LOADS, "physics": "heat", "ts_dt": 1, "heat_ts_dt": 0}, code=2)
runs.require("a sub-step of no length is refused", "-heat_ts_dt" in refused.log)
refused = runs.run("refused_contact", {"mesh_set_h": 1, "heat_ts_dt": 1e-5}, files=[runs.option_file("brake.opts")], code=2)
runs.require("sub-steps are refused where heat passes a contact", "no sub-steps where heat passes a contact" in refused.log)
runs.finish()
