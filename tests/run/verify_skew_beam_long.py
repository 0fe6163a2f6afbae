# labels: run long
# timeout: 3000
"""A crack in space at 1e5 unknowns: the notched beam of PMMA whose slot stands askew by 45 degrees, options/skew_beam.opts. In
bending its crack twists, as it rises, into the plane of bending (Lazarus, Buchholz, Fulland, Wiebesiek, Int. J. Fract. 153
(2008) 141), and costs what its area must."""
import numpy

from _runs import check, check_between, finish, option_file, require, run
from fields import Fields

GC, GAMMA, H, THICK = 0.5, 1.2, 0.6, 10.0
r = run("skew_beam", {}, files=[option_file("skew_beam.opts")], ranks=2)
fields = Fields("skew_beam/vis.xdmf")
X, phi = fields.places(fields.grids[-1]), fields.field(fields.grids[-1], "phi")[0].ravel()
require(f"unknowns of both fields: {4 * len(phi)}", 4 * len(phi) > 1e5)


def angle(height):
    """Of the crack with the plane of bending, degrees, where it is as far above the root of the slot."""
    near = (abs(X[:, 1] - 20 - height) < 1) & (phi > 0.9) & (abs(X[:, 0]) < 30)
    return numpy.degrees(numpy.arctan(abs(numpy.polyfit(X[near, 2], X[near, 0], 1)[0])))


check_between("angle of the crack at the slot, degrees", angle(0), 25, 46)
check_between("3 mm above it", angle(3), 8, 22)
check_between("a thickness above it", angle(10), 0, 8)
check_between("largest force, N", -r["reaction_load_y"].min(), 400, 700)
check("each step at its first try", r["tries"].max(), 1, 0)
check("sum of all energies", r["balance"][-1], 0, 1e-9, relative=False)
finish()
