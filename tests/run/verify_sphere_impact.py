# labels: run
# timeout: 240
# long: 240
# processors: 1
"""Hertz's impact: a steel sphere hits a rigid plane (options/sphere_impact.opts), and another sphere that is free too, on
a mesh that does not match. Time of contact, largest force and approach of the closed form; the spheres part as fast as
they met, momentum stays and energy never rises."""
import numpy
from _impact import compare, hertz
from _runs import check, check_between, finish, long, option_file, run

R, E, NU, RHO = 10.0, 210e3, 0.3, 7.8e-9
MASS = 4 / 3 * numpy.pi * R**3 * RHO


def compare_elastic(r, reference, approach):
    compare(r, reference, approach)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check_between("largest energy over the energy at the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
    check_between("energy at the end over the energy at the start", energy[-1] / energy[0], 0.99, 1)
    check_between("tries of a step", r["tries"].max(), 1, 1)
    check_between("mean Newton iterations per step", r["newton"][1:].mean(), 1, 5)


print("on a rigid plane with 1 m/s")
r = run("plane", {}, files=[option_file("sphere_impact.opts")])
compare_elastic(r, hertz(R, E / (1 - NU**2), MASS, 1000), -r["probe_middle_uy"].min())
check("speed at the end over that of the start", -r["momentum_sphere_y"][-1] / r["momentum_sphere_y"][0], 1, 0.005)

if not long():
    finish()
print("on an equal sphere at rest with 1 m/s")
r = run("spheres", {"mesh_set_two": 1, "mesh_set_near": 0.045, "materials": "sphere,lower", "material_lower_like": "sphere",
                    "bc_axis_on": "axis,lower_axis", "contact_foot_primary": "lower_round", "ts_max_time": 8e-5,
                    "probes": "middle,other", "probe_other_at": "0,-10", "probe_other_fields": "u"},
        files=[option_file("sphere_impact.opts")])
compare_elastic(r, hertz(R / 2, E / (1 - NU**2) / 2, MASS / 2, 1000), (r["probe_other_uy"] - r["probe_middle_uy"]).max())
check("speed of the other one at the end over that of the start", r["momentum_lower_y"][-1] / r["momentum_sphere_y"][0], 1, 0.005)
total = r["momentum_lower_y"] + r["momentum_sphere_y"]
check("change of the total momentum, relative", abs(total / total[0] - 1).max(), 0, 1e-10, relative=False)
finish()
