# labels: run
# timeout: 120
# processors: 1
"""options/thermal_shock.opts: the skin before it cracks against an independent solution, and a coarse slab that cracks. The spacing of cracks
is measured by verify_thermal_shock_long.py."""
import math
import os
import sys

import numpy
from _runs import SOURCE, check, check_between, finish, option_file, require, run

sys.path.insert(0, os.path.join(SOURCE, "tools"))
import crack_spacing  # noqa: E402

E, GC, ELL, ALPHA, DIFFUSIVITY = 340e3, 42.47e-3, 0.046, 8e-6, 31 / 3.5  # of the file; mm, N, s


def skin(drop, t, depth, n=600):
    """phi over the depth where it is uniform along the surface: the minimum over phi >= 0 of the integral of
    (1 - phi)^2 E (alpha d)^2/2 + 3 Gc/8 (phi/l + l phi'^2) with d = drop erfc(y/2 sqrt(D t)), a sheet in uniaxial stress that may not
    shrink along the surface. Linear elements, lumped; active sets."""
    y = numpy.linspace(0, depth, n + 1)
    mass = numpy.full(n + 1, y[1])
    mass[[0, -1]] /= 2
    psi = 0.5 * E * (ALPHA * drop * numpy.array([math.erfc(v / 2 / math.sqrt(DIFFUSIVITY * t)) for v in y]))**2
    K = numpy.diag(2 * psi * mass)
    for i in range(n):
        K[i:i + 2, i:i + 2] += 0.75 * GC * ELL / y[1] * numpy.array([[1, -1], [-1, 1]])
    f = mass * (2 * psi - 3 * GC / 8 / ELL)
    phi, held = numpy.zeros(n + 1), f <= 0
    for _ in range(100):
        phi[:] = 0
        phi[~held] = numpy.linalg.solve(K[numpy.ix_(~held, ~held)], f[~held])
        now = numpy.where(held, K @ phi - f > -1e-13 * abs(f).max(), phi < -1e-13)
        if (now == held).all():
            energy = numpy.trapezoid if hasattr(numpy, "trapezoid") else numpy.trapz
            return phi[0], energy(3 * GC / 8 * (phi / ELL + ELL * numpy.gradient(phi, y)**2), y)
        held = now
    sys.exit("the active sets do not settle")


# A strip too narrow for cracks: 40 steps of heat in cells of 3 um.
with open("strip.geo", "w") as file:
    file.write("""Point(1) = {0, 0, 0}; Point(2) = {0.01, 0, 0}; Point(3) = {0.01, 0.3, 0}; Point(4) = {0, 0.3, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 2; Transfinite Curve {2, 4} = 101; Transfinite Surface {1}; Recombine Surface {1};
Physical Surface("slab") = {1};
Physical Curve("bottom") = {1}; Physical Curve("right") = {2}; Physical Curve("cold") = {3}; Physical Curve("left") = {4};
""")
DROP = 380
r = run("strip", {"mesh": "strip.geo", "ts_times": "0,1e-5,4e-5", "ts_dts": "2.5e-7,7.5e-7", "output_vis_times": 4e-5,
                  "coupling_snes_atol": 1e-6, "measures": "skin", "measure_skin_on": "cold", "measure_skin_fields": "phi"},
        files=[option_file("thermal_shock.opts")])
phi, energy = skin(DROP, 4e-5, 0.3)
check("phi of the surface before it cracks", r["measure_skin_phi"][-1], phi, 1e-3)
check("energy of the damage", r["energy_fracture"][-1], 0.01 * energy, 1e-3)
check("first law", abs(r["balance_first_law"]).max(), 0, 1e-10, relative=False)
r = run("strip_none", {"mesh": "strip.geo", "ts_times": "0,1e-5,4e-5", "ts_dts": "5e-6,1e-5", "param_drop": 100, "output_vis_times": 4e-5},
        files=[option_file("thermal_shock.opts")])
check("100 K colder, below the strength: damage", r["phi_max"].max(), 0, 0, relative=False)

# A coarse slab.
r = run("slab", {"mesh_set_width": 1.5, "mesh_set_depth": 0.6, "mesh_set_fine": 0.15, "mesh_set_h": 0.023, "param_drop": 480,
                 "ts_times": "0,1.2e-4,4e-4", "ts_dts": "1e-5,4e-5", "output_vis_times": "1e-5,4e-5,1.2e-4,4e-4"},
        files=[option_file("thermal_shock.opts")])
slab = crack_spacing.Slab(os.path.join(r.dir, "vis.xdmf"))
last = len(slab.times) - 1
require("cracks run in from the surface", slab.count(last, ELL)[0] >= 3)
check_between("their spacing over that of the long study", slab.spacing(last, ELL / 2) / 0.26, 0.7, 1.5)
check("none before", slab.count(1, 0)[0], 0, 0, relative=False)
before = None
for k in range(last + 1):
    phi = slab.fields.field(slab.fields.grids[k], "phi")[0][:, 0]
    if k:
        check_between(f"t = {slab.times[k]:g}: smallest growth of phi at a node", (phi - before).min(), 0, 1)
    check_between(f"t = {slab.times[k]:g}: largest phi", phi.max(), 0, 1 + 1e-12)
    before = phi
check("first law of the slab", abs(r["balance_first_law"]).max(), 0, 1e-10, relative=False)
finish()
