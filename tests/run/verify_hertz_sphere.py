# labels: run
# timeout: 240
# long: 240
"""Hertz: a quarter of a steel half sphere pressed on a rigid plane in space (options/hertz_sphere.opts). Force at the
given approach, largest pressure, radius of contact and the pressure over it against the closed form; the error falls
under refinement, and faces of six nodes twice as large do as well; an augmented Lagrangian gives the same from penalties a
thousandfold apart."""
import os
import sys

import numpy
from _runs import check, check_between, finish, long, option_file, run

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools"))
from fields import Fields  # noqa: E402

R, E, NU, APPROACH = 10.0, 210e3, 0.3, 2.194e-3
STAR = E / (1 - NU**2)
FORCE = 4 / 3 * STAR * R**0.5 * APPROACH**1.5
RADIUS = (R * APPROACH) ** 0.5
PEAK = 1.5 * FORCE / (numpy.pi * RADIUS**2)
print(f"Hertz: force {FORCE:.5g} N, radius {RADIUS:.4g} mm, largest pressure {PEAK:.5g} MPa")


def sphere(name, near, extra=None, ranks=2):
    return run(name, {"mesh_set_near": near, "output_vis_times": 1, **(extra or {})},
               files=[option_file("hertz_sphere.opts")], ranks=ranks)


def pressures(name):
    """Distance from the axis and pressure of the nodes on the sphere, by distance."""
    fields = Fields(os.path.join(name, "vis.xdmf"))
    x = fields.places(fields.grids[0])
    p = fields.field(fields.grids[-1], "contact_pressure")[0][:, 0]
    r = numpy.hypot(x[:, 0], x[:, 2])
    order = numpy.argsort(r)
    on_sphere = abs(numpy.hypot(r, x[:, 1] - R) - R) < 1e-6 * R
    near = order[(r[order] < 1.5 * RADIUS) & on_sphere[order] & (x[order, 1] < R)]
    return r[near], p[near]


errors = []
# Of second order: twice the size, by mortar and at Gauss points.
for near, extra in ((0.12, {"order": 2, "contact_foot_method": "mortar"}), (0.12, {"order": 2, "contact_foot_method": "gpts"}),
                    (0.06, {}), (0.025, {})):
    name = f"near_{near}_{extra.get('contact_foot_method', '')}"
    r = sphere(name, near, extra)
    force = 4 * r["contact_foot_force_y"][-1]
    at, p = pressures(name)
    hertz = PEAK * numpy.sqrt(numpy.maximum(0, 1 - (at / RADIUS) ** 2))
    peak = (p * hertz).sum() / (hertz**2).sum()  # of the profile that fits best
    scatter = numpy.sqrt(numpy.mean((p - hertz)[at < RADIUS] ** 2)) / PEAK
    radius = numpy.sqrt(4 * r["contact_foot_length"][-1] / numpy.pi)
    print(f"     {RADIUS / near:.1f} cells over the radius: force {force / FORCE:.4f}, pressure {peak:.4f} (in the middle {p[0] / PEAK:.4f}),"
          f" radius {radius / RADIUS:.4f} of Hertz, pressure {scatter:.3f} off in the mean, {r['newton'].max():.0f} Newton iterations")
    errors.append((abs(force / FORCE - 1), scatter))
mortar, gpts, *errors = errors
for method, curved in (("mortar", mortar), ("Gauss points", gpts)):
    for what, i in (("force", 0), ("pressure", 1)):
        check_between(f"{what}: error of faces of six nodes by {method} over that of straight ones of half the size",
                      curved[i] / errors[0][i], 0, 0.6 if method == "mortar" else 1)
check("force", force, FORCE, 0.05)
check("largest pressure of the profile that fits best, over Hertz", peak, 1, 0.05)
check("radius of contact, from the closed area", radius, RADIUS, 0.05)
check_between("mean error of the pressure over the largest one", scatter, 0, 0.1)
check_between("force: error on the finer mesh over that on the coarser one", errors[1][0] / errors[0][0], 0, 0.8)
check_between("pressure: error on the finer mesh over that on the coarser one", errors[1][1] / errors[0][1], 0, 0.8)
check_between("Newton iterations of a step", r["newton"].max(), 3, 25)
check_between("tries of a step", r["tries"].max(), 1, 1)

print("augmented Lagrangian from other penalties, 0.06 mm cells")
reference = None
for factor in (0.1, 1, 10, 100)[:: 1 if long() else 3]:
    penalty = factor * 10 * E / 0.06
    s = sphere(f"factor_{factor}", 0.06, {
        "contact_foot_enforce": "auglag", "contact_foot_penalty": penalty, "contact_foot_penalty_max": 1e12,
        "contact_foot_gap_tol": 1e-8, "contact_foot_pressure_tol": 1e-5,
        "uzawa_snes_max_it": 30}, ranks=1)
    force = s["contact_foot_force_y"][-1]
    reference = force if reference is None else reference
    print(f"     {factor} of the automatic one: {s['newton'].max():.0f} Newton iterations of a step")
    # Solves that end early may want another augmentation; what they cost is Newton iterations.
    check_between(f"penalty {factor} of the automatic one: augmentations of a step", s["uzawa"].max() - 1, 2, 12)
    check_between(f"penalty {factor} of the automatic one: Newton iterations of a step", s["newton"].max(), 4, 20)
    check(f"penalty {factor} of the automatic one: force against the first", force, reference, 1e-6)
finish()
