# Plate impact, the gallery's with half of its cells: the waves of the square pulse meet in the middle of the target, which
# breaks there; the pull-back of the rear side tells the strength; what comes off flies as fast as the flyer did.
# labels: run
# timeout: 60
import math

import _runs as runs
from fields import Fields

E, NU, RHO, STRENGTH, GC, SPEED, CELL = 375e3, 0.23, 3.89e-9, 400.0, 0.05, 40e3, 1 / 250  # MPa, t/mm^3, N/mm, mm/s, mm
M = E * (1 - NU) / ((1 + NU) * (1 - 2 * NU))
C = math.sqrt(M / RHO)
# The energy at which damage begins, of the spectral split, in uniaxial strain.
LIMIT = STRENGTH * math.sqrt(M / E * (1 + NU * (1 - 2 * NU)) / (1 + NU))

run = runs.run("spall", {"mesh_set_n": 250, "mesh_set_n_second": 500, "mesh_set_width": CELL, "ts_max_time": 0.46e-6},
               files=[runs.option_file("spall.opts")])
t, v = run["time"], run["measure_rear_vx"]
plateau = v[(t > 2.2 / C) & (t < 3.8 / C)]
runs.check("speed of the rear side behind the wave, over that of the flyer", plateau.mean() / SPEED, 1, 1e-3)
lowest = v[(t > 3.8 / C) & (t < 4.2 / C)].min()
runs.check("rho c/2 times the pull-back, over the strength in uniaxial strain", RHO * C / 2 * (SPEED - lowest) / LIMIT, 1, 0.02)
runs.check("time of the pull-back, over that of the wave from the middle", t[v == lowest][0] * C / 4, 1, 0.02)
fields = Fields("spall/vis.xdmf")
places, phi = fields.places(fields.grids[-1]), fields.field(fields.grids[-1], "phi")[0].ravel()
broken = places[phi > 0.9999, 0] - 2  # the target begins at 1 and is 2 long
runs.check_between("cells that are broken, nearest side to the middle, over a cell", abs(broken).min() / CELL, 0, 1)
runs.check_between("and the farthest", abs(broken).max() / CELL, 0, 3)
# Two rows of broken cells, 0.16 G_c each, and what the front, some cells wide, damages beside the crack.
runs.check_between("energy of the crack over G_c", run["energy_fracture"][-1] / (GC * CELL), 1, 1.7)
runs.check("momentum of the target over that of the flyer", run["momentum_target_x"][-1] / (RHO * SPEED * CELL), 1, 5e-3)
runs.finish()
