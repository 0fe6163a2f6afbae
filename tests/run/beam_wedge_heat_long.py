# labels: run long
# timeout: 1200
# processors: 1
"""beam_wedge_heat.opts with fields at every step: the beam warms most at the root of the slit, as the crack leaves it."""
import os
import sys

import numpy
from _runs import SOURCE, check, check_between, finish, option_file, run

sys.path.insert(0, os.path.join(SOURCE, "tools"))
import warmest  # noqa: E402

ROOT = numpy.array([0.010, 0.006])
r = run("beam", {"output_vis_every": 1}, files=[option_file("beam_wedge_heat.opts")])
x, times = warmest.rises(os.path.join(r.dir, "vis.xdmf"))
away = numpy.linalg.norm(x[:, :2] - ROOT, axis=1)
t, rise = max(times, key=lambda item: item[1].max())
print(f"     largest rise {rise.max():.3f} K at t = {t:.5g} s, {1e3 * x[rise.argmax(), 0]:.4g}, {1e3 * x[rise.argmax(), 1]:.4g} mm; farther than "
      f"1 mm from the root {max(now[away > 1e-3].max() for _, now in times):.3f} K in the whole run")
check("largest rise: distance to the root of the slit in mm", 1e3 * away[rise.argmax()], 0, 0.15, relative=False)
check("largest rise in K", rise.max(), 3.70, 0.02)
opened = r["time"][numpy.flatnonzero(r["phi_max"] > 0.95)[0]]
check_between("it comes after the crack has opened, s later", t - opened, 0, 5e-3)
check_between("largest rise elsewhere over it", max(now[away > 1e-3].max() for _, now in times) / rise.max(), 0.4, 0.8)
check("first law", abs(r["balance_first_law"]).max(), 0, 1.5e-4, relative=False)
finish()
