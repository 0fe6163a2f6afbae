# labels: run
# timeout: 120
"""Another linear solver changes the iteration counts and nothing else: the two blocks in contact with each solver, and
with the fragments of options/solver."""
import shutil

from _histories import difference
from _runs import TWO_BLOCKS, check, finish, option_file, require, run

BLOCKS = {
    **TWO_BLOCKS,
    "motion_snes_rtol": 1e-10, "motion_ksp_rtol": 1e-11,
}
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
    worst, where = difference(a.history, b.history)
    check(f"{claim} ({b['linear'].sum():.0f} linear iterations): largest difference, in {where}", worst, 0, tolerance,
          relative=False)


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
worst, where = difference(whole.history, resumed.history, exact=True)
check(f"gamg, resumed: largest difference, in {where}", worst, 0, 0, relative=False)
finish()
