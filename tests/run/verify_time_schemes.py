# labels: run
# timeout: 120
"""A run that goes on from a checkpoint with another -ts_type: loaded statically, then let go; each way between the schemes.
The motion is that of a run which starts from the same displacement, and the energies go on."""
import glob
import re
import subprocess

import numpy

from _runs import ENVIRONMENT, PROGRAM, check, check_between, finish, mesh, require, run

# A bar of length 10 on rails, pulled to a strain of 1e-4: the static solution is u = strain x.
STRAIN, LENGTH, E, RHO = 1e-4, 10.0, 1000.0, 1.0
SPEED = (E / RHO) ** 0.5
BAR = {"mesh": mesh("block.geo"), "mesh_set_lx": LENGTH, "mesh_set_ly": 0.5, "mesh_set_n": 40, "mesh_set_ny": 2,
       "materials": "solid", "material_solid_E": E, "material_solid_nu": 0, "material_solid_rho": RHO,
       "bcs": "wall,rails", "bc_wall_on": "left", "bc_wall_ux": 0, "bc_rails_on": "solid", "bc_rails_uy": 0}
PULLED = {**BAR, "bcs": "wall,rails,pull", "bc_pull_on": "right", "bc_pull_ux": f"{STRAIN * LENGTH}*t"}
CHANGED = "ts_type,bcs,bc_pull_on,bc_pull_type,bc_pull_ux"
SCHEMES = {"newmark": {"ts_type": "newmark", "ts_dt": 2e-3}, "central_difference": {"ts_type": "central_difference", "ts_dt": 2e-3}}
STATIC = {"ts_type": "static", "ts_dt": 1, "ts_max_time": 1}


def last_checkpoint(of):
    return max(glob.glob(f"{of.dir}/checkpoints/*.h5"))


def go_on(name, before, options, allow, end, **more):
    return run(name, {**options, "restart": last_checkpoint(before), "restart_allow": allow,
                      "ts_max_time": before["time"][-1] + end}, **more)


loaded = run("loaded", {**PULLED, **STATIC})
energy = loaded["energy_elastic"][-1]
check("elastic energy of the pulled bar", energy, 0.5 * E * STRAIN ** 2 * LENGTH * 0.5, 1e-3)
let_go = {}
for scheme, options in SCHEMES.items():
    afresh = run(f"afresh_{scheme}", {**BAR, **options, "ics": "stretch", "ic_stretch_on": "solid", "ic_stretch_ux": f"{STRAIN}*x",
                                      "ts_max_time": 0.64})
    after = let_go[scheme] = go_on(f"after_{scheme}", loaded, {**BAR, **options}, CHANGED, 0.64)
    rows = len(after["time"])
    for column in ("energy_kinetic", "energy_elastic", "energy_numerical"):
        if column not in after.history:
            continue
        worst = numpy.abs(after[column] - afresh[column][-rows:]).max() / energy
        check(f"{scheme} from statics: {column} as from the displacement", worst, 0, 1e-8, relative=False)
    # All of the energy is motion when the wave of the free end has come to the wall.
    at = numpy.argmin(abs(after["time"] - 1 - LENGTH / SPEED))
    check_between(f"{scheme}: share of motion after L/c", after["energy_kinetic"][at] / energy, 0.95, 1.0)
    check(f"{scheme}: first law", after["balance_first_law"][-1], 0, 1e-3, relative=False)

# Statics know no erosion: a run that goes on with it starts with all cells there.
eroding = go_on("eroding", loaded, {**BAR, **SCHEMES["central_difference"], "material_solid_erosion": "on"},
                CHANGED + ",material_solid_erosion", 0.1)
plain = let_go["central_difference"]
check("with erosion: the same motion", eroding["energy_kinetic"][-1], numpy.interp(eroding["time"][-1], plain["time"], plain["energy_kinetic"]), 1e-6)
lost = run("lost", {**BAR, "ts_type": "newmark", "ts_dt": 2e-3, "restart": last_checkpoint(eroding), "ts_max_time": 2,
                    "restart_allow": "ts_type,material_solid_erosion"}, code=None)
require("what has left is not forgotten: without erosion it is refused", lost.code == 4 and "eroded (cell_point, 1)" in lost.log)

# The history of another scheme has other columns: it is left as it is, before the first step.
before, there = open("loaded/history.csv").read(), last_checkpoint(loaded)
words = [f"-{key} {value}" for key, value in {**BAR, **SCHEMES["central_difference"], "restart": "auto", "restart_allow": CHANGED,
                                              "ts_max_time": 1.1, "output_dir": "loaded"}.items()]
other = subprocess.run([PROGRAM, *" ".join(words).split()], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=ENVIRONMENT)
require("the history of another scheme is not continued",
        other.returncode == 4 and "it has no column energy_numerical" in other.stdout and "contact or -ts_type that" in other.stdout)
