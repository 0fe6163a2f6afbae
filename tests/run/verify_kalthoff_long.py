# labels: run long
# timeout: 1800
"""A plate struck beside its slit (Kalthoff and Winkler 1988, D10), in explicit steps with gamma 1 mm on cells of 0.5 mm: by the
edge's speed, as published computations have it, and by a projectile (options/kalthoff_striker.opts), whose push ends."""
import numpy

from _runs import check, check_between, finish, option_file, run

RAYLEIGH = 2803.0  # m/s
HISTORY = {"outputs": "hist", "output_hist_type": "csv", "output_hist_dt": 5e-7}


def follow(name, r):
    """Checks its start and speed; the mean angle of the crack from the tip of the slit to y = 90 mm, and the time there."""
    t = r["time"] * 1e6
    x, y = (numpy.nan_to_num(r[f"crack_plate_tip_{axis}"]) * 1e3 for axis in "xy")
    ran = numpy.hypot(x - 50, y - 25) * (x > 0)
    check_between(f"{name}: it has run 1 mm, us", t[numpy.argmax(ran > 1)], 20, 30)
    speeds = []
    for start in numpy.arange(30, 75):
        rows = (t >= start) & (t <= start + 10)
        speeds.append(numpy.hypot(*(numpy.polyfit(t[rows], c[rows], 1)[0] for c in (x, y))) * 1e3)
    check_between(f"{name}: largest speed of the tip over 10 us, m/s, below 0.6 of Rayleigh's", max(speeds), 1000, 0.6 * RAYLEIGH)
    first, last = numpy.argmax(y > 35), numpy.argmax(y > 90)
    check_between(f"{name}: angle of the first 10 mm, degrees", numpy.degrees(numpy.arctan2(y[first] - 25, x[first] - 50)), 65, 75)
    check(f"{name}: first law", r["balance_first_law"][-1], 0, 1e-3, relative=False)
    return numpy.degrees(numpy.arctan2(y[last] - 25, x[last] - 50)), t[last]


pushed = run("pushed", {**HISTORY, "ts_type": "central_difference", "ts_dt": "auto", "coupling_snes_max_it": 1, "mesh_set_h": 0.5, "mesh_set_far": 2,
                        "material_plate_gamma": "1 mm"}, files=[option_file("kalthoff.opts")])
mean, there = follow("pushed", pushed)
check_between("pushed: mean angle, degrees, 65 to 70 published", mean, 65, 70)
struck = run("struck", HISTORY, files=[option_file("kalthoff_striker.opts")])
mean, there = follow("struck", struck)
# The projectile of 100 mm has lost its speed after 36 us and lets go after 47 us.
ends = struck["time"][numpy.flatnonzero(struck["contact_face_force_x"])[-1]] * 1e6
check_between("struck: end of the contact, us", ends, 44, 50)
check("struck: mean angle, degrees", mean, 62, 1.5, relative=False)
finish()
