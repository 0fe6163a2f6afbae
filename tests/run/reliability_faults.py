# labels: run
# timeout: 180
"""R10, R11: a number that is none at one quadrature point of one rank, an inverted cell, and solvers that fail. All ranks
see it in the same evaluation, it is located, the step is cut and grows again; after -ts_max_reject tries the run ends
with status 5 and a checkpoint from which it can go on."""
import os
import re

from _reliability import BOTH, FAULTY, history, log_of, run_within, start, with_mesh
from _runs import check, check_between, finish, mesh, require, run

# Both bodies are plastic here, so that every point of every rank has a history.
OPTIONS = {**with_mesh(BOTH), "checkpoint_every": 0, "output_vis_every": 1000, "material_upper_model": "j2",
           "material_upper_damage": "at2"}
require("undisturbed run on 2 ranks", run_within(60, "whole", OPTIONS, 2) == 0)
whole = history("whole")


def cut_lines(log):
    return [line for line in log.splitlines() if line.endswith("time step cut")]


# R10: rank 1 of 2, step 12, once.
code = run_within(60, "nan_once", OPTIONS, 2, FAULTY, "nan:12:1:1")
log = log_of("nan_once")
require(f"NaN on rank 1 in step 12, once: status 0 (is {code})", code == 0)
place = re.search(r"impact: (.*) at x=\((\S+),(\S+)\) in material (\w+), step (\d+) try (\d+)", log)
require("NaN once: one line says where, in which material, step and try", place is not None
        and (place.group(4), place.group(5), place.group(6)) in
        (("lower", "12", "1"), ("upper", "12", "1")))
once = history("nan_once")
require("NaN once: one try more in that step alone",
        once["tries"][12] == 2 and once["tries"].sum() == len(once["tries"]) + 1)
check("NaN once: the step is halved", once["dt"][12], whole["dt"][12] / 2, 1e-12)
check("NaN once: dt grows back", once["dt"].max() if once["dt"][-2] > 0.9 * 2e-3 else 0, 2e-3, 1e-12)
check("NaN once: kinetic energy at the end (smaller steps in between)", once["energy_kinetic"][-1],
      whole["energy_kinetic"][-1], 0.1)

# Without end.
code = run_within(60, "nan_always", {**OPTIONS, "ts_max_reject": 4}, 2, FAULTY, "nan:12:1:99")
log = log_of("nan_always")
require(f"NaN in every try: status 5 (is {code})", code == 5)
check("NaN in every try: tries", len(cut_lines(log)), 5, 0)
require("NaN in every try: a checkpoint of the state before",
        re.search(r"the state at t = 0.022, step 11, is in nan_always/checkpoints/checkpoint_000001.h5", log) is not None)
code = run_within(60, "nan_always", {**OPTIONS, "restart": "auto"}, 2)
require(f"NaN in every try: without it the run goes on to its end (status {code})",
        code == 0 and "step 11" in log_of("nan_always") and history("nan_always")["time"][-1] == whole["time"][-1])

# An expression that has no value from some time on: nothing to cut, the user's data is wrong.
code = run_within(60, "expression", {**OPTIONS, "bc_hold_type": "displacement", "bc_hold_ux": 0,
                                          "bc_hold_uy": "0*sqrt(0.0211-t)"}, 2)
said = [line for line in log_of("expression").splitlines() if line.startswith("impact: ")]
said = [line for line in said if "-bc_hold_uy" in line]
require(f"an expression without a value: status 3 (is {code}) and its name: {said}", code == 3 and len(said) == 1)
require("an expression without a value: the state before is kept", os.path.exists(
    "expression/checkpoints/checkpoint_000001.manifest"))

