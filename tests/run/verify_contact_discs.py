# labels: run
# timeout: 180
# long: 200
"""Oblique impact of two elastic discs without friction, mortar, everything else by default: momentum to rounding, moment of
momentum to 1e-6, energy never above its start, velocities after the impact those of smooth elastic discs. What is left of
the moment of momentum is the integrator's own, of second order in the step; forces along the gradients at the end of the
step would turn the pair by dt/2 times impulse times tangential velocity."""
import math

import numpy
from _fields import Bodies
from _runs import check, check_between, finish, long, option_file, run

RHO, V, RADIUS, GAP, OFFSET, DT = 2700.0, 10.0, 10e-3, 0.05e-3, 10e-3, 2e-7
SINE = OFFSET / (2 * RADIUS + GAP)  # of the angle between the flight and the line of centres
COSINE = math.sqrt(1 - SINE**2)


def collide(name, options):
    """The run, its energy and the change of its moment of momentum over momentum times radius, time after time."""
    r = run(name, options, files=[option_file("discs.opts")])
    bodies = Bodies(r, RHO)
    moments = numpy.array([bodies.moments(k) for k in range(len(bodies.fields.times))])
    start = r["momentum_disc_x"][0]
    for k in "xy":
        total = r[f"momentum_disc_{k}"] + r[f"momentum_second_{k}"]
        check(f"{name}: change of the total momentum in {k}, relative", abs(total - total[0]).max() / start, 0, 1e-10,
              relative=False)
    check(f"{name}: momentum from the fields over that of the history", moments[0, 0] / start, 1, 1e-9)
    turn = (moments[:, 2] - moments[0, 2]) / (start * RADIUS)
    pressed = numpy.flatnonzero(r["contact_face_active"])
    print(f"     {name}: {len(r['time']) - 1} steps, contact in {len(pressed)}, Newton iterations per step "
          f"{r['newton'][1:].mean():.2f}, most {r['newton'].max():.0f}; moment of momentum changes by {abs(turn).max():.2e}")
    energy = r["energy_kinetic"] + r["energy_elastic"]
    return r, energy / energy[0], abs(turn).max()


r, energy, turn = collide("discs", {})
check_between("largest energy over that of the start", energy.max(), 0.97, 1 + 1e-9)
check_between("energy at the end over that of the start", energy[-1], 0.97, 1)
# Equal discs, an impact without loss: the struck one takes the velocity along the line of centres.
impulse = numpy.hypot(r["impulse_face_x"][-1], r["impulse_face_y"][-1])
# The discs are polygons with corners of 7.5 degrees.
check("direction of the impulse, sine of the angle", abs(r["impulse_face_y"][-1]) / impulse, SINE, 0.06)
check_between("impulse over m v cos, less what is left as vibration", impulse / (r["momentum_disc_x"][0] * COSINE), 0.95, 1)
theory = DT / 2 * V * SINE * impulse / (r["momentum_disc_x"][0] * RADIUS)
check("change of the moment of momentum over momentum times radius", turn, 0, 1e-6, relative=False)
check_between(f"the same over the {theory:.2e} of forces at the end of the step", turn / theory, 0, 0.02)
if long():
    _, _, short = collide("short_steps", {"ts_dt": DT / 2})
    check_between("the same with half the step over that with the whole one", short / turn, 0.15, 0.4)
r, energy, turn = collide("points", {"contact_face_method": "gpts", "contact_face_enforce": "penalty"})
check("Gauss points and penalty: change of the moment of momentum", turn, 0, 1e-6, relative=False)
energy = energy + r["energy_contact"] / (r["energy_kinetic"][0] + r["energy_elastic"][0])
check_between("Gauss points and penalty: largest energy over that of the start", energy.max(), 0.97, 1 + 1e-9)
_, energy, turn = collide("trapezoidal", {"contact_face_impact": "none", "contact_face_enforce": "penalty",
                                          "contact_face_penalty": 7e13, "ts_newmark_rho": 1})
check("trapezoidal rule and penalty: change of the moment of momentum", turn, 0, 1e-6, relative=False)
finish()
