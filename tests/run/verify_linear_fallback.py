# labels: run
# timeout: 120
"""An iterative linear solver that the program chose and that fails gives way to factors: the run goes on as by factors, and says so; a
restart, repeated steps and ranks do as well. What the options chose fails as asked."""
from _runs import check, finish, mesh, require, run

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
tried = run("tried", {**FAILS, "test_restep": 1}, refused=None)
two = run("two", FAILS, ranks=2)
for column in ("energy_elastic", "reaction_push_x"):
    require(f"restart: {column} bit for bit", (again[column][-2:] == falls[column][-2:]).all())
    require(f"steps tried twice: {column} bit for bit", (tried[column] == falls[column]).all())
    check(f"two ranks: {column}", two[column][-1], falls[column][-1], 1e-9)
asked = run("asked", {**FAILS, "motion_ksp_type": "cg", "motion_pc_type": "jacobi"}, code=5)
require("a solver that was asked for fails as it is", "DIVERGED_LINEAR_SOLVE" in asked.log and SAID not in asked.log)
finish()
