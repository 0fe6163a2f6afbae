# labels: run
# timeout: 180
"""Contact beside the matrix (-contact_operator shell) gives the histories of contact in the matrix, to the tolerance
of the solvers: two blocks that meet in flight, with penalty and with augmentations, and two that are pressed together
without inertia, on 1 and 2 ranks. A preconditioner that cannot see the contact is refused where it is the solver."""
from _histories import difference
from _runs import TWO_BLOCKS, check, check_between, finish, mesh, require, run

# All but the last solve of augmentations are rough: two ways to solve share the multipliers to _pressure_tol only.
TIGHT = {"motion_snes_rtol": 1e-12, "motion_ksp_rtol": 1e-12}
# CG, the default for such small steps, meets an indefinite matrix under the grown penalty of the augmented case.
FACTOR = {"motion_pc_type": "lu", "motion_pc_factor_mat_solver_type": "mumps"}
FLIGHT = {**TWO_BLOCKS, **TIGHT, **FACTOR, "ts_max_time": 0.03}
AUGMENTED = {**FLIGHT, "contact_face_enforce": "auglag", "contact_face_gap_tol": 1e-6,
             "contact_face_pressure_tol": 1e-9, "uzawa_snes_max_it": 200}
PRESSED = {
    **TIGHT, "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 6, "mesh_set_n_upper": 5,
    "materials": "lower,upper", "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_upper_like": "lower",
    "bcs": "plate,press", "bc_plate_on": "lower_bottom", "bc_plate_type": "fix", "bc_press_on": "upper_top",
    "bc_press_ux": "0.01*t", "bc_press_uy": "-0.02*t", "contacts": "face", "contact_face_secondary": "upper_bottom",
    "contact_face_primary": "lower_top", "contact_face_method": "gpts", "contact_face_pressure_tol": 1e-9, "uzawa_snes_max_it": 200,
    "ts_type": "static", "ts_dt": 0.5, "ts_max_time": 1,
}

for name, options in (("penalty", FLIGHT), ("augmented", AUGMENTED), ("pressed", PRESSED)):
    assembled = run(f"{name}_assembled", {**options, "motion_ksp_type": "preonly"})
    touched = assembled["contact_face_active"].max()
    check_between(f"{name}: points in contact", touched, 4, 1000)
    for ranks in (1,) if name == "penalty" else (1, 2):
        shell = run(f"{name}_shell_{ranks}", {**options, "contact_operator": "shell", "motion_ksp_type": "gmres"},
                    ranks=ranks)
        worst, where = difference(assembled.history, shell.history)
        check(f"{name}, {ranks} ranks: largest difference, in {where}", worst, 0, 1e-8, relative=False)
        # What shows that the contact is not in the matrix that is factored.
        check_between(f"{name}, {ranks} ranks: linear iterations, shell over assembled",
                      shell["linear"].sum() / assembled["linear"].sum(), 1.5, 100)

r = run("preonly", {**PRESSED, "contact_operator": "shell", "motion_ksp_type": "preonly"}, code=2)
require("preonly with the shell is refused and the remedy named",
        "impact: -motion_ksp_type preonly:" in r.log and "gmres" in r.log)
finish()
