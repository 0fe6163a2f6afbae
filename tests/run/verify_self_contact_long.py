# labels: long
# timeout: 900
"""Self-contact at length: the folding ring of options/ring.opts in every form and with every enforcement and on 1 to 4
ranks, and in space; notches that are pressed shut; three blocks that fall on each other in space, all their surfaces under one name, against the same pile with a
name for every side."""
import numpy
from _ring import ring
from _runs import check, check_between, finish, mesh, option_file, require, run

CYCLE = {"param_load": 8, "bc_outside_value": "load*stiffness*(t<1?t:t<1.5?2-t:t-1)", "ts_max_time": 2, "ts_dt": 0.02}
reference = ring("reference", CYCLE)
last = reference["contact_inside_force_y"][-1]
for method in ("mortar", "gpts"):
    for enforce in ("semismooth", "auglag", "penalty"):
        r = ring(f"{method}_{enforce}", {**CYCLE, "contact_inside_method": method, "contact_inside_enforce": enforce})
        name = f"{method}, {enforce}"
        # The hinge of the fold is one facet wide: points and nodes share its force differently.
        check(f"{name}: force at the end", abs(r["contact_inside_force_y"][-1]), abs(last),
              0.02 if method == "gpts" else 1e-3)
        check_between(f"{name}: smallest gap", numpy.nanmin(r["contact_inside_gap_min"]),
                      -0.02 if enforce == "penalty" else -1e-3, 1)
triangles = ring("triangles", {**CYCLE, "mesh_set_simplices": 1, "mesh_set_n_around": 250, "mesh_set_n_through": 6})
require("triangles: closed at the end", triangles["contact_inside_active"][-1] > 0)

# In space between walls, hexahedra instead of quadrilaterals: the plane, times the width.
PLANE = {**CYCLE, "contact_inside_multipliers": "standard"}
plane = ring("plane", PLANE)
space = ring("space", {**PLANE, "mesh_set_width": 2, "mesh_set_n_wide": 2, "bcs": "cut,right,outside,faces",
                       "bc_faces_on": "faces", "bc_faces_uz": 0}, ranks=2)
if require("in space: as many steps", len(space["time"]) == len(plane["time"])):
    for column in ("energy_elastic", "contact_inside_force_y", "contact_inside_length"):
        check(f"in space: {column}", abs(abs(space[column]) - 2 * abs(plane[column])).max() / abs(plane[column]).max(), 0,
              1e-7, relative=False)


def same(claim, a, b, columns, tolerance):
    if not require(f"{claim}: as many steps", len(a["time"]) == len(b["time"])):
        return
    worst = (0.0, "")
    for column in columns:
        mine, other = abs(a[column]), abs(b[column])
        scale = max(abs(a[c]).max() for c in columns if c.rsplit("_", 1)[0] == column.rsplit("_", 1)[0])
        worst = max(worst, (abs(mine - other).max() / scale, column))
    check(f"{claim}: largest difference, in {worst[1]}", worst[0], 0, tolerance, relative=False)


for ranks in (2, 3, 4):
    same(f"{ranks} ranks", reference, ring(f"ranks_{ranks}", CYCLE, ranks=ranks),
         ("energy_elastic", "work_external", "contact_inside_force_y", "contact_inside_length"), 1e-8)

# A notch that is pressed shut: all of the block's boundary is one surface.
NOTCH = {"mesh": mesh("notch.geo"), "materials": "block", "material_block_E": 1000, "material_block_nu": 0.3,
         "bcs": "left,right", "bc_left_on": "left", "bc_left_ux": 0, "bc_left_uy": 0, "bc_right_on": "right",
         "bc_right_ux": "-0.25*t", "bc_right_uy": 0, "ts_type": "static", "ts_dt": 0.1, "ts_max_time": 1}
SKIN = {"contacts": "skin", "contact_skin_secondary": "skin", "contact_skin_primary": "skin"}
for wedge in (0, 1):
    force = {}
    # Mortar with a penalty stalls beside the tip of a wedge (theory.md, self-contact), where augmentations cut a step.
    # More points than nodes hold a gap: what all of them cannot hold leaves by a tenth an iteration, the faster the
    # stiffer the penalty, and the solve is repeated with augmentations.
    for method, enforce, refused in (("mortar", "semismooth", 0), ("gpts", "auglag", 0), ("gpts", "semismooth", 4),
                                     ("mortar", "auglag", 2 * wedge)):
        r = run(f"notch_{wedge}_{method}_{enforce}", {**NOTCH, **SKIN, "mesh_set_wedge": wedge, "contact_skin_method": method,
                                                      "contact_skin_enforce": enforce}, refused=refused)
        force[method, enforce] = r["reaction_right_x"][-1]
        check_between(f"notch, wedge {wedge}, {method}, {enforce}: smallest gap over the facet",
                      numpy.nanmin(r["contact_skin_gap_min"]) / 0.08, -1e-3, 1)
        check_between("closed length over the depth", r["contact_skin_length"][-1] / 1.2, 0.7, 1.1)
    for which, value in force.items():
        check(f"notch, wedge {wedge}, {', '.join(which)}: force against mortar, semismooth", value,
              force["mortar", "semismooth"], 1e-3)
# A hair-thin one that closes without sliding leaves the block as if there were none.
whole = run("whole", {**NOTCH, "mesh_set_width": 0})
hair = run("hair", {**NOTCH, **SKIN, "mesh_set_width": 1e-4, "mesh_set_wedge": 1, "contact_skin_method": "mortar"})
check("a closed crack under pressure against none: force", hair["reaction_right_x"][-1], whole["reaction_right_x"][-1], 2e-3)

PILE = {"ts_max_time": 0.3, "output_vis_dt": 1, "motion_snes_rtol": 1e-11, "mesh_set_tilt": 0}
named = run("named", PILE, files=[option_file("pile.opts")])
ONE = {**PILE, "mesh_set_skin": 1, "contacts": "floor,first", "contact_floor_secondary": "skin",
       "contact_first_secondary": "skin", "contact_first_primary": "skin"}
# The file without the contact that has gone.
left = [line for line in open(option_file("pile.opts")) if not line.startswith(("-contact_second", "-contacts"))]
with open("pile_one.opts", "w") as file:
    file.writelines(line.replace("../meshes", option_file("../meshes")) for line in left)
piles = {ranks: run(f"one_{ranks}", ONE, files=["pile_one.opts"], ranks=ranks) for ranks in (1, 2, 3, 4)}
one = piles[1]
MOTION = [c for c in one.history if c.startswith(("energy_kinetic", "energy_elastic", "momentum"))]
for column in ("energy_kinetic", "energy_elastic", "momentum_rubber_y"):
    check(f"all surfaces under one name against every side by its name: {column}",
          abs(one[column] - named[column]).max() / abs(named[column]).max(), 0, 1e-8, relative=False)
check_between("one name: smallest gap", numpy.nanmin(one["contact_first_gap_min"]), -1e-9, 1)
check_between("one name: tries of a step", one["tries"].max(), 1, 1)
# What changes the momentum is the weight and the floor.
for axis in "xz":
    change = one[f"momentum_rubber_{axis}"] - one[f"impulse_floor_{axis}"]
    check(f"momentum of the pile along {axis}", abs(change - change[0]).max() / abs(one["momentum_rubber_y"]).max(), 0,
          1e-9, relative=False)
for ranks in (2, 3, 4):
    same(f"one name, {ranks} ranks", one, piles[ranks], MOTION, 1e-8)
finish()
