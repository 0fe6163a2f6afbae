# labels: run
# timeout: 300
# long: 200
# processors: 1
"""Mortar contact: two blocks of non-matching meshes carry the uniform pressure of the closed form, with standard and
dual multipliers, by each enforcement, whatever the penalty, at any angle; equal bars exchange their velocities; a block
dropped on another one bounces with about as many Newton iterations as in free flight; the ranks do not matter."""
import math

import numpy
from _histories import difference
from _press import press
from _runs import check, check_between, finish, long, mesh, option_file, require, run

E, NU, PRESS = 1e6, 0.3, 0.02
TOP = 2 * PRESS
STRETCH, FORCE = press(E, NU, 1 - PRESS)
PRESSURE = FORCE / STRETCH
MORTAR = {"contact_face_method": "mortar"}


def patch(angle=0, cells=(5, 4)):
    """Both blocks compressed and stretched uniformly, turned by the angle."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    # Displacements along and across the interface of a point (x, y): (A - 1) xi and the press from above.
    along, across = f"({c!r}*x+{s!r}*y)", f"({c!r}*y-{s!r}*x)"

    def ends(xi, eta):
        return {"ux": f"({c!r}*({xi})-{s!r}*({eta}))*t", "uy": f"({s!r}*({xi})+{c!r}*({eta}))*t"}

    sides = f"{STRETCH - 1!r}*{along}"
    top, bottom = ends(sides, f"-{TOP!r}"), ends(sides, "0")
    return {
        "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": cells[0], "mesh_set_n_upper": cells[1],
        "mesh_set_angle": angle,
        "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU, "material_upper_like": "lower",
        "bcs": "plate,press", "bc_plate_on": "lower_bottom", "bc_press_on": "upper_top",
        **{f"bc_plate_{k}": v for k, v in bottom.items()}, **{f"bc_press_{k}": v for k, v in top.items()},
        "contacts": "face", "contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom",
        "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, **MORTAR,
    }


def uniform(name, r, tolerance):
    low, high = r["contact_face_pressure_min"][-1] / PRESSURE, r["contact_face_pressure_max"][-1] / PRESSURE
    check(f"pressure of the closed form at every node, {name}", max(high - 1, 1 - low), 0, tolerance, relative=False)
    return low, high


print(f"closed form: lateral stretch {STRETCH:.8f}, pressure {PRESSURE:.8g}")
for space in ("standard", "dual"):
    for angle, cells in ((0, (5, 4)), (0, (4, 9)), (33, (5, 4))):
        r = run(f"{space}_{angle}_{cells[1]}", {**patch(angle, cells), "contact_face_multipliers": space})
        uniform(f"{space}, angle {angle}, {cells[0]} on {cells[1]} facets", r, 1e-8)
        check_between("tries of the step", r["tries"].max(), 1, 1)
        check_between("Newton iterations", r["newton"][-1], 3, 9)
r = run("auglag", {**patch(), "contact_face_enforce": "auglag", "contact_face_gap_tol": 1e-9,
                   "contact_face_pressure_tol": 1e-8, "uzawa_snes_max_it": 100})
uniform("augmented Lagrangian", r, 1e-8)
r = run("penalty", {**patch(), "contact_face_enforce": "penalty"})
low, high = uniform("penalty, which is soft", r, 2e-2)
check("penalty: minus the smallest gap is p / eps", -r["contact_face_gap_min"][-1] * 10 * E * 5 / PRESSURE, 1, 0.05)
for factor in (0.1, 10, 100) if long() else (100,):
    r = run(f"factor_{factor}", {**patch(), "contact_face_penalty": factor * 10 * E * 5,
                                 "contact_face_penalty_max": 1e15})
    uniform(f"semismooth, {factor} times the automatic penalty", r, 1e-8)
    check_between("Newton iterations", r["newton"][-1], 3, 12)

if long():
    print("equal bars, undamped Newmark with the stabilised update")
    L, MODULUS, RHO, V, WIDTH = 0.1, 70e9, 2800.0, 2.0, 1e-3
    C = (MODULUS / RHO) ** 0.5
    PLATEAU = RHO * C * V / 2 * WIDTH
    MOMENTUM = RHO * L * WIDTH * V
    r = run("bars", {**MORTAR, "ts_newmark_rho": 1, "mesh_set_gap": 1e-2, "output_vis_every": 100000},
            files=[option_file("bars_impact.opts")])
    on = numpy.nonzero(r["contact_face_force_x"])[0]
    check("contact time 2 L/c", r["time"][on[-1]] - r["time"][on[0]], 2 * L / C, 0.02)
    start = 1e-5 / V
    middle = (r["time"] > start + L / (2 * C)) & (r["time"] < start + 3 * L / (2 * C))
    check("plateau rho c v A / 2, largest excursion", abs(-r["contact_face_force_x"][middle] / PLATEAU - 1).max(), 0, 0.02,
          relative=False)
    total = r["momentum_striker_x"] + r["momentum_target_x"]
    check("change of the total momentum, relative", abs(total / MOMENTUM - 1).max(), 0, 1e-10, relative=False)
    check("velocity of the target", r["momentum_target_x"][-1] / MOMENTUM, 1, 0.01)
    energy = r["energy_kinetic"] + r["energy_elastic"]
    check_between("largest energy over the energy at the start", energy.max() / energy[0], 0.97, 1 + 1e-9)
    check_between("energy at the end over the energy at the start", energy[-1] / energy[0], 0.97, 1)
    check_between("mean Newton iterations per step", r["newton"][1:].mean(), 0.5, 2.5)
    check_between("Uzawa passes of a step", r["uzawa"].max(), 1, 1)

print("a block dropped on a clamped one, 60 steps")
DROP = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 8, "mesh_set_n_upper": 7, "mesh_set_gap": 0.01,
    "materials": "lower,upper", "material_lower_E": 1e7, "material_lower_nu": 0.3, "material_lower_rho": 1000,
    "material_upper_like": "lower",
    "bcs": "hold,weight", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
    "bc_weight_on": "lower,upper", "bc_weight_type": "body_force", "bc_weight_uy": -10,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "ts_dt": 0.007, "ts_newmark_rho": 0.9, "ts_max_time": 0.42, **MORTAR,
}
runs = {ranks: run(f"drop_{ranks}", DROP, ranks=ranks) for ranks in ((1, 2, 3) if long() else (1, 2))}
r = runs[1]
pressed = r["contact_face_active"] > 0
bounces = numpy.count_nonzero(numpy.diff(pressed.astype(int)) == 1)
print(f"     {len(r['time']) - 1} steps, {bounces} contacts, most Newton iterations {r['newton'].max():.0f}")
check_between("contacts, with three bounces between the first four", bounces, 4, 6)
require("60 steps", len(pressed) == 61)
check_between("mean Newton iterations per step", r["newton"][1:].mean(), 1, 3)
check_between("tries of a step", r["tries"].max(), 1, 1)
check_between("smallest gap over a facet", numpy.nanmin(r["contact_face_gap_min"]) * 7, -1e-8, 1)
energy = r["energy_kinetic"] + r["energy_elastic"] - r["work_external"]
# In free flight too: the trapezoidal rule keeps the energy of linear bodies only.
check_between("largest rise of the energy over the work of the weight",
              numpy.diff(energy).max() / abs(r["work_external"]).max(), -1, 1e-3)
for ranks in (2, 3) if long() else (2,):
    worst, where = difference(r.history, runs[ranks].history, modulus=1e7)
    check(f"{ranks} ranks against 1, worst column {where}", worst, 0, 1e-8, relative=False)
finish()
