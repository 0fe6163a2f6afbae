# labels: run
# timeout: 120
"""First longitudinal mode of a bar held at one end, strain 1e-9: the period of the trapezoidal rule is longer than the
exact one by w dt / (2 atan(w dt / 2)), where w belongs to the mesh (linear elements, consistent mass); the energy
stays."""
from math import atan, cos, pi, sin

import numpy
from _runs import check, finish, mesh, run

L, N, E, RHO = 0.1, 16, 70e9, 2800.0
C, H, K = (E / RHO) ** 0.5, L / N, pi / (2 * L)
OMEGA = C / H * (6 * (1 - cos(K * H)) / (2 + cos(K * H))) ** 0.5
STRAIN = 1e-9
AMPLITUDE = STRAIN / K
BASE = {
    "mesh": mesh("strip.geo"), "mesh_set_length": L, "mesh_set_width": H, "mesh_set_n": N, "mesh_set_n_width": 1,
    "materials": "bar", "material_bar_region": "strip", "material_bar_E": E, "material_bar_nu": 0,
    "material_bar_rho": RHO,
    "bcs": "hold", "bc_hold_on": "left", "bc_hold_ux": 0,
    "ics": "swing", "ic_swing_on": "strip", "ic_swing_vx": f"{AMPLITUDE * OMEGA!r}*sin({K!r}*x)",
    "measures": "tip", "measure_tip_on": "right", "measure_tip_fields": "u,v",
    # Forces at this strain are 1e-9 E h: the absolute tolerance, 1e-10 E h, would be too coarse.
    "motion_snes_atol": 0, "motion_snes_rtol": 1e-9,
    "motion_ksp_type": "preonly", "motion_pc_type": "lu",
}


def period(time, u):
    """Mean period of a sine that starts at zero and is sampled evenly."""
    step = time[1] - time[0]
    crossings = numpy.nonzero((u[1:-1] > 0) & (u[2:] <= 0))[0] + 1
    last = crossings[-1]
    # Between two samples of a sine the crossing is found from their phases, not by a straight line.
    angle = 2 * pi * step / (time[last] / (len(crossings) - 0.5))
    for _ in range(30):
        phase = numpy.arctan2(u[last] * sin(angle), u[last] * cos(angle) - u[last + 1])
        value = (time[last] + phase / angle * step) / (len(crossings) - 0.5)
        angle = 2 * pi * step / value
    return value


check("frequency of the mesh, linear elements and exact 12500 Hz", OMEGA / (2 * pi), 12500, 1e-3)
for x, elongation in ((0.1, 1.00083278), (0.2, 1.00332449), (0.4, 1.01319402)):
    assert abs(elongation - x / (2 * atan(x / 2))) < 1e-8
    r = run(f"step_{x}", {**BASE, "ts_dt": x / OMEGA, "ts_max_time": 5.7 * 2 * pi / OMEGA})
    u = r["measure_tip_ux"]
    check(f"period elongation at w dt = {x}", period(r["time"], u) * OMEGA / (2 * pi), elongation, 2e-7)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check(f"energy drift at w dt = {x}", abs(energy / energy[0] - 1).max(), 0, 1e-10, relative=False)
    check(f"amplitude at w dt = {x}", abs(u).max() / AMPLITUDE, 1, 1.3 * x * x / 8)
finish()
