# labels: run
# timeout: 180
# long: 200
"""A matrix of the blocks on and above the diagonal (-motion_mat_type sbaij) changes the linear solver and nothing else:
histories are those of the full matrix, in the plane with contact and in space, on one and two ranks, with each
preconditioner that can work with it; what cannot is refused."""
from _runs import TWO_BLOCKS, check, finish, long, mesh, require, run

TIGHT = {"motion_snes_rtol": 1e-10, "motion_ksp_rtol": 1e-11}
PLANE = {**TWO_BLOCKS, **TIGHT}
SPACE = {
    "mesh": mesh("block.geo"), "mesh_set_dim": 3, "mesh_set_n": 5, "mesh_set_lz": 0.6, "mesh_set_nz": 3,
    "materials": "solid", "material_solid_E": 1e6, "material_solid_nu": 0.3, "material_solid_rho": 1000,
    "bcs": "hold,twist", "bc_hold_on": "left", "bc_hold_type": "fix",
    "bc_twist_on": "right", "bc_twist_uy": "0.2*z*ramp(t,0,0.02)", "bc_twist_uz": "(-0.2)*y*ramp(t,0,0.02)",
    "ts_dt": 2e-3, "ts_max_time": 0.03, **TIGHT,
}
COLUMNS = {
    "plane": ("energy_kinetic", "energy_elastic", "momentum_upper_x", "momentum_upper_y", "reaction_hold_y",
              "contact_face_force_y", "contact_face_pressure_max"),
    "space": ("energy_kinetic", "energy_elastic", "reaction_hold_x", "reaction_hold_y", "reaction_twist_z"),
}
CHOLESKY = {"motion_ksp_type": "preonly", "motion_pc_type": "cholesky"}
VARIANTS = {
    "as chosen by the program": ({}, (1, 2)),
    "cholesky, mumps": ({**CHOLESKY, "motion_pc_factor_mat_solver_type": "mumps"}, (2,)),
    "cholesky, petsc": ({**CHOLESKY, "motion_pc_factor_mat_solver_type": "petsc"}, (1,)),
    "cg + icc": ({"motion_ksp_type": "cg", "motion_pc_type": "icc"}, (1,)),
    "cg + bjacobi": ({"motion_ksp_type": "cg", "motion_pc_type": "bjacobi"}, (2,)),
    "cg + jacobi": ({"motion_ksp_type": "cg", "motion_pc_type": "jacobi"}, (1, 2)),
}


def folder(*words):
    return "_".join(str(word) for word in words).translate(str.maketrans(" ,", "__", "+"))


for name, base in {"plane": PLANE, "space": SPACE}.items():
    full = run(folder(name, "aij"), {**base, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
                                     "motion_pc_factor_mat_solver_type": "mumps"})
    for variant, (options, ranks) in VARIANTS.items():
        if variant not in ("as chosen by the program", "cg + icc" if name == "space" else "cholesky, mumps") and not long():
            continue
        for count in ranks if long() else ranks[-1:]:
            half = run(folder(name, variant, count), {**base, "motion_mat_type": "sbaij", **options}, ranks=count)
            claim = f"{name}, {variant}, {count} rank{'s' if count > 1 else ''}"
            if not require(f"{claim}: as many steps, no step cut",
                           len(full["time"]) == len(half["time"]) and half["tries"].max() == 1):
                continue
            differences = {c: abs(full[c] - half[c]).max() / abs(full[c]).max() for c in COLUMNS[name]}
            where = max(differences, key=differences.get)
            check(f"{claim} ({half['linear'].sum():.0f} linear iterations): largest difference, in {where}",
                  differences[where], 0, 1e-8, relative=False)
    require(f"{name}: something happens", full["energy_elastic"].max() > 0)

print("the program takes the half of its own accord where it chooses conjugate gradients and forces are symmetric")
WAVES = {**SPACE, "ts_dt": 5e-4, "ts_max_time": 2e-3}
PUSHED = {"bcs": "hold,twist,press", "bc_press_on": "top", "bc_press_type": "pressure", "bc_press_value": 1}
for name, options, half in (("waves", {}, True), ("aij asked for", {"motion_mat_type": "aij"}, False),
                            ("a preconditioner is given", {"motion_pc_type": "jacobi", "motion_ksp_type": "cg"}, False),
                            ("a follower pressure", PUSHED, False), ("long steps", {"ts_dt": 0.3, "ts_max_time": 0.3}, False)):
    r = run(folder("auto", name), {**WAVES, **options})
    require(f"{name}: {'the half' if half else 'all of the matrix'}", ("its upper half" in r.log) == half)
print("what cannot work is refused with a message, exit status 2")
PLASTIC = {"material_lower_model": "j2", "material_lower_sigma_y": 3e3, "material_lower_hardening": "linear",
           "material_lower_linear_h": 1e5}
for name, options, text in (
        ("lu", {"motion_pc_type": "lu"}, '-motion_pc_type "lu": cannot work with -motion_mat_type sbaij; allowed: cholesky'),
        ("gamg", {"motion_pc_type": "gamg"}, '-motion_pc_type "gamg": cannot work with -motion_mat_type sbaij'),
        ("plastic", PLASTIC, "needs a symmetric tangent, that of -material_lower_model j2 is not"),
        ("friction", {"contact_face_friction": 0.3}, "needs a symmetric tangent, that of -contact_face_friction is not")):
    r = run(f"refused_{name}", {**PLANE, "motion_mat_type": "sbaij", **options}, code=2)
    require(f"{name}: {text}", text in r.log)
print("the symmetric part of a plastic tangent is a choice of the user's")
flows = {**PLANE, **PLASTIC, "ts_max_time": 0.04, "motion_tangent": "symmetric", "motion_snes_max_it": 60}
full, half = run("plastic_aij", flows), run("plastic_sbaij", {**flows, "motion_mat_type": "sbaij"})
require("the block flows", full["alpha_max"][-1] > 1e-4)
check("largest difference of the largest alpha", abs(full["alpha_max"] - half["alpha_max"]).max() / full["alpha_max"].max(),
      0, 1e-7, relative=False)
finish()
