# labels: run long
# timeout: 2400
"""A crack that stops under a hole (options/hole_arrest.opts, D14) beside the raw data of Mandal, Nguyen and Wu (Eng. Fract.
Mech. 2020, iitbtushar/dynamic-fracture, arrest/post-processing), reduced in the same way. Theirs has gamma 0.0375 mm on cells of
gamma/4 and is driven by the largest stress; here gamma is four times as long, on cells of gamma/2, and the energy drives."""
import numpy

from _runs import check, check_between, finish, option_file, run

GAMMA = 0.15
r = run("hole_arrest", {}, files=[option_file("hole_arrest.opts")])
t, x = r["time"] * 1e6, numpy.nan_to_num(r["crack_pmma_tip_x"])
# AT2, AT1, cohesive; AT2 goes on from the hole.
check_between("the crack has run 0.1 mm, us; 100.3, 101.0, 99.9 published", t[numpy.argmax(x > 75.1)], 0.975 * 100.5, 1.025 * 101.5)
way = (x > 76) & (x < 88)
speed = numpy.polyfit(t[way], x[way], 1)[0] * 1e3
check_between("speed from x = 76 to 88 mm, m/s; 361, 371, 369 published", speed, 0.95 * 364, 1.05 * 370)
for place, published in ((80, 113.2), (85, 126.5), (88, 135.9), (90, 145.3), (91, 155.4)):
    check(f"time at x = {place} mm, us, beside AT1", t[numpy.argmax(x > place)], published, 0.05)
check_between("where it stops, mm; 91.37, 91.49 published", x[-1], 91.37 - GAMMA, 91.49 + GAMMA)
check("it has stood since 165 us", x[numpy.argmax(t > 165)], x[-1], GAMMA, relative=False)
for time, published in ((120, 2.633), (130, 3.896), (140, 4.771), (180, 5.668)):
    check(f"surface energy at {time} us, mJ/mm, beside AT1", float(numpy.interp(time, t, r["energy_fracture"])), published, 0.05)
check("first law", r["balance_first_law"][-1], 0, 5e-4, relative=False)
finish()