require("nor changed, and no step made", open("loaded/history.csv").read() == before and last_checkpoint(loaded) == there)

# From one scheme to the other and back: what vibrates goes on.
ways = [("newmark", "central_difference"), ("central_difference", "newmark")]
for first, second in ways:
    other = go_on(f"{first}_then", let_go[first], {**BAR, **SCHEMES[second]}, "ts_type", 0.5)
    total = (other["energy_kinetic"] + other["energy_elastic"]) / energy
    # The mass is lumped in the one and not in the other.
    check_between(f"{first}, then {second}: motion and strain", total[0], 0.99, 1.01)
    check(f"{first}, then {second}: change of motion and strain", total.max() - total.min(), 0, 5e-4, relative=False)
    check(f"{first}, then {second}: balance of momentum", abs(other["balance"]).max(), 0, 1e-10, relative=False)

# To rest: statics have no motion, whose energy the change of scheme takes.
rest = go_on("rest", let_go["newmark"], {**BAR, "ts_type": "static", "ts_dt": 1}, "ts_type", 1)
before = let_go["newmark"]
check("at rest: energy of motion that was there is the integrator's loss",
      (rest["dissipated_numerical"][-1] - before["dissipated_numerical"][-1]) / energy, before["energy_kinetic"][-1] / energy, 1e-6)
check("at rest: supports that stay and loads that are not there do no work",
      (rest["work_external"][-1] - before["work_external"][-1]) / energy, 0, 1e-9, relative=False)
strained = go_on("strained", loaded, {**BAR, **SCHEMES["newmark"]}, CHANGED, 0.1)
slack = go_on("slack", strained, {**BAR, "ts_type": "static", "ts_dt": 1}, "ts_type", 1, refused=None)
check("at rest, strained before: what the first law misses over the elastic energy that was there",
      -slack["balance_first_law"][-1] * slack["work_external"][-1] / strained["energy_elastic"][-1], 1, 1e-3)
check("at rest: elastic energy", rest["energy_elastic"][-1] / energy, 0, 1e-9, relative=False)

# A body that is thrown once the load stands.
thrown = go_on("thrown", loaded, {**PULLED, "bc_pull_ux": STRAIN * LENGTH, **SCHEMES["newmark"], "ics": "throw",
                                  "ic_throw_on": "solid", "ic_throw_vx": "1e-3*x*(10-x)"},
               "ts_type,ics,ic_throw_on,ic_throw_vx,bc_pull_ux", 0.02)
check("thrown from statics: energy of motion", thrown["energy_kinetic"][0],
      0.5 * RHO * 0.5 * 1e-6 * LENGTH ** 5 / 30, 2e-2)

# Two blocks that are pressed together stay so.
PRESSED = {"mesh": mesh("two_blocks.geo"), "mesh_set_gap": 0, "materials": "lower,upper", "material_lower_E": 1e6,
           "material_lower_nu": 0.3, "material_lower_rho": 1000, "material_upper_like": "lower",
           "bcs": "ground,press", "bc_ground_on": "lower_bottom", "bc_ground_type": "fix", "bc_press_on": "upper_top", "bc_press_ux": 0,
           "contacts": "face", "contact_face_secondary": "upper_bottom", "contact_face_primary": "lower_top",
           "contact_face_method": "gpts", "contact_face_enforce": "penalty"}
for penalty in ("auto", 1e8):  # that of explicit steps would be softer
    by_penalty = {**PRESSED, "contact_face_penalty": penalty}
    pressed = run(f"pressed_{penalty}", {**by_penalty, "bc_press_uy": "0-1e-3*t", **STATIC})
    for scheme in SCHEMES:
        held = go_on(f"held_{scheme}_{penalty}", pressed, {**by_penalty, "bc_press_uy": -1e-3, "ts_type": scheme, "ts_dt": 2e-4,
                                                           **({"contact_face_impact": "none"} if scheme == "newmark" else {})},
                     "ts_type,bc_press_uy,contact_face_impact", 0.02)
        check(f"pressed by a penalty ({penalty}), then {scheme}: energy of motion, relative",
              held["energy_kinetic"].max() / pressed["energy_elastic"][-1], 0, 1e-9, relative=False)
        check(f"pressed by a penalty ({penalty}), then {scheme}: pressing force", held["contact_face_force_y"][-1],
              pressed["contact_face_force_y"][-1], 1e-6)
