# labels: run long
# timeout: 3600
# processors: 1
"""Spacing of the cracks of options/thermal_shock.opts. Where they begin it follows sqrt(l l_0), l_0 = G_c/(E (alpha drop)^2) being Griffith's
length (Bourdin and others, PRL 112, 2014; Sicsic and others, JMPS 63, 2014), as the shock gets severe; on their way every other one stops."""
import math
import os
import sys

import numpy
from _runs import SOURCE, check, check_between, finish, option_file, run

sys.path.insert(0, os.path.join(SOURCE, "tools"))
import crack_spacing  # noqa: E402

E, GC, ALPHA = 340e3, 42.47e-3, 8e-6


def first_cracks(drop, ell):
    """Spacing at the depth of a quarter of l when cracks have formed, the lengths sqrt(l l_0) and the severity drop/sqrt(Gc/(E alpha^2 l))."""
    r = run(f"first_{drop}_{1000 * ell:g}", {
        "mesh_set_width": 4, "mesh_set_depth": 0.6, "mesh_set_fine": 0.08 + 2 * ell, "mesh_set_h": 0.35 * ell, "param_drop": drop,
        "material_slab_gamma": ell, "ts_times": "0,1e-4,6e-4", "ts_dts": "5e-6,2.5e-5", "output_vis_times": 6e-4},
            files=[option_file("thermal_shock.opts")])
    slab = crack_spacing.Slab(os.path.join(r.dir, "vis.xdmf"))
    griffith = GC / E / (ALPHA * drop)**2
    return slab.spacing(len(slab.times) - 1, ell / 4), math.sqrt(ell * griffith), math.sqrt(ell / griffith)


found = {}
for drop, ell in ((300, 0.046), (380, 0.046), (480, 0.046), (600, 0.046), (380, 0.023), (380, 0.092)):
    spacing, scale, severity = found[drop, ell] = first_cracks(drop, ell)
    print(f"     drop {drop} K, l = {1000 * ell:g} um: severity {severity:.2f}, spacing {spacing:.3f} mm = {spacing / ell:.1f} l = "
          f"{spacing / scale:.1f} sqrt(l l_0)", flush=True)
    check_between("spacing over sqrt(l l_0)", spacing / scale, *((12, 15.5) if severity > 1.8 else (15.5, 23)))
check("spacing with the drop, exponent", math.log(found[600, 0.046][0] / found[380, 0.046][0]) / math.log(600 / 380), -1, 0.2)
check("spacing with l, exponent", math.log(found[380, 0.092][0] / found[380, 0.046][0]) / math.log(2), 0.5, 0.2)

r = run("whole", {}, files=[option_file("thermal_shock.opts")])
slab = crack_spacing.Slab(os.path.join(r.dir, "vis.xdmf"))
last = len(slab.times) - 1
numbers = [slab.count(last, depth)[0] for depth in (0.05, 0.1, 0.2, 0.3, 0.5)]
print("     cracks at 0.05, 0.1, 0.2, 0.3, 0.5 mm:", *numbers)
check_between("fewer cracks the deeper", numpy.diff(numbers).max(), -10, 0)
check_between("cracks near the surface", numbers[0], 7, 9)
check_between("half of them or less go on at 0.3 mm", numbers[3] / numbers[0], 0.2, 0.5)
check("first law", abs(r["balance_first_law"]).max(), 0, 1e-10, relative=False)
check_between("largest phi", r["phi_max"].max(), 0.99, 1 + 1e-12)
finish()
