# The L-panel of concrete in the gallery, coarse and up to its peak: the load of the test (Winkler 2001), nearly the same for
# another length, and with one set of parameters a strength that falls with the size, less than that of a body with a long crack.
# labels: run
# timeout: 300
# long: 200
import math

import _runs as runs
from fields import Fields

MEASURED = 7219.0  # N
peaks = {}
for size, h, gamma, end in ((250, 12, 36, 0.2), (250, 8, 24, 0.2), (125, 6, 18, 0.12), (500, 12, 36, 0.3))[: 4 if runs.long() else 3]:
    run = runs.run(f"l_{size}_{gamma}", {"mesh_set_size": size, "mesh_set_h": h, "material_panel_gamma": gamma, "ts_dt": end / 20,
                                         "ts_max_time": end, "output_vis_times": end}, files=[runs.option_file("l_panel.opts")])
    force = run["reaction_lift_y"]
    runs.require(f"size {size}, gamma {gamma}: the load has fallen at the end", force[-1] < 0.99 * force.max())
    peaks[size, gamma] = force.max()
runs.check("largest load beside that of the test", peaks[250, 24], MEASURED, 0.05)
runs.check("largest load with one and a half times the length", peaks[250, 36], peaks[250, 24], 0.03)
for small, large in (((125, 18), (250, 36)), ((250, 36), (500, 36)))[: 2 if runs.long() else 1]:
    power = -math.log(peaks[large] / peaks[small] / 2) / math.log(2)
    runs.check_between(f"fall of the nominal strength from size {small[0]} to {large[0]}: power of the size", power, 0.2, 0.5)
fields = Fields("l_250_24/vis.xdmf")
places, phi = fields.places(fields.grids[-1]), fields.field(fields.grids[-1], "phi")[0].ravel()
tip = places[phi > 0.1][places[phi > 0.1][:, 0].argmin()]
runs.check_between("crack: how far it is to the left of the corner, over the size", (250 - tip[0]) / 250, 0.2, 1)
runs.check_between("crack: its slope, upwards", (tip[1] - 250) / (250 - tip[0]), 0, 0.5)
runs.finish()
