# labels: run
# timeout: 120
"""A flat rigid punch on a half plane, mortar: the way it sinks and the pressure of the closed form, with errors that fall
with the cells. The half plane's own displacements hold the outer sides of the mesh: a block that is held below and free
at its sides, as wide as twice its depth, gives way by 7.5 % more than the formula."""
import math

from _fields import pressed
from _runs import check, check_between, finish, option_file, run

E, NU, A, DEPTH, LOAD = 200e3, 0.3, 10.0, 200.0, 10e3
# Plane strain: E / (1 - nu^2) and nu / (1 - nu) in the formula of plane stress (Johnson, Contact Mechanics, 2.8).
WAY = LOAD * (1 - NU**2) / (math.pi * E) * (2 * math.log(2 * DEPTH / A) - (1 + NU / (1 - NU)))

print(f"closed form: way {WAY:.6f} mm, pressure in the middle {LOAD / (math.pi * A):.2f} MPa")
errors = []
for n in (10, 20, 40):
    r = run(f"punch_{n}", {"mesh_set_n": n, "ts_dt": 1}, files=[option_file("punch.opts")])
    x, _, p = pressed(r)
    middle = p[0] * math.pi * A / LOAD
    inner = x < A / 2
    profile = abs(p[inner] * math.pi * (A**2 - x[inner] ** 2) ** 0.5 / LOAD - 1).max()
    errors.append((1 + r["mean_press_uy"][-1] / WAY, 1 - middle))
    print(f"     {n} cells below the half punch: way {-r['mean_press_uy'][-1]:.6f}, middle {middle:.5f} F/(pi a), largest error "
          f"of the pressure up to a/2 {profile:.4f}, Newton iterations {r['newton'][1:]}")
    check(f"{n} cells: force of the contact, half of the load", r["contact_face_force_y"][-1], LOAD / 2, 1e-8)
    check_between(f"{n} cells: Newton iterations of a step", r["newton"].max(), 2, 8)
check("way of the punch, finest mesh", -r["mean_press_uy"][-1], WAY, 0.005)
check("pressure in the middle, finest mesh", p[0], LOAD / (math.pi * A), 0.01)
for k, what in enumerate(("way", "pressure in the middle")):
    for coarse, fine in zip(errors, errors[1:]):
        check_between(f"error of the {what} with cells of half the size over that before", fine[k] / coarse[k], 0.1, 0.6)
check("pressure up to a/2, largest error, finest mesh", profile, 0, 0.02, relative=False)
finish()
