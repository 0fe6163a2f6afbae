# labels: run
# timeout: 180
"""What a contact must not depend on: the angle of the whole set-up, which side is the secondary one, on which rank each
body lies, the convergence criterion in use while nothing touches yet, and a step in which a body flies deep into the
other one."""
from math import cos, pi, sin

import numpy
from _runs import TWO_BLOCKS, check, check_between, finish, long, mesh, require, run

E, RHO, GAP, SPEED = 1e6, 1000.0, 0.0213, 1.0
DT = 2.5e-3
BASE = {
    "mesh": mesh("two_blocks.geo"), "mesh_set_n_lower": 4, "mesh_set_n_upper": 3, "mesh_set_gap": GAP,
    "mesh_set_inset": 0.1,
    "materials": "lower,upper", "material_lower_E": E, "material_lower_nu": 0.3, "material_lower_rho": RHO,
    "material_upper_like": "lower",
    "bcs": "hold", "bc_hold_on": "lower_bottom", "bc_hold_type": "fix",
    "ics": "flight", "ic_flight_on": "upper",
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "ts_dt": DT, "ts_max_time": 0.25,
    "contact_face_enforce": "penalty", "ts_newmark_rho": 0.9,
    # The default of the second, 1e-12 E h = 2.5e-7 N, leaves 1e-11 of the momentum in steps of several facets.
    "motion_snes_rtol": 1e-12, "motion_snes_atol": 1e-9, "motion_ksp_type": "preonly", "motion_pc_type": "lu",
}
SWAPPED = {"contact_face_secondary": "lower_top", "contact_face_primary": "upper_bottom"}


def flight(angle, extra=None, refused=0, **kwargs):
    turn = angle * pi / 180
    options = {**BASE, "mesh_set_angle": angle, "ic_flight_vx": repr(SPEED * sin(turn)),
               "ic_flight_vy": repr(-SPEED * cos(turn)), **(extra or {})}
    name = "run_" + "_".join(str(v) for v in (angle, *(extra or {}).values(), *kwargs.values()))
    return run("".join(c if c.isalnum() or c in "_." else "_" for c in name)[:80], options, refused=refused, **kwargs)


def impulse(r):
    return numpy.hypot(r["impulse_face_x"], r["impulse_face_y"])


def same(claim, a, b, tolerance):
    """Energies, gap and impulse of two runs, relative to each column's largest value."""
    if not require(f"{claim}: as many steps", len(a["time"]) == len(b["time"])):
        return
    worst = {}
    for column in ("energy_kinetic", "energy_elastic", "contact_face_gap_min", "contact_face_length"):
        scale = numpy.nanmax(abs(a[column]))
        worst[column] = numpy.nanmax(abs(a[column] - b[column])) / scale
        if (numpy.isnan(a[column]) != numpy.isnan(b[column])).any():
            worst[column] = numpy.inf
    worst["impulse"] = abs(impulse(a) - impulse(b)).max() / impulse(a).max()
    name = max(worst, key=worst.get)
    check(f"{claim}: largest difference, in {name}", worst[name], 0, tolerance, relative=False)


reference = flight(0)
momentum = -reference["momentum_upper_y"]
energy = reference["energy_kinetic"] + reference["energy_elastic"]
require("free flight first: nothing touches before the gap is closed",
        not reference["contact_face_active"][reference["time"] < GAP / SPEED - DT].any())
check_between("steps with contact", numpy.count_nonzero(reference["contact_face_active"]), 10, 95)
check_between("largest energy over that of the start", energy.max() / energy[0], 1, 1 + 1e-9)
check("impulse on the flying block is its change of momentum", impulse(reference)[-1], momentum[0] - momentum[-1],
      1e-12)

for angle in (30, 90) if long() else (30,):
    r = flight(angle)
    same(f"turned by {angle} degrees", reference, r, 1e-8)
    require("the same points are active", (r["contact_face_active"] == reference["contact_face_active"]).all())

# Touch within rounding at the end of a step: multipliers of rounding size must not keep the augmentations going.
r = flight(30, {"mesh_set_gap": 0.02, "contact_face_enforce": "auglag", "ts_max_steps": 40, "ts_max_time": 0.1})
check_between("touch exactly at a step: most tries", r["tries"].max(), 1, 1)
check("touch exactly at a step: the time that 40 steps reach", r["time"][-1], 0.1, 1e-9)

