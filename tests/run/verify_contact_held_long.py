# labels: long
# timeout: 3600
"""Static bodies that contact alone holds, the whole matrix: cylinder and sphere on a block against Hertz and a stack of
three blocks, at steps of 1/20 and 1/1 of the load, both methods, all enforcements, without and with friction, 1 and 2
ranks. A penalty of 10 E/h lets the surfaces in by its pressure over it, which spreads the load: 4 % hold it too."""
import math

from _held import LOAD, METHODS, R, SPHERE, STAR, cylinder, hertz_error, stack
from _runs import check, check_between, finish, run

STEPS = (1, 0.05)


def settle(what, r, total):
    check_between(f"{what}: Newton iterations of the first step", r["newton"][1], 1, 25)
    check(f"{what}: force", r["contact_touch_force_y"][-1], total, 1e-6)
    check(f"{what}: balance", abs(r["balance"]).max(), 0, 1e-9, relative=False)


for method, enforce in METHODS:
    for dt in STEPS:
        for friction in (0, 0.3):
            for ranks in (1, 2):
                name = f"{method}_{enforce}_{dt}_{friction}_{ranks}"
                what = f"{method} {enforce}, step {dt}, friction {friction}, {ranks} ranks"
                settle("cylinder " + what, cylinder("cylinder_" + name, method, enforce, friction,
                                                    extra={"ts_dt": dt}, ranks=ranks), LOAD / 2)
                check_between(f"cylinder {what}: pressure over Hertz's", hertz_error("cylinder_" + name), 0.96, 1.04)
                r = stack("stack_" + name, method, enforce, friction, extra={"ts_dt": dt}, ranks=ranks)
                check(f"stack {what}: lower force over the weight", r["contact_lower_force_y"][-1] / 4.4145e-3, 1, 1e-6)
                check(f"stack {what}: balance", abs(r["balance"]).max(), 0, 1e-9, relative=False)
                r = run("sphere_" + name, {**SPHERE, "contact_touch_method": method, "contact_touch_enforce": enforce,
                                           "contact_touch_friction": friction, "ts_dt": dt}, ranks=ranks)
                load = r["reaction_ground_y"][-1]  # of the traction on the faceted top
                settle("sphere " + what, r, load)
                width = (3 * 4 * load * R / 4 / STAR) ** (1 / 3)
                error = hertz_error("sphere_" + name, 1.5 * 4 * load / (math.pi * width**2), width)
                check_between(f"sphere {what}: pressure over Hertz's", error, 0.96, 1.04)
finish()
