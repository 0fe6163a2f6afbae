# labels: run
# processors: 2
# timeout: 240
"""The same histories on 1 to 4 ranks and with METIS and PTScotch: two blocks in contact by penalty and with
multipliers, and the notched beam with plasticity and fracture. Differences count relative to the largest value of a
column."""
import numpy
from _runs import TWO_BLOCKS, check, finish, option_file, require, run

LU = {"motion_snes_rtol": 1e-12, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
      "motion_pc_factor_mat_solver_type": "mumps"}
COUNTS = ("newton", "newton_most", "linear", "uzawa", "damage_its", "balance", "balance_first_law")

BLOCKS = {**TWO_BLOCKS, **LU}
# As many cells above as below: the simple partitioner parts the bodies, each surface lies on a rank of its own.
GAP_TOL = 1e-4
AUGMENTED = {**BLOCKS, "contact_face_enforce": "auglag", "contact_face_gap_tol": GAP_TOL, "mesh_set_n_upper": 6}
BEAM = {
    "output_vis_every": 100000, "ts_dt": 0.01, "ts_max_time": 0.14, "output_vis_times": 0.14,
    "mesh_set_h_factor": 2, "damage_snes_rtol": 1e-12, "damage_ksp_type": "preonly", "damage_pc_type": "cholesky",
    "damage_pc_factor_mat_solver_type": "mumps", **LU,
}


def compare(claim, a, b, tolerance):
    if not require(f"{claim}: the same columns and steps",
                   list(a.history) == list(b.history) and len(a["time"]) == len(b["time"])):
        return
    worst, where = 0.0, "time"
    energy = max(abs(a[c]).max() for c in a.history if c.startswith(("energy", "work")))
    for column, values in a.history.items():
        other = b[column]
        if column in COUNTS or column.startswith("crack"):
            continue
        if (numpy.isnan(values) != numpy.isnan(other)).any():
            worst, where = numpy.inf, column
            continue
        scale = numpy.nanmax(abs(values), initial=0)
        # A component that is zero but for the solver's tolerance is measured by its vector.
        if column[-2:] in ("_x", "_y") and not column.startswith("crack"):
            scale = max(numpy.nanmax(abs(a[column[:-1] + k]), initial=0) for k in "xy")
        # With multipliers it is force times gap, and the gap of closed points falls to the rounding of their places:
        # measured by what the tolerance of the gap lets pass.
        if column == "energy_contact" and a["uzawa"].max() > 1:
            scale = max(scale, GAP_TOL * abs(a["contact_face_force_y"]).max())
        # Columns that are rounding noise say nothing.
        if column.startswith(("energy", "work", "dissipated")) and scale < 1e-10 * energy:
            continue
        difference = numpy.nanmax(abs(values - other), initial=0) / scale if scale > 0 else 0
        if difference > worst:
            worst, where = difference, column
    check(f"{claim}: largest difference, in {where}", worst, 0, tolerance, relative=False)


for name, options, files, variants in (
        ("blocks", BLOCKS, [], ((2, "metis"), (3, "metis"), (4, "metis"), (2, "simple"), (2, "ptscotch"))),
        ("augmented", AUGMENTED, [], ((2, "simple"), (3, "metis"), (4, "metis"), (3, "ptscotch"))),
        ("beam", BEAM, [option_file("beam_push.opts")], ((2, "metis"), (3, "ptscotch")))):
    one = run(f"{name}_1", options, files=files)
    last = {c: one[c][-1] for c in ("phi_max", "alpha_max", "contact_face_active", "uzawa") if c in one.history}
    print(f"     {name}: {len(one['time']) - 1} steps, at the end {last}, tries at most {one['tries'].max():.0f}")
    for ranks, partitioner in variants:
        other = run(f"{name}_{ranks}_{partitioner}", {**options, "petscpartitioner_type": partitioner}, files=files,
                    ranks=ranks)
        compare(f"{name}, {ranks} ranks, {partitioner}", one, other, 1e-8)
finish()