print("criteria of Newton's method one by one; none may end a step blind after the free flight")
for name, criterion in {"rtol": {"snes_rtol": 1e-9}, "atol": {"snes_rtol": 0, "snes_atol": 1e-5},
                        "rounding": {"snes_rtol": 0, "snes_atol": 0}}.items():
    same(f"-motion_snes_{name} decides", reference,
         flight(0, {f"motion_{key}": value for key, value in criterion.items()}), 1e-5)

swapped = flight(0, SWAPPED)
check("sides swapped: impulse", impulse(swapped)[-1], impulse(reference)[-1], 0.02)
check("sides swapped: impulse on the flying block is its change of momentum", impulse(swapped)[-1],
      swapped["momentum_upper_y"][-1] - swapped["momentum_upper_y"][0], 1e-12)

# The simple partitioner deals the cells out in their order: the lower block's 16 to one rank, the upper's to another.
even = {"mesh_set_n_upper": 4, "mesh_set_inset": 0.07}
same("each body on its own rank", flight(0, even),
     flight(0, {**even, "petscpartitioner_type": "simple"}, ranks=2), 1e-8)

# The rebound is elastic but for what the waves carry away; a body that is lost goes on with its momentum.
SPACE = {"mesh_set_dim": 3, "mesh_set_simplices_upper": 1}
MORTAR = {"contact_face_method": "mortar", "contact_face_enforce": "semismooth"}
SECOND = {"order": 2, "contact_face_method": "mortar"}
for facets, extra in ((1.2, {}), (2, {}), (3.2, SWAPPED), (5, {}),
                      (5, {"mesh_set_gap": 3.1, "contact_face_enforce": "penalty"}), (5, SWAPPED), (5, MORTAR),
                      (5, {**SPACE, **MORTAR}), (3.2, {**SPACE, **MORTAR, **SWAPPED}),
                      (5, {**SPACE, "contact_face_method": "gpts", "contact_face_enforce": "penalty"}),
                      (5, SECOND), (3.2, {**SECOND, **SWAPPED}), (5, {**SECOND, **MORTAR, **SWAPPED}))[:: 1 if long() else 3]:
    step = facets * 0.25 / SPEED
    r = flight(0, {"ts_dt": step, "ts_max_time": 6 * step, "contact_face_impact": "stabilised",
                   "contact_face_enforce": "auglag", **extra}, refused=2)
    before = -r["momentum_upper_y"][0]
    print(f"     v dt = {facets} facets {extra}: tries {r['tries'].max():.0f}, Newton at most {r['newton'].max():.0f}, "
          f"upward momentum {r['momentum_upper_y'][-1]:.4g}")
    check_between(f"fast body, v dt = {facets} facets: impulse", impulse(r)[-1], 0.9 * before, 2 * before)
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    check_between("largest energy over that of the start", energy.max() / energy[0], 1, 1 + 1e-9)
    # A solve leaves more of a facet's depth than of the first touch.
    check("impulse is the change of momentum", impulse(r)[-1], r["momentum_upper_y"][-1] - r["momentum_upper_y"][0],
          1e-12 if extra in ({}, SWAPPED) else 1e-8 if "mesh_set_gap" in extra else 1e-7)
    check_between("smallest gap", numpy.nanmin(r["contact_face_gap_min"]), -1e-3, 1)

# In one step from above the surface to below it, deep or shallow, and beside it: the way crosses no facet.
for method in ("mortar", "gpts"):
    for gap in (0.75, 1.2) if long() else (0.75 if method == "mortar" else 1.2,):
        r = flight(0, {"ts_dt": 1.25, "ts_max_time": 2.5, "mesh_set_gap": gap, "contact_face_enforce": "auglag",
                       "contact_face_method": method, "ic_flight_vx": 4})
        claim = f"fast body that passes beside, {method}, {1.25 - gap:.2f} deep"
        check(f"{claim}: impulse", impulse(r)[-1], 0, 0, relative=False)
        check(f"{claim}: its momentum stays", r["momentum_upper_y"][-1], r["momentum_upper_y"][0], 1e-12)
# Steps far shorter than a wave needs through a cell (h/c is 3e-3 s): the surface's mass resists, not its modulus, and
# augmentations with a penalty of 10 E/h alone shrink the gap by nothing.
short = run("short_steps", {**TWO_BLOCKS, "mesh_set_gap": 1e-4, "contact_face_enforce": "auglag", "motion_pc_type": "lu",
                            "ts_dt": 2e-5, "ts_max_time": 6e-4})
check_between("steps of h/150c: largest number of tries", short["tries"].max(), 1, 1)
check_between("steps of h/150c: largest number of Uzawa passes", short["uzawa"].max(), 2, 8)
require("steps of h/150c: the blocks touch", short["contact_face_active"].max() > 0)
finish()
