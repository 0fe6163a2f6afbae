# labels: run
# timeout: 120
# long: 200
"""When a nonlinear solve counts as converged, and its first iteration. A solve that failed is refused whatever its last
step was; forces left on a soft body are not excused by a stiff one beside it; what cannot be solved at any length of the
step ends the run and is named; prescribed displacements take the whole body along at once."""
import re

import numpy

from _reliability import FAULTY, history, run_within, start
from _runs import check, check_between, finish, long, mesh, require, run, some

BLOCK = {"mesh": mesh("block.geo"), "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3,
         "material_solid_rho": 1000, "bcs": "hold,push", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top",
         "bc_push_ux": "0.3*t^2", "bc_push_uy": "-0.3*t^2", "ts_dt": 0.05, "ts_max_time": 0.5}
TWO = {"mesh": mesh("two_blocks.geo"), "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3,
       "material_lower_rho": 1000, "material_upper_like": "lower", "bcs": "hold", "bc_hold_on": "lower_bottom",
       "bc_hold_type": "fix"}


def cuts(r):
    return [line for line in r.log.splitlines() if line.endswith("time step cut")]


def refused(name, options, code, *said):
    r = run(name, options, code=code)
    last = [line for line in r.log.splitlines() if line.startswith("impact: ")]
    require(f"{name}: status {code}, {[line for line in last if said[0] in line][-1:]}",
            any(all(word in line for word in said) for line in last))
    return r


print("a failed solve is refused")
# From the k-th evaluation of the residual on there is none in the first try of step 6: before, in and after the first
# iteration, in the line search of the next one. The step norms of step 5 are still about.
whole = run("whole", BLOCK)
for k in some(range(1, 6), 3):
    run_within(60, f"domain_{k}", BLOCK, 1, FAULTY, f"domain:6:{k}")
    once = history(f"domain_{k}")
    require(f"no residual from evaluation {k} on in step 6: one try more, in that step alone",
            once["tries"][6] == 2 and once["tries"].sum() == len(once["tries"]) + 1)
    check(f"evaluation {k}: elastic energy at the end", once["energy_elastic"][-1], whole["energy_elastic"][-1], 2e-2)
    check_between(f"evaluation {k}: balance", abs(once["balance"]).max(), 0, 1e-9)

fast = run("fast", {**TWO, "mesh_set_n_lower": 3, "mesh_set_n_upper": 2, "mesh_set_inset": 0.1, "mesh_set_gap": 0.3,
                    "plane": "stress", "ics": "fall", "ic_fall_on": "upper", "ic_fall_vy": -20, "contacts": "face",
                    "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
                    "material_lower_model": "j2", "material_lower_sigma_y": 3e4, "material_lower_hardening": "linear",
                    "material_lower_linear_h": 1e5, "ts_dt": 0.02, "ts_max_time": 0.2}, refused=10)
energy = sum(value for key, value in fast.history.items()
             if re.fullmatch("energy_(kinetic|elastic|plastic|fracture|contact)|dissipated_(plastic|viscous|friction)", key))
check_between("a block at half the wave speed on a block: largest energy over that of the start",
              energy.max() / energy[0], 0.99, 1.0001)

STATIC = {**BLOCK, "ts_type": "static", "ts_max_reject": 3, "motion_ksp_type": "gmres"}
refused("no_step_ksp_atol", {**STATIC, "motion_ksp_atol": 1e30}, 5, "could not be solved", "DIVERGED")
for name, options in some({"motion_vi": {"motion_snes_type": "vinewtonrsls"}, "coupling": {"coupling_snes_type": "newtonls"},
                           "uzawa": {"uzawa_snes_type": "newtonls"}, "motion_stol": {"motion_snes_stol": 1e-9},
                           "motion_rtol": {"motion_ksp_rtol": 2}}.items(), 2):
    refused("refused_" + name, {**BLOCK, **options}, 2, "-" + next(iter(options)))
