# labels: run long
# timeout: 300
"""Hertz's impact of an elastic sphere on a free rigid one that is not meshed: time of contact, force, approach, momentum; the
dent of a rigid ball in aluminium and the speed with which it leaves (options/drop_ball.opts) beside Johnson's rebound."""
import numpy
from _impact import compare, hertz
from _runs import check, check_between, finish, option_file, run

print("Hertz: an elastic sphere of 10 mm hits a rigid one of the same mass at 1 m/s")
R, E, NU, DENSITY = 10.0, 210e3, 0.3, 7.8e-9
m, modulus = 4 / 3 * numpy.pi * R**3 * DENSITY / 2, E / (1 - NU**2)
r = run("spheres", {"mesh_set_near": 0.05, "contact_foot_primary": "rigid_sphere", "contact_foot_centre": "0,-10",
                    "contact_foot_radius": R, "contact_foot_rigid_mass": 2 * m, "ts_max_time": 6e-5},
        files=[option_file("sphere_impact.opts")])
compare(r, hertz(R / 2, modulus, m, 1000), (r["rigid_obstacle_foot_uy"] - r["probe_middle_uy"]).max())
check("speed of the rigid one at the end", r["rigid_obstacle_foot_vy"][-1], -1000, 0.01)
momentum = r["momentum_sphere_y"] + r["momentum_obstacle_foot_y"]
check("change of the momentum", abs(momentum / momentum[0] - 1).max(), 0, 1e-10, relative=False)

print("a ball leaves a dent and bounces (options/drop_ball.opts)")
# Two of the solves in which it leaves are left to augmentations.
r = run("drop", {}, files=[option_file("drop_ball.opts")], refused=2)
speed = r["rigid_obstacle_foot_vy"]
MODULUS, YIELD, MASS = 70e3 / (1 - 0.33**2), 300.0, 4.08e-6
# Johnson's elastic rebound from the largest force and its circle of contact (K. L. Johnson, Contact Mechanics, 11.5); his
# estimate of both is by 3 Y under the ball.
force, area = max(zip(abs(r["contact_foot_force_y"]), r["contact_foot_length"]))
check_between("mean pressure over the yield stress", force / area / YIELD, 2.5, 3)
rebound = 3 * force**2 / (10 * numpy.sqrt(area / numpy.pi) * MODULUS)
check("speed that comes back, beside Johnson's rebound", speed[-1] / 5000, numpy.sqrt(rebound / (MASS / 2 * 5000**2)), 0.1)
lost = MASS / 2 * (speed[0] ** 2 - speed[-1] ** 2)
check_between("part of the lost energy that flowed plastically, the rest went off in waves", r["dissipated_plastic"][-1] / lost,
              0.7, 1)
check("first law", abs(r["balance_first_law"]).max() / r["energy_kinetic"][0], 0, 1e-2, relative=False)
finish()
