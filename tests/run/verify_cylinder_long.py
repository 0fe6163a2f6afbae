# labels: run long
# timeout: 2400
"""A thick cylinder bursts (options/cylinder.opts, D14) beside the raw data of Mandal, Nguyen and Wu (Eng. Fract. Mech. 2020,
iitbtushar/dynamic-fracture, fragmentation/post-processing/wu.dat): energies while it is elastic, surface energy when it has
broken. Theirs has gamma 1 mm on cells of gamma/4 and another field of chance, and is driven by the largest stress."""
import os

from _runs import check, check_between, finish, option_file, run
from fields import Fields
from fragments import parts
import numpy

r = run("cylinder", {}, files=[option_file("cylinder.opts")])
t = r["time"] * 1e6


def at(time, column):
    """In J/mm."""
    return float(numpy.interp(time, t, r[column])) * 1e-3


for time, elastic, kinetic in ((20, 7.5256, 17.5072), (30, 18.4548, 21.9125), (40, 40.8733, 16.3171), (50, 55.0594, 6.1354)):
    check(f"elastic energy at {time} us, J/mm", at(time, "energy_elastic"), elastic, 5e-3)
    check(f"kinetic energy at {time} us, J/mm", at(time, "energy_kinetic"), kinetic, 1e-2)
check("time of the first mJ/mm of surface energy, us", t[numpy.argmax(r["energy_fracture"] > 1)], 51.06, 0.05)
for time, published in ((90, 40.60), (104, 42.50)):
    check(f"surface energy at {time} us, J/mm", at(time, "energy_fracture"), published, 0.05)
rows = t > 55
half = float(numpy.interp(21.25, r["energy_fracture"][rows] * 1e-3, t[rows]))
check("time when half of it is there, us", half, 73.46, 0.08)
fields = Fields(os.path.join(r.dir, "vis.xdmf"))
pieces = parts(fields, fields.grids[-1])
check_between("pieces", len(pieces), 10, 20)
check_between("what they are of the cylinder", sum(pieces), 0.7, 1)
check("first law", r["balance_first_law"][-1], 0, 1e-2, relative=False)
finish()
