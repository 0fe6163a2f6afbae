# labels: run
# timeout: 180
# long: 200
"""One touch by every contact method, set of multipliers, enforcement and impact update that the program's own reference
names, in the plane (strain and stress) and in space, with and without friction: two free blocks, of which the upper one
falls and slides on the lower one. What is new in the reference is tried without a word here. The long form takes all of them together,
the other every fourth: each value once at least."""
import itertools
import re
import subprocess

import numpy
from _runs import ENVIRONMENT, PROGRAM, check, check_between, finish, long, mesh, require, run

REFERENCE = subprocess.run([PROGRAM, "-reference"], stdout=subprocess.PIPE, text=True, env=ENVIRONMENT).stdout
MU = 0.3
BASE = {
    "mesh_set_n_lower": 2, "mesh_set_n_upper": 2, "mesh_set_gap": 0.01, "mesh_set_inset": 0.07, "materials": "lower,upper",
    "material_lower_E": 1e6, "material_lower_nu": 0.3, "material_lower_rho": 1000, "material_upper_like": "lower",
    "ics": "flight", "ic_flight_on": "upper", "ic_flight_vx": 1, "ic_flight_vy": -1,
    "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
    "ts_dt": 4e-3, "ts_max_time": 0.02, "motion_snes_rtol": 1e-11, "motion_snes_atol": 1e-9,
}


def values_of(option):
    """What the option allows, without auto."""
    row = re.search(rf"^\| `-contact_<id>_{option}` \|[^|]*\|([^|]*)\|", REFERENCE, re.M)
    return [value.strip() for value in row.group(1).split(",") if value.strip() != "auto"]


meshes = {}
for dim in (2, 3):
    run(f"mesh_{dim}", {**BASE, "mesh": mesh("two_blocks.geo"), "mesh_set_dim": dim, "dry_run": "on"})
    meshes[dim] = f"mesh_{dim}/two_blocks.msh"

FORMS = [{"method": method, **more} for method in values_of("method")
         for more in ([{"multipliers": kind} for kind in values_of("multipliers")] if method == "mortar" else [{}])]
IMPACTS = values_of("impact")
FRAMES = {"dim": 2}, {"dim": 3}, {"dim": 2, "plane": "stress"}
EXPLICIT = {"ts_type": "central_difference", "ts_dt": "auto", "ts_dt_cfl": 0.2}
implicit = [enforce for enforce in values_of("enforce") if enforce != "impulse"]
# The updates take turns, so that each meets every form, enforcement and friction.
cases = [(frame, form, enforce, friction, IMPACTS[(place + place // len(IMPACTS)) % len(IMPACTS)], {})
         for place, (frame, form, enforce, friction) in enumerate(itertools.product(FRAMES, FORMS, implicit, (0, MU)))]
cases += [(frame, {"method": "gpts"}, enforce, friction, "none", EXPLICIT)
          for frame, enforce, friction in itertools.product(FRAMES, ("penalty", "impulse"), (0, MU))]
tried, refused = set(), 0
for frame, form, enforce, friction, impact, steps in cases[slice(None) if long() else slice(1, None, 4)]:
    dim = frame["dim"]
    sheet = "plane" in frame
    if sheet and friction == 0:
        continue
    settings = {**form, "enforce": enforce, "impact": impact, "friction": friction}
    name = "_".join(["explicit"] * bool(steps) + ["stress" if sheet else str(dim), *map(str, settings.values())])
    options = {**BASE, **steps, "mesh": meshes[dim], **({"plane": "stress"} if sheet else {}),
               **{f"contact_face_{key}": value for key, value in settings.items()}}
    for key in [k for k in options if k.startswith("mesh_set_")]:
        del options[key]
    r = run(name, options, code=None)
    if r.code == 2 and "impact: -contact_face_impact: `conserving` is for the penalty" in r.log:
        refused += 1
        r = run(name, {**options, "contact_face_impact": "auto"})
        impact = "auto"
    if not require(f"{name}: ends with status 0", r.code == 0):
        continue
    tried |= {*form.values(), enforce, impact}
    momentum = {side: numpy.array([r[f"momentum_{side}_{axis}"] for axis in "xyz"[:dim]]).T for side in ("lower", "upper")}
    whole = numpy.linalg.norm(momentum["upper"][0])
    normal, slide = momentum["lower"][-1][1], momentum["lower"][-1][0]
    good = [check_between(f"{name}: points or nodes in contact", r["contact_face_active"].max(), 2, 1000),
            check(f"{name}: what both momenta add up to", abs(sum(momentum.values()) - momentum["upper"][0]).max() / whole, 0,
                  1e-9, relative=False),
            check_between(f"{name}: what the lower block is given, down, over the momentum", -normal / whole, 0.05, 0.8)]
    # It is rubbed to the right by no more than Coulomb's part of that, without friction by what turns of the sides allow.
    turn = 1e-3 if steps else 1e-9
    if friction:
        check_between(f"{name}: what friction gives it, over Coulomb's part", slide / (-normal * friction), 0.5, 1 + turn)
    else:
        check_between(f"{name}: what it is pushed aside, over what it is pushed down", slide / -normal, -1e-3, 1e-3)
    energy = r["energy_kinetic"] + r["energy_elastic"] + r["energy_contact"]
    # Explicit steps meet the kink of a penalty's force within a step, now to the one side and now to the other.
    kink = 1e-3 if steps and enforce == "penalty" else 1e-9
    check_between(f"{name}: largest energy over that of the start", energy.max() / energy[0], 0.9, 1 + kink)
missing = {value for option in ("method", "multipliers", "enforce", "impact") for value in values_of(option)} - tried
require(f"every value was tried, {len(tried)} of them ({refused} pairs are refused by the options); not: {sorted(missing)}",
        not missing)
finish()
