# labels: run
# timeout: 120
"""Another linear solver changes the iteration counts and nothing else: the two blocks in contact with each solver, and
with the fragments of options/solver."""
import shutil

import numpy
from _runs import TWO_BLOCKS, check, finish, option_file, require, run

BLOCKS = {
    **TWO_BLOCKS,
    "motion_snes_rtol": 1e-10, "motion_ksp_rtol": 1e-11,
}
COLUMNS = ("energy_kinetic", "energy_elastic", "momentum_upper_x", "momentum_upper_y", "reaction_hold_y",
           "contact_face_force_y", "contact_face_pressure_max")
VARIANTS = {
    "cg + jacobi": {"motion_ksp_type": "cg", "motion_pc_type": "jacobi"},
    "gmres + jacobi": {"motion_ksp_type": "gmres", "motion_pc_type": "jacobi"},
    "cg + hypre": {"motion_ksp_type": "cg", "motion_pc_type": "hypre"},
    "gmres + gamg": {"motion_ksp_type": "gmres", "motion_pc_type": "gamg"},
    "lu, superlu_dist": {"motion_ksp_type": "preonly", "motion_pc_type": "lu",
                         "motion_pc_factor_mat_solver_type": "superlu_dist"},
}


def compare(claim, a, b, tolerance=1e-8):
    if not require(f"{claim}: as many steps, no step cut", len(a["time"]) == len(b["time"]) and b["tries"].max() == 1):
        return
    differences = {c: abs(a[c] - b[c]).max() / abs(a[c]).max() for c in COLUMNS}
    where = max(differences, key=differences.get)
    check(f"{claim} ({b['linear'].sum():.0f} linear iterations): largest difference, in {where}", differences[where], 0,
          tolerance, relative=False)
    require(f"{claim}: the same points are active", (a["contact_face_active"] == b["contact_face_active"]).all())


reference = run("mumps", {**BLOCKS, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
                          "motion_pc_factor_mat_solver_type": "mumps"})
require("the blocks touch", reference["contact_face_active"].max() > 0)
for name, options in VARIANTS.items():
    compare(name, reference, run(name.replace(" ", "_").replace(",", ""), {**BLOCKS, **options}))
for fragment in ("direct", "jacobi", "hypre", "gamg"):
    compare(f"solver/{fragment}.opts", reference,
            run(fragment, BLOCKS, files=[option_file(f"solver/{fragment}.opts")]))

# A hierarchy that serves on is a memory, which a checkpoint ends.
MULTIGRID = {**BLOCKS, **VARIANTS["gmres + gamg"], "checkpoint_every": 15}
whole = run("whole", MULTIGRID)
shutil.copytree("whole", "resumed")
resumed = run("resumed", {**MULTIGRID, "restart": "resumed/checkpoints/checkpoint_000001.h5"})
for column in COLUMNS:
    check(f"gamg, resumed: {column}", abs(resumed[column] - whole[column]).max(), 0, 0, relative=False)
finish()
