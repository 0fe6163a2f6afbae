# labels: run
# timeout: 240
# long: 300
"""The same histories on 1 to 3 ranks (long: 4, more cases) and with METIS and PTScotch: two blocks in contact by penalty and with
multipliers, and the notched beam with plasticity and fracture."""
from _histories import difference
from _runs import TWO_BLOCKS, check, finish, long, option_file, require, run

LU = {"motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
      "motion_pc_factor_mat_solver_type": "mumps"}

BLOCKS = {**TWO_BLOCKS, **LU}
# As many cells above as below: the simple partitioner parts the bodies, each surface lies on a rank of its own.
GAP_TOL = 1e-4
AUGMENTED = {**BLOCKS, "contact_face_enforce": "auglag", "contact_face_gap_tol": GAP_TOL, "mesh_set_n_upper": 6}
BEAM = {
    "output_vis_every": 100000, "ts_dt": 0.01, "ts_max_time": 0.14, "output_vis_times": 0.14,
    "mesh_set_h_factor": 2, "damage_snes_rtol": 1e-12, "damage_ksp_type": "preonly", "damage_pc_type": "cholesky",
    "damage_pc_factor_mat_solver_type": "mumps", **LU,
}


for name, options, files, variants in (
        ("blocks", BLOCKS, [], ((2, "simple"), (2, "ptscotch"), (3, "metis"), (2, "metis"), (4, "metis"))),
        ("augmented", AUGMENTED, [], ((2, "simple"), (3, "metis"), (4, "metis"), (3, "ptscotch"))),
        ("beam", BEAM, [option_file("beam_push.opts")], ((2, "metis"), (3, "metis")))):
    if not long():
        variants = {"blocks": variants[1:3], "augmented": variants[:1], "beam": variants[:1]}[name]
    one = run(f"{name}_1", options, files=files, refused=1)
    last = {c: one[c][-1] for c in ("phi_max", "alpha_max", "contact_face_active", "uzawa") if c in one.history}
    print(f"     {name}: {len(one['time']) - 1} steps, at the end {last}, tries at most {one['tries'].max():.0f}")
    for ranks, partitioner in variants:
        other = run(f"{name}_{ranks}_{partitioner}", {**options, "petscpartitioner_type": partitioner}, files=files,
                    ranks=ranks, refused=1)
        worst, where = difference(one.history, other.history)
        check(f"{name}, {ranks} ranks, {partitioner}: largest difference, in {where}", worst, 0, 1e-8, relative=False)
# The few triangles of the beam share their volume; of the partitioners METIS alone is told not to part them.
refused = run("beam_parted", {**BEAM, "petscpartitioner_type": "ptscotch"}, files=[option_file("beam_push.opts")], ranks=2, code=2)
require("a partitioner that may part patches is refused", "may part linear triangles or tetrahedra" in refused.log)
finish()