PRESS = {**TWO, "ts_type": "static", "bcs": "hold,push", "bc_push_on": "upper_top", "bc_push_ux": 0, "bc_push_uy": "-0.1*t",
         "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
         "mesh_set_inset": 0.1, "ts_dt": 0.5, "ts_max_time": 1}
open_contact = refused("one_augmentation", {**PRESS, "contact_face_enforce": "auglag", "uzawa_snes_max_it": 1,
                                            "ts_max_reject": 2}, 5, "uzawa: DIVERGED_MAX_IT")
# Perfectly plastic, pulled by twice what it bears.
limit = refused("limit", {**BLOCK, "ts_type": "static", "material_solid_model": "j2", "material_solid_sigma_y": 1e3, "bc_push_type": "traction",
                          "bc_push_ux": 0, "bc_push_uy": "4e3*t"}, 5, "could not be solved", "the largest force left at (")
require("a load beyond its limit: what to do", "impact: no shorter step found an equilibrium; where a load reaches its limit" in limit.log)
check_between("a load beyond its limit: time reached", limit["time"][-1], 0.25, 0.35)
RUBS = {**BLOCK, "ts_type": "static", "material_solid_model": "j2", "material_solid_sigma_y": 1e3, "bc_push_type": "traction", "bc_push_ux": 0,
        "bc_push_uy": "(-4e3*t)", "bc_hold_type": "displacement", "bc_hold_ux": 0, "contacts": "floor", "contact_floor_secondary": "bottom",
        "contact_floor_primary": "plane", "contact_floor_friction": 0.3}
for method in some(("gpts", "mortar"), 2):
    rubs = refused(f"limit_{method}", {**RUBS, "contact_floor_method": method}, 5, "no shorter step found an equilibrium")
    require(f"a load beyond its limit beside friction by {method}: the other form is named",
            ("-contact_floor_method mortar" in rubs.log) == (method == "gpts"))

print("forces left on a soft body")
# Two bodies that know nothing of each other; the stiffer one may carry a load of its size.
SOFT = {**TWO, "ts_type": "static", "mesh_set_gap": 0.5, "bcs": "hold,lie,push,load", "bc_lie_on": "upper_bottom",
        "bc_lie_type": "fix", "bc_push_on": "upper_top", "bc_push_type": "traction", "bc_push_uy": "500*t",
        "bc_load_on": "lower_top", "bc_load_type": "traction", "bc_load_uy": 0, "ts_dt": 0.5, "ts_max_time": 1,
        "measures": "top", "measure_top_on": "upper_top", "measure_top_fields": "u"}
alone = run("equal", SOFT)
for name, stiff in {"stiff": {"material_lower_E": 1e15}, "loaded": {"material_lower_E": 1e15, "bc_load_uy": "1e12*t"}}.items():
    own = {key: value for key, value in SOFT.items() if key != "material_upper_like"}
    beside = run(name, {**own, "material_upper_E": 1e6, "material_upper_nu": 0.3, "material_upper_rho": 1000, **stiff})
    check(f"beside E = 1e15 ({name}): displacement of the soft body", beside["measure_top_uy"][-1], alone["measure_top_uy"][-1], 1e-8)
    check_between(f"beside E = 1e15 ({name}): iterations of a step", beside["newton"][1:].max(), 1, 6)

print("no solution at any length of the step")
jump = refused("jump", {**BLOCK, "ts_type": "static", "bc_push_ux": 0, "bc_push_uy": "-0.05*t-5*step(t,0.35)"}, 5,
               "could not be solved", "cell inverted")
check_between("a jump of the data: steps and tries", len(jump["step"]) + len(cuts(jump)), 10, 120)
check_between("a jump of the data: time reached", jump["time"][-1], 0.349, 0.35)
HEAT = {**BLOCK, "ts_type": "static", "bc_push_ux": 0, "bc_push_uy": 0, "material_solid_c_v": 1000,
        "material_solid_conductivity": 10, "bcs": "hold,push,hot", "bc_hot_on": "top", "bc_hot_type": "heat_flux",
        "bc_hot_value": -1e6, "ts_dt": 1, "ts_max_time": 10, "ts_max_steps": 400}
