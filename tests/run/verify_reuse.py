# labels: run
# processors: 1
# timeout: 240
# long: 400
"""Newton's method that does not solve more exactly than it needs to, and preconditioners that serve on: plastic flow and damage
under multigrid against MUMPS; iterations and factorisations of the beam on the wedge, step by step."""
import re

from _runs import check, check_between, finish, long, mesh, option_file, require, run
from _histories import difference

FLOW = {
    "units": "mm_t_s_MPa", "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 10, "materials": "solid", "material_solid_model": "j2",
    "material_solid_E": 210e3, "material_solid_nu": 0.3, "material_solid_sigma_y": 300, "material_solid_linear_h": 1000, "material_solid_damage": "at2",
    "material_solid_Gc": 2.7, "material_solid_gamma": 0.3, "bcs": "top,bottom", "bc_top_on": "top", "bc_top_ux": 0, "bc_top_uy": "1e-2*t",
    "bc_top_uz": 0, "bc_bottom_on": "bottom", "bc_bottom_type": "fix", "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 0.3,
}


def events(log, name):
    """Calls of one of PETSc's events, all stages together."""
    return sum(int(n) for n in re.findall(rf"^{re.escape(name)} +(\d+) ", log, re.M))


exact = run("lu", {**FLOW, "motion_ksp_type": "preonly", "motion_pc_type": "lu"})
flows = run("gamg", {**FLOW, "motion_ksp_type": "gmres", "motion_pc_type": "gamg", "log_view": ""})
require("plastic flow under multigrid: it flows, no step is cut", flows["alpha_max"][-1] > 1e-3 and flows["tries"].max() == 1)
worst, where = difference(exact.history, flows.history)
check(f"it is what MUMPS gives: largest difference, in {where}", worst, 0, 1e-6, relative=False)
newton, linear, made = flows["newton"].sum(), flows["linear"].sum(), events(flows.log, "PCSetUp_GAMG+")
check_between(f"linear iterations in {newton:.0f} of Newton's", linear / newton, 1, 25)
check_between("hierarchies", made, 1, newton / 4)
each = run("each", {**FLOW, "motion_ksp_type": "gmres", "motion_pc_type": "gamg", "motion_reuse_preconditioner": 0, "log_view": ""})
check("-motion_reuse_preconditioner 0: a hierarchy for each linear solve", events(each.log, "PCSetUp_GAMG+"), each["newton"].sum(), 0)
worst, where = difference(exact.history, each.history)
check(f"with the same result: largest difference, in {where}", worst, 0, 1e-6, relative=False)

# What a run in space takes by itself: as many linear iterations for a body of eight times as many unknowns.
count = {}
for n in (12, 24):
    body = run(f"levels_{n}", {**FLOW, "mesh_set_n": n, "material_solid_model": "elastic", "ts_max_steps": 1})
    require(f"{n}^3 cells: conjugate gradients and two levels", "motion solver: cg + two_level" in body.log)
    count[n] = body["linear"].sum() / body["newton"].sum()
check_between("linear iterations of one of Newton's, eight times as many cells over fewer", count[24] / count[12], 0.5, 1.4)
if long():
    alone = run("alone", {**FLOW, "mesh_set_n": 24, "material_solid_model": "elastic", "ts_max_steps": 1, "motion_ksp_type": "cg",
                          "motion_pc_type": "jacobi", "motion_ksp_rtol": 1e-3})
    check_between("over those of Jacobi alone", count[24] / (alone["linear"].sum() / alone["newton"].sum()), 0, 0.75)
if long():
    levels = run("levels", {**FLOW, "mesh_set_n": 12})
    exact = run("exact", {**FLOW, "mesh_set_n": 12, "motion_ksp_type": "preonly", "motion_pc_type": "lu"})
    require("plastic flow by two levels: no step is cut", levels["tries"].max() == 1 and "cg + two_level" in levels.log)
    worst, where = difference(exact.history, levels.history)
    check(f"it is what MUMPS gives: largest difference, in {where}", worst, 0, 1e-6, relative=False)