# Multipliers press without its help: steps are as long as of a run that starts explicitly.
by_multipliers = {**PRESSED, "contact_face_enforce": "semismooth"}
pressed = run("pressed_semismooth", {**by_multipliers, "bc_press_uy": "0-1e-3*t", **STATIC})
explicit = {**PRESSED, "bc_press_uy": -1e-3, "ts_type": "central_difference"}
held = go_on("held_semismooth", pressed, explicit, "ts_type,ts_dt,bc_press_uy,contact_face_enforce", 0.02)
afresh = run("afresh", {**explicit, "bc_press_uy": 0, "ts_max_time": 0.02})
check("pressed by multipliers, then central_difference: step", *(numpy.diff(r["time"])[-2] for r in (held, afresh)), 3e-2)
check("pressed by multipliers, then central_difference: pressing force", held["contact_face_force_y"][-1],
      pressed["contact_face_force_y"][-1], 1e-6)

# Let go, they give the energy that the run says beforehand; impulses keep none.
free = {**explicit, "bc_press_type": "traction", "bc_press_uy": 0}
ALLOW = "ts_type,ts_dt,bc_press_type,bc_press_uy,contact_face_enforce"
let_go_of = go_on("free_multipliers", pressed, free, ALLOW, 0.1)
told = re.search(r"contact face presses by multipliers .* gives up to (\S+) of energy", let_go_of.log)
require("pressed by multipliers, let go: the energy is told", told is not None)
check("pressed by multipliers, let go: work of the contact, over what is told", let_go_of["work_contact"][-1] / float(told[1]), 1, 0.05)
by_impulse = go_on("free_impulse", pressed, {**free, "contact_face_enforce": "impulse"}, ALLOW, 0.1)
require("impulses: nothing is told", "presses by multipliers" not in by_impulse.log)
check("impulses: first law, over the elastic energy", by_impulse["balance_first_law"][-1], 0, 1e-3, relative=False)

# Blocks that overlap at the start spring apart in a static step; that of blocks whose gap closes within a step misses some, which no
# scheme after it has.
FIT = {**PRESSED, "contact_face_enforce": "auglag", "contact_face_initial": "allow"}
for name, gap, way in ("pressed by their overlap", -0.01, 0), ("pressed through a gap", 0.01, -0.02):
    fit = run("fit", {**FIT, "mesh_set_gap": gap, "bc_press_uy": way, **STATIC})
    missed = abs(fit["balance_first_law"][-1])
    if gap < 0:
        check(f"{name}: first law of the static step", missed, 0, 1e-3, relative=False)
    else:
        check_between(f"{name}: what the static step misses of the largest energy", missed, 0.01, 1)
    held = go_on("held_fit", fit, {**FIT, "mesh_set_gap": gap, "contact_face_enforce": "penalty", "bc_press_uy": way, "ts_type": "central_difference"},
                 "ts_type,ts_dt,contact_face_enforce", 0.02)
    check(f"{name}, then central_difference: first law", abs(held["balance_first_law"]).max(), 0, 1e-3, relative=False)
    check(f"{name}, then central_difference: pressing force", held["contact_face_force_y"][-1], fit["contact_face_force_y"][-1], 1e-3)

# The default contact too, whose update keeps its force out of the acceleration.
FRICTION = {key: value for key, value in PRESSED.items() if key not in ("contact_face_method", "contact_face_enforce")}
FRICTION |= {"contact_face_friction": 0.3, "bc_press_ux": "1e-4*t"}
pressed = run("rubbed", {**FRICTION, "bc_press_uy": "0-1e-3*t", **STATIC})
still = {**FRICTION, "bc_press_ux": 1e-4, "bc_press_uy": -1e-3}
held = go_on("held", pressed, {**still, "ts_type": "newmark", "ts_dt": 2e-4}, "ts_type,bc_press_ux,bc_press_uy,coupling_snes", 2e-3)
for axis in "xy":
    check(f"pressed by mortar, then newmark: force along {axis} in the first step", held[f"contact_face_force_{axis}"][0],
          pressed[f"contact_face_force_{axis}"][-1], 1e-6)
check("pressed by mortar, then newmark: energy of motion, relative", held["energy_kinetic"].max() / pressed["energy_elastic"][-1], 0, 1e-14,
      relative=False)
other = go_on("other", pressed, {**still, **SCHEMES["central_difference"]}, "ts_type,bc_press_ux,bc_press_uy,coupling_snes", 0.02, code=4)
said = next((line for line in other.log.splitlines() if "cannot use checkpoint" in line), "")
require(f"mortar's checkpoint does not fit explicit steps: names what differs, in {len(said)} letters", "contact_face_multiplier" in said
        and "history" not in said and "_method" in said)

refused = run("refused", {**BAR, **SCHEMES["newmark"], "restart": last_checkpoint(loaded), "ts_max_time": 2}, code=None)
require("another scheme is refused where it is not allowed", refused.code == 2 and "-restart_allow" in refused.log)
finish()
