# labels: run long
# timeout: 300
# processors: 1
"""Hertz's impact of a steel sphere on a rigid plane by central differences (options/sphere_impact.opts) beside the closed form and
beside Newmark's method: time of contact, largest force and approach, speed at the end, energy."""
import numpy
from _impact import hertz
from _runs import check, finish, option_file, run

R, E, NU, RHO = 10.0, 210e3, 0.3, 7.8e-9
CLOSED = hertz(R, E / (1 - NU**2), 4 / 3 * numpy.pi * R**3 * RHO, 1000)
QUIET = {"output_vis_every": 1000000}


def figures(r):
    """Time of contact, largest force, largest approach, speed at the end over that of the start."""
    force = r["contact_foot_force_y"]
    on = numpy.nonzero(force)[0]
    return (r["time"][on[-1]] - r["time"][on[0] - 1], force.max(), -r["probe_middle_uy"].min(),
            -r["momentum_sphere_y"][-1] / r["momentum_sphere_y"][0])


r = run("explicit", {**QUIET, "ts_type": "central_difference", "ts_dt": "auto"}, files=[option_file("sphere_impact.opts")])
newmark = run("newmark", QUIET, files=[option_file("sphere_impact.opts")])
print(f"     {r['step'][-1]:.0f} explicit steps, {newmark['step'][-1]:.0f} of Newmark's method")
for name, found, closed, other in zip(("time of contact", "largest force", "largest approach"), figures(r), CLOSED, figures(newmark)):
    check(f"{name}, closed form", found, closed, 0.02)
    check(f"{name}, Newmark's method", found, other, 0.02)
check("speed at the end over that of the start", figures(r)[3], 1, 1e-3)
energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
check("energy over that of the start", abs(energy / energy[0] - 1).max(), 0, 1e-4, relative=False)
check("first law", abs(r["balance_first_law"]).max(), 0, 1e-6, relative=False)
finish()