# A column pressed far beyond what it buckles at: its tangent is indefinite, which conjugate gradients alone did not survive.
COLUMN = {"mesh": mesh("block.geo"), "mesh_set_n": 2, "mesh_set_ny": 20, "mesh_set_ly": 10, "materials": "solid", "material_solid_E": 1,
          "material_solid_nu": 0.3, "bcs": "hold,push", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top",
          "bc_push_uy": "(-t)", "bc_push_ux": "0.01*t", "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
JACOBI = {"motion_ksp_type": "cg", "motion_pc_type": "jacobi", "motion_ksp_converged_reason": ""}
for leaves, factors in ("off", "lu"), ("auto", "cholesky"):
    cg, exact = (run(f"column_{name}_{leaves}", {**COLUMN, **solver, "motion_leave_unstable": leaves}) for name, solver in (
        ("cg", JACOBI), ("exact", {"motion_ksp_type": "preonly", "motion_pc_type": factors})))
    require(f"a buckled column: its tangent is indefinite, no step is cut, it is left: {leaves}",
            "INDEFINITE" in cg.log and cg["tries"].max() == 1 and ("left an equilibrium that is unstable" in cg.log) == (leaves == "auto"))
    worst, where = difference(exact.history, cg.history)
    check(f"it is what MUMPS gives: largest difference, in {where}", worst, 0, 1e-6, relative=False)

# A block is pressed on another one and shoved along it: more than a hundred linear iterations where it slips.
SHOVED = {"mesh": mesh("two_blocks.geo"), "mesh_set_dim": 3, "mesh_set_n_lower": 12, "mesh_set_n_upper": 9, "mesh_set_inset": 0.1,
          "materials": "lower,upper", "material_lower_E": 1e9, "material_lower_nu": 0.3, "material_upper_like": "lower", "bcs": "hold,push",
          "bc_hold_on": "lower_bottom", "bc_hold_type": "fix", "bc_push_on": "upper_top", "bc_push_ux": "0.005*t", "bc_push_uy": "(-0.01*t)",
          "bc_push_uz": 0, "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
          "contact_face_method": "gpts", "contact_face_friction": 0.3, "ts_type": "static", "ts_dt": 1, "ts_max_time": 1}
if long():
    amg = run("shoved_gamg", {**SHOVED, "motion_ksp_type": "gmres", "motion_pc_type": "gamg"})
    require("a block shoved along another one, under multigrid: no step is cut", amg["tries"].max() == 1)
    check_between("linear iterations of one of Newton's", amg["linear"].sum() / amg["newton"].sum(), 30, 200)
    lu = run("shoved_lu", {**SHOVED, "motion_ksp_type": "preonly", "motion_pc_type": "lu"})
    for column, tolerance in (("reaction_push_x", 1e-4), ("reaction_push_y", 1e-4), ("dissipated_friction", 2e-3)):  # that of augmentations
        check(f"{column}: that of MUMPS", amg[column][-1], lu[column][-1], tolerance)

# The wedge presses, the beam is elastic: at most six iterations in a step once it has been met.
beam = run("beam", {"ts_max_steps": 22, "outputs": "hist", "output_hist_type": "csv"}, files=[option_file("beam_wedge.opts")])
check_between("beam_wedge, elastic: most iterations of Newton's method in a step", beam["newton"][2:].max(), 1, 6)
check_between("on the average", beam["newton"][2:].mean(), 1, 4.5)
# The same with some 6e4 unknowns, whose factors of one half serve on over the steps.
if long():
    FINE = {"dm_refine": 2, "outputs": "hist", "output_hist_type": "csv", "log_view": ""}
    STEPS = 12
    fine = run("fine", {**FINE, "ts_max_steps": STEPS}, files=[option_file("beam_wedge.opts")])
    require("refined twice: Cholesky factors, no step is cut", "fgmres + cholesky by mumps" in fine.log and fine["tries"].max() == 1)
    check_between("refined twice: most iterations in a step after the first", fine["newton"][2:].max(), 1, 6)
    made = events(fine.log, "MatCholFctrNum")
    check_between("refined twice: factorisations, fewer than iterations by one in each step after the first touch", made, 1, fine["newton"].sum() - (STEPS - 1))
    touch = run("touch", {**FINE, "ts_max_steps": 1}, files=[option_file("beam_wedge.opts")])
    made -= events(touch.log, "MatCholFctrNum")
    check_between("refined twice: factorisations in the 11 steps after the first touch", made, 0, 10)
    applied = events(fine.log, "MatSolve") - events(touch.log, "MatSolve")
    check_between("their applications in a step: one for each linear iteration, none beside", applied / fine["linear"][2:].sum(), 1, 1.05)
# However fine the mesh, the first touch takes one try and hardly more iterations.
touches = [("no", beam)]
if long():
    touches += [("two", fine)]
    touches.append(("three", run("finer", {"dm_refine": 3, "outputs": "hist", "output_hist_type": "csv", "ts_max_steps": 1},
                                 files=[option_file("beam_wedge.opts")])))
for refined, first in touches:
    check_between(f"iterations of the first touch after {refined} refinements", first["newton"][1], 1, 24)
require("none of them is cut", max(first["tries"].max() for _, first in touches) == 1)
finish()
