"""A plate comes down on a tube (tetrahedra of second order, flow, static steps): it touches along a line at first, after a step
in which many points had lain behind it. Stiff springs there asked for pressures that threw the cells about: steps were cut to an
eighth, and a mesh of 73,422 unknowns took two minutes for the first of them. In the end the force is that of four hinges of
plane strain, M_p = (2/sqrt 3) sigma_y t^2/4 per width each: 4 M_p/R on the tube, half of it on the half that is here."""""
# labels: run
# timeout: 180
import math

from _runs import check, check_between, finish, mesh, require, run

RADIUS, WALL, LENGTH, YIELD = 25, 3, 30, 250
TUBE = {
    "mesh": mesh("pressed_tube.geo"), "order": 2, "units": "mm_t_s_MPa", "materials": "tube", "material_tube_model": "j2",
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
finish()