cold = refused("cold", HEAT, 5, "could not be solved", " K")
check_between("heat taken out of a cold body: steps and tries", len(cold["step"]) + len(cuts(cold)), 10, 120)
# What left is in the body's capacity but for a step's worth.
refused("convection_h", {**HEAT, "bc_hot_type": "convection", "bc_hot_value": 300, "bc_hot_h": "-5"}, 2, "-bc_hot_h")
refused("convection_around", {**HEAT, "bc_hot_type": "convection", "bc_hot_value": "-300", "bc_hot_h": 5}, 2, "-bc_hot_value")

print("the first iteration")
BEAM = {"mesh": mesh("block.geo"), "mesh_set_lx": 100, "mesh_set_ly": 10, "mesh_set_n": 40, "mesh_set_ny": 4,
        "units": "mm_t_s_MPa", "materials": "solid", "material_solid_E": 200e3, "material_solid_nu": 0.3, "bcs": "root,tip",
        "bc_root_on": "left", "bc_root_type": "fix", "bc_tip_on": "right", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
DYNAMIC = {"ts_type": "newmark", "material_solid_rho": 8e-9, "ts_dt": 1e-3, "ts_max_time": 1e-3}
for name, options in some({
        "0.5 mm": {"bc_tip_uy": "-0.5*t"}, "2 mm": {"bc_tip_uy": "-2*t"},
        "2 mm, shorter cells": {"bc_tip_uy": "-2*t", "mesh_set_n": 80, "mesh_set_ny": 8},
        "force": {"bc_tip_type": "force", "bc_tip_uy": "-100*t"},
        "2 mm, in space": {"bc_tip_uy": "-2*t", "mesh_set_dim": 3, "mesh_set_lz": 10, "mesh_set_nz": 2, "mesh_set_ny": 2,
                          "mesh_set_n": 20},
        "yielding": {"bc_tip_uy": "-2*t", "material_solid_model": "j2", "material_solid_sigma_y": 250,
                     "material_solid_hardening": "none"},
        "dynamic": {"bc_tip_uy": "-2e6*t^2", **DYNAMIC}}.items(), 2):
    r = run("beam_" + re.sub(r"\W+", "_", name), {**BEAM, **options})
    check_between(f"beam, {name}: tries", r["tries"].max(), 1, 1)
    check_between(f"beam, {name}: iterations of the first step", r["newton"][1], 2, {"yielding": 9, "2 mm, in space": 7}.get(name, 6))
one = run("beam_1", {**BEAM, "bc_tip_uy": "-2*t", "motion_snes_rtol": 1e-12})
for ranks in (2, 3) if long() else (2,):
    more = run(f"beam_{ranks}", {**BEAM, "bc_tip_uy": "-2*t", "motion_snes_rtol": 1e-12}, ranks=ranks)
    check(f"{ranks} ranks: elastic energy", more["energy_elastic"][-1], one["energy_elastic"][-1], 1e-10)
    check(f"{ranks} ranks: iterations", more["newton"][-1], one["newton"][-1], 1, relative=False)
# A tenth of two touching blocks at once, by every enforcement; with inertia a twentieth of that, since facets that turn within a
# step let contact work to third order: 2.6e-9 of the energy in twice the step.
WAYS = {}, {"contact_operator": "shell", "contact_face_gap_tol": 1e-5}, {"ts_type": "newmark", "ts_dt": 0.05}
for place, enforce in enumerate(("penalty", "auglag", "semismooth")):
    for extra in WAYS if long() else (WAYS[place],):
        r = run("press", {**PRESS, "ts_max_steps": 1, "contact_face_enforce": enforce, **extra}, ranks=1 + len(extra))
        name = " ".join([enforce] + [str(value) for value in extra.values()])
        check_between(f"pressed blocks, {name}: tries", r["tries"].max(), 1, 1)
        check_between(f"pressed blocks, {name}: longest solve", r["newton_most"].max(), 1, 12)
finish()
