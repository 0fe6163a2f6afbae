# D7: a square plate with a slit in shear. With the spectral split the crack goes to the tension side; without one that tells
# tension from compression it does not. The references are two coarse runs of tjhei/cracks with the same split (initial stiffness 64.9 kN/mm per
# mm of thickness; largest force 527 N with a small width, more than 590 N with one of 0.088 mm), so a tenth is their own spread.
# labels: run long
# timeout: 900
import _runs as runs


def plate(split, end):
    return runs.run(split, {
        "mesh": runs.mesh("edge_crack.geo"), "mesh_set_n": 40, "ts_type": "static", "units": "mm_t_s_MPa",
        "materials": "plate", "material_plate_E": 210e3, "material_plate_nu": 0.3, "material_plate_damage": "at2",
        "material_plate_Gc": 2.7, "material_plate_gamma": 0.044, "material_plate_split": split,
        "bcs": "hold,push,sides,flank", "bc_hold_on": "bottom", "bc_hold_type": "fix", "bc_push_on": "top",
        "bc_push_ux": "t", "bc_push_uy": 0, "bc_sides_on": "sides", "bc_sides_uy": 0, "bc_flank_on": "flank",
        "bc_flank_uy": 0, "ts_times": f"0,7e-3,{end}", "ts_dts": "5e-4,1e-4", "coupling_snes_atol": 1e-3})


run = plate("spectral", 14e-3)
force = run["reaction_push_x"]
runs.check("initial stiffness (N/mm)", force[1] / run["time"][1], 64.9e3, 0.02)
runs.check_between("largest force (N)", force.max(), 500, 590)
runs.check_between("displacement there (mm)", run["time"][force.argmax()], 9e-3, 11.5e-3)
runs.require("the force falls by a third or more", force[-1] < 2 / 3 * force.max())
runs.check_between("tip of the crack, x", run["crack_plate_tip_x"][-1], 0.8, 1)
runs.check_between("tip of the crack, y: below the slit, on the side of tension", run["crack_plate_tip_y"][-1], 0, 0.2)
other = plate("volumetric", 9e-3)
runs.require("with the volumetric split the plate is weaker, because shear alone breaks it",
             other["reaction_push_x"].max() < 0.85 * force.max())
runs.finish()
