# labels: run
"""All nodes of a body are driven, by displacement, velocity or acceleration, so that it moves as one: the reaction is its mass times the
acceleration at any time, to second order in the step (Newmark's method without damping, theory.md, 7)."""
import math

from _runs import check, check_between, finish, run

with open("bar.geo", "w") as file:
    file.write("""Point(1) = {0, 0, 0}; Point(2) = {100, 0, 0}; Point(3) = {100, 5, 0}; Point(4) = {0, 5, 0};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1}; Curve Loop(1) = {1 : 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = 11; Transfinite Curve {2, 4} = 2; Transfinite Surface {1}; Recombine Surface {1}; Physical Surface("bar") = {1};
""")
PERIOD, PEAK = 1e-3, 1e6
MASS = 8e-9 * 100 * 5
w = 2 * math.pi / PERIOD
motions = {"acceleration": f"{PEAK}*sin({w!r}*t)", "velocity": f"{PEAK}/{w!r}*(1 - cos({w!r}*t))",
           "displacement": f"{PEAK}*(t/{w!r} - sin({w!r}*t)/{w!r}^2)"}
for kind, motion in motions.items():
    errors = []
    for steps in (100, 200):
        r = run(f"{kind}_{steps}", {
            "mesh": "bar.geo", "units": "mm_t_s_MPa", "materials": "bar", "material_bar_E": 200e3, "material_bar_nu": 0, "material_bar_rho": 8e-9,
            "bcs": "drive", "bc_drive_on": "bar", "bc_drive_type": kind, "bc_drive_ux": motion, "bc_drive_uy": 0,
            "ts_dt": PERIOD / steps, "ts_max_time": PERIOD})
        errors.append(max(abs(r["reaction_drive_x"] - [MASS * PEAK * math.sin(w * t) for t in r["time"]])) / (MASS * PEAK))
    check(f"{kind}: largest error of the reaction over its amplitude, 200 steps", errors[1], 0, 1e-3, relative=False)
    check_between(f"{kind}: order of the error in the step", math.log2(errors[0] / errors[1]), 1.8, 2.6)
finish()
