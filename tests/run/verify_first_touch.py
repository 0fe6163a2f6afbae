"""A plate comes down on a tube (tetrahedra of second order, flow, static steps): it touches along a line at first, after a step
in which many points had lain behind it. Stiff springs there asked for pressures that threw the cells about: steps were cut to an
eighth, and a mesh of 73,422 unknowns took two minutes for the first of them. In the end the force is that of four hinges of
plane strain, M_p = (2/sqrt 3) sigma_y t^2/4 per width each: 4 M_p/R on the tube, half of it on the half that is here.
A ball pressed into steel meets more of it in each step, with augmentations: with all of their penalty from the start Newton's
method went astray (107,811 unknowns did not end their second step in a quarter of an hour). Mean pressure of Tabor, 2.8 sigma_y."""
# labels: run
# timeout: 180
# long: 240
import math

from _runs import check, check_between, finish, long, mesh, require, run

RADIUS, WALL, LENGTH, YIELD = 25, 3, 15 if long() else 5, 250
TUBE = {
    "mesh": mesh("pressed_tube.geo"), "mesh_set_length": LENGTH, "order": 2, "units": "mm_t_s_MPa", "materials": "tube", "material_tube_model": "j2",
    "material_tube_E": 200e3, "material_tube_nu": 0.3, "material_tube_sigma_y": YIELD,
    "bcs": "left,low,ends", "bc_left_on": "left", "bc_left_ux": 0, "bc_low_on": "low", "bc_low_uy": 0, "bc_ends_on": "ends", "bc_ends_uz": 0,
    "contacts": "plate", "contact_plate_secondary": "skin", "contact_plate_primary": "plane", "contact_plate_plane_normal": "0,-1,0",
    "contact_plate_plane_point": f"0,{RADIUS + WALL / 2},0", "contact_plate_rigid_uy": "(-3*t)",
    "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 1, "energy_tol": 0.3,
}
hinge = 2 / math.sqrt(3) * YIELD * WALL**2 / 4
forces = {}
for name, settings in {"default": {}, "augmentations": {"contact_plate_enforce": "auglag", "ts_max_time": 0.5}}.items():
    r = run(name, {**TUBE, **settings}, refused=4)
    require(f"{name}: no step was cut", "time step cut" not in r.log)
    check_between(f"{name}: iterations of the step of the first touch", r["newton"][1], 3, 25)
    forces[name] = -r["contact_plate_force_y"]
check("force of two hinges of the half and two more beside them", forces["default"][-1], 2 * hinge * LENGTH / RADIUS, 0.1)
check("both enforcements, half way", forces["augmentations"][5], forces["default"][5], 2e-3)

BALL, DEPTH = 5, 0.1
r = run("ball", {
    "mesh": mesh("block.geo"), "mesh_set_dim": 3, **{f"mesh_set_l{k}": 3 for k in "xyz"}, "mesh_set_n": 12, "units": "mm_t_s_MPa",
    "materials": "solid", "material_solid_model": "j2", "material_solid_E": 200e3, "material_solid_nu": 0.3, "material_solid_sigma_y": 400,
    "bcs": "left,back,bottom", "bc_left_on": "left", "bc_left_ux": 0, "bc_back_on": "back", "bc_back_uz": 0, "bc_bottom_on": "bottom",
    "bc_bottom_type": "fix", "contacts": "ball", "contact_ball_secondary": "top", "contact_ball_primary": "rigid_sphere",
    "contact_ball_centre": f"0,{3 + BALL},0", "contact_ball_radius": BALL, "contact_ball_rigid_uy": "(-t)", "contact_ball_friction": 0.2,
    "contact_ball_enforce": "auglag", "ts_type": "static", "ts_dt": 0.02, "ts_max_time": DEPTH, "energy_tol": 0.3}, refused=None)
require("ball: no step was cut", "time step cut" not in r.log)
check_between("ball: iterations of Newton's method in all", r["newton"].sum(), 40, 110)
check_between("ball: iterations of its linear solves in all", r["linear"].sum(), 2000, 9000)
check("mean pressure below the old surface over 2.8 yield stresses", -4 * r["contact_ball_force_y"][-1] / (math.pi * 2 * BALL * DEPTH),
      2.8 * 400, 0.12)
finish()
