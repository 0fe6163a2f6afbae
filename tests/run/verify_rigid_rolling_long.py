# labels: run long
# timeout: 300
"""A rigid disc that rolls or slides down a slope with friction, and Hertz's impact of an elastic sphere on a free rigid one:
accelerations of the closed forms, heat of friction, time of contact, force, approach and momentum. A rigid ball with spin on a
free plate in space: momentum, ranks."""
import numpy
from _impact import compare, hertz
from _runs import check, finish, mesh, option_file, require, run

print("a disc on a slope of 20 degrees")
G, SLOPE = 10.0, numpy.radians(20)
DISC = {
    "mesh": mesh("roller.geo"), "mesh_set_n": 96, "mesh_set_n_slab": 24, "mesh_set_start": 1.5,
    "materials": "disc,slab", "material_disc_model": "rigid", "material_disc_rho": 1, "material_slab_like": "disc",
    "bcs": "hold,weight", "bc_hold_on": "slab", "bc_hold_type": "fix", "bc_weight_on": "disc",
    "bc_weight_type": "body_force", "bc_weight_ux": G * numpy.sin(SLOPE), "bc_weight_uy": -G * numpy.cos(SLOPE),
    "contacts": "face", "contact_face_secondary": "disc_side", "contact_face_primary": "slab_top",
    "contact_face_enforce": "penalty", "contact_face_penalty": 1e5, "contact_face_friction": 0.5,
    "ts_dt": 0.01, "ts_max_time": 1, "ts_newmark_rho": 0.8,
}


def slope_of(r, column):
    late = r["time"] > 0.3
    return numpy.polyfit(r["time"][late], r[column][late], 1)[0]


r = run("rolls", DISC)
moment = r["rigid_disc_lz"][-1] / r["rigid_disc_wz"][-1]
mass = r["momentum_disc_x"][-1] / r["rigid_disc_vx"][-1]
check("its moment of inertia over m R^2/2", moment / mass, 0.5, 0.01)
check("rolls: acceleration over 2/3 g sin", slope_of(r, "rigid_disc_vx"), G * numpy.sin(SLOPE) / (1 + moment / mass), 0.02)
check("angular acceleration times R over acceleration", slope_of(r, "rigid_disc_wz") / slope_of(r, "rigid_disc_vx"), -1, 0.05)
r = run("slides", {**DISC, "contact_face_friction": 0.05})
check("slides: acceleration g (sin - mu cos)", slope_of(r, "rigid_disc_vx"), G * (numpy.sin(SLOPE) - 0.05 * numpy.cos(SLOPE)), 5e-3)
check("angular acceleration mu m g cos R/I", slope_of(r, "rigid_disc_wz"), -0.05 * mass * G * numpy.cos(SLOPE) / moment, 0.01)
work = r["work_external"][-1] - r["energy_kinetic"][-1]
check("heat of friction, what the weight did and did not become motion", r["dissipated_friction"][-1], work, 0.05)

print("Hertz: an elastic sphere of 10 mm hits a rigid one of the same mass at 1 m/s")
R, E, NU, DENSITY = 10.0, 210e3, 0.3, 7.8e-9
m, modulus = 4 / 3 * numpy.pi * R**3 * DENSITY / 2, E / (1 - NU**2)
r = run("spheres", {"mesh_set_two": 1, "mesh_set_near": 0.05, "materials": "sphere,lower", "material_lower_model": "rigid",
                    "material_lower_rho": DENSITY, "contact_foot_primary": "lower_round", "ts_max_time": 6e-5},
        files=[option_file("sphere_impact.opts")])
compare(r, hertz(R / 2, modulus, m, 1000), (r["rigid_lower_uy"] - r["probe_middle_uy"]).max())
check("speed of the rigid one at the end", r["rigid_lower_vy"][-1], -1000, 0.01)
momentum = r["momentum_sphere_y"] + r["momentum_lower_y"]
check("change of the momentum", abs(momentum / momentum[0] - 1).max(), 0, 1e-10, relative=False)

print("a spinning rigid ball on a free plate in space (options/rigid_ball.opts, coarser)")
BALL = {"mesh_set_n": 12, "mesh_set_layers": 1, "mesh_set_near": 9, "mesh_set_far": 16, "bc_clamp_type": "body_force",
        "bc_clamp_on": "plate", "bc_clamp_ux": 0, "ts_max_time": 2.4e-3, "contact_foot_search_radius": "1 cm",
        "motion_snes_rtol": 1e-12, "output_vis_dt": 1}
one = run("ball", BALL, files=[option_file("rigid_ball.opts")])
for axis in "xyz":
    momentum = one["momentum_ball_" + axis] + one["momentum_plate_" + axis]
    check(f"change of the momentum in {axis} over the ball's", numpy.ptp(momentum) / abs(one["momentum_ball_z"][0]), 0, 1e-10,
          relative=False)
require("friction takes a good part of the spin", one["rigid_ball_wy"][-1] < 0.8 * one["rigid_ball_wy"][0])
three = run("ball_ranks", BALL, files=[option_file("rigid_ball.opts")], ranks=3)
for column in ("rigid_ball_wy", "contact_foot_force_z", "energy_elastic", "momentum_plate_x"):
    check(f"three ranks: {column}", abs(one[column] - three[column]).max() / abs(one[column]).max(), 0, 1e-8, relative=False)
finish()
