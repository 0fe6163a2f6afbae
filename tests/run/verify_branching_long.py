# labels: run long
# timeout: 1800
"""A crack that forks (options/branching.opts, D9) beside the raw data of Mandal, Nguyen and Wu (Eng. Fract. Mech. 2020,
iitbtushar/dynamic-fracture, branching/post-processing/sigma1b05), reduced in the same way: their notch, as wide as gamma, plane
stress, and cells of gamma/3, whose crack costs 1.17 Gc (theirs of gamma/5 1.10, those of the gallery's file 1.25). Their
damage is driven by the largest stress, here by the elastic energy."""
import os

import numpy

from _runs import check, check_between, finish, mesh, option_file, run
from fields import Fields

GAMMA = 0.5
r = run("branching", {"mesh": mesh("notched_strip.geo"), "mesh_set_n": 600, "mesh_set_beside": 70, "plane": "stress", "material_glass_split": "volumetric",
                      "crack_level": 0.85, "ts_max_time": 83e-6, "output_hist_dt": 0.25e-6}, files=[option_file("branching.opts")])
t, x, y = r["time"] * 1e6, numpy.nan_to_num(r["crack_glass_tip_x"]), r["crack_glass_tip_y"]


def at(what):
    """The first of the rows where it holds."""
    return int(numpy.argmax(what))


# Three models each: AT2, AT1, cohesive.
check_between("the crack has run 0.5 mm, us; 13.7, 14.2, 15.4 published", t[at(x > 50.5)], 0.95 * 13.3, 1.05 * 15.2)
fork = at(abs(y - 20) > 0.5)
check_between("it is 0.5 mm off its line, us; 33.3, 32.8, 32.9 published", t[fork], 31, 1.05 * 33.3)
check("there, x", x[fork], 64.85, 0.02)
run_on = (t > 20) & (t < 70)
speed = numpy.polyfit(t[run_on], x[run_on], 1)[0] * 1e3
check_between("speed along x from 20 to 70 us, m/s; 809, 861, 867 published", speed, 0.95 * 811, 1.05 * 857)
out = at(x > 98.9)
check_between("y of the upper arm at x = 99 mm; 37.1, 36.5, 36.9 published, 37.5, 36.7, 37.1 at the side", max(y[out], 40 - y[out]), 36.5 - GAMMA, 37.5 + GAMMA)
for time, published in ((40, 0.1167), (50, 0.1772), (60, 0.2625), (70, 0.3449), (80, 0.3885)):
    check(f"surface energy at {time} us, mJ/mm", float(numpy.interp(time, t, r["energy_fracture"])), published, 0.05)

fields = Fields(os.path.join(r.dir, "vis.xdmf"))
grid = fields.grids[-1]
place, phi = fields.places(grid), fields.field(grid, "phi")[0][:, 0]
here = numpy.lexsort((numpy.round(place[:, 1], 6), numpy.round(place[:, 0], 6)))
there = numpy.lexsort((numpy.round(40 - place[:, 1], 6), numpy.round(place[:, 0], 6)))
check("the arms are mirror images: largest difference of phi", abs(phi[here] - phi[there]).max(), 0, 2e-2, relative=False)
check("first law", r["balance_first_law"][-1], 0, 1e-4, relative=False)
finish()