# R11. A block is compressed, on one side to a fifth of its height: one step inverts cells, small ones do not.
BLOCK = {"ts_type": "static", "mesh": mesh("block.geo"), "mesh_set_n": 4, "materials": "solid", "material_solid_E": 1e3,
         "material_solid_nu": 0.3, "bcs": "x,y,push", "bc_x_on": "left", "bc_x_ux": 0, "bc_y_on": "bottom", "bc_y_uy": 0,
         "bc_push_on": "top", "bc_push_uy": "-0.9*t", "motion_snes_rtol": 1e-12, "ts_max_time": 0.6}
small = run("small_steps", {**BLOCK, "ts_dt": 0.01})
large = run("inverted", {**BLOCK, "bc_push_uy": "-1.3*t*(0.3+1.4*x)", "ts_max_time": 0.36, "ts_dt": 0.36, "motion_snes_linesearch_type":
                         "basic"}, refused=20)
same = run("inverted_small", {**BLOCK, "bc_push_uy": "-1.3*t*(0.3+1.4*x)", "ts_max_time": 0.36, "ts_dt": 0.01})
print("     " + (cut_lines(large.log) or ["nothing was cut"])[0])
check_between("inverted cell: cut steps", len(cut_lines(large.log)), 1, 20)
check("inverted cell, cut: elastic energy at the end", large["energy_elastic"][-1], same["energy_elastic"][-1], 1e-8)
check("inverted cell: tries in the history", large["tries"][1:].sum() - len(large["tries"][1:]), len(cut_lines(large.log)), 0)

newton = run("newton", {**BLOCK, "ts_dt": 0.3, "motion_snes_max_it": 3}, refused=10)
require("Newton fails: " + (cut_lines(newton.log) or [""])[0], "motion: DIVERGED_MAX_IT" in newton.log)
check("Newton fails, cut: elastic energy at the end", newton["energy_elastic"][-1], small["energy_elastic"][-1], 1e-8)

linear = run("linear", {**BLOCK, "ts_dt": 0.05, "motion_ksp_type": "gmres", "motion_pc_type": "none", "motion_ksp_max_it": 2,
                        "motion_ksp_rtol": 1e-10, "ts_max_reject": 3}, code=5)
require("the linear solver fails: status 5, " + (cut_lines(linear.log) or [""])[0], "DIVERGED_LINEAR_SOLVE" in linear.log)
require("the linear solver fails: a checkpoint of the start", "the state at t = 0, step 0, is in" in linear.log)
short = run("linear_short", {**BLOCK, "ts_dt": 0.05, "motion_ksp_type": "gmres", "motion_pc_type": "none", "motion_ksp_max_it": 2,
                             "motion_ksp_rtol": 1e-10}, code=5)
require("the last word is of linear solves, not of loads", "no linear solve found a solution" in short.log and "load reaches" not in short.log)
rescued = run("linear", {**BLOCK, "ts_dt": 0.05, "restart": "auto"})
check("other solver on restart: elastic energy at the end", rescued["energy_elastic"][-1], small["energy_elastic"][-1], 1e-8)

# Tried again by a preconditioner that PETSc cannot use again after a reset.
split = run("split", {**BLOCK, "ts_dt": 0.05, "motion_ksp_type": "minres", "motion_pc_type": "fieldsplit", "ts_max_reject": 3}, code=5)
require("a field split that fails: status 5", "DIVERGED_LINEAR_SOLVE" in split.log and len(cut_lines(split.log)) > 1)

uzawa = run("uzawa", {**with_mesh(BOTH), "checkpoint_every": 0, "uzawa_snes_max_it": 6, "contact_face_method": "gpts", "contact_face_enforce": "auglag",
                      "contact_face_pressure_tol": 1e-2, "output_vis_every": 1000, "ts_max_steps": 60}, code=None, refused=None)
require(f"augmentation fails: {(cut_lines(uzawa.log) or [''])[0]}", "uzawa: DIVERGED_MAX_IT" in uzawa.log)
require(f"augmentation fails: the step is cut and the run ends (status {uzawa.code})",
        uzawa.code == 0 and uzawa["tries"].max() > 1)
finish()
