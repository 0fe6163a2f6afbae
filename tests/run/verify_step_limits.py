# labels: run
# timeout: 120
"""Limits on what a step may change (-ts_adapt_dalpha, -ts_adapt_dtheta), the tolerance of the temperature between
passes (-coupling_theta_tol) and what the last pass leaves (-coupling_error)."""
import math

import numpy

import _runs as runs

BLOCK = {"ts_type": "static", "mesh": runs.mesh("block.geo"), "mesh_set_n": 2, "materials": "solid",
         "material_solid_E": 1000, "material_solid_nu": 0.3}
PULL = {**BLOCK, "bcs": "clamp,pull", "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_pull_on": "right",
        "bc_pull_ux": "0.05*t", "ts_max_time": 1}

# Plastic strain: the elastic start takes long steps, flow the short ones that its limit asks for.
PLASTIC = {**PULL, "material_solid_model": "j2", "material_solid_sigma_y": 10, "material_solid_linear_h": 50,
           "ts_dt": 0.2}
MOST = 0.004
free, limited = runs.run("free", PLASTIC), runs.run("dalpha", {**PLASTIC, "ts_adapt_dalpha": MOST}, refused=3)
fine = runs.run("fine", {**PLASTIC, "ts_dt": 0.01})
runs.check_between("without the limit: largest growth of alpha_max in a step", numpy.diff(free["alpha_max"]).max(),
                   2 * MOST, 1)
runs.check_between("-ts_adapt_dalpha: largest growth", numpy.diff(limited["alpha_max"]).max(), 0.4 * MOST, MOST)
runs.require("-ts_adapt_dalpha: a step beyond it is cut and says so",
             f"the plastic strain grows by" in limited.log and f"-ts_adapt_dalpha is {MOST}" in limited.log)
runs.check("-ts_adapt_dalpha: the end is reached", limited["time"][-1], 1, 1e-12)
runs.check("-ts_adapt_dalpha: the plastic strain of short steps", limited["alpha_max"][-1], fine["alpha_max"][-1], 0.02)

# The same of a sheet, whose history holds its thickness behind the plastic strain.
free, limited = (runs.run(f"sheet_{limit}", {**PLASTIC, "plane": "stress", "ts_adapt_dalpha": limit}, refused=cuts)
                 for limit, cuts in ((0, 0), (MOST, 3)))
runs.check_between("sheet without the limit: largest growth of alpha_max in a step", numpy.diff(free["alpha_max"]).max(), 2 * MOST, 1)
runs.check_between("sheet, -ts_adapt_dalpha: largest growth", numpy.diff(limited["alpha_max"]).max(), 0.4 * MOST, MOST)

# Temperature: a heat pulse.
HEAT = {**BLOCK, "physics": "heat", "material_solid_c_v": 2.0, "material_solid_conductivity": 0.1, "bcs": "glow",
        "bc_glow_on": "solid", "bc_glow_type": "heat_source", "bc_glow_value": "400*pulse(t,0.25,0.75)", "ts_dt": 0.125,
        "ts_max_time": 1}
free, limited = runs.run("unlimited", HEAT), runs.run("dtheta", {**HEAT, "ts_adapt_dtheta": 5}, refused=3)
runs.check_between("without the limit: largest rise in a step", numpy.diff(free["theta_max"]).max(), 20, 30)
runs.check_between("-ts_adapt_dtheta: largest rise", numpy.diff(limited["theta_max"]).max(), 2, 5 * (1 + 1e-12))
runs.require("-ts_adapt_dtheta: a step beyond it is cut and says so", "the temperature changes by" in limited.log)
runs.check_between("-ts_adapt_dtheta: heated by the pulse, to the width of its edges", limited["theta_max"][-1] - 298.15,
                   95, 110)

# Passes end by the temperature: a body that heats as it is pulled fast, and expands.
WARM = {**PULL, "material_solid_c_v": 2.0, "material_solid_alpha_t": 1e-4, "ts_dt": 0.25, "coupling_error": 1,
        "motion_snes_rtol": 1e-13}
errors = {}
for tolerance in (1e-3, 1e-6, 1e-10):
    run = runs.run(f"passes_{tolerance}", {**WARM, "coupling_theta_tol": tolerance})
    errors[tolerance] = run["coupling_error"].max()
print("     coupling error by the tolerance of the temperature:", errors)
runs.check_between("tolerance 1e-3: what a single pass leaves", errors[1e-3], 1e-5, 1)
runs.check_between("tolerance 1e-6: coupling error", errors[1e-6], 0, 0.1 * errors[1e-3])
runs.check("tolerance 1e-10: coupling error", errors[1e-10], 0, 1e-8, relative=False)
default, same = (runs.run(name, {**WARM, "coupling_snes_atol": 1e-6, **more})
                 for name, more in (("default", {}), ("same", {"coupling_theta_tol": 1e-6})))
runs.require("the default is that of phi", numpy.array_equal(default["coupling_error"], same["coupling_error"]))

# Single passes: error and estimate are of first order in the step.
TIME = 8e-5
CRACK = {"ts_type": "static", "mesh": runs.mesh("block.geo"), "mesh_set_lx": 2e-3, "mesh_set_ly": 5e-4, "mesh_set_n": 4,
         "mesh_set_ny": 1, "materials": "solid", "material_solid_E": 72e9, "material_solid_nu": 0.33,
         "material_solid_damage": "at2", "material_solid_split": "volumetric", "material_solid_Gc": 4950.6, "material_solid_gamma": 5e-4,
         "material_solid_c": 1e-3, "bcs": "x,y,pull", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
         "bc_pull_on": "right", "bc_pull_ux": f"{0.012 * 2e-3}*t/{TIME}", "ts_max_time": TIME, "coupling_snes_max_it": 1,
         "coupling_error": 1, "motion_snes_rtol": 1e-12}
single = {n: runs.run(f"single_{n}", {**CRACK, "ts_dt": TIME / n}) for n in (20, 40, 80, 640)}
for a, b in ((20, 40), (40, 80)):
    estimate = [single[n]["coupling_error"][-1] for n in (a, b)]
    error = [abs(single[n]["phi_max"][-1] - single[640]["phi_max"][-1]) for n in (a, b)]
    runs.check(f"single passes, {a} and {b} steps: order of the coupling error", math.log2(estimate[0] / estimate[1]), 1,
               0.15, relative=False)
    runs.check(f"single passes, {a} and {b} steps: order of phi", math.log2(error[0] / error[1]), 1, 0.2, relative=False)
runs.finish()
