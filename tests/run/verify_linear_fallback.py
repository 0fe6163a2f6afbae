# labels: run
# timeout: 120
# long: 200
"""An iterative linear solver that the program chose and that fails gives way to factors: the run goes on as by factors, and says so; a
restart, repeated steps and ranks do as well. What the options chose fails as asked."""
from _runs import check, finish, long, mesh, require, run

BLOCK = {"mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 12, "materials": "solid", "material_solid_E": 1e9, "material_solid_nu": 0.3, "bcs": "hold,push",
         "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top", "bc_push_ux": "0.05*t", "bc_push_uy": 0, "bc_push_uz": 0, "ts_type": "static", "ts_dt": 0.25,
         "ts_max_time": 0.75, "checkpoint_every": 1, "checkpoint_keep": 5}
FAILS = {**BLOCK, "motion_ksp_max_it": 3}
SAID = "cg + two_level does not solve the motion: factors take its place"
factors = run("factors", {**BLOCK, "motion_pc_type": "lu"})
falls = run("falls", FAILS)
require("it is said, once", falls.log.count(SAID) == 1 and "cg + two_level" in falls.log)
require("and not where it works", SAID not in run("works", BLOCK).log)
for column in ("energy_elastic", "reaction_push_x"):
    check(f"{column}, as by factors from the start", falls[column][-1], factors[column][-1], 1e-9)
again = run("falls", {**FAILS, "restart": "falls/checkpoints/checkpoint_000001.h5"})
require("a restart goes on by factors without a word", SAID not in again.log)
tried = run("tried", {**FAILS, "test_restep": 1}, refused=None) if long() else None
two = run("two", FAILS, ranks=2)
for column in ("energy_elastic", "reaction_push_x"):
    require(f"restart: {column} bit for bit", (again[column][-2:] == falls[column][-2:]).all())
    if tried:
        require(f"steps tried twice: {column} bit for bit", (tried[column] == falls[column]).all())
    check(f"two ranks: {column}", two[column][-1], falls[column][-1], 1e-9)
asked = run("asked", {**FAILS, "motion_ksp_type": "cg", "motion_pc_type": "jacobi"}, code=5)
require("a solver that was asked for fails as it is", "DIVERGED_LINEAR_SOLVE" in asked.log and SAID not in asked.log)

# A cantilever 100 times as long as thick: iterations by the thousand, factors with few entries. Its tip under a small shear force T:
# T L^3 / (3 E I) + T L / (5/6 G A), from its 27-node hexahedra to a thousandth.
LONG, THICK, T, E = 1.0, 0.01, 1e-3, 1e9
SLENDER = {**BLOCK, "order": 2, "mesh_set_lx": LONG, "mesh_set_ly": THICK, "mesh_set_lz": THICK, "mesh_set_n": 60, "mesh_set_ny": 3, "mesh_set_nz": 3, "material_solid_nu": 0,
           "bcs": "hold,push", "bc_hold_on": "left", "bc_push_on": "right", "bc_push_type": "force", "bc_push_uy": f"{T}*t", "ts_dt": 0.5, "ts_max_time": 1}
del SLENDER["bc_push_ux"], SLENDER["bc_push_uz"]
TOO_LONG = "factors take its place"
slender = run("slender", SLENDER)
require("what takes longer than factors gives way to them, once", slender.log.count(TOO_LONG) == 1 and "iterations for a linear solve" in slender.log)
require(f"which it is not asked to end first: {slender['linear'].max():.0f} iterations", slender["linear"].max() <= 250)
tip = T * LONG**3 / (3 * E * THICK**4 / 12) + T * LONG / (5 / 6 * E / 2 * THICK**2)
check("tip of the cantilever: twice the work over the force", 2 * slender["energy_elastic"][-1] / T, tip, 2e-3)
require("its second step takes no more iterations than Newton's method", slender["linear"][-1] <= slender["newton"][-1])
again = run("slender", {**SLENDER, "restart": "slender/checkpoints/checkpoint_000001.h5"})
tried = [("steps tried twice", run("slender_tried", {**SLENDER, "test_restep": 1}, refused=None))] if long() else []
for name, r in [("restart", again), *tried]:
    require(f"{name}: the energy bit for bit", r["energy_elastic"][-1] == slender["energy_elastic"][-1])
if long():
    require("a solver that was asked for goes on", TOO_LONG not in run("asked_cg", {**SLENDER, "motion_ksp_type": "cg", "motion_pc_type": "two_level"}).log)
finish()
