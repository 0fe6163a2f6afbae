# labels: run long
# timeout: 1500
"""The notched beam with three holes of Bittencourt, Wawrzynek, Ingraffea and Sousa (Eng. Fract. Mech. 55 (1996) 321) with the
data of Miehe, Hofacker and Welschinger (CMAME 199 (2010) 2765), options/three_holes.opts: the crack passes the first hole on
its left and ends in the second. It runs there within one step of statics, whose passes must all find their balance: broken
cells, which bear a millionth where they are open, are stretched to several times their size on the way."""
import numpy

from _runs import check, check_between, finish, option_file, require, run
from fields import Fields

r = run("three_holes", {}, files=[option_file("three_holes.opts")])
force = -r["reaction_load_y"]
running = numpy.argmax(r["newton"])
check("each step at its first try", r["tries"].max(), 1, 0)
check_between("way at which the crack runs, mm", r["time"][running], 0.165, 0.175)
check_between("force that is left over the largest", force[running] / force.max(), 0, 0.1)
fields = Fields("three_holes/vis.xdmf")
X, phi = fields.places(fields.grids[-1]), fields.field(fields.grids[-1], "phi")[0].ravel()
first, second = (numpy.abs(numpy.hypot(X[:, 0] - 6, X[:, 1] - y) - 0.25) < 1e-3 for y in (2.75, 4.75))
check_between("phi at the first hole", phi[first].max(), 0, 0.2)
open_hole = X[second & (phi > 0.95) & (X[:, 1] < 4.75)]
require("the crack opens the second hole", len(open_hole) > 0)
angle = numpy.degrees(numpy.arctan2(6 - open_hole[:, 0].mean(), 4.75 - open_hole[:, 1].mean()))
check_between("from below, on its left, degrees", angle, 0, 60)
beside = X[(phi > 0.95) & (abs(X[:, 1] - 2.75) < 0.06), 0]
check_between("where it passes the first hole, mm", beside.mean(), 4.5, 5.1)
check("sum of all energies", r["balance"][-1], 0, 1e-10, relative=False)
finish()
