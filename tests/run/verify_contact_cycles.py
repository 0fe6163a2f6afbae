# labels: run
# timeout: 120
# long: 200
# processors: 1
"""Newton's method with contact that does not come to rest: where a primary surface ends above a gap the force of mortar
jumps, and iterations that begin with one squashed layer of cells go round in circles; those whose first one moves the
whole body do not, and end at the pressure of the closed form. More constraints than a surface can meet leave gaps that no pressure
closes, which count as closed below 1e-6 of a facet."""
import re

import numpy
from _press import press
from _runs import check, check_between, finish, long, mesh, require, run

E, NU, SQUEEZE = 1e6, 0.3, 0.02
STRETCH, FORCE = press(E, NU, 1 - SQUEEZE)
SHOW = {"motion_snes_monitor": "", "motion_snes_converged_reason": ""}


def solves(log):
    """Norms of the residuals of each solve of the motion, and how it ended."""
    norms = []
    for line in log.splitlines():
        if norm := re.search(r"^ +\d+ SNES Function norm (\S+)", line):
            norms.append(float(norm[1]))
        if end := re.search(r"motion_ solve .* due to (\w+) iterations", line):
            yield norms, end[1]
            norms = []


def period(norms):
    """Of the circle in which a list of norms ends, 0: none."""
    for n in range(2, len(norms) // 2 + 1):
        if all(abs(norms[-i] - norms[-i - n]) < 0.05 * norms[-i] for i in range(1, n + 1)):
            return n
    return 0


print("two blocks squeezed by mortar and augmentations: the sides of both end at the same place")
r = run("kink", {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 5, "mesh_set_n_upper": 4,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": NU, "material_upper_like": "lower",
    "bcs": "plate,press", "bc_plate_on": "lower_bottom", "bc_plate_ux": f"{STRETCH - 1!r}*x*t", "bc_plate_uy": 0,
    "bc_press_on": "upper_top", "bc_press_ux": f"{STRETCH - 1!r}*x*t", "bc_press_uy": f"-{2 * SQUEEZE!r}*t",
    "contacts": "face", "contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom",
    "contact_face_method": "mortar", "contact_face_enforce": "auglag", "contact_face_gap_tol": 1e-9,
    "contact_face_pressure_tol": 1e-8, "uzawa_snes_max_it": 100,
    "ts_type": "static", "ts_dt": 1, "ts_max_time": 1, **SHOW})
require("no solve goes round in a circle",
        all(end.startswith("CONV") and period(norms) == 0 for norms, end in solves(r.log)))
check_between("pressure of the closed form at every node, smallest", r["contact_face_pressure_min"][-1] * STRETCH / FORCE,
              1 - 1e-8, 1 + 1e-8)
check_between("largest", r["contact_face_pressure_max"][-1] * STRETCH / FORCE, 1 - 1e-8, 1 + 1e-8)
check_between("most iterations of a solve, both ways", r["newton_most"].max(), 3, 12)

print("a notch that closes: two constraints per facet and the multipliers of the semismooth method")
NOTCH = {
    "mesh": mesh("notch.geo"), "mesh_set_wedge": 1, "materials": "block", "material_block_E": 1000,
    "material_block_nu": 0.3, "bcs": "left,right", "bc_left_on": "left", "bc_left_ux": 0, "bc_left_uy": 0,
    "bc_right_on": "right", "bc_right_ux": "-0.25*t", "bc_right_uy": 0,
    "contacts": "skin", "contact_skin_secondary": "skin", "contact_skin_primary": "skin",
    "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 0.3,
}
runs = {method: run(method, {**NOTCH, "contact_skin_method": method, "contact_skin_enforce": "semismooth", **SHOW})
        for method in ("gpts", "mortar")}
for method, r in runs.items():
    require(f"{method}: every solve ends in balance", all(end.startswith("CONV") for _, end in solves(r.log)))
check_between("Gauss points leave gaps, over a facet of 0.1", -runs["gpts"]["contact_skin_gap_min"].min() / 0.1, 0, 1e-6)
check("force against mortar", runs["gpts"]["reaction_right_x"][-1], runs["mortar"]["reaction_right_x"][-1], 1e-3)
print("a slender beam bends over a cylinder: the set goes round in a circle longer than a solve, at any step")
ROUND, LENGTH, HEIGHT, TIP = 1.0, 3.0, 0.02, 0.8
STIFF, BEND = 1e6 * HEIGHT**3 / 12, ROUND + HEIGHT / 2


def free_end(lies, points=400):
    """Of an elastica that lies on the cylinder over that length, under the force at its tip: slope of its angle, and place, at the tip."""
    y = numpy.array([BEND * numpy.sin(lies / BEND), BEND * (numpy.cos(lies / BEND) - 1), -lies / BEND, -1 / BEND])
    h = (LENGTH - lies) / points

    def rate(y):
        return numpy.array([numpy.cos(y[2]), numpy.sin(y[2]), y[3], TIP * numpy.cos(y[2]) / STIFF])

    for _ in range(points):
        a = rate(y)
        b = rate(y + h / 2 * a)
        c = rate(y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + rate(y + h * c))
    return y[3], y[1]


low, high = 0.0, 1.5
for _ in range(50):
    low, high = ((low + high) / 2, high) if free_end((low + high) / 2)[0] > 0 else (low, (low + high) / 2)
down = free_end(low)[1]
for dt in (0.1, 0.02) if long() else (0.1,):
    r = run(f"wrapped_{dt}", {
        "mesh": mesh("block.geo"), "mesh_set_lx": LENGTH, "mesh_set_ly": HEIGHT, "mesh_set_n": 300, "mesh_set_ny": 2, "materials": "beam",
        "material_beam_region": "solid", "material_beam_E": 1e6, "material_beam_nu": 0, "material_beam_locking": "none", "bcs": "clamp,force",
        "bc_clamp_on": "left", "bc_clamp_type": "fix", "bc_force_on": "right", "bc_force_type": "force", "bc_force_uy": f"(-{TIP}*t)",
        "contacts": "face", "contact_face_secondary": "bottom", "contact_face_primary": "rigid_cylinder", "contact_face_centre": "0,-1",
        "contact_face_radius": ROUND, "ts_type": "static", "ts_dt": dt, "ts_max_time": 1}, refused=None)
    check(f"steps of {dt}: the tip goes down as that of the elastica ({-down:.4f}), linear cells", r["mean_force_uy"][-1], down, 0.01)
    check_between(f"steps of {dt}: steps made", len(r["time"]) - 1, 10, 125)

print("leaves of a spring that lie on each other: from one iteration to the next a node or two lift, and where the norms alternate no set comes again")
LEAVES = {"mesh": mesh("leaf_spring.geo"), "units": "mm_t_s_MPa", "plane": "stress", "materials": "lower,upper", "material_lower_E": 200000,
          "material_lower_nu": 0.3, "material_upper_like": "lower", "bcs": "clamp,tip", "bc_clamp_on": "lower_left,upper_left", "bc_clamp_type": "fix",
          "bc_tip_on": "tip", "bc_tip_uy": "-0.5*t", "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
          "ts_type": "static", "ts_dt": 0.5, "ts_max_time": 1}
TWO = 2 * 3 * 200000 * (2**3 / 12) / 100**3 * 0.5  # Bernoulli's, N
for dt in 0.5, 0.01:
    r = run(f"leaves_{dt}", {**LEAVES, "ts_dt": dt, "ts_max_time": 2 * dt})
    check(f"steps of {dt}: force at the tip, linear cells", -r["reaction_tip_y"][-1], 2 * dt * TWO, 0.15)
    check_between(f"steps of {dt}: most iterations of a solve", r["newton_most"].max(), 3, 150)
for lower, upper, order in (90, 100, 1), (100, 100, 1), (100, 100, 2):
    r = run(f"leaves_{lower}_{upper}_{order}", {**LEAVES, "mesh_set_n_lower": lower, "mesh_set_n_upper": upper, "order": order})
    check(f"{lower} facets below {upper}, order {order}: force at the tip", -r["reaction_tip_y"][-1], TWO, 0.15 if order == 1 else 0.01)
    check_between(f"{lower} facets below {upper}, order {order}: most iterations of a solve", r["newton_most"].max(), 3, 40)
few = run("few", {**LEAVES, "motion_snes_max_it": 5}, code=5, refused=None)
require("with few iterations the message names the contact and what may do", "contact face may not come to rest: try -contact_face_enforce auglag" in few.log)
finish()
